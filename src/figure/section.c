/* Draws signals at several distances, each at its own. */
#include "figure/canvas.h"
#include "figure/markup.h"
#include "figure/unit.h"

#include "base/base.h"

#include <math.h>
#include <sonopack/figure/figure.h>
#include <sonopack/figure/plot.h>
#include <stdio.h>

enum { RECORDS_MOST = 200, KEYS = 2, KEY_ROOM = 320 };

typedef struct section {
    int records;
    const sp_plot_record *record;
    bool numbered;      /* the distances are unknown */
    double least, most; /* of the largest values of the signals */
    char key[KEYS][KEY_ROOM];
} section;

static double level(const section *s, int k) { return s->numbered ? k + 1 : s->record[k].distance; }

static double spacing(const section *s) {
    double low = INFINITY, high = -INFINITY;
    for (int k = 0; k < s->records; k++) {
        low = fmin(low, level(s, k));
        high = fmax(high, level(s, k));
    }
    return high > low ? (high - low) / (s->records - 1) : 1;
}

/* Shifts a trace to its distance. Its largest value spans the mean spacing of the traces. */
static void lift(section *s, int k, double scale, double *y) {
    const sp_plot_record *r = &s->record[k];
    double largest = 0;
    for (int64_t l = 0; l < r->n; l++)
        largest = isfinite(r->f[l]) ? fmax(largest, fabs(r->f[l])) : largest;
    if (largest > 0) {
        s->least = fmin(s->least, largest);
        s->most = fmax(s->most, largest);
    }
    for (int64_t l = 0; l < r->n; l++)
        y[l] = isfinite(r->f[l]) ? level(s, k) + (largest > 0 ? scale * (r->f[l] / largest) : 0) : NAN;
}

static sp_status check_section(section *s, size_t *points, sp_error *err) {
    if (s->records < 1 || s->records > RECORDS_MOST)
        return sp_fail(err, SP_EINVAL, "%d signals: a section shows 1 to %d", s->records, RECORDS_MOST);
    s->numbered = true;
    *points = 0;
    for (int k = 0; k < s->records; k++)
        s->numbered = s->numbered && isnan(s->record[k].distance);
    for (int k = 0; k < s->records; k++) {
        const sp_plot_record *r = &s->record[k];
        if (r->n < 0 || (!s->numbered && !isfinite(r->distance)))
            return sp_fail(err, SP_EINVAL, "signal %d has %lld points and distance %g: must be finite, or nan for all",
                           k + 1, (long long)r->n, r->distance);
        *points += (size_t)r->n;
    }
    return SP_OK;
}

/* The scale, in two lines: the traces decay too much for a common one. */
static void describe_scale(section *s) {
    char unit[UNIT_MARKUP], least[48], most[48];
    const char *force = s->record[0].f_unit;
    sp_unit_markup(force ? force : UNIT_FORCE, unit);
    sp_figure_text_number(least, sizeof least, s->least, 3);
    sp_figure_text_number(most, sizeof most, s->most, 3);
    snprintf(s->key[0], KEY_ROOM, "each signal scaled to its largest \\||F|\\|:");
    snprintf(s->key[1], KEY_ROOM, "%s to %s %s", least, most, unit);
}

sp_status sp_plot_section(int records, const sp_plot_record *record, const char *path, sp_error *err) {
    section s = {.records = records, .record = record, .least = INFINITY};
    size_t points = 0;
    sp_status status = sp_canvas_check(path, err);
    if (status == SP_OK)
        status = check_section(&s, &points, err);
    if (status != SP_OK)
        return status;
    double *y = sp_alloc(points, sizeof *y);
    sp_curve *curve = sp_alloc((size_t)records + KEYS, sizeof *curve);
    if (!y || !curve) {
        status = sp_fail_memory(err, points * sizeof *y);
        goto out;
    }
    const double scale = spacing(&s);
    size_t at = 0;
    for (int k = 0; k < records; k++) {
        lift(&s, k, scale, y + at);
        curve[k] = (sp_curve){.n = record[k].n, .x = record[k].t, .y = y + at, .width = 0.6};
        at += (size_t)record[k].n;
    }
    int keys = 0;
    if (s.most > 0)
        for (describe_scale(&s); keys < KEYS; keys++)
            curve[records + keys] = (sp_curve){.label = s.key[keys], .dash = SP_DASH_NONE};
    char time[UNIT_MARKUP + 16], distance[UNIT_MARKUP + 16];
    const char *length = record[0].distance_unit ? record[0].distance_unit : UNIT_LENGTH;
    const sp_panel panel = {
        .x = {.label = sp_unit_label("|t|", record[0].t_unit ? record[0].t_unit : UNIT_TIME, time, sizeof time)},
        .y = {.label = s.numbered ? "number" : sp_unit_label("distance", length, distance, sizeof distance)},
        .curves = records + keys,
        .curve = curve};
    const sp_sheet sheet = {.title = "Signals at several distances",
                            .rows = 1,
                            .columns = 1,
                            .panel = &panel,
                            .aspect = fmin(1.5, 0.75 + 0.02 * records)};
    status = sp_plot_sheet(&sheet, path, err);
out:
    sp_free(y);
    sp_free(curve);
    return status;
}
