/* Density along the column by the models' own definitions. */
#include "base/base.h"
#include "test.h"

#include <sonopack/tapped/tapped.h>

typedef struct rows {
    int32_t particles;
    int64_t n;
    double t[64], y[64][64], rho[64][64];
} rows;

static sp_status keep(double t, const double *y, const double *rho, void *user, sp_error *err) {
    rows *r = user;
    (void)err;
    assert_true(r->n < 64 && r->particles < 64);
    r->t[r->n] = t;
    memcpy(r->y[r->n], y, ((size_t)r->particles + 1) * sizeof *y);
    memcpy(r->rho[r->n], rho, (size_t)r->particles * sizeof *rho);
    r->n++;
    return SP_OK;
}

static void run(const sp_tapped_spec *c, int64_t n, const double *t, rows *r) {
    *r = (rows){.particles = c->particles};
    assert_ok(sp_tapped_run_density(c, n, t, keep, r, &err));
    assert_int_equal(r->n, n);
}

typedef struct kind {
    sp_tapped_model model;
    sp_tapped_bsr bsr;
} kind;
static const kind kinds[] = {{SP_TAPPED_LATTICE, SP_TAPPED_BSR_CONSERVATIVE},
                             {SP_TAPPED_LONGWAVE, SP_TAPPED_BSR_CONSERVATIVE},
                             {SP_TAPPED_BSR, SP_TAPPED_BSR_CONSERVATIVE},
                             {SP_TAPPED_BSR, SP_TAPPED_BSR_LITERAL},
                             {SP_TAPPED_BSR, SP_TAPPED_BSR_SIGNED}};
enum { KINDS = sizeof kinds / sizeof *kinds };

/* (42): m/2r in a column that just touches, with every model; to the rounding of y_z = 1 and of the cells' masses. */
TEST(test_touching) {
    const double start = 0, mass = 3, radius = 0.7;
    for (int k = 0; k < KINDS; k++)
        for (int32_t n = 1; n <= 50; n += n < 4 ? 1 : 23) {
            sp_tapped_spec c = sp_tapped_spec_default();
            rows r;
            c.model = kinds[k].model;
            c.bsr = kinds[k].bsr;
            c.particles = n;
            c.mass = &mass;
            c.radius = &radius;
            c.drop = 0;
            c.taps = 1;
            c.period = 0.08;
            run(&c, 1, &start, &r);
            for (int32_t i = 0; i < n; i++)
                assert_relative(r.rho[0][i], mass / (2 * radius), 1e-12);
        }
}

/* Each of unequal particles has m/2r of its own. */
TEST(test_unequal) {
    const double start = 0, mass[] = {1, 0.2, 5}, radius[] = {1, 0.5};
    sp_tapped_spec c = sp_tapped_spec_default();
    rows r;
    c.particles = 9;
    c.mass = mass;
    c.masses = 3;
    c.radius = radius;
    c.radii = 2;
    c.drop = 0;
    c.taps = 1;
    run(&c, 1, &start, &r);
    for (int32_t i = 0; i < 9; i++)
        assert_relative(r.rho[0][i], mass[i % 3] / (2 * radius[i % 2]), 1e-12);
}

/* Lengths of the particles: halves of distances, all of the lowest to the floor, the radius above the highest. */
static double mass_of(const sp_tapped_spec *c, const rows *r, int64_t k) {
    double mass = 0, low = r->y[k][0];
    const int32_t n = c->particles;
    for (int32_t i = 1; i <= n; i++) {
        double high = i < n ? (r->y[k][i] + r->y[k][i + 1]) / 2 : r->y[k][n] + sp_tapped_radius(c, n);
        mass += r->rho[k][i - 1] * (high - low);
        low = high;
    }
    return mass;
}

/* The lattice's density over the height is the mass of all at any time. */
TEST(test_lattice_mass) {
    sp_tapped_spec c = sp_tapped_spec_default();
    double t[40];
    rows r;
    c.taps = 1;
    for (int k = 0; k < 40; k++)
        t[k] = 0.025 * k;
    run(&c, 40, t, &r);
    for (int64_t k = 0; k < 40; k++)
        assert_relative(mass_of(&c, &r, k), 5.0, 1e-12);
}

/* At rest the lattice has m/(h - n M) around a particle with a contact of load n - 1/2 in the mean, M = m g/K, and the
 * continua m/s, s^2 = (h - N M)^2 + 2 M x with (i - 1/2) m below: s = h - (N - i + 1/2) M. */
TEST(test_rest) {
    const double start = 0;
    for (int k = 0; k < 3; k++) {
        sp_tapped_spec c = sp_tapped_spec_default();
        rows r;
        c.model = kinds[k].model;
        c.particles = 20;
        c.taps = 1;
        run(&c, 1, &start, &r);
        double sag = c.gravity / sp_tapped_stiffness(&c);
        for (int32_t i = 2; i < 20; i++) {
            /* cells of h/8 have the density of their own middle: within sag h/16 of the distance */
            double tolerance = kinds[k].model == SP_TAPPED_BSR ? 1.01 * sag / 16 : 1e-9;
            assert_relative(r.rho[0][i - 1], 1 / (2 - (20 - i + 0.5) * sag), tolerance);
        }
    }
}

/* The continua's density, integrated over the height, is the mass up to the midpoint rule's error, of second order in
 * 1/N; in the middle of the column, where no end has a say. */
TEST(test_mass) {
    const double t[] = {0, 0.3};
    for (int k = 1; k < 3; k++) {
        sp_tapped_spec c = sp_tapped_spec_default();
        rows r;
        c.model = kinds[k].model;
        c.particles = 40;
        c.amplitude = 0.1;
        c.taps = 1;
        run(&c, 2, t, &r);
        for (int64_t row = 0; row < 2; row++) {
            double mass = 0;
            for (int32_t i = 6; i <= 35; i++)
                mass += r.rho[row][i - 1] * (r.y[row][i + 1] - r.y[row][i - 1]) / 2;
            assert_relative(mass, 30.0, 0.005);
        }
    }
}

/* (48) with (42) along a path: rho grows as neighbours come closer, by up to a fifth and more here. Their distance
 * stands for that of paths next to each other up to (h^2/6) y_zzz, some percent, as Theta is 3 h wide. */
TEST(test_literal) {
    const double t[] = {0, 0.03};
    for (int k = 3; k < KINDS; k++) {
        sp_tapped_spec c = sp_tapped_spec_default();
        rows r;
        c.model = kinds[k].model;
        c.bsr = kinds[k].bsr;
        c.particles = 40;
        c.amplitude = 0;
        c.taps = 1;
        c.cells = 16;
        run(&c, 2, t, &r);
        double worst = 0, most = 0;
        for (int32_t i = 8; i < 40; i++) {
            double closer = (r.y[0][i + 1] - r.y[0][i - 1]) / (r.y[1][i + 1] - r.y[1][i - 1]);
            worst = fmax(worst, fabs(r.rho[1][i - 1] / r.rho[0][i - 1] / closer - 1));
            most = fmax(most, fabs(closer - 1));
        }
        if (!(worst < 0.15 * most && most > 0.05))
            fail_msg("rho and distances, which change by %g, disagree by %g", most, worst);
    }
}

RUN_TESTS(NULL, NULL)
