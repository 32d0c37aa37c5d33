/* Draws the speed of sound against pressure, with its power law. */
#include "figure/figure.h"

#include "base/base.h"

#include <math.h>
#include <sonopack/figure/plot.h>
#include <stdio.h>

/* Columns of the figure: log10 of the values, NAN for an empty cell. */
enum { C_P = 0, C_TOF, C_L, C_T, C_LOW, C_HIGH = C_LOW + 3, C_COLUMNS = C_HIGH + 3, SPEEDS = 3 };

typedef struct speeds {
    int64_t n;
    double *column[C_COLUMNS];
    double *memory;
    double low_p, high_p, low_c, high_c; /* ranges of the points, log10 */
    int64_t points;
} speeds;

static double widen(double *low, double *high, double value) {
    *low = fmin(*low, value);
    *high = fmax(*high, value);
    return value;
}

/* log10 of a cell, NAN for NAN. SP_EREFUSED for values that a logarithmic axis cannot show. */
static sp_status cell_log(const sp_table *t, int64_t row, int column, double *out, sp_error *err) {
    double value = sp_table_number(t, row, column);
    *out = NAN;
    if (isnan(value))
        return SP_OK;
    if (!(value > 0.0) || isinf(value))
        return sp_fail(err, SP_EREFUSED, "row %lld, %s = %g: a logarithmic axis shows positive numbers only",
                       (long long)row + 1, t->column[column].name, value);
    *out = log10(value);
    return SP_OK;
}

/* Ends of the error bar of speed k. A bar that reaches zero ends at the bottom of the figure. column: indices of the
 * speed and its error, -1 if absent. */
static sp_status error_bar(const sp_table *t, int64_t row, int k, const int column[2], speeds *s, sp_error *err) {
    double *low = &s->column[C_LOW + k][row], *high = &s->column[C_HIGH + k][row];
    double error = column[1] < 0 ? NAN : sp_table_number(t, row, column[1]);
    double value = column[0] < 0 ? NAN : sp_table_number(t, row, column[0]);
    *low = *high = NAN;
    if (isnan(error) || isnan(value) || isnan(s->column[C_P][row]))
        return SP_OK;
    if (error < 0.0 || isinf(error))
        return sp_fail(err, SP_EREFUSED, "row %lld, %s = %g: an error is a number >= 0", (long long)row + 1,
                       t->column[column[1]].name, error);
    *high = widen(&s->low_c, &s->high_c, log10(value) + log1p(error / value) / M_LN10);
    *low = error < value ? log10(value) + log1p(-error / value) / M_LN10 : -1e3;
    if (error < 0.9 * value)
        widen(&s->low_c, &s->high_c, *low);
    return SP_OK;
}

static sp_status read_speeds(const sp_table *t, speeds *s, sp_error *err) {
    static const char *const name[] = {"p", "c_tof", "c_l", "c_t"};
    static const char *const errors[] = {"c_tof_err", "c_l_err", "c_t_err"};
    int column[4];
    for (int k = 0; k < 4; k++) {
        column[k] = sp_table_find_column(t, name[k]);
        if (column[k] < 0 && k < 2)
            return sp_fail(err, SP_EINVAL, "the table has no column %s; a ctof table has p, c_tof, c_tof_err, c_l, c_t",
                           name[k]);
    }
    for (int k = 0; k < 4; k++)
        if (column[k] >= 0 && t->column[column[k]].kind == SP_CELL_TEXT)
            return sp_fail(err, SP_EINVAL, "column %s holds text: must be numbers, nan where there is none", name[k]);
    for (int64_t row = 0; row < t->rows; row++) {
        for (int k = 0; k < 4; k++) {
            double *to = &s->column[k][row];
            *to = NAN;
            if (column[k] < 0)
                continue;
            sp_status status = cell_log(t, row, column[k], to, err);
            if (status != SP_OK)
                return status;
            if (k == 0 || isnan(*to) || isnan(s->column[C_P][row]))
                continue;
            widen(&s->low_c, &s->high_c, *to);
            widen(&s->low_p, &s->high_p, s->column[C_P][row]);
            s->points++;
        }
        for (int k = 0; k < SPEEDS; k++) {
            const int bar[2] = {column[1 + k], sp_table_find_column(t, errors[k])};
            sp_status status = error_bar(t, row, k, bar, s, err);
            if (status != SP_OK)
                return status;
        }
    }
    if (s->points == 0)
        return sp_fail(err, SP_EREFUSED, "nothing to draw: no row of %lld has a pressure and a speed",
                       (long long)t->rows);
    return SP_OK;
}

/* Least-squares slope of log c_tof against log p, and its standard error. False with fewer than three points or a
 * single pressure. */
static bool fit_exponent(const speeds *s, double *exponent, double *error) {
    double n = 0.0, mx = 0.0, my = 0.0, sxx = 0.0, sxy = 0.0, rest = 0.0;
    const double *x = s->column[C_P], *y = s->column[C_TOF];
    for (int pass = 0; pass < 3; pass++) {
        for (int64_t k = 0; k < s->n; k++) {
            if (isnan(x[k]) || isnan(y[k]))
                continue;
            if (pass == 0) {
                n += 1.0;
                mx += x[k];
                my += y[k];
            } else if (pass == 1) {
                sxx += (x[k] - mx) * (x[k] - mx);
                sxy += (x[k] - mx) * (y[k] - my);
            } else {
                double off = y[k] - my - *exponent * (x[k] - mx);
                rest += off * off;
            }
        }
        if (pass == 0 && n < 3.0)
            return false;
        if (pass == 0) {
            mx /= n;
            my /= n;
        }
        if (pass == 1) {
            if (!(sxx > 1e-12))
                return false;
            *exponent = sxy / sxx;
        }
    }
    *error = sqrt(rest / (n - 2.0) / sxx);
    return true;
}

/* The power law of c_tof. The exponent comes from the table or from a fit, the prefactor from the mean of the points
 * weighted by their errors. */
typedef struct power_law {
    bool known;
    double exponent, error;
    double x[2], y[2]; /* ends of the line, log10 */
} power_law;

static power_law find_law(const sp_table *t, const speeds *s) {
    power_law law = {.exponent = NAN, .error = NAN};
    sp_table_get_number(t, "exponent_err", &law.error);
    law.known = sp_table_get_number(t, "exponent", &law.exponent) || fit_exponent(s, &law.exponent, &law.error);
    double sum[2] = {0.0, 0.0}, weights[2] = {0.0, 0.0}; /* weighted by the errors; with equal weights */
    bool errors = true;
    law.x[0] = INFINITY;
    law.x[1] = -INFINITY;
    for (int64_t k = 0; k < s->n && law.known; k++) {
        const double x = s->column[C_P][k], y = s->column[C_TOF][k], off = y - law.exponent * x;
        const double bar = s->column[C_HIGH][k] - y;
        if (isnan(off))
            continue;
        widen(&law.x[0], &law.x[1], x);
        errors = errors && bar > 0.0;
        sum[0] += bar > 0.0 ? off / (bar * bar) : 0.0;
        weights[0] += bar > 0.0 ? 1.0 / (bar * bar) : 0.0;
        sum[1] += off;
        weights[1] += 1.0;
    }
    const double off = errors ? sum[0] / weights[0] : sum[1] / weights[1];
    for (int k = 0; k < 2; k++)
        law.y[k] = off + law.exponent * law.x[k];
    law.known = law.known && law.x[0] < law.x[1] && isfinite(law.y[0]) && isfinite(law.y[1]);
    return law;
}

static void tof_label(const power_law *law, char *label, size_t size) {
    char number[64];
    sp_figure_text_measured(number, sizeof number, law->exponent, law->error);
    if (law->known)
        snprintf(label, size, "|c|_{tof} ~ |p|^{%s}", number);
    else
        snprintf(label, size, "|c|_{tof}");
}

/* Leaves the same margin on all sides of the points and the published line. */
static void set_axes(figure *f, speeds *s, const double *line_y) {
    widen(&s->low_c, &s->high_c, line_y[0]);
    widen(&s->low_c, &s->high_c, line_y[1]);
    double pad_p = fmax(0.25, 0.04 * (s->high_p - s->low_p)), pad_c = fmax(0.12, 0.06 * (s->high_c - s->low_c));
    sp_axis_log(&f->axes.x, s->low_p - pad_p, s->high_p + pad_p, 2.0);
    sp_axis_log(&f->axes.y, s->low_c - pad_c, s->high_c + pad_c, 0.5);
    snprintf(f->axes.x.label, sizeof f->axes.x.label, "|p|  [|E|*]");
    snprintf(f->axes.y.label, sizeof f->axes.y.label, "|c|  [(|E|*/|\xcf\x81|)^{1/2}]");
}

/* One column as a series. It has a legend entry if it has points. */
static series points(const speeds *s, int column, int ink, marker shape, const char *label) {
    series out = {.n = s->n, .x = s->column[C_P], .y = s->column[column], .ink = sp_figure_ink(ink), .dash = DASH_NONE};
    out.marker = shape;
    out.open = column != C_TOF;
    out.group = column != C_TOF; /* two low legends may fit where one high legend would cover points */
    out.low = s->column[column - C_TOF + C_LOW];
    out.high = s->column[column - C_TOF + C_HIGH];
    for (int64_t k = 0; k < s->n; k++)
        if (!isnan(out.x[k]) && !isnan(out.y[k]))
            out.label = label;
    return out;
}

static sp_status draw(const sp_table *t, speeds *s, const char *path, sp_error *err) {
    canvas c;
    sp_status status =
        sp_canvas_open(&c, path, "Sound speeds against pressure", CANVAS_COLUMN, 0.78 * CANVAS_COLUMN, err);
    if (status == SP_OK) {
        char label[128];
        const power_law law = find_law(t, s);
        tof_label(&law, label, sizeof label);
        /* c_tof = 0.26 (p/1e-4)^(1/6): Somfai et al. 2005, Secs. IV C and D */
        const double beyond = fmax(0.15, 0.5 - 0.5 * (s->high_p - s->low_p));
        const double line_x[2] = {s->low_p - beyond, s->high_p + beyond};
        const double line_y[2] = {log10(0.26) + (line_x[0] + 4.0) / 6.0, log10(0.26) + (line_x[1] + 4.0) / 6.0};
        series all[5] = {{.n = law.known ? 2 : 0, .x = law.x, .y = law.y, .ink = sp_figure_ink(1), .width = 0.6}};
        all[0].key = MARKER_CIRCLE;
        all[0].label = law.known ? label : NULL;
        all[1] = (series){.n = 2, .x = line_x, .y = line_y, .ink = sp_figure_ink(0), .dash = DASH_DASHED, .width = 0.8};
        all[1].label = "|p|^{1/6}, Somfai |et al.|";
        all[2] = points(s, C_TOF, 1, MARKER_CIRCLE, law.known ? NULL : label);
        all[3] = points(s, C_L, 2, MARKER_SQUARE, "|c|_{l}");
        all[4] = points(s, C_T, 3, MARKER_TRIANGLE, "|c|_{t}");
        figure f = {.canvas = &c, .n = 5, .series = all};
        set_axes(&f, s, line_y);
        sp_figure_draw(&f);
    }
    return sp_canvas_close(&c, status, err);
}

sp_status sp_plot_ctof(const sp_table *ctof, const char *path, sp_error *err) {
    speeds s = {.n = ctof->rows, .low_p = INFINITY, .high_p = -INFINITY, .low_c = INFINITY, .high_c = -INFINITY};
    sp_status status = sp_canvas_check(path, err);
    if (status != SP_OK)
        return status;
    s.memory = sp_alloc((size_t)s.n, C_COLUMNS * sizeof *s.memory);
    if (!s.memory)
        return sp_fail_memory(err, (size_t)s.n * C_COLUMNS * sizeof *s.memory);
    for (int k = 0; k < C_COLUMNS; k++)
        s.column[k] = s.memory + k * s.n;
    status = read_speeds(ctof, &s, err);
    if (status == SP_OK)
        status = draw(ctof, &s, path, err);
    sp_free(s.memory);
    return status;
}
