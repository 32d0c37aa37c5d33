/* What the items of the paper on the tapped column write: progress, sentences, tables and figures. */
#include "base/base.h"
#include "paper/blackmore.h"

#include <sonopack/figure/plot.h>
#include <sonopack/version.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

bool sp_blackmore_is_selected(const blackmore *p, int item) { return p->opt->items == 0 || p->opt->items >> item & 1; }

sp_status sp_blackmore_progress(blackmore *p, double done, sp_error *err) {
    sp_paper_progress progress = {.what = p->step,
                                  .fraction = p->item_at + p->item_share * done,
                                  .seconds = sp_clock_wall() - p->begun,
                                  .seconds_left = NAN};
    if (progress.fraction > 0.02)
        progress.seconds_left = progress.seconds * (1 - progress.fraction) / progress.fraction;
    if (!p->watch || p->watch(&progress, p->user))
        return SP_OK;
    return sp_fail(err, SP_EINTERRUPTED, "stopped at %.0f%%", 100 * progress.fraction);
}

void sp_blackmore_say(blackmore *p, int item, const char *format, ...) {
    char line[1200];
    va_list args;
    va_start(args, format);
    vsnprintf(line, sizeof line, format, args);
    va_end(args);
    sp_text_add(&p->section[item].text, "%s\n", line);
}

sp_status sp_blackmore_save(blackmore *p, const char *name, sp_table *t, sp_error *err) {
    if (!p->opt->folder)
        return SP_OK;
    char path[SP_PATH_MAX];
    sp_status status = sp_table_add_comment(t, err, "sonopack %s, reproduce blackmore2011", SONOPACK_VERSION);
    char *text = status == SP_OK ? sp_table_text(t, SP_TSV) : NULL;
    if (status != SP_OK)
        return status;
    if (!text)
        return sp_fail_memory(err, (size_t)(t->rows * t->columns) * 24);
    snprintf(path, sizeof path, "%.3900s/%s.tsv", p->opt->folder, name);
    status = sp_text_save(path, text, strlen(text), err);
    sp_free(text);
    return status;
}

/* Adds figure NAME to the section and returns its path. */
static void add_figure(blackmore *p, int item, const char *name, const char *caption, char path[SP_PATH_MAX]) {
    blackmore_section *s = &p->section[item];
    snprintf(path, SP_PATH_MAX, "%.3900s/%s.%s", p->opt->folder, name, p->opt->figures);
    if (s->figures == BLACKMORE_FIGURES)
        return;
    snprintf(s->file[s->figures], sizeof s->file[0], "%s.%s", name, p->opt->figures);
    snprintf(s->caption[s->figures], sizeof s->caption[0], "%s", caption);
    s->figures++;
}

sp_status sp_blackmore_draw(blackmore *p, int item, const char *name, int tables, const sp_table *const *table,
                            const char *const *labels, const char *caption, sp_error *err) {
    if (!p->opt->folder)
        return SP_OK;
    char path[SP_PATH_MAX];
    sp_plot_table plot[4];
    for (int k = 0; k < tables && k < 4; k++)
        plot[k] = (sp_plot_table){.label = labels ? labels[k] : NULL, .table = table[k]};
    add_figure(p, item, name, caption, path);
    return sp_plot_column(tables, plot, NULL, path, err);
}

sp_status sp_blackmore_draw_sheet(blackmore *p, int item, const char *name, const sp_sheet *sheet, const char *caption,
                                  sp_error *err) {
    if (!p->opt->folder)
        return SP_OK;
    char path[SP_PATH_MAX];
    add_figure(p, item, name, caption, path);
    return sp_plot_sheet(sheet, path, err);
}
