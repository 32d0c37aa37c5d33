/* Packings that are compressed further: from a packing, through a history of pressures, with sides that yield, and from
 * a lattice that is not perfect. */
#include "making.h"

#include "base/base.h"
#include "packing/prepare.h"

#include <sonopack/study/scene.h>

static sp_pack_spec small(int dim, int32_t grains, double width, double pressure) {
    sp_pack_spec s = sp_pack_spec_default();
    s.dim = dim;
    s.grains = grains;
    s.width = width;
    s.pressure = pressure;
    s.tolerance = 1e-6 * pressure;
    s.seed = 5;
    s.protocol = SP_PROTOCOL_QUICK;
    return s;
}

static sp_packing make_from(const sp_packing *from, double pressure, double tolerance) {
    sp_pack_spec s = sp_pack_spec_default();
    s.kind = SP_PACK_FILE;
    s.pressure = pressure;
    s.tolerance = tolerance;
    s.friction = from->friction;
    const sp_pack_hooks hooks = {.from = from};
    sp_packing p = sp_packing_none();
    assert_ok(sp_packing_make_with(&s, &hooks, &p, &err));
    return p;
}

/* tolerance: of accelerations; the lightest grain of the default sizes has a mass of 0.27, the heaviest 0.9. */
static sp_audit audited(const sp_packing *p, double tolerance) {
    sp_audit a;
    assert_ok(sp_packing_check(p, &err));
    assert_ok(sp_packing_audit(p, 1e-4, &a, &err));
    print_message(
        "p %.3g: height %.8g, %d carry, %d rattle, force %.2g, torque %.2g, wall %.2g, geometry %.2g, Coulomb "
        "%.2g, %d missing, %lld steps\n",
        p->pressure, sp_packing_height(p), a.carrying, a.rattlers, a.force_residual, a.torque_residual, a.wall_residual,
        a.geometry_residual, a.coulomb_excess, a.missing, (long long)p->steps);
    assert_true(a.force_residual < 2 * tolerance / p->pressure);
    assert_true(a.torque_residual < 2 * tolerance / p->pressure);
    assert_true(a.wall_residual < 20 * tolerance / p->pressure);
    assert_true(a.geometry_residual < 1e-9);
    assert_true(a.coulomb_excess < 1e-12);
    assert_int_equal(a.missing, 0);
    return a;
}

static double mean_x(const sp_packing *p, int axis) {
    double sum = 0;
    for (int32_t i = 0; i < p->n; i++)
        sum += p->x[3 * (size_t)i + (size_t)axis];
    return sum / p->n;
}

/* Ten times less pressure, and back: less height than at first, as sliding is not undone. */
TEST(a_cycle_of_pressure) {
    for (int dim = 2; dim <= 3; dim++) {
        const sp_pack_spec s = dim == 2 ? small(2, 80, 8, 1e-4) : small(3, 90, 5, 1e-4);
        FREED(sp_packing) first = make_packing(&s), low = make_from(&first, 1e-5, 1e-11),
                          again = make_from(&low, 1e-4, 1e-10);
        const sp_audit a = audited(&first, 1e-10), b = audited(&low, 1e-11), c = audited(&again, 1e-10);
        assert_true(b.carrying < a.carrying);
        assert_true(c.carrying > b.carrying);
        const double h = sp_packing_height(&first);
        assert_true(sp_packing_height(&low) > h * 1.001);
        assert_true(fabs(sp_packing_height(&again) / h - 1) < (sp_packing_height(&low) / h - 1));
        assert_true(fabs(mean_x(&low, dim - 1) / sp_packing_height(&low) - mean_x(&first, dim - 1) / h) < 0.01);
        assert_true(low.box[0] == first.box[0]);
    }
}

TEST(the_same_pressure_again) {
    for (int dim = 2; dim <= 3; dim++) {
        const sp_pack_spec s = dim == 2 ? small(2, 80, 8, 1e-4) : small(3, 90, 5, 1e-4);
        FREED(sp_packing) first = make_packing(&s), again = make_from(&first, 1e-4, 1e-10);
        const double change = sp_packing_height(&again) / sp_packing_height(&first) - 1;
        double worst = 0;
        assert_int_equal(again.n_contacts, first.n_contacts);
        for (int32_t c = 0; c < first.n_contacts; c++) {
            const sp_contact *k = &first.contacts[c], *l = &again.contacts[c];
            assert_true(k->i == l->i && k->j == l->j);
            for (int a = 0; a < 3; a++)
                worst = fmax(worst, fabs(k->ft[a] - l->ft[a]));
        }
        print_message("%d dimensions: height %.2g, tangential forces %.2g p d^2, %lld steps\n", dim, change,
                      worst / s.pressure, (long long)again.steps);
        assert_true(fabs(change) < 1e-6);
        assert_true(worst < 1e-4 * s.pressure);
    }
}

typedef struct stages {
    int count;
    sp_packing last;
} stages;

static sp_status keep_stage(const sp_packing *p, int32_t index, void *user, sp_error *err) {
    stages *s = user;
    (void)err;
    assert_int_equal(index, s->count);
    static const double pressures[] = {1e-4, 2e-5, 5e-4};
    assert_true(p->pressure == pressures[index]);
    const double tolerances[] = {1e-10, 2e-11, 1e-10};
    audited(p, tolerances[index]);
    s->count++;
    return SP_OK;
}

static sp_status refuse_stage(const sp_packing *p, int32_t index, void *user, sp_error *err) {
    (void)p;
    (void)user;
    return sp_fail(err, SP_EIO, "stage %d has no place", index);
}

TEST(a_history_in_one_making) {
    static const double history[] = {1e-4, 2e-5, 5e-4};
    sp_pack_spec s = small(2, 80, 8, 1e-4);
    s.history = history;
    s.history_count = 3;
    stages seen = {0};
    sp_pack_hooks hooks = {.stage = keep_stage, .user = &seen};
    FREED(sp_packing) p = sp_packing_none(), q = sp_packing_none();
    assert_ok(sp_packing_make_with(&s, &hooks, &p, &err));
    assert_int_equal(seen.count, 3);
    assert_true(p.pressure == 1e-4);
    audited(&p, 1e-10);
    hooks.stage = refuse_stage;
    assert_fails(sp_packing_make_with(&s, &hooks, &q, &err), SP_EIO, "0");
    s.history_count = 0;
    q = make_packing(&s); /* the same grains, but no history */
    assert_true(memcmp(p.r, q.r, (size_t)p.n * sizeof *p.r) == 0);
    assert_true(sp_packing_height(&p) < sp_packing_height(&q));
}

TEST(sides_that_yield) {
    const double pressures[] = {1e-3, 1e-5, 1e-8};
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 3; k += SANITIZED_STEP(2)) {
            if (dim == 3 && k != 1)
                continue;
            sp_pack_spec s = dim == 2 ? small(2, 80, 8, pressures[k]) : small(3, 90, 5, pressures[k]);
            s.tolerance = 1e-5 * s.pressure;
            s.compression = SP_COMPRESSION_ISOTROPIC;
            FREED(sp_packing) p = make_packing(&s);
            audited(&p, s.tolerance);
            sp_statics t;
            assert_ok(sp_statics_make(&p, 1e-4, 1, &t, &err));
            print_message("p %g: width %.6g of %g, stress ratio - 1: %.2g\n", s.pressure, p.box[0], s.width,
                          t.s1_over_s2 - 1);
            assert_true(fabs(t.s1_over_s2 - 1) < 2e-3); /* contacts below the threshold are left out there */
            assert_true(p.box[0] < s.width);
        }
}

/* P* = 3 p/alpha^1.5, alpha the width of the diameters' distribution. */
static double closed_part(double alpha, double reduced) {
    sp_pack_spec s = small(2, 96, 8, reduced * pow(alpha, 1.5) / 3);
    s.kind = SP_PACK_TRIANGULAR;
    s.diameter_min = 1 - 0.5 * alpha;
    s.diameter_max = 1 + 0.5 * alpha;
    s.tolerance = 1e-5 * s.pressure;
    FREED(sp_packing) p = make_packing(&s);
    const sp_audit a = audited(&p, s.tolerance);
    const double part = a.carrying / (3.0 * p.n);
    print_message("P* = %g, alpha %g: %.4f of the lattice's contacts, width %.6g\n", reduced, alpha, part, p.box[0]);
    return part;
}

TEST(a_lattice_of_unequal_grains) {
    assert_true(closed_part(1e-3, 30) > 0.99);
    assert_true(closed_part(0.02, 0.01) < 0.8);
    assert_true(closed_part(1e-3, 0.01) < 0.8);
}

TEST(what_is_refused) {
    sp_pack_spec s = sp_pack_spec_default(), c = sp_pack_spec_default();
    sp_packing p = sp_packing_none(), chain, lattice;
    sp_pack_hooks hooks = {0};
    s.kind = SP_PACK_FILE;
    assert_fails(sp_packing_make_with(&s, &hooks, &p, &err), SP_EINVAL, "packing.file");
    c.kind = SP_PACK_CHAIN;
    c.dim = 1;
    c.grains = 20;
    chain = make_packing(&c);
    c.kind = SP_PACK_TRIANGULAR;
    c.dim = 2;
    c.width = 10;
    c.grains = 100;
    lattice = make_packing(&c);
    hooks.from = &chain;
    assert_fails(sp_packing_make_with(&s, &hooks, &p, &err), SP_EINVAL, "chain");
    hooks.from = &lattice;
    s.grains = 99;
    assert_fails(sp_packing_make_with(&s, &hooks, &p, &err), SP_EINVAL, "packing.grains 99");
    s.grains = 100;
    s.width = 10;
    assert_fails(sp_packing_make_with(&s, &hooks, &p, &err), SP_EINVAL, "packing.width 10");
    s.width = lattice.box[0];
    s.diameter_max = 1.2;
    assert_fails(sp_packing_make_with(&s, &hooks, &p, &err), SP_EINVAL, "packing.diameter_max 1.2");
    s.diameter_max = 1;
    s.content = sp_packing_hash(&lattice) + 1;
    assert_fails(sp_packing_make_with(&s, &hooks, &p, &err), SP_EINVAL, "packing.content");
    lattice.wall = SP_WALL_GRAIN;
    assert_fails(sp_packing_make_with(&s, &hooks, &p, &err), SP_EINVAL, "packing.file");
    c.history = &c.pressure;
    c.history_count = 1;
    assert_fails(sp_packing_make(&c, NULL, NULL, &p, &err), SP_EINVAL, "packing.history");
    c = sp_pack_spec_default();
    static const double wrong[] = {1e-4, 1};
    c.history = wrong;
    c.history_count = 2;
    assert_fails(sp_packing_make(&c, NULL, NULL, &p, &err), SP_EINVAL, "packing.history 2 1");
    sp_packing_free(&lattice);
    sp_packing_free(&chain);
}

TEST(what_a_scene_says_of_it) {
    static const char text[] = "packing = { kind = \"file\"; file = \"a \\\"b\\\\.h5\"; content = 7; pressure = 1e-5;\n"
                               "history = [1e-3, 1e-6]; compression = \"isotropic\"; };\n";
    sp_scene s = sp_scene_default(), back = sp_scene_default();
    assert_ok(sp_scene_parse(text, "in/s.cfg", 0, NULL, &s, &err));
    assert_string_equal(s.from, "in/a \"b\\.h5");
    assert_int_equal(s.pack.history_count, 2);
    assert_true(s.pack.history[0] == 1e-3 && s.pack.history[1] == 1e-6 && s.pack.content == 7);
    char *written = sp_scene_text(&s, NULL);
    assert_non_null(written);
    assert_ok(sp_scene_parse(written, "s.cfg", 0, NULL, &back, &err));
    assert_string_equal(back.from, s.from);
    assert_int_equal(back.pack.history_count, 2);
    assert_memory_equal(back.pack.history, s.pack.history, 2 * sizeof *s.pack.history);
    assert_true(back.pack.kind == SP_PACK_FILE && back.pack.content == 7);
    sp_free(written);
    sp_scene_free(&s);
    sp_scene_free(&back);
    assert_fails(sp_scene_parse("packing = { kind = \"file\"; };", "s.cfg", 0, NULL, &s, &err), SP_EINVAL,
                 "packing.file");
    assert_fails(sp_scene_parse("packing = { file = \"x.h5\"; };", "s.cfg", 0, NULL, &s, &err), SP_EINVAL,
                 "packing.kind");
    assert_fails(sp_scene_parse("packing = { history = [1]; };", "s.cfg", 0, NULL, &s, &err), SP_EINVAL,
                 "packing.history");
    assert_fails(sp_scene_parse("packing = { history = 1e-4; };", "s.cfg", 0, NULL, &s, &err), SP_EINVAL,
                 "s.cfg:1 packing.history 0.0001");
}

RUN_TESTS(NULL, NULL)
