/* Draws the tables of `sonopack spectrum'. */
#include "figure/spectrum.h"

#include "base/base.h"
#include "figure/markup.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define OMEGA    "\xcf\x89"
#define RESPONSE "E* d^3/sqrt(E* / rho)"

typedef enum form { FORM_LINE = 0, FORM_STEPS, FORM_POINTS, FORM_BINS } form;

/* How a kind of table is drawn. log: values span decades. */
typedef struct style {
    const char *kind;  /* metadata "spectrum" */
    const char *title; /* title of the figure */
    const char *y, *error;
    form form;
    bool log;
    const char *label, *unit; /* of the y axis; the unit is that of tables that name none */
} style;

static const style styles[] = {
    {"dos", "Density of states", "smooth", "smooth_err", FORM_LINE, false, "|g|(|" OMEGA "|)", UNIT_TIME},
    {"ensemble", "Density of states", "density", NULL, FORM_BINS, false, "|g|(|" OMEGA "|)", UNIT_TIME},
    {"transmission", "Spectrum of the signal", "magnitude", NULL, FORM_LINE, true, "\\||F|(|" OMEGA "|)\\|", RESPONSE},
    {"harmonic", "Harmonic response", "magnitude", NULL, FORM_POINTS, true, "\\||F|(|" OMEGA "|)\\|", RESPONSE},
    {"participation", "Participation ratio", "participation", "sd", FORM_POINTS, false, "participation ratio", ""},
    {"modes", "Density of states", NULL, NULL, FORM_STEPS, false, "|g|(|" OMEGA "|)", UNIT_TIME}};
enum { STYLES = sizeof styles / sizeof *styles };

/* Further columns of a harmonic response. */
static const style responses[] = {
    {"harmonic", "Attenuation", "alpha", "alpha_err", FORM_POINTS, false, "|\xce\xb1|", UNIT_WAVE},
    {"harmonic", "Wave number", "k", "k_err", FORM_POINTS, false, "|k|", UNIT_WAVE},
    {"harmonic", "Speed of waves", "speed", "speed_err", FORM_POINTS, false, "speed", UNIT_SPEED}};
enum { RESPONSES = sizeof responses / sizeof *responses };

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

/* ---- curves ----------------------------------------------------------------------------------------------------- */

/* The bins of a density of states as a thin line behind its smooth curve. */
static void add_steps(spectrum_drawing *d, const sp_table *t) {
    const int low = sp_table_find_column(t, "low"), high = sp_table_find_column(t, "high"),
              density = sp_table_find_column(t, "density");
    if (low < 0 || high < 0 || density < 0)
        return;
    double *x = sp_spectrum_take(d, 2 * t->rows), *y = sp_spectrum_take(d, 2 * t->rows);
    for (int64_t k = 0; k < t->rows; k++) {
        x[2 * k] = sp_table_number(t, k, low);
        x[2 * k + 1] = sp_table_number(t, k, high);
        y[2 * k] = y[2 * k + 1] = sp_table_number(t, k, density);
    }
    d->curve[d->curves++] =
        (sp_curve){.label = "modes in bins", .n = 2 * t->rows, .x = x, .y = y, .ink = 6, .width = 0.7};
}

/* The ends of the bars of a row: one error from the value, but no farther than the least and the greatest value where
 * the table has them, so that no bar shows what cannot be. */
static void bar_of(const sp_table *t, int64_t row, double value, double error, double *low, double *high) {
    const int least = sp_table_find_column(t, "min"), most = sp_table_find_column(t, "max");
    *low = *high = NAN;
    if (!(error > 0))
        return;
    *low = value - error;
    *high = value + error;
    if (least >= 0 && most >= 0) {
        *low = fmax(*low, sp_table_number(t, row, least));
        *high = fmin(*high, sp_table_number(t, row, most));
    }
}

static sp_status add_curve(spectrum_drawing *d, const style *as, int j, sp_error *err) {
    const sp_table *t = d->table[j].table;
    int omega = -1, value = -1;
    sp_status status = sp_spectrum_column(t, "omega", &omega, err);
    if (status == SP_OK)
        status = sp_spectrum_column(t, as->y, &value, err);
    if (status != SP_OK)
        return status;
    const bool density = strcmp(as->kind, "dos") == 0, points = as->form == FORM_POINTS;
    if (d->tables == 1 && density)
        add_steps(d, t);
    const int error = as->error ? sp_table_find_column(t, as->error) : -1;
    double *x = sp_spectrum_take(d, t->rows), *y = sp_spectrum_take(d, t->rows), *low = sp_spectrum_take(d, t->rows),
           *high = sp_spectrum_take(d, t->rows), bars = 0, top = 0;
    for (int64_t k = 0; k < t->rows; k++) {
        const double v = sp_table_number(t, k, value), e = error < 0 ? 0 : sp_table_number(t, k, error);
        x[k] = sp_table_number(t, k, omega);
        y[k] = isfinite(v) && (!as->log || v > 0) ? v : NAN;
        bar_of(t, k, v, e, &low[k], &high[k]);
        bars = fmax(bars, e);
        top = fmax(top, fabs(v));
    }
    const bool barred = bars > 1e-4 * top; /* smaller ones, as of rounding, would be caps without bars */
    const char *name = sp_spectrum_name(d, j);
    sp_curve c = {.label = name ? name : density ? "smoothed" : NULL, .n = t->rows, .x = x, .y = y, .ink = j % 6 + 1};
    c.bar_low = barred ? low : NULL;
    c.bar_high = barred ? high : NULL;
    c.dash = (sp_dash)(j % 4);
    c.width = points ? 0.6 : 0.9;
    if (points) {
        static const sp_mark marks[] = {SP_MARK_CIRCLE, SP_MARK_SQUARE, SP_MARK_TRIANGLE, SP_MARK_DIAMOND};
        c.mark = marks[j % 4];
        c.dash = strcmp(as->kind, "harmonic") == 0 ? SP_DASH_SOLID : SP_DASH_NONE;
    }
    d->curve[d->curves++] = c;
    return SP_OK;
}

/* Means over samples as steps, and their intervals as a band. */
static sp_status add_bins(spectrum_drawing *d, int j, sp_error *err) {
    static const char *const names[] = {"low", "high", "density", "density_low", "density_high"};
    const sp_table *t = d->table[j].table;
    int column[5];
    sp_status status = SP_OK;
    for (int k = 0; k < 5 && status == SP_OK; k++)
        status = sp_spectrum_column(t, names[k], &column[k], err);
    if (status != SP_OK)
        return status;
    double *x = sp_spectrum_take(d, 2 * t->rows), *y = sp_spectrum_take(d, 2 * t->rows),
           *low = sp_spectrum_take(d, 2 * t->rows), *high = sp_spectrum_take(d, 2 * t->rows);
    for (int64_t k = 0; k < 2 * t->rows; k++) {
        x[k] = sp_table_number(t, k / 2, column[k % 2]);
        y[k] = sp_table_number(t, k / 2, column[2]);
        const double end = sp_table_number(t, k / 2, column[3]);
        low[k] = end < 0 ? 0 : end; /* densities are not negative */
        high[k] = sp_table_number(t, k / 2, column[4]);
    }
    d->curve[d->curves++] = (sp_curve){.label = sp_spectrum_name(d, j),
                                       .n = 2 * t->rows,
                                       .x = x,
                                       .y = y,
                                       .lower = low,
                                       .upper = high,
                                       .ink = j % 6 + 1,
                                       .dash = (sp_dash)(j % 4),
                                       .width = 0.9};
    return SP_OK;
}

/* Legend entry for steps and bands, below the labels of the tables. */
static void add_key(spectrum_drawing *d) {
    static const double nowhere[1] = {NAN};
    char first[64], other[64];
    sp_settings_interval(d->table[0].table, first, sizeof first);
    for (int j = 1; j < d->tables; j++) {
        sp_settings_interval(d->table[j].table, other, sizeof other);
        if (strcmp(first, other) != 0)
            snprintf(first, sizeof first, "interval");
    }
    snprintf(d->band, sizeof d->band, "mean, %s", first);
    if (!d->curve[0].label)
        d->curve[0].label = d->band;
    else
        d->curve[d->curves++] = (sp_curve){.lower = nowhere, .upper = nowhere, .width = 0.9, .label = d->band};
}

/* ---- tables of modes -------------------------------------------------------------------------------------------- */

/* Frequencies between which no mode is missing: metadata "complete = low:high". Without it, up to the highest. */
typedef struct range {
    double low, high, zero; /* modes at or below `zero' are zero modes */
} range;

static range range_of(const sp_table *t, int omega) {
    range r = {.low = 0, .high = INFINITY, .zero = 0};
    const char *text = sp_table_get_text(t, "complete");
    double low, high, last = 0;
    sp_table_get_number(t, "zero_below", &r.zero);
    if (text && sscanf(text, "%lf:%lf", &low, &high) == 2 && low < high)
        r = (range){fmax(low, 0), high, r.zero};
    for (int64_t k = 0; k < t->rows; k++) {
        const double w = sp_table_number(t, k, omega);
        last = isfinite(w) ? fmax(last, w) : last;
    }
    r.high = isfinite(r.high) ? r.high : last;
    return r;
}

static bool inside(const range *r, double omega) { return omega > r->zero && omega >= r->low && omega <= r->high; }

/* The number of grains that have modes, if all tables name it. */
static bool all_name_grains(const spectrum_drawing *d) {
    double grains;
    for (int j = 0; j < d->tables; j++)
        if (!sp_table_get_number(d->table[j].table, "carrying", &grains) || !(grains > 0))
            return false;
    return true;
}

/* Modes for each grain and unit of frequency, as of `sonopack spectrum dos'; without the number of grains, modes for
 * each unit of frequency. Both hold for a part of the spectrum too. */
static sp_status add_histogram(spectrum_drawing *d, int j, sp_error *err) {
    enum { BINS_MOST = 60 };
    const sp_table *t = d->table[j].table;
    double count = 0, grains = 1;
    int omega = -1;
    sp_status status = sp_spectrum_column(t, "omega", &omega, err);
    if (status != SP_OK)
        return status;
    const range r = range_of(t, omega);
    for (int64_t k = 0; k < t->rows; k++)
        count += inside(&r, sp_table_number(t, k, omega));
    if (!(count > 0))
        return sp_fail(err, SP_EREFUSED, "nothing to draw: no frequency above 0");
    if (all_name_grains(d))
        sp_table_get_number(t, "carrying", &grains);
    const int bins = (int)fmin(BINS_MOST, fmax(5, sqrt(count)));
    const double width = (r.high - r.low) / bins;
    double *x = sp_spectrum_take(d, 2 * BINS_MOST), *y = sp_spectrum_take(d, 2 * BINS_MOST);
    for (int64_t k = 0; k < t->rows; k++) {
        const double w = sp_table_number(t, k, omega);
        if (inside(&r, w))
            y[2 * (int)fmin(bins - 1, floor((w - r.low) / width))] += 1 / (width * grains);
    }
    for (int b = 0; b < bins; b++) {
        x[2 * b] = r.low + b * width;
        x[2 * b + 1] = r.low + (b + 1) * width;
        y[2 * b + 1] = y[2 * b];
    }
    const char *name = sp_spectrum_name(d, j);
    if (!name)
        snprintf(d->band, sizeof d->band, "%.0f modes in bins", count);
    d->curve[d->curves++] = (sp_curve){.label = name ? name : d->band,
                                       .n = 2 * bins,
                                       .x = x,
                                       .y = y,
                                       .ink = j % 6 + 1,
                                       .dash = (sp_dash)(j % 4),
                                       .width = 0.9};
    return SP_OK;
}

/* ---- axes ------------------------------------------------------------------------------------------------------- */

/* Densities of one norm only: "grain", "one" or "modes". */
static sp_status common_norm(const spectrum_drawing *d, const char **out, sp_error *err) {
    *out = NULL;
    for (int j = 0; j < d->tables; j++) {
        const char *norm = sp_table_get_text(d->table[j].table, "norm");
        if (norm && *out && strcmp(norm, *out) != 0)
            return sp_fail(err, SP_EINVAL, "table %d has the norm %s, an earlier one %s: must be the same", j + 1, norm,
                           *out);
        *out = norm ? norm : *out;
    }
    return SP_OK;
}

static sp_status label_y(const spectrum_drawing *d, const style *as, char *out, size_t size, sp_error *err) {
    const char *unit = as->unit, *norm = NULL;
    char markup[UNIT_MARKUP];
    sp_status status = as->y ? sp_unit_common(d->tables, d->table, as->y, as->unit, &unit, err)
                             : sp_unit_common(d->tables, d->table, "omega", UNIT_FREQUENCY, &unit, err);
    if (status == SP_OK)
        status = common_norm(d, &norm, err);
    if (status != SP_OK)
        return status;
    const bool modes = as->form == FORM_STEPS;
    if (modes)
        sp_unit_inverse(unit, markup);
    else
        sp_unit_markup(unit, markup);
    const bool per = modes ? all_name_grains(d) : norm && strcmp(norm, "grain") == 0;
    if (modes && !per)
        snprintf(out, size, "%s  [modes %s]", as->label, markup);
    else
        snprintf(out, size, *markup ? "%s  [%s%s]" : "%s", as->label, markup, per ? "/grain" : "");
    return SP_OK;
}

static double lowest(const spectrum_drawing *d, bool across) {
    double low = 0;
    for (int k = 0; k < d->curves; k++)
        for (int64_t l = 0; l < d->curve[k].n; l++) {
            const double value = across ? d->curve[k].x[l] : d->curve[k].y[l];
            low = isfinite(value) ? fmin(low, value) : low;
        }
    return low;
}

static sp_status draw(const spectrum_drawing *d, const style *as, const char *path, sp_error *err) {
    char x[UNIT_MARKUP + 16], y[UNIT_MARKUP + 64];
    const char *omega;
    sp_status status = sp_unit_common(d->tables, d->table, "omega", UNIT_FREQUENCY, &omega, err);
    if (status == SP_OK)
        status = label_y(d, as, y, sizeof y, err);
    if (status != SP_OK)
        return status;
    const sp_panel panel = {
        .x = {.label = sp_unit_label("|" OMEGA "|", omega, x, sizeof x),
              .low = lowest(d, true) < 0 ? NAN : 0,
              .high = NAN},
        .y = {.label = y, .log = as->log, .low = as->log || lowest(d, false) < 0 ? NAN : 0, .high = NAN},
        .curves = d->curves,
        .curve = d->curve};
    const sp_sheet sheet = {.title = as->title, .rows = 1, .columns = 1, .panel = &panel, .aspect = 0.72};
    return sp_plot_sheet(&sheet, path, err);
}

/* ---- the figure ------------------------------------------------------------------------------------------------- */

/* column: style of a column of a harmonic response; NULL for other tables */
static sp_status choose_style(int tables, const sp_plot_table *table, const style *column, const style **out,
                              sp_error *err) {
    for (int j = 0; j < tables; j++) {
        const style *own = NULL;
        const sp_status status = style_of(table[j].table, &own, err);
        if (status != SP_OK)
            return status;
        if (column && strcmp(own->kind, column->kind) != 0)
            return sp_fail(err, SP_EINVAL, "column %s of a table of %s: must be of `sonopack spectrum harmonic'",
                           column->y, own->kind);
        own = column ? column : own;
        if (j > 0 && own != *out)
            return sp_fail(err, SP_EINVAL, "tables of %s and of %s in one figure, must be of one kind", (*out)->kind,
                           own->kind);
        *out = own;
    }
    return SP_OK;
}

static sp_status plot_tables(int tables, const sp_plot_table *table, const style *column, const char *path,
                             sp_error *err) {
    const style *as = NULL;
    spectrum_drawing *d = NULL;
    sp_status status = sp_spectrum_begin(tables, table, 8, path, &d, err);
    if (status == SP_OK)
        status = choose_style(tables, table, column, &as, err);
    for (int j = 0; j < tables && status == SP_OK; j++)
        status = as->form == FORM_STEPS  ? add_histogram(d, j, err)
                 : as->form == FORM_BINS ? add_bins(d, j, err)
                                         : add_curve(d, as, j, err);
    if (status == SP_OK)
        status = sp_spectrum_check(d, "a frequency and a value", err);
    if (status == SP_OK && as->form == FORM_BINS)
        add_key(d);
    if (status == SP_OK)
        status = draw(d, as, path, err);
    sp_spectrum_end(d);
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
