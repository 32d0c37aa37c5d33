/* Draws the mean signal of an ensemble. */
#include "figure/canvas.h"
#include "figure/columns.h"
#include "figure/settings.h"
#include "figure/unit.h"

#include "base/base.h"

#include <math.h>
#include <sonopack/figure/figure.h>
#include <sonopack/figure/plot.h>
#include <stdio.h>
#include <string.h>

enum { ENSEMBLES_MOST = 6, LABEL_MOST = 20 };

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
        if (q >= E_LOW && (at < 0 || t->column[at].kind == SP_COLUMN_TEXT))
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
    if (tables == 1 && !table[0].named) {
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
    const char *time, *force;
    char x[UNIT_MARKUP + 16], y[UNIT_MARKUP + 16];
    sp_status status = sp_unit_common(tables, table, "t", UNIT_TIME, &time, err);
    if (status == SP_OK)
        status = sp_unit_common(tables, table, "mean", UNIT_FORCE, &force, err);
    if (status != SP_OK)
        return status;
    const sp_panel panel = {.x = {.label = sp_unit_label("|t|", time, x, sizeof x)},
                            .y = {.label = sp_unit_label("|F|_{sig}", force, y, sizeof y)},
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
