/* The paper beside our values: verdicts, constants, ensembles, folders. */
#include "base/base.h"
#include "paper/blackmore.h"
#include "paper/claims.h"
#include "paper/counts.h"
#include "paper/fronts.h"
#include "paper/lattice.h"
#include "paper/paper.h"
#include "test.h"

#include <sys/stat.h>
#include <unistd.h>

/* fontconfig, behind cairo, keeps offsets in place of pointers: the leak checker cannot see that its memory is held. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) { return "leak:libfontconfig"; }
const char *__lsan_default_options(void);
const char *__lsan_default_options(void) { return "print_suppressions=0"; }

static paper_row judged(paper_scatter scatter, double value, double sd, double ours, double err) {
    paper_row row = {
        .paper = value, .paper_sd = sd, .scatter = scatter, .ours = ours, .ours_sd = 2 * err, .err = err, .samples = 4};
    sp_paper_judge(&row);
    return row;
}

static void verdicts(void **state) {
    (void)state;
    const double se = 0.4 / sqrt(30);
    paper_row r = judged(PAPER_SCATTER_PAPER, 3, 0.4, 3.1, 0.02);
    assert_close(r.sigma, 0.25, 1e-12);
    assert_close(r.combined, 0.1 / hypot(se, 0.02), 1e-12);
    assert_string_equal(r.verdict, "agrees");
    r = judged(PAPER_SCATTER_PAPER, 3, 0.5, 2.5, 0.02); /* exactly one */
    assert_close(r.sigma, -1, 0);
    assert_string_equal(r.verdict, "agrees");
    r = judged(PAPER_SCATTER_PAPER, 3, 0.5, 2.4999, 0.02);
    assert_string_equal(r.verdict, "deviates");
    r = judged(PAPER_SCATTER_PAPER, 3, 0.5, 3.6, NAN); /* one sample: sigma needs no error of ours */
    assert_close(r.sigma, 1.2, 1e-12);
    assert_true(isnan(r.combined));
    assert_string_equal(r.verdict, "deviates");
    r = judged(PAPER_SCATTER_PAPER, 3, 0.5, NAN, NAN);
    assert_true(isnan(r.sigma));
    assert_string_equal(r.verdict, "missing");
}

static const char *claimed(paper_relation relation, double limit, double within, double ours, double err) {
    paper_row row = {.paper = limit,
                     .paper_sd = within,
                     .scatter = PAPER_SCATTER_CLAIM,
                     .relation = relation,
                     .ours = ours,
                     .err = err};
    sp_paper_judge(&row);
    assert_true(isnan(row.sigma) && isnan(row.combined) && isnan(row.deviation_err));
    return row.verdict;
}

static void verdicts_on_claims(void **state) {
    (void)state;
    assert_string_equal(claimed(PAPER_BELOW, 1.1, NAN, 1.0, 0.04), "holds");
    assert_string_equal(claimed(PAPER_BELOW, 1.1, NAN, 1.0, 0.06), "undecided");
    assert_string_equal(claimed(PAPER_BELOW, 1.1, NAN, 1.15, 0.03), "undecided");
    assert_string_equal(claimed(PAPER_BELOW, 1.1, NAN, 1.21, 0.03), "contradicted");
    assert_string_equal(claimed(PAPER_ABOVE, 1, NAN, 1.4, 0.04), "holds");
    assert_string_equal(claimed(PAPER_ABOVE, 1, NAN, 0.9, 0.04), "contradicted");
    assert_string_equal(claimed(PAPER_EQUAL, -1, 0.01, -0.999, 0), "holds");
    assert_string_equal(claimed(PAPER_EQUAL, -1, 0.01, -1.02, 0), "contradicted");
    assert_string_equal(claimed(PAPER_EQUAL, 0, 0.01, 0.009, 0.002), "undecided");
    assert_string_equal(claimed(PAPER_BELOW, 1, NAN, 0.5, NAN), "missing"); /* one sample: nothing is known */
    assert_string_equal(claimed(PAPER_BELOW, 1, NAN, NAN, 0), "missing");
}

/* Printed to 0.1: uniform within 0.05, a standard deviation of 0.1/sqrt(12). */
static void verdicts_and_print(void **state) {
    (void)state;
    paper_row row = {.paper = 3,
                     .paper_sd = 0.3 * sqrt(30),
                     .digit = 0.1 * sqrt(12),
                     .scatter = PAPER_SCATTER_PAPER,
                     .ours = 4,
                     .ours_sd = 1,
                     .err = 0.4};
    sp_paper_judge(&row);
    assert_close(row.combined, 2, 1e-12);
    assert_close(row.deviation_err, 1 / sqrt(0.26), 1e-12);
    row.digit = 0;
    sp_paper_judge(&row);
    assert_close(row.deviation_err, 2, 1e-12);
}

static paper_row off_by(int item, const char *quantity, double errors) {
    paper_row row = {.item = item, .paper = 1, .paper_sd = 0.3 * sqrt(30), .ours = 1 + 0.5 * errors, .err = 0.4};
    snprintf(row.quantity, sizeof row.quantity, "%s", quantity);
    sp_paper_judge(&row);
    return row;
}

static void counts_and_families(void **state) {
    (void)state;
    paper_row rows[] = {
        off_by(PAPER_TABLE_1, "a", 0.5),  off_by(PAPER_TABLE_1, "a", 2.5), off_by(PAPER_TABLE_1, "a", 3.5),
        off_by(PAPER_TABLE_1, "b", 0.9),  off_by(PAPER_TABLE_1, "b", 0.1), off_by(PAPER_TABLE_1, "b", 0.3),
        off_by(PAPER_TABLE_2, "b", -2.5), off_by(PAPER_TABLE_2, "b", 2.5), off_by(PAPER_TABLE_2, "b", 2.1),
        off_by(PAPER_FIG(6), "c", -1.5),  off_by(PAPER_TABLE_2, "b", NAN)};
    enum { ROWS = sizeof rows / sizeof *rows };
    rows[9].scatter = PAPER_SCATTER_STATED;
    const paper_counts one = sp_paper_count(ROWS, rows, PAPER_TABLE_1, PAPER_SORT_MEANS),
                       all = sp_paper_count(ROWS, rows, -1, PAPER_SORT_MEANS),
                       stated = sp_paper_count(ROWS, rows, -1, PAPER_SORT_STATED);
    assert_true(one.values == 6 && one.judged == 6 && one.within1 == 4 && one.beyond2 == 2 && one.beyond3 == 1);
    assert_close(one.chi2, 0.25 + 6.25 + 12.25 + 0.81 + 0.01 + 0.09, 1e-12);
    assert_close(one.chi2_bare, one.chi2, 1e-12);
    assert_true(all.values == 9 && all.missing == 1 && all.beyond2 == 5 && stated.values == 1);
    int64_t at = 0;
    paper_family f = sp_paper_family_next(ROWS, rows, &at);
    assert_true(at == 3 && f.values == 3 && f.side == 1 && sp_paper_is_systematic(&f));
    assert_close(f.together, 6.5 / sqrt(3), 1e-12);
    assert_close(f.low, 0.25, 1e-12);
    assert_close(f.high, 1.75, 1e-12);
    f = sp_paper_family_next(ROWS, rows, &at);
    assert_true(at == 6 && f.side == 1 && !sp_paper_is_systematic(&f)); /* on one side, but near */
    f = sp_paper_family_next(ROWS, rows, &at);
    assert_true(at == 9 && f.side == 0 &&
                sp_paper_is_systematic(&f)); /* the same name in another item; none within 2 */
    f = sp_paper_family_next(ROWS, rows, &at);
    assert_true(at == 10 && f.values == 1 && !sp_paper_is_systematic(&f));
    sp_table t = sp_table_none();
    assert_ok(sp_paper_add_counts(ROWS, rows, &t, &err));
    assert_string_equal(t.comment[0],
                        "count: table1 values 6 agree 5 missing 0 judged 6 within1 4 beyond2 2 beyond3 1 chi2 19.7 "
                        "chi2_without_rounding 19.7");
    sp_table_free(&t);
}

static void sums(void **state) {
    (void)state;
    paper_sum s = {0};
    sp_paper_sum_add(&s, 1);
    assert_true(isnan(sp_paper_sum_err(&s)));
    sp_paper_sum_add(&s, NAN);
    sp_paper_sum_add(&s, 2);
    sp_paper_sum_add(&s, 6);
    assert_close(sp_paper_sum_mean(&s), 3, 1e-15);
    assert_close(sp_paper_sum_err(&s), sqrt(7.0 / 3), 1e-14);
}

static const char *verdict_of(blackmore_row row) {
    sp_blackmore_set_verdict(&row);
    return row.verdict;
}

static void verdicts_on_the_column(void **state) {
    (void)state;
    blackmore_row row = {.paper = 2.5, .precision = 0.05, .ours = 2.54, .err = 0};
    assert_string_equal(verdict_of(row), "agrees");
    row.ours = 2.56;
    assert_string_equal(verdict_of(row), "deviates");
    row.err = 0.02;
    assert_string_equal(verdict_of(row), "agrees");
    row.err = NAN; /* no bound: none is taken */
    assert_string_equal(verdict_of(row), "deviates");
    row.misprint = true;
    assert_string_equal(verdict_of(row), "erratum");
    row.ours = 2.5; /* what is printed is right after all */
    assert_string_equal(verdict_of(row), "agrees");
    row.paper = NAN;
    assert_string_equal(verdict_of(row), "erratum");
    row.misprint = false;
    assert_string_equal(verdict_of(row), "not given");
    row.ours = NAN;
    assert_string_equal(verdict_of(row), "missing");
    row = (blackmore_row){.relation = BLACKMORE_ABOVE, .paper = 0, .ours = 0.1, .err = 0.05};
    assert_string_equal(verdict_of(row), "agrees");
    row.err = 0.2; /* above by less than its error */
    assert_string_equal(verdict_of(row), "deviates");
    row = (blackmore_row){.relation = BLACKMORE_BELOW, .paper = 0, .ours = -0.1, .err = 0.05};
    assert_string_equal(verdict_of(row), "agrees");
    row.ours = 0;
    assert_string_equal(verdict_of(row), "deviates");
    row = (blackmore_row){.claim = true, .relation = BLACKMORE_ABOVE, .paper = 4, .ours = 0.1, .err = 0.01};
    assert_string_equal(verdict_of(row), "contradicted");
    row.ours = 4.005;
    assert_string_equal(verdict_of(row), "undecided");
    row.ours = 5;
    assert_string_equal(verdict_of(row), "holds");
    row = (blackmore_row){.claim = true, .paper = 0, .precision = 0.01, .ours = 0.4, .err = 0.5};
    assert_string_equal(verdict_of(row), "undecided");
    row.err = 0.1;
    assert_string_equal(verdict_of(row), "contradicted");
    row.ours = 0.005;
    assert_string_equal(verdict_of(row), "holds");
    row = (blackmore_row){.misprint = true, .paper = -INFINITY, .ours = 0};
    assert_string_equal(verdict_of(row), "erratum");
}

static void verdicts_without_scatter(void **state) {
    (void)state;
    paper_row r = judged(PAPER_SCATTER_OURS, 1.3, NAN, 1.35, 0.02); /* our sd: 0.04 */
    assert_close(r.sigma, 1.25, 1e-9);
    assert_close(r.combined, 0.05 / hypot(0.04 / sqrt(30), 0.02), 1e-9);
    assert_string_equal(r.verdict, "deviates");
    r = judged(PAPER_SCATTER_OURS, 1.3, NAN, 1.35, NAN); /* one sample: no scatter at all */
    assert_string_equal(r.verdict, "missing");
    r = judged(PAPER_SCATTER_STATED, 0.25, 0.003, 0.2546, 0.004);
    assert_close(r.sigma, 0.92, 1e-9); /* 0.003 and 0.004 make 0.005 */
    assert_string_equal(r.verdict, "agrees");
    r = judged(PAPER_SCATTER_STATED, 0.25, 0.003, 0.2546, NAN);
    assert_string_equal(r.verdict, "deviates");
    r = judged(PAPER_SCATTER_BOUND, 2.0 / 3, 0.01, 0.9, 0.01);
    assert_close(r.sigma, 0, 0);
    assert_string_equal(r.verdict, "agrees");
    r = judged(PAPER_SCATTER_BOUND, 2.0 / 3, 0.01, 0.6, 0.01);
    assert_string_equal(r.verdict, "deviates");
}

static void means(void **state) {
    (void)state;
    const double values[5] = {1, NAN, 2, 6, INFINITY};
    paper_row r = {0};
    sp_paper_row_mean(&r, 5, values);
    assert_int_equal(r.samples, 3);
    assert_close(r.ours, 3, 1e-15);
    assert_close(r.ours_sd, sqrt(7), 1e-15);
    assert_close(r.err, sqrt(7.0 / 3), 1e-15);
    sp_paper_row_mean(&r, 1, values);
    assert_close(r.ours, 1, 0);
    assert_true(isnan(r.ours_sd) && isnan(r.err));
    sp_paper_row_mean(&r, 0, values);
    assert_true(isnan(r.ours) && r.samples == 0);
}

static void table_of_rows(void **state) {
    (void)state;
    paper_row rows[2] = {judged(PAPER_SCATTER_PAPER, 3, 0.4, 3.1, 0.02), judged(PAPER_SCATTER_BOUND, 1, 0.1, NAN, NAN)};
    snprintf(rows[0].quantity, sizeof rows[0].quantity, "zs");
    rows[1].item = PAPER_FIG(12);
    sp_table t = sp_table_none();
    assert_ok(sp_paper_rows_table(2, rows, &t, &err));
    assert_int_equal(t.rows, 2);
    assert_string_equal(t.cells[0].text, "table1");
    assert_string_equal(t.cells[t.columns].text, "fig12");
    assert_string_equal(t.cells[2].text, "zs");
    assert_close(sp_table_number(&t, 0, sp_table_find_column(&t, "sigma")), 0.25, 1e-12);
    assert_string_equal(t.cells[sp_table_find_column(&t, "verdict")].text, "agrees");
    assert_string_equal(t.cells[t.columns + sp_table_find_column(&t, "scatter")].text, "bound");
    sp_table_free(&t);
    for (int64_t k = 0; k < 60; k += 3) { /* every kind of allocation on the way may fail */
        sp_error err = {0};
        sp_alloc_fail_after(k);
        const sp_status status = sp_paper_rows_table(2, rows, &t, &err);
        sp_alloc_fail_after(-1);
        if (status == SP_OK)
            sp_table_free(&t);
        else
            assert_int_equal(status, SP_ENOMEM);
    }
}

/* Numbers of the tables as they are printed, a few of each, and what all of them have in common. */
static void constants(void **state) {
    (void)state;
    static const struct {
        int item;
        const char *name;
        int at;
        double mean, sd;
    } known[] = {{PAPER_TABLE_1, "zs", 1, 3.23, 0.04},         {PAPER_TABLE_1, "f0", 3, 7.4, 1.5},
                 {PAPER_TABLE_1, "N_over_p", 0, 1.31, 0},      {PAPER_TABLE_1, "F2S", 3, 0.578, 0},
                 {PAPER_TABLE_2, "C22", 0, 13.9e-4, 0.8e-4},   {PAPER_TABLE_2, "C33", 1, 0.35e-3, 0.07e-3},
                 {PAPER_TABLE_4, "C22(2)/C22", 0, 0.74, 0.09}, {PAPER_TABLE_4, "C33(2)/C33", 3, 0.90, 0.07},
                 {PAPER_TABLE_5, "C22(3)/C22", 1, 1.07, 0.07}, {PAPER_TABLE_5, "C33(3)/C33", 0, 2.49, 0.69}};
    for (size_t k = 0; k < sizeof known / sizeof *known; k++) {
        int found = 0;
        for (int q = 0; q < sp_paper_quantity_count; q++)
            if (sp_paper_quantities[q].item == known[k].item &&
                strcmp(sp_paper_quantities[q].name, known[k].name) == 0) {
                assert_close(sp_paper_quantities[q].mean[known[k].at], known[k].mean, 0);
                assert_close(sp_paper_quantities[q].sd[known[k].at], known[k].sd, 0);
                found++;
            }
        assert_int_equal(found, 1);
    }
    assert_int_equal(sp_paper_quantity_count, 10 + 5 + 4 + 4);
    sp_sample s = {0};
    s.statics.zs = 4;
    s.moduli.c33 = 2;
    s.probe[SP_LINES_3].shear = 3;
    for (int q = 0; q < sp_paper_quantity_count; q++) {
        const paper_quantity *p = &sp_paper_quantities[q];
        if (p->item == PAPER_TABLE_5 && strcmp(p->name, "C33(3)/C33") == 0)
            assert_close(p->ours(&s), 1.5, 0);
        if (strcmp(p->name, "zs") == 0)
            assert_close(p->ours(&s), 4, 0);
    }
}

static void items(void **state) {
    (void)state;
    assert_null(sp_paper_item_name(-1));
    assert_null(sp_paper_item_name(SP_PAPER_ITEMS));
    for (int k = 0; k < SP_PAPER_ITEMS; k++) {
        char name[16];
        snprintf(name, sizeof name, k < 5 ? "table%d" : k < 17 ? "fig%d" : "claims", k < 5 ? k + 1 : k - 4);
        assert_string_equal(sp_paper_item_name(k), name);
        assert_non_null(sp_paper_item_title(k));
        assert_true(sp_paper_items[k].needs >= 1 && sp_paper_items[k].needs <= PAPER_NEEDS);
    }
}

static void ensembles(void **state) {
    (void)state;
    static const int64_t samples_of_30[PAPER_ENSEMBLES] = {
        [PAPER_SQUARE] = 120,  [PAPER_LOW] = 120,       [PAPER_SHORT] = 60,       [PAPER_TALL] = 30,
        [PAPER_TALLEST] = 15,  [PAPER_SMOOTH] = 30,     [PAPER_SPHERES] = 8,      [PAPER_LATTICE] = 20,
        [PAPER_UNEVEN] = 96,   [PAPER_UNEVEN_LOW] = 12, [PAPER_LATTICE_LONG] = 8, [PAPER_CHAIN_1] = 180,
        [PAPER_CHAIN_2] = 180, [PAPER_CHAIN_4] = 180};
    for (paper_ensemble e = PAPER_SQUARE; e < PAPER_ENSEMBLES; e++)
        for (int32_t n = 1; n <= 30; n += 29) {
            sp_scene scene = sp_scene_default();
            assert_ok(
                sp_paper_ensemble_scene(e, n, n == 1 ? SP_PROTOCOL_SOMFAI2005 : SP_PROTOCOL_DEFAULT, &scene, &err));
            assert_int_equal(scene.pack.protocol, n == 1 && scene.pack.kind == SP_PACK_PISTON ? SP_PROTOCOL_SOMFAI2005
                                                                                              : SP_PROTOCOL_DEFAULT);
            if (n == 30)
                assert_int_equal(sp_study_count(&scene), samples_of_30[e]);
            for (int64_t k = 0; k < sp_study_count(&scene); k++) {
                sp_scene one;
                assert_ok(sp_study_scene(&scene, k, &one, &err));
            }
            sp_scene_free(&scene);
            assert_true(sp_paper_ensemble_cost(e, n, SP_PROTOCOL_DEFAULT) > 0);
        }
}

static void lines(void **state) {
    (void)state;
    const double x[4] = {0, 1, 2, 3}, y[4] = {1, 3, 5, 7}, err[4] = {0.1, 0.1, 0.1, 0.1};
    paper_line l = sp_paper_line_fit(4, x, y, err);
    assert_close(l.slope, 2, 1e-15);
    assert_close(l.intercept, 1, 1e-15);
    assert_close(l.err, 0.1 / sqrt(5), 1e-15);
    assert_true(isnan(sp_paper_line_fit(1, x, y, err).slope) && isnan(sp_paper_line_fit(0, x, y, err).slope));
    paper_distance d[5] = {{.distance = 4}, {.distance = 8}, {.distance = 25}, {.distance = 49}, {.distance = 97}};
    for (int k = 0; k < 5; k++)
        d[k].amplitude = (paper_mean){7 * pow(d[k].distance, -1.5), 0, 0};
    assert_close(sp_paper_power(5, d, sp_paper_amplitude).slope, -1.5, 1e-12);
    paper_range r = sp_paper_fitted(5, d, false);
    assert_true(r.first == 1 && r.end == 4);
    r = sp_paper_fitted(5, d, true);
    assert_true(r.first == 1 && r.end == 5);
    r = sp_paper_fitted(0, d, false);
    assert_true(r.first == 0 && r.end == 0);
}

static void write_text(const char *folder, const char *name, const char *text) {
    char path[300];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static void folders(void **state) {
    (void)state;
    char folder[] = "/tmp/sonopack-paper-XXXXXX", path[100], file[120];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/report", folder);
    snprintf(file, sizeof file, "%s/report.md", path);
    assert_ok(sp_paper_check_folder(path, false, &err)); /* makes it */
    assert_ok(sp_paper_check_folder(path, false, &err)); /* empty */
    write_text(path, "report.md", "<!-- sonopack reproduce -->\n\nThis report is not finished.\n");
    assert_ok(sp_paper_check_folder(path, false, &err));
    write_text(path, "report.md", "<!-- sonopack reproduce -->\n\n# Done\n");
    assert_fails(sp_paper_check_folder(path, false, &err), SP_EINVAL, "--force");
    assert_ok(sp_paper_check_folder(path, true, &err));
    write_text(path, "report.md", "# My own\n");
    assert_fails(sp_paper_check_folder(path, true, &err), SP_EINVAL, "report");
    assert_fails(sp_paper_check_folder(file, true, &err), SP_EINVAL, "report.md");
    assert_fails(sp_paper_check_folder("", true, &err), SP_EINVAL, "3800");
    unlink(file);
    rmdir(path);
    rmdir(folder);
}

static bool stop(const sp_paper_progress *progress, void *user) {
    (void)progress;
    return ++*(int *)user < 2;
}

static void options(void **state) {
    (void)state;
    char folder[] = "/tmp/sonopack-paper-XXXXXX";
    assert_non_null(mkdtemp(folder));
    sp_store *store = NULL;
    sp_table t = sp_table_none();
    assert_ok(sp_store_open(folder, true, &store, &err));
    sp_paper_options o = sp_paper_options_default();
    o.samples = 0;
    assert_fails(sp_paper_reproduce(store, &o, NULL, NULL, &t, &err), SP_EINVAL, "samples 0");
    o = sp_paper_options_default();
    o.jobs = 0;
    assert_fails(sp_paper_reproduce(store, &o, NULL, NULL, &t, &err), SP_EINVAL, "jobs 0");
    o = sp_paper_options_default();
    o.items = UINT32_C(1) << SP_PAPER_ITEMS;
    assert_fails(sp_paper_reproduce(store, &o, NULL, NULL, &t, &err), SP_EINVAL, "items");
    o = sp_paper_options_default();
    o.figures = "gif";
    assert_fails(sp_paper_reproduce(store, &o, NULL, NULL, &t, &err), SP_EINVAL, "svg png pdf");
    o = sp_paper_options_default();
    o.items = UINT32_C(1) << PAPER_TABLE_1;
    int calls = 0;
    assert_fails(sp_paper_reproduce(store, &o, stop, &calls, &t, &err), SP_EINTERRUPTED, "0 120");
    o.items = UINT32_C(1) << PAPER_FIG(1); /* drawn only: without a folder there is nothing to do */
    assert_ok(sp_paper_reproduce(store, &o, NULL, NULL, &t, &err));
    assert_int_equal(t.rows, 0);
    sp_table_free(&t);
    sp_store_close(store);
    char command[64];
    snprintf(command, sizeof command, "rm -r %s", folder);
    assert_int_equal(system(command), 0);
}

/* Lattices only, from an empty store and then from a full one: whichever allocation fails, the call says so and frees
 * what it has. */
static void failing_allocations(void **state) {
    (void)state;
    static const int64_t after[] = {0, 3, 10, 40, 150, 600, 2000, 7000};
    char folder[] = "/tmp/sonopack-paper-XXXXXX", report[64], command[64];
    assert_non_null(mkdtemp(folder));
    snprintf(report, sizeof report, "%s/report", folder);
    sp_store *store = NULL;
    assert_ok(sp_store_open(folder, true, &store, &err));
    assert_ok(sp_paper_check_folder(report, false, &err));
    sp_paper_options o = sp_paper_options_default();
    o.items = UINT32_C(1) << PAPER_FIG(12);
    o.folder = report;
    sp_table t = sp_table_none();
    for (size_t k = 0; k < sizeof after / sizeof *after; k++) {
        sp_error err = {0};
        sp_alloc_fail_after(after[k]);
        const sp_status status = sp_paper_reproduce(store, &o, NULL, NULL, &t, &err);
        sp_alloc_fail_after(-1);
        assert_true(status == SP_OK || status == SP_ENOMEM || status == SP_EFAILED || status == SP_EIO);
        if (status == SP_OK)
            sp_table_free(&t);
        else
            assert_true(err.text[0] != '\0');
    }
    assert_ok(sp_paper_reproduce(store, &o, NULL, NULL, &t, &err));
    assert_int_equal(t.rows, 1);
    sp_table_free(&t);
    sp_store_close(store);
    snprintf(command, sizeof command, "rm -r %s", folder);
    assert_int_equal(system(command), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(verdicts),
                                       cmocka_unit_test(verdicts_on_the_column),
                                       cmocka_unit_test(verdicts_without_scatter),
                                       cmocka_unit_test(verdicts_on_claims),
                                       cmocka_unit_test(verdicts_and_print),
                                       cmocka_unit_test(counts_and_families),
                                       cmocka_unit_test(sums),
                                       cmocka_unit_test(means),
                                       cmocka_unit_test(table_of_rows),
                                       cmocka_unit_test(constants),
                                       cmocka_unit_test(items),
                                       cmocka_unit_test(ensembles),
                                       cmocka_unit_test(lines),
                                       cmocka_unit_test(folders),
                                       cmocka_unit_test(failing_allocations),
                                       cmocka_unit_test(options)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
