/* Draws squared frequencies and weights of modes. */
#include "figure/canvas.h"
#include "figure/columns.h"
#include "figure/settings.h"
#include "figure/unit.h"

#include "base/base.h"

#include <math.h>
#include <sonopack/figure/figure.h>
#include <sonopack/figure/plot.h>
#include <stdio.h>

enum {
    TABLES_MOST = 6,
    LABEL_MOST = 24,
    FEW = 60,         /* so many rows have marks instead of a line */
    FIRST_MODES = 25, /* number of modes in the inset */
    EACH = 5          /* columns of numbers that a figure needs */
};
/* Zero modes: omega^2 relative to the largest is below this. */
#define ZERO_MODE 1e-12

/* One table. */
typedef struct spectrum {
    int64_t rows;
    double *n, *square, *ab, *low, *high; /* [rows] low, high: ends of the bars of ab */
    bool weighted;                        /* any ab is finite: not so of a packing that does not touch its walls */
    int64_t first, end;                   /* rows of the inset */
    char label[SETTINGS_LABEL];
} spectrum;

typedef struct drawing {
    int tables;
    const sp_plot_table *table;
    spectrum of[TABLES_MOST];
    sp_curve squares[TABLES_MOST], weights[TABLES_MOST];
    bool weighted;
} drawing;

static void copy(const sp_table *t, int column, double *to) {
    for (int64_t k = 0; k < t->rows; k++) {
        const double value = column < 0 ? NAN : sp_table_number(t, k, column);
        to[k] = isfinite(value) ? value : NAN;
    }
}

static void find_inset(spectrum *s) {
    double largest = 0;
    for (int64_t k = 0; k < s->rows; k++)
        largest = fmax(largest, s->square[k]);
    while (s->first < s->rows && !(s->square[s->first] > ZERO_MODE * largest))
        s->first++;
    s->end = s->first + FIRST_MODES < s->rows ? s->first + FIRST_MODES : s->rows;
}

static sp_status read_table(const sp_table *t, double *memory, spectrum *s, sp_error *err) {
    static const char what[] = "a table of modes has n, omega, a, b, ab";
    int n, omega, ab = sp_table_find_column(t, "ab");
    sp_status status = sp_column_find(t, "n", what, &n, err);
    if (status == SP_OK)
        status = sp_column_find(t, "omega", what, &omega, err);
    if (status == SP_OK && ab >= 0)
        status = sp_column_find(t, "ab", what, &ab, err);
    if (status == SP_OK && t->rows == 0)
        status = sp_fail(err, SP_EREFUSED, "nothing to draw: the table of modes has no row");
    if (status != SP_OK)
        return status;
    *s = (spectrum){.rows = t->rows, .n = memory, .square = memory + t->rows, .ab = memory + 2 * t->rows};
    s->low = s->ab + t->rows;
    s->high = s->low + t->rows;
    copy(t, n, s->n);
    copy(t, omega, s->square);
    copy(t, ab, s->ab);
    for (int64_t k = 0; k < s->rows; k++) {
        s->square[k] *= s->square[k];
        s->low[k] = isnan(s->ab[k]) ? NAN : fmin(0, s->ab[k]);
        s->high[k] = isnan(s->ab[k]) ? NAN : fmax(0, s->ab[k]);
        s->weighted = s->weighted || isfinite(s->ab[k]);
    }
    find_inset(s);
    return SP_OK;
}

static void add_curves(drawing *d, int j) {
    static const sp_mark marks[] = {SP_MARK_CIRCLE, SP_MARK_SQUARE, SP_MARK_TRIANGLE, SP_MARK_DIAMOND};
    spectrum *s = &d->of[j];
    const bool few = s->rows <= FEW;
    if (d->tables > 1 || d->table[j].named)
        sp_settings_label(d->tables, d->table, j, LABEL_MOST, s->label);
    d->squares[j] = (sp_curve){.label = s->label[0] ? s->label : NULL,
                               .n = s->rows,
                               .x = s->n,
                               .y = s->square,
                               .ink = j + 1,
                               .dash = few ? SP_DASH_NONE : (sp_dash)(j % 4),
                               .mark = few ? marks[j % 4] : SP_MARK_NONE,
                               .width = 1.2};
    d->weights[j] = d->squares[j];
    d->weights[j].label = NULL;
    d->weights[j].y = s->ab;
    d->weights[j].width = 0.5;
    d->weights[j].ink = d->tables == 1 ? 0 : j + 1;
    if (few) {
        d->weights[j].bar_low = s->low;
        d->weights[j].bar_high = s->high;
    }
    d->weighted = d->weighted || s->weighted;
}

static sp_status draw(drawing *d, const char *path, sp_error *err) {
    char square[UNIT_MARKUP], upper[UNIT_MARKUP + 40], lower[UNIT_MARKUP + 40];
    const char *omega, *ab;
    const spectrum *one = &d->of[0];
    sp_status status = sp_unit_common(d->tables, d->table, "omega", UNIT_FREQUENCY, &omega, err);
    if (status == SP_OK)
        status = sp_unit_common(d->tables, d->table, "ab", UNIT_FORCE, &ab, err);
    if (status != SP_OK)
        return status;
    sp_unit_square(omega, square);
    snprintf(upper, sizeof upper, "|\xcf\x89|_{|n|}^{2}  [%s]", square);
    sp_unit_label("|a|_{|n|} |b|_{|n|}", ab, lower, sizeof lower);
    const int64_t from = one->first > 3 ? one->first - 3 : 0; /* including the last zero modes */
    const sp_curve low = {.n = one->end - from,
                          .x = one->n + from,
                          .y = one->square + from,
                          .ink = 1,
                          .dash = SP_DASH_NONE,
                          .mark = SP_MARK_CIRCLE,
                          .open = true};
    /* the unit is that of the panel: beside it the label would be longer than the inset is high */
    const sp_panel inset = {
        .x = {.label = "|n|"}, .y = {.label = "|\xcf\x89|_{|n|}^{2}"}, .curves = 1, .curve = &low, .zero_line = true};
    const bool closer = d->tables == 1 && one->rows > FEW && one->end - one->first > 1 && one->end < one->rows;
    const sp_panel panel[2] = {{.tag = d->weighted ? "(a)" : NULL,
                                .x = {.label = "|n|"},
                                .y = {.label = upper},
                                .curves = d->tables,
                                .curve = d->squares,
                                .inset = closer ? &inset : NULL},
                               {.tag = "(b)",
                                .x = {.label = "|n|"},
                                .y = {.label = lower},
                                .curves = d->tables,
                                .curve = d->weights,
                                .zero_line = true}};
    const sp_sheet sheet = {
        .title = "Modes of a packing", .rows = d->weighted ? 2 : 1, .columns = 1, .panel = panel, .aspect = 0.66};
    return sp_plot_sheet(&sheet, path, err);
}

sp_status sp_plot_modes_tables(int tables, const sp_plot_table *table, const char *path, sp_error *err) {
    size_t rows = 0;
    sp_status status = sp_canvas_check(path, err);
    if (status == SP_OK && (tables < 1 || tables > TABLES_MOST))
        status = sp_fail(err, SP_EINVAL, "%d tables: a figure shows 1 to %d", tables, TABLES_MOST);
    for (int j = 0; j < tables && status == SP_OK; j++)
        rows += (size_t)table[j].table->rows;
    if (status != SP_OK)
        return status;
    drawing d = {.tables = tables, .table = table};
    double *memory = sp_alloc(EACH * rows, sizeof *memory), *at = memory;
    if (!memory)
        return sp_fail_memory(err, EACH * rows * sizeof *memory);
    for (int j = 0; j < tables && status == SP_OK; j++) {
        status = read_table(table[j].table, at, &d.of[j], err);
        if (status != SP_OK && tables > 1)
            sp_fail_prefix(err, "table %d", j + 1);
        at += EACH * table[j].table->rows;
        if (status == SP_OK)
            add_curves(&d, j);
    }
    if (status == SP_OK)
        status = draw(&d, path, err);
    sp_free(memory);
    return status;
}

sp_status sp_plot_modes(const sp_table *modes, const char *path, sp_error *err) {
    const sp_plot_table one = {.table = modes};
    return sp_plot_modes_tables(1, &one, path, err);
}
