/* Draws signals on common axes, or above each other if they are many. */
#include "cli/plot_signals.h"

#include "base/base.h"
#include "cli/plot_input.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct drawing {
    const cli_common *common;
    const plot_look *look;
    int files;
    char **file;
    plot_signals *read; /* [files] */
    int traces;
} drawing;

/* The label of a signal: that of the command line, or the file name without folder and ending, and the column if the
 * file has several signals. With a single file without label the column alone is enough. */
static char *label_of(const drawing *d, int file, const plot_signal *s) {
    enum { SIZE = 256 };
    const char *path = d->file[file], *slash = strrchr(path, '/'), *name = slash && slash[1] ? slash + 1 : path;
    const char *dot = strrchr(name, '.'), *column = *s->place ? "" : s->name;
    const bool named = file < d->look->labels, alone = d->files == 1 && *s->name && !named;
    const int length = (int)(dot && dot > name ? dot - name : (ptrdiff_t)strlen(name));
    char *label = sp_alloc(SIZE, 1);
    if (!label || alone)
        return label ? strncpy(label, column, SIZE - 1) : NULL;
    if (named)
        snprintf(label, SIZE, "%s%s%s", d->look->label[file], *column ? " " : "", column);
    else
        snprintf(label, SIZE, "%.*s%s%s", length, name, *column ? " " : "", column);
    return label;
}

/* The trace points to the arrays and units of the signal. */
static sp_status make_trace(const drawing *d, int file, const plot_signal *s, sp_plot_trace *out, sp_error *err) {
    char *label = label_of(d, file, s);
    if (!label)
        return sp_fail_memory(err, strlen(d->file[file]));
    sp_front front = {.t10 = NAN, .t_peak = NAN, .t_zero = NAN};
    sp_front_options rule = sp_front_options_default();
    sp_error reason = {0};
    rule.window = s->window;
    if (sp_front_find(s->n, s->t, s->f, &rule, &front, &reason) != SP_OK)
        cli_note(d->common, "%s%s%s: the first front is not marked: %s", d->file[file], *s->name ? ", " : "", s->name,
                 reason.text);
    *out = (sp_plot_trace){.label = label,
                           .n = s->n,
                           .t = s->t,
                           .f = s->f,
                           .t10 = front.t10,
                           .t_peak = front.t_peak,
                           .t_zero = front.t_zero,
                           .t_unit = s->foreign ? s->t_unit : NULL,
                           .f_unit = s->foreign ? s->f_unit : NULL,
                           .place = *s->place ? s->place : NULL};
    return SP_OK;
}

static sp_status draw_traces(const drawing *d, sp_error *err) {
    int count = 0;
    sp_status status = SP_OK;
    sp_plot_trace *trace = sp_alloc((size_t)d->traces, sizeof *trace);
    if (!trace)
        return sp_fail_memory(err, (size_t)d->traces * sizeof *trace);
    for (int k = 0; k < d->files && status == SP_OK; k++)
        for (int j = 0; j < d->read[k].n && status == SP_OK; j++) {
            status = make_trace(d, k, &d->read[k].signal[j], &trace[count], err);
            count += status == SP_OK;
        }
    if (status == SP_OK)
        status = sp_plot_signal(d->traces, trace, d->common->output, err);
    for (int j = 0; j < count; j++)
        sp_free((void *)trace[j].label);
    sp_free(trace);
    return status;
}

/* ---- sections --------------------------------------------------------------------------------------------------- */

/* Too many signals for a legend are drawn one above the other, up to the number that is still legible. */
static bool is_section(const drawing *d) {
    enum { LEGEND_MAX = 10, SECTION_MAX = 60 };
    const plot_signal *first = &d->read[0].signal[0];
    bool alike = d->traces > LEGEND_MAX && d->traces <= SECTION_MAX;
    for (int k = 0; k < d->files; k++)
        for (int j = 0; j < d->read[k].n; j++) {
            const plot_signal *s = &d->read[k].signal[j];
            alike =
                alike && *s->t_unit && strcmp(s->t_unit, first->t_unit) == 0 && strcmp(s->f_unit, first->f_unit) == 0;
        }
    return alike;
}

/* Whether all distances are known and no two are nearly equal. */
static bool are_distinct(int n, const sp_plot_record *record) {
    double low = INFINITY, high = -INFINITY, least = INFINITY;
    bool known = true;
    for (int k = 0; k < n; k++) {
        known = known && isfinite(record[k].distance);
        low = fmin(low, record[k].distance);
        high = fmax(high, record[k].distance);
        for (int j = 0; j < k; j++)
            least = fmin(least, fabs(record[k].distance - record[j].distance));
    }
    return known && least > 0.1 * (high - low) / (n - 1);
}

static sp_status draw_section(const drawing *d, sp_error *err) {
    int count = 0;
    sp_plot_record *record = sp_alloc((size_t)d->traces, sizeof *record);
    if (!record)
        return sp_fail_memory(err, (size_t)d->traces * sizeof *record);
    for (int k = 0; k < d->files; k++)
        for (int j = 0; j < d->read[k].n; j++) {
            const plot_signal *s = &d->read[k].signal[j];
            record[count++] = (sp_plot_record){.distance = s->distance,
                                               .n = s->n,
                                               .t = s->t,
                                               .f = s->f,
                                               .t_unit = s->t_unit,
                                               .f_unit = s->f_unit,
                                               .distance_unit = s->length_unit};
        }
    if (!are_distinct(d->traces, record))
        for (int k = 0; k < d->traces; k++)
            record[k].distance = NAN;
    const sp_status status = sp_plot_section(d->traces, record, d->common->output, err);
    sp_free(record);
    return status;
}

sp_status plot_signal_files(const cli_common *common, const sp_scene *scene, const plot_look *look, int files,
                            char **file, sp_error *err) {
    drawing d = {.common = common, .look = look, .files = files, .file = file};
    d.read = sp_alloc((size_t)files, sizeof *d.read);
    sp_status status = d.read ? SP_OK : sp_fail_memory(err, (size_t)files * sizeof *d.read);
    for (int k = 0; k < files && status == SP_OK; k++) {
        status = plot_read_signals(file[k], scene, &d.read[k], err);
        d.traces += status == SP_OK ? d.read[k].n : 0;
    }
    if (status == SP_OK)
        status = is_section(&d) ? draw_section(&d, err) : draw_traces(&d, err);
    for (int k = 0; k < files && d.read; k++)
        plot_signals_free(&d.read[k]);
    sp_free(d.read);
    return status;
}
