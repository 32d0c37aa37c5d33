/* Draws tables of speeds, fronts, ensembles, modes, waves and the tapped column. */
#include "cli/plot_tables.h"

#include "base/base.h"
#include "cli/plot_input.h"
#include "cli/trace.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const char *plot_name(const char *path, char out[PLOT_NAME]) {
    const char *slash = strrchr(path, '/'), *name = slash && slash[1] ? slash + 1 : path, *dot = strrchr(name, '.');
    const size_t length = dot && dot > name ? (size_t)(dot - name) : strlen(name);
    snprintf(out, PLOT_NAME, "%.*s", (int)(length < PLOT_NAME ? length : PLOT_NAME - 1), name);
    return out;
}

/* Draws fronts with an inset: the signal of a sample, with its front. */
static sp_status draw_with_sample(const cli_common *common, const sp_scene *scene, const char *sample, int files,
                                  const sp_plot_table *shown, sp_error *err) {
    plot_signals read = {0};
    sp_front front;
    sp_front_options rule = sp_front_options_default();
    sp_status status = plot_read_signals(sample, scene, &read, err);
    if (status != SP_OK)
        return status;
    const plot_signal *s = &read.signal[0];
    rule.window = s->window;
    status = sp_front_find(s->n, s->t, s->f, &rule, &front, err);
    if (status == SP_OK && !isfinite(front.t_zero))
        status = sp_fail(err, SP_EREFUSED, "the signal ends before its first front does");
    if (status != SP_OK)
        sp_fail_prefix(err, "%s", sample);
    const sp_plot_trace trace = {
        .n = s->n, .t = s->t, .f = s->f, .t10 = front.t10, .t_peak = front.t_peak, .t_zero = front.t_zero};
    if (status == SP_OK)
        status = sp_plot_fronts(files, shown, &trace, common->output, err);
    plot_signals_free(&read);
    return status;
}

static sp_status draw(const cli_common *common, plot_tables_kind kind, int files, const sp_plot_table *shown,
                      sp_error *err) {
    switch (kind) {
    case PLOT_FRONTS: return sp_plot_fronts(files, shown, NULL, common->output, err);
    case PLOT_SCALING: return sp_plot_scaling(files, shown, common->output, err);
    case PLOT_ENSEMBLE: return sp_plot_ensemble(files, shown, common->output, err);
    case PLOT_MODES: return sp_plot_modes_tables(files, shown, common->output, err);
    case PLOT_CTOF: return sp_plot_ctof_tables(files, shown, common->output, err);
    case PLOT_AMPLITUDE: return sp_plot_amplitude(files, shown, common->output, err);
    case PLOT_TRANSPORT: return sp_plot_transport(files, shown, common->output, err);
    case PLOT_WAVE: return sp_plot_wave(files, shown, common->output, err);
    }
    return SP_EINVAL;
}

sp_status plot_tables_alloc(int files, char **file, plot_tables *out, sp_error *err) {
    *out = (plot_tables){.files = files, .file = file, .table = sp_alloc((size_t)files, sizeof *out->table)};
    out->shown = sp_alloc((size_t)files, sizeof *out->shown);
    out->name = sp_alloc((size_t)files, sizeof *out->name);
    if (!out->table || !out->shown || !out->name)
        return sp_fail_memory(err, (size_t)files * (sizeof *out->table + sizeof *out->shown + sizeof *out->name));
    for (int k = 0; k < files; k++)
        out->shown[k] = (sp_plot_table){.label = plot_name(file[k], out->name[k]), .table = &out->table[k]};
    return SP_OK;
}

void plot_tables_free(plot_tables *t) {
    for (int k = 0; k < t->files && t->table; k++)
        sp_table_free(&t->table[k]);
    sp_free(t->table);
    sp_free(t->shown);
    sp_free(t->name);
}

void plot_tables_name(plot_tables *t, const plot_look *look) {
    for (int k = 0; t->shown && k < t->files && k < look->labels; k++) {
        t->shown[k].label = look->label[k];
        t->shown[k].named = true;
    }
}

static sp_status read_tables(int files, char **file, plot_tables *out, sp_error *err) {
    bool packing = false;
    sp_status status = plot_tables_alloc(files, file, out, err);
    for (int k = 0; k < files && status == SP_OK; k++) {
        status = cli_is_packing(file[k], &packing, err);
        if (status == SP_OK && packing)
            status = sp_fail(err, SP_EFORMAT, "%s: is a packing, must be a table", file[k]);
        if (status == SP_OK)
            status = plot_read_table(file[k], &out->table[k], err);
    }
    return status;
}

sp_status plot_tables_files(const cli_common *common, const sp_scene *scene, const plot_tables_want *want, int files,
                            char **file, sp_error *err) {
    plot_tables t;
    sp_status status = read_tables(files, file, &t, err);
    plot_tables_name(&t, want->look);
    if (status == SP_OK)
        status = want->sample ? draw_with_sample(common, scene, want->sample, files, t.shown, err)
                              : draw(common, want->kind, files, t.shown, err);
    plot_tables_free(&t);
    return status;
}

sp_status plot_column_files(const cli_common *common, const sp_plot_column_options *options, const plot_look *look,
                            int files, char **file, sp_error *err) {
    plot_tables t;
    sp_status status = read_tables(files, file, &t, err);
    plot_tables_name(&t, look);
    if (status == SP_OK)
        status = sp_plot_column(files, t.shown, options, common->output, err);
    plot_tables_free(&t);
    return status;
}
