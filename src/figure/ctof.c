/* Draws the speed of sound against pressure, with its power law. */
#include "base/base.h"
#include "figure/canvas.h"
#include "figure/look.h"
#include "figure/markup.h"
#include "figure/settings.h"
#include "figure/unit.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

enum { S_TOF = 0, S_L, S_T, SPEEDS, TABLES_MOST = 12, LABEL_MOST = 28, ENTRY = 256, LINE = 64 };

static const char *const names[SPEEDS] = {"c_tof", "c_l", "c_t"};
static const char *const errors[SPEEDS] = {"c_tof_err", "c_l_err", "c_t_err"};
static const char *const symbols[SPEEDS] = {"|c|_{tof}", "|c|_{l}", "|c|_{t}"};
static const sp_mark marks[SPEEDS] = {SP_MARK_CIRCLE, SP_MARK_SQUARE, SP_MARK_TRIANGLE};

/* The power law of c_tof. The exponent comes from the table or from a fit, the prefactor from the mean of the points
 * weighted by their errors. */
typedef struct power_law {
    bool known;
    double exponent, error;
    double x[LINE], y[LINE];
} power_law;

/* The points of one table. NAN: no value. */
typedef struct speeds {
    const sp_table *table;
    int64_t n;
    double *p, *c[SPEEDS], *error[SPEEDS];
    int64_t points[SPEEDS]; /* with a pressure and this speed */
    power_law law;
    char label[ENTRY];
} speeds;

typedef struct drawing {
    int tables;
    const sp_plot_table *table;
    speeds speeds[TABLES_MOST];
    double low, high; /* range of the pressures with a speed */
    const char *p_unit, *c_unit;
    bool published;
    double line_p[LINE], line_c[LINE]; /* the published line */
    sp_curve curve[TABLES_MOST * (2 + SPEEDS) + SPEEDS + 1];
    int curves;
} drawing;

/* ---- reading ---------------------------------------------------------------------------------------------------- */

static sp_status find_column(const sp_table *t, const char *name, bool needed, int *out, sp_error *err) {
    *out = sp_table_find_column(t, name);
    if (*out < 0 && needed)
        return sp_fail(err, SP_EINVAL, "the table has no column %s; a ctof table has p, c_tof, c_tof_err, c_l, c_t",
                       name);
    if (*out >= 0 && t->column[*out].kind == SP_COLUMN_TEXT)
        return sp_fail(err, SP_EINVAL, "column %s holds text: must be numbers, nan where there is none", name);
    return SP_OK;
}

/* A pressure or a speed is positive, an error is not negative, and each may be missing. */
static sp_status read_column(const sp_table *t, int column, bool is_error, double *to, sp_error *err) {
    for (int64_t row = 0; row < t->rows; row++) {
        to[row] = column < 0 ? NAN : sp_table_number(t, row, column);
        if (isnan(to[row]))
            continue;
        if (isinf(to[row]) || to[row] < 0 || (to[row] == 0 && !is_error))
            return sp_fail(err, SP_EREFUSED, "row %lld, %s = %g: must be %s", (long long)row + 1,
                           t->column[column].name, to[row], is_error ? "a number >= 0, or nan" : "above 0, or nan");
    }
    return SP_OK;
}

static sp_status read_speeds(speeds *s, double *memory, sp_error *err) {
    const sp_table *t = s->table;
    int p, column, error;
    s->n = t->rows;
    s->p = memory;
    sp_status status = find_column(t, "p", true, &p, err);
    if (status == SP_OK)
        status = find_column(t, "c_tof", true, &column, err);
    if (status == SP_OK)
        status = read_column(t, p, false, s->p, err);
    for (int q = 0; q < SPEEDS && status == SP_OK; q++) {
        s->c[q] = memory + (1 + 2 * q) * s->n;
        s->error[q] = s->c[q] + s->n;
        status = find_column(t, names[q], false, &column, err);
        if (status == SP_OK)
            status = find_column(t, errors[q], false, &error, err);
        if (status == SP_OK)
            status = read_column(t, column, false, s->c[q], err);
        if (status == SP_OK)
            status = read_column(t, error, true, s->error[q], err);
        for (int64_t k = 0; k < s->n && status == SP_OK; k++)
            s->points[q] += !isnan(s->p[k]) && !isnan(s->c[q][k]);
    }
    return status;
}

/* ---- the law ---------------------------------------------------------------------------------------------------- */

/* Least-squares slope of log c_tof against log p, and its standard error. False with fewer than three points or a
 * single pressure. */
static bool fit_exponent(const speeds *s, double *exponent, double *error) {
    double n = 0, mx = 0, my = 0, sxx = 0, sxy = 0, syy = 0;
    for (int64_t k = 0; k < s->n; k++) {
        if (isnan(s->p[k]) || isnan(s->c[S_TOF][k]))
            continue;
        const double x = log(s->p[k]), y = log(s->c[S_TOF][k]), dx = x - mx, dy = y - my;
        n += 1;
        mx += dx / n;
        my += dy / n;
        sxx += dx * (x - mx);
        sxy += dx * (y - my);
        syy += dy * (y - my);
    }
    if (n < 3 || !(sxx > 1e-12))
        return false;
    *exponent = sxy / sxx;
    *error = sqrt(fmax(0, syy - *exponent * sxy) / (n - 2) / sxx);
    return true;
}

/* Pressures from low to high. A power law is straight on logarithmic axes only, so that it needs more than its ends. */
static void spread(double low, double high, double p[LINE]) {
    for (int k = 0; k < LINE; k++)
        p[k] = fmin(DBL_MAX, exp(log(low) + (log(high) - log(low)) * k / (LINE - 1)));
}

static power_law find_law(const speeds *s) {
    power_law law = {.exponent = NAN, .error = NAN};
    double low = INFINITY, high = 0, sum[2] = {0, 0},
           weights[2] = {0, 0}; /* weighted by the errors; with equal weights */
    bool known = true;
    sp_table_get_number(s->table, "exponent_err", &law.error);
    law.known = sp_table_get_number(s->table, "exponent", &law.exponent) || fit_exponent(s, &law.exponent, &law.error);
    for (int64_t k = 0; k < s->n && law.known; k++) {
        const double off = log(s->c[S_TOF][k]) - law.exponent * log(s->p[k]), bar = s->error[S_TOF][k] / s->c[S_TOF][k];
        if (isnan(off))
            continue;
        low = fmin(low, s->p[k]);
        high = fmax(high, s->p[k]);
        known = known && bar > 0;
        sum[0] += bar > 0 ? off / (bar * bar) : 0;
        weights[0] += bar > 0 ? 1 / (bar * bar) : 0;
        sum[1] += off;
        weights[1] += 1;
    }
    const double off = known ? sum[0] / weights[0] : sum[1] / weights[1];
    law.known = law.known && low < high && isfinite(off);
    spread(low, high, law.x);
    for (int k = 0; k < LINE; k++)
        law.y[k] = exp(off + law.exponent * log(law.x[k]));
    return law;
}

/* c_tof = 0.26 (p/1e-4)^(1/6): Somfai et al. 2005, Secs. IV C and D, for two dimensions. */
static sp_status find_published(drawing *d, sp_error *err) {
    const sp_plot_published wish = sp_look()->published;
    const bool ours = sp_unit_same(d->p_unit, UNIT_PRESSURE) && sp_unit_same(d->c_unit, UNIT_SPEED);
    if (wish == SP_PLOT_PUBLISHED_ALWAYS && !ours)
        return sp_fail(err, SP_EINVAL, "look.published: the line has p in %s and c in %s, the table in %s and %s",
                       UNIT_PRESSURE, UNIT_SPEED, d->p_unit, d->c_unit);
    d->published = wish == SP_PLOT_PUBLISHED_ALWAYS ||
                   (wish != SP_PLOT_PUBLISHED_NEVER && ours && sp_settings_dimension(d->tables, d->table) == 2);
    const double beyond = pow(10, fmax(0.15, 0.5 - 0.5 * (log10(d->high) - log10(d->low))));
    spread(fmax(d->low / beyond, DBL_TRUE_MIN), fmin(d->high * beyond, DBL_MAX), d->line_p);
    for (int k = 0; k < LINE; k++)
        d->line_c[k] = 0.26 * pow(d->line_p[k] / 1e-4, 1.0 / 6);
    return SP_OK;
}

/* ---- curves ----------------------------------------------------------------------------------------------------- */

static sp_curve *add(drawing *d, sp_curve curve) {
    d->curve[d->curves] = curve;
    return &d->curve[d->curves++];
}

/* "label: c_tof ~ p^0.166(4)", without label for a single table. */
static void name_table(drawing *d, int j) {
    speeds *s = &d->speeds[j];
    char own[SETTINGS_LABEL] = "", exponent[64];
    if (d->tables > 1 || d->table[j].named)
        sp_settings_label(d->tables, d->table, j, LABEL_MOST, own);
    sp_figure_text_measured(exponent, sizeof exponent, s->law.exponent, s->law.error);
    snprintf(s->label, sizeof s->label, s->law.known ? "%s%s|c|_{tof} ~ |p|^{%s}" : "%s%s|c|_{tof}", own,
             *own ? ": " : "", exponent);
}

static int ink_of(const drawing *d, int j, int q) { return d->tables == 1 ? q + 1 : j % 6 + 1; }

/* Points, error bars and law of one table. One table has a colour for each speed, several have one each. */
static void add_table(drawing *d, int j) {
    speeds *s = &d->speeds[j];
    const sp_dash dash = (sp_dash)(j % 4);
    if (s->law.known)
        add(d, (sp_curve){.n = LINE, .x = s->law.x, .y = s->law.y, .ink = ink_of(d, j, 0), .dash = dash, .width = 0.7});
    for (int q = 0; q < SPEEDS; q++)
        if (s->points[q] > 0)
            add(d, (sp_curve){.n = s->n,
                              .x = s->p,
                              .y = s->c[q],
                              .error = s->error[q],
                              .ink = ink_of(d, j, q),
                              .dash = SP_DASH_NONE,
                              .mark = marks[q],
                              .open = q != S_TOF});
    name_table(d, j);
    add(d, (sp_curve){.label = s->label,
                      .ink = ink_of(d, j, 0),
                      .dash = s->law.known ? dash : SP_DASH_NONE,
                      .mark = marks[S_TOF],
                      .width = 0.7});
}

/* Entries of the legend for the other speeds: in black if the colours belong to several tables. */
static void add_keys(drawing *d) {
    for (int q = S_L; q < SPEEDS; q++) {
        int64_t points = 0;
        for (int j = 0; j < d->tables; j++)
            points += d->speeds[j].points[q];
        if (points > 0)
            add(d, (sp_curve){.label = symbols[q],
                              .ink = d->tables == 1 ? q + 1 : 0,
                              .dash = SP_DASH_NONE,
                              .mark = marks[q],
                              .open = true});
    }
    if (d->published)
        add(d, (sp_curve){.label = "|p|^{1/6}, Somfai |et al.|",
                          .n = LINE,
                          .x = d->line_p,
                          .y = d->line_c,
                          .dash = SP_DASH_DASHED,
                          .width = 0.8});
}

static sp_status draw(drawing *d, const char *path, sp_error *err) {
    char x[UNIT_MARKUP + 40], y[UNIT_MARKUP + 40];
    for (int j = 0; j < d->tables; j++)
        add_table(d, j);
    add_keys(d);
    const double beyond = pow(10, fmax(0.25, 1 - 0.5 * (log10(d->high) - log10(d->low))));
    const bool linear = sp_look()->x_scale == SP_PLOT_SCALE_LINEAR;
    const sp_panel panel = {.x = {.label = sp_unit_label("|p|", d->p_unit, x, sizeof x),
                                  .log = true,
                                  .low = linear ? 0 : fmax(d->low / beyond, DBL_TRUE_MIN),
                                  .high = linear ? NAN : fmin(d->high * beyond, DBL_MAX)},
                            .y = {.label = sp_unit_label("|c|", d->c_unit, y, sizeof y), .log = true},
                            .curves = d->curves,
                            .curve = d->curve};
    const sp_sheet sheet = {.title = "Sound speeds against pressure",
                            .rows = 1,
                            .columns = 1,
                            .panel = &panel,
                            .aspect = 0.78 + 0.03 * (d->tables - 1)};
    return sp_plot_sheet(&sheet, path, err);
}

/* ---- the figure ------------------------------------------------------------------------------------------------- */

static void widen(drawing *d, const speeds *s) {
    for (int64_t k = 0; k < s->n; k++)
        for (int q = 0; q < SPEEDS; q++)
            if (!isnan(s->p[k]) && !isnan(s->c[q][k])) {
                d->low = fmin(d->low, s->p[k]);
                d->high = fmax(d->high, s->p[k]);
            }
}

static sp_status read_tables(drawing *d, double *memory, sp_error *err) {
    sp_status status = SP_OK;
    int64_t rows = 0;
    for (int j = 0; j < d->tables && status == SP_OK; j++) {
        speeds *s = &d->speeds[j];
        s->table = d->table[j].table;
        status = read_speeds(s, memory, err);
        if (status != SP_OK)
            return d->tables > 1 ? sp_fail_prefix(err, "table %d", j + 1) : status;
        s->law = find_law(s);
        widen(d, s);
        memory += (1 + 2 * SPEEDS) * s->n;
        rows += s->n;
    }
    if (!(d->low <= d->high))
        return sp_fail(err, SP_EREFUSED, "nothing to draw: no row of %lld has a pressure and a speed", (long long)rows);
    status = sp_unit_common(d->tables, d->table, "p", UNIT_PRESSURE, &d->p_unit, err);
    return status == SP_OK ? sp_unit_common(d->tables, d->table, "c_tof", UNIT_SPEED, &d->c_unit, err) : status;
}

sp_status sp_plot_ctof_tables(int tables, const sp_plot_table *table, const char *path, sp_error *err) {
    size_t room = 0;
    sp_status status = sp_canvas_check(path, err);
    if (status == SP_OK && (tables < 1 || tables > TABLES_MOST))
        status = sp_fail(err, SP_EINVAL, "%d tables: a figure shows 1 to %d", tables, TABLES_MOST);
    for (int j = 0; j < tables && status == SP_OK; j++)
        room += (1 + 2 * SPEEDS) * (size_t)table[j].table->rows;
    if (status != SP_OK)
        return status;
    drawing *d = sp_alloc(1, sizeof *d);
    double *memory = sp_alloc(room, sizeof *memory);
    if (d && memory) {
        *d = (drawing){.tables = tables, .table = table, .low = INFINITY, .high = 0};
        status = read_tables(d, memory, err);
        if (status == SP_OK)
            status = find_published(d, err);
        if (status == SP_OK)
            status = draw(d, path, err);
    } else {
        status = sp_fail_memory(err, room * sizeof *memory);
    }
    sp_free(memory);
    sp_free(d);
    return status;
}

sp_status sp_plot_ctof(const sp_table *ctof, const char *path, sp_error *err) {
    const sp_plot_table one = {.table = ctof};
    return sp_plot_ctof_tables(1, &one, path, err);
}
