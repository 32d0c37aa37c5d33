/* The map from tap to tap: its derivative, exact multipliers, exponents, diagrams. */
#include "test.h"

#include "column_runs.h"
#include "tapped/column.h"

static sp_tapped_spec one_particle(double period) {
    sp_tapped_spec c = sp_tapped_spec_default();
    c.particles = 1;
    c.period = period;
    return c;
}

/* The fixed point at T = 0.2 s, and its multipliers by the product over turning points. */
TEST(test_floquet) {
    sp_tapped_spec c = one_particle(0.2);
    FREED(sp_tapped_state) s;
    double d[4], y, v;
    assert_ok(sp_tapped_state_make(&c, &s, &err));
    assert_ok(sp_tapped_map(&c, &s, 300, NULL, &err));
    sp_tapped_positions(&c, &s, &y, &v);
    assert_close(y, 1.147749316, 1e-9);
    assert_close(v, 17.526667496, 1e-8);
    assert_ok(sp_tapped_map(&c, &s, 1, d, &err));
    assert_close(d[0] * d[3] - d[1] * d[2], 0.688060, 1e-6);
    assert_close(d[0] + d[3], 0.385857, 1e-6);
    sp_tapped_exponent found;
    assert_ok(sp_tapped_lyapunov(&c, &found, &err));
    assert_close(found.lambda, 0.5 * log(d[0] * d[3] - d[1] * d[2]), 1e-12);
    assert_close(found.lambda, -0.18694, 1e-6);
    assert_int_equal(found.cycle, 1);
}

/* The same number by the growth of a tangent, without the multipliers: an orbit that is cut off before it closes. */
TEST(test_average_agrees_with_multipliers) {
    sp_tapped_spec c = one_particle(0.2);
    c.transient = 40; /* closed to 1e-4 only */
    c.taps = 3000;
    sp_tapped_exponent found;
    assert_ok(sp_tapped_lyapunov(&c, &found, &err));
    assert_int_equal(found.cycle, 0);
    assert_close(found.lambda, -0.186939787, 1e-6);
    assert_true(found.error < 1e-4);
}

TEST(test_period_two) {
    sp_tapped_spec c = one_particle(0.7);
    FREED(sp_tapped_state) s;
    assert_ok(sp_tapped_state_make(&c, &s, &err));
    assert_ok(sp_tapped_map(&c, &s, 300, NULL, &err));
    double first = s.overlap[0];
    assert_ok(sp_tapped_map(&c, &s, 1, NULL, &err));
    assert_true(fabs(s.overlap[0] - first) > 1e-3);
    assert_ok(sp_tapped_map(&c, &s, 1, NULL, &err));
    assert_close(s.overlap[0], first, 1e-10);
    sp_tapped_exponent found;
    assert_ok(sp_tapped_lyapunov(&c, &found, &err));
    assert_int_equal(found.cycle, 2);
    assert_true(found.lambda < 0);
    assert_true(found.error >= 1e-13 && found.error < 1e-9); /* the rounds of a cycle often agree to the last bit */
}

static double shifted(const sp_tapped_spec *c, const sp_tapped_state *s, int32_t k, double h, int32_t row) {
    FREED(sp_tapped_state) p;
    assert_ok(sp_tapped_state_make(c, &p, &err));
    memcpy(p.overlap, s->overlap, (size_t)c->particles * sizeof(double));
    memcpy(p.opening, s->opening, (size_t)c->particles * sizeof(double));
    *(k < c->particles ? p.overlap + k : p.opening + k - c->particles) += h;
    assert_ok(sp_tapped_map(c, &p, 1, NULL, &err));
    double value = row < c->particles ? p.overlap[row] : p.opening[row - c->particles];
    return value;
}

/* Saltations included: against central differences, wherever no event comes or goes within h. */
TEST(test_derivative) {
    const int32_t sizes[] = {1, 2, 3, 6};
    for (size_t n = 0; n < 4; n++) {
        sp_tapped_spec c = one_particle(0.2);
        c.particles = sizes[n];
        int32_t dof = 2 * sizes[n];
        FREED(sp_tapped_state) s, after;
        double *d = malloc((size_t)(dof * dof) * sizeof *d), most = 0;
        assert_non_null(d);
        assert_ok(sp_tapped_state_make(&c, &s, &err));
        assert_ok(sp_tapped_state_make(&c, &after, &err));
        assert_ok(sp_tapped_map(&c, &s, 60, NULL, &err));
        memcpy(after.overlap, s.overlap, (size_t)sizes[n] * sizeof(double));
        memcpy(after.opening, s.opening, (size_t)sizes[n] * sizeof(double));
        assert_ok(sp_tapped_map(&c, &after, 1, d, &err));
        for (int32_t k = 0; k < dof * dof; k++)
            most = fmax(most, fabs(d[k]));
        const double h = 1e-7;
        for (int32_t k = 0; k < dof; k++)
            for (int32_t row = 0; row < dof; row++)
                assert_close(d[row * dof + k], (shifted(&c, &s, k, h, row) - shifted(&c, &s, k, -h, row)) / (2 * h),
                             2e-6 * most);
        free(d);
    }
}

/* Two taps are one tap and one more; what a run gives at the end of a tap is what the map gives. */
TEST(test_map_is_the_run) {
    sp_tapped_spec c = sp_tapped_spec_default();
    c.particles = 7;
    c.period = 0.31;
    c.taps = 5;
    FREED(sp_tapped_state) once, twice;
    assert_ok(sp_tapped_state_make(&c, &once, &err));
    assert_ok(sp_tapped_state_make(&c, &twice, &err));
    assert_ok(sp_tapped_map(&c, &once, 5, NULL, &err));
    for (int k = 0; k < 5; k++)
        assert_ok(sp_tapped_map(&c, &twice, 1, NULL, &err));
    FREED(column_rows) rows = column_run(&c, 1, 5 * c.period, 5 * c.period);
    double y[7], v[7];
    sp_tapped_positions(&c, &once, y, v);
    for (int32_t i = 0; i < 7; i++) {
        assert_close(twice.overlap[i], once.overlap[i], 1e-11);
        assert_close(y[i], column_y(&rows, 0, i + 1), 1e-11);
        assert_close(v[i], column_v(&rows, 0, i + 1), 1e-8);
    }
}

/* [B]'s settings are not chaotic; one ball tapped every 0.15 s is. */
TEST(test_order_and_chaos) {
    sp_tapped_exponent found;
    for (int32_t n = 5; n <= 10; n += 5) {
        sp_tapped_spec c = sp_tapped_spec_default();
        c.particles = n;
        c.frequency = n == 5 ? 7.5 : 9.5;
        c.transient = 60;
        c.taps = 200;
        assert_ok(sp_tapped_lyapunov(&c, &found, &err));
        assert_true(found.lambda < 0);
    }
    sp_tapped_spec c = one_particle(0.1526);
    c.taps = 4000;
    assert_ok(sp_tapped_lyapunov(&c, &found, &err));
    assert_int_equal(found.cycle, 0);
    assert_true(found.lambda > 0.1 && found.error < 0.2);
}

TEST(test_diagram_does_not_depend_on_threads) {
    const sp_tapped_output outputs[] = {SP_TAPPED_LYAPUNOV, SP_TAPPED_BIFURCATION};
    for (int k = 0; k < 2; k++) {
        sp_tapped_spec c = one_particle(0.2);
        c.output = outputs[k];
        c.parameter = SP_TAPPED_BY_AMPLITUDE;
        c.from = 0.2;
        c.to = 1.4;
        c.points = 23;
        c.transient = 50;
        c.taps = 10;
        FREED(sp_table) one, three;
        assert_ok(sp_tapped_table(&c, 1, &one, &err));
        assert_ok(sp_tapped_table(&c, 3, &three, &err));
        assert_int_equal(one.rows, k == 0 ? 23 : 230);
        assert_int_equal(three.rows, one.rows);
        assert_close(sp_table_number(&one, one.rows - 1, 0), 1.4, 1e-15);
        bool warned = false; /* K = 2 m g/r is soft: the ball is pressed through the floor */
        for (int comment = 0; comment < one.comments; comment++)
            warned = warned || strncmp(one.comment[comment], "warning: ordering (1) violated at ", 34) == 0;
        assert_true(warned);
        for (int64_t row = 0; row < one.rows; row++)
            for (int column = 0; column < one.columns; column++) {
                double a = sp_table_number(&one, row, column), b = sp_table_number(&three, row, column);
                assert_true(a == b || (isnan(a) && isnan(b)));
            }
    }
}

RUN_TESTS(NULL, NULL)
