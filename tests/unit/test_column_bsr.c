/* The BSR models: the printed integral and the one with signs, whose columns collapse; and the conservative one, which
 * carries its column. */
#include "base/base.h"
#include "test.h"

#include <sonopack/tapped/tapped.h>

static const double pi = 3.14159265358979323846;

typedef struct rows {
    int32_t particles;
    int64_t n;
    double *t, *y, *v; /* [n], [n][particles + 1] */
    bool finite;
} rows;

static sp_status keep(double t, const double *y, const double *v, void *user, sp_error *err) {
    rows *r = user;
    size_t width = (size_t)r->particles + 1;
    (void)err;
    r->t[r->n] = t;
    for (size_t i = 0; i < width; i++)
        r->finite = r->finite && isfinite(y[i]) && isfinite(v[i]);
    memcpy(r->y + (size_t)r->n * width, y, width * sizeof *y);
    memcpy(r->v + (size_t)r->n * width, v, width * sizeof *v);
    r->n++;
    return SP_OK;
}

/* n + 1 rows, equally spaced over all taps. */
static sp_status try(const sp_tapped_spec *c, int64_t n, rows *r, sp_tapped_report *report, sp_error *err) {
    size_t all = (size_t)(n + 1), width = (size_t)c->particles + 1;
    double *t = sp_alloc(all, sizeof *t);
    *r = (rows){.particles = c->particles, .finite = true};
    r->t = sp_alloc(all, sizeof *r->t);
    r->y = sp_alloc(all * width, sizeof *r->y);
    r->v = sp_alloc(all * width, sizeof *r->v);
    assert_true(t && r->t && r->y && r->v);
    for (int64_t k = 0; k <= n; k++)
        t[k] = c->taps * c->period * (double)k / (double)n;
    sp_status status = sp_tapped_run(c, n + 1, t, keep, r, report, err);
    sp_free(t);
    return status;
}
static void run(const sp_tapped_spec *c, int64_t n, rows *r, sp_tapped_report *report) {
    assert_ok(try(c, n, r, report, &err));
    assert_int_equal(r->n, n + 1);
    assert_true(r->finite);
}
static void release(rows *r) {
    sp_free(r->t);
    sp_free(r->y);
    sp_free(r->v);
}
static double at(const rows *r, int64_t k, int32_t i) {
    return r->y[(size_t)k * (size_t)(r->particles + 1) + (size_t)i];
}
static double speed_at(const rows *r, int64_t k, int32_t i) {
    return r->v[(size_t)k * (size_t)(r->particles + 1) + (size_t)i];
}

static sp_tapped_spec bsr(sp_tapped_bsr which) {
    sp_tapped_spec c = sp_tapped_spec_default();
    c.model = SP_TAPPED_BSR;
    c.bsr = which;
    c.taps = 4;
    return c;
}

/* ---- (45) ------------------------------------------------------------------------------------------------------- */

/* The integral in closed form: h - |y| is the second integral of delta(y - h) - 2 delta(y) + delta(y + h), and that of
 * a normal distribution is x Phi + phi. With sgn(y) only one side counts, twice, less both. */
static double twice_integrated(double x) { return x * 0.5 * erfc(-x / sqrt(2)) + exp(-x * x / 2) / sqrt(2 * pi); }
static double closed_force(const sp_tapped_spec *c, double z, bool printed) {
    double h = 2 * sp_tapped_radius(c, 1), b = 7 * h, w = 3 * h, k = sp_tapped_stiffness(c) / c->gravity;
    double x = (z - b) / w, up = (z + h - b) / w, down = (z - h - b) / w;
    double whole = w * (twice_integrated(up) - 2 * twice_integrated(x) + twice_integrated(down));
    /* above: int_0^h (h - y) Theta = w (G(up) - G(x)) - h Phi(x) */
    double above = w * (twice_integrated(up) - twice_integrated(x)) - h * 0.5 * erfc(-x / sqrt(2));
    return printed ? k * whole * w / b : k * (2 * above - whole);
}

/* [B]'s ten particles: 2.2588 g and 0.3545 g. Printed, (44) has 1/(b sqrt(2 pi)), and it is that which gives 2.2588;
 * with signs 1/(c sqrt(2 pi)) gives 0.3545. Both without e, and proportional to N by K = 2 N m g/r. */
TEST(test_force) {
    for (int32_t n = 1; n <= 100; n += 9) {
        sp_tapped_spec c = sp_tapped_spec_default();
        c.particles = n;
        double most = 0, signed_most = 0;
        for (double z = 0; z <= 60; z += 0.001) {
            most = fmax(most, closed_force(&c, z, true));
            signed_most = fmax(signed_most, fabs(closed_force(&c, z, false)));
        }
        double printed = sp_tapped_bsr_force(&c, SP_TAPPED_BSR_LITERAL);
        double with_sign = sp_tapped_bsr_force(&c, SP_TAPPED_BSR_SIGNED);
        assert_relative(printed, most, 1e-8); /* of the scan: the square of its step over c^2 */
        assert_relative(with_sign, signed_most, 1e-7);
        assert_relative(printed, closed_force(&c, 14, true), 1e-12);
        assert_relative(printed, 0.22588 * n, 2e-5); /* half of the last digit */
        assert_relative(with_sign, 0.03545 * n, 1.5e-4);
        c.stiffness = 3 * sp_tapped_stiffness(&c);
        assert_relative(sp_tapped_bsr_force(&c, SP_TAPPED_BSR_SIGNED), 3 * with_sign, 1e-12);
    }
    const double masses[] = {1, 2};
    sp_tapped_spec c = sp_tapped_spec_default();
    assert_true(isnan(sp_tapped_bsr_force(&c, SP_TAPPED_BSR_CONSERVATIVE)));
    c.masses = 2;
    c.mass = masses;
    assert_true(isnan(sp_tapped_bsr_force(&c, SP_TAPPED_BSR_LITERAL)));
}

/* A resting floor and e = 0: u is smooth until the first particle leaves, and particles follow z'' = -g (1 + force(z)),
 * here by Runge's and Kutta's steps with the closed form; the field's error is of first order. */
static double characteristic(const sp_tapped_spec *c, double z, double until, bool printed) {
    const int steps = 200;
    double v = 0, dt = until / steps;
    for (int k = 0; k < steps; k++) {
        double dz[4], dv[4];
        for (int s = 0; s < 4; s++) {
            double part = s == 0 ? 0 : s == 3 ? dt : dt / 2;
            dz[s] = v + (s > 0 ? part * dv[s - 1] : 0);
            dv[s] = -c->gravity * (1 + closed_force(c, z + (s > 0 ? part * dz[s - 1] : 0), printed));
        }
        z += dt / 6 * (dz[0] + 2 * dz[1] + 2 * dz[2] + dz[3]);
        v += dt / 6 * (dv[0] + 2 * dv[1] + 2 * dv[2] + dv[3]);
    }
    return z;
}

TEST(test_characteristics) {
    for (int which = SP_TAPPED_BSR_LITERAL; which <= SP_TAPPED_BSR_SIGNED; which++) {
        double error[3];
        for (int level = 0; level < 3; level++) {
            sp_tapped_spec c = bsr((sp_tapped_bsr)which);
            rows r;
            c.particles = 10;
            c.amplitude = c.e = 0;
            c.taps = 1;
            c.period = 0.06;
            c.cells = 8 << level;
            run(&c, 6, &r, NULL);
            error[level] = 0;
            for (int32_t i = 5; i <= 10; i++)
                error[level] =
                    fmax(error[level],
                         fabs(at(&r, 6, i) - characteristic(&c, at(&r, 0, i), 0.06, which == SP_TAPPED_BSR_LITERAL)));
            release(&r);
        }
        double order = log2(error[1] / error[2]);
        if (!(order > 0.8 && order < 1.4 && error[2] < 0.05))
            fail_msg("errors %g %g %g cm, order %g; expected 1", error[0], error[1], error[2], order);
    }
}

/* Neither carries a column: all particles go through the floor, the lowest first, and fall on like stones. */
TEST(test_collapse) {
    for (int which = SP_TAPPED_BSR_LITERAL; which <= SP_TAPPED_BSR_SIGNED; which++)
        for (int32_t n = 1; n <= 100; n = n * 3 + 2) {
            sp_tapped_spec c = bsr((sp_tapped_bsr)which);
            sp_tapped_report report;
            rows r;
            c.particles = n;
            run(&c, 100, &r, &report);
            assert_int_equal(report.violated, 0);
            assert_true(report.violated_at > 0 && report.violated_at < 0.1);
            assert_true(report.tap[0].separation < 0);
            for (int32_t i = 1; i <= n; i++) {
                assert_true(at(&r, 100, i) < -1000);
                double gained = speed_at(&r, 100, i) - speed_at(&r, 75, i);
                assert_relative(gained, -c.gravity, 1e-9);
            }
            sp_tapped_report_free(&report);
            release(&r);
        }
}

/* However large alpha_v, sigma asks for no shorter steps. */
TEST(test_stiff_sigma) {
    for (int which = SP_TAPPED_BSR_CONSERVATIVE; which <= SP_TAPPED_BSR_SIGNED; which++) {
        sp_tapped_spec c = bsr((sp_tapped_bsr)which);
        sp_tapped_report report;
        rows r;
        c.alpha_v = 1e9;
        c.e = 0.99;
        run(&c, 40, &r, &report);
        assert_true(report.steps < 20000);
        sp_tapped_report_free(&report);
        release(&r);
    }
}

/* ---- the conservative one --------------------------------------------------------------------------------------- */

/* At rest s^2 = (h - N M)^2 + 2 M x: particle i is where the mass below is (i - 1/2) m, over an edge that the floor's
 * contact lets down by N M/2; a distance of M/8 below (27) everywhere. */
TEST(test_rest) {
    const int32_t counts[] = {1, 2, 5, 10, 40};
    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
        double drift[3], rest[40];
        for (int level = 0; level < 3; level++) {
            sp_tapped_spec c = bsr(SP_TAPPED_BSR_CONSERVATIVE);
            sp_tapped_report report;
            rows r;
            c.particles = counts[k];
            c.amplitude = 0;
            c.taps = 1;
            c.cells = 4 << level;
            run(&c, 50, &r, &report);
            sp_tapped_rest(&c, rest);
            double n = c.particles, sag = c.gravity / sp_tapped_stiffness(&c);
            drift[level] = 0;
            for (int32_t i = 1; i <= c.particles; i++) {
                double j = i - 0.5, expected = 2 * j - j * (n - j / 2) * sag - n * sag / 2;
                /* within a cell the density is taken as constant: less than rho_z/rho dx^2/8, sag/s^2 < 1/4 */
                double near = 0.25 / (c.cells * c.cells) * 4 / 8;
                assert_close(at(&r, 0, i), expected, near);
                assert_close(expected - rest[i - 1], sag / 8, 1e-12);
                drift[level] = fmax(drift[level], fabs(at(&r, 50, i) - at(&r, 0, i)));
            }
            assert_true(report.error < 1e-13);
            assert_int_equal(report.violated, -1);
            sp_tapped_report_free(&report);
            release(&r);
        }
        double order = log2(drift[0] / drift[2]) / 2;
        if (!(order > 1 && drift[1] < 0.002))
            fail_msg("N = %d: drifts %g %g %g cm, order %g; expected above 1, and below 0.002 with eight cells",
                     (int)counts[k], drift[0], drift[1], drift[2], order);
    }
}

/* Taps of all sizes: mass to rounding, no number lost, order kept between particles. */
TEST(test_mass) {
    const double amplitudes[] = {0.01, 0.3, 1.06, 3, 8};
    const int32_t counts[] = {1, 2, 5, 30};
    for (size_t a = 0; a < 5; a++)
        for (size_t k = 0; k < 4; k++) {
            sp_tapped_spec c = bsr(SP_TAPPED_BSR_CONSERVATIVE);
            sp_tapped_report report;
            rows r;
            c.particles = counts[k];
            c.amplitude = amplitudes[a];
            c.taps = 3;
            c.period = 0.4;
            run(&c, 120, &r, &report);
            assert_true(report.error < 1e-13);
            assert_true(report.steps > 100);
            for (int64_t row = 0; row <= 120; row++) {
                assert_close(at(&r, row, 0), sp_tapped_floor(&c, r.t[row]), 0);
                for (int32_t i = 1; i < c.particles; i++)
                    assert_true(at(&r, row, i + 1) > at(&r, row, i));
                assert_true(at(&r, row, c.particles) < 1e3);
            }
            sp_tapped_report_free(&report);
            release(&r);
        }
}

/* A column let go falls as one, exactly: the grid falls with it. */
TEST(test_free_fall) {
    sp_tapped_spec c = bsr(SP_TAPPED_BSR_CONSERVATIVE);
    rows r;
    c.particles = 7;
    c.amplitude = 0;
    c.drop = 20;
    c.taps = 1;
    c.period = 0.2; /* it would be down at sqrt(2 * 20/g) = 0.20196 s */
    run(&c, 20, &r, NULL);
    for (int64_t k = 0; k <= 20; k++)
        for (int32_t i = 1; i <= 7; i++) {
            double t = r.t[k];
            assert_close(at(&r, k, i), 20 + 2 * i - 1 - c.gravity * t * t / 2, 1e-10);
            assert_close(speed_at(&r, k, i), -c.gravity * t, 1e-9);
        }
    release(&r);
}

/* Momentum: a column in flight, compressed below and loose above, has nothing but gravity. The mean of its forty
 * particles stands for the centre of mass, by a midpoint rule. */
TEST(test_flight) {
    sp_tapped_spec c = bsr(SP_TAPPED_BSR_CONSERVATIVE);
    rows r;
    c.particles = 40;
    c.amplitude = 8;
    c.taps = 1;
    c.period = 0.1;
    run(&c, 20, &r, NULL);
    double mean[3] = {0};
    for (int k = 0; k < 3; k++) {
        int64_t row = 11 + 2 * k; /* 0.055, 0.065, 0.075 s */
        assert_true(at(&r, row, 1) - at(&r, row, 0) > 1.5);
        for (int32_t i = 1; i <= 40; i++)
            mean[k] += at(&r, row, i) / 40;
    }
    double most = 0; /* it does not fly as one */
    for (int32_t i = 1; i <= 40; i++)
        most = fmax(most, fabs((at(&r, 15, i) - 2 * at(&r, 13, i) + at(&r, 11, i)) / 1e-4 + c.gravity));
    assert_true(most > 0.1 * c.gravity);
    assert_relative((mean[2] - 2 * mean[1] + mean[0]) / 1e-4, -c.gravity, 0.01);
    release(&r);
}

static double distance(const rows *a, const rows *b) {
    double sum = 0;
    for (int64_t k = 0; k < a->n; k++)
        for (int32_t i = 1; i <= a->particles; i++)
            sum += fabs(at(a, k, i) - at(b, k, i)) / ((double)a->n * a->particles);
    return sum;
}

/* Against the lattice, the four taps of [B]'s five particles: the mean distance over the rows falls with the cells to
 * what the continuum itself leaves out, some hundredths of a centimetre as for the long wave. */
TEST(test_lattice) {
    double mean[3];
    rows exact;
    sp_tapped_spec c = sp_tapped_spec_default();
    c.taps = 4;
    run(&c, 400, &exact, NULL);
    for (int level = 0; level < 3; level++) {
        rows r;
        sp_tapped_spec d = bsr(SP_TAPPED_BSR_CONSERVATIVE);
        d.cells = 4 << level;
        run(&d, 400, &r, NULL);
        mean[level] = distance(&r, &exact);
        release(&r);
    }
    release(&exact);
    if (!(mean[0] > mean[1] && mean[1] > mean[2] && mean[0] < 0.14 && mean[1] < 0.1 && mean[2] < 0.085))
        fail_msg("mean distances %g %g %g cm", mean[0], mean[1], mean[2]);
}

/* And against the lattice with the same tanh, of more and more particles: about as 1/N. */
TEST(test_many) {
    double mean[3];
    for (int level = 0; level < 3; level++) {
        rows lattice, r;
        sp_tapped_spec c = sp_tapped_spec_default(), d = bsr(SP_TAPPED_BSR_CONSERVATIVE);
        c.particles = d.particles = 6 << level;
        c.frequency = d.frequency = 9.5;
        c.taps = d.taps = 1;
        c.method = SP_TAPPED_SMOOTH;
        run(&c, 100, &lattice, NULL);
        run(&d, 100, &r, NULL);
        mean[level] = distance(&r, &lattice);
        release(&lattice);
        release(&r);
    }
    if (!(log2(mean[0] / mean[2]) / 2 > 0.8 && mean[2] < 0.03))
        fail_msg("mean distances %g %g %g cm of 6, 12, 24 particles", mean[0], mean[1], mean[2]);
}

TEST(test_repeats) {
    sp_tapped_spec c = bsr(SP_TAPPED_BSR_CONSERVATIVE);
    for (int which = SP_TAPPED_BSR_CONSERVATIVE; which <= SP_TAPPED_BSR_SIGNED; which++) {
        rows all, few;
        c.bsr = (sp_tapped_bsr)which;
        c.taps = 2;
        c.period = 0.5;
        run(&c, 100, &all, NULL);
        run(&c, 25, &few, NULL); /* what rows are wanted changes nothing */
        for (int64_t k = 0; k <= 25; k++)
            for (int32_t i = 0; i <= c.particles; i++)
                assert_true(at(&few, k, i) == at(&all, 4 * k, i));
        release(&all);
        release(&few);
    }
}

/* The smallest number above 0 in a text. */
static double smallest_number(const char *text) {
    double smallest = INFINITY;
    while (*(text = text + strcspn(text, "0123456789"))) {
        char *end;
        const double number = strtod(text, &end);
        smallest = number > 0 ? fmin(smallest, number) : smallest;
        text = end;
    }
    return smallest;
}

TEST(test_refusals) {
    const double unequal[] = {1, 1.5};
    for (int which = SP_TAPPED_BSR_CONSERVATIVE; which <= SP_TAPPED_BSR_SIGNED; which++) {
        sp_tapped_spec c = bsr((sp_tapped_bsr)which);
        sp_tapped_report report;
        rows r;
        c.taps = 1;
        c.mass = unequal;
        c.masses = 2;
        assert_fails(try(&c, 10, &r, NULL, &err), SP_EINVAL, "column.mass 2 1.5");
        release(&r);
        c = bsr((sp_tapped_bsr)which);
        c.taps = 1;
        c.radius = unequal;
        c.radii = 2;
        assert_fails(try(&c, 10, &r, NULL, &err), SP_EINVAL, "column.radius 2 1.5");
        release(&r);
        c = bsr((sp_tapped_bsr)which);
        c.taps = 1;
        c.time_step = 0.01;
        assert_fails(try(&c, 10, &r, NULL, &err), SP_EINVAL, "column.time_step 0.01");
        release(&r);
        sp_error why = {0};
        assert_int_equal(try(&c, 10, &r, NULL, &why), SP_EINVAL);
        release(&r);
        c.time_step = smallest_number(why.text); /* the bound itself is allowed */
        assert_true(c.time_step > 1e-6 && c.time_step < 0.01);
        run(&c, 10, &r, &report);
        assert_close(report.time_step, c.time_step, 0);
        sp_tapped_report_free(&report);
        release(&r);
        c.time_step *= 1.001;
        assert_fails(try(&c, 10, &r, NULL, &err), SP_EINVAL, "column.time_step");
        release(&r);
    }
}

static sp_status ignore(double t, const double *y, const double *v, void *user, sp_error *err) {
    (void)t, (void)y, (void)v, (void)user, (void)err;
    return SP_OK;
}
static sp_status stop(double t, const double *y, const double *v, void *user, sp_error *err) {
    (void)y, (void)v, (void)user;
    return t > 0.05 ? sp_fail(err, SP_EINTERRUPTED, "enough") : SP_OK;
}

/* Lack of memory at any place, and rows that stop the run: a status, and nothing left behind. */
TEST(test_ends) {
    const double t[] = {0, 0.06, 0.09};
    for (int which = SP_TAPPED_BSR_CONSERVATIVE; which <= SP_TAPPED_BSR_SIGNED; which++) {
        sp_tapped_spec c = bsr((sp_tapped_bsr)which);
        c.taps = 1;
        c.period = 0.1;
        c.amplitude = 30; /* the grid has to grow */
        EACH_ALLOCATION_FAILS(2, sp_tapped_run(&c, 3, t, ignore, NULL, NULL, &err), );
        assert_fails(sp_tapped_run(&c, 3, t, stop, NULL, NULL, &err), SP_EINTERRUPTED, "enough");
    }
}

RUN_TESTS(NULL, NULL)
