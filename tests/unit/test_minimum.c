/* Packings at a minimum of the energy: balanced, stable, of the law, pressure and fraction that are asked for. */
#include "test.h"

#include "base/base.h"

#include <math.h>
#include <sonopack/modes.h>
#include <sonopack/packing.h>
#include <string.h>

static sp_pack_spec spec_of(int dim, double exponent) {
    sp_pack_spec s = sp_pack_spec_default();
    s.kind = SP_PACK_MINIMUM;
    s.cell = SP_CELL_PERIODIC;
    s.dim = dim;
    s.grains = dim == 2 ? 120 : 200;
    s.friction = 0;
    s.sizes = SP_SIZES_BIDISPERSE;
    s.diameter_min = 5.0 / 6;
    s.diameter_max = 7.0 / 6;
    s.pressure = 1e-3;
    s.law_exponent = exponent;
    s.seed = 5;
    return s;
}

/* F = 4/3 E12 R12^(2 - a) n^a, by pow. */
static double law(double a, double ri, double rj, double n) {
    const double r = ri * rj / (ri + rj);
    return 4.0 / 3.0 * 0.5 * pow(r, 2 - a) * pow(n, a);
}

/* Forces and stiffnesses are those of the law at the overlaps of the positions; the stiffness is the slope of the
 * force, whose error by differences falls with the square of their width. */
static void check_law(const sp_packing *p, double a) {
    sp_audit audit;
    assert_ok(sp_packing_audit(p, 1e-4, &audit, &err));
    assert_true(audit.force_residual < 1e-6 && audit.geometry_residual < 1e-12 && audit.missing == 0);
    assert_true(audit.wall_residual < 1e-12);
    for (int32_t k = 0; k < p->n_contacts; k++) {
        const sp_contact *c = &p->contacts[k];
        const double ri = p->r[c->i], rj = p->r[c->j], n = c->overlap, kn = c->kn;
        assert_close(c->fn, law(a, ri, rj, n), 1e-13 * c->fn);
        assert_true((kn == 0) == (a == 1.5));
        for (double h = 1e-2; kn > 0 && h > 1e-3; h /= 2) {
            const double slope = (law(a, ri, rj, n * (1 + h)) - law(a, ri, rj, n * (1 - h))) / (2 * h * n);
            assert_close(slope, kn, (a * h * h + 1e-12) * kn);
        }
    }
}

static void check_stable(const sp_packing *p) {
    sp_network_options o = sp_network_options_default();
    FREED(sp_network) net;
    sp_stability s;
    o.prestress = true;
    assert_ok(sp_network_make(p, &o, &net, &err));
    assert_ok(sp_stability_make(p, &net, &s, &err));
    assert_int_equal(s.verdict, SP_MODES_STABLE);
    assert_int_equal(s.zero, p->dim); /* the packing as a whole */
}

TEST(test_laws) {
    static const double exponents[] = {1, 1.5, 2, 2.3, 3};
    for (int dim = 2; dim <= 3; dim++)
        for (size_t k = 0; k < sizeof exponents / sizeof *exponents; k += SANITIZED_STEP(3)) {
            const sp_pack_spec s = spec_of(dim, exponents[k]);
            FREED(sp_packing) p, again;
            assert_ok(sp_packing_make(&s, NULL, NULL, &p, &err));
            assert_close(p.pressure, s.pressure, 1e-9 * s.pressure);
            assert_true(p.residual <= 1e-6 * s.pressure && p.friction == 0);
            assert_int_equal(sp_packing_hertzian(&p), exponents[k] == 1.5);
            check_law(&p, exponents[k]);
            check_stable(&p);
            assert_ok(sp_packing_make(&s, NULL, NULL, &again, &err));
            assert_true(sp_packing_hash(&p) == sp_packing_hash(&again));
        }
}

/* A cell of fixed size and shape: its grains have the fraction; below jamming there is no packing. */
TEST(test_fraction) {
    SKIP_SANITIZED();
    for (int dim = 2; dim <= 3; dim++) {
        sp_pack_spec s = spec_of(dim, 1);
        double solid = 0, volume;
        sp_packing p;
        s.pressure = sp_pack_spec_default().pressure;
        s.fraction = dim == 2 ? 0.9 : 0.72;
        s.width = 20;
        s.depth = dim == 3 ? 10 : 0;
        s.grains = dim == 2 ? 400 : 2000;
        assert_ok(sp_packing_make(&s, NULL, NULL, &p, &err));
        for (int32_t i = 0; i < p.n; i++)
            solid += dim == 2 ? 3.14159265358979 * p.r[i] * p.r[i] : 4.18879020478639 * p.r[i] * p.r[i] * p.r[i];
        volume = sp_packing_volume(&p);
        assert_close(solid / volume, s.fraction, 1e-12);
        if (dim == 3)
            assert_close(p.box[0], 2 * p.box[1], 1e-12);
        assert_close(p.box[0], 20, 2); /* about the width */
        assert_true(p.pressure > 1e-4);
        check_law(&p, 1);
        sp_packing_free(&p);
        s.fraction = 0.4;
        assert_fails(sp_packing_make(&s, NULL, NULL, &p, &err), SP_EFAILED, "packing.fraction");
    }
}

typedef struct stages {
    int32_t count;
    double pressure[2], residual;
} stages;

static sp_status keep(const sp_packing *p, int32_t index, void *user, sp_error *e) {
    stages *s = user;
    (void)e;
    check_law(p, 1);
    assert_int_equal(index, s->count);
    s->pressure[s->count++] = p->pressure;
    return SP_OK;
}

/* Down in pressure: each is at rest at its own, and the last contacts are some of the first ones. */
TEST(test_history) {
    static const double history[] = {1e-2, 1e-3};
    sp_pack_spec s = spec_of(2, 1);
    stages seen = {0};
    const sp_pack_hooks hooks = {.user = &seen, .stage = keep};
    sp_packing p;
    s.history = history;
    s.history_count = 2;
    s.pressure = 1e-4;
    assert_ok(sp_packing_make_with(&s, &hooks, &p, &err));
    assert_int_equal(seen.count, 2);
    for (int k = 0; k < 2; k++)
        assert_close(seen.pressure[k], history[k], 1e-8 * history[k]);
    assert_close(p.pressure, 1e-4, 1e-12);
    check_law(&p, 1);
    sp_packing_free(&p);
    s.fraction = 0.9;
    assert_fails(sp_packing_make(&s, NULL, NULL, &p, &err), SP_EINVAL, "packing.history");
}

static sp_packing go_on(const sp_packing *from, double pressure, double fraction) {
    const sp_pack_hooks hooks = {.from = from};
    sp_packing p = sp_packing_none();
    sp_pack_spec s = sp_pack_spec_default();
    s.kind = SP_PACK_MINIMUM;
    s.cell = SP_CELL_PERIODIC;
    s.dim = from->dim;
    s.friction = 0;
    s.law_exponent = 1;
    s.pressure = pressure;
    s.fraction = fraction;
    assert_ok(sp_packing_make_with(&s, &hooks, &p, &err));
    return p;
}

/* A minimum that begins with another is the next of its history; at its own fraction it stays where it is. */
TEST(test_goes_on) {
    for (int dim = 2; dim <= 3; dim++) {
        const double history[] = {2e-3};
        sp_pack_spec s = spec_of(dim, 1);
        sp_packing first, both, still;
        s.pressure = 2e-3;
        assert_ok(sp_packing_make(&s, NULL, NULL, &first, &err));
        s.pressure = 1e-3;
        s.history = history;
        s.history_count = 1;
        assert_ok(sp_packing_make(&s, NULL, NULL, &both, &err));
        FREED(sp_packing) next = go_on(&first, 1e-3, 0);
        assert_relative(next.pressure, 1e-3, 2e-9);
        assert_relative(next.box[0], both.box[0], 1e-7);
        assert_int_equal(next.n_contacts, both.n_contacts);
        check_law(&next, 1);
        sp_statics of;
        assert_ok(sp_statics_make(&first, 1e-4, 0, &of, &err));
        still = go_on(&first, sp_pack_spec_default().pressure, dim == 2 ? of.phi2 : of.phi3);
        assert_relative(still.pressure, first.pressure, 1e-9);
        sp_packing_free(&still);
        still = go_on(&first, sp_pack_spec_default().pressure, 1.01 * (dim == 2 ? of.phi2 : of.phi3));
        assert_true(still.pressure > 1.1 * first.pressure);
        sp_packing_free(&still);
        sp_packing_free(&both);
        sp_packing_free(&first);
    }
}

TEST(test_goes_on_refusals) {
    sp_packing smooth, p = sp_packing_none();
    sp_pack_spec s = spec_of(2, 1);
    assert_ok(sp_packing_make(&s, NULL, NULL, &smooth, &err));
    const sp_pack_hooks hooks = {.from = &smooth};
    s.sizes = SP_SIZES_UNIFORM;
    s.diameter_min = s.diameter_max = 0;
    s.law_exponent = 1.5;
    assert_fails(sp_packing_make_with(&s, &hooks, &p, &err), SP_EINVAL, "packing.law.exponent 1.5 1");
    s.law_exponent = 1;
    smooth.friction = 0.5;
    assert_fails(sp_packing_make_with(&s, &hooks, &p, &err), SP_EINVAL, "packing.file friction 0.5 smooth");
    smooth.friction = 0;
    s.content = 7;
    assert_fails(sp_packing_make_with(&s, &hooks, &p, &err), SP_EINVAL, "packing.content 7");
    assert_fails(sp_packing_make(&s, NULL, NULL, &p, &err), SP_EINVAL, "packing.file packing.content");
    sp_packing_free(&smooth);
}

static bool stop(const sp_pack_progress *progress, void *user) {
    (void)progress, (void)user;
    return false;
}

TEST(test_refusals) {
    sp_packing p = sp_packing_none();
    sp_pack_spec s = spec_of(2, 1);
    assert_fails(sp_packing_make(&s, stop, NULL, &p, &err), SP_EINTERRUPTED, "steps");
    s.max_steps = 10;
    assert_fails(sp_packing_make(&s, NULL, NULL, &p, &err), SP_EFAILED, "10 steps");
    s = spec_of(2, 1);
    s.friction = 0.5;
    assert_fails(sp_packing_make(&s, NULL, NULL, &p, &err), SP_EINVAL, "packing.friction");
    s = spec_of(2, 1);
    s.cell = SP_CELL_BOX;
    assert_fails(sp_packing_make(&s, NULL, NULL, &p, &err), SP_EINVAL, "packing.cell");
    s = spec_of(2, 1);
    s.kind = SP_PACK_PISTON;
    s.cell = SP_CELL_BOX;
    assert_fails(sp_packing_make(&s, NULL, NULL, &p, &err), SP_EINVAL, "packing.law.exponent");
    s = spec_of(2, 1.5);
    s.protocol = SP_PROTOCOL_QUICK;
    assert_fails(sp_packing_make(&s, NULL, NULL, &p, &err), SP_EINVAL, "packing.protocol");
    s = spec_of(2, 1);
    s.pressure = 1e-10;
    assert_fails(sp_packing_make(&s, NULL, NULL, &p, &err), SP_EINVAL, "packing.pressure");
    s = spec_of(2, 1.5);
    s.kind = SP_PACK_PISTON;
    s.fraction = 0.9;
    assert_fails(sp_packing_make(&s, NULL, NULL, &p, &err), SP_EINVAL, "packing.fraction");
    s = spec_of(2, NAN);
    assert_fails(sp_packing_make(&s, NULL, NULL, &p, &err), SP_EINVAL, "packing.law.exponent");
    s = spec_of(2, 2);
    EACH_ALLOCATION_FAILS(5, sp_packing_make(&s, NULL, NULL, &p, &err), assert_true(!lacks || !p.x),
                          sp_packing_free(&p));
}

RUN_TESTS(NULL, NULL)
