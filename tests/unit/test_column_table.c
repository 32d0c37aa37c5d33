/* The tables of a column: shapes, comments, being stopped, and lack of memory. */
#include "test.h"

#include "base/base.h"
#include "tapped/tapped_table.h"

#include <string.h>

static sp_tapped_spec small(sp_tapped_output output) {
    sp_tapped_spec c = sp_tapped_spec_default();
    c.particles = 2;
    c.taps = 2;
    c.step = 0.125;
    c.output = output;
    return c;
}

static bool has_comment(const sp_table *t, const char *begin) {
    for (int k = 0; k < t->comments; k++)
        if (strncmp(t->comment[k], begin, strlen(begin)) == 0)
            return true;
    return false;
}

TEST(shapes_of_the_tables) {
    static const struct {
        sp_tapped_output output;
        int64_t rows;
        int columns;
        const char *first, *last;
    } expected[] = {{SP_TAPPED_TRAJECTORY, 17, 4, "t", "y2"},
                    {SP_TAPPED_STROBE, 2, 5, "tap", "density"},
                    {SP_TAPPED_ENERGY, 2, 9, "tap", "contact"},
                    {SP_TAPPED_DENSITY, 17, 5, "t", "rho2"}};
    for (size_t k = 0; k < sizeof expected / sizeof *expected; k++) {
        const sp_tapped_spec c = small(expected[k].output);
        FREED(sp_table) t;
        assert_ok(sp_tapped_table(&c, 1, &t, &err));
        assert_int_equal(t.rows, expected[k].rows);
        assert_int_equal(t.columns, expected[k].columns);
        assert_string_equal(t.column[0].name, expected[k].first);
        assert_string_equal(t.column[t.columns - 1].name, expected[k].last);
        assert_string_equal(sp_table_get_text(&t, "stiffness"), "3922.68");
        assert_string_equal(sp_table_get_text(&t, "method"), "event");
    }
}

TEST(the_last_row_is_the_end) {
    sp_tapped_spec c = small(SP_TAPPED_TRAJECTORY);
    static const double periods[] = {1, 0.7, 1.0 / 3, 0.1};
    for (size_t k = 0; k < sizeof periods / sizeof *periods; k++) {
        c.period = periods[k];
        c.step = 0; /* a hundredth: of no binary fraction */
        FREED(sp_table) t;
        assert_ok(sp_tapped_table(&c, 1, &t, &err));
        assert_int_equal(t.rows, 201);
        assert_true(fabs(sp_table_number(&t, 200, 0) - 2 * c.period) <= 1e-15);
    }
    c.step = 100; /* longer than all: the start alone */
    FREED(sp_table) t;
    assert_ok(sp_tapped_table(&c, 1, &t, &err));
    assert_int_equal(t.rows, 1);
}

TEST(long_lists_are_cut_in_comments) {
    double mass[40];
    for (int k = 0; k < 40; k++)
        mass[k] = 1 + 1.0 / (3 + k);
    sp_tapped_spec c = small(SP_TAPPED_STROBE);
    c.mass = mass;
    c.masses = 40;
    FREED(sp_table) t;
    assert_ok(sp_tapped_table(&c, 1, &t, &err));
    const char *text = sp_table_get_text(&t, "mass");
    assert_non_null(text);
    assert_non_null(strstr(text, ", ... 40 values)"));
}

TEST(warnings_stand_in_the_comments) {
    sp_tapped_report report = {.violated_at = 1.5, .violated = 3};
    const sp_tapped_spec c = small(SP_TAPPED_TRAJECTORY);
    FREED(sp_table) t = sp_table_none();
    assert_ok(sp_tapped_comment_report(&c, &report, &t, &err));
    assert_true(has_comment(&t, "warning: ordering (1) violated at t = 1.5 s between particles 3 and 4"));
    report.violated = 0;
    assert_ok(sp_tapped_comment_report(&c, &report, &t, &err));
    assert_true(has_comment(&t, "warning: ordering (1) violated at t = 1.5 s between the floor and particle 1"));
    sp_table_free(&t);
    report.violated_at = NAN;
    assert_ok(sp_tapped_comment_report(&c, &report, &t, &err));
    assert_int_equal(t.comments, 0);
    sp_tapped_spec literal = c;
    literal.model = SP_TAPPED_BSR;
    literal.bsr = SP_TAPPED_BSR_LITERAL;
    literal.particles = 10;
    assert_ok(sp_tapped_comment_model(&literal, &t, &err));
    assert_true(has_comment(&t, "warning: bsr = literal: the force of (45) as it was printed points downwards, and is "
                                "2.2588 m g at the most"));
    sp_table_free(&t);
    literal.bsr = SP_TAPPED_BSR_SIGNED;
    assert_ok(sp_tapped_comment_model(&literal, &t, &err));
    assert_true(has_comment(&t, "warning: bsr = signed: the force of (45) with its signs put right is 0.354"));
    sp_table_free(&t);
    literal.model = SP_TAPPED_LATTICE;
    literal.method = SP_TAPPED_RK4;
    assert_ok(sp_tapped_comment_model(&literal, &t, &err));
    assert_true(has_comment(&t, "warning: method rk4 is of first order"));
}

static bool stop_at_half(double share, void *user) {
    double *last = user;
    assert_true(share > *last && share <= 1);
    *last = share;
    return share < 0.5;
}

TEST(stopped_in_the_middle) {
    static const sp_tapped_output outputs[] = {SP_TAPPED_TRAJECTORY, SP_TAPPED_STROBE, SP_TAPPED_ENERGY,
                                               SP_TAPPED_DENSITY};
    for (size_t k = 0; k < sizeof outputs / sizeof *outputs; k++) {
        const sp_tapped_spec c = small(outputs[k]);
        double share = 0;
        sp_table t;
        memset(&t, 0x5a, sizeof t);
        const sp_table before = t;
        assert_fails(sp_tapped_table_watched(&c, 1, (sp_tapped_watcher){stop_at_half, &share}, &t, &err),
                     SP_EINTERRUPTED, "");
        assert_memory_equal(&t, &before, sizeof t);
        assert_true(share >= 0.5 && share < 0.6);
    }
}

/* All refusals of columns, one row each: what is changed in a column that runs. */
TEST(refused) {
    static const double unequal[] = {1, 1.5};
    sp_table t;
#define WRONG(change, status, words)                                                                                   \
    do {                                                                                                               \
        sp_tapped_spec c = small(SP_TAPPED_TRAJECTORY);                                                                \
        change;                                                                                                        \
        assert_fails(sp_tapped_table(&c, 1, &t, &err), status, words);                                                 \
    } while (0)
    WRONG((c.output = SP_TAPPED_ENERGY, c.model = SP_TAPPED_LONGWAVE), SP_EINVAL, "column.output energy");
    WRONG((c.output = SP_TAPPED_LYAPUNOV, c.model = SP_TAPPED_LONGWAVE), SP_EINVAL, "column.output lyapunov");
    WRONG((c.output = SP_TAPPED_BIFURCATION, c.method = SP_TAPPED_SMOOTH), SP_EINVAL, "column.output bifurcation");
    WRONG((c.step = 1e-12, c.taps = 100000000), SP_ENOMEM, "column.step");
    WRONG(c.e = 1, SP_EINVAL, "column.e 1");
    WRONG(c.model = SP_TAPPED_EQ37, SP_EREFUSED, "eq37");
    for (int which = SP_TAPPED_BSR_CONSERVATIVE; which <= SP_TAPPED_BSR_SIGNED; which++) {
        WRONG((c.model = SP_TAPPED_BSR, c.bsr = (sp_tapped_bsr)which, c.mass = unequal, c.masses = 2), SP_EINVAL,
              "column.mass 2 1.5");
        WRONG((c.model = SP_TAPPED_BSR, c.bsr = (sp_tapped_bsr)which, c.radius = unequal, c.radii = 2), SP_EINVAL,
              "column.radius 2 1.5");
        WRONG((c.model = SP_TAPPED_BSR, c.bsr = (sp_tapped_bsr)which, c.time_step = 0.02), SP_EINVAL,
              "column.time_step 0.02");
    }
    WRONG((c.model = SP_TAPPED_LONGWAVE, c.mass = unequal, c.masses = 2), SP_EINVAL, "2");
    WRONG((c.model = SP_TAPPED_LONGWAVE, c.radius = unequal, c.radii = 2), SP_EINVAL, "2");
    WRONG((c.model = SP_TAPPED_LONGWAVE, c.time_step = 2e-3), SP_EINVAL, "column.time_step 0.002");
    WRONG((c.model = SP_TAPPED_LONGWAVE, c.alpha_v = 1e9), SP_EINVAL, "column.alpha_v");
    WRONG((c.method = SP_TAPPED_SMOOTH, c.alpha_v = 1e9), SP_EFAILED, "column.alpha_v");
    WRONG((c.method = SP_TAPPED_RK4, c.time_step = 0.0625), SP_EINVAL, "column.time_step 0.0625");
    WRONG((c.method = SP_TAPPED_RK4, c.time_step = 1e-9), SP_EINVAL, "column.time_step");
    WRONG((c.output = SP_TAPPED_BIFURCATION, c.parameter = SP_TAPPED_BY_PERIOD, c.points = 5, c.from = 0.01, c.to = 1),
          SP_EINVAL, "column.from period 0.01");
    WRONG((c.output = SP_TAPPED_BIFURCATION, c.parameter = SP_TAPPED_BY_PERIOD, c.points = 5, c.from = 2, c.to = 1),
          SP_EINVAL, "column.to 1");
    WRONG((c.output = SP_TAPPED_BIFURCATION, c.points = c.taps = 100000000, c.from = 0.1, c.to = 1), SP_EINVAL,
          "column.points column.taps");
#undef WRONG
    const double back[] = {0.5, 0.2};
    const sp_tapped_spec c = small(SP_TAPPED_TRAJECTORY);
    assert_fails(sp_tapped_run(&c, 2, back, NULL, NULL, NULL, &err), SP_EINVAL, "0.20000000000000001");
}

/* Every allocation fails once: a reason, no leak (the sanitizers look), nothing written. */
TEST(lack_of_memory) {
    static const struct {
        sp_tapped_output output;
        sp_tapped_model model;
        sp_tapped_method method;
        sp_tapped_bsr bsr;
    } each[] = {{.output = SP_TAPPED_TRAJECTORY}, {.output = SP_TAPPED_STROBE},
                {.output = SP_TAPPED_ENERGY},     {.output = SP_TAPPED_DENSITY},
                {.output = SP_TAPPED_COMPARE},    {.model = SP_TAPPED_LONGWAVE},
                {.method = SP_TAPPED_SMOOTH},     {.method = SP_TAPPED_RK4},
                {.model = SP_TAPPED_BSR},         {.model = SP_TAPPED_BSR, .bsr = SP_TAPPED_BSR_LITERAL}};
    for (size_t k = 0; k < sizeof each / sizeof *each; k++) {
        sp_tapped_spec c = small(each[k].output);
        c.model = each[k].model;
        c.method = each[k].method;
        c.bsr = each[k].bsr;
        c.taps = 1;
        c.cells = 2;
        c.step = 0.5;
        c.amplitude = each[k].model == SP_TAPPED_BSR ? 30 : c.amplitude; /* the grid has to grow */
        sp_table t = sp_table_none();
        EACH_ALLOCATION_FAILS(19, sp_tapped_table(&c, 1, &t, &err), /* the comments alone are as many */
                              assert_true(!lacks || (t.rows == 0 && t.comments == 0)), sp_table_free(&t));
    }
}

RUN_TESTS(NULL, NULL)
