/* Collects what the items produce: rows, sentences, figures and tables. */
#include "base/base.h"
#include "paper/paper.h"
#include "table/array.h"

#include <math.h>
#include <sonopack/version.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

bool sp_paper_wants(const paper *p, int item) { return p->opt->items == 0 || p->opt->items >> item & 1; }

bool sp_paper_report_progress(const paper *p, const char *what, double fraction, int64_t computed, int64_t failed) {
    sp_paper_progress progress = {.what = what,
                                  .fraction = fraction,
                                  .seconds = sp_clock_wall() - p->begun,
                                  .seconds_left = NAN,
                                  .computed = computed,
                                  .failed = failed};
    if (fraction > 0.02)
        progress.seconds_left = progress.seconds * (1 - fraction) / fraction;
    return !p->watch || p->watch(&progress, p->user);
}

sp_status sp_paper_tell(paper *p, const char *what, double fraction, sp_error *err) {
    if (sp_paper_report_progress(p, what, fraction, p->computed, p->failed))
        return SP_OK;
    return sp_fail(err, SP_EINTERRUPTED, "stopped before %s, all samples are in the store", what);
}

sp_status sp_paper_add_row(paper *p, paper_row row, sp_error *err) {
    paper_row *larger = sp_array_reserve(p->row, (size_t)p->rows, sizeof *larger);
    if (!larger)
        return sp_fail_memory(err, (size_t)p->rows * sizeof *larger);
    p->row = larger;
    sp_paper_judge(&row);
    p->row[p->rows++] = row;
    return SP_OK;
}

sp_status sp_paper_add_stated(paper *p, int item, double pressure, paper_scatter scatter, const double value[2],
                              const double ours[2], sp_error *err, const char *quantity, ...) {
    paper_row row = {.item = item,
                     .p = pressure,
                     .paper = value[0],
                     .paper_sd = value[1],
                     .scatter = scatter,
                     .ours = ours[0],
                     .ours_sd = NAN,
                     .err = ours[1]};
    va_list args;
    va_start(args, quantity);
    vsnprintf(row.quantity, sizeof row.quantity, quantity, args);
    va_end(args);
    return sp_paper_add_row(p, row, err);
}

void sp_paper_say(paper *p, int item, const char *format, ...) {
    char line[1200];
    va_list args;
    va_start(args, format);
    vsnprintf(line, sizeof line, format, args);
    va_end(args);
    for (char *none; (none = strstr(line, " +- nan"));) /* a single sample has no error */
        memmove(none, none + 7, strlen(none + 7) + 1);
    sp_text_add(&p->section[item].text, "%s\n", line);
}

void sp_paper_path(const paper *p, const char *name, const char *ending, char path[SP_PATH_MAX]) {
    snprintf(path, SP_PATH_MAX, "%.3900s/%s.%s", p->opt->folder, name, ending);
}

void sp_paper_add_figure(paper *p, int item, const char *name, const char *caption) {
    paper_section *s = &p->section[item];
    if (s->figures == PAPER_FIGURES)
        return;
    snprintf(s->file[s->figures], sizeof s->file[0], "%s.%s", name, p->opt->figures);
    snprintf(s->caption[s->figures], sizeof s->caption[0], "%s", caption);
    s->figures++;
}

sp_status sp_paper_save_table(paper *p, const char *name, sp_table *t, sp_error *err) {
    char path[SP_PATH_MAX];
    sp_status status = sp_table_add_comment(t, err, "sonopack %s, reproduce somfai2005, samples = %d", SONOPACK_VERSION,
                                            p->opt->samples);
    char *text = status == SP_OK ? sp_table_text(t, SP_TSV) : NULL;
    if (status != SP_OK)
        return status;
    if (!text)
        return sp_fail_memory(err, (size_t)(t->rows * t->columns) * 24);
    sp_paper_path(p, name, "tsv", path);
    status = sp_text_save(path, text, strlen(text), err);
    sp_free(text);
    return status;
}

/* Removes markup: "|c|_{tof}" becomes "c_tof". */
static const char *plain(const char *label, char out[96]) {
    size_t n = 0;
    for (; label && *label && n < 95; label++)
        if (!strchr("|{}", *label))
            out[n++] = *label;
    out[n] = '\0';
    return out;
}

/* Adds the points of a panel's curves, followed by those of its inset. */
static sp_status add_panel(sp_table *t, const char *tag, const sp_panel *panel, sp_error *err) {
    sp_status status = SP_OK;
    char label[96];
    for (int c = 0; c < panel->curves; c++) {
        const sp_curve *curve = &panel->curve[c];
        plain(curve->label, label);
        for (int64_t k = 0; k < curve->n && status == SP_OK; k++)
            status = sp_table_add_row(t, err, tag, (int64_t)c + 1, label, curve->x[k], curve->y[k],
                                      curve->error ? curve->error[k] : NAN, curve->lower ? curve->lower[k] : NAN,
                                      curve->upper ? curve->upper[k] : NAN);
    }
    char inset[32];
    snprintf(inset, sizeof inset, "%.20s inset", tag);
    return status == SP_OK && panel->inset ? add_panel(t, inset, panel->inset, err) : status;
}

static sp_status describe_panel(sp_table *t, const char *tag, const sp_panel *panel, sp_error *err) {
    char x[96], y[96];
    return sp_table_add_comment(t, err, "%s%sx: %s; y: %s", tag, *tag ? ": " : "", plain(panel->x.label, x),
                                plain(panel->y.label, y));
}

static sp_status sheet_table(const sp_sheet *sheet, sp_table *t, sp_error *err) {
    static const struct {
        const char *name;
        sp_column_kind kind;
    } column[] = {{"panel", SP_COLUMN_TEXT},   {"curve", SP_COLUMN_INTEGER}, {"label", SP_COLUMN_TEXT},
                  {"x", SP_COLUMN_NUMBER},     {"y", SP_COLUMN_NUMBER},      {"error", SP_COLUMN_NUMBER},
                  {"lower", SP_COLUMN_NUMBER}, {"upper", SP_COLUMN_NUMBER}};
    sp_status status = SP_OK;
    for (size_t k = 0; k < sizeof column / sizeof *column && status == SP_OK; k++)
        status = sp_table_add_column(t, column[k].name, "", column[k].kind, err);
    for (int k = 0; k < sheet->rows * sheet->columns && status == SP_OK; k++) {
        const sp_panel *panel = &sheet->panel[k];
        char tag[96];
        plain(panel->tag, tag);
        status = describe_panel(t, tag, panel, err);
        if (status == SP_OK)
            status = add_panel(t, tag, panel, err);
    }
    return status;
}

sp_status sp_paper_draw(paper *p, int item, const char *name, const sp_sheet *sheet, const char *caption,
                        sp_error *err) {
    if (!p->opt->folder)
        return SP_OK;
    char path[SP_PATH_MAX];
    sp_paper_path(p, name, p->opt->figures, path);
    sp_status status = sp_plot_sheet(sheet, path, err);
    sp_table t = sp_table_none();
    if (status == SP_OK)
        status = sheet_table(sheet, &t, err);
    if (status == SP_OK)
        status = sp_paper_save_table(p, name, &t, err);
    sp_table_free(&t);
    if (status == SP_OK)
        sp_paper_add_figure(p, item, name, caption);
    return status;
}
