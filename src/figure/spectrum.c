/* Draws the tables of `sonopack spectrum'. */
#include "figure/columns.h"
#include "figure/figure.h"
#include "figure/settings.h"

#include "base/base.h"

#include <math.h>
#include <sonopack/figure/plot.h>
#include <stdio.h>
#include <string.h>

enum { TABLES_MOST = 32, LABEL_MOST = 28, GROUPS = 3 };

#define OMEGA "\xcf\x89"
#define RHO   "\xcf\x81"
/* units */
#define FREQUENCY "(|E|*/|" RHO "|)^{1/2}/|d|"
#define TIME      "|d|(|" RHO "|/|E|*)^{1/2}"
#define RESPONSE  "|E|* |d|^{3}(|" RHO "|/|E|*)^{1/2}"

typedef enum look { LOOK_LINE = 0, LOOK_STEPS, LOOK_POINTS, LOOK_BINS } look;

/* How a kind of table is drawn. log: values span decades. */
typedef struct style {
    const char *kind;  /* metadata "spectrum" */
    const char *title; /* title of the figure */
    const char *y, *error;
    look look;
    bool log;
    const char *label, *unit; /* of the y axis */
} style;

static const style styles[] = {
    {"dos", "Density of states", "smooth", "smooth_err", LOOK_LINE, false, "|g|(|" OMEGA "|)", ""},
    {"ensemble", "Density of states", "density", NULL, LOOK_BINS, false, "|g|(|" OMEGA "|)", ""},
    {"transmission", "Spectrum of the signal", "magnitude", NULL, LOOK_LINE, true, "\\||F|(|" OMEGA "|)\\|", RESPONSE},
    {"harmonic", "Harmonic response", "magnitude", NULL, LOOK_POINTS, true, "\\||F|(|" OMEGA "|)\\|", RESPONSE},
    {"participation", "Participation ratio", "participation", "sd", LOOK_POINTS, false, "participation ratio", ""},
    {"modes", "Density of states", NULL, NULL, LOOK_STEPS, false, "|g|(|" OMEGA "|)", TIME}};
enum { STYLES = sizeof styles / sizeof *styles };

/* Further columns of a harmonic response. */
static const style responses[] = {
    {"harmonic", "Attenuation", "alpha", "alpha_err", LOOK_POINTS, false, "|\xce\xb1|", "1/|d|"},
    {"harmonic", "Wave number", "k", "k_err", LOOK_POINTS, false, "|k|", "1/|d|"},
    {"harmonic", "Speed of waves", "speed", "speed_err", LOOK_POINTS, false, "speed", "(|E|*/|" RHO "|)^{1/2}"}};
enum { RESPONSES = sizeof responses / sizeof *responses };

typedef struct drawing {
    int tables;
    const sp_plot_table *table;
    const style *style;
    double *memory; /* memory of all arrays */
    size_t used, room;
    series series[2 * TABLES_MOST + GROUPS];
    int count;
    char label[TABLES_MOST][SETTINGS_LABEL], band[80];
    double low_x, high_x, low_y, high_y; /* ranges of the visible points; log10 on a logarithmic axis */
} drawing;

static double *take(drawing *d, int64_t n) {
    double *a = d->memory + d->used;
    d->used += (size_t)n;
    return a;
}

static void widen(double *low, double *high, double value) {
    if (!isfinite(value))
        return;
    *low = fmin(*low, value);
    *high = fmax(*high, value);
}

static sp_status find_column(const sp_table *t, const char *name, int *out, sp_error *err) {
    return sp_column_find(t, name, "must be from `sonopack spectrum' without --lines and --profile", out, err);
}

static sp_status style_of(const sp_table *t, const style **out, sp_error *err) {
    const char *kind = sp_table_get_text(t, "spectrum");
    if (!kind && sp_table_find_column(t, "omega") >= 0 && sp_table_find_column(t, "n") >= 0)
        kind = "modes";
    if (!kind && sp_table_find_column(t, "density_low") >= 0) /* CSV files have no metadata */
        kind = "ensemble";
    for (int k = 0; kind && k < STYLES; k++)
        if (strcmp(kind, styles[k].kind) == 0) {
            *out = &styles[k];
            return SP_OK;
        }
    return sp_fail(err, SP_EINVAL,
                   "no table to draw here: must be of `sonopack spectrum' dos, transmission, harmonic or "
                   "participation, of `sonopack modes', or of `sonopack table spectrum'");
}

/* A value on the scale of the axis. */
static double shown(const drawing *d, double value) {
    if (!d->style->log)
        return value;
    return value > 0 ? log10(value) : NAN;
}

static void name_series(drawing *d, int j, series *s) {
    if (d->tables < 2)
        return;
    sp_settings_label(d->tables, d->table, j, LABEL_MOST, d->label[j]);
    s->label = d->label[j][0] ? d->label[j] : NULL;
}

/* Draws the bins of a density of states as steps behind its smooth curve. */
static void add_steps(drawing *d, const sp_table *t) {
    const int low = sp_table_find_column(t, "low"), high = sp_table_find_column(t, "high"),
              density = sp_table_find_column(t, "density");
    if (low < 0 || high < 0 || density < 0)
        return;
    double *x = take(d, 2 * t->rows), *y = take(d, 2 * t->rows);
    for (int64_t k = 0; k < t->rows; k++) {
        x[2 * k] = sp_table_number(t, k, low);
        x[2 * k + 1] = sp_table_number(t, k, high);
        y[2 * k] = y[2 * k + 1] = sp_table_number(t, k, density);
        widen(&d->low_y, &d->high_y, y[2 * k]);
    }
    d->series[d->count++] =
        (series){.n = 2 * t->rows, .x = x, .y = y, .ink = sp_figure_ink(6), .dash = DASH_SOLID, .width = 0.7};
}

static sp_status add_curve(drawing *d, int j, sp_error *err) {
    const sp_table *t = d->table[j].table;
    int omega = -1, value = -1;
    sp_status status = find_column(t, "omega", &omega, err);
    if (status == SP_OK)
        status = find_column(t, d->style->y, &value, err);
    if (status != SP_OK)
        return status;
    if (d->tables == 1 && strcmp(d->style->kind, "dos") == 0)
        add_steps(d, t);
    const int error = d->style->error ? sp_table_find_column(t, d->style->error) : -1;
    double *x = take(d, t->rows), *y = take(d, t->rows), *low = take(d, t->rows), *high = take(d, t->rows), bars = 0,
           top = 0;
    for (int64_t k = 0; k < t->rows; k++) {
        const double v = sp_table_number(t, k, value), e = error < 0 ? 0 : sp_table_number(t, k, error);
        x[k] = sp_table_number(t, k, omega);
        y[k] = shown(d, v);
        low[k] = e > 0 ? shown(d, v - e) : NAN;
        high[k] = e > 0 ? shown(d, v + e) : NAN;
        bars = fmax(bars, e);
        top = fmax(top, fabs(v));
        widen(&d->low_x, &d->high_x, x[k]);
        widen(&d->low_y, &d->high_y, y[k]);
        widen(&d->low_y, &d->high_y, low[k]);
        widen(&d->low_y, &d->high_y, high[k]);
    }
    const bool points = d->style->look == LOOK_POINTS;
    series s = {.n = t->rows, .x = x, .y = y, .ink = sp_figure_ink(j + 1), .dash = j % DASHES, .width = 0.9};
    if (bars > 1e-4 * top) { /* smaller ones, as of rounding, would be caps without bars */
        s.low = low;
        s.high = high;
    }
    if (points) {
        static const marker shapes[] = {MARKER_CIRCLE, MARKER_SQUARE, MARKER_TRIANGLE, MARKER_DIAMOND};
        s.marker = shapes[j % 4];
        s.dash = strcmp(d->style->kind, "harmonic") == 0 ? DASH_SOLID : DASH_NONE;
        s.width = 0.6;
    }
    name_series(d, j, &s);
    d->series[d->count++] = s;
    return SP_OK;
}

/* Means over samples as steps, and their intervals as a band. */
static sp_status add_bins(drawing *d, int j, sp_error *err) {
    static const char *const names[] = {"low", "high", "density", "density_low", "density_high"};
    const sp_table *t = d->table[j].table;
    int column[5];
    sp_status status = SP_OK;
    for (int k = 0; k < 5 && status == SP_OK; k++)
        status = find_column(t, names[k], &column[k], err);
    if (status != SP_OK)
        return status;
    double *x = take(d, 2 * t->rows), *y = take(d, 2 * t->rows), *low = take(d, 2 * t->rows),
           *high = take(d, 2 * t->rows);
    for (int64_t k = 0; k < 2 * t->rows; k++) {
        x[k] = sp_table_number(t, k / 2, column[k % 2]);
        y[k] = sp_table_number(t, k / 2, column[2]);
        const double end = sp_table_number(t, k / 2, column[3]);
        low[k] = end < 0 ? 0 : end; /* densities are not negative */
        high[k] = sp_table_number(t, k / 2, column[4]);
        widen(&d->low_x, &d->high_x, x[k]);
        widen(&d->low_y, &d->high_y, y[k]);
        widen(&d->low_y, &d->high_y, low[k]);
        widen(&d->low_y, &d->high_y, high[k]);
    }
    series s = {.n = 2 * t->rows, .x = x, .y = y, .fill_low = low, .fill_high = high, .ink = sp_figure_ink(j + 1)};
    s.dash = j % DASHES;
    s.width = 0.9;
    name_series(d, j, &s);
    d->series[d->count++] = s;
    return SP_OK;
}

/* Legend entry for steps and bands, below the labels of the tables. */
static void add_key(drawing *d) {
    char first[64], other[64];
    sp_settings_interval(d->table[0].table, first, sizeof first);
    for (int j = 1; j < d->tables; j++) {
        sp_settings_interval(d->table[j].table, other, sizeof other);
        if (strcmp(first, other) != 0)
            snprintf(first, sizeof first, "interval");
    }
    snprintf(d->band, sizeof d->band, "mean, %s", first);
    if (d->tables == 1)
        d->series[0].label = d->band;
    else
        d->series[d->count++] = (series){.fill_low = d->memory, .fill_high = d->memory, .width = 0.9, .label = d->band};
}

/* Histogram of the frequencies of a table of modes, with integral 1. */
static sp_status add_histogram(drawing *d, int j, sp_error *err) {
    enum { BINS_MOST = 60 };
    const sp_table *t = d->table[j].table;
    double last = 0, count = 0;
    int omega = -1;
    sp_status status = find_column(t, "omega", &omega, err);
    if (status != SP_OK)
        return status;
    for (int64_t k = 0; k < t->rows; k++) {
        const double w = sp_table_number(t, k, omega);
        last = isfinite(w) ? fmax(last, w) : last;
        count += w > 0 && isfinite(w);
    }
    if (!(last > 0))
        return sp_fail(err, SP_EREFUSED, "nothing to draw: no frequency above 0");
    const int bins = (int)fmin(BINS_MOST, fmax(5, sqrt(count)));
    double *x = take(d, 2 * BINS_MOST), *y = take(d, 2 * BINS_MOST);
    for (int64_t k = 0; k < t->rows; k++) {
        const double w = sp_table_number(t, k, omega);
        if (w > 0 && isfinite(w))
            y[2 * (int)fmin(bins - 1, floor(w / last * bins))] += bins / (last * count);
    }
    for (int b = 0; b < bins; b++) {
        x[2 * b] = last * b / bins;
        x[2 * b + 1] = last * (b + 1) / bins;
        y[2 * b + 1] = y[2 * b];
        widen(&d->low_y, &d->high_y, y[2 * b]);
    }
    widen(&d->low_x, &d->high_x, 0);
    widen(&d->low_x, &d->high_x, last);
    series s = {.n = 2 * bins, .x = x, .y = y, .ink = sp_figure_ink(j + 1), .dash = j % DASHES, .width = 0.9};
    name_series(d, j, &s);
    d->series[d->count++] = s;
    return SP_OK;
}

static void label_y(const drawing *d, axis *a) {
    char unit[96];
    const char *norm = sp_table_get_text(d->table[0].table, "norm");
    snprintf(unit, sizeof unit, "%s", d->style->unit);
    if (strcmp(d->style->kind, "dos") == 0 || d->style->look == LOOK_BINS) {
        const char *per = norm && strcmp(norm, "grain") == 0 ? "/grain" : "";
        const char *modes = norm && strcmp(norm, "modes") == 0 ? "modes " : "";
        snprintf(unit, sizeof unit, "%s" TIME "%s", modes, per);
    }
    sp_axis_name(a, d->style->label, unit);
}

static void set_axes(drawing *d, figure *f) {
    const double x0 = fmin(0, d->low_x), room = 0.02 * (d->high_x - x0);
    sp_axis_linear(&f->axes.x, x0, d->high_x + (d->style->look == LOOK_POINTS ? room : 0));
    sp_axis_name(&f->axes.x, "|" OMEGA "|", FREQUENCY);
    if (d->style->log) { /* the axis shows at most ten decades */
        const double low = fmax(d->low_y, d->high_y - 10);
        sp_axis_log(&f->axes.y, low - 0.05 * (d->high_y - low), d->high_y + 0.05 * (d->high_y - low) + 0.05, 1.0);
    } else {
        const double low = fmin(0, d->low_y);
        sp_axis_linear(&f->axes.y, low, d->high_y + 0.08 * (d->high_y - low));
    }
    label_y(d, &f->axes.y);
    for (int k = 0; k < d->count; k++) { /* convert to axis units */
        double *arrays[] = {(double *)d->series[k].y, (double *)d->series[k].low, (double *)d->series[k].high,
                            (double *)d->series[k].fill_low, (double *)d->series[k].fill_high};
        for (int q = 0; q < 5 && !d->style->log; q++)
            for (int64_t l = 0; arrays[q] && l < d->series[k].n; l++)
                arrays[q][l] = sp_axis_unit(&f->axes.y, arrays[q][l]);
        double *x = (double *)d->series[k].x;
        for (int64_t l = 0; l < d->series[k].n; l++)
            x[l] = sp_axis_unit(&f->axes.x, x[l]);
    }
}

/* Draws the series on axes that are set. height: over the width. */
static sp_status draw(const drawing *d, figure *f, double height, const char *path, sp_error *err) {
    canvas c = {0};
    f->canvas = &c;
    f->n = d->count;
    f->series = d->series;
    const sp_status status = sp_canvas_open(&c, path, d->style->title, CANVAS_COLUMN, height * CANVAS_COLUMN, err);
    if (status == SP_OK)
        sp_figure_draw(f);
    f->canvas = NULL;
    return sp_canvas_close(&c, status, err);
}

static sp_status check_ranges(const drawing *d, const char *columns, sp_error *err) {
    if (!(d->low_x <= d->high_x) || !(d->low_y <= d->high_y))
        return sp_fail(err, SP_EREFUSED, "nothing to draw: no row has %s", columns);
    return SP_OK;
}

static sp_status begin(int tables, const sp_plot_table *table, const char *path, drawing *d, sp_error *err) {
    sp_status status = sp_canvas_check(path, err);
    if (status != SP_OK)
        return status;
    if (tables < 1 || tables > TABLES_MOST)
        return sp_fail(err, SP_EINVAL, "%d tables: a figure shows 1 to %d", tables, TABLES_MOST);
    *d = (drawing){.tables = tables, .table = table, .low_x = INFINITY, .high_x = -INFINITY};
    d->low_y = INFINITY;
    d->high_y = -INFINITY;
    for (int j = 0; j < tables; j++)
        d->room += 8 * (size_t)table[j].table->rows * GROUPS + 256;
    d->memory = sp_alloc(d->room, sizeof *d->memory);
    return d->memory ? SP_OK : sp_fail_memory(err, d->room * sizeof *d->memory);
}

/* column: style of a column of a harmonic response; NULL for other tables */
static sp_status plot_tables(int tables, const sp_plot_table *table, const style *column, const char *path,
                             sp_error *err) {
    drawing d = {0};
    sp_status status = begin(tables, table, path, &d, err);
    for (int j = 0; j < tables && status == SP_OK; j++) {
        const style *own = NULL;
        status = style_of(table[j].table, &own, err);
        if (status == SP_OK && column && strcmp(own->kind, column->kind) != 0)
            status = sp_fail(err, SP_EINVAL, "column %s of a table of %s: must be of `sonopack spectrum harmonic'",
                             column->y, own->kind);
        own = column ? column : own;
        if (status == SP_OK && j > 0 && own != d.style)
            status = sp_fail(err, SP_EINVAL, "tables of %s and of %s in one figure, must be of one kind", d.style->kind,
                             own->kind);
        d.style = j == 0 ? own : d.style;
        if (status == SP_OK)
            status = own->look == LOOK_STEPS  ? add_histogram(&d, j, err)
                     : own->look == LOOK_BINS ? add_bins(&d, j, err)
                                              : add_curve(&d, j, err);
    }
    if (status == SP_OK && d.style->look == LOOK_BINS)
        add_key(&d);
    figure f = {0};
    if (status == SP_OK)
        status = check_ranges(&d, "a frequency and a value", err);
    if (status == SP_OK) {
        set_axes(&d, &f);
        status = draw(&d, &f, 0.72, path, err);
    }
    sp_free(d.memory);
    return status;
}

sp_status sp_plot_spectrum(int tables, const sp_plot_table *table, const char *path, sp_error *err) {
    return plot_tables(tables, table, NULL, path, err);
}

sp_status sp_plot_harmonic(int tables, const sp_plot_table *table, const char *column, const char *path,
                           sp_error *err) {
    for (int k = 0; k < RESPONSES; k++)
        if (strcmp(column, responses[k].y) == 0)
            return plot_tables(tables, table, &responses[k], path, err);
    return sp_fail(err, SP_EINVAL, "column %.60s: must be alpha, k or speed", column);
}

/* ---- waves ------------------------------------------------------------------------------------------------------ */

static const char *const polarizations[GROUPS] = {"longitudinal", "transverse", "rotational"};

typedef struct wave_columns {
    int polarization, k, peak, width;
} wave_columns;

static sp_status find_waves(const sp_table *t, wave_columns *c, sp_error *err) {
    c->polarization = sp_table_find_column(t, "polarization");
    if (c->polarization < 0 || t->column[c->polarization].kind != SP_CELL_TEXT)
        return sp_fail(
            err, SP_EINVAL,
            "the table has no words in a column polarization; must be one of `sonopack spectrum dispersion'");
    sp_status status = find_column(t, "k", &c->k, err);
    if (status == SP_OK)
        status = find_column(t, "peak", &c->peak, err);
    c->width = sp_table_find_column(t, "half_width");
    return status;
}

static void add_waves(drawing *d, int j, int group, const wave_columns *c) {
    static const marker shapes[GROUPS] = {MARKER_CIRCLE, MARKER_SQUARE, MARKER_TRIANGLE};
    const sp_table *t = d->table[j].table;
    double *x = take(d, t->rows), *y = take(d, t->rows), *low = take(d, t->rows), *high = take(d, t->rows);
    int64_t n = 0;
    for (int64_t r = 0; r < t->rows; r++) {
        const char *word = t->cells[r * t->columns + c->polarization].text;
        if (!word || strcmp(word, polarizations[group]) != 0)
            continue;
        const double width = c->width < 0 ? NAN : sp_table_number(t, r, c->width);
        x[n] = sp_table_number(t, r, c->k);
        y[n] = sp_table_number(t, r, c->peak);
        low[n] = fmax(y[n] - width, 0);
        high[n] = y[n] + width;
        if (isnan(width))
            low[n] = high[n] = NAN;
        widen(&d->low_x, &d->high_x, x[n]);
        widen(&d->low_y, &d->high_y, y[n]);
        widen(&d->low_y, &d->high_y, high[n++]);
    }
    if (n == 0)
        return;
    series s = {.n = n, .x = x, .y = y, .low = low, .high = high, .ink = sp_figure_ink(group + 1), .dash = DASH_NONE};
    s.marker = shapes[group];
    s.open = j > 0;
    if (j == 0)
        s.label = polarizations[group];
    else if (!d->label[j][0]) /* markers of the second table are open */
        name_series(d, j, &s);
    d->series[d->count++] = s;
}

sp_status sp_plot_dispersion(int tables, const sp_plot_table *table, const char *path, sp_error *err) {
    static const style waves = {"dispersion", "Dispersion of waves", "peak", NULL, LOOK_POINTS, false, "", ""};
    drawing d = {0};
    sp_status status = begin(tables, table, path, &d, err);
    d.style = &waves;
    if (status == SP_OK && tables > 2)
        status = sp_fail(err, SP_EINVAL, "%d tables of waves: a figure shows 1 or 2", tables);
    for (int j = 0; j < tables && status == SP_OK; j++) {
        wave_columns c = {0};
        status = find_waves(table[j].table, &c, err);
        for (int g = 0; g < GROUPS && status == SP_OK; g++)
            add_waves(&d, j, g, &c);
    }
    figure f = {0};
    if (status == SP_OK)
        status = check_ranges(&d, "a wave number and a peak", err);
    if (status == SP_OK) {
        set_axes(&d, &f);
        sp_axis_name(&f.axes.x, "|k|", "1/|d|");
        sp_axis_name(&f.axes.y, "|" OMEGA "|", FREQUENCY);
        status = draw(&d, &f, 0.78, path, err);
    }
    sp_free(d.memory);
    return status;
}
