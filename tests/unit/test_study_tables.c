#include "base/base.h"
#include "test.h"

#include <sonopack/study/store.h>
#include <sonopack/study/study.h>
#include <stdbool.h>

/* Cells and comments, bit for bit. */
static void assert_same_table(const sp_table *a, const sp_table *b) {
    char *left = sp_table_text(a, SP_TSV), *right = sp_table_text(b, SP_TSV);
    assert_non_null(left);
    assert_non_null(right);
    assert_string_equal(left, right);
    sp_free(left);
    sp_free(right);
}

/* Samples of fronts with speed 0.3 (p/1e-4)^(1/6) between heights near 8 and 25, and known statics and moduli. */
static sp_sample made_up(double p, int grains, int seed, double offset) {
    double c = 0.3 * pow(p / 1e-4, 1.0 / 6), height = grains == 200 ? 8 : 25;
    sp_sample s = {.dim = 2, .grains = grains, .width = 24, .pressure = p, .friction = 0.5, .seed = (uint64_t)seed};
    snprintf(s.name, sizeof s.name, "%08x%08x%016x", (unsigned)(-1000 * log10(p)), (unsigned)grains, (unsigned)seed);
    s.height = height + offset;
    s.have = SP_WANT_CTOF | SP_WANT_STATICS | SP_WANT_MODULI;
    s.front.t10 = 5 / c + s.height / c;
    s.front.t_peak = 10 / c + 1.25 * s.height / c;
    s.front.t_zero = 15 / c + 1.5 * s.height / c;
    s.front.amplitude = 1 / s.height;
    s.front.width = s.front.t_zero - s.front.t10;
    s.statics = (sp_statics){.phi2 = 0.81,
                             .phi3 = 0.55,
                             .phi3s = 0.5,
                             .zs = 3.2 + offset,
                             .f0 = 10,
                             .n_over_p = 1.2,
                             .z2 = 1.5,
                             .z3 = 2.8,
                             .f2 = 0.52,
                             .f2s = 0.56,
                             .s1_over_s2 = 0.8,
                             .s12_over_s2 = 0.01,
                             .s32_over_s2 = NAN,
                             .mobilised = 0.1};
    s.moduli = (sp_moduli){.c11 = 1,
                           .c12 = 2,
                           .c22 = 3,
                           .c33 = 4,
                           .c_l = grains == 600 ? 0.2 + offset : 9,
                           .c_t = grains == 600 ? 0.1 : 9};
    return s;
}

enum { MADE = 4 * 2 * 5 };

static void make_up(sp_sample s[MADE]) {
    int n = 0;
    for (int seed = 1; seed <= 5; seed++)
        for (int e = -7; e <= -4; e++)
            for (int grains = 200; grains <= 600; grains += 400)
                s[n++] = made_up(pow(10, e), grains, seed, 0.1 * (seed - 3));
}

static double cell(const sp_table *t, int64_t row, const char *column) {
    int c = sp_table_find_column(t, column);
    assert_true(c >= 0);
    return sp_table_number(t, row, c);
}

TEST(table_of_speeds) {
    sp_sample s[MADE];
    make_up(s);
    FREED(sp_table) t = sp_table_none();
    assert_ok(sp_study_table("ctof", MADE, s, NULL, &t, &err));
    static const char *const columns[] = {"p",          "samples",    "c_tof",   "c_tof_err", "c_peak",
                                          "c_zero",     "c_l",        "c_t",     "c_tof_low", "c_tof_high",
                                          "c_peak_err", "c_zero_err", "c_l_err", "c_t_err"};
    assert_int_equal(t.columns, 14);
    for (int c = 0; c < 14; c++)
        assert_string_equal(t.column[c].name, columns[c]);
    assert_int_equal(t.rows, 4);
    for (int k = 0; k < 4; k++) {
        double p = pow(10, k - 7), c = 0.3 * pow(p / 1e-4, 1.0 / 6);
        assert_true(cell(&t, k, "p") == p);
        assert_close(cell(&t, k, "samples"), 5, 0);
        assert_relative(cell(&t, k, "c_tof"), c, 1e-12);
        assert_relative(cell(&t, k, "c_peak"), c / 1.25, 1e-12);
        assert_relative(cell(&t, k, "c_zero"), c / 1.5, 1e-12);
        assert_relative(cell(&t, k, "c_l"), 0.2, 1e-12); /* of the high boxes */
        assert_relative(cell(&t, k, "c_t"), 0.1, 1e-12);
        assert_close(cell(&t, k, "c_tof_err"), 0, 1e-12); /* heights scatter, the speed does not */
        assert_relative(cell(&t, k, "c_tof_low"), c, 1e-10);
        assert_relative(cell(&t, k, "c_tof_high"), c, 1e-10);
        assert_relative(cell(&t, k, "c_l_err"), 0.1 * sqrt(2.5 / 5), 1e-12);
        assert_close(cell(&t, k, "c_t_err"), 0, 1e-15);
    }
    assert_close(strtod(sp_table_get_text(&t, "exponent"), NULL), 1.0 / 6, 1e-6);
    assert_string_equal(sp_table_get_text(&t, "failed"), "0");
}

/* Arrival times that scatter by dt: the error of c = dH/dT is c sqrt(2 dt^2/n)/T. */
TEST(error_of_the_speed) {
    sp_sample s[MADE];
    make_up(s);
    for (int k = 0; k < MADE; k++)
        s[k].front.t10 += s[k].seed % 2 ? 2 : -3; /* mean 0, squares 30 over the five */
    sp_table t = sp_table_none();
    assert_ok(sp_study_table("ctof", MADE, s, NULL, &t, &err));
    for (int k = 0; k < 4; k++) {
        double c = 0.3 * pow(10, (k - 3) / 6.0), flight = 17 / c;
        assert_relative(cell(&t, k, "c_tof"), c, 1e-12);
        /* heights scatter by 0.02 d^2, which moves H and t10 together and c not at all */
        assert_relative(cell(&t, k, "c_tof_err"), c * sqrt(2 * 30.0 / (5 * 4)) / flight, 0.15);
        assert_close(cell(&t, k, "c_peak_err"), 0, 1e-12);
        /* of five samples twice, between 1.96 errors to either side and twice those of Student's for four */
        const double error = cell(&t, k, "c_tof_err"), low = c - cell(&t, k, "c_tof_low"),
                     high = cell(&t, k, "c_tof_high") - c;
        assert_true(low > 1.3 * error && high > 1.3 * error && low + high > 2 * 1.96 * error * 0.85);
        assert_true(low < 2 * 2.78 * 1.15 * error && high < 2 * 2.78 * 1.15 * error);
    }
    sp_table_free(&t);
    int n = 0; /* two high boxes, without scatter, leave the error of the five low ones */
    make_up(s);
    for (int k = 0; k < MADE; k++) {
        if (s[k].grains == 200)
            s[k].front.t10 += s[k].seed % 2 ? 2 : -3;
        if (s[k].grains == 200 || s[k].seed <= 2)
            s[n++] = s[k];
    }
    assert_ok(sp_study_table("ctof", n, s, NULL, &t, &err));
    for (int k = 0; k < 4; k++) {
        double c = 0.3 * pow(10, (k - 3) / 6.0);
        assert_relative(cell(&t, k, "c_tof_err"), c * sqrt(30.0 / (5 * 4)) * c / 17, 0.15);
        assert_close(cell(&t, k, "samples"), 2, 0);
    }
    sp_table_free(&t);
}

TEST(any_order_of_samples) {
    static const char *const names[] = {"ctof", "statics", "moduli", "ensemble"};
    sp_sample s[MADE], mixed[MADE + 3];
    make_up(s);
    for (int k = 0; k < MADE; k++) {
        s[k].front.t10 += sin(k); /* irregular, so that sums depend on their order */
        s[k].statics.phi2 += 0.01 * cos(k);
        s[k].moduli.c22 += 1e-3 * cos(3 * k);
    }
    s[7].failed = true;
    s[7].have = 0;
    snprintf(s[7].reason, sizeof s[7].reason, "it failed");
    for (int n = 0; n < 4; n++) {
        FREED(sp_table) t = sp_table_none();
        assert_ok(sp_study_table(names[n], MADE, s, NULL, &t, &err));
        for (int trial = 1; trial < 8; trial++) {
            for (int k = 0; k < MADE; k++)
                mixed[k] = s[k];
            for (int k = MADE - 1; k > 0; k--) { /* a shuffle by a small generator */
                int other = (int)((unsigned)(trial * 7919 + k * 104729) % (unsigned)(k + 1));
                sp_sample swap = mixed[k];
                mixed[k] = mixed[other];
                mixed[other] = swap;
            }
            for (int k = 0; k < 3; k++)
                mixed[MADE + k] = mixed[k * trial]; /* the same sample again counts once */
            FREED(sp_table) again = sp_table_none();
            assert_ok(sp_study_table(names[n], MADE + 3, mixed, NULL, &again, &err));
            assert_same_table(&t, &again);
        }
    }
}

TEST(groups_with_holes) {
    sp_sample s[MADE];
    make_up(s);
    for (int k = 0; k < MADE; k++) {
        if (s[k].pressure < 2e-7 && s[k].grains == 600) { /* no front in any high box */
            s[k].have &= ~(unsigned)SP_WANT_CTOF;
            s[k].failed = true;
        }
        if (s[k].pressure > 5e-7 && s[k].pressure < 2e-6 && s[k].seed > 2) { /* three of five failed */
            s[k].failed = true;
            s[k].have = 0;
        }
        if (s[k].pressure > 5e-6 && s[k].pressure < 2e-5 && s[k].seed == 4) { /* no zero crossing, no moduli */
            s[k].front.t_zero = s[k].front.width = NAN;
            s[k].have &= ~(unsigned)SP_WANT_MODULI;
            s[k].lacks = SP_WANT_MODULI;
        }
        if (s[k].pressure > 5e-5 && s[k].seed > 1) /* one sample only */
            s[k] = made_up(1e-4, s[k].grains, 1, -0.2);
    }
    sp_table t = sp_table_none();
    assert_ok(sp_study_table("ctof", MADE, s, NULL, &t, &err));
    assert_int_equal(t.rows, 4);
    assert_true(isnan(cell(&t, 0, "c_tof")) && isnan(cell(&t, 0, "c_tof_err")) && isnan(cell(&t, 0, "c_zero")));
    for (int k = 1; k < 4; k++) {
        double c = 0.3 * pow(10, (k - 3) / 6.0);
        assert_relative(cell(&t, k, "c_tof"), c, 1e-12);
        assert_relative(cell(&t, k, "c_zero"), c / 1.5, 1e-12);
    }
    assert_close(cell(&t, 1, "samples"), 2, 0);
    assert_close(cell(&t, 1, "c_l"), 0.2 - 0.15, 1e-12); /* seeds 1 and 2 */
    assert_close(cell(&t, 2, "samples"), 5, 0);
    assert_close(cell(&t, 2, "c_l"), 0.2 - 0.025, 1e-12); /* seeds 1, 2, 3 and 5 */
    assert_close(cell(&t, 3, "samples"), 1, 0);
    /* one sample has no spread */
    static const char *const spread[] = {"c_tof_err",  "c_tof_low", "c_tof_high", "c_peak_err",
                                         "c_zero_err", "c_l_err",   "c_t_err"};
    for (int c = 0; c < 7; c++)
        assert_true(isnan(cell(&t, 3, spread[c])));
    assert_string_equal(sp_table_get_text(&t, "failed"), "11");
    sp_table_free(&t);
    assert_ok(sp_study_table("moduli", MADE, s, NULL, &t, &err));
    const int with_moduli[8] = {5, 5, 2, 2, 4, 4, 1, 1}, without[8] = {0, 0, 3, 3, 1, 1, 0, 0};
    assert_int_equal(t.rows, 8);
    for (int k = 0; k < 8; k++) {
        assert_close(cell(&t, k, "samples"), with_moduli[k], 0);
        assert_close(cell(&t, k, "left_out"), without[k], 0);
    }
    assert_close(cell(&t, 5, "c_l"), 0.2 - 0.025, 1e-12);
    sp_table_free(&t);
    /* one size only */
    assert_ok(sp_study_table("ctof", 1, s, NULL, &t, &err));
    assert_int_equal(t.rows, 1);
    assert_true(isnan(cell(&t, 0, "c_tof")));
    assert_true(t.comments > 1); /* why there is no speed */
    sp_table_free(&t);
    /* nothing at all is an empty table */
    assert_ok(sp_study_table("ctof", 0, s, NULL, &t, &err));
    assert_int_equal(t.rows, 0);
    assert_int_equal(t.columns, 14);
    sp_table_free(&t);
}

/* The highest boxes that have fronts count, however many they are. */
TEST(three_sizes) {
    sp_sample s[16];
    int n = 0;
    for (int seed = 1; seed <= 9; seed++)
        s[n++] = made_up(1e-4, 200, seed, 0.1 * seed);
    for (int seed = 1; seed <= 3; seed++) {
        s[n++] = made_up(1e-4, 400, seed, -5); /* height 20 */
        s[n] = made_up(1e-4, 600, seed, 0);
        s[n].have = 0;
        s[n++].failed = true;
    }
    sp_table t = sp_table_none();
    assert_ok(sp_study_table("ctof", n, s, NULL, &t, &err));
    assert_int_equal(t.rows, 1);
    assert_close(cell(&t, 0, "samples"), 3, 0);
    assert_relative(cell(&t, 0, "c_tof"), 0.3, 1e-12);
    assert_true(cell(&t, 0, "c_tof_err") < 1e-12);
    assert_true(test_names(t.comment[1], "200 400"));
    sp_table_free(&t);
    /* the same sample twice, once with what it lacked before */
    s[n] = s[n - 1];
    s[n].failed = false;
    s[n++].have = SP_WANT_CTOF;
    assert_ok(sp_study_table("ctof", n, s, NULL, &t, &err));
    assert_true(test_names(t.comment[1], "200 600"));
    assert_close(cell(&t, 0, "samples"), 1, 0);
    assert_string_equal(sp_table_get_text(&t, "failed"), "2");
    sp_table_free(&t);
}

/* Other sizes, another protocol: whatever the seeds. Files that do not say are taken as they are. */
TEST(unlike_materials) {
    static const char *const names[] = {"ctof", "scaling", "planes", "statics", "moduli", "probes"};
    sp_sample s[MADE];
    make_up(s);
    for (int k = 0; k < MADE; k++)
        s[k].material = k % 3 == 0 ? 0 : 77;
    sp_table t = sp_table_none();
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        assert_ok(sp_study_table(names[k], MADE, s, NULL, &t, &err));
        sp_table_free(&t);
    }
    s[MADE - 1].material = 78;
    for (size_t k = 0; k < sizeof names / sizeof *names; k++)
        assert_fails(sp_study_table(names[k], MADE, s, NULL, &t, &err), SP_EREFUSED, "packing signal.source");
    assert_ok(sp_study_table("ensemble", MADE, s, NULL, &t, &err));
    sp_table_free(&t);
    s[MADE - 1].failed = true; /* which has nothing to average */
    assert_ok(sp_study_table("statics", MADE, s, NULL, &t, &err));
    sp_table_free(&t);
}

TEST(table_of_means) {
    sp_sample s[MADE];
    make_up(s);
    sp_table t = sp_table_none();
    assert_ok(sp_study_table("statics", MADE, s, NULL, &t, &err));
    assert_int_equal(t.columns, 4 + 5 * 13);
    assert_close(cell(&t, 0, "s12_over_s2"), 0.01, 1e-15);
    assert_close(cell(&t, 0, "mobilised"), 0.1, 1e-15);
    assert_int_equal(t.rows, 8);
    for (int k = 0; k < 8; k++) {
        assert_relative(cell(&t, k, "p"), pow(10, k / 2 - 7), 1e-15);
        assert_close(cell(&t, k, "grains"), k % 2 ? 600 : 200, 0);
        assert_close(cell(&t, k, "samples"), 5, 0);
        assert_close(cell(&t, k, "zs"), 3.2, 1e-14);
        assert_close(cell(&t, k, "zs_sd"), 0.1 * sqrt(2.5), 1e-14);
        assert_close(cell(&t, k, "Phi2"), 0.81, 1e-15);
        assert_close(cell(&t, k, "s1_over_s2"), 0.8, 1e-15);
        assert_close(cell(&t, k, "s1_over_s2_sd"), 0, 1e-15);
        assert_close(cell(&t, k, "zs_err"), 0.1 * sqrt(2.5 / 5), 1e-14);
        /* five symmetric numbers: as far to either side as 1000 resamples know it */
        const double low = 3.2 - cell(&t, k, "zs_low"), high = cell(&t, k, "zs_high") - 3.2;
        assert_true(low > 1.96 * 0.07 && low < 2 * 2.78 * 0.071 && high > 1.96 * 0.07 && high < 2 * 2.78 * 0.071);
        assert_true(cell(&t, k, "s1_over_s2_low") <= 0.8 + 1e-15 && cell(&t, k, "s1_over_s2_high") >= 0.8 - 1e-15);
    }
    sp_table_free(&t);
    assert_ok(sp_study_table("moduli", MADE, s, NULL, &t, &err));
    assert_int_equal(t.columns, 4 + 5 * 8);
    assert_close(cell(&t, 0, "C12"), 2, 0);
    assert_close(cell(&t, 0, "C33"), 4, 0);
    assert_close(cell(&t, 1, "c_l"), 0.2, 1e-15);
    assert_close(cell(&t, 1, "c_l_sd"), 0.1 * sqrt(2.5), 1e-14);
    sp_table_free(&t);
    assert_ok(sp_study_table("ensemble", MADE, s, NULL, &t, &err));
    assert_int_equal(t.rows, MADE);
    for (int k = 1; k < MADE; k++) {
        double p = cell(&t, k, "p"), before = cell(&t, k - 1, "p");
        double g = cell(&t, k, "grains"), g_before = cell(&t, k - 1, "grains");
        assert_true(p > before || (p == before && g > g_before) ||
                    (p == before && g == g_before && cell(&t, k, "seed") > cell(&t, k - 1, "seed")));
    }
    assert_relative(cell(&t, 0, "width"), s[0].front.width, 1e-15);
    sp_table_free(&t);
}

/* A level more is a wider interval; means and errors stay. */
TEST(levels_of_intervals) {
    static const struct {
        const char *table, *low, *high, *rest;
    } all[] = {{"ctof", "c_tof_low", "c_tof_high", "c_tof_err"},
               {"moduli", "c_l_low", "c_l_high", "c_l_err"},
               {"statics", "zs_low", "zs_high", "zs_err"}};
    sp_sample s[MADE];
    make_up(s);
    for (int k = 0; k < MADE; k++)
        s[k].front.t10 += s[k].seed % 2 ? 2 : -3;
    assert_true(sp_table_options_default().level == 0.95);
    for (int n = 0; n < 3; n++) {
        sp_table t[3] = {sp_table_none(), sp_table_none(), sp_table_none()}, none = sp_table_none();
        static const double levels[] = {0.5, 0.95, 0.999};
        for (int k = 0; k < 3; k++) {
            const sp_table_options o = {levels[k]};
            char text[60];
            assert_ok(sp_study_table(all[n].table, MADE, s, &o, &t[k], &err));
            snprintf(text, sizeof text, "%g", levels[k]);
            bool told = false;
            for (int c = 0; c < t[k].comments; c++)
                told = told || test_names(t[k].comment[c], text);
            assert_true(told);
            const int64_t last = t[k].rows - 1;
            assert_true(cell(&t[k], last, all[n].rest) == cell(&t[0], last, all[n].rest));
            if (k > 0)
                assert_true(cell(&t[k], last, all[n].low) < cell(&t[k - 1], last, all[n].low) &&
                            cell(&t[k], last, all[n].high) > cell(&t[k - 1], last, all[n].high));
        }
        assert_ok(sp_study_table(all[n].table, MADE, s, NULL, &none, &err));
        assert_same_table(&none, &t[1]);
        for (int k = 0; k < 3; k++)
            sp_table_free(&t[k]);
        sp_table_free(&none);
        const sp_table_options wrong = {95};
        assert_fails(sp_study_table(all[n].table, MADE, s, &wrong, &none, &err), SP_EINVAL, "0.5 0.999");
    }
}

TEST(what_is_not_averaged) {
    sp_sample s[MADE];
    sp_table t = sp_table_none();
    make_up(s);
    s[3].friction = 0;
    assert_fails(sp_study_table("ctof", MADE, s, NULL, &t, &err), SP_EREFUSED, "friction");
    assert_fails(sp_study_table("statics", MADE, s, NULL, &t, &err), SP_EREFUSED, "friction");
    assert_ok(sp_study_table("ensemble", MADE, s, NULL, &t, &err));
    sp_table_free(&t);
    make_up(s);
    s[3].width = 48;
    assert_fails(sp_study_table("ctof", MADE, s, NULL, &t, &err), SP_EREFUSED, "width");
    make_up(s);
    s[8] = s[0]; /* the same seed under another name: of another scene */
    s[8].name[0] = 'f';
    assert_fails(sp_study_table("moduli", MADE, s, NULL, &t, &err), SP_EREFUSED, "1e-07 200 1");
    assert_fails(sp_study_table("spectra", MADE, s, NULL, &t, &err), SP_EINVAL, "spectra");
    assert_null(t.cells);
}

TEST(tables_without_memory) {
    static const char *const names[] = {"ctof", "statics", "moduli", "ensemble"};
    sp_sample s[MADE];
    make_up(s);
    for (int n = 0; n < 4; n++) {
        sp_status status = SP_ENOMEM;
        int64_t k;
        for (k = 0; status != SP_OK; k++) {
            sp_table t = sp_table_none();
            sp_error err = {0};
            sp_alloc_fail_after(k);
            status = sp_study_table(names[n], MADE, s, NULL, &t, &err);
            sp_alloc_fail_after(-1);
            if (status != SP_OK)
                assert_int_equal(status, SP_ENOMEM);
            else
                sp_table_free(&t);
            assert_true(k < 10000);
        }
        assert_true(k > 5);
    }
}

RUN_TESTS(NULL, NULL)
