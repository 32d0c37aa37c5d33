/* Draws signals with the marks of their first fronts. */
#include "base/base.h"
#include "figure/canvas.h"
#include "figure/markup.h"
#include "figure/unit.h"

#include <math.h>
#include <sonopack/figure/figure.h>
#include <sonopack/figure/plot.h>
#include <stdio.h>
#include <string.h>

enum {
    LEGEND_MOST = 10, /* more traces are identified by their number */
    LABEL_MOST = 28,  /* length of the label of a trace [characters] */
    MARKS = 3,        /* t10, peak, zero crossing */
    TRACES_MOST = 16000,
    INKS_USED = 6,
    LABEL_ROOM = 200
};

typedef struct drawing {
    int traces;
    const sp_plot_trace *trace;
    double *place; /* [traces][MARKS][2] */
    sp_curve *curve;
    int curves;
    char (*label)[LABEL_ROOM];
    double low, high; /* times */
} drawing;

static bool finite_point(const sp_plot_trace *t, int64_t k) { return isfinite(t->t[k]) && isfinite(t->f[k]); }

/* Traces without units have those of sp_signal. */
static const char *unit_of(const sp_plot_trace *t, bool force) {
    const char *unit = !t->t_unit ? (force ? UNIT_FORCE : UNIT_TIME) : force ? t->f_unit : t->t_unit;
    return unit ? unit : "";
}

/* The unit that all traces have; "" if that of one is unknown. */
static const char *common_unit(const drawing *d, bool force) {
    for (int j = 0; j < d->traces; j++)
        if (!*unit_of(&d->trace[j], force))
            return "";
    return unit_of(&d->trace[0], force);
}

/* Curves in two units on one axis would look comparable. */
static sp_status check_units(const drawing *d, bool force, sp_error *err) {
    const char *unit = "";
    int first = 0;
    for (int j = 0; j < d->traces; j++) {
        const char *other = unit_of(&d->trace[j], force);
        if (*unit && *other && !sp_unit_same(unit, other))
            return sp_fail(err, SP_EINVAL, "signal %d has %s in %s, signal %d in %s: must be the same unit", first + 1,
                           force ? "F" : "t", unit, j + 1, other);
        if (!*unit && *other) {
            unit = other;
            first = j;
        }
    }
    return SP_OK;
}

static bool are_ours(const drawing *d) {
    bool ours = true;
    for (int j = 0; j < d->traces; j++)
        ours = ours && !d->trace[j].t_unit;
    return ours;
}

static sp_status find_times(drawing *d, sp_error *err) {
    d->low = INFINITY;
    d->high = -INFINITY;
    for (int j = 0; j < d->traces; j++)
        for (int64_t k = 0; k < d->trace[j].n; k++)
            if (finite_point(&d->trace[j], k)) {
                d->low = fmin(d->low, d->trace[j].t[k]);
                d->high = fmax(d->high, d->trace[j].t[k]);
            }
    if (!(d->low <= d->high))
        return sp_fail(err, SP_EREFUSED, "nothing to draw: no finite point in %d signal%s", d->traces,
                       d->traces == 1 ? "" : "s");
    return SP_OK;
}

/* F at a time by linear interpolation, NAN outside the trace. */
static double height_at(const sp_plot_trace *t, double time) {
    for (int64_t k = 1; k < t->n; k++) {
        if (!finite_point(t, k - 1) || !finite_point(t, k) || time < t->t[k - 1] || time > t->t[k])
            continue;
        const double step = t->t[k] - t->t[k - 1], part = step > 0.0 ? (time - t->t[k - 1]) / step : 0.0;
        return t->f[k - 1] * (1.0 - part) + t->f[k] * part;
    }
    return NAN;
}

static int ink_of(const drawing *d, int j) { return d->traces > 1 ? j % INKS_USED + 1 : 0; }

/* The label and the place of its detector; false if it has neither. */
static bool name_trace(const sp_plot_trace *t, char out[LABEL_ROOM]) {
    char plain[LABEL_ROOM - 80];
    sp_figure_text_escape(plain, sizeof plain, t->label ? t->label : "", LABEL_MOST);
    snprintf(out, LABEL_ROOM, "%s%s%.70s", plain, *plain && t->place ? ", " : "", t->place ? t->place : "");
    return *out != '\0';
}

static void add_traces(drawing *d) {
    for (int j = 0; j < d->traces; j++) {
        const sp_plot_trace *t = &d->trace[j];
        /* dashes change when the colours repeat */
        d->curve[d->curves] = (sp_curve){.n = t->n,
                                         .x = t->t,
                                         .y = t->f,
                                         .ink = ink_of(d, j),
                                         .dash = (sp_dash)((j + j / INKS_USED) % 4),
                                         .width = 0.9};
        if (d->traces <= LEGEND_MOST && name_trace(t, d->label[j]))
            d->curve[d->curves].label = d->label[j];
        d->curves++;
    }
    if (d->traces > LEGEND_MOST) {
        snprintf(d->label[0], LABEL_ROOM, "%d signals", d->traces);
        d->curve[0].label = d->label[0];
    }
}

/* Marks of the first front, as in Fig. 6 of Somfai et al. 2005, and black ones for the legend. */
static void add_marks(drawing *d) {
    static const sp_mark shape[MARKS] = {SP_MARK_TRIANGLE, SP_MARK_CIRCLE, SP_MARK_SQUARE};
    static const char *const name[MARKS] = {"|t|_{10}", "|t|_{peak}", "|t|_{zero}"};
    for (int m = 0; m < MARKS; m++) {
        sp_curve mark = {.n = 1, .dash = SP_DASH_NONE, .mark = shape[m], .open = true};
        const int before = d->curves;
        for (int j = 0; j < d->traces; j++) {
            const sp_plot_trace *t = &d->trace[j];
            const double time = m == 0 ? t->t10 : m == 1 ? t->t_peak : t->t_zero;
            double *place = d->place + 2 * (MARKS * j + m);
            place[0] = time;
            place[1] = isfinite(time) ? height_at(t, time) : NAN;
            if (isnan(place[1]))
                continue;
            mark.x = place;
            mark.y = place + 1;
            mark.ink = ink_of(d, j);
            d->curve[d->curves++] = mark;
        }
        if (d->curves > before)
            d->curve[d->curves++] = (sp_curve){.label = name[m], .dash = SP_DASH_NONE, .mark = shape[m], .open = true};
    }
}

static sp_status draw(drawing *d, const char *path, sp_error *err) {
    char x[UNIT_MARKUP + 16], y[UNIT_MARKUP + 16];
    add_traces(d);
    add_marks(d);
    const bool steady = d->low < d->high; /* one point has no range */
    const sp_panel panel = {
        .x = {.label = sp_unit_label("|t|", common_unit(d, false), x, sizeof x),
              .low = steady ? d->low : NAN,
              .high = steady ? d->high : NAN},
        .y = {.label = sp_unit_label(are_ours(d) ? "|F|_{sig}" : "|F|", common_unit(d, true), y, sizeof y)},
        .curves = d->curves,
        .curve = d->curve,
        .zero_line = true};
    /* a long legend makes the figure taller */
    const double more = d->traces > 4 && d->traces <= LEGEND_MOST ? 0.04 * (d->traces - 4) : 0.0;
    const sp_sheet sheet = {
        .title = "Signals: force on the top wall", .rows = 1, .columns = 1, .panel = &panel, .aspect = 0.66 + more};
    return sp_plot_sheet(&sheet, path, err);
}

sp_status sp_plot_signal(int traces, const sp_plot_trace *trace, const char *path, sp_error *err) {
    drawing d = {.traces = traces, .trace = trace};
    sp_status status = sp_canvas_check(path, err);
    if (status != SP_OK)
        return status;
    if (traces < 1 || traces > TRACES_MOST)
        return sp_fail(err, SP_EINVAL, "%d signals: a figure shows 1 to %d", traces, TRACES_MOST);
    for (int j = 0; j < traces; j++)
        if (trace[j].n < 0)
            return sp_fail(err, SP_EINVAL, "signal %d has %lld points", j + 1, (long long)trace[j].n);
    status = check_units(&d, false, err);
    if (status == SP_OK)
        status = check_units(&d, true, err);
    if (status == SP_OK)
        status = find_times(&d, err);
    if (status != SP_OK)
        return status;
    d.place = sp_alloc((size_t)traces, 2 * MARKS * sizeof *d.place);
    d.curve = sp_alloc((size_t)traces * (1 + MARKS) + MARKS, sizeof *d.curve);
    d.label = sp_alloc((size_t)traces, sizeof *d.label);
    if (d.place && d.curve && d.label)
        status = draw(&d, path, err);
    else
        status = sp_fail_memory(err, (size_t)traces * (1 + MARKS) * sizeof *d.curve);
    sp_free(d.place);
    sp_free(d.curve);
    sp_free(d.label);
    return status;
}
