/* The tables scaling, planes and probes, of made-up samples. */
#include "base/base.h"
#include "test.h"

#include <sonopack/study/store.h>
#include <sonopack/study/study.h>

static double cell(const sp_table *t, int64_t row, const char *column) {
    int c = sp_table_find_column(t, column);
    if (c < 0)
        fail_msg("no column %s", column);
    return sp_table_number(t, row, c);
}

static const double heights[3] = {8, 25, 50};

static sp_front law(double l, double speed, double gamma, double factor) {
    sp_front f = {.t10 = 5 + l / speed, .amplitude = 3 * pow(l, -gamma) * factor};
    f.t_zero = f.t10 + 2 * pow(l, 0.8);
    f.t_peak = f.t_zero - 0.7 * pow(l, 0.6);
    f.width = f.t_zero - f.t10;
    return f;
}

/* Boxes of two widths and three heights at two pressures; gamma = 1.5 in narrow ones and 1.2 in wide ones; c_l = 0.2 in
 * the lowest, 0.22 in the others. Planes at 3, 6 and, in the higher two, 12. */
enum { WIDTHS = 2, PRESSURES = 2, SEEDS = 4, MADE = WIDTHS * PRESSURES * 3 * SEEDS };

static sp_sample made_up(double p, double width, int height, int seed) {
    const double gamma = width < 20 ? 1.5 : 1.2, speed = 0.25 * pow(p / 1e-4, 1.0 / 6), factor = 1 + 0.1 * (seed - 2.5);
    const double offset = 0.02 * (seed - 2.5);
    sp_sample s = {.dim = 2, .width = width, .pressure = p, .friction = 0.5, .seed = (uint64_t)seed};
    s.grains = (int)(width * heights[height]);
    snprintf(s.name, sizeof s.name, "%08x%08x%08x%08x", (unsigned)(-1000 * log10(p)), (unsigned)width,
             (unsigned)s.grains, (unsigned)seed);
    s.height = heights[height] + offset;
    s.have = SP_WANT_CTOF | SP_WANT_MODULI | SP_WANT_PLANES | SP_WANT_STATICS | SP_WANT_PROBES;
    s.front = law(heights[height], speed, gamma, factor);
    s.front.t10 += offset / speed;
    s.moduli = (sp_moduli){.c22 = 2 + offset, .c33 = 0.5, .c_l = (height ? 0.22 : 0.2) + offset, .c_t = 0.1};
    for (int k = 0; k < SP_PROBES; k++)
        s.probe[k] = (sp_probe_moduli){.along = (0.9 - 0.1 * k) * s.moduli.c22, .shear = 0.5 * (1 + k)};
    s.planes = height ? 3 : 2;
    for (int k = 0; k < s.planes; k++) {
        s.plane[k] = 3 * pow(2, k);
        s.plane_front[k] = law(s.plane[k], 2 * speed, 1, factor);
    }
    return s;
}

static void make_up(sp_sample s[MADE]) {
    int n = 0;
    for (int seed = SEEDS; seed > 0; seed--)
        for (int p = 0; p < PRESSURES; p++)
            for (int width = 12; width <= 24; width += 12)
                for (int h = 2; h >= 0; h--)
                    s[n++] = made_up(p ? 1e-4 : 1e-6, width, h, seed);
}

TEST(a_row_a_height) {
    sp_sample s[MADE];
    make_up(s);
    FREED(sp_table) t = sp_table_none();
    assert_ok(sp_study_table("scaling", MADE, s, NULL, &t, &err));
    static const char *const columns[] = {
        "p",      "width",      "distance",       "distance_err", "samples",       "t10",       "t10_err",
        "t_peak", "t_peak_err", "t_zero",         "t_zero_err",   "amplitude",     "width10",   "width10_err",
        "speed",  "speed_err",  "gamma",          "gamma_err",    "alpha",         "alpha_err", "alpha_peak",
        "c_l",    "c_l_err",    "speed_over_c_l", "friction",     "alpha_peak_err"};
    for (size_t k = 0; k < sizeof columns / sizeof *columns; k++)
        assert_true(sp_table_find_column(&t, columns[k]) >= 0);
    assert_int_equal(t.rows, 12);
    for (int r = 0; r < 12; r++) {
        const double p = r < 6 ? 1e-6 : 1e-4, width = r % 6 < 3 ? 12 : 24, speed = 0.25 * pow(p / 1e-4, 1.0 / 6);
        const double gamma = width < 20 ? 1.5 : 1.2;
        assert_true(cell(&t, r, "p") == p && cell(&t, r, "width") == width && cell(&t, r, "samples") == SEEDS);
        assert_relative(cell(&t, r, "distance"), heights[r % 3], 1e-12);
        assert_relative(cell(&t, r, "distance_err"), 0.02 * sqrt(5.0 / 3) / 2, 1e-9);
        assert_relative(cell(&t, r, "amplitude_err") / cell(&t, r, "amplitude"), 0.1 * sqrt(5.0 / 3) / 2, 1e-9);
        assert_relative(cell(&t, r, "c_l"), r % 3 ? 0.22 : 0.2, 1e-12);
        if (r % 3 == 2) {
            assert_true(isnan(cell(&t, r, "speed")) && isnan(cell(&t, r, "gamma_err")));
            assert_true(isnan(cell(&t, r, "speed_low")) && isnan(cell(&t, r, "speed_high")));
            continue;
        }
        assert_relative(cell(&t, r, "speed"), speed, 1e-12);
        assert_close(cell(&t, r, "speed_err"), 0, 1e-12); /* heights scatter, the speed does not */
        assert_relative(cell(&t, r, "speed_low"), speed, 1e-10);
        assert_relative(cell(&t, r, "speed_high"), speed, 1e-10);
        assert_relative(cell(&t, r, "speed_over_c_l"), speed / (r % 3 ? 0.22 : 0.21), 1e-12);
        assert_close(cell(&t, r, "gamma"), gamma, 1e-12);
        /* 10% sd of independent rows of four, to the noise of a bootstrap of so few */
        const double error = sqrt(2 * 0.01 * 5 / 3 / 4) / log(heights[r % 3 + 1] / heights[r % 3]);
        assert_relative(cell(&t, r, "gamma_err"), error, 0.15);
    }
    const char *fit = sp_table_get_text(&t, "gamma(p=1e-06, width=24, friction=0.5)");
    assert_non_null(fit);
    assert_close(strtod(fit, NULL), 1.2, 1e-5);
    assert_non_null(strstr(fit, "chi2"));
    assert_close(strtod(sp_table_get_text(&t, "speed(p=0.0001, width=12, friction=0.5)"), NULL), 0.25, 1e-5);
}

TEST(a_row_a_plane) {
    sp_sample s[MADE];
    make_up(s);
    for (int k = 0; k < MADE; k++)
        if (s[k].grains == 300 && s[k].seed == 1)
            s[k].plane_front[1] = (sp_front){NAN, NAN, NAN, NAN, NAN, 0};
    FREED(sp_table) t = sp_table_none();
    assert_ok(sp_study_table("planes", MADE, s, NULL, &t, &err));
    assert_int_equal(t.rows, 2 * 2 * (2 + 3 + 3));
    for (int r = 0; r < t.rows; r++) {
        const int group = r % 8; /* 3, 6; 3, 6, 12; 3, 6, 12 */
        const int plane = group < 2 ? group : (group - 2) % 3;
        const double speed = 0.5 * pow(cell(&t, r, "p") / 1e-4, 1.0 / 6);
        assert_relative(cell(&t, r, "distance"), 3 * pow(2, plane), 1e-15);
        assert_close(cell(&t, r, "distance_err"), 0, 0);
        const bool lacks = cell(&t, r, "grains") == 300 && plane == 1;
        assert_close(cell(&t, r, "samples"), lacks ? 3 : 4, 0);
        if (group == 1 || group == 4 || group == 7)
            continue;
        assert_relative(cell(&t, r, "speed"), speed, 1e-12);
        if (cell(&t, r, "grains") == 300)
            continue;
        assert_close(cell(&t, r, "gamma"), 1, 1e-12);
        assert_close(cell(&t, r, "gamma_err"), 0, 1e-12); /* factors of the packings cancel */
    }
    assert_non_null(sp_table_get_text(&t, "alpha(p=1e-06, width=12, friction=0.5, grains=600)"));
}

/* Times of planes that scatter: alike in all planes of a packing they leave the speed alone, by themselves they do not.
 */
TEST(intervals_of_speeds) {
    static const double off[SEEDS] = {0.5, -0.5, -0.3, 0.3};
    sp_sample s[MADE];
    for (int own = 0; own < 2; own++) {
        make_up(s);
        for (int k = 0; k < MADE; k++)
            for (int i = 0; i < s[k].planes; i++)
                s[k].plane_front[i].t10 += off[(s[k].seed - 1 + (own ? (unsigned)i : 0)) % SEEDS];
        FREED(sp_table) t = sp_table_none();
        assert_ok(sp_study_table("planes", MADE, s, NULL, &t, &err));
        for (int r = 0; r < t.rows; r++) {
            const double speed = cell(&t, r, "speed"), low = cell(&t, r, "speed_low"), high = cell(&t, r, "speed_high");
            assert_true(isnan(speed) ? isnan(low) && isnan(high) : low <= speed + 1e-12 && high >= speed - 1e-12);
            if (isnan(speed))
                continue;
            const double error = cell(&t, r, "speed_err");
            if (!own)
                assert_close(high - low, 0, 1e-10);
            else /* four samples: Student's is 3.2, twice of it the most; the errors are of the first order */
                assert_true(high - low > 2 * 1.6 * error && high - low < 4 * 3.2 * 1.5 * error);
        }
    }
}

TEST(means_of_probes) {
    sp_sample s[MADE];
    int n = 0;
    for (int seed = 1; seed <= SEEDS; seed++)
        s[n++] = made_up(1e-4, 24, 1, seed);
    s[0].probe[SP_SINE_2].concentrated = 0.9;
    sp_table t = sp_table_none();
    assert_ok(sp_study_table("probes", n, s, NULL, &t, &err));
    assert_int_equal(t.rows, 1);
    assert_int_equal(t.columns, 4 + 5 * 16);
    static const char *const probe[SP_PROBES] = {"sine1", "sine2", "lines1", "lines3"};
    for (int k = 0; k < SP_PROBES; k++) {
        char name[40];
        snprintf(name, sizeof name, "C22_%s_ratio", probe[k]);
        assert_relative(cell(&t, 0, name), 0.9 - 0.1 * k, 1e-12); /* sample by sample, so without scatter */
        snprintf(name, sizeof name, "C22_%s_ratio_sd", probe[k]);
        assert_close(cell(&t, 0, name), 0, 1e-12);
        snprintf(name, sizeof name, "C22_%s", probe[k]);
        assert_relative(cell(&t, 0, name), 2 * (0.9 - 0.1 * k), 1e-12);
        snprintf(name, sizeof name, "C22_%s_sd", probe[k]);
        assert_relative(cell(&t, 0, name), (0.9 - 0.1 * k) * 0.02 * sqrt(5.0 / 3), 1e-9);
        snprintf(name, sizeof name, "C33_%s_ratio", probe[k]);
        assert_relative(cell(&t, 0, name), 1.0 + k, 1e-12);
    }
    assert_true(test_names(sp_table_get_text(&t, "loose"), "1"));
    sp_table_free(&t);
    for (int k = 0; k < n; k++) { /* names of three dimensions; without moduli no ratio */
        s[k].dim = 3;
        s[k].moduli.c55 = 0.25;
        s[k].have &= ~(unsigned)(k == 0 ? SP_WANT_MODULI : 0);
    }
    assert_ok(sp_study_table("probes", n, s, NULL, &t, &err));
    assert_true(isnan(cell(&t, 0, "C55_lines3_ratio")) && cell(&t, 0, "C55_lines3") == 2);
    sp_table_free(&t);
    assert_ok(sp_study_table("moduli", n, s, NULL, &t, &err));
    assert_int_equal(t.columns, 4 + 5 * 13);
    assert_close(cell(&t, 0, "C55"), 0.25, 1e-15);
    sp_table_free(&t);
}

TEST(what_is_refused_and_left_out) {
    sp_sample s[MADE + 1];
    sp_table t = sp_table_none();
    make_up(s);
    s[MADE] = s[3];
    s[MADE].name[0] = 'f';
    assert_fails(sp_study_table("scaling", MADE + 1, s, NULL, &t, &err), SP_EREFUSED, "1e-06 1200 4");
    assert_fails(sp_study_table("planes", MADE + 1, s, NULL, &t, &err), SP_EREFUSED, "1e-06 1200 4");
    assert_fails(sp_study_table("spectrum", MADE, s, NULL, &t, &err), SP_EINVAL, "ctof scaling planes");
    for (int k = 0; k < MADE; k++) /* no front anywhere: no rows; failures are counted */
        s[k].have = 0;
    s[2].failed = true;
    assert_ok(sp_study_table("scaling", MADE, s, NULL, &t, &err));
    assert_int_equal(t.rows, 0);
    assert_string_equal(sp_table_get_text(&t, "failed"), "1");
    sp_table_free(&t);
    assert_ok(sp_study_table("planes", MADE, s, NULL, &t, &err));
    assert_int_equal(t.rows, 0);
    sp_table_free(&t);
    assert_ok(sp_study_table("scaling", 0, s, NULL, &t, &err));
    assert_int_equal(t.rows, 0);
    sp_table_free(&t);
}

TEST(in_any_order) {
    sp_sample s[MADE], turned[MADE];
    make_up(s);
    for (int k = 0; k < MADE; k++) {
        s[k].front.t10 += sin(k);
        s[k].plane_front[1].amplitude += 1e-3 * cos(k);
    }
    for (int k = 0; k < MADE; k++)
        turned[k] = s[(k * 31 + 7) % MADE]; /* 31 and 48 have no common factor */
    static const char *const names[] = {"scaling", "planes", "probes"};
    for (int n = 0; n < 2; n++) {
        FREED(sp_table) a = sp_table_none(), b = sp_table_none();
        assert_ok(sp_study_table(names[n], MADE, s, NULL, &a, &err));
        assert_ok(sp_study_table(names[n], MADE, turned, NULL, &b, &err));
        char *left = sp_table_text(&a, SP_TSV), *right = sp_table_text(&b, SP_TSV);
        assert_string_equal(left, right);
        sp_free(left);
        sp_free(right);
    }
}

TEST(tables_without_memory) {
    static const char *const names[] = {"scaling", "planes", "probes"};
    sp_sample s[SEEDS * 3];
    int count = 0;
    for (int seed = 1; seed <= SEEDS; seed++)
        for (int h = 0; h < 3; h++)
            s[count++] = made_up(1e-4, 24, h, seed);
    for (int n = 0; n < 3; n++) {
        sp_status status = SP_ENOMEM;
        for (int64_t k = 0; status != SP_OK; k += 1 + k / 10) {
            sp_table t = sp_table_none();
            sp_error err = {0};
            sp_alloc_fail_after(k);
            status = sp_study_table(names[n], count, s, NULL, &t, &err);
            sp_alloc_fail_after(-1);
            assert_true(status == SP_OK || status == SP_ENOMEM);
            if (status == SP_OK)
                sp_table_free(&t);
            assert_true(k < 10000);
        }
    }
}

/* Lattices and packings of the same box are no rows of one group, and have no common means. */
TEST(kinds_are_kept_apart) {
    sp_sample s[MADE];
    sp_table t = sp_table_none();
    make_up(s);
    for (int k = 0; k < MADE; k++)
        if (s[k].seed % 2)
            s[k].kind = SP_PACK_TRIANGULAR;
    assert_ok(sp_study_table("scaling", MADE, s, NULL, &t, &err));
    assert_int_equal(t.rows, 24);
    for (int r = 0; r < 24; r++)
        assert_true(cell(&t, r, "samples") == SEEDS / 2);
    assert_non_null(sp_table_get_text(&t, "gamma(p=1e-06, width=24, friction=0.5, triangular)"));
    assert_non_null(sp_table_get_text(&t, "gamma(p=1e-06, width=24, friction=0.5)"));
    sp_table_free(&t);
    s[1] = s[0];
    s[1].kind = SP_PACK_CHAIN;
    s[1].name[0] = 'e';
    assert_fails(sp_study_table("moduli", 2, s, NULL, &t, &err), SP_EREFUSED, "packing.kind");
}

RUN_TESTS(NULL, NULL)
