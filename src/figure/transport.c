/* Draws diffusivity and mean free path against frequency. */
#include "figure/canvas.h"
#include "figure/markup.h"
#include "figure/settings.h"
#include "figure/unit.h"

#include "base/base.h"

#include <math.h>
#include <sonopack/figure/figure.h>
#include <sonopack/figure/plot.h>

enum { TABLES_MOST = 6, PANELS = 2 };

/* What a panel shows: a column, that of its error, and the axis. */
static const struct {
    const char *value, *error, *symbol, *unit;
} shown[PANELS] = {{"D", "D_err", "|D|", "d sqrt(E* / rho)"}, {"path", "path_err", "mean free path", UNIT_LENGTH}};

typedef struct drawing {
    sp_curve curve[PANELS][TABLES_MOST];
    char label[TABLES_MOST][SETTINGS_LABEL];
    int curves[PANELS];
} drawing;

/* A column of positive numbers; a value that a logarithmic axis cannot show makes a gap. False if there is none. */
static bool read_column(const sp_table *t, const char *name, bool positive, double *to) {
    const int at = sp_table_find_column(t, name);
    if (at < 0 || t->column[at].kind == SP_COLUMN_TEXT)
        return false;
    for (int64_t row = 0; row < t->rows; row++) {
        const double value = sp_table_number(t, row, at);
        to[row] = isfinite(value) && (!positive || value > 0) ? value : NAN;
    }
    return true;
}

static bool any_number(int64_t n, const double *x) {
    for (int64_t k = 0; k < n; k++)
        if (isfinite(x[k]))
            return true;
    return false;
}

/* Adds the curve of table j to a panel if it has the columns. */
static void add_curve(drawing *d, const sp_table *t, int panel, int j, const double *omega, double *memory) {
    static const sp_mark marks[] = {SP_MARK_CIRCLE, SP_MARK_SQUARE, SP_MARK_TRIANGLE, SP_MARK_DIAMOND};
    double *value = memory, *error = memory + t->rows;
    if (!read_column(t, shown[panel].value, true, value) || !read_column(t, shown[panel].error, false, error) ||
        !any_number(t->rows, value))
        return;
    d->curve[panel][d->curves[panel]++] = (sp_curve){.label = *d->label[j] ? d->label[j] : NULL,
                                                     .n = t->rows,
                                                     .x = omega,
                                                     .y = value,
                                                     .error = error,
                                                     .ink = j + 1,
                                                     .dash = SP_DASH_NONE,
                                                     .mark = marks[j % 4],
                                                     .open = j >= 4};
}

static sp_status read_tables(drawing *d, int tables, const sp_plot_table *table, double *memory, sp_error *err) {
    for (int j = 0; j < tables; j++) {
        const sp_table *t = table[j].table;
        double *omega = memory;
        if (tables > 1 || table[j].named)
            sp_settings_label(tables, table, j, 30, d->label[j]);
        if (!read_column(t, "omega", true, omega))
            return sp_fail(err, SP_EINVAL,
                           "the table has no column omega of numbers; one of `sonopack transport' has omega and D or "
                           "path");
        for (int panel = 0; panel < PANELS; panel++)
            add_curve(d, t, panel, j, omega, memory + (1 + 2 * panel) * t->rows);
        memory += (1 + 2 * PANELS) * t->rows;
    }
    return d->curves[0] + d->curves[1] > 0
               ? SP_OK
               : sp_fail(err, SP_EREFUSED, "nothing to draw: no table has a D or a path with its error");
}

/* The same range of frequencies for all panels. */
static void frequency_axis(const drawing *d, sp_axis *axis) {
    axis->low = INFINITY;
    for (int panel = 0; panel < PANELS; panel++)
        for (int c = 0; c < d->curves[panel]; c++)
            for (int64_t k = 0; k < d->curve[panel][c].n; k++) {
                axis->low = fmin(axis->low, 0.8 * d->curve[panel][c].x[k]);
                axis->high = fmax(axis->high, 1.25 * d->curve[panel][c].x[k]);
            }
}

/* The label of an axis, in the unit of the tables. */
static sp_status label_axis(int tables, const sp_plot_table *table, const char *column, const char *own,
                            const char *symbol, char label[UNIT_MARKUP + 40], sp_error *err) {
    const char *unit;
    const sp_status status = sp_unit_common(tables, table, column, own, &unit, err);
    if (status == SP_OK)
        sp_unit_label(symbol, unit, label, UNIT_MARKUP + 40);
    return status;
}

static sp_status draw(const drawing *d, int tables, const sp_plot_table *table, const char *path, sp_error *err) {
    static const char *const tags[] = {"(a)", "(b)"};
    char across[UNIT_MARKUP + 40], up[PANELS][UNIT_MARKUP + 40];
    sp_panel panel[PANELS];
    int panels = 0;
    sp_status status = label_axis(tables, table, "omega", UNIT_FREQUENCY, "|\xcf\x89|", across, err);
    sp_axis omega = {.label = across, .log = true};
    frequency_axis(d, &omega);
    for (int q = 0; q < PANELS && status == SP_OK; q++) {
        if (d->curves[q] == 0)
            continue;
        status = label_axis(tables, table, shown[q].value, shown[q].unit, shown[q].symbol, up[q], err);
        panel[panels] =
            (sp_panel){.x = omega, .y = {.label = up[q], .log = true}, .curves = d->curves[q], .curve = d->curve[q]};
        panels++;
    }
    for (int q = 0; q < panels && panels > 1; q++)
        panel[q].tag = tags[q];
    const sp_sheet sheet = {
        .title = "Transport of energy", .rows = panels, .columns = 1, .panel = panel, .aspect = 0.62};
    return status == SP_OK ? sp_plot_sheet(&sheet, path, err) : status;
}

sp_status sp_plot_transport(int tables, const sp_plot_table *table, const char *path, sp_error *err) {
    drawing d = {0};
    size_t rows = 0;
    sp_status status = sp_canvas_check(path, err);
    if (status == SP_OK && (tables < 1 || tables > TABLES_MOST))
        status = sp_fail(err, SP_EINVAL, "%d tables: a figure shows 1 to %d", tables, TABLES_MOST);
    for (int j = 0; j < tables && status == SP_OK; j++)
        rows += (size_t)table[j].table->rows;
    if (status == SP_OK && rows == 0)
        status = sp_fail(err, SP_EREFUSED, "nothing to draw: the table has no row");
    if (status != SP_OK)
        return status;
    double *memory = sp_alloc((1 + 2 * PANELS) * rows, sizeof *memory);
    if (!memory)
        return sp_fail_memory(err, (1 + 2 * PANELS) * rows * sizeof *memory);
    status = read_tables(&d, tables, table, memory, err);
    if (status == SP_OK)
        status = draw(&d, tables, table, path, err);
    sp_free(memory);
    return status;
}
