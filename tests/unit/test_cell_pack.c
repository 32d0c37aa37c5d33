/* Packings in cells without a piston, and under gravity: they are at rest at their pressure or stress; and what cannot
 * be is refused. */
#include "test.h"

#include "base/base.h"
#include "packing/contact.h"

static sp_pack_spec small(int dim, sp_cell cell, double friction) {
    sp_pack_spec s = sp_pack_spec_default();
    s.dim = dim;
    s.cell = cell;
    s.grains = dim == 2 ? 80 : 160;
    s.friction = friction;
    s.seed = 5;
    return s;
}

static sp_packing make(const sp_pack_spec *s, const sp_packing *from) {
    sp_packing p = sp_packing_none();
    sp_audit audit;
    char reason[200];
    const sp_pack_hooks hooks = {.from = from};
    assert_ok(sp_packing_make_with(s, &hooks, &p, &err));
    assert_ok(sp_packing_check(&p, &err));
    assert_ok(sp_packing_audit(&p, 1e-4, &audit, &err));
    if (!(sp_audit_worst(&audit, 1e-5, reason, sizeof reason) < 1e-5))
        fail_msg("%s", reason);
    return p;
}

/* Stress from the contacts alone: xx yy zz yz xz xy. */
static void stress_of(const sp_packing *p, double stress[6]) {
    static const int row[6] = {0, 1, 2, 1, 0, 0}, column[6] = {0, 1, 2, 2, 2, 1};
    memset(stress, 0, 6 * sizeof *stress);
    for (int32_t c = 0; c < p->n_contacts; c++) {
        const sp_contact *k = &p->contacts[c];
        const double length = p->r[k->i] - k->overlap + (k->j >= 0 ? p->r[k->j] : 0);
        for (int m = 0; m < 6; m++) { /* of both orders, as friction is not along the branch */
            const int a = row[m], b = column[m];
            const double one = k->fn * k->n[a] * k->n[b] - k->ft[a] * k->n[b];
            const double two = k->fn * k->n[a] * k->n[b] - k->ft[b] * k->n[a];
            stress[m] += 0.5 * (one + two) * length / sp_packing_volume(p);
        }
    }
}

/* The mean pressure of cells that keep their shape, at high and low pressure, with and without friction. */
TEST(test_pressure) {
    for (int k = 0; k < 8; k += SANITIZED_STEP(3)) {
        sp_pack_spec s = small(2 + k % 2, k < 4 ? SP_CELL_PERIODIC : SP_CELL_BOX, k / 2 % 2 ? 0.5 : 0);
        s.pressure = k % 4 == 0 ? 1e-5 : 1e-4;
        FREED(sp_packing) p = make(&s, NULL);
        double stress[6];
        stress_of(&p, stress);
        assert_int_equal(p.cell, s.cell);
        assert_relative((stress[0] + stress[1] + stress[2]) / s.dim, s.pressure, 2e-6);
        assert_relative(p.box[s.dim - 1], p.box[0], 0.05); /* equal edges */
        assert_true(p.tilt[0] == 0 && p.tilt[1] == 0 && p.tilt[2] == 0);
    }
}

/* A faster strain saves steps where elastic waves slow the cell down, at small pressures, and ends at the same stress.
 */
TEST(test_strain_rate) {
    SKIP_SANITIZED();
    int64_t steps[3];
    for (int k = 0; k < 3; k++) {
        sp_pack_spec s = small(2, SP_CELL_PERIODIC, 0.5);
        s.pressure = 1e-7;
        s.strain_rate = k == 0 ? 0 : k == 1 ? 0.1 : 1e-3;
        FREED(sp_packing) p = make(&s, NULL);
        double stress[6];
        stress_of(&p, stress);
        steps[k] = p.steps;
        assert_relative((stress[0] + stress[1]) / 2, s.pressure, 2e-6);
    }
    assert_true(steps[1] < steps[2] && steps[2] < steps[0]);
}

/* Forces by other powers of the overlap, with friction. */
TEST(test_laws) {
    static const double exponents[] = {1, 1.25, 2, 3};
    for (int k = 0; k < 8; k += SANITIZED_STEP(5)) {
        const double a = exponents[k / 2], eta = contact_eta(0.3);
        sp_pack_spec s = small(2 + k % 2, SP_CELL_PERIODIC, 0.4);
        double stress[6], sheared = 0;
        s.law_exponent = a;
        s.poisson = 0.3;
        s.pressure = 1e-3;
        FREED(sp_packing) p = make(&s, NULL);
        stress_of(&p, stress);
        assert_relative((stress[0] + stress[1] + stress[2]) / s.dim, s.pressure, 2e-6);
        for (int32_t c = 0; c < p.n_contacts; c++) {
            const sp_contact *t = &p.contacts[c];
            const double r = p.r[t->i] * p.r[t->j] / (p.r[t->i] + p.r[t->j]);
            assert_relative(t->fn, 2.0 / 3 * pow(r, 2 - a) * pow(t->overlap, a), 1e-12);
            assert_relative(t->kn, a * t->fn / t->overlap, 1e-12);
            assert_relative(t->kt, eta * t->kn, 1e-12);
            sheared += sqrt(t->ft[0] * t->ft[0] + t->ft[1] * t->ft[1] + t->ft[2] * t->ft[2]);
        }
        assert_true(sheared > 0.02 * p.n_contacts * s.pressure);
    }
}

/* Every component that the cell controls; with shear stress the cell is tilted. */
TEST(test_stress) {
    static const double plane[] = {1e-4, 1.2e-4, 1e-5}, flat[] = {1e-4, 1.2e-4, 0},
                        space[] = {1e-4, 1.2e-4, 1.1e-4, -5e-6, 1e-5, 5e-6};
    for (int k = 0; k < 3; k++) {
        sp_pack_spec s = small(k == 1 ? 3 : 2, k == 2 ? SP_CELL_BOX : SP_CELL_PERIODIC, 0.5);
        const double *target = k == 0 ? plane : k == 1 ? space : flat;
        s.stress = target;
        s.stress_count = k == 1 ? 6 : 3;
        FREED(sp_packing) p = make(&s, NULL);
        double stress[6];
        stress_of(&p, stress);
        const double mean = k == 1 ? 1.1e-4 : 1.1e-4;
        assert_relative(p.pressure, mean, 1e-12);
        for (int c = 0; c < s.stress_count; c++)
            if (k < 2 || c < 2)
                assert_close(stress[s.dim == 2 && c == 2 ? 5 : c], target[c], 3e-6 * mean);
        assert_true((p.tilt[0] != 0) == (k < 2));
    }
}

/* A packing from a file goes on from its own contacts: at its own pressure nothing moves, and a history passes through
 * other ones. */
TEST(test_file) {
    static const double history[] = {1e-3};
    for (int k = 0; k < 4; k += SANITIZED_STEP(4)) {
        sp_pack_spec s = small(2 + k % 2, k < 2 ? SP_CELL_PERIODIC : SP_CELL_BOX, 0.5);
        FREED(sp_packing) first = make(&s, NULL);
        sp_pack_spec again = sp_pack_spec_default();
        again.kind = SP_PACK_FILE;
        again.friction = s.friction;
        FREED(sp_packing) same = make(&again, &first);
        assert_int_equal(same.cell, s.cell);
        sp_audit before, after; /* a rattler may or may not touch its cage */
        assert_ok(sp_packing_audit(&first, 1e-4, &before, &err));
        assert_ok(sp_packing_audit(&same, 1e-4, &after, &err));
        assert_int_equal(after.carrying, before.carrying);
        for (int a = 0; a < s.dim; a++)
            assert_relative(same.box[a], first.box[a], 1e-7);
        again.history = history;
        again.history_count = 1;
        again.pressure = 2e-4;
        FREED(sp_packing) other = make(&again, &first);
        assert_true(other.box[0] < first.box[0]);
        assert_relative(other.pressure, 2e-4, 1e-12);
    }
}

/* The kernel and the plain path make different packings, but the same mean density and coordination. */
TEST(test_reference) {
    double height[2];
    for (int plain = 0; plain < 2; plain++) {
        sp_pack_spec s = small(2, SP_CELL_PERIODIC, 0);
        s.pressure = 1e-3;
        s.tolerance = 1e-8;
        s.reference = plain;
        FREED(sp_packing) p = make(&s, NULL);
        height[plain] = sp_packing_height(&p);
    }
    assert_relative(height[1], height[0], 0.02);
}

/* The bottom carries the piston and the weight, and the pressure grows with the depth. */
TEST(test_gravity) {
    for (int dim = 2; dim <= 3; dim++) {
        sp_pack_spec s = small(dim, SP_CELL_PISTON, 0.5);
        s.width = 6;
        s.gravity = 3e-5;
        FREED(sp_packing) p = make(&s, NULL);
        double walls[2] = {0, 0}, weight = 0;
        for (int32_t c = 0; c < p.n_contacts; c++)
            if (p.contacts[c].j < 0)
                walls[-1 - p.contacts[c].j] += p.contacts[c].fn;
        for (int32_t i = 0; i < p.n; i++)
            weight += s.gravity * grain_mass(p.r[i]);
        assert_true(weight > 0.5 * s.pressure * sp_packing_wall_area(&p));
        assert_relative(walls[1], s.pressure * sp_packing_wall_area(&p), 1e-5);
        assert_relative(walls[0] - walls[1], weight, 1e-5);
        assert_true(p.gravity == s.gravity);
    }
}

/* ---- what cannot be ------------------------------------------------------------------------------------------ */

static void assert_refuses(const sp_pack_spec *s, sp_status expected, const char *key) {
    sp_packing p = sp_packing_none();
    sp_error why = {0};
    const sp_status status = sp_packing_make(s, NULL, NULL, &p, &why);
    if (status != expected || strcmp(why.key, key) != 0)
        fail_msg("%s, key \"%s\": %s", sp_status_name(status), why.key, why.text);
}

TEST(test_bad_stress) {
    static const double wrong[][3] = {{1e-4, 1e-4, 1.1e-4}, {-1e-4, 1e-4, 0}, {1e-4, 0, 0}};
    sp_pack_spec s = small(2, SP_CELL_PERIODIC, 0.5);
    s.stress_count = 3;
    for (int k = 0; k < 3; k++) {
        s.stress = wrong[k];
        assert_refuses(&s, SP_EINVAL, "packing.stress");
    }
    static const double sheared[] = {1e-4, 1e-4, 1e-5}, strong[] = {1e-4, 1e-4, 7e-5};
    s.stress = sheared;
    s.stress_count = 2;
    assert_refuses(&s, SP_EINVAL, "packing.stress");
    s.stress_count = 3;
    s.pressure = 2e-4;
    assert_refuses(&s, SP_EINVAL, "packing.pressure");
    s.pressure = sp_pack_spec_default().pressure;
    s.cell = SP_CELL_BOX;
    assert_refuses(&s, SP_EINVAL, "packing.stress");
    s.cell = SP_CELL_PISTON;
    assert_refuses(&s, SP_EINVAL, "packing.stress");
    s.cell = SP_CELL_PERIODIC;
    s.stress = strong; /* more than grains without friction carry */
    s.friction = 0;
    assert_refuses(&s, SP_EFAILED, "packing.stress");
}

TEST(test_bad_cells) {
    sp_pack_spec s = small(2, SP_CELL_PERIODIC, 0.5);
    s.grains = 20;
    assert_refuses(&s, SP_EINVAL, "packing.grains");
    s.grains = 80;
    s.width = 4;
    assert_refuses(&s, SP_EINVAL, "packing.width");
    s = small(2, SP_CELL_BOX, 0.5);
    s.gravity = 1e-5;
    assert_refuses(&s, SP_EINVAL, "packing.gravity");
    s.gravity = 0;
    s.compression = SP_COMPRESSION_ISOTROPIC;
    assert_refuses(&s, SP_EINVAL, "packing.compression");
    s.compression = SP_COMPRESSION_PISTON;
    s.kind = SP_PACK_TRIANGULAR;
    assert_refuses(&s, SP_EINVAL, "packing.cell");
    s.kind = SP_PACK_PISTON;
    s.dim = 1;
    assert_refuses(&s, SP_EINVAL, "packing.dimension");
    s = small(2, SP_CELL_PISTON, 0.5);
    s.strain_rate = 0.01;
    assert_refuses(&s, SP_EINVAL, "packing.strain_rate");
}

/* Grains that their own weight pushes through each other: the reason is the gravity, not the pressure. */
TEST(test_huge_gravity) {
    sp_pack_spec s = small(2, SP_CELL_PISTON, 0.5);
    s.width = 6;
    s.gravity = 1e-2;
    assert_refuses(&s, SP_EFAILED, "packing.gravity");
}

RUN_TESTS(NULL, NULL)
