/* Paths of strain: their stages, the stress along them against the moduli of the packing, and closed ones. */
#include "test.h"

#include "base/base.h"
#include "packing/prepare.h"

#include <math.h>
#include <sonopack/elastic.h>
#include <sonopack/packing.h>
#include <string.h>

enum { MOST = 16 };

/* What is kept of each stage. */
typedef struct path {
    int32_t count;
    double pressure[MOST], stress[MOST][6], *first; /* stresses xx yy zz yz xz xy; places at stage 0 */
    double c[SP_STRAINS_MAX][SP_STRAINS_MAX];       /* stiffness at stage 0 */
    double apart[MOST];                             /* largest distance of a grain from its place at stage 0 */
} path;

static void find_stress(const sp_packing *p, double stress[6]) {
    sp_statics s;
    assert_ok(sp_statics_make(p, 1e-8, 0, &s, &err));
    const double all[6] = {s.s_xx, s.s_yy, s.s_zz, s.s_yz, s.s_xz, s.s_xy};
    memcpy(stress, all, sizeof all);
}

/* With prestress: the second derivative of the energy, or of the work. */
static void find_stiffness(const sp_packing *p, path *to) {
    sp_network_options o = sp_network_options_default();
    FREED(sp_network) net;
    sp_elasticity e;
    o.prestress = true;
    o.threshold = 1e-8;
    assert_ok(sp_network_make(p, &o, &net, &err));
    assert_ok(sp_elasticity_make(&net, 1, NULL, &e, &err));
    memcpy(to->c, e.c, sizeof e.c);
}

static sp_status keep(const sp_packing *p, int32_t index, void *user, sp_error *e) {
    path *to = user;
    (void)e;
    assert_int_equal(index, to->count);
    to->pressure[to->count] = p->pressure;
    find_stress(p, to->stress[to->count]);
    if (index == 0) {
        find_stiffness(p, to);
        to->first = sp_alloc(3 * (size_t)p->n, sizeof *to->first);
        memcpy(to->first, p->x, 3 * (size_t)p->n * sizeof *p->x);
    }
    for (int32_t k = 0; k < 3 * p->n; k++)
        to->apart[index] = fmax(to->apart[index], fabs(p->x[k] - to->first[k]));
    to->count++;
    return SP_OK;
}

static sp_pack_spec spec_of(int dim, bool rough) {
    sp_pack_spec s = sp_pack_spec_default();
    s.kind = rough ? SP_PACK_PISTON : SP_PACK_MINIMUM;
    s.cell = SP_CELL_PERIODIC;
    s.dim = dim;
    s.grains = dim == 2 ? 100 : 150;
    s.friction = rough ? 20 : 0; /* so that nothing slides */
    s.pressure = 1e-3;
    s.tolerance = rough ? 1e-10 : 0;
    s.law_exponent = rough == (dim == 2) ? 1 : 1.5;
    s.seed = 4;
    return s;
}

static path run(const sp_pack_spec *s) {
    path to = {0};
    const sp_pack_hooks hooks = {.user = &to, .stage = keep};
    FREED(sp_packing) p = sp_packing_none();
    assert_ok(sp_packing_make_with(s, &hooks, &p, &err));
    assert_ok(keep(&p, to.count, &to, &err));
    assert_int_equal(to.count, sp_pack_stages(s));
    sp_free(to.first);
    return to;
}

/* Small strains raise the stress by the modulus. Of a uniaxial strain and of simple shear the change of Cauchy's stress
 * of the same name is that of the first Piola-Kirchhoff stress, the derivative of the energy. What is left is the
 * curvature, which grows with the strain: 0.3% at 1e-5. */
TEST(small_strains) {
    for (int k = 0; k < 4; k++)
        for (int axis = 0; axis < 2; axis++) {
            const int dim = 2 + k % 2, c = axis ? 5 : 1;
            const double e = 1e-5;
            double strain[6] = {0};
            sp_pack_spec s = spec_of(dim, k > 1);
            strain[axis ? (dim == 2 ? 2 : 5) : 1] = e;
            s.strain = strain;
            s.strain_count = dim == 2 ? 3 : 6;
            s.strain_steps = 1;
            const path to = run(&s);
            const int at = axis ? (dim == 2 ? 2 : 5) : 1;
            const double rise = (to.stress[1][c] - to.stress[0][c]) / e;
            if (fabs(rise / to.c[at][at] - 1) > 3e-3)
                print_message("dim %d rough %d axis %d: %g, modulus %g\n", dim, k > 1, axis, rise, to.c[at][at]);
            assert_close(rise, to.c[at][at], 3e-3 * to.c[at][at]);
        }
}

/* Components that are free hold their stress; the path goes where its turns say. */
TEST(lateral_stress) {
    static const double strain[] = {0, 0.02, 0}, turns[] = {1, 0, 0.25}, stress[] = {1e-3, 1.2e-3, 2e-5};
    static const double at[] = {0, 0.5, 1, 0.5, 0, 0.25};
    for (int rough = 0; rough < 2; rough++) {
        sp_pack_spec s = spec_of(2, rough);
        s.friction = rough ? 0.5 : 0;
        s.strain = strain;
        s.turns = turns;
        s.strain_count = s.turn_count = 3;
        s.strain_steps = 2;
        s.lateral = SP_LATERAL_STRESS;
        s.pressure = sp_pack_spec_default().pressure;
        s.stress = stress;
        s.stress_count = 3;
        const path to = run(&s);
        s = sp_pack_spec_resolve(&s);
        assert_int_equal(to.count, 6);
        for (int k = 0; k < to.count; k++) {
            assert_close(sp_pack_stage_strain(&s, k), 0.02 * at[k], 1e-15);
            assert_close(to.stress[k][0], 1e-3, 1e-9);
            assert_close(to.stress[k][5], 2e-5, 1e-9);
            assert_close(to.pressure[k], 0.5 * (to.stress[k][0] + to.stress[k][1]), 1e-9);
        }
        assert_close(to.stress[0][1], 1.2e-3, 1e-9);
        assert_true(!rough || (to.stress[2][1] > 1.3e-3 && to.stress[4][1] < 1.1e-3)); /* smooth ones hardly differ */
    }
}

/* Without friction a short closed path leads back to its minimum, up to the tolerance over the smallest stiffness. */
TEST(closed_paths) {
    static const double turns[] = {1, 0};
    for (int dim = 2; dim <= 3; dim += SANITIZED_STEP(2)) {
        const double strain[6] = {0, 1e-5, 1e-5, 0, 1e-5, 1e-5};
        sp_pack_spec s = spec_of(dim, false);
        s.strain = strain;
        s.turns = turns;
        s.turn_count = 2;
        s.strain_count = dim == 2 ? 3 : 6;
        s.strain_steps = 2;
        const path to = run(&s);
        assert_true(to.apart[2] > 1e-6);
        assert_true(to.apart[4] < 1e-2 * to.apart[2]);
        assert_close(to.pressure[4], to.pressure[0], 1e-7 * to.pressure[0]);
    }
}

/* Far shear tilts the cell past half of its edge; the packings stay packings, and a path ends where it falls apart. */
TEST(far_paths) {
    static const double shear[] = {0, 0, 0.8}, pull[] = {-0.2, -0.2, 0};
    sp_pack_spec s = spec_of(2, false);
    sp_packing p;
    sp_audit audit;
    s.strain = shear;
    s.strain_count = 3;
    s.strain_steps = 40;
    assert_ok(sp_packing_make(&s, NULL, NULL, &p, &err));
    assert_true(fabs(p.tilt[0]) <= 0.5 * p.box[0]);
    assert_ok(sp_packing_check(&p, &err));
    assert_ok(sp_packing_audit(&p, 1e-4, &audit, &err));
    assert_true(audit.force_residual < 1e-6 && audit.geometry_residual < 1e-10 && audit.missing == 0);
    sp_packing_free(&p);
    for (int rough = 0; rough < 2; rough += SANITIZED_STEP(2)) {
        s = spec_of(2, rough);
        s.strain = pull;
        s.strain_count = 3;
        assert_fails(sp_packing_make(&s, NULL, NULL, &p, &err), SP_EFAILED, "packing.path.strain");
    }
}

TEST(refusals) {
    static const double strain[6] = {0, 0.05, 0, 0, 0, 0.01}, none[6] = {0};
    const sp_pack_spec good = {.strain = strain, .strain_count = 3};
    for (int k = 0; k < 8; k++) {
        sp_pack_spec s = spec_of(2, k % 2);
        const char *key = "packing.path.strain";
        s.strain = good.strain;
        s.strain_count = k == 0 ? 6 : 3;
        switch (k) {
        case 0: break;
        case 1: s.cell = SP_CELL_PISTON; break;
        case 2: s.strain = none; break;
        case 3: s.cell = SP_CELL_BOX, s.strain = strain + 3; break;
        case 4: s.strain_count = 0, s.lateral = SP_LATERAL_STRESS; break;
        case 5: s.strain_steps = 1, key = "packing.path.steps"; break;
        case 6:
            s.fraction = 0.9, s.pressure = sp_pack_spec_default().pressure, s.lateral = SP_LATERAL_STRESS;
            key = "packing.path.lateral";
            break;
        default: s.stages = 60, key = "packing.stages";
        }
        assert_fails(sp_pack_spec_check(&s, &err), SP_EINVAL, key);
    }
}

RUN_TESTS(NULL, NULL)
