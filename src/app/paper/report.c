/* Writes the report: report.html and report.md, with figures and tables beside them. */
#include "base/base.h"
#include "paper/counts.h"
#include "paper/page.h"
#include "paper/paper.h"

#include <math.h>
#include <sonopack/version.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

sp_status sp_paper_report_begin(paper *p, sp_error *err) { return sp_paper_page_unfinished(p->opt->folder, err); }

typedef struct report {
    paper_page page;
    const paper *p;
} report;

/* ---- tables ----------------------------------------------------------------------------------------------------- */

enum { CELL = 64, CELLS = 8 };

static void number(char cell[CELL], const char *format, double x) {
    if (isfinite(x))
        snprintf(cell, CELL, format, x);
    else
        snprintf(cell, CELL, "–");
}

/* Number of decimal places for `digits` significant digits of x. zeros: keep trailing zeros. */
static int decimals(double x, int digits, bool zeros) {
    char text[40];
    snprintf(text, sizeof text, "%.*e", digits - 1, x);
    char *const exponent = strchr(text, 'e');
    const char *last = exponent - 1;
    while (!zeros && digits > 1 && *last == '0') {
        digits--;
        last--;
    }
    const int places = digits - 1 - atoi(exponent + 1);
    return places < 0 ? 0 : places > 9 ? 9 : places;
}

/* Writes a value and its error to the same decimal place: ours to two digits of the error, the paper's as printed. */
static void value(char *cell, double x, double error, bool printed) {
    if (!isfinite(x)) {
        snprintf(cell, CELL, "–");
        return;
    }
    if (!isfinite(error) || error <= 0) {
        snprintf(cell, CELL, "%.4g", x);
        return;
    }
    int places = decimals(error, 2, !printed);
    if (printed && decimals(x, 4, false) > places)
        places = decimals(x, 4, false);
    snprintf(cell, CELL, "%.*f ± %.*f", places, x, places, error);
}

static void row_cells(const paper_row *row, bool with_item, char cell[CELLS][CELL]) {
    int n = 0;
    if (with_item)
        snprintf(cell[n++], CELL, "%s", sp_paper_item_name(row->item));
    snprintf(cell[n++], CELL, "%s", row->quantity);
    number(cell[n++], "%.0e", row->p);
    if (row->scatter == PAPER_SCATTER_BOUND)
        snprintf(cell[n++], CELL, "≥ %.3g", row->paper);
    else
        value(cell[n++], row->paper, row->paper_sd, true);
    value(cell[n++], row->ours, row->err, false);
    number(cell[n++], "%+.2f", row->sigma);
    number(cell[n++], "%+.1f", row->deviation_err);
    snprintf(cell[n++], CELL, "%s", row->verdict);
}

/* Whether a row belongs to the table of an item, or (item < 0) to that of all values that do not agree. */
static bool in_table(const paper_row *row, int item) {
    return !sp_paper_is_claim(row) && (item >= 0 ? row->item == item : strcmp(row->verdict, "agrees") != 0);
}

static void table(report *r, int item) {
    static const char *const head[CELLS] = {"item", "quantity", "p", "paper", "ours", "σ", "s.e.", "verdict"};
    const int first = item >= 0, cells = CELLS - first;
    char text[CELLS][CELL];
    const char *cell[CELLS];
    int64_t rows = 0;
    for (int64_t k = 0; k < r->p->rows; k++)
        rows += in_table(&r->p->row[k], item);
    if (rows == 0)
        return;
    for (int k = 0; k < CELLS; k++)
        cell[k] = text[k];
    sp_paper_page_table(&r->page, cells, head + first);
    for (int64_t k = 0; k < r->p->rows; k++) {
        if (!in_table(&r->p->row[k], item))
            continue;
        row_cells(&r->p->row[k], item < 0, text);
        sp_paper_page_row(&r->page, cells, cell, r->p->row[k].verdict, -1);
    }
    sp_paper_page_table_end(&r->page);
}

enum { CLAIM_CELLS = 6 };

static void claim_cells(const paper_row *row, char cell[CLAIM_CELLS][2 * CELL]) {
    static const char *const sign[] = {[PAPER_EQUAL] = "", [PAPER_ABOVE] = "> ", [PAPER_BELOW] = "< "};
    snprintf(cell[0], 2 * CELL, "%s", row->where ? row->where : "–");
    snprintf(cell[1], 2 * CELL, "%s", row->quantity);
    if (row->relation == PAPER_EQUAL && row->paper_sd > 0)
        snprintf(cell[2], 2 * CELL, "%.4g ± %.2g", row->paper, row->paper_sd);
    else
        snprintf(cell[2], 2 * CELL, "%s%.4g", sign[row->relation], row->paper);
    value(cell[3], row->ours, row->err, false);
    snprintf(cell[4], 2 * CELL, "%s", row->verdict);
}

/* Whether a claim belongs to the table of an item, or (item < 0) to that of all claims that do not hold. */
static bool in_claims(const paper_row *row, int item) {
    return sp_paper_is_claim(row) && (item >= 0 ? row->item == item : strcmp(row->verdict, "holds") != 0);
}

static void claims_table(report *r, int item) {
    static const char *const head[CLAIM_CELLS] = {"in the paper", "claim", "paper", "ours", "verdict", "what was done"};
    char text[CLAIM_CELLS][2 * CELL];
    const char *cell[CLAIM_CELLS];
    int64_t rows = 0;
    for (int64_t k = 0; k < r->p->rows; k++)
        rows += in_claims(&r->p->row[k], item);
    if (rows == 0)
        return;
    sp_paper_page_table(&r->page, CLAIM_CELLS, head);
    for (int64_t k = 0; k < r->p->rows; k++) {
        const paper_row *row = &r->p->row[k];
        if (!in_claims(row, item))
            continue;
        claim_cells(row, text);
        for (int c = 0; c < CLAIM_CELLS - 1; c++)
            cell[c] = text[c];
        cell[CLAIM_CELLS - 1] = row->note;
        sp_paper_page_row(&r->page, CLAIM_CELLS, cell, row->verdict, CLAIM_CELLS - 1);
    }
    sp_paper_page_table_end(&r->page);
}

/* ---- parts ------------------------------------------------------------------------------------------------------ */

static void section(report *r, int item) {
    const paper_section *s = &r->p->section[item];
    sp_paper_page_heading(&r->page, sp_paper_items[item].name, sp_paper_items[item].title);
    sp_paper_page_paragraph(&r->page, "In the paper.", sp_paper_items[item].shows);
    sp_paper_page_paragraphs(&r->page, "Here.", s->text.data);
    table(r, item);
    claims_table(r, item);
    for (int k = 0; k < s->figures; k++)
        sp_paper_page_figure(&r->page, s->file[k], strcmp(r->p->opt->figures, "pdf") != 0, s->caption[k]);
}

/* ---- summary ---------------------------------------------------------------------------------------------------- */

static void lead(report *r) {
    const paper *p = r->p;
    const paper_counts means = sp_paper_count(p->rows, p->row, -1, PAPER_SORT_MEANS),
                       stated = sp_paper_count(p->rows, p->row, -1, PAPER_SORT_STATED);
    const paper_claims c = sp_paper_count_claims(p->rows, p->row);
    const int64_t values = p->rows - c.claims;
    if (p->rows == 0)
        sp_paper_page_paragraph(&r->page, "", "Only figures were asked for, which have no values to compare.");
    if (values > 0)
        sp_paper_page_format(
            &r->page, "By the scatter of one sample.",
            "Of %lld values of the paper %lld agree within one standard deviation, %lld deviate, and %lld "
            "could not be compared.",
            (long long)values, (long long)(means.agree + stated.agree),
            (long long)(means.values - means.agree + stated.values - stated.agree),
            (long long)(means.missing + stated.missing));
    if (means.judged > 0)
        sp_paper_page_format(
            &r->page, "By the standard errors of both means.",
            "Of %lld means that the paper prints %lld lie within one combined standard error, %lld beyond "
            "two and %lld beyond three; chi^2 = %.0f (%.0f without the rounding of print). This is the "
            "sharper measure, and shows differences that the scatter of one sample hides.",
            (long long)means.judged, (long long)means.within1, (long long)means.beyond2, (long long)means.beyond3,
            means.chi2, means.chi2_bare);
    if (c.claims > 0)
        sp_paper_page_format(
            &r->page, "Claims in words.",
            "Of %lld claims %lld hold, %lld are contradicted, %lld are undecided, and %lld could not be "
            "examined.",
            (long long)c.claims, (long long)c.hold, (long long)c.contradicted, (long long)c.undecided,
            (long long)c.missing);
}

enum { COUNT_CELLS = 9 };

static void count_row(report *r, const char *name, const paper_counts *c) {
    char text[COUNT_CELLS][CELL];
    const char *cell[COUNT_CELLS];
    const int64_t whole[] = {c->values, c->agree, c->judged, c->within1, c->beyond2, c->beyond3};
    if (c->values + c->missing == 0)
        return;
    snprintf(text[0], CELL, "%s", name);
    for (int k = 0; k < 6; k++)
        snprintf(text[k + 1], CELL, "%lld", (long long)whole[k]);
    number(text[7], "%.1f", c->judged > 0 ? c->chi2 : NAN);
    number(text[8], "%.1f", c->judged > 0 ? c->chi2_bare : NAN);
    for (int k = 0; k < COUNT_CELLS; k++)
        cell[k] = text[k];
    sp_paper_page_row(&r->page, COUNT_CELLS, cell, "", -1);
}

static void counts_table(report *r) {
    static const char *const head[COUNT_CELLS] = {
        "",         "values",   "within 1 σ", "with errors",     "within 1 s.e.",
        "beyond 2", "beyond 3", "chi^2",      "without rounding"};
    const paper *p = r->p;
    sp_paper_page_table(&r->page, COUNT_CELLS, head);
    for (int item = 0; item < SP_PAPER_ITEMS; item++) {
        const paper_counts c = sp_paper_count(p->rows, p->row, item, PAPER_SORT_MEANS);
        count_row(r, sp_paper_item_name(item), &c);
    }
    const paper_counts means = sp_paper_count(p->rows, p->row, -1, PAPER_SORT_MEANS),
                       stated = sp_paper_count(p->rows, p->row, -1, PAPER_SORT_STATED);
    count_row(r, "all means", &means);
    count_row(r, "stated in words", &stated);
    sp_paper_page_table_end(&r->page);
}

/* Caveats: the error of the paper's mean is unknown if few packings dominate it, and the values of one table come from
 * the same packings. */
static void systematic(report *r) {
    const paper *p = r->p;
    int64_t found = 0, families = 0;
    for (int64_t at = 0; at < p->rows;) {
        const paper_family f = sp_paper_family_next(p->rows, p->row, &at);
        families += f.values >= 3;
        if (!sp_paper_is_systematic(&f))
            continue;
        if (found++ == 0)
            sp_paper_page_paragraph(
                &r->page, "Systematic deviations.",
                "Quantities that lie on one side of the paper at all pressures, and together beyond "
                "three errors; or off at all pressures, none within two errors:");
        sp_paper_page_format(&r->page, "",
                             "%s, %s: %s at all %lld pressures, by %+.1f%% to %+.1f%%; %+.1f errors together.",
                             sp_paper_item_name(f.first->item), f.first->quantity,
                             f.side > 0   ? "high"
                             : f.side < 0 ? "low"
                                          : "off, on both sides,",
                             (long long)f.values, 100 * f.low, 100 * f.high, f.together);
    }
    if (families > 0 && found == 0)
        sp_paper_page_paragraph(&r->page, "Systematic deviations.", "None.");
}

static void explain(report *r) {
    sp_paper_page_paragraph(
        &r->page, "How to read the tables.",
        "Paper: mean and one standard deviation of its samples. Ours: mean and its standard error. σ: the "
        "difference over one standard deviation of the paper; where it gives none (normal forces, their moments, "
        "fabric) over that of our samples; for values that the paper states in words over the precision of the "
        "words and our standard error together, and 0 above a lower bound (≥). A value agrees when σ is within "
        "one; with few samples more of them deviate by chance. Missing: ours has no value, or a single sample no "
        "scatter. s.e.: the difference over the standard errors of both means together, 30 samples taken for the "
        "paper, "
        "and the rounding of print (uniform within half of the last digit). Values of one table come from the same "
        "packings, so that chi^2 is no sum of independent parts. Claims hold or are contradicted where ours is two "
        "standard errors away from the limit, else they are undecided.");
}

static void summary(report *r) {
    const paper *p = r->p;
    sp_paper_page_heading(&r->page, "summary", "Summary");
    lead(r);
    if (p->rows > 0)
        counts_table(r);
    systematic(r);
    table(r, -1);
    claims_table(r, -1);
    explain(r);
    sp_paper_page_format(&r->page, "Run.",
                         "sonopack %s, reproduce somfai2005 with %d samples a pressure (2400 grains: half as many; "
                         "spheres: a quarter), protocol %s; "
                         "%lld samples made in this run, %lld that failed or lack a part; %.0f seconds.",
                         SONOPACK_VERSION, p->opt->samples, sp_paper_protocol_name(p->opt->protocol),
                         (long long)p->computed, (long long)p->failed, sp_clock_wall() - p->begun);
}

static void opening(report *r) {
    sp_paper_page_open(&r->page, "Elastic wave propagation in confined granular systems, computed again");
    sp_paper_page_paragraph(
        &r->page, "",
        "Tables and figures of E. Somfai, J.-N. Roux, J. H. Snoeijer, M. van Hecke, W. van Saarloos, Phys. Rev. E "
        "72, 021301 (2005), beside values and figures of new packings. Units: lengths in mean grain diameters d, "
        "pressures in E*, speeds in sqrt(E*/rho), times in d/sqrt(E*/rho).");
}

/* Saves the rows of an item as a table. */
static sp_status save_rows(paper *p, int item, sp_error *err) {
    int64_t first = 0, n = 0;
    for (int64_t k = 0; k < p->rows; k++)
        if (p->row[k].item == item && n++ == 0)
            first = k;
    if (n == 0)
        return SP_OK;
    char name[32];
    sp_table t = sp_table_none();
    snprintf(name, sizeof name, "%s%s", sp_paper_items[item].name,
             item < PAPER_FIG_1 || item > PAPER_FIG(12) ? "" : "-values");
    sp_status status = sp_paper_rows_table(n, p->row + first, &t, err);
    if (status == SP_OK)
        status = sp_paper_save_table(p, name, &t, err);
    sp_table_free(&t);
    return status;
}

sp_status sp_paper_report(paper *p, sp_error *err) {
    report r = {.p = p};
    sp_status status = SP_OK;
    opening(&r);
    summary(&r);
    for (int item = 0; item < SP_PAPER_ITEMS && status == SP_OK; item++) {
        if (!sp_paper_wants(p, item))
            continue;
        section(&r, item);
        status = save_rows(p, item, err);
    }
    sp_paper_page_heading(&r.page, "files", "Files");
    sp_paper_page_paragraph(
        &r.page, "",
        "The numbers behind each figure and table are beside it in a file of the same name: fig6.tsv, table1.tsv; "
        "values of figures that the paper states in fig6-values.tsv and so on.");
    if (status == SP_OK)
        status = sp_paper_page_save(&r.page, p->opt->folder, err);
    sp_paper_page_free(&r.page);
    return status;
}
