/* The event-driven lattice: the numbers of an independent program, closed forms, balances, invariances. */
#include "test.h"

#include "column_runs.h"
#include "numeric/random.h"

static const double PI = 3.14159265358979323846;

/* Five particles of [B]: by a program that agrees with itself to nine digits under half the step and a higher order. */
TEST(test_reference) {
    const double expected[] = {0.499205348314, 2.093203277325, 3.784435777282, 5.576736210942, 7.474198032402};
    sp_tapped_spec c = sp_tapped_spec_default();
    FREED(column_rows) rows = column_run(&c, 1, 0.99, 0.99);
    for (int32_t i = 1; i <= 5; i++)
        assert_close(column_y(&rows, 0, i), expected[i - 1], 1e-9);
    assert_relative(rows.report.tap[0].work, 6994.497407, 1e-9);
    assert_relative(rows.report.tap[0].dissipated, 6993.618476, 1e-9);
    for (int32_t i = 0; i <= 5; i++) /* at rest by then, exactly */
        assert_true(column_v(&rows, 0, i) == 0);
    assert_true(rows.report.violated < 0 && isnan(rows.report.violated_at));
}

/* One ball that comes down onto the floor at 1 km/s with next to no gravity leaves at sqrt((1 - e)/(1 + e)) of it. */
TEST(test_restitution) {
    for (double e = 0; e < 0.999; e = e * 1.2 + 0.09) {
        sp_tapped_spec c = sp_tapped_spec_default();
        c.particles = 1;
        c.amplitude = 0;
        c.gravity = 1e-9;
        c.stiffness = 9806.7;
        c.e = e;
        FREED(sp_tapped_state) s;
        assert_ok(sp_tapped_state_make(&c, &s, &err));
        s.overlap[0] = -0.5;
        s.opening[0] = -1e5;
        assert_ok(sp_tapped_map(&c, &s, 1, NULL, &err));
        assert_close(s.opening[0] / 1e5, sqrt((1 - e) / (1 + e)), 1e-12);
        if (fabs(e - 0.09) < 1e-9)
            assert_close(s.opening[0] / 1e5, 0.913708041620, 1e-12);
    }
}

/* Dropped from 1 cm: up to 1.583734480. The peak by the parabola from a row in the flight. */
TEST(test_drop) {
    sp_tapped_spec c = sp_tapped_spec_default();
    c.particles = 1;
    c.amplitude = 0;
    c.drop = 1;
    c.taps = 1;
    FREED(column_rows) rows = column_run(&c, 2, 0.16, 0.18);
    for (int64_t k = 0; k < 2; k++) {
        double v = column_v(&rows, k, 1);
        assert_close(column_y(&rows, k, 1) + v * v / (2 * c.gravity), 1.583734480, 1e-9);
    }
}

/* e = 0: mode k of N balls on a floor at rest, a quarter of a period after it was let go, is at rest's positions.
 * Rounding of overlaps near 1 cm, over the amplitude: the frequency to 1e-12. */
TEST(test_elastic_modes) {
    const int32_t sizes[] = {1, 2, 5, 23};
    for (size_t n = 0; n < sizeof sizes / sizeof *sizes; n++)
        for (int32_t k = 1; k <= sizes[n]; k += 1 + sizes[n] / 4) {
            sp_tapped_spec c = sp_tapped_spec_default();
            c.particles = sizes[n];
            c.amplitude = 0;
            c.e = 0;
            FREED(sp_tapped_state) s, rest;
            assert_ok(sp_tapped_state_make(&c, &s, &err));
            assert_ok(sp_tapped_state_make(&c, &rest, &err));
            double angle = (2 * k - 1) * PI / (4 * sizes[n] + 2);
            double omega = 2 * sqrt(sp_tapped_stiffness(&c)) * sin(angle), size = 0.4 / sizes[n] / sizes[n];
            if (sizes[n] == 5 && k == 1)
                assert_close(omega, 28.186530672, 1e-9);
            for (int32_t i = 0; i < sizes[n]; i++)
                s.overlap[i] -= size * (sin(2 * angle * (i + 1)) - sin(2 * angle * i));
            c.period = PI / (2 * omega);
            assert_ok(sp_tapped_map(&c, &s, 1, NULL, &err));
            for (int32_t i = 0; i < sizes[n]; i++) {
                double speed = -omega * size * (sin(2 * angle * (i + 1)) - sin(2 * angle * i));
                assert_close(s.overlap[i], rest.overlap[i], 1e-12 * size * PI / 2 + 2e-15);
                assert_close(s.opening[i], speed, 1e-12 * omega * size + 4e-15 * omega);
            }
        }
}

static sp_tapped_spec random_spec(sp_random *r, int32_t most, double *mass, double *radius) {
    sp_tapped_spec c = sp_tapped_spec_default();
    c.particles = 1 + (int32_t)sp_random_below(r, (uint64_t)most);
    c.e = sp_random_uniform(r) < 0.1 ? 0 : 0.005 + 0.9 * sp_random_uniform(r) * sp_random_uniform(r);
    c.frequency = 4 + 26 * sp_random_uniform(r);
    c.period = 0.5 / c.frequency + sp_random_uniform(r);
    c.amplitude = 2 * sp_random_uniform(r) * 7.5 / c.frequency;
    c.taps = 3;
    if (mass) {
        c.masses = 1 + (int32_t)sp_random_below(r, 3);
        c.radii = 1 + (int32_t)sp_random_below(r, 3);
        for (int32_t k = 0; k < 3; k++) {
            mass[k] = 0.2 + 2 * sp_random_uniform(r);
            radius[k] = 0.5 + sp_random_uniform(r);
        }
        c.mass = mass;
        c.radius = radius;
    }
    double above = 1.05 + 8 * sp_random_uniform(r);
    c.stiffness = above * sp_tapped_stiffness_bound(&c);
    return c;
}

/* E - E0 = int F0 dy0 - sum int e K delta |w| dt, for equal and unequal particles, any e, f, T, a, K. */
TEST(test_energy_balance) {
    const uint64_t seed = 1106;
    sp_random r = sp_random_make(seed, 1);
    for (int k = 0; k < 60; k++) {
        double mass[3], radius[3];
        sp_tapped_spec c = random_spec(&r, k < 50 ? 30 : 150, k % 2 ? mass : NULL, radius);
        FREED(sp_tapped_report) report;
        assert_ok(sp_tapped_run(&c, 0, NULL, NULL, NULL, &report, &err));
        double before = report.initial_energy;
        for (int32_t tap = 0; tap < c.taps; tap++) {
            const sp_tapped_tap *t = report.tap + tap;
            double scale = fmax(fabs(t->work), t->dissipated);
            if (fabs(t->energy - before - t->work + t->dissipated) > 1e-9 * scale + 1e-14 * fabs(t->energy))
                fail_msg("seed %d, column %d: %d particles, e = %g: off by %g of %g", (int)seed, k, c.particles, c.e,
                         t->energy - before - t->work + t->dissipated, scale);
            assert_true(t->dissipated >= 0 && (c.e > 0 || t->dissipated == 0));
            before = t->energy;
        }
    }
}

/* Impacts of unlike balls on stiff contacts: forces are thousands of weights then, and what decides which contacts
 * stick must be judged by them. Energies round with the ratio of the masses. */
TEST(test_unlike_masses) {
    const uint64_t seed = 505;
    sp_random r = sp_random_make(seed, 1);
    for (int k = 0; k < 300; k++) {
        double mass[3], ratio = pow(10, 4 * sp_random_uniform(&r));
        for (int i = 0; i < 3; i++)
            mass[i] = 1.3 * pow(ratio, sp_random_uniform(&r));
        sp_tapped_spec c = sp_tapped_spec_default();
        c.particles = 2 + (int32_t)sp_random_below(&r, 4);
        c.masses = 2 + k % 2;
        c.mass = mass;
        c.e = k % 5 == 0 ? 0.9 : 0.01 + 0.5 * sp_random_uniform(&r);
        c.stiffness = sp_tapped_stiffness(&c) * pow(10, 1 + 6 * sp_random_uniform(&r));
        c.amplitude = 0;
        c.drop = 5 * sp_random_uniform(&r);
        c.taps = 1;
        c.period = 0.3;
        FREED(sp_tapped_report) report;
        sp_error err = {0};
        if (sp_tapped_run(&c, 0, NULL, NULL, NULL, &report, &err) != SP_OK)
            fail_msg("seed %d, column %d: %s", (int)seed, k, err.text);
        assert_close(report.tap[0].residual, 0, 1e-9);
    }
    const double pair[] = {1.3, 5}, far[] = {1.3, 40};
    sp_tapped_spec c = sp_tapped_spec_default();
    c.particles = c.masses = 2;
    c.amplitude = 0;
    c.drop = 4.7;
    c.taps = 1;
    for (int k = 0; k < 2; k++) {
        c.mass = k == 0 ? pair : far;
        c.e = k == 0 ? 0.9 : 0.09;
        c.stiffness = k == 0 ? 123564419999999.98 : 8100334199999.999;
        assert_ok(sp_tapped_run(&c, 0, NULL, NULL, NULL, NULL, &err));
    }
}

/* Any state within the band n_i M/(1 + e) .. n_i M/(1 - e) rests for ever, to the last bit; one outside does not. */
TEST(test_rest_states_are_a_band) {
    sp_random r = sp_random_make(3, 1);
    const int32_t sizes[] = {1, 5, 80, 300};
    for (size_t n = 0; n < sizeof sizes / sizeof *sizes; n++) {
        sp_tapped_spec c = sp_tapped_spec_default();
        c.particles = sizes[n];
        c.amplitude = 0;
        FREED(sp_tapped_state) s;
        assert_ok(sp_tapped_state_make(&c, &s, &err));
        double *kept = malloc((size_t)sizes[n] * sizeof *kept), unit = c.gravity / sp_tapped_stiffness(&c);
        assert_non_null(kept);
        for (int32_t i = 0; i < sizes[n]; i++) {
            double low = 1 / (1 + c.e), high = 1 / (1 - c.e);
            kept[i] = s.overlap[i] =
                (sizes[n] - i) * unit * (low + (high - low) * (0.001 + 0.998 * sp_random_uniform(&r)));
        }
        assert_ok(sp_tapped_map(&c, &s, 3, NULL, &err));
        for (int32_t i = 0; i < sizes[n]; i++)
            assert_true(s.overlap[i] == kept[i] && s.opening[i] == 0);
        s.overlap[sizes[n] - 1] = unit * 1.001 / (1 - c.e);
        assert_ok(sp_tapped_map(&c, &s, 1, NULL, &err));
        assert_true(s.overlap[sizes[n] - 1] < unit * 1.0005 / (1 - c.e));
        free(kept);
    }
}

/* Masses and stiffness doubled, or all lengths, change nothing but units; with powers of two, not a bit. */
TEST(test_units) {
    const double two = 2, four = 4;
    sp_tapped_spec c = sp_tapped_spec_default(), heavy, large;
    c.particles = 12;
    heavy = large = c;
    heavy.mass = &four;
    large.radius = &two;
    large.amplitude *= 2;
    large.gravity *= 2;
    column_rows a = column_run(&c, 50, 0, 4), b = column_run(&heavy, 50, 0, 4), d = column_run(&large, 50, 0, 4);
    for (int64_t k = 0; k < a.n; k++)
        for (int32_t i = 0; i < a.width; i++) {
            assert_close(column_y(&b, k, i), column_y(&a, k, i), 1e-11);
            assert_close(column_y(&d, k, i), 2 * column_y(&a, k, i), 1e-11);
        }
    column_rows_free(&a);
    column_rows_free(&b);
    column_rows_free(&d);
}

/* Rows are looked at, not steps made: more of them change nothing. */
TEST(test_rows_change_nothing) {
    sp_tapped_spec c = sp_tapped_spec_default();
    c.particles = 10;
    c.frequency = 9.5;
    column_rows few = column_run(&c, 5, 0, 4), many = column_run(&c, 4001, 0, 4);
    for (int64_t k = 0; k < few.n; k++)
        for (int32_t i = 0; i < few.width; i++)
            assert_true(column_y(&few, k, i) == column_y(&many, k * 1000, i));
    for (int64_t k = 1; k < many.n; k++) { /* velocities are those of the positions: y' within h max|y''|/2 */
        double h = many.t[k] - many.t[k - 1];
        for (int32_t i = 1; i < many.width; i++) {
            double v = 0.5 * (column_v(&many, k, i) + column_v(&many, k - 1, i));
            assert_close((column_y(&many, k, i) - column_y(&many, k - 1, i)) / h, v, 0.25 * h * 8e4);
        }
    }
    column_rows_free(&few);
    column_rows_free(&many);
}

/* [B]'s column at half the period: ordering (1) fails, -0.25 cm in the fourth tap. Without friction there is no event
 * where overlaps are largest. */
TEST(test_violations_are_reported) {
    for (int k = 0; k < 2; k++) {
        sp_tapped_spec c = sp_tapped_spec_default();
        c.period = 0.5;
        c.e = k == 0 ? 0.09 : 0;
        FREED(column_rows) rows = column_run(&c, 20001, 0, 2);
        const sp_tapped_tap *tap = rows.report.tap;
        if (k == 0)
            assert_close(tap[3].separation, -0.25, 0.005);
        int64_t first = 0;
        double least = 1;
        for (int64_t row = 0; row < rows.n; row++)
            for (int32_t i = 1; i < rows.width; i++) {
                double gap = column_y(&rows, row, i) - column_y(&rows, row, i - 1);
                first = first == 0 && gap < 0 ? row : first;
                if (row > 15000)
                    least = fmin(least, gap);
            }
        assert_true(rows.t[first - 1] <= rows.report.violated_at && rows.report.violated_at <= rows.t[first]);
        assert_close(tap[3].separation, least, 1e-4); /* rows are 1e-4 s apart */
        assert_true(tap[3].separation <= least);
    }
}

RUN_TESTS(NULL, NULL)
