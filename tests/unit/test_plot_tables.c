/* Figures of fronts, ensembles, modes, sections, contacts and motion: what they say, and what they refuse. */
#include "base/base.h"
#include "reference.h"

#include <sonopack/counts.h>
#include <sonopack/figure/plot.h>
#include <sonopack/signal.h>
#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__)
/* fontconfig, behind cairo, keeps offsets in place of pointers: the leak checker cannot see that its memory is held. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) { return "leak:libfontconfig"; }
const char *__lsan_default_options(void);
const char *__lsan_default_options(void) { return "print_suppressions=0"; }
#endif

#define PACKING SOURCE_DIR "/packings/reference/packing_N200_p1e-4.txt"

static char folder[] = "/tmp/sonopack-tables-XXXXXX", svg[64];

static int setup(void **state) {
    (void)state;
    if (!mkdtemp(folder))
        return 1;
    snprintf(svg, sizeof svg, "%s/a.svg", folder);
    return 0;
}

static int teardown(void **state) {
    (void)state;
    remove(svg);
    return rmdir(folder);
}

/* All texts of the figure, a line each. */
static char *drawn(void) {
    FILE *file = fopen(svg, "rb");
    assert_non_null(file);
    char *text = calloc(1, 4000000);
    assert_non_null(text);
    assert_true(fread(text, 1, 3999999, file) > 0);
    fclose(file);
    remove(svg);
    return text;
}

static void says(const char *const *words) {
    char *text = drawn();
    for (; *words; words++)
        if (!strstr(text, *words))
            fail_msg("no %s in %.900s", *words, text);
    free(text);
}

static sp_table table_of(const char *names, int rows, const double *cells) {
    sp_table t = sp_table_none();
    char copy[256], *rest = copy;
    int columns = 0;
    snprintf(copy, sizeof copy, "%s", names);
    for (char *name; (name = strsep(&rest, " ")) != NULL; columns++)
        assert_ok(sp_table_add_column(&t, name, "", SP_COLUMN_NUMBER, &err));
    for (int k = 0; k < rows; k++)
        assert_ok(sp_table_add_numbers(&t, cells + k * columns, &err));
    return t;
}

#define SCALING "p width distance t10 t10_err t_peak t_zero amplitude width10 gamma gamma_err alpha alpha_peak"
static const double scaling[6][13] = {{1e-4, 24, 10, 40, 1, 46, 52, 2, 12, 1.5, .1, .9, .7},
                                      {1e-4, 24, 20, 80, 1, 88, 97, .7, 17, 1.2, .1, .8, .6},
                                      {1e-4, 24, 40, 160, 2, 172, 185, .3, 25, NAN, NAN, NAN, NAN},
                                      {1e-4, 48, 10, 41, 1, 47, 53, 2, 12, 1.5, .1, .9, .7},
                                      {1e-4, 48, 20, 82, 1, 88, 97, .7, 17, 1.3, .1, .8, .6},
                                      {1e-4, 48, 40, 164, 2, 172, 185, .3, 25, NAN, NAN, NAN, NAN}};

/* The speed of a line through exact points is exact; groups are told apart by what differs. */
static void test_fronts(void **state) {
    (void)state;
    sp_table one = table_of(SCALING, 3, scaling[0]), two = table_of(SCALING, 6, scaling[0]);
    const double time[5] = {0, 1, 2, 3, 4}, force[5] = {0, 1, 2, 0, -1};
    const sp_plot_trace sample = {NULL, 5, time, force, .2, 2, 3, NULL, NULL, NULL};
    const sp_plot_table single = {"one", &one, false}, both[2] = {{"a", &two, false}, {"b", &one, false}};
    assert_ok(sp_plot_fronts(1, &single, &sample, svg, &err));
    says((const char *[]){"\nt_10,  c = 0.25\n", "\nt_peak,  c = 0.2", "\nF_sig  [E* d^2]\n", "\ndistance\n", NULL});
    const sp_plot_table widths = {"two", &two, false};
    assert_ok(sp_plot_fronts(1, &widths, NULL, svg, &err));
    says((const char *[]){"\nwidth 24 d\n", "\nwidth 48 d\n", "\nt_10\n", "\nt_zero\n", NULL});
    assert_ok(sp_plot_scaling(2, both, svg, &err));
    says((const char *[]){"\na, width 24 d\n", "\nb, width 24 d\n", "\n(b)\n", "\xce\xb3_eff", "\xce\xb1_eff", "\nW\n",
                          NULL});
    sp_table_free(&one);
    sp_table_free(&two);
}

/* Rows whose distances begin anew are another group, told apart by their number of grains; frictions by theirs. */
static void test_groups(void **state) {
    (void)state;
    const double cells[4][4] = {{5, 20, 200, 0.5}, {10, 40, 200, 0.5}, {5, 21, 400, 0.5}, {10, 42, 400, 0.5}};
    sp_table t = table_of("distance t10 grains friction", 4, cells[0]);
    const sp_plot_table shown = {"planes", &t, false};
    assert_ok(sp_plot_fronts(1, &shown, NULL, svg, &err));
    says((const char *[]){"\nN = 200\n", "\nN = 400\n", NULL});
    t.cells[2 * 4 + 3].number = t.cells[3 * 4 + 3].number = 0;
    t.cells[2 * 4 + 2].number = t.cells[3 * 4 + 2].number = 200;
    assert_ok(sp_plot_fronts(1, &shown, NULL, svg, &err));
    says((const char *[]){"\n\xce\xbc = 0\n", "\n\xce\xbc = 0.5\n", NULL});
    sp_table_free(&t);
}

/* The unit of an axis is that of the tables, and none where they say none; tables must agree. */
static void test_units(void **state) {
    (void)state;
    const double cells[2][2] = {{5, 20}, {10, 40}};
    const char *const unit[3][2] = {{"d", "d/sqrt(E* / rho)"}, {"mm", "us"}, {"", ""}};
    sp_table t[3];
    for (int j = 0; j < 3; j++) {
        t[j] = sp_table_none();
        assert_ok(sp_table_add_column(&t[j], "distance", unit[j][0], SP_COLUMN_NUMBER, &err));
        assert_ok(sp_table_add_column(&t[j], "t10", unit[j][1], SP_COLUMN_NUMBER, &err));
        for (int k = 0; k < 2; k++)
            assert_ok(sp_table_add_numbers(&t[j], cells[k], &err));
    }
    const sp_plot_table shown[3] = {{"a", &t[0], false}, {"b", &t[1], false}, {"c", &t[2], false}};
    assert_ok(sp_plot_fronts(1, &shown[0], NULL, svg, &err));
    says((const char *[]){"\ndistance  [d]\n", "\nt  [d (", NULL});
    assert_ok(sp_plot_fronts(1, &shown[1], NULL, svg, &err));
    says((const char *[]){"\ndistance  [mm]\n", "\nt  [\xc2\xb5s]\n", NULL});
    assert_ok(sp_plot_fronts(1, &shown[2], NULL, svg, &err));
    says((const char *[]){"\ndistance\n", "\nt\n", NULL});
    assert_fails(sp_plot_fronts(2, shown, NULL, svg, &err), SP_EINVAL, "distance d mm");
    for (int j = 0; j < 3; j++)
        sp_table_free(&t[j]);
}

/* A table of `chain front': width is that of the pulse, grains the distance. */
static void test_chain(void **state) {
    (void)state;
    const double cells[2][10] = {{10, 9, 11, 13, .5, 4, 2, .5, .3, .25}, {20, 19, 21, 24, .35, 5, 3, .55, .31, .28}};
    sp_table t = table_of("grains t10 t_peak t_zero amplitude width width_peak gamma alpha alpha_peak", 2, cells[0]);
    const sp_plot_table shown = {"chain", &t, false};
    assert_ok(sp_plot_fronts(1, &shown, NULL, svg, &err));
    says((const char *[]){"\nt_10,  c = 1\n", NULL});
    assert_ok(sp_plot_scaling(1, &shown, svg, &err));
    says((const char *[]){"\nt_zero \xe2\x88\x92 t_10\n", "\nA\n", "\nW\n", NULL});
    sp_table_free(&t);
}

/* Comments tell tables apart where they differ in them, and names where they do not, or not all of them. */
static void test_labels_of_ensembles(void **state) {
    (void)state;
    const double cells[3][5] = {{0, 0, 0, 0, 0}, {1, 1e-3, 2e-3, 5e-4, 2e-3}, {2, -1e-3, 1e-3, -2e-3, 0}};
    static const char *const friction[] = {"0", "0.5", "0.5"}, *const pressure[] = {"1e-06", "1e-06", "0.0001"};
    sp_table t[3];
    sp_plot_table shown[3];
    static const char *const names[] = {"x", "y", "z"};
    for (int k = 0; k < 3; k++) {
        t[k] = table_of("t mean rms low high", 3, cells[0]);
        assert_ok(sp_table_add_comment(&t[k], &err, "samples = %d", k + 2));
        assert_ok(
            sp_table_add_comment(&t[k], &err, "pressure = %s, width = 24, friction = %s", pressure[k], friction[k]));
        assert_ok(sp_table_add_comment(&t[k], &err, "packing.friction = %s", friction[k]));
        assert_ok(sp_table_add_comment(&t[k], &err, "mean_err: error; low, high: its interval at level %s, by t",
                                       k < 2 ? "0.95" : "0.68"));
        shown[k] = (sp_plot_table){names[k], &t[k], false};
    }
    assert_ok(sp_plot_ensemble(1, shown, svg, &err));
    says((const char *[]){"\nmean, 95% interval\n", NULL});
    assert_ok(sp_plot_ensemble(2, shown, svg, &err));
    says((const char *[]){"\n\xce\xbc = 0\n", "\n\xce\xbc = 0.5\n", "\nmean, 95% interval\n", NULL});
    assert_ok(sp_plot_ensemble(3, shown, svg, &err)); /* levels differ */
    says((const char *[]){"\np = 10^\xe2\x88\x92"
                          "6 E*, \xce\xbc = 0\n",
                          "\np = 10^\xe2\x88\x92"
                          "4 E*, \xce\xbc = 0.5\n",
                          "\nmean, interval\n", NULL});
    shown[2].table = &t[1]; /* twice the same: names */
    assert_ok(sp_plot_ensemble(3, shown, svg, &err));
    says((const char *[]){"\nx\n", "\ny\n", "\nz\n", NULL});
    for (int k = 0; k < 3; k++)
        sp_table_free(&t[k]);
}

/* Curves that fill the frame: the legend of two tables stands above it, and y ends where the curves do. */
static void test_range_of_ensembles(void **state) {
    (void)state;
    enum { N = 400 };
    static double cells[N][3];
    for (int k = 0; k < N; k++) {
        cells[k][0] = k;
        cells[k][1] = k % 2 * 1e-3;
        cells[k][2] = 5e-4;
    }
    sp_table t = table_of("t mean rms", N, cells[0]);
    const sp_plot_table shown[2] = {{"x", &t, false}, {"y", &t, false}};
    assert_ok(sp_plot_ensemble(2, shown, svg, &err));
    char *text = drawn();
    assert_non_null(strstr(text, "\n1.0\n"));
    assert_null(strstr(text, "\n1.2\n"));
    free(text);
    sp_table_free(&t);
}

static void test_ensemble_modes_section(void **state) {
    (void)state;
    const double cells[3][3] = {{0, 0, 0}, {1, 1e-3, 2e-3}, {2, -1e-3, INFINITY}};
    sp_table t = table_of("t mean rms", 3, cells[0]);
    const sp_plot_table shown[2] = {{"x", &t, false}, {"y", &t, false}};
    assert_ok(sp_plot_ensemble(1, shown, svg, &err));
    says((const char *[]){"\nmean\n", "\nrms deviation\n",
                          "\nF_sig  [10^\xe2\x88\x92"
                          "3 E* d^2]\n",
                          NULL});
    assert_ok(sp_plot_ensemble(2, shown, svg, &err));
    says((const char *[]){"\nx\n", "\ny\n", "\nmean\n", "\nrms deviation\n", NULL});
    sp_table_free(&t);
    double modes[60][3];
    for (int k = 0; k < 60; k++) {
        modes[k][0] = k;
        modes[k][1] = k < 5 ? 0 : 0.01 * k;
        modes[k][2] = sin(k);
    }
    t = table_of("n omega ab", 60, modes[0]);
    assert_ok(sp_plot_modes(&t, svg, &err));
    says((const char *[]){"\n(a)\n", "\n(b)\n", "\xcf\x89_n^2", "a_n b_n", NULL});
    sp_table_free(&t);
    t = table_of("n omega x", 3, modes[0]);
    assert_ok(sp_plot_modes(&t, svg, &err));
    char *text = drawn();
    assert_null(strstr(text, "\n(b)\n"));
    free(text);
    sp_table_free(&t);
    const double time[3] = {0, 1, 2}, force[3] = {0, 1, NAN}, nothing[3] = {0, 0, 0};
    const sp_plot_record record[3] = {{5, 3, time, force, NULL, NULL, NULL},
                                      {10, 3, time, nothing, NULL, NULL, NULL},
                                      {15, 0, time, force, NULL, NULL, NULL}};
    assert_ok(sp_plot_section(3, record, svg, &err));
    says((const char *[]){"\ndistance  [d]\n", "\n10\n", NULL});
    const sp_plot_record numbered[2] = {{NAN, 3, time, force, NULL, NULL, NULL},
                                        {NAN, 3, time, force, NULL, NULL, NULL}};
    assert_ok(sp_plot_section(2, numbered, svg, &err));
    says((const char *[]){"\nnumber\n", NULL});
}

static void test_contacts_and_motion(void **state) {
    (void)state;
    sp_packing p = reference_packing(PACKING);
    const sp_network_options o = sp_network_options_default();
    sp_network net = sp_network_none();
    sp_contact_counts c = sp_contact_counts_none();
    sp_table angles = sp_table_none(), values = sp_table_none();
    assert_ok(sp_contact_counts_add(&c, &p, 1e-4, 3, &err));
    assert_ok(sp_contact_angles_table(&c, &angles, &err));
    assert_ok(sp_contact_values_table(&c, &values, &err));
    assert_ok(sp_plot_angles(&angles, svg, &err));
    says((const char *[]){"\nall contacts\n", "\n90\xc2\xb0\n", "\n180\xc2\xb0\n", "\nstrong: F &gt;", NULL});
    assert_ok(sp_plot_contact_values(&values, svg, &err));
    says((const char *[]){"\nnormal force\n", "\nprobability density\n", NULL});
    assert_ok(sp_network_make(&p, &o, &net, &err));
    double *u = calloc((size_t)sp_network_dofs(&net), sizeof *u);
    assert_non_null(u);
    assert_ok(sp_plot_snapshot(&p, &net, u, 0, svg, &err)); /* nothing moves */
    says((const char *[]){"t = 0 d", NULL});
    const double t = 20;
    const sp_field_options spec = {.times = 1, .t = &t};
    assert_ok(sp_signal_field(&net, &spec, u, NULL, &err));
    assert_ok(sp_plot_snapshot(&p, &net, u, t, svg, &err));
    says((const char *[]){"t = 20 d", "longer, cut\n", "\n= ", " d\n", NULL});
    u[7] = NAN;
    assert_fails(sp_plot_snapshot(&p, &net, u, t, svg, &err), SP_EREFUSED, "7");
    sp_packing other = chain_packing(5, 1e-4);
    assert_fails(sp_plot_snapshot(&other, &net, u, t, svg, &err), SP_EINVAL, "200 5");
    sp_packing_free(&other);
    free(u);
    sp_table_free(&angles);
    sp_table_free(&values);
    sp_network_free(&net);
    sp_packing_free(&p);
}

/* ---- refusals --------------------------------------------------------------------------------------------------- */

static void refuse_fronts(int column, double value, const char *reason) {
    double cells[3][13];
    memcpy(cells, scaling, sizeof cells);
    cells[1][column] = value;
    sp_table t = table_of(SCALING, 3, cells[0]);
    const sp_plot_table shown = {"x", &t, false};
    assert_fails(sp_plot_scaling(1, &shown, svg, &err), SP_EREFUSED, reason);
    sp_table_free(&t);
}

static void test_refusals(void **state) {
    (void)state;
    refuse_fronts(2, -1, "2 distance -1");
    refuse_fronts(2, 0, "2 distance 0");
    refuse_fronts(3, INFINITY, "2 t10 inf");
    refuse_fronts(4, -1, "2 t10_err -1");
    refuse_fronts(7, -1, "2 amplitude -1");
    const double cells[2][3] = {{1, 2, 3}, {2, -3, NAN}}, nans[2][3] = {{1, NAN, NAN}, {2, NAN, NAN}};
    sp_table t = table_of("a b c", 2, cells[0]);
    const sp_plot_table shown[7] = {{"x", &t, false}, {"x", &t, false}, {"x", &t, false}, {"x", &t, false},
                                    {"x", &t, false}, {"x", &t, false}, {"x", &t, false}};
    assert_fails(sp_plot_fronts(1, shown, NULL, svg, &err), SP_EINVAL, "distance grains");
    assert_fails(sp_plot_fronts(2, shown, NULL, svg, &err), SP_EINVAL, "1");
    assert_fails(sp_plot_ensemble(1, shown, svg, &err), SP_EINVAL, "t");
    assert_fails(sp_plot_ensemble(7, shown, svg, &err), SP_EINVAL, "7");
    assert_fails(sp_plot_modes(&t, svg, &err), SP_EINVAL, "n");
    assert_fails(sp_plot_angles(&t, svg, &err), SP_EINVAL, "angle");
    assert_fails(sp_plot_contact_values(&t, svg, &err), SP_EINVAL, "x");
    sp_table_free(&t);
    t = table_of("t mean rms", 2, nans[0]);
    assert_fails(sp_plot_ensemble(1, shown, svg, &err), SP_EREFUSED, "1");
    sp_table_free(&t);
    t = table_of("distance t10 x", 2, nans[0]);
    assert_fails(sp_plot_fronts(1, shown, NULL, svg, &err), SP_EREFUSED, "1");
    assert_fails(sp_plot_scaling(1, shown, svg, &err), SP_EREFUSED, "gamma alpha");
    sp_table_free(&t);
    t = table_of("angle all weak", 2, cells[0]);
    assert_fails(sp_plot_angles(&t, svg, &err), SP_EREFUSED, "2 -3");
    sp_table_free(&t);
    t = table_of("n omega ab", 0, NULL);
    assert_fails(sp_plot_modes(&t, svg, &err), SP_EREFUSED, "");
    assert_fails(sp_plot_fronts(0, shown, NULL, svg, &err), SP_EINVAL, "0");
    sp_table_free(&t);
    sp_plot_record record = {INFINITY, 0, NULL, NULL, NULL, NULL, NULL};
    const sp_plot_record some[2] = {{1, 0, NULL, NULL, NULL, NULL, NULL}, {NAN, 0, NULL, NULL, NULL, NULL, NULL}};
    assert_fails(sp_plot_section(1, &record, svg, &err), SP_EINVAL, "distance inf");
    assert_fails(sp_plot_section(2, some, svg, &err), SP_EINVAL, "2 0 points distance nan");
    record = (sp_plot_record){1, 0, NULL, NULL, NULL, NULL, NULL};
    assert_fails(sp_plot_section(1, &record, svg, &err), SP_EREFUSED, "1");
    assert_int_equal(access(svg, F_OK), -1);
}

/* Two and three rows are too few to merge any: this divided by zero once. */
static void test_few_angles(void **state) {
    (void)state;
    const double cells[3][3] = {{0, 1, 1}, {60, 2, 1}, {120, 3, 1}};
    for (int rows = 2; rows <= 3; rows++) {
        sp_table t = table_of("angle all weak", rows, cells[0]);
        assert_ok(sp_plot_angles(&t, svg, &err));
        assert_int_equal(unlink(svg), 0);
        sp_table_free(&t);
    }
}

static sp_status draw_some(const sp_plot_table *shown, const sp_plot_table *ensemble) {
    sp_status status = sp_plot_fronts(1, shown, NULL, svg, NULL);
    if (status == SP_OK)
        status = sp_plot_scaling(1, shown, svg, NULL);
    return status == SP_OK ? sp_plot_ensemble(1, ensemble, svg, NULL) : status;
}

static void test_memory(void **state) {
    (void)state;
    const double cells[2][3] = {{0, 0, 0}, {1, 1, 1}};
    sp_table t = table_of(SCALING, 6, scaling[0]), e = table_of("t mean rms", 2, cells[0]);
    const sp_plot_table shown = {"x", &t, false}, ensemble = {"x", &e, false};
    /* every third, for time: what is kept of a figure of many bytes grows step by step */
    for (int64_t k = 0;; k += 3) {
        sp_alloc_fail_after(k);
        const sp_status status = draw_some(&shown, &ensemble);
        sp_alloc_fail_after(-1);
        if (status == SP_OK)
            break;
        assert_int_equal(status, SP_ENOMEM);
    }
    sp_table_free(&t);
    sp_table_free(&e);
}

/* Signals in different known units have no common axis. */
static void test_mixed_signals(void **state) {
    (void)state;
    const double t[3] = {0, 1, 2}, f[3] = {0, 1, 0};
    remove(svg);
    static const char *const unit[][2] = {{"us", "N"}, {NULL, NULL}, {"s", "N"}, {"us", "V"}};
    for (int k = 1; k < 4; k++) {
        sp_error err = {0};
        const sp_plot_trace trace[3] = {{"x", 3, t, f, 0.1, 1, 2, "", "", NULL},
                                        {"y", 3, t, f, 0.1, 1, 2, unit[0][0], unit[0][1], NULL},
                                        {"z", 3, t, f, 0.1, 1, 2, unit[k][0], unit[k][1], NULL}};
        assert_int_equal(sp_plot_signal(3, trace, svg, &err), SP_EINVAL);
        assert_non_null(strstr(err.text, k == 3 ? "F in N" : "t in us"));
        assert_int_not_equal(access(svg, F_OK), 0);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_fronts),
                                       cmocka_unit_test(test_chain),
                                       cmocka_unit_test(test_groups),
                                       cmocka_unit_test(test_units),
                                       cmocka_unit_test(test_mixed_signals),
                                       cmocka_unit_test(test_labels_of_ensembles),
                                       cmocka_unit_test(test_range_of_ensembles),
                                       cmocka_unit_test(test_ensemble_modes_section),
                                       cmocka_unit_test(test_contacts_and_motion),
                                       cmocka_unit_test(test_refusals),
                                       cmocka_unit_test(test_few_angles),
                                       cmocka_unit_test(test_memory)};
    return cmocka_run_group_tests(tests, setup, teardown);
}
