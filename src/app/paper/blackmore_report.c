/* Writes the report on the reproduction of the paper on the tapped column. */
#include "base/base.h"
#include "paper/blackmore.h"

#include <sonopack/version.h>
#include <stdio.h>
#include <string.h>

enum { CELL = 96, CELLS = 7 };

static const char *sign(blackmore_relation relation) {
    return relation == BLACKMORE_ABOVE ? "> " : relation == BLACKMORE_BELOW ? "< " : "";
}

static void number(char cell[CELL], const char *before, double x, double error) {
    if (isnan(x))
        snprintf(cell, CELL, "–");
    else if (isinf(x))
        snprintf(cell, CELL, "%s%s∞", before, x < 0 ? "-" : "");
    else if (error > 1e-6 * fabs(x))
        snprintf(cell, CELL, "%s%.7g +- %.2g", before, x, error);
    else
        snprintf(cell, CELL, "%s%.7g", before, x);
}

static void add_row(paper_page *page, const blackmore_row *row, const char *item) {
    char text[CELLS][CELL], note[sizeof row->note + 8];
    const char *cell[CELLS + 1];
    int n = 0;
    if (item)
        snprintf(text[n++], CELL, "%s", item);
    snprintf(text[n++], CELL, "%s", row->equation);
    snprintf(text[n++], CELL, "%s%s%s%s", row->quantity, *row->unit ? " [" : "", row->unit, *row->unit ? "]" : "");
    number(text[n++], sign(row->relation), row->paper, row->precision);
    number(text[n++], "", row->ours, row->err);
    snprintf(text[n++], CELL, "%s", row->verdict);
    snprintf(note, sizeof note, "%s", row->note);
    for (int k = 0; k < n; k++)
        cell[k] = text[k];
    cell[n++] = note;
    sp_paper_page_row(page, n, cell, row->verdict, n - 1);
}

/* Selects the rows of an item or, for item < 0, all that deviate or do not hold. */
static bool in_table(const blackmore_row *row, int item) {
    if (item >= 0)
        return row->item == item && !row->detail;
    return strcmp(row->verdict, "deviates") == 0 || strcmp(row->verdict, "contradicted") == 0 ||
           strcmp(row->verdict, "undecided") == 0;
}

static void table(const blackmore *p, paper_page *page, int item) {
    static const char *const head[CELLS] = {"item", "in [B]", "quantity", "paper", "ours", "verdict", "note"};
    const int first = item >= 0;
    int64_t rows = 0;
    for (int64_t k = 0; k < p->rows; k++)
        rows += in_table(&p->row[k], item);
    if (rows == 0)
        return;
    sp_paper_page_table(page, CELLS - first, head + first);
    for (int64_t k = 0; k < p->rows; k++)
        if (in_table(&p->row[k], item))
            add_row(page, &p->row[k], item < 0 ? p->items[p->row[k].item].name : NULL);
    sp_paper_page_table_end(page);
}

static int64_t count(const blackmore *p, const char *verdict) {
    int64_t rows = 0;
    for (int64_t k = 0; k < p->rows; k++)
        rows += strcmp(p->row[k].verdict, verdict) == 0;
    return rows;
}

static void summary(const blackmore *p, paper_page *page) {
    const int64_t claims = count(p, "holds") + count(p, "contradicted") + count(p, "undecided");
    sp_paper_page_heading(page, "summary", "Summary");
    sp_paper_page_format(
        page, "",
        "Of %lld values %lld agree with the paper, %lld deviate, %lld are errata, and %lld are not given there; of "
        "%lld claims %lld hold, %lld are contradicted and %lld are undecided.%s",
        (long long)(p->rows - claims), (long long)count(p, "agrees"), (long long)count(p, "deviates"),
        (long long)count(p, "erratum"), (long long)count(p, "not given"), (long long)claims,
        (long long)count(p, "holds"), (long long)count(p, "contradicted"), (long long)count(p, "undecided"),
        count(p, "deviates") + claims > count(p, "holds") ? " What deviates or does not hold:" : "");
    table(p, page, -1);
    sp_paper_page_paragraph(
        page, "How to read the tables.",
        "Paper: what is printed, with the precision of the print, or what follows from a printed equation or claim. "
        "Ours: with a bound of our error where it is not rounding alone. Agrees: within both. Deviates: not so. "
        "Erratum: the paper is wrong by its own premises, and ours is right. Not given: the paper has no number, "
        "often only a picture. Claims in words and theorems hold, are contradicted, or are undecided where ours lies "
        "within its error of the limit; the note says what was computed.");
    sp_paper_page_format(page, "Run.", "sonopack %s, reproduce blackmore2011; %.1f seconds.", SONOPACK_VERSION,
                         sp_clock_wall() - p->begun);
}

static sp_status section(blackmore *p, paper_page *page, int item, sp_error *err) {
    const blackmore_section *s = &p->section[item];
    if (s->text.failed)
        return sp_fail_memory(err, s->text.capacity);
    sp_paper_page_heading(page, p->items[item].name, p->items[item].title);
    sp_paper_page_paragraph(page, "In the paper.", p->items[item].shows);
    sp_paper_page_paragraphs(page, "Here.", s->text.data);
    table(p, page, item);
    for (int k = 0; k < s->figures; k++)
        sp_paper_page_figure(page, s->file[k], strcmp(p->opt->figures, "pdf") != 0, s->caption[k]);
    sp_table rows = sp_table_none();
    sp_status status = sp_blackmore_rows_table(p, item, &rows, err);
    if (status == SP_OK)
        status = sp_blackmore_save(p, p->items[item].name, &rows, err);
    sp_table_free(&rows);
    return status;
}

sp_status sp_blackmore_report(blackmore *p, sp_error *err) {
    paper_page page = {0};
    sp_status status = SP_OK;
    sp_paper_page_open(&page, "Tapping dynamics for a column of particles and beyond, computed again");
    sp_paper_page_paragraph(
        &page, "",
        "Figures, equations and claims of D. Blackmore, A. Rosato, X. Tricoche, K. Urban, V. Ratnaswamy, J. Mech. "
        "Mater. Struct. 6 (2011), [B], beside what its model gives. Units: cm, g, s. The lattice is solved exactly, "
        "from event to event, with contacts that stick.");
    summary(p, &page);
    for (int item = 0; item < SP_PAPER_COLUMN_ITEMS && status == SP_OK; item++)
        if (sp_blackmore_is_selected(p, item))
            status = section(p, &page, item, err);
    sp_paper_page_heading(&page, "files", "Files");
    sp_paper_page_paragraph(&page, "",
                            "The rows of each item are in a file of its name: errata.tsv, fig1.tsv; the numbers behind "
                            "each figure in files whose names begin with that of the item.");
    if (status == SP_OK)
        status = sp_paper_page_save(&page, p->opt->folder, err);
    sp_paper_page_free(&page);
    return status;
}
