/* The report: report.html and report.md, which say the same, with the figures and tables beside them. */
#include "base/base.h"
#include "paper/paper.h"

#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <sonopack/version.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- the folder ------------------------------------------------------------------------------------------------- */

/* What tells a report of ours, and one that was not finished. */
#define MARK       "<!-- sonopack reproduce -->"
#define UNFINISHED "This report is not finished."

/* What report.md of a folder begins with; "" where there is none. */
static void read_head(const char *folder, char head[256]) {
    char path[SP_PATH_MAX];
    head[0] = '\0';
    snprintf(path, sizeof path, "%.3900s/report.md", folder);
    FILE *file = fopen(path, "rb");
    if (!file)
        return;
    head[fread(head, 1, 255, file)] = '\0';
    fclose(file);
}

static bool is_empty(const char *folder) {
    DIR *open = opendir(folder);
    int files = 0;
    for (struct dirent *entry; open && (entry = readdir(open));)
        files += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
    if (open)
        closedir(open);
    return files == 0;
}

sp_status sp_paper_check_folder(const char *folder, bool replace, sp_error *err) {
    struct stat info;
    char head[256];
    if (!*folder || strlen(folder) > 3800)
        return sp_fail(err, SP_EINVAL, "folder '%.100s': a path of 1 to 3800 characters", folder);
    if (mkdir(folder, 0777) != 0 && errno != EEXIST)
        return sp_fail(err, SP_EIO, "cannot make the folder %s: %s", folder, strerror(errno));
    if (stat(folder, &info) != 0 || !S_ISDIR(info.st_mode))
        return sp_fail(err, SP_EINVAL, "%s: is no folder: must be one for the report and its figures", folder);
    sp_status status = sp_folder_probe(folder, err);
    if (status != SP_OK || is_empty(folder))
        return status;
    read_head(folder, head);
    if (strncmp(head, MARK, strlen(MARK)) != 0)
        return sp_fail(err, SP_EINVAL, "%s: has other files in it and no report: must be a new or an empty folder",
                       folder);
    if (!strstr(head, UNFINISHED) && !replace)
        return sp_fail(err, SP_EINVAL, "%s: has a report already: must be another folder, or give --force", folder);
    return SP_OK;
}

static sp_status save(const paper *p, const char *ending, const sp_text *text, sp_error *err) {
    char path[SP_PATH_MAX];
    if (text->failed)
        return sp_fail_memory(err, text->capacity);
    paper_path(p, "report", ending, path);
    return sp_text_save(path, text->data, text->size, err);
}

sp_status paper_report_begin(paper *p, sp_error *err) {
    sp_text text = {0};
    sp_text_add(&text, "%s\n\n%s The same command goes on with it.\n", MARK, UNFINISHED);
    sp_status status = save(p, "md", &text, err);
    sp_text_free(&text);
    return status;
}

/* ---- two forms -------------------------------------------------------------------------------------------------- */

typedef struct report {
    sp_text html, md;
    const paper *p;
} report;

static void escape(sp_text *t, const char *text) {
    for (; *text; text++) {
        if (*text == '<')
            sp_text_add(t, "&lt;");
        else if (*text == '>')
            sp_text_add(t, "&gt;");
        else if (*text == '&')
            sp_text_add(t, "&amp;");
        else if (*text == '"')
            sp_text_add(t, "&quot;");
        else if (*text == '+' && text[1] == '-') {
            sp_text_add(t, "±");
            text++;
        } else
            sp_text_bytes(t, text, 1);
    }
}

/* Letters that Markdown would take for its own. */
static void escape_md(sp_text *t, const char *text) {
    for (; *text; text++) {
        if (*text == '+' && text[1] == '-') {
            sp_text_add(t, "±");
            text++;
            continue;
        }
        if (strchr("*_|<>\\", *text))
            sp_text_add(t, "\\");
        sp_text_bytes(t, text, 1);
    }
}

static void heading(report *r, const char *id, const char *text) {
    sp_text_add(&r->html, "<h2 id=\"%s\">", id);
    escape(&r->html, text);
    sp_text_add(&r->html, "</h2>\n");
    sp_text_add(&r->md, "## ");
    escape_md(&r->md, text);
    sp_text_add(&r->md, "\n\n");
}

static void paragraph(report *r, const char *lead, const char *text) {
    sp_text_add(&r->html, "<p>");
    if (*lead)
        sp_text_add(&r->html, "<b>%s</b> ", lead);
    escape(&r->html, text);
    sp_text_add(&r->html, "</p>\n");
    if (*lead)
        sp_text_add(&r->md, "**%s** ", lead);
    escape_md(&r->md, text);
    sp_text_add(&r->md, "\n\n");
}

/* ---- tables ----------------------------------------------------------------------------------------------------- */

enum { CELL = 64, CELLS = 8 };

static void number(char cell[CELL], const char *format, double x) {
    if (isfinite(x))
        snprintf(cell, CELL, format, x);
    else
        snprintf(cell, CELL, "–");
}

/* Decimal places of x with so many significant digits; trailing zeros count only if `zeros`. */
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

/* Both to the same decimal place: ours to two digits of the error, the paper's as it prints them. */
static void value(char cell[CELL], double x, double error, bool printed) {
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
    number(cell[n++], "%+.1f", row->combined);
    snprintf(cell[n++], CELL, "%s", row->verdict);
}

static void table_row(report *r, int cells, char cell[CELLS][CELL], const char *tag, const char *class) {
    sp_text_add(&r->html, "<tr%s%s%s>", *class ? " class=\"" : "", class, *class ? "\"" : "");
    sp_text_add(&r->md, "|");
    for (int k = 0; k < cells; k++) {
        sp_text_add(&r->html, "<%s>", tag);
        escape(&r->html, cell[k]);
        sp_text_add(&r->html, "</%s>", tag);
        sp_text_add(&r->md, " ");
        escape_md(&r->md, cell[k]);
        sp_text_add(&r->md, " |");
    }
    sp_text_add(&r->html, "</tr>\n");
    sp_text_add(&r->md, "\n");
}

/* Rows of an item, or (item < 0) all that do not agree. */
static bool in_table(const paper_row *row, int item) {
    return item >= 0 ? row->item == item : strcmp(row->verdict, "agrees") != 0;
}

static void table(report *r, int item) {
    char head[CELLS][CELL] = {"item", "quantity", "p", "paper", "ours", "σ", "s.e.", "verdict"}, cell[CELLS][CELL];
    const int first = item >= 0, cells = CELLS - first;
    int64_t rows = 0;
    for (int64_t k = 0; k < r->p->rows; k++)
        rows += in_table(&r->p->row[k], item);
    if (rows == 0)
        return;
    sp_text_add(&r->html, "<div class=\"wide\"><table>\n");
    table_row(r, cells, head + first, "th", "");
    sp_text_add(&r->md, "|");
    for (int k = 0; k < cells; k++)
        sp_text_add(&r->md, "---|");
    sp_text_add(&r->md, "\n");
    for (int64_t k = 0; k < r->p->rows; k++) {
        if (!in_table(&r->p->row[k], item))
            continue;
        row_cells(&r->p->row[k], item < 0, cell);
        table_row(r, cells, cell, "td", r->p->row[k].verdict);
    }
    sp_text_add(&r->html, "</table></div>\n");
    sp_text_add(&r->md, "\n");
}

/* ---- parts ------------------------------------------------------------------------------------------------------ */

static void figure(report *r, const char *file, const char *caption) {
    const bool shown = strcmp(r->p->opt->figures, "pdf") != 0;
    sp_text_add(&r->html, "<figure>");
    if (shown) {
        sp_text_add(&r->html, "<img src=\"%s\" alt=\"", file);
        escape(&r->html, caption);
        sp_text_add(&r->html, "\">");
    } else {
        sp_text_add(&r->html, "<a href=\"%s\">%s</a>", file, file);
    }
    sp_text_add(&r->html, "<figcaption>");
    escape(&r->html, caption);
    sp_text_add(&r->html, "</figcaption></figure>\n");
    sp_text_add(&r->md, shown ? "![" : "[");
    escape_md(&r->md, caption);
    sp_text_add(&r->md, "](%s)\n\n", file);
    if (shown) {
        sp_text_add(&r->md, "*");
        escape_md(&r->md, caption);
        sp_text_add(&r->md, "*\n\n");
    }
}

/* Every line of a text as a paragraph. */
static void paragraphs(report *r, const char *lead, const char *text) {
    char line[1300];
    while (text && *text) {
        const size_t length = strcspn(text, "\n");
        snprintf(line, sizeof line, "%.*s", (int)length, text);
        paragraph(r, lead, line);
        lead = "";
        text += length + (text[length] == '\n');
    }
}

static void section(report *r, int item) {
    const paper_section *s = &r->p->section[item];
    heading(r, paper_items[item].name, paper_items[item].title);
    paragraph(r, "In the paper.", paper_items[item].shows);
    paragraphs(r, "Here.", s->text.data);
    table(r, item);
    for (int k = 0; k < s->figures; k++)
        figure(r, s->file[k], s->caption[k]);
}

static void summary(report *r) {
    const paper *p = r->p;
    int64_t agrees = 0, deviates = 0, missing = 0;
    char line[600];
    for (int64_t k = 0; k < p->rows; k++) {
        agrees += strcmp(p->row[k].verdict, "agrees") == 0;
        deviates += strcmp(p->row[k].verdict, "deviates") == 0;
        missing += strcmp(p->row[k].verdict, "missing") == 0;
    }
    heading(r, "summary", "Summary");
    snprintf(
        line, sizeof line,
        "Of %lld values of the paper %lld agree within one standard deviation, %lld deviate, and %lld could not be "
        "compared. What does not agree:",
        (long long)p->rows, (long long)agrees, (long long)deviates, (long long)missing);
    if (deviates + missing == 0)
        snprintf(line, sizeof line, "All %lld values of the paper agree within one standard deviation.",
                 (long long)p->rows);
    if (p->rows == 0)
        snprintf(line, sizeof line, "Only figures were asked for, which have no values to compare.");
    paragraph(r, "", line);
    table(r, -1);
    paragraph(r, "How to read the tables.",
              "Paper: mean and one standard deviation of its samples. Ours: mean and its standard error. σ: the "
              "difference over one standard deviation of the paper; where it gives none (normal forces, their moments, "
              "fabric) over that of our samples; for values that the paper states in words over the precision of the "
              "words and our standard error together, and 0 above a lower bound (≥). A value agrees when σ is within "
              "one; with few samples more of them deviate by chance. Missing: ours has no value, or a single sample no "
              "scatter. s.e.: the difference over "
              "the standard errors of both means together, 30 samples taken for the paper; it shows small differences "
              "that the scatter hides.");
    snprintf(line, sizeof line,
             "sonopack %s, reproduce somfai2005 with %d samples a pressure (2400 grains: half as many; spheres: a "
             "quarter), protocol %s; "
             "%lld samples made in this run, %lld that failed or lack a part; %.0f seconds.",
             SONOPACK_VERSION, p->opt->samples, p->opt->protocol == SP_PROTOCOL_SOMFAI2005 ? "somfai2005" : "default",
             (long long)p->computed, (long long)p->failed, sp_clock_wall() - p->begun);
    paragraph(r, "Run.", line);
}

static const char *const style =
    "body{font:16px/1.45 Georgia,serif;max-width:46em;margin:1em auto;padding:0 1em;color:#111;background:#fff}"
    "h1{font-size:1.5em;line-height:1.2}h2{font-size:1.2em;margin-top:2em;border-top:1px solid #bbb;padding-top:.6em}"
    ".wide{overflow-x:auto}table{border-collapse:collapse;font:13px/1.35 sans-serif;margin:.8em 0}"
    "th,td{padding:.15em .6em;text-align:right;white-space:nowrap;border-bottom:1px solid #ddd}"
    "th:first-child,td:first-child{text-align:left}tr.deviates td{background:#fdebd3}tr.missing td{color:#777}"
    "figure{margin:1.2em 0;text-align:center}img{max-width:100%;height:auto}"
    "figcaption{font-size:.9em;color:#333;text-align:left}"
    "@media print{body{max-width:none;font-size:11pt}figure,table{break-inside:avoid}}";

static void opening(report *r) {
    static const char *const title = "Elastic wave propagation in confined granular systems, computed again";
    sp_text_add(&r->html,
                "<!DOCTYPE html>\n%s\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
                "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
                "<title>%s</title>\n<style>%s</style></head>\n<body>\n<h1>%s</h1>\n",
                MARK, title, style, title);
    sp_text_add(&r->md, "%s\n\n# %s\n\n", MARK, title);
    paragraph(
        r, "",
        "Tables and figures of E. Somfai, J.-N. Roux, J. H. Snoeijer, M. van Hecke, W. van Saarloos, Phys. Rev. E "
        "72, 021301 (2005), beside values and figures of new packings. Units: lengths in mean grain diameters d, "
        "pressures in E*, speeds in sqrt(E*/rho), times in d/sqrt(E*/rho).");
}

/* The rows of an item as a table of their own. */
static sp_status save_rows(paper *p, int item, sp_error *err) {
    int64_t first = 0, n = 0;
    for (int64_t k = 0; k < p->rows; k++)
        if (p->row[k].item == item && n++ == 0)
            first = k;
    if (n == 0)
        return SP_OK;
    char name[32];
    sp_table t = sp_table_none();
    snprintf(name, sizeof name, "%s%s", paper_items[item].name, item < PAPER_FIG_1 ? "" : "-values");
    sp_status status = paper_rows_table(n, p->row + first, &t, err);
    if (status == SP_OK)
        status = paper_save_table(p, name, &t, err);
    sp_table_free(&t);
    return status;
}

sp_status paper_report(paper *p, sp_error *err) {
    report r = {.p = p};
    sp_status status = SP_OK;
    opening(&r);
    summary(&r);
    for (int item = 0; item < SP_PAPER_ITEMS && status == SP_OK; item++) {
        if (!paper_wants(p, item))
            continue;
        section(&r, item);
        status = save_rows(p, item, err);
    }
    heading(&r, "files", "Files");
    paragraph(
        &r, "",
        "The numbers behind each figure and table are beside it in a file of the same name: fig6.tsv, table1.tsv; "
        "values of figures that the paper states in fig6-values.tsv and so on.");
    sp_text_add(&r.html, "</body></html>\n");
    if (status == SP_OK)
        status = save(p, "html", &r.html, err);
    if (status == SP_OK)
        status = save(p, "md", &r.md, err);
    sp_text_free(&r.html);
    sp_text_free(&r.md);
    return status;
}
