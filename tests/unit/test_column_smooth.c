/* The lattice with smooth sigma and chi, and by plain Runge-Kutta steps, against what the sharp law gives. */
#include "column_runs.h"

static sp_tapped_spec lattice(sp_tapped_method method) {
    sp_tapped_spec c = sp_tapped_spec_default();
    c.method = method;
    c.taps = 1;
    return c;
}

/* K = 2 m g/r by default for one particle. Height of the next peak, from energies in flight. */
static double peak(const sp_tapped_spec *c, double t) {
    column_rows rows = column_run(c, 1, t, t);
    const double y = column_y(&rows, 0, 1), v = column_v(&rows, 0, 1);
    assert_true(y > 1); /* in flight */
    column_rows_free(&rows);
    return y + v * v / (2 * c->gravity);
}

static sp_tapped_spec dropped(double e) {
    sp_tapped_spec c = lattice(SP_TAPPED_SMOOTH);
    c.particles = 1;
    c.amplitude = 0;
    c.drop = 1;
    c.e = e;
    return c;
}

/* Without e the ball comes back to where it fell from. A step may err by the tolerance of 2 sqrt(2 g), at 44 cm/s four
 * times it in height; ten steps in contact; and ten times that where a step has the kink at contact in it, of which the
 * difference of the two orders sees a part. */
TEST(test_elastic_drop) {
    sp_tapped_spec c = dropped(0);
    for (c.tolerance = 1e-5; c.tolerance > 1e-13; c.tolerance *= 1e-2) {
        const double off = peak(&c, 0.16) - 2;
        print_message("tolerance %.0e: %.1e\n", c.tolerance, off);
        assert_close(off, 0, 400 * c.tolerance);
    }
}

/* With e it comes back to 1.583734480 cm as alpha_v grows (the value is that of the sharp law, to all digits): at the
 * turning point the force lacks tanh(alpha_v v) while |v| < 1/alpha_v, for a time that falls like 1/alpha_v, at a
 * velocity that does so, too. */
TEST(test_drop_nears_the_sharp_law) {
    sp_tapped_spec c = dropped(0.09);
    enum { RUNS = 5 };
    double alpha[RUNS], error[RUNS];
    for (int q = 0; q < RUNS; q++) {
        c.alpha_v = alpha[q] = pow(10, q * 0.5 - 0.5);
        c.tolerance = 1e-12;
        error[q] = fabs(peak(&c, 0.16) - 1.583734480);
    }
    const double order = column_order(RUNS, alpha, error);
    print_message("error of a rebound like alpha_v^%.2f, %.1e at alpha_v = %g\n", order, error[RUNS - 1],
                  alpha[RUNS - 1]);
    assert_close(order, -2, 0.2);
}

/* A column: contacts that the sharp law holds creep, at velocities like 1/alpha_v. */
TEST(test_column_nears_the_events) {
    sp_tapped_spec c = lattice(SP_TAPPED_EVENT);
    enum { RUNS = 5 };
    double alpha[RUNS], work[RUNS], error[RUNS];
    FREED(column_rows) exact = column_run(&c, 41, 0, 0.2);
    assert_close(exact.report.tap[0].work, 6994.497407, 1e-5); /* an independent reference */
    c.method = SP_TAPPED_SMOOTH;
    for (int q = 0; q < RUNS; q++) {
        c.alpha_v = alpha[q] = pow(10, q * 0.5 + 0.5);
        FREED(column_rows) smooth = column_run(&c, 41, 0, 0.2);
        error[q] = column_mean(&smooth, &exact);
        work[q] = fabs(smooth.report.tap[0].work - exact.report.tap[0].work);
    }
    print_message("like alpha_v^%.2f (positions), alpha_v^%.2f (work); %.1e cm at alpha_v = %g\n",
                  column_order(RUNS, alpha, error), column_order(RUNS, alpha, work), error[RUNS - 1], alpha[RUNS - 1]);
    assert_close(column_order(RUNS, alpha, error), -1, 0.3);
    assert_close(column_order(RUNS, alpha, work), -1, 0.3);
}

static const double masses[] = {1, 0.7, 1.3}, radii[] = {1, 0.8};

/* Unequal particles rest in the like of (27). */
TEST(test_rests) {
    sp_tapped_spec c = lattice(SP_TAPPED_SMOOTH);
    c.particles = 7;
    c.amplitude = 0;
    c.taps = 3;
    c.masses = 3;
    c.mass = masses;
    c.radii = 2;
    c.radius = radii;
    for (int method = 0; method < 2; method++) {
        c.method = method ? SP_TAPPED_RK4 : SP_TAPPED_SMOOTH;
        FREED(column_rows) rows = column_run(&c, 10, 0, 3);
        double rest[7];
        sp_tapped_rest(&c, rest);
        /* RK4: by rounding a sign now and then, which is worth a step's e K delta/m dt^2 = 1e-5 cm */
        for (int64_t k = 0; k < 10; k++)
            for (int32_t i = 1; i <= 7; i++)
                assert_close(column_y(&rows, k, i), rest[i - 1], method ? 1e-3 : 1e-11);
    }
}

/* E - E0 = work - dissipated, with chi sharp or smooth (whose energy has a dilogarithm), to the tolerance. */
TEST(test_energy) {
    sp_tapped_spec c = lattice(SP_TAPPED_SMOOTH);
    c.masses = 3;
    c.mass = masses;
    c.radii = 2;
    c.radius = radii;
    c.taps = 2;
    for (int q = 0; q < 4; q++) {
        c.alpha_x = (const double[]){0, 3, 30, 300}[q];
        for (c.tolerance = 1e-6; c.tolerance > 1e-11; c.tolerance *= 1e-2) {
            FREED(column_rows) rows = column_run(&c, 1, 0, 0);
            for (int k = 0; k < 2; k++) {
                const sp_tapped_tap *tap = &rows.report.tap[k];
                assert_true(tap->work > 100 && tap->dissipated > 100 && isnan(tap->rest));
                assert_close(tap->residual, 0, 300 * c.tolerance); /* some 300 periods of the fastest mode */
            }
        }
    }
}

/* The smallest separation and the first violation, as the events have them. */
TEST(test_separation) {
    sp_tapped_spec c = lattice(SP_TAPPED_EVENT);
    c.particles = 1;
    FREED(column_rows) exact = column_run(&c, 1, 0, 0);
    c.method = SP_TAPPED_SMOOTH;
    c.alpha_v = 1000;
    FREED(column_rows) smooth = column_run(&c, 1, 0, 0);
    const sp_tapped_tap *a = &exact.report.tap[0], *b = &smooth.report.tap[0];
    assert_true(a->separation < 0); /* (28) is no bound for what taps do */
    assert_close(b->separation, a->separation, 1e-4);
    assert_close(b->at, a->at, 2e-3);
    assert_int_equal(b->contact, a->contact);
    assert_close(smooth.report.violated_at, exact.report.violated_at, 1e-4);
    assert_int_equal(smooth.report.violated, 0);
}

/* Plain Runge-Kutta of order 4 is of order 1 here. */
TEST(test_rk4_is_of_first_order) {
    sp_tapped_spec c = lattice(SP_TAPPED_EVENT);
    FREED(column_rows) exact = column_run(&c, 41, 0, 0.2);
    c.method = SP_TAPPED_RK4;
    enum { RUNS = 8 };
    double step[RUNS], error[RUNS];
    for (int q = 0; q < RUNS; q++) {
        c.time_step = step[q] = 1e-3 / (1 << q);
        FREED(column_rows) fixed = column_run(&c, 41, 0, 0.2);
        assert_close(fixed.report.time_step, step[q], 0.05 * step[q]);
        error[q] = column_mean(&fixed, &exact);
    }
    print_message("error like dt^%.2f, %.1e cm at dt = %.1e s\n", column_order(RUNS, step, error), error[RUNS - 1],
                  step[RUNS - 1]);
    assert_close(column_order(RUNS, step, error), 1, 0.35);
}

/* After a tap one ball sticks at y = 0.4545, within the band of rest; plain steps let it creep towards (27)'s 0.5. */
TEST(test_rk4_creeps) {
    sp_tapped_spec c = lattice(SP_TAPPED_EVENT);
    c.particles = 1;
    c.period = 4;
    FREED(column_rows) exact = column_run(&c, 2, 2, 4);
    c.method = SP_TAPPED_RK4;
    FREED(column_rows) fixed = column_run(&c, 2, 2, 4);
    c.time_step = fixed.report.time_step / 8;
    FREED(column_rows) finer = column_run(&c, 2, 2, 4);
    const double crept = column_y(&fixed, 1, 1) - column_y(&fixed, 0, 1),
                 less = column_y(&finer, 1, 1) - column_y(&finer, 0, 1);
    print_message("creeps %.1e cm in 2 s, %.1e with an eighth of the step\n", crept, less);
    assert_close(column_y(&exact, 1, 1), column_y(&exact, 0, 1), 1e-14);
    assert_true(crept > 1e-3 && less > 1e-4 && less < 0.4 * crept);
}

/* Taps end and floors stop between steps, whatever their length: rows on both sides of the jumps. */
TEST(test_floor) {
    for (int method = 0; method < 2; method++) {
        sp_tapped_spec c = lattice(method ? SP_TAPPED_RK4 : SP_TAPPED_SMOOTH);
        c.taps = 3;
        c.period = 0.1;
        c.particles = 2;
        FREED(column_rows) rows = column_run(&c, 301, 0, 0.3);
        for (int64_t k = 0; k < 301; k++) {
            assert_close(column_y(&rows, k, 0), sp_tapped_floor(&c, rows.t[k]), 0);
            assert_close(column_v(&rows, k, 0), sp_tapped_floor_velocity(&c, rows.t[k]), 0);
            /* v is y's derivative: a few 1e4 cm/s^2 times a millisecond off the middle's */
            for (int32_t i = 1; i <= 2 && k > 0; i++)
                assert_close((column_y(&rows, k, i) - column_y(&rows, k - 1, i)) * 1e3,
                             0.5 * (column_v(&rows, k, i) + column_v(&rows, k - 1, i)), 1);
        }
    }
}

RUN_TESTS(NULL, NULL)
