/* Draws signals with the marks of their first fronts. */
#include "figure/figure.h"

#include "base/base.h"

#include <math.h>
#include <sonopack/figure/plot.h>
#include <stdio.h>
#include <string.h>

enum {
    LEGEND_MOST = 10, /* more traces are identified by their number */
    LABEL_MOST = 28,  /* length of the label of a trace [characters] */
    UNIT_MOST = 24,   /* length of a unit [characters] */
    MARKS = 3,        /* t10, peak, zero crossing */
    TRACES_MOST = 1 << 16,
};

typedef struct drawing {
    int traces;
    const sp_plot_trace *trace;
    double *x, *y;           /* axis units, all traces one after the other */
    double *mark_x, *mark_y; /* [MARKS][traces] NAN: no mark */
    series *series;          /* first the traces, then one series for each mark and trace */
    char (*label)[160];
    int64_t points;
} drawing;

static bool finite_point(const sp_plot_trace *t, int64_t k) { return isfinite(t->t[k]) && isfinite(t->f[k]); }

/* The unit that all traces have, as markup; "" if they differ. */
static void common_unit(const drawing *d, bool force, char *out, size_t size) {
    const char *common = NULL;
    bool same = true;
    for (int j = 0; j < d->traces; j++) {
        const sp_plot_trace *t = &d->trace[j];
        const char *unit = force ? t->f_unit : t->t_unit;
        unit = unit && t->t_unit ? unit : "";
        same = same && (!common || strcmp(unit, common) == 0);
        common = unit;
    }
    sp_figure_text_escape(out, size, same ? common : "", UNIT_MOST);
}

static void label_axes(const drawing *d, axes *a) {
    bool ours = true;
    for (int j = 0; j < d->traces; j++)
        ours = ours && !d->trace[j].t_unit;
    if (ours) {
        sp_axis_name(&a->x, "|t|", "|d| (|\xcf\x81|/|E|*)^{1/2}");
        sp_axis_name(&a->y, "|F|_{sig}", "|E|* |d|^{2}");
        return;
    }
    char unit[160];
    common_unit(d, false, unit, sizeof unit);
    sp_axis_name(&a->x, "|t|", unit);
    common_unit(d, true, unit, sizeof unit);
    sp_axis_name(&a->y, "|F|", unit);
}

/* Sets the axes: t from the first point to the last, F including zero with a margin. */
static sp_status set_axes(const drawing *d, axes *a, sp_error *err) {
    double low_t = INFINITY, high_t = -INFINITY, low_f = 0.0, high_f = 0.0;
    for (int j = 0; j < d->traces; j++)
        for (int64_t k = 0; k < d->trace[j].n; k++) {
            if (!finite_point(&d->trace[j], k))
                continue;
            low_t = fmin(low_t, d->trace[j].t[k]);
            high_t = fmax(high_t, d->trace[j].t[k]);
            low_f = fmin(low_f, d->trace[j].f[k]);
            high_f = fmax(high_f, d->trace[j].f[k]);
        }
    if (!(low_t <= high_t))
        return sp_fail(err, SP_EREFUSED, "nothing to draw: no finite point in %d signal%s", d->traces,
                       d->traces == 1 ? "" : "s");
    sp_axis_linear(&a->x, low_t, high_t);
    sp_axis_linear(&a->y, low_f, high_f);
    double room = 0.06 * (a->y.high - a->y.low);
    a->y.low -= room;
    a->y.high += room;
    label_axes(d, a);
    return SP_OK;
}

/* F at a time by linear interpolation, NAN outside the trace. */
static double height_at(const sp_plot_trace *t, double time) {
    for (int64_t k = 1; k < t->n; k++) {
        if (!finite_point(t, k - 1) || !finite_point(t, k) || time < t->t[k - 1] || time > t->t[k])
            continue;
        double step = t->t[k] - t->t[k - 1], part = step > 0.0 ? (time - t->t[k - 1]) / step : 0.0;
        return t->f[k - 1] * (1.0 - part) + t->f[k] * part;
    }
    return NAN;
}

static void make_label(const drawing *d, canvas *c, int j) {
    const char *raw = d->trace[j].label ? d->trace[j].label : "";
    for (int most = LABEL_MOST; most >= 6; most -= 2) {
        sp_figure_text_escape(d->label[j], sizeof d->label[j], raw, most);
        if (sp_figure_text_width(c, d->label[j], TEXT_LEGEND) < 0.42 * c->width)
            break;
    }
}

static void add_traces(drawing *d, figure *f) {
    int64_t at = 0;
    for (int j = 0; j < d->traces; j++) {
        const sp_plot_trace *t = &d->trace[j];
        for (int64_t k = 0; k < t->n; k++) {
            d->x[at + k] = finite_point(t, k) ? sp_axis_unit(&f->axes.x, t->t[k]) : NAN;
            d->y[at + k] = finite_point(t, k) ? sp_axis_unit(&f->axes.y, t->f[k]) : NAN;
        }
        /* dashes change when the colours repeat */
        d->series[j] = (series){.n = t->n,
                                .x = d->x + at,
                                .y = d->y + at,
                                .ink = sp_figure_ink(j + (d->traces > 1)),
                                .dash = (j + j / INKS) % DASHES,
                                .width = 0.9};
        if (d->traces <= LEGEND_MOST && t->label && t->label[0]) {
            make_label(d, f->canvas, j);
            d->series[j].label = d->label[j];
        }
        at += t->n;
    }
    if (d->traces > LEGEND_MOST) {
        snprintf(d->label[0], sizeof d->label[0], "%d signals", d->traces);
        d->series[0].label = d->label[0];
    }
    f->n = d->traces;
}

/* Marks of the first front, as in Fig. 6 of Somfai et al. 2005. They have their own group in the legend. */
static void add_marks(drawing *d, figure *f) {
    static const marker shape[MARKS] = {MARKER_TRIANGLE, MARKER_CIRCLE, MARKER_SQUARE};
    static const char *const name[MARKS] = {"|t|_{10}", "|t|_{peak}", "|t|_{zero}"};
    for (int m = 0; m < MARKS; m++) {
        series mark = {.dash = DASH_NONE, .marker = shape[m], .open = true, .group = 1};
        const int before = f->n;
        for (int j = 0; j < d->traces; j++) {
            const sp_plot_trace *t = &d->trace[j];
            double time = m == 0 ? t->t10 : m == 1 ? t->t_peak : t->t_zero;
            double height = isfinite(time) ? height_at(t, time) : NAN;
            if (isnan(height))
                continue;
            double *x = d->mark_x + m * d->traces + j, *y = d->mark_y + m * d->traces + j;
            *x = sp_axis_unit(&f->axes.x, time);
            *y = sp_axis_unit(&f->axes.y, height);
            mark.n = 1;
            mark.x = x;
            mark.y = y;
            mark.ink = d->series[j].ink;
            d->series[f->n++] = mark;
        }
        if (f->n > before) {
            mark.n = 0; /* appears only in the legend, in black */
            mark.ink = sp_figure_ink(0);
            mark.label = name[m];
            d->series[f->n++] = mark;
        }
    }
}

static sp_status draw(drawing *d, const char *path, sp_error *err) {
    canvas c = {0};
    figure f = {.canvas = &c, .series = d->series, .zero_line = true};
    /* a long legend makes the figure taller */
    const double room = d->traces > 4 && d->traces <= LEGEND_MOST ? 10.0 * (d->traces - 4) : 0.0;
    sp_status status = set_axes(d, &f.axes, err);
    if (status == SP_OK)
        status =
            sp_canvas_open(&c, path, "Signals: force on the top wall", CANVAS_COLUMN, 0.66 * CANVAS_COLUMN + room, err);
    if (status == SP_OK) {
        add_traces(d, &f);
        add_marks(d, &f);
        sp_figure_draw(&f);
    }
    return sp_canvas_close(&c, status, err);
}

sp_status sp_plot_signal(int traces, const sp_plot_trace *trace, const char *path, sp_error *err) {
    drawing d = {.traces = traces, .trace = trace};
    sp_status status = sp_canvas_check(path, err);
    if (status != SP_OK)
        return status;
    if (traces < 1 || traces > TRACES_MOST)
        return sp_fail(err, SP_EINVAL, "%d signals: a figure shows 1 to %d", traces, TRACES_MOST);
    for (int j = 0; j < traces; j++) {
        if (trace[j].n < 0)
            return sp_fail(err, SP_EINVAL, "signal %d has %lld points", j + 1, (long long)trace[j].n);
        d.points += trace[j].n;
    }
    const size_t marks = MARKS * (size_t)traces;
    d.x = sp_alloc((size_t)d.points, 2 * sizeof *d.x);
    d.mark_x = sp_alloc(marks, 2 * sizeof *d.mark_x);
    d.series = sp_alloc(marks + MARKS + (size_t)traces, sizeof *d.series);
    d.label = sp_alloc((size_t)traces, sizeof *d.label);
    if (!d.x || !d.mark_x || !d.series || !d.label) {
        status = sp_fail_memory(err, (size_t)d.points * 2 * sizeof *d.x);
        goto out;
    }
    d.y = d.x + d.points;
    d.mark_y = d.mark_x + marks;
    status = draw(&d, path, err);
out:
    sp_free(d.x);
    sp_free(d.mark_x);
    sp_free(d.series);
    sp_free(d.label);
    return status;
}
