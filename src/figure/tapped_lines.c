/* Line figures of the tapped column: states after each tap, differences between models, and energies. */
#include "figure/tapped_table.h"

#include "base/base.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { LINES_MOST = 40, NAMED_MOST = 6, MARKED_MOST = 60, LABEL_ROOM = 100 };

static sp_mark mark_of(int64_t points, sp_mark mark) { return points <= MARKED_MOST ? mark : SP_MARK_NONE; }

static sp_status draw_sheet(const char *title, int panels, const sp_panel *panel, const char *path, sp_error *err) {
    const tapped_sheet sheet = {.title = title,
                                .panels = panels,
                                .panel = panel,
                                .aspect = panels == 1   ? 0.75
                                          : panels == 2 ? 0.62
                                                        : 0.5,
                                .whole = true};
    return sp_tapped_draw_sheet(&sheet, path, err);
}

/* Axis of taps, the same for all panels so that they line up. Points at whole taps stay clear of the frame. */
static sp_axis taps_axis(int64_t rows, const double *tap, const char *label) {
    double low = INFINITY, high = -INFINITY;
    for (int64_t k = 0; k < rows; k++) {
        low = fmin(low, tap[k]);
        high = fmax(high, tap[k]);
    }
    const double margin = fmax(0.04 * (high - low), fmin(0.5, 0.08 * (high - low)));
    return (sp_axis){
        .label = label, .low = low - (margin > 0 ? margin : 0.5), .high = high + (margin > 0 ? margin : 0.5)};
}

/* ---- after each tap --------------------------------------------------------------------------------------------- */

/* Subtracts the first finite value. */
static void relative(int64_t n, double *y) {
    int64_t first = 0;
    while (first < n && !isfinite(y[first]))
        first++;
    const double from = first < n ? y[first] : NAN;
    for (int64_t k = 0; k < n; k++)
        y[k] -= from;
}

static void strobe_curves(const tapped_table *s, const double *tap, int shown, double *memory, sp_curve *curve,
                          char (*label)[LABEL_ROOM]) {
    static const sp_mark marks[] = {SP_MARK_CIRCLE, SP_MARK_SQUARE, SP_MARK_TRIANGLE, SP_MARK_DIAMOND};
    const int64_t rows = s->table->rows;
    const int stride = (s->particles + LINES_MOST - 1) / LINES_MOST;
    for (int k = 0; k < shown; k++) {
        const int particle = s->particles - (shown - 1 - k) * stride;
        double *y = memory + k * rows;
        sp_tapped_table_values(s, s->first + particle - 1, y);
        relative(rows, y);
        const bool few = s->particles <= NAMED_MOST, end = k == 0 || k == shown - 1;
        curve[k] = (sp_curve){.n = rows, .x = tap, .y = y, .ink = few ? 1 + k : -1, .width = few ? 0.8 : 0.5};
        curve[k].mark = few ? mark_of(rows, marks[k % 4]) : SP_MARK_NONE;
        curve[k].open = k >= 4;
        if (!few && end) {
            curve[k].ink = k == 0 ? 1 : 2;
            curve[k].width = 1;
        }
        if (few || end) {
            snprintf(label[k], LABEL_ROOM, "|y|_{%d}", particle);
            curve[k].label = label[k];
        } else if (k == shown / 2) {
            curve[k].label = "those between";
        }
    }
}

static sp_status draw_strobe(const tapped_table *s, double *memory, const char *path, sp_error *err) {
    const int64_t rows = s->table->rows;
    const int stride = (s->particles + LINES_MOST - 1) / LINES_MOST, shown = (s->particles + stride - 1) / stride;
    double *tap = memory, *density = memory + rows;
    sp_curve curve[LINES_MOST], above;
    char label[LINES_MOST][LABEL_ROOM], x[TAPPED_LABEL], upper[TAPPED_LABEL], lower[TAPPED_LABEL], name[TAPPED_LABEL];
    sp_status status = sp_tapped_table_abscissa(s, tap, err);
    if (status != SP_OK)
        return status;
    sp_tapped_table_values(s, sp_tapped_table_column(s, "density"), density);
    above = (sp_curve){.n = rows, .x = tap, .y = density, .ink = 1, .mark = mark_of(rows, SP_MARK_CIRCLE)};
    strobe_curves(s, tap, shown, memory + 2 * rows, curve, label);
    snprintf(name, sizeof name, "|y| \xe2\x88\x92 |y|(tap %.0f)", tap[0]);
    const sp_axis abscissa = taps_axis(rows, tap, sp_tapped_axis_label(s, "tap", s->abscissa, x));
    const sp_panel panel[2] = {
        {.tag = "(a)",
         .x = abscissa,
         .y = {.label = sp_tapped_axis_label(s, "density", sp_tapped_table_column(s, "density"), upper)},
         .curves = 1,
         .curve = &above},
        {.tag = "(b)",
         .x = abscissa,
         .y = {.label = sp_tapped_axis_label(s, name, s->first, lower)},
         .curves = shown,
         .curve = curve,
         .tight = shown > 2,
         .zero_line = true}};
    return draw_sheet("A column after its taps", 2, panel, path, err);
}

sp_status sp_tapped_draw_strobe(const tapped_table *s, const char *path, sp_error *err) {
    return sp_tapped_draw_with_memory(draw_strobe, (size_t)s->table->rows * (2 + LINES_MOST), s, path, err);
}

/* ---- differences of models -------------------------------------------------------------------------------------- */

enum { DIFFERENCES = 4 };

/* Whether one scale cannot show all curves, because their maxima differ too much. */
static bool far_apart(int curves, const sp_curve *curve) {
    double least = INFINITY, most = 0;
    for (int j = 0; j < curves; j++) {
        double high = 0;
        for (int64_t k = 0; k < curve[j].n; k++)
            high = fmax(high, curve[j].y[k]);
        least = high > 0 ? fmin(least, high) : least;
        most = fmax(most, high);
    }
    return most > 30 * least;
}

/* Turns values that a logarithmic axis cannot show into gaps. Both models start from the lattice, where the difference
 * is zero. */
static void only_positive(int64_t n, double *y) {
    for (int64_t k = 0; k < n; k++)
        y[k] = y[k] > 0 ? y[k] : NAN;
}

static sp_status draw_compare(const tapped_table *s, double *memory, const char *path, sp_error *err) {
    static const struct {
        const char *name, *label;
    } known[DIFFERENCES] = {{"mean_longwave", "long wave, mean"},
                            {"max_longwave", "long wave, largest"},
                            {"mean_bsr", "BSR, mean"},
                            {"max_bsr", "BSR, largest"}};
    const int64_t rows = s->table->rows;
    sp_curve curve[DIFFERENCES];
    char x[TAPPED_LABEL], y[TAPPED_LABEL];
    int curves = 0, column = -1;
    sp_status status = sp_tapped_table_abscissa(s, memory, err);
    if (status != SP_OK)
        return status;
    for (int k = 0; k < DIFFERENCES; k++) {
        const int at = sp_tapped_table_column(s, known[k].name);
        double *to = memory + (curves + 1) * rows;
        if (at < 0 || !sp_tapped_any_finite(rows, sp_tapped_table_values(s, at, to)))
            continue;
        column = column < 0 ? at : column;
        curve[curves++] = (sp_curve){.label = known[k].label,
                                     .n = rows,
                                     .x = memory,
                                     .y = to,
                                     .ink = 1 + k / 2,
                                     .dash = k % 2 ? SP_DASH_DASHED : SP_DASH_SOLID,
                                     .width = k % 2 ? 0.7 : 1};
    }
    if (curves == 0)
        return sp_fail(err, SP_EREFUSED, "nothing to draw: no difference is finite");
    const bool log = far_apart(curves, curve);
    for (int j = 0; log && j < curves; j++)
        only_positive(rows, memory + (j + 1) * rows);
    const sp_panel panel = {
        .x = {.label = sp_tapped_axis_label(s, "|t|", s->abscissa, x), .low = memory[0], .high = memory[rows - 1]},
        .y = {.label = sp_tapped_axis_label(s, "difference from the lattice", column, y), .log = log},
        .curves = curves,
        .curve = curve};
    const sp_sheet sheet = {.title = "Continua and the lattice", .rows = 1, .columns = 1, .panel = &panel};
    return sp_plot_sheet(&sheet, path, err);
}

sp_status sp_tapped_draw_compare(const tapped_table *s, const char *path, sp_error *err) {
    return sp_tapped_draw_with_memory(draw_compare, (size_t)s->table->rows * (1 + DIFFERENCES), s, path, err);
}

/* ---- energies --------------------------------------------------------------------------------------------------- */

enum { E_TAP = 0, E_WORK, E_DISSIPATED, E_KEPT, E_REST, E_SEPARATION, ENERGIES };

/* Limits from below zero to well above the values, which leaves space for the panel's tag. */
static void with_headroom(sp_axis *a, int64_t rows, const double *value) {
    double low = 0, high = 0;
    for (int64_t k = 0; k < rows; k++) {
        low = fmin(low, value[k]); /* NAN is ignored */
        high = fmax(high, value[k]);
    }
    const double range = high > low ? high - low : 1;
    a->low = low - 0.06 * range;
    a->high = high + 0.28 * range;
}

/* Reads the columns. The column keeps so little of the work that work and dissipation look equal on one scale, so their
 * difference is drawn, too. */
static void read_energies(const tapped_table *s, double *memory, sp_curve curve[ENERGIES], int column[ENERGIES]) {
    static const char *const names[ENERGIES] = {"tap", "work", "dissipated", "work", "rest", "separation"};
    const int64_t rows = s->table->rows;
    for (int q = 0; q < ENERGIES; q++) {
        column[q] = sp_tapped_table_column(s, names[q]);
        double *to = memory + q * rows;
        if (column[q] >= 0)
            sp_tapped_table_values(s, column[q], to);
        for (int64_t k = 0; k < rows && (q == E_KEPT || column[q] < 0); k++)
            to[k] = column[q] < 0 ? NAN : to[k] - memory[E_DISSIPATED * rows + k];
        curve[q] = (sp_curve){.n = rows, .x = memory, .y = to, .ink = 1, .width = 0.8};
        curve[q].mark = mark_of(rows, SP_MARK_CIRCLE);
    }
    curve[E_WORK].label = "work of the floor";
    curve[E_DISSIPATED].label = "dissipated";
    curve[E_DISSIPATED].ink = 2;
    curve[E_DISSIPATED].mark = mark_of(rows, SP_MARK_SQUARE);
    curve[E_DISSIPATED].open = true;
    curve[E_DISSIPATED].width = 2.6; /* visible on both sides of the other curve */
}

static sp_status draw_energy(const tapped_table *s, double *memory, const char *path, sp_error *err) {
    static const char *const tags[] = {"(a)", "(b)", "(c)", "(d)"};
    static const char *const labels[ENERGIES] = {[E_KEPT] = "work \xe2\x88\x92 dissipated",
                                                 [E_REST] = "at rest after",
                                                 [E_SEPARATION] = "least |y|_{|i|+1} \xe2\x88\x92 |y|_{|i|}"};
    const int64_t rows = s->table->rows;
    sp_curve curve[ENERGIES];
    int column[ENERGIES], panels = 1;
    char x[TAPPED_LABEL], y[ENERGIES][TAPPED_LABEL];
    read_energies(s, memory, curve, column);
    if (!sp_tapped_any_finite(rows, memory) ||
        !(sp_tapped_any_finite(rows, curve[E_WORK].y) || sp_tapped_any_finite(rows, curve[E_DISSIPATED].y)))
        return sp_fail(err, SP_EREFUSED, "nothing to draw: no energy is finite");
    const sp_axis abscissa = taps_axis(rows, memory, sp_tapped_axis_label(s, "tap", s->abscissa, x));
    const sp_curve both[2] = {curve[E_DISSIPATED], curve[E_WORK]};
    sp_panel panel[4] = {{.x = abscissa, .curves = 2, .curve = both}};
    panel[0].y.label = sp_tapped_axis_label(s, "energy", column[E_WORK], y[0]);
    for (int q = E_KEPT; q < ENERGIES; q++) {
        if (!sp_tapped_any_finite(rows, curve[q].y))
            continue;
        panel[panels] = (sp_panel){.x = abscissa, .curves = 1, .curve = &curve[q], .zero_line = true};
        panel[panels].y.label = sp_tapped_axis_label(s, labels[q], column[q], y[q]);
        with_headroom(&panel[panels].y, rows, curve[q].y);
        panels++;
    }
    for (int k = 0; k < panels && panels > 1; k++)
        panel[k].tag = tags[k];
    return draw_sheet("Energies of the taps", panels, panel, path, err);
}

sp_status sp_tapped_draw_energy(const tapped_table *s, const char *path, sp_error *err) {
    return sp_tapped_draw_with_memory(draw_energy, (size_t)s->table->rows * ENERGIES, s, path, err);
}
