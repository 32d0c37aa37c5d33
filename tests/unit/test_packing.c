/* Structure checks, rattlers, audit, statics, and the ordered packings whose every number is known. */
#include "packing/geometry.h"
#include "test.h"

#include "base/base.h"
#include "numeric/random.h"
#include "packing/contact.h"

#include <sonopack/packing.h>

static sp_packing make_triangular(int rows, int columns, double pressure) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.kind = SP_PACK_TRIANGULAR;
    spec.width = columns;
    spec.grains = rows * columns;
    spec.pressure = pressure;
    sp_packing p = sp_packing_none();
    assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
    return p;
}

static sp_packing make_chain(int n, double low, double high) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.kind = SP_PACK_CHAIN;
    spec.dim = 1;
    spec.grains = n;
    spec.diameter_min = low;
    spec.diameter_max = high;
    sp_packing p = sp_packing_none();
    assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
    return p;
}

static void assert_sound(const sp_packing *p) {
    sp_audit a;
    assert_ok(sp_packing_check(p, &err));
    assert_ok(sp_packing_audit(p, 1e-4, &a, &err));
    assert_true(a.force_residual < 1e-11);
    assert_true(a.torque_residual < 1e-11);
    assert_true(a.wall_residual < 1e-11);
    assert_true(a.law_residual < 1e-12);
    assert_true(a.geometry_residual < 1e-9); /* 24 d x 2^-52 over an overlap of 2e-3 d */
    assert_true(a.coulomb_excess <= 0);
    assert_int_equal(a.missing, 0);
    assert_int_equal(a.rattlers, 0);
    assert_int_equal(a.carrying, p->n_contacts);
}

TEST(test_triangular) {
    sp_packing p = make_triangular(25, 24, 1e-4);
    assert_sound(&p);
    assert_int_equal(p.n_contacts, 3 * 600);
    const double spacing = 1 - p.contacts[0].overlap, down = p.contacts[p.n_contacts - 1].overlap;
    assert_relative(p.box[0], 24 * spacing, 1e-15);
    for (int c = 0; c < p.n_contacts; c++) /* p times a spacing of wall on two oblique contacts */
        assert_relative(p.contacts[c].fn, 1e-4 * spacing / (p.contacts[c].j < 0 ? 1 : sqrt(3.0)), 1e-13);
    /* stiffness at the wall over that between two rows, 3/2 k_n a grain; section V B of the paper prints the inverse,
     * but its wall is rigid (appendix A) */
    const double k_wall = 2 * sqrt(0.5 * down), k_row = 1.5 * sqrt(0.25 * (1 - spacing));
    assert_relative(k_wall / k_row, 4 / pow(3, 5.0 / 6.0), 1e-13);
    sp_packing_free(&p);
    p = make_triangular(2, 3, 1e-2);
    assert_sound(&p);
    sp_packing_free(&p);
    p = make_triangular(1, 5, 1e-9);
    assert_sound(&p);
    sp_packing_free(&p);
}

/* Walls bear p times their area, whatever the size of the grains. */
TEST(test_other_sizes) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.kind = SP_PACK_TRIANGULAR;
    spec.width = 20;
    for (double d = 0.5; d <= 2; d *= 2) {
        spec.diameter_min = spec.diameter_max = d;
        spec.grains = (int32_t)(5 * 20 / d);
        FREED(sp_packing) p = sp_packing_none();
        assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
        assert_sound(&p);
    }
    spec = sp_pack_spec_default();
    spec.kind = SP_PACK_CHAIN;
    spec.dim = 1;
    spec.pressure = 1e-2;
    spec.diameter_min = spec.diameter_max = 0.02; /* crushed */
    sp_packing p = sp_packing_none();
    assert_fails(sp_packing_make(&spec, NULL, NULL, &p, &err), SP_EFAILED, "packing.pressure 0.01");
    /* a pressure at which the overlap of the first two is between their radii, and all others are less */
    const double radius[] = {0.0102, 0.01, 5}, diameter[] = {0.0204, 0.02, 10};
    spec.grains = spec.diameter_count = 3;
    spec.sizes = SP_SIZES_LIST;
    spec.diameters = diameter;
    spec.diameter_min = spec.diameter_max = 0;
    spec.pressure = contact_force(contact_stiffness(radius[0], radius[1]), 0.0101);
    assert_fails(sp_packing_make(&spec, NULL, NULL, &p, &err), SP_EFAILED, "packing.pressure");
    spec.pressure *= 0.9;
    assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
    sp_packing_free(&p);
    spec = sp_pack_spec_default(); /* of a lattice the second neighbours would touch */
    spec.kind = SP_PACK_TRIANGULAR;
    spec.pressure = 1e-2;
    spec.width = 0.4;
    spec.grains = 100;
    spec.diameter_min = spec.diameter_max = 0.02;
    assert_fails(sp_packing_make(&spec, NULL, NULL, &p, &err), SP_EFAILED, "packing.pressure 0.01");
}

TEST(test_chain) {
    sp_packing p = make_chain(10, 0, 0);
    assert_sound(&p);
    assert_int_equal(p.n_contacts, 11);
    /* F = n^(3/2)/3 between balls of diameter 1 (E12 = 1/2, R12 = 1/4), walls the same */
    for (int c = 0; c < 11; c++)
        assert_relative(p.contacts[c].overlap, pow(3e-4, 2.0 / 3.0), 1e-14);
    assert_relative(p.box[0], 10 - 11 * pow(3e-4, 2.0 / 3.0), 1e-14);
    sp_packing_free(&p);
    p = make_chain(50, 0.5, 1.5);
    assert_sound(&p);
    assert_true(p.r[0] != p.r[1]);
    sp_packing_free(&p);
    p = make_chain(1, 0, 0);
    assert_sound(&p);
    sp_packing_free(&p);
}

/* One pass after another over everything: the definition itself. */
static int naive_rattlers(const sp_packing *p, double threshold, uint8_t *rattler) {
    int needed = p->friction > 0 ? 2 : p->dim + 1, total = 0, found = 1;
    memset(rattler, 0, (size_t)p->n);
    while (found > 0) {
        found = 0;
        for (int32_t i = 0; i < p->n; i++) {
            int count = 0;
            for (int32_t c = 0; c < p->n_contacts; c++) {
                const sp_contact *k = &p->contacts[c];
                bool mine = k->i == i || k->j == i, loose = rattler[k->i] || (k->j >= 0 && rattler[k->j]);
                count += mine && !loose && k->fn > threshold * p->pressure;
            }
            if (!rattler[i] && count < needed) {
                rattler[i] = 1;
                found++;
            }
        }
        total += found;
    }
    return total;
}

TEST(test_rattlers) {
    uint8_t want[100], got[100], carrying[400];
    for (uint64_t seed = 1; seed <= 200; seed++) {
        FREED(sp_packing) p = make_triangular(10, 10, 1e-4);
        sp_random r = sp_random_make(seed, 77);
        p.friction = seed % 2 ? 0.5 : 0;
        for (int32_t c = 0; c < p.n_contacts; c++)
            p.contacts[c].fn *= sp_random_uniform(&r) < 0.45 ? 1e-6 : 1; /* open some */
        int32_t n;
        assert_ok(sp_packing_rattlers(&p, 1e-4, got, carrying, &n, &err));
        if (n != naive_rattlers(&p, 1e-4, want) || memcmp(want, got, 100) != 0)
            fail_msg("seed %d: %d rattlers", (int)seed, n);
        for (int32_t c = 0; c < p.n_contacts; c++) {
            const sp_contact *k = &p.contacts[c];
            bool loose = got[k->i] || (k->j >= 0 && got[k->j]);
            assert_int_equal(carrying[c], !loose && k->fn > 1e-8);
        }
        assert_fails(sp_packing_rattlers(&p, NAN, got, carrying, &n, &err), SP_EINVAL, "threshold");
    }
}

TEST(test_check_finds) {
    sp_packing p = make_triangular(4, 5, 1e-4), q;
#define BROKEN(change, text)                                                                                           \
    do {                                                                                                               \
        q = make_triangular(4, 5, 1e-4);                                                                               \
        change;                                                                                                        \
        assert_fails(sp_packing_check(&q, &err), SP_EFORMAT, text);                                                    \
        sp_packing_free(&q);                                                                                           \
    } while (0)
    BROKEN(q.r[3] = 0, "3 radius");
    BROKEN(q.r[3] = NAN, "3 radius");
    BROKEN(q.r[3] = 1e200, "3 radius 1e+200 height");
    BROKEN(q.x[0] = -1, "0 -1");
    BROKEN(q.x[1] = NAN, "1 nan");
    BROKEN(q.box[0] = INFINITY, "0");
    BROKEN(q.pressure = 0, "pressure");
    BROKEN(q.friction = -1, "friction");
    BROKEN(assert_ok(sp_packing_alloc_species(&q, &err)); q.species[2] = -1, "2 -1");
    BROKEN(q.poisson = 0.6, "Poisson");
    BROKEN(q.contacts[2].j = 99, "2");
    BROKEN(q.contacts[2].i = -1, "2");
    BROKEN(q.contacts[2].j = -3, "2");
    BROKEN(q.contacts[2].n[0] = 2, "2 2.17944947177");
    BROKEN(q.contacts[2].n[2] = 1e-3, "2");
    BROKEN(q.contacts[2].overlap = -1e-3, "overlap");
    BROKEN(q.contacts[2].overlap = 5, "overlap");
    BROKEN(q.contacts[2].fn = NAN, "2 nan");
    BROKEN(q.contacts[2].fn = 1e300, "2 1e+300");
    BROKEN(q.contacts[2].ft[0] = 1, "2");
    BROKEN(q.contacts[2] = q.contacts[1], "2 0 4");
    BROKEN(q.contacts[1] = q.contacts[2], "2 0 5");
    BROKEN(q.wall = (sp_wall)7, "7 0 1");
    BROKEN(q.n = 0, "0");
    sp_packing_free(&p);
}

TEST(test_audit_finds) {
    sp_audit a;
    sp_packing p = make_triangular(6, 6, 1e-4);
    p.contacts[10].fn *= 1.01;
    assert_ok(sp_packing_audit(&p, 1e-4, &a, &err));
    assert_true(a.force_residual > 1e-3 && a.law_residual > 1e-3);
    sp_packing_free(&p);

    p = make_triangular(6, 6, 1e-4);
    p.contacts[10].ft[0] = -p.contacts[10].n[1] * p.contacts[10].fn;
    p.contacts[10].ft[1] = p.contacts[10].n[0] * p.contacts[10].fn;
    assert_ok(sp_packing_audit(&p, 1e-4, &a, &err));
    assert_close(a.coulomb_excess, 1.0, 1e-9); /* |ft| = fn at mu = 0.5 */
    assert_true(a.torque_residual > 0.1);
    sp_packing_free(&p);

    p = make_triangular(6, 6, 1e-4); /* a contact that nobody lists */
    p.contacts[0] = p.contacts[p.n_contacts - 1];
    p.n_contacts--;
    sp_packing_sort(&p);
    assert_ok(sp_packing_audit(&p, 1e-4, &a, &err));
    assert_int_equal(a.missing, 1);
    sp_packing_free(&p);

    p = make_triangular(6, 6, 1e-4);
    p.x[3 * 14] += 1e-3;
    assert_ok(sp_packing_audit(&p, 1e-4, &a, &err));
    assert_true(a.geometry_residual > 0.1);
    sp_packing_free(&p);

    p = make_triangular(6, 6, 1e-4);
    p.pressure *= 1.001;
    assert_ok(sp_packing_audit(&p, 1e-4, &a, &err));
    assert_relative(a.wall_residual, 1e-3, 1e-2);
    sp_packing_free(&p);
}

/* Overlap and force follow from each other as in a packing that has both; what has neither is refused. */
TEST(test_complete) {
    FREED(sp_packing) p = make_triangular(6, 6, 1e-4), q = make_triangular(6, 6, 1e-4);
    for (int c = 0; c < q.n_contacts; c++)
        *(c % 2 ? &q.contacts[c].fn : &q.contacts[c].overlap) = NAN;
    assert_ok(sp_packing_complete(&q, &err));
    for (int c = 0; c < q.n_contacts; c++) {
        assert_relative(q.contacts[c].fn, p.contacts[c].fn, 1e-13);
        assert_relative(q.contacts[c].overlap, p.contacts[c].overlap, 1e-13);
    }
    q.contacts[5] = (sp_contact){.i = 1, .j = 2, .overlap = 0.01, .fn = NAN, .kn = 3, .kt = NAN}; /* a linear spring */
    assert_ok(sp_packing_complete(&q, &err));
    assert_relative(q.contacts[5].fn, 0.03, 1e-15);
    assert_relative(q.contacts[5].kt, 3.0, 1e-15); /* Poisson's ratio is 0 */
    q.contacts[3].fn = q.contacts[3].overlap = NAN;
    assert_fails(sp_packing_complete(&q, &err), SP_EINVAL, "3 overlap");
    q.contacts[3] = p.contacts[3];
    q.contacts[4].j = q.n;
    assert_fails(sp_packing_complete(&q, &err), SP_EINVAL, "4");
}

TEST(test_statics) {
    sp_packing p = make_triangular(60, 20, 1e-6);
    sp_statics s;
    assert_ok(sp_statics_make(&p, 1e-4, 3, &s, &err));
    /* hexagonal packing of discs pi/(2 sqrt 3), of balls in a layer pi/(3 sqrt 3); the bulk cuts rows: 1/50 */
    assert_relative(s.phi2, 0.9069, 0.02);
    assert_relative(s.phi3, 0.6046, 0.02);
    assert_close(s.phi3s, s.phi3, 1e-15);
    assert_close(s.zs, 6.0, 1e-12);
    assert_close(s.f0, 0.0, 0);
    assert_relative(s.n_over_p, 1 / sqrt(3.0), 1e-3);
    assert_close(s.z2, 1.0, 1e-12);
    assert_close(s.z3, 1.0, 1e-12);
    assert_close(s.f2, 0.5, 0.01); /* isotropic; the bulk cuts between rows */
    assert_relative(s.s1_over_s2, 1.0, 0.02);
    sp_packing_free(&p);
    p = make_triangular(4, 5, 1e-4); /* no bulk: says so with NAN */
    assert_ok(sp_statics_make(&p, 1e-4, 3, &s, &err));
    assert_true(isnan(s.phi2) && isnan(s.zs));
    sp_packing_free(&p);
}

TEST(test_spec_refuses) {
    sp_pack_spec s;
#define REFUSED(change, text)                                                                                          \
    do {                                                                                                               \
        s = sp_pack_spec_default();                                                                                    \
        change;                                                                                                        \
        assert_fails(sp_pack_spec_check(&s, &err), SP_EINVAL, text);                                                   \
    } while (0)
    s = sp_pack_spec_default();
    assert_ok(sp_pack_spec_check(&s, &err));
    REFUSED(s.grains = 0, "packing.grains");
    REFUSED(s.width = 3, "packing.width");
    REFUSED(s.width = NAN, "packing.width");
    REFUSED(s.pressure = 1e-12, "packing.pressure");
    REFUSED(s.pressure = 10, "packing.pressure");
    REFUSED(s.pressure = NAN, "packing.pressure");
    REFUSED(s.friction = -0.1, "packing.friction");
    REFUSED(s.poisson = 0.51, "packing.poisson");
    REFUSED(s.time_step = 4.5, "packing.time_step 4.5 0.001 1");
    REFUSED(s.time_step = 5e-4, "packing.time_step");
    REFUSED(s.dim = 1, "packing.dimension 1 2 3");
    REFUSED(s.dim = 4, "packing.dimension");
    REFUSED(s.depth = 24, "packing.depth 24 0");
    REFUSED((s.dim = 3, s.depth = 4), "packing.depth 4 4.8");
    REFUSED((s.dim = 3, s.width = 4, s.depth = 9), "packing.width 4");
    REFUSED(s.depth = NAN, "packing.depth");
    REFUSED(s.gas_fraction = 0.8, "packing.gas_fraction");
    REFUSED(s.gas_fraction = 0.46, "packing.gas_fraction 0.46 0.01 0.45");
    REFUSED((s.dim = 3, s.gas_fraction = 0.31), "packing.gas_fraction 0.31 0.3 3");
    REFUSED(s.gas_fraction = 0.001, "packing.gas_fraction");
    REFUSED(s.gas_fraction = NAN, "packing.gas_fraction");
    REFUSED(s.piston_mass = 0.09, "packing.piston_mass 0.09 0.1");
    REFUSED(s.piston_mass = 2e4, "packing.piston_mass 20000 10000");
    REFUSED(s.calm = NAN, "packing.calm");
    REFUSED(s.drag = 0.2, "packing.drag");
    REFUSED(s.sizes = (sp_sizes)4, "packing.sizes");
    REFUSED(s.protocol = (sp_protocol)4, "packing.protocol");
    REFUSED(s.compression = (sp_compression)7, "packing.compression");
    REFUSED(s.large_fraction = 1.1, "packing.large_fraction");
    REFUSED(s.size_spread = -0.1, "packing.size_spread");
    REFUSED((s.diameter_min = 1.2, s.diameter_max = 0.8), "packing.diameter_min");
    REFUSED((s.diameter_min = 0.01, s.diameter_max = 2), "100");
    REFUSED((s.diameter_min = s.diameter_max = 100, s.width = 500), "packing.diameter_min packing.diameter_max");
    REFUSED(s.damping = 3, "packing.damping 3 0.001 2");
    REFUSED(s.piston_mass = 0.01, "packing.piston_mass 0.01 0.1");
    REFUSED(s.piston_mass = 1e5, "packing.piston_mass");
    REFUSED((s.grains = 2, s.width = 500, s.pressure = 0.01), "packing.pressure 0.01");
    REFUSED((s.grains = 10, s.compression = SP_COMPRESSION_ISOTROPIC), "packing.grains 10 29");
    REFUSED(s.tolerance = 1, "packing.tolerance 1 0.1 packing.pressure");
    REFUSED((s.sizes = SP_SIZES_LOGNORMAL, s.diameter_min = 2, s.diameter_max = 3),
            "packing.size_spread packing.diameter_min packing.diameter_max");
    REFUSED((s.sizes = SP_SIZES_LOGNORMAL, s.diameter_min = s.diameter_max = 1), "0");
    REFUSED((s.sizes = SP_SIZES_LOGNORMAL, s.size_spread = 0, s.diameter_min = 1.1, s.diameter_max = 1.2), "1");
    REFUSED((s.sizes = SP_SIZES_LOGNORMAL, s.size_spread = 0.8), "100");
    REFUSED((s.sizes = SP_SIZES_LOGNORMAL, s.size_spread = 0.7), "packing.width 24"); /* 6.4 d */
    REFUSED((s.sizes = SP_SIZES_BIDISPERSE, s.diameter_min = 1, s.diameter_max = 7), "packing.width 24");
    REFUSED(s.sizes = SP_SIZES_LIST, "packing.diameters 0 packing.grains 600");
    const double list[] = {1, 1.1, 0.9, 1, 1.2}, torn[] = {1, NAN, 1}, wide[] = {1, 1, 0.009};
    REFUSED((s.sizes = SP_SIZES_LIST, s.diameters = list, s.diameter_count = 5), "5");
    REFUSED((s.sizes = SP_SIZES_LIST, s.grains = 3, s.diameters = torn, s.diameter_count = 3), "2 nan");
    REFUSED((s.sizes = SP_SIZES_LIST, s.grains = 2, s.diameters = wide, s.diameter_count = 3), "3 0.009");
    REFUSED((s.sizes = SP_SIZES_LIST, s.grains = 5, s.diameters = list, s.diameter_count = 5, s.diameter_max = 1.3),
            "packing.diameter_max 1.3 0");
    REFUSED((s.grains = 5, s.diameters = list, s.diameter_count = 5), "packing.sizes uniform list");
    REFUSED((s.diameters = list, s.diameter_count = -1), "packing.diameters");
    s = sp_pack_spec_default();
    s.sizes = SP_SIZES_LIST;
    s.grains = 5;
    s.diameters = list;
    s.diameter_count = 5;
    assert_ok(sp_pack_spec_check(&s, &err));
    s = sp_pack_spec_default();
    s.dim = 3;
    assert_ok(sp_pack_spec_check(&s, &err));
    s.diameter_min = s.diameter_max = 1;
    s.width = s.depth = 4;
    assert_ok(sp_pack_spec_check(&s, &err));
    s = sp_pack_spec_default();
    s.kind = SP_PACK_TRIANGULAR;
    s.diameter_min = 0.9;
    s.diameter_max = 1.1;
    assert_ok(sp_pack_spec_check(&s, &err));
    REFUSED((s.kind = SP_PACK_TRIANGULAR, s.diameter_min = 0.5, s.diameter_max = 7.5, s.grains = 6),
            "packing.width 24 30");
    REFUSED((s.kind = SP_PACK_TRIANGULAR, s.diameter_min = 0.9, s.diameter_max = 1.1, s.tolerance = 1), "tolerance");
    REFUSED((s.kind = SP_PACK_CHAIN), "packing.dimension");
    REFUSED((s.kind = SP_PACK_CHAIN, s.dim = 1, s.compression = SP_COMPRESSION_ISOTROPIC),
            "packing.compression isotropic packing.kind chain");
    REFUSED((s.kind = SP_PACK_TRIANGULAR, s.grains = 601), "24");
}

/* The walls of a box balance together: friction at the bottom holds what the left wall pushes more than the right. */
TEST(test_audit_box) {
    FREED(sp_packing) p;
    sp_audit a;
    const double f = 1e-4, slip = 1e-5, normal[4][2] = {{0, -1}, {0, 1}, {-1, 0}, {1, 0}};
    assert_ok(sp_packing_alloc(&p, 2, 1, 4, &err));
    p.cell = SP_CELL_BOX;
    p.box[0] = p.box[1] = 1;
    p.x[0] = p.x[1] = p.r[0] = 0.5;
    p.friction = 0.5;
    for (int k = 0; k < 4; k++) {
        p.contacts[k] = (sp_contact){.i = 0, .j = SP_BOTTOM - k, .fn = f + (k == 2 ? slip : 0)};
        memcpy(p.contacts[k].n, normal[k], sizeof normal[k]);
    }
    p.contacts[0].ft[0] = -slip;
    p.pressure = 0.5 * (4 * f + slip) / 2; /* sum of F R over dim V */
    assert_ok(sp_packing_check(&p, &err));
    assert_ok(sp_packing_audit(&p, 1e-4, &a, &err));
    assert_close(a.wall_residual, 0, 1e-12);
    p.contacts[0].ft[0] = 0;
    assert_ok(sp_packing_audit(&p, 1e-4, &a, &err));
    assert_close(a.wall_residual, slip / p.pressure, 1e-12);
}

TEST(nothing_given) {
    const sp_pack_spec spec = sp_pack_spec_default();
    sp_packing p = sp_packing_none();
    assert_fails(sp_packing_make(NULL, NULL, NULL, &p, &err), SP_EINVAL, "spec");
    assert_fails(sp_packing_make(&spec, NULL, NULL, NULL, &err), SP_EINVAL, "packing");
    assert_fails(sp_packing_make_with(NULL, NULL, &p, &err), SP_EINVAL, "spec");
}

/* Which pairs a sweep visits, and how often. */
typedef struct visits {
    int n;
    int *times; /* [n][n] */
} visits;

static sp_status visit(int32_t i, int32_t j, void *user, sp_error *err) {
    visits *v = user;
    (void)err;
    if (j >= 0) {
        assert_true(i < j && j < v->n);
        v->times[i * v->n + j]++;
    }
    return SP_OK;
}

/* Every pair that is near is visited, and none twice where no period is narrow. */
TEST(test_sweep) {
    enum { N = 250 };
    static int times[N * N];
    srand(5);
    for (int round = 0; round < 60; round++) {
        const int dim = 2 + round % 2;
        const sp_cell cell = (sp_cell)(round / 2 % 3);
        const double gap = 0.7 * rand() / RAND_MAX;
        FREED(sp_packing) p = sp_packing_none();
        assert_ok(sp_packing_alloc(&p, dim, N, 0, &err));
        p.cell = cell;
        for (int a = 0; a < 3; a++)
            p.box[a] = a < dim ? 4 + 10.0 * rand() / RAND_MAX : 1;
        for (int a = 0; a < 3 && cell == SP_CELL_PERIODIC && round % 4 < 2; a++)
            p.tilt[a] = a == 0 || dim == 3 ? (1.0 * rand() / RAND_MAX - 0.5) * p.box[a == 2] : 0;
        for (int i = 0; i < N; i++) {
            p.r[i] = 0.3 + 0.2 * rand() / RAND_MAX;
            for (int a = 0; a < dim; a++)
                p.x[3 * i + a] = p.box[a] * rand() / RAND_MAX;
            sp_packing_wrap(&p, p.x + 3 * (size_t)i);
        }
        memset(times, 0, sizeof times);
        assert_ok(sp_packing_sweep(&p, gap, visit, &(visits){N, times}, &err));
        for (int i = 0; i < N; i++)
            for (int j = i + 1; j < N; j++) {
                double d[3];
                sp_packing_separation(&p, i, j, d);
                const double apart = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) - p.r[i] - p.r[j];
                assert_true(apart >= gap || times[i * N + j] == 1);
                assert_true(times[i * N + j] <= 1);
            }
    }
}

RUN_TESTS(NULL, NULL)
