/* The long wave: rest, orders of convergence, dispersion, energy, and the lattice that it stands for. */
#include "column_runs.h"

static sp_tapped_spec longwave(void) {
    sp_tapped_spec c = sp_tapped_spec_default();
    c.model = SP_TAPPED_LONGWAVE;
    c.taps = 1;
    return c;
}

/* [B]'s ten particles with taps so small that no contact opens: all is smooth between the floor's jumps. */
static sp_tapped_spec gentle(void) {
    sp_tapped_spec c = longwave();
    c.particles = 10;
    c.frequency = 9.5;
    c.amplitude = 0.005;
    return c;
}

/* Rounding of heights up to 20 makes forces of K h/dz 4e-15, a 1e-13 of the weight; it drives nothing. */
TEST(test_untapped_stays) {
    for (int32_t n = 1; n <= 10; n += 3)
        for (int32_t cells = 1; cells <= 8; cells += cells == 1 ? 2 : 5) {
            sp_tapped_spec c = longwave();
            c.particles = n;
            c.cells = cells;
            c.amplitude = 0;
            c.taps = 5;
            double rest[10];
            sp_tapped_rest(&c, rest);
            FREED(column_rows) rows = column_run(&c, 50, 0, 5);
            for (int64_t k = 0; k < 50; k++)
                for (int32_t i = 1; i <= n; i++) {
                    /* M/8 above (27), M = r/(2 N); a chord is as much above the parabola, where one cell is all */
                    const double off = (n * cells > 1 ? 1 : 2) / (16.0 * n);
                    assert_close(column_y(&rows, k, i), rest[i - 1] + off, 2e-13);
                    assert_close(column_v(&rows, k, i), 0, 1e-11);
                }
            assert_close(rows.report.tap[4].work, 0, 0);
            assert_true(isnan(rows.report.violated_at));
            assert_int_equal(rows.report.violated, -1);
        }
}

/* Free fall of all labels, exactly, until the floor. */
TEST(test_falls_freely) {
    sp_tapped_spec c = longwave();
    c.amplitude = 0;
    c.drop = 2;
    FREED(column_rows) rows = column_run(&c, 20, 0, 0.06);
    for (int64_t k = 0; k < 20; k++)
        for (int32_t i = 1; i <= 5; i++) {
            const double t = rows.t[k];
            assert_close(column_y(&rows, k, i), 2 + 2 * i - 1 - 0.5 * c.gravity * t * t, 1e-11);
            assert_close(column_v(&rows, k, i), -c.gravity * t, 1e-10);
        }
}

/* Errors against the finest of a row of runs, each twice as fine as the one before. */
static double order_of(sp_tapped_spec c, int runs, bool in_time, double first) {
    enum { ROWS = 50, MOST = 8 };
    column_rows rows[MOST];
    double size[MOST], error[MOST];
    c.period = 0.5;
    for (int q = 0; q < runs; q++) {
        size[q] = 1.0 / (1 << q);
        if (in_time)
            c.time_step = first * size[q];
        else
            c.cells = (int32_t)(first / size[q]);
        rows[q] = column_run(&c, ROWS, 0, 0.5);
    }
    for (int q = 0; q < runs; q++)
        error[q] = column_mean(&rows[q], &rows[runs - 1]);
    for (int q = 0; q < runs; q++)
        column_rows_free(&rows[q]);
    return column_order(runs - 1, size, error);
}

/* Linear elements: order 2, and 1 to 2 where contacts open and close, at places that no grid knows. The last run stands
 * for the limit, which bends the line upwards: by 0.3 at most over four halvings of order 1 (ln 2/ln 8). */
TEST(test_order_in_cells) {
    SKIP_SANITIZED();
    sp_tapped_spec c = gentle();
    c.time_step = 5e-5; /* errors of 1e-9, a hundredth of the finest grid's */
    const double smooth = order_of(c, 5, false, 2), rough = order_of(longwave(), 6, false, 1);
    print_message("order in the grid: %.2f gentle, %.2f violent\n", smooth, rough);
    assert_close(smooth, 2.15, 0.3);
    assert_true(rough > 0.9 && rough < 2.5);
}

/* Runge-Kutta of order 4, and at least 2 where contacts open and close: (1 - y_z)_+ has a kink. Steps that are whole
 * over one jump of the floor and not over the other would be of order 1. */
TEST(test_order_in_time) {
    SKIP_SANITIZED();
    const double smooth = order_of(gentle(), 4, true, 1e-4), rough = order_of(longwave(), 5, true, 1e-4);
    print_message("order in time: %.2f gentle, %.2f violent\n", smooth, rough);
    assert_true(smooth > 3.8);
    assert_true(rough > 1.6 && rough < 4);
}

/* |sum over the record of window v exp(-i omega t)|. */
static double line(const column_rows *rows, double omega) {
    double re = 0, im = 0;
    for (int64_t k = 0; k < rows->n; k++) {
        const double window = 1 - cos(2 * acos(-1) * (double)k / (double)(rows->n - 1));
        re += window * column_v(rows, k, 5) * cos(omega * rows->t[k]);
        im += window * column_v(rows, k, 5) * sin(omega * rows->t[k]);
    }
    return hypot(re, im);
}

/* Standing waves without e, u = cos k (L - z), have u_z = 0 at the free top and, by omega^2 = c^2 k^2/(1 + (k h)^2/12),
 * k h tan k L = 2 (1 + (k h)^2/12) at the floor. A short small tap rings them; the spectrum of the top particle's
 * velocity over 9.9 s (lines 0.6/s apart) peaks at them. Without dispersion the third would be 15 percent off. */
TEST(test_dispersion) {
    sp_tapped_spec c = longwave();
    c.e = 0;
    c.alpha_v = 0.1;
    c.cells = 24;
    c.frequency = 30;
    c.amplitude = 0.001;
    c.period = 10;
    FREED(column_rows) rows = column_run(&c, 2000, 0.1, 10);
    const double pi = acos(-1);
    for (int n = 0; n < 3; n++) {
        double low = n * pi / 5, high = (n + 0.5) * pi / 5; /* k h, as L = 5 h: k L between n pi and (n + 1/2) pi */
        for (int q = 0; q < 100; q++) {
            const double x = 0.5 * (low + high);
            if (x * tan(5 * x) < 2 * (1 + x * x / 12))
                low = x;
            else
                high = x;
        }
        const double omega = sqrt(9806.7) * low / sqrt(1 + low * low / 12);
        double best = 0, at = 0;
        for (double other = omega - 1.5; other < omega + 1.5; other += 0.01)
            if (line(&rows, other) > best) {
                best = line(&rows, other);
                at = other;
            }
        assert_relative(at, omega, 1e-3);
        assert_true(best > 3 * line(&rows, omega + 1.5)); /* a peak, not an edge */
    }
}

/* Work - dissipation is the gain of energy, at the order of the steps; without e nothing is lost, with e never gained.
 */
TEST(test_energy) {
    for (int part = 0; part < 2; part++) {
        sp_tapped_spec c = longwave();
        c.e = part ? 0.09 : 0;
        c.taps = 2;
        double residual[2];
        for (int q = 0; q < 2; q++) {
            c.time_step = q ? 2e-5 : 2e-4;
            FREED(column_rows) rows = column_run(&c, 1, 0, 0);
            const sp_tapped_tap *tap = rows.report.tap;
            assert_true(part ? tap[0].dissipated > 0 && tap[1].dissipated > 0 : tap[1].dissipated == 0);
            assert_true(tap[0].work > 0);
            residual[q] = fabs(tap[0].residual) + fabs(tap[1].residual);
            assert_close(tap[0].energy - rows.report.initial_energy - tap[0].work + tap[0].dissipated, 0,
                         1.01 * residual[q] * fmax(tap[0].work, tap[0].dissipated));
        }
        print_message("residual of the energy: %.1e, %.1e\n", residual[0], residual[1]);
        assert_true(residual[0] < 5e-3 && residual[1] < 5e-5);
    }
}

/* Mean distance from the lattice with the same tanh while the column moves, [0, 0.5 s] of a tap: it falls with N. */
TEST(test_nears_the_lattice) {
    SKIP_SANITIZED();
    const double bound[] = {0.15, 0.06, 0.025};
    double before = INFINITY;
    for (int q = 0; q < 3; q++) {
        sp_tapped_spec c = longwave();
        c.particles = 5 << q;
        c.frequency = q ? 9.5 : 7.5;
        FREED(column_rows) wave = column_run(&c, 51, 0, 0.5);
        c.model = SP_TAPPED_LATTICE;
        c.method = SP_TAPPED_SMOOTH;
        FREED(column_rows) lattice = column_run(&c, 51, 0, 0.5);
        const double mean = column_mean(&wave, &lattice);
        print_message("N = %d: %.4f cm\n", c.particles, mean);
        assert_true(mean < bound[q] && mean < 0.7 * before && mean > 0);
        before = mean;
    }
}

/* Rows are looked at, not stepped to. */
TEST(test_rows_change_nothing) {
    sp_tapped_spec c = longwave();
    c.particles = 3;
    column_rows few = column_run(&c, 3, 0, 1), many = column_run(&c, 401, 0, 1);
    for (int64_t k = 0; k < 3; k++)
        for (int32_t i = 0; i <= 3; i++) {
            assert_close(column_y(&few, k, i), column_y(&many, 200 * k, i), 0);
            assert_close(column_v(&few, k, i), column_v(&many, 200 * k, i), 0);
        }
    assert_close(few.report.tap[0].energy, many.report.tap[0].energy, 0);
    column_rows_free(&few);
    column_rows_free(&many);
}

/* At the bound for elastic waves rounding must not grow, whatever the grid; at 0.8/sqrt(K/m) it does, with 8
 * cells or more, for the floor's spring adds to the highest frequency. */
TEST(test_stable_up_to_the_bound) {
    sp_tapped_spec c = longwave();
    c.amplitude = 0;
    c.taps = 5;
    c.e = 0;
    const double bound = sqrt(8 / (6 + 2 * sqrt(21)) / 9806.7), rest = 7.5 + 0.1 / 8;
    for (c.cells = 2; c.cells <= 32; c.cells *= 4) {
        c.time_step = 0.9999 * bound;
        FREED(column_rows) rows = column_run(&c, 200, 0, 5);
        for (int64_t k = 0; k < 200; k++)
            assert_close(column_y(&rows, k, 5), rest, 1e-12);
    }
    c.time_step = 0.8 / sqrt(9806.7);
    const double t = 0;
    column_rows unused = {.width = 6};
    assert_fails(sp_tapped_run(&c, 1, &t, column_keep, &unused, NULL, &err), SP_EINVAL, "column.time_step");
}

/* With friction the steps follow the overlap, and stay stable far beyond the alpha_v that the elastic bound allows. */
TEST(test_damped_steps) {
    sp_tapped_spec c = longwave();
    c.alpha_v = 10;
    c.e = 0.5;
    FREED(column_rows) rows = column_run(&c, 1, 0.99, 0.99);
    assert_true(rows.report.time_step < 2.5 / (12 * 9806.7 * 0.5 * 10 * 1)); /* delta = 1 cm at the floor at rest */
    assert_true(fabs(rows.report.tap[0].residual) < 1e-5);
    for (int32_t i = 1; i <= 5; i++)
        assert_close(column_y(&rows, 0, i), 2 * i - 1 - 0.05 * i * (11 - i), 0.1); /* near (27) again */
}

RUN_TESTS(NULL, NULL)
