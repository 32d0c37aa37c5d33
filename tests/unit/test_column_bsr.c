/* The BSR models: the printed integral and the one with signs, whose columns collapse; and the conservative one, which
 * carries its column. */
#include "column_runs.h"

static const double pi = 3.14159265358979323846;

/* n + 1 rows, equally spaced over all taps. */
static column_rows run(const sp_tapped_spec *c, int64_t n) {
    column_rows r = column_run(c, n + 1, 0, c->taps * c->period);
    for (int64_t k = 0; k < r.n * r.width; k++)
        assert_true(isfinite(r.y[k]) && isfinite(r.v[k]));
    return r;
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
            c.particles = 10;
            c.amplitude = c.e = 0;
            c.taps = 1;
            c.period = 0.06;
            c.cells = 8 << level;
            FREED(column_rows) r = run(&c, 6);
            error[level] = 0;
            for (int32_t i = 5; i <= 10; i++)
                error[level] =
                    fmax(error[level], fabs(column_y(&r, 6, i) - characteristic(&c, column_y(&r, 0, i), 0.06,
                                                                                which == SP_TAPPED_BSR_LITERAL)));
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
            c.particles = n;
            FREED(column_rows) r = run(&c, 100);
            assert_int_equal(r.report.violated, 0);
            assert_true(r.report.violated_at > 0 && r.report.violated_at < 0.1);
            assert_true(r.report.tap[0].separation < 0);
            for (int32_t i = 1; i <= n; i++) {
                assert_true(column_y(&r, 100, i) < -1000);
                double gained = column_v(&r, 100, i) - column_v(&r, 75, i);
                assert_relative(gained, -c.gravity, 1e-9);
            }
        }
}

/* However large alpha_v, sigma asks for no shorter steps. */
TEST(test_stiff_sigma) {
    for (int which = SP_TAPPED_BSR_CONSERVATIVE; which <= SP_TAPPED_BSR_SIGNED; which++) {
        sp_tapped_spec c = bsr((sp_tapped_bsr)which);
        c.alpha_v = 1e9;
        c.e = 0.99;
        FREED(column_rows) r = run(&c, 40);
        assert_true(r.report.steps < 20000);
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
            c.particles = counts[k];
            c.amplitude = 0;
            c.taps = 1;
            c.cells = 4 << level;
            FREED(column_rows) r = run(&c, 50);
            sp_tapped_rest(&c, rest);
            double n = c.particles, sag = c.gravity / sp_tapped_stiffness(&c);
            drift[level] = 0;
            for (int32_t i = 1; i <= c.particles; i++) {
                double j = i - 0.5, expected = 2 * j - j * (n - j / 2) * sag - n * sag / 2;
                /* within a cell the density is taken as constant: less than rho_z/rho dx^2/8, sag/s^2 < 1/4 */
                double near = 0.25 / (c.cells * c.cells) * 4 / 8;
                assert_close(column_y(&r, 0, i), expected, near);
                assert_close(expected - rest[i - 1], sag / 8, 1e-12);
                drift[level] = fmax(drift[level], fabs(column_y(&r, 50, i) - column_y(&r, 0, i)));
            }
            assert_true(r.report.error < 1e-13);
            assert_int_equal(r.report.violated, -1);
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
            c.particles = counts[k];
            c.amplitude = amplitudes[a];
            c.taps = 3;
            c.period = 0.4;
            FREED(column_rows) r = run(&c, 120);
            assert_true(r.report.error < 1e-13);
            assert_true(r.report.steps > 100);
            for (int64_t row = 0; row <= 120; row++) {
                assert_close(column_y(&r, row, 0), sp_tapped_floor(&c, r.t[row]), 0);
                for (int32_t i = 1; i < c.particles; i++)
                    assert_true(column_y(&r, row, i + 1) > column_y(&r, row, i));
                assert_true(column_y(&r, row, c.particles) < 1e3);
            }
        }
}

/* A column let go falls as one, exactly: the grid falls with it. */
TEST(test_free_fall) {
    sp_tapped_spec c = bsr(SP_TAPPED_BSR_CONSERVATIVE);
    c.particles = 7;
    c.amplitude = 0;
    c.drop = 20;
    c.taps = 1;
    c.period = 0.2; /* it would be down at sqrt(2 * 20/g) = 0.20196 s */
    FREED(column_rows) r = run(&c, 20);
    for (int64_t k = 0; k <= 20; k++)
        for (int32_t i = 1; i <= 7; i++) {
            double t = r.t[k];
            assert_close(column_y(&r, k, i), 20 + 2 * i - 1 - c.gravity * t * t / 2, 1e-10);
            assert_close(column_v(&r, k, i), -c.gravity * t, 1e-9);
        }
}

/* Momentum: a column in flight, compressed below and loose above, has nothing but gravity. The mean of its forty
 * particles stands for the centre of mass, by a midpoint rule. */
TEST(test_flight) {
    sp_tapped_spec c = bsr(SP_TAPPED_BSR_CONSERVATIVE);
    c.particles = 40;
    c.amplitude = 8;
    c.taps = 1;
    c.period = 0.1;
    FREED(column_rows) r = run(&c, 20);
    double mean[3] = {0};
    for (int k = 0; k < 3; k++) {
        int64_t row = 11 + 2 * k; /* 0.055, 0.065, 0.075 s */
        assert_true(column_y(&r, row, 1) - column_y(&r, row, 0) > 1.5);
        for (int32_t i = 1; i <= 40; i++)
            mean[k] += column_y(&r, row, i) / 40;
    }
    double most = 0; /* it does not fly as one */
    for (int32_t i = 1; i <= 40; i++)
        most =
            fmax(most, fabs((column_y(&r, 15, i) - 2 * column_y(&r, 13, i) + column_y(&r, 11, i)) / 1e-4 + c.gravity));
    assert_true(most > 0.1 * c.gravity);
    assert_relative((mean[2] - 2 * mean[1] + mean[0]) / 1e-4, -c.gravity, 0.01);
}

/* Against the lattice, the four taps of [B]'s five particles: the mean distance over the rows falls with the cells to
 * what the continuum itself leaves out, some hundredths of a centimetre as for the long wave. */
TEST(test_lattice) {
    double mean[3];
    sp_tapped_spec c = sp_tapped_spec_default();
    c.taps = 4;
    column_rows exact = run(&c, 400);
    for (int level = 0; level < 3; level++) {
        sp_tapped_spec d = bsr(SP_TAPPED_BSR_CONSERVATIVE);
        d.cells = 4 << level;
        FREED(column_rows) r = run(&d, 400);
        mean[level] = column_mean(&r, &exact);
    }
    column_rows_free(&exact);
    if (!(mean[0] > mean[1] && mean[1] > mean[2] && mean[0] < 0.14 && mean[1] < 0.1 && mean[2] < 0.085))
        fail_msg("mean distances %g %g %g cm", mean[0], mean[1], mean[2]);
}

TEST(test_repeats) {
    sp_tapped_spec c = bsr(SP_TAPPED_BSR_CONSERVATIVE);
    for (int which = SP_TAPPED_BSR_CONSERVATIVE; which <= SP_TAPPED_BSR_SIGNED; which++) {
        c.bsr = (sp_tapped_bsr)which;
        c.taps = 2;
        c.period = 0.5;
        FREED(column_rows) all = run(&c, 100);
        FREED(column_rows) few = run(&c, 25); /* what rows are wanted changes nothing */
        for (int64_t k = 0; k <= 25; k++)
            for (int32_t i = 0; i <= c.particles; i++)
                assert_true(column_y(&few, k, i) == column_y(&all, 4 * k, i));
    }
}

RUN_TESTS(NULL, NULL)
