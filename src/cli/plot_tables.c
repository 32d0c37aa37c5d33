#include "cli/plot_tables.h"

#include "base/base.h"
#include "cli/plot_input.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const char *plot_name(const char *path, char out[PLOT_NAME]) {
    const char *slash = strrchr(path, '/'), *name = slash && slash[1] ? slash + 1 : path, *dot = strrchr(name, '.');
    const size_t length = dot && dot > name ? (size_t)(dot - name) : strlen(name);
    snprintf(out, PLOT_NAME, "%.*s", (int)(length < PLOT_NAME ? length : PLOT_NAME - 1), name);
    return out;
}

/* The signal for the inset, with its front. */
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
    case PLOT_MODES: return sp_plot_modes(shown[0].table, common->output, err);
    case PLOT_WAVE: return sp_plot_wave(files, shown, common->output, err);
    }
    return SP_EINVAL;
}

sp_status plot_tables_files(const cli_common *common, const sp_scene *scene, plot_tables_kind kind, const char *sample,
                            int files, char **file, sp_error *err) {
    sp_table *table = sp_alloc((size_t)files, sizeof *table);
    sp_plot_table *shown = sp_alloc((size_t)files, sizeof *shown);
    char(*name)[PLOT_NAME] = sp_alloc((size_t)files, sizeof *name);
    sp_status status = table && shown && name ? SP_OK : sp_fail_memory(err, (size_t)files * sizeof *table);
    bool packing = false;
    for (int k = 0; k < files && status == SP_OK; k++) {
        status = plot_is_packing(file[k], &packing, err);
        if (status == SP_OK && packing)
            status = sp_fail(err, SP_EFORMAT, "%s: a packing, must be a table", file[k]);
        if (status == SP_OK)
            status = plot_read_table(file[k], &table[k], err);
        if (status == SP_OK)
            shown[k] = (sp_plot_table){plot_name(file[k], name[k]), &table[k]};
    }
    if (status == SP_OK)
        status =
            sample ? draw_with_sample(common, scene, sample, files, shown, err) : draw(common, kind, files, shown, err);
    for (int k = 0; k < files && table; k++)
        sp_table_free(&table[k]);
    sp_free(table);
    sp_free(shown);
    sp_free(name);
    return status;
}
