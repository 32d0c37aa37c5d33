/* Checks the curves of a panel and turns them into series in axis units. */
#include "figure/panel.h"

#include "base/base.h"
#include "figure/look.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { ARRAYS = 6, CURVES_MOST = 1 << 16 };

typedef struct limits {
    double low, high;
} limits;

typedef struct maker {
    panel *p;
    const char *name;
    bool asked_x, asked_y; /* the reader asked for this logarithmic axis */
    limits x, y;           /* ranges of the visible points */
    bool marks;            /* a curve has markers: the axes extend beyond its points */
} maker;

/* ---- checks ----------------------------------------------------------------------------------------------------- */

static sp_status check_axis(const maker *m, const sp_axis *a, char which, sp_error *err) {
    if (isinf(a->low) || isinf(a->high) || a->low >= a->high)
        return sp_fail(err, SP_EINVAL, "%s: limits %g and %g of %c, must be finite and in rising order, or NAN",
                       m->name, a->low, a->high, which);
    if (a->log && (a->low <= 0 || a->high <= 0))
        return sp_fail(err, SP_EINVAL, "%s: limits %g and %g of a logarithmic axis %c, must be > 0", m->name, a->low,
                       a->high, which);
    return SP_OK;
}

static sp_status check_curve(const maker *m, int j, sp_error *err) {
    const sp_curve *k = &m->p->source.curve[j];
    if (k->n < 0 || (k->n > 0 && (!k->x || !k->y)))
        return sp_fail(err, SP_EINVAL, "%s, curve %d: %lld points%s", m->name, j + 1, (long long)k->n,
                       k->n > 0 ? " without x or y" : ", must be >= 0");
    if (!k->bar_low != !k->bar_high || (k->bar_low && k->error))
        return sp_fail(err, SP_EINVAL, "%s, curve %d: must have both ends of bars, or errors, or neither", m->name,
                       j + 1);
    if (!k->lower != !k->upper)
        return sp_fail(err, SP_EINVAL, "%s, curve %d: one edge of a band, must be both or none", m->name, j + 1);
    if (k->ink < -1 || k->ink >= INKS || (int)k->dash < 0 || k->dash > SP_DASH_NONE || (int)k->mark < 0 ||
        k->mark > SP_MARK_DOT)
        return sp_fail(err, SP_EINVAL, "%s, curve %d: ink %d, dash %d, mark %d: no such one", m->name, j + 1, k->ink,
                       (int)k->dash, (int)k->mark);
    if (!(k->width >= 0) || isinf(k->width))
        return sp_fail(err, SP_EINVAL, "%s, curve %d: width %g, must be >= 0", m->name, j + 1, k->width);
    return SP_OK;
}

static sp_status check(const maker *m, sp_error *err) {
    const sp_panel *s = &m->p->source;
    if (s->curves < 0 || s->curves > CURVES_MOST || (s->curves > 0 && !s->curve))
        return sp_fail(err, SP_EINVAL, "%s: %d curves%s", m->name, s->curves,
                       s->curves > 0 && !s->curve ? ", but NULL" : ", must be 0 to 65536");
    sp_status status = check_axis(m, &s->x, 'x', err);
    if (status == SP_OK)
        status = check_axis(m, &s->y, 'y', err);
    for (int j = 0; j < s->curves && status == SP_OK; j++)
        status = check_curve(m, j, err);
    return status;
}

/* An error for a point that an axis cannot show. A point that is not finite makes a gap. */
static sp_status check_point(const maker *m, int j, int64_t k, sp_error *err) {
    const sp_panel *s = &m->p->source;
    const sp_curve *c = &s->curve[j];
    if (c->x[k] < s->x.low || c->x[k] > s->x.high)
        return SP_OK; /* outside the frame */
    const bool x = s->x.log && isfinite(c->x[k]) && c->x[k] <= 0;
    const bool y = s->y.log && isfinite(c->y[k]) && c->y[k] <= 0 && !(c->steps && k == c->n - 1);
    if ((x && m->asked_x) || (y && !x && m->asked_y)) { /* zeros lie below the frame */
        const double value = x ? c->x[k] : c->y[k];
        return value == 0 ? SP_OK
                          : sp_fail(err, SP_EINVAL, "look.log %c: %s%s%.60s, point %lld: %c = %g is below 0",
                                    x ? 'x' : 'y', m->name, c->label ? ", " : "", c->label ? c->label : "",
                                    (long long)k + 1, x ? 'x' : 'y', value);
    }
    if (x || y)
        return sp_fail(err, SP_EREFUSED,
                       "%s, curve %d%s%.60s, point %lld: %c = %g, a logarithmic axis shows positive numbers only",
                       m->name, j + 1, c->label ? " " : "", c->label ? c->label : "", (long long)k + 1, x ? 'x' : 'y',
                       x ? c->x[k] : c->y[k]);
    if (c->error && c->error[k] < 0)
        return sp_fail(err, SP_EREFUSED, "%s, curve %d, point %lld: error %g, must be >= 0", m->name, j + 1,
                       (long long)k + 1, c->error[k]);
    return SP_OK;
}

/* ---- ranges ----------------------------------------------------------------------------------------------------- */

static void widen(limits *l, const sp_axis *a, double value) {
    if (!isfinite(value) || (a->log && value <= 0))
        return;
    l->low = fmin(l->low, value);
    l->high = fmax(l->high, value);
}

static void widen_point(maker *m, const sp_curve *c, int64_t k) {
    const sp_panel *s = &m->p->source;
    const bool end = c->steps && k == c->n - 1; /* only the right end of the last step */
    if (!isfinite(c->x[k]) || (!end && !isfinite(c->y[k])))
        return;
    widen(&m->x, &s->x, c->x[k]);
    /* points outside the limits of x do not affect the range of y */
    if (end || c->x[k] < s->x.low || c->x[k] > s->x.high)
        return;
    widen(&m->y, &s->y, c->y[k]);
    if (c->error && isfinite(c->error[k])) {
        widen(&m->y, &s->y, c->y[k] + c->error[k]);
        /* an error bar that nearly reaches zero would extend a logarithmic axis over decades */
        if (!s->y.log || c->error[k] < 0.9 * c->y[k])
            widen(&m->y, &s->y, c->y[k] - c->error[k]);
    }
    if (c->bar_low) {
        widen(&m->y, &s->y, c->bar_high[k]);
        if (!s->y.log || c->bar_low[k] > 0.1 * c->y[k])
            widen(&m->y, &s->y, c->bar_low[k]);
    }
    if (c->lower) {
        widen(&m->y, &s->y, c->lower[k]);
        widen(&m->y, &s->y, c->upper[k]);
    }
}

static sp_status find_ranges(maker *m, sp_error *err) {
    const sp_panel *s = &m->p->source;
    for (int j = 0; j < s->curves; j++) {
        const sp_curve *c = &s->curve[j];
        for (int64_t k = 0; k < c->n; k++) {
            sp_status status = check_point(m, j, k, err);
            if (status != SP_OK)
                return status;
            widen_point(m, c, k);
        }
        m->marks = m->marks || (c->mark != SP_MARK_NONE && c->n > 0);
    }
    if (s->zero_line && !s->y.log)
        widen(&m->y, &s->y, 0);
    return SP_OK;
}

/* Sets an axis to the given limits. A limit that is not given follows from the range of the points, with a margin. */
static sp_status set_axis(const maker *m, const sp_axis *a, limits range, double space, axis *out, sp_error *err) {
    const bool low = isfinite(a->low), high = isfinite(a->high);
    if (!(range.low <= range.high) && (!low || !high))
        return sp_fail(err, SP_EREFUSED, "%s: nothing to draw, no point within its axes", m->name);
    limits l = {low ? a->low : range.low, high ? a->high : range.high};
    if (l.low > l.high || (l.low == l.high && low != high)) { /* all points lie beyond the limit */
        const double one = low ? l.low : l.high, size = a->log ? 9 * one : fmax(fabs(one), 1e-300);
        l = low ? (limits){one, fmin(one + size, DBL_MAX)}
                : (limits){a->log ? fmax(0.1 * one, DBL_TRUE_MIN) : fmax(one - size, -DBL_MAX), one};
    }
    if (!a->log) {
        sp_axis_linear(out, l.low, l.high);
        const double pad = space * (out->high - out->low);
        out->low -= low ? 0 : pad;
        out->high += high ? 0 : pad;
        return SP_OK;
    }
    const double from = log10(l.low), to = log10(l.high), pad = space > 0 ? fmax(space * (to - from), 0.04) : 0;
    sp_axis_log(out, low ? from : from - pad, high ? to : to + pad, low && high ? 1e-9 : 0.3);
    if (low && !high)
        out->high += from - out->low, out->low = from;
    if (high && !low)
        out->low -= out->high - to, out->high = to;
    return SP_OK;
}

/* Adds a power of ten to the unit: "F [E* d^2]" becomes "F [10^-5 E* d^2]". */
static void name_axis(axis *a, const char *label) {
    char number[32];
    const char *unit = label ? strrchr(label, '[') : NULL;
    const size_t length = label ? strlen(label) : 0;
    snprintf(a->label, sizeof a->label, "%s", label ? label : "");
    if (a->power == 0)
        return;
    sp_figure_text_number(number, sizeof number, a->power, 4);
    if (unit && label[length - 1] == ']')
        snprintf(a->label, sizeof a->label, "%.*s[10^{%s} %s", (int)(unit - label), label, number, unit + 1);
    else
        snprintf(a->label, sizeof a->label, "%s%s[10^{%s}]", label ? label : "", length > 0 ? "  " : "", number);
}

/* The y axis of a histogram begins at zero. */
static void settle_y(const maker *m, axis *a) {
    const sp_panel *s = &m->p->source;
    bool stands = !s->y.log && !isfinite(s->y.low) && m->y.low >= 0;
    for (int j = 0; j < s->curves; j++)
        stands = stands && (s->curve[j].steps || s->curve[j].n == 0);
    if (stands && s->curves > 0)
        a->low = 0;
}

static sp_status set_axes(const maker *m, sp_error *err) {
    const sp_panel *s = &m->p->source;
    axes *a = &m->p->figure.axes;
    const bool steep = m->x.low < m->x.high;
    sp_status status = set_axis(m, &s->x, m->x, m->marks || !steep ? 0.04 : 0, &a->x, err);
    if (status == SP_OK)
        status = set_axis(m, &s->y, m->y, 0.06, &a->y, err);
    if (status != SP_OK)
        return status;
    settle_y(m, &a->y);
    name_axis(&a->x, s->x.label);
    name_axis(&a->y, s->y.label);
    m->p->grows = !isfinite(s->y.high) && !s->tight;
    return SP_OK;
}

/* ---- series ----------------------------------------------------------------------------------------------------- */

static int64_t points_of(const sp_curve *c) { return !c->steps ? c->n : c->n > 1 ? 2 * (c->n - 1) : 0; }

/* A value in axis units. Values that a logarithmic axis cannot show lie far below it. */
static double place(const axis *a, double value) {
    if (a->log && isfinite(value) && value <= 0)
        return -1e3;
    return isfinite(value) ? sp_axis_unit(a, value) : NAN;
}

/* Ends of the error bar of a point in axis units, NAN without one. */
static void bar_of(const sp_curve *c, int64_t k, const axis *a, double *low, double *high) {
    *low = *high = NAN;
    if (c->steps)
        return;
    if (c->error && isfinite(c->error[k])) {
        *low = place(a, c->y[k] - c->error[k]);
        *high = place(a, c->y[k] + c->error[k]);
    } else if (c->bar_low) {
        *low = place(a, c->bar_low[k]);
        *high = place(a, c->bar_high[k]);
    }
}

static void fill_series(const maker *m, const sp_curve *c, series *s, double *memory) {
    const axis *ax = &m->p->figure.axes.x, *ay = &m->p->figure.axes.y;
    const int64_t n = points_of(c);
    double *x = memory, *y = x + n, *low = y + n, *high = low + n, *fill_low = high + n, *fill_high = fill_low + n;
    for (int64_t q = 0; q < n; q++) {
        const int64_t k = c->steps ? q / 2 : q, at = c->steps ? (q + 1) / 2 : q;
        x[q] = place(ax, c->x[at]);
        y[q] = place(ay, c->y[k]);
        bar_of(c, k, ay, &low[q], &high[q]);
        fill_low[q] = c->lower ? place(ay, c->lower[k]) : NAN;
        fill_high[q] = c->lower ? place(ay, c->upper[k]) : NAN;
    }
    *s = (series){.n = n,
                  .x = x,
                  .y = y,
                  .low = (c->error || c->bar_low) && !c->steps ? low : NULL,
                  .high = (c->error || c->bar_low) && !c->steps ? high : NULL,
                  .fill_low = c->lower ? fill_low : NULL,
                  .fill_high = c->lower ? fill_high : NULL,
                  .ink = c->ink < 0 ? (colour){0.6, 0.6, 0.6} : sp_figure_ink(c->ink),
                  .dash = c->dash == SP_DASH_NONE ? DASH_NONE : (int)c->dash,
                  .width = c->width > 0 ? c->width : 1.0,
                  .marker = c->steps ? MARKER_NONE : (marker)c->mark,
                  .open = c->open,
                  .label = c->label && *c->label ? c->label : NULL};
}

static sp_status make_series(const maker *m, sp_error *err) {
    const sp_panel *s = &m->p->source;
    size_t count = 0;
    for (int j = 0; j < s->curves; j++)
        count += ARRAYS * (size_t)points_of(&s->curve[j]);
    m->p->memory = sp_alloc(count, sizeof *m->p->memory);
    m->p->series = sp_alloc((size_t)s->curves, sizeof *m->p->series);
    if (!m->p->memory || !m->p->series)
        return sp_fail_memory(err, count * sizeof *m->p->memory);
    double *memory = m->p->memory;
    for (int j = 0; j < s->curves; j++) {
        fill_series(m, &s->curve[j], &m->p->series[j], memory);
        memory += ARRAYS * points_of(&s->curve[j]);
    }
    m->p->figure.series = m->p->series;
    m->p->figure.n = s->curves;
    return SP_OK;
}

/* Limits that are both 0 are not given. */
static void axis_of(sp_axis *a) {
    if (a->low == 0 && a->high == 0)
        a->low = a->high = NAN;
}

sp_status sp_panel_make(panel *p, const sp_panel *source, int k, canvas *c, const char *name, sp_error *err) {
    *p = (panel){.source = *source, .columns = 1, .figure = {.canvas = c}};
    axis_of(&p->source.x);
    axis_of(&p->source.y);
    p->figure.zero_line = source->zero_line && !source->y.log;
    maker m = {.p = p, .name = name, .x = {INFINITY, -INFINITY}, .y = {INFINITY, -INFINITY}};
    m.asked_x = k >= 0 && sp_look_is_log('x', k);
    m.asked_y = k >= 0 && sp_look_is_log('y', k);
    sp_status status = check(&m, err);
    if (status == SP_OK)
        status = find_ranges(&m, err);
    if (status == SP_OK)
        status = set_axes(&m, err);
    if (status == SP_OK)
        status = make_series(&m, err);
    if (status != SP_OK || !source->inset)
        return status;
    if (k < 0)
        return sp_fail(err, SP_EINVAL, "%s: an inset in an inset", name);
    char inner[80];
    snprintf(inner, sizeof inner, "inset of %.60s", name);
    p->inset = sp_alloc(1, sizeof *p->inset);
    return p->inset ? sp_panel_make(p->inset, source->inset, -1, c, inner, err) : sp_fail_memory(err, sizeof *p->inset);
}

void sp_panel_free(panel *p) {
    if (p->inset)
        sp_panel_free(p->inset);
    sp_free(p->inset);
    sp_free(p->series);
    sp_free(p->memory);
    *p = (panel){0};
}
