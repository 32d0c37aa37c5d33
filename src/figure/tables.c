/* Draws the mean signal of an ensemble, modes, and signals at several distances. */
#include "figure/canvas.h"
#include "figure/columns.h"
#include "figure/settings.h"

#include "base/base.h"

#include <math.h>
#include <sonopack/figure/figure.h>
#include <sonopack/figure/plot.h>
#include <stdio.h>
#include <string.h>

enum { ENSEMBLES_MOST = 6, RECORDS_MOST = 200, LABEL_MOST = 20 };

#define TIME_AXIS  "|t|  [|d| (|\xcf\x81|/|E|*)^{1/2}]"
#define FORCE_AXIS "|F|_{sig}  [|E|* |d|^{2}]"

/* Copies a column. Infinite values become NAN. */
static const double *column_of(const sp_table *t, int column, double *to) {
    for (int64_t k = 0; k < t->rows; k++) {
        const double value = sp_table_number(t, k, column);
        to[k] = isfinite(value) ? value : NAN;
    }
    return to;
}

/* ---- ensembles -------------------------------------------------------------------------------------------------- */

enum { E_TIME = 0, E_MEAN, E_RMS, E_LOW, E_HIGH, ENSEMBLE_COLUMNS };
static const char *const ensemble_columns[ENSEMBLE_COLUMNS] = {"t", "mean", "rms", "low", "high"};

/* Reads times, mean and rms deviation. low and high are NULL if the table does not have them. */
static sp_status read_ensemble(const sp_table *t, double **memory, const double *column[ENSEMBLE_COLUMNS],
                               sp_error *err) {
    for (int q = 0; q < ENSEMBLE_COLUMNS; q++) {
        int at = sp_table_find_column(t, ensemble_columns[q]);
        column[q] = NULL;
        if (q >= E_LOW && (at < 0 || t->column[at].kind == SP_CELL_TEXT))
            continue;
        sp_status status =
            sp_column_find(t, ensemble_columns[q], "a table of an ensemble has t, mean and rms", &at, err);
        if (status != SP_OK)
            return status;
        column[q] = column_of(t, at, *memory);
        *memory += t->rows;
    }
    return SP_OK;
}

/* Curves of table j: mean with its band, and rms deviation. */
static sp_status add_ensemble(int tables, const sp_plot_table *table, int j, double **memory, sp_curve *curve,
                              sp_error *err) {
    const double *column[ENSEMBLE_COLUMNS];
    const sp_status status = read_ensemble(table[j].table, memory, column, err);
    if (status != SP_OK)
        return status;
    for (int q = 0; q < 2; q++)
        curve[q] = (sp_curve){.n = table[j].table->rows,
                              .x = column[0],
                              .y = column[1 + q],
                              .ink = tables == 1 ? q + 1 : j + 1,
                              .dash = q == 0 ? SP_DASH_SOLID : SP_DASH_DASHED};
    if (column[E_LOW] && column[E_HIGH]) {
        curve[0].lower = column[E_LOW];
        curve[0].upper = column[E_HIGH];
    }
    return SP_OK;
}

/* "mean, 95% interval" if all bands have the same level. */
static void name_mean(int tables, const sp_plot_table *table, const sp_curve *curve, char *out, size_t size) {
    char interval[64] = "", other[64];
    for (int j = 0; j < tables; j++) {
        if (!curve[2 * j].lower)
            continue;
        sp_settings_interval(table[j].table, other, sizeof other);
        if (*interval && strcmp(interval, other) != 0)
            snprintf(other, sizeof other, "interval");
        snprintf(interval, sizeof interval, "%s", other);
    }
    snprintf(out, size, "mean%s%s", *interval ? ", " : "", interval);
}

static sp_status draw_ensemble(int tables, const sp_plot_table *table, double *memory, const char *path,
                               sp_error *err) {
    static const double nowhere[1] = {NAN};
    sp_curve curve[2 * ENSEMBLES_MOST + 2];
    char label[ENSEMBLES_MOST][SETTINGS_LABEL], mean[80];
    int curves = 2 * tables;
    for (int j = 0; j < tables; j++) {
        const sp_status status = add_ensemble(tables, table, j, &memory, &curve[2 * j], err);
        if (status != SP_OK)
            return status;
    }
    name_mean(tables, table, curve, mean, sizeof mean);
    if (tables == 1) {
        curve[0].label = mean;
        curve[1].label = "rms deviation";
    } else { /* colours distinguish tables, dashes distinguish quantities */
        for (int j = 0; j < tables; j++) {
            sp_settings_label(tables, table, j, LABEL_MOST, label[j]);
            curve[2 * j].label = label[j];
        }
        curve[curves++] = (sp_curve){.label = mean};
        curve[curves++] = (sp_curve){.label = "rms deviation", .dash = SP_DASH_DASHED};
        if (strcmp(mean, "mean") != 0)
            curve[curves - 2].lower = curve[curves - 2].upper = nowhere;
    }
    const sp_panel panel = {.x = {.label = TIME_AXIS},
                            .y = {.label = FORCE_AXIS},
                            .curves = curves,
                            .curve = curve,
                            .zero_line = true,
                            .tight = tables > 1};
    /* space for a legend above the frame */
    const double aspect = tables == 1 ? 0.66 : 0.67 + 0.045 * tables;
    const sp_sheet sheet = {
        .title = "Signal of an ensemble", .rows = 1, .columns = 1, .panel = &panel, .aspect = aspect};
    return sp_plot_sheet(&sheet, path, err);
}

sp_status sp_plot_ensemble(int tables, const sp_plot_table *table, const char *path, sp_error *err) {
    sp_status status = sp_canvas_check(path, err);
    if (status == SP_OK && (tables < 1 || tables > ENSEMBLES_MOST))
        status = sp_fail(err, SP_EINVAL, "%d tables: a figure shows 1 to %d", tables, ENSEMBLES_MOST);
    if (status != SP_OK)
        return status;
    size_t rows = 0;
    for (int j = 0; j < tables; j++)
        rows += (size_t)table[j].table->rows;
    double *memory = sp_alloc(ENSEMBLE_COLUMNS * rows, sizeof *memory);
    if (!memory)
        return sp_fail_memory(err, ENSEMBLE_COLUMNS * rows * sizeof *memory);
    status = draw_ensemble(tables, table, memory, path, err);
    sp_free(memory);
    return status;
}

/* ---- modes ------------------------------------------------------------------------------------------------------ */

/* Number of modes in the inset. */
enum { FIRST_MODES = 25 };
/* Zero modes: omega^2 relative to the largest is below this. */
#define ZERO_MODE 1e-12

static void largest_and_first(int64_t n, const double *squares, int64_t *first, int64_t *end) {
    double largest = 0;
    for (int64_t k = 0; k < n; k++)
        largest = fmax(largest, squares[k]);
    *first = 0;
    while (*first < n && !(squares[*first] > ZERO_MODE * largest))
        ++*first;
    *end = *first + FIRST_MODES < n ? *first + FIRST_MODES : n;
}

/* NULL if no value is finite: of a packing that does not touch its walls. */
static const double *if_any(int64_t n, const double *x) {
    for (int64_t k = 0; k < n; k++)
        if (isfinite(x[k]))
            return x;
    return NULL;
}

static sp_status draw_modes(const sp_table *modes, const int column[3], double *memory, const char *path,
                            sp_error *err) {
    const int64_t rows = modes->rows;
    const double *n = column_of(modes, column[0], memory);
    const double *ab = column[2] < 0 ? NULL : if_any(rows, column_of(modes, column[2], memory + 2 * rows));
    double *squares = memory + rows;
    int64_t first = 0, end = 0;
    column_of(modes, column[1], squares);
    for (int64_t k = 0; k < rows; k++)
        squares[k] *= squares[k];
    largest_and_first(rows, squares, &first, &end);
    const int64_t from = first > 3 ? first - 3 : 0; /* including the last zero modes */
    const sp_curve all = {.n = rows, .x = n, .y = squares, .ink = 1, .width = 1.2};
    const sp_curve low = {.n = end - from,
                          .x = n + from,
                          .y = squares + from,
                          .ink = 1,
                          .dash = SP_DASH_NONE,
                          .mark = SP_MARK_CIRCLE,
                          .open = true};
    const sp_curve coupling = {.n = rows, .x = n, .y = ab, .width = 0.5};
    const sp_panel inset = {
        .x = {.label = "|n|"}, .y = {.label = "|\xcf\x89|_{|n|}^{2}"}, .curves = 1, .curve = &low, .zero_line = true};
    const sp_panel panel[2] = {{.tag = ab ? "(a)" : NULL,
                                .x = {.label = "|n|"},
                                .y = {.label = "|\xcf\x89|_{|n|}^{2}  [|E|*/(|\xcf\x81 d|^{2})]"},
                                .curves = 1,
                                .curve = &all,
                                .inset = end - first > 1 && end < rows ? &inset : NULL},
                               {.tag = "(b)",
                                .x = {.label = "|n|"},
                                .y = {.label = "|a|_{|n|} |b|_{|n|}  [|E|* |d|^{2}]"},
                                .curves = 1,
                                .curve = &coupling,
                                .zero_line = true}};
    const sp_sheet sheet = {
        .title = "Modes of a packing", .rows = ab ? 2 : 1, .columns = 1, .panel = panel, .aspect = 0.66};
    return sp_plot_sheet(&sheet, path, err);
}

sp_status sp_plot_modes(const sp_table *modes, const char *path, sp_error *err) {
    static const char what[] = "a table of modes has n, omega, a, b, ab";
    int column[3] = {0};
    sp_status status = sp_canvas_check(path, err);
    if (status == SP_OK)
        status = sp_column_find(modes, "n", what, &column[0], err);
    if (status == SP_OK)
        status = sp_column_find(modes, "omega", what, &column[1], err);
    column[2] = sp_table_find_column(modes, "ab");
    if (status == SP_OK && column[2] >= 0)
        status = sp_column_find(modes, "ab", what, &column[2], err);
    if (status == SP_OK && modes->rows == 0)
        status = sp_fail(err, SP_EREFUSED, "nothing to draw: the table of modes has no row");
    if (status != SP_OK)
        return status;
    double *memory = sp_alloc(3 * (size_t)modes->rows, sizeof *memory);
    if (!memory)
        return sp_fail_memory(err, 3 * (size_t)modes->rows * sizeof *memory);
    status = draw_modes(modes, column, memory, path, err);
    sp_free(memory);
    return status;
}

/* ---- sections --------------------------------------------------------------------------------------------------- */

typedef struct section {
    int records;
    const sp_plot_record *record;
    bool numbered; /* the distances are unknown */
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
static void lift(const section *s, int k, double scale, double *y) {
    const sp_plot_record *r = &s->record[k];
    double largest = 0;
    for (int64_t l = 0; l < r->n; l++)
        largest = isfinite(r->f[l]) ? fmax(largest, fabs(r->f[l])) : largest;
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

sp_status sp_plot_section(int records, const sp_plot_record *record, const char *path, sp_error *err) {
    section s = {.records = records, .record = record};
    size_t points = 0;
    sp_status status = sp_canvas_check(path, err);
    if (status == SP_OK)
        status = check_section(&s, &points, err);
    if (status != SP_OK)
        return status;
    double *y = sp_alloc(points, sizeof *y);
    sp_curve *curve = sp_alloc((size_t)records, sizeof *curve);
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
    const sp_panel panel = {.x = {.label = TIME_AXIS},
                            .y = {.label = s.numbered ? "number" : "distance  [|d|]"},
                            .curves = records,
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
