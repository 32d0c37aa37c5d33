/* Draws phase speed and attenuation of coherent waves against the wave number. */
#include "figure/canvas.h"
#include "figure/markup.h"
#include "figure/settings.h"
#include "figure/unit.h"

#include "base/base.h"

#include <math.h>
#include <sonopack/figure/figure.h>
#include <sonopack/figure/plot.h>
#include <stdio.h>

enum { LAW = 128 };
enum { WAVES_MOST = 6, W_K = 0, W_SPEED, W_SPEED_ERR, W_ALPHA, W_ALPHA_ERR, WAVE_COLUMNS };

static const char *const names[WAVE_COLUMNS] = {"k", "speed", "speed_err", "alpha", "alpha_err"};

/* Reads the columns of one table. A value makes a gap if a logarithmic axis cannot show it; so does an alpha smaller
 * than its error. */
static sp_status read_wave(const sp_table *t, double *memory, const double *column[WAVE_COLUMNS], sp_error *err) {
    for (int q = 0; q < WAVE_COLUMNS; q++) {
        const int at = sp_table_find_column(t, names[q]);
        if (at < 0 || t->column[at].kind == SP_COLUMN_TEXT)
            return sp_fail(
                err, SP_EINVAL,
                "the table has no column %s of numbers; one of `sonopack wave' has omega, k, speed and alpha",
                names[q]);
        double *to = memory + q * t->rows;
        column[q] = to;
        for (int64_t row = 0; row < t->rows; row++) {
            const double value = sp_table_number(t, row, at);
            const bool positive = q == W_K || q == W_ALPHA;
            to[row] = isfinite(value) && (!positive || value > 0) ? value : NAN;
        }
    }
    for (int64_t row = 0; row < t->rows; row++)
        if (memory[W_ALPHA * t->rows + row] < memory[W_ALPHA_ERR * t->rows + row])
            memory[W_ALPHA * t->rows + row] = NAN;
    return SP_OK;
}

/* Fits Rayleigh's law alpha = a k^(dim + 1) to long waves: points whose mean free path exceeds 10/k. Points are
 * weighted by their errors. False with fewer than three points. */
static bool rayleigh(int tables, const sp_plot_table *table, const double *const column[][WAVE_COLUMNS], double x[2],
                     double y[2]) {
    const int power = sp_settings_dimension(tables, table) + 1;
    double sum = 0, weight = 0;
    int points = 0;
    x[0] = INFINITY;
    x[1] = 0;
    for (int j = 0; j < tables; j++)
        for (int64_t r = 0; r < table[j].table->rows; r++) {
            const double k = column[j][W_K][r], alpha = column[j][W_ALPHA][r], error = column[j][W_ALPHA_ERR][r];
            if (!(k > 0) || !(alpha > 0) || alpha > 0.1 * k || alpha < 3 * error)
                continue;
            const double w = error > 0 ? pow(alpha / error, 2) : 1;
            sum += w * log(alpha / pow(k, power));
            weight += w;
            x[0] = fmin(x[0], k);
            x[1] = fmax(x[1], k);
            points++;
        }
    if (power < 2 || points < 3 || !(x[1] > x[0]))
        return false;
    x[0] *= 0.8;
    x[1] *= 2;
    for (int e = 0; e < 2; e++)
        y[e] = exp(sum / weight) * pow(x[e], power);
    return true;
}

/* The axes k, speed and attenuation, in the units of the tables. */
static sp_status label_axes(int tables, const sp_plot_table *table, char label[3][UNIT_MARKUP + 40], sp_error *err) {
    static const char *const column[] = {"k", "speed", "alpha"}, *const own[] = {UNIT_WAVE, UNIT_SPEED, UNIT_WAVE};
    static const char *const symbol[] = {"|k|", "|\xcf\x89|/|k|", "|\xce\xb1|"};
    for (int q = 0; q < 3; q++) {
        const char *unit;
        const sp_status status = sp_unit_common(tables, table, column[q], own[q], &unit, err);
        if (status != SP_OK)
            return status;
        sp_unit_label(symbol[q], unit, label[q], sizeof label[q]);
    }
    return SP_OK;
}

/* "0.12 d^2 k^3", or "~ k^3" where the unit of the number is not ours. */
static void name_law(double factor, int power, bool ours, char out[LAW]) {
    char number[48], lengths[24] = "|d|";
    sp_figure_text_number(number, sizeof number, factor, 2);
    if (power > 2)
        snprintf(lengths, sizeof lengths, "|d|^{%d}", power - 1);
    if (ours)
        snprintf(out, LAW, "%s %s |k|^{%d}", number, lengths, power);
    else
        snprintf(out, LAW, "~ |k|^{%d}", power);
}

static sp_status draw_wave(int tables, const sp_plot_table *table, double *memory, const char *path, sp_error *err) {
    static const sp_mark marks[] = {SP_MARK_CIRCLE, SP_MARK_SQUARE, SP_MARK_TRIANGLE, SP_MARK_DIAMOND};
    const double *column[WAVES_MOST][WAVE_COLUMNS];
    const char *unit;
    char label[WAVES_MOST][SETTINGS_LABEL], law[LAW], axis[3][UNIT_MARKUP + 40];
    sp_curve speed[WAVES_MOST], alpha[WAVES_MOST + 1];
    double x[2], y[2];
    int curves = tables;
    sp_status status = label_axes(tables, table, axis, err);
    if (status == SP_OK)
        status = sp_unit_common(tables, table, "k", UNIT_WAVE, &unit, err);
    if (status != SP_OK)
        return status;
    for (int j = 0; j < tables; j++) {
        const sp_table *t = table[j].table;
        status = read_wave(t, memory, column[j], err);
        if (status != SP_OK)
            return status;
        memory += WAVE_COLUMNS * t->rows;
        *label[j] = '\0';
        if (tables > 1 || table[j].named)
            sp_settings_label(tables, table, j, 30, label[j]);
        speed[j] = (sp_curve){.label = *label[j] ? label[j] : NULL,
                              .n = t->rows,
                              .x = column[j][W_K],
                              .y = column[j][W_SPEED],
                              .error = column[j][W_SPEED_ERR],
                              .ink = j + 1,
                              .dash = SP_DASH_NONE,
                              .mark = marks[j % 4],
                              .open = j >= 4};
        alpha[j] = speed[j];
        alpha[j].label = NULL;
        alpha[j].y = column[j][W_ALPHA];
        alpha[j].error = column[j][W_ALPHA_ERR];
    }
    if (rayleigh(tables, table, (const double *const(*)[WAVE_COLUMNS])column, x, y)) {
        const int power = sp_settings_dimension(tables, table) + 1;
        name_law(y[0] / pow(x[0], power), power, sp_unit_same(unit, UNIT_WAVE), law);
        alpha[curves++] = (sp_curve){.label = law, .n = 2, .x = x, .y = y, .dash = SP_DASH_DASHED, .width = 0.8};
    }
    sp_axis k = {.label = axis[0], .log = true, .low = INFINITY};
    for (int j = 0; j < tables; j++)
        for (int64_t r = 0; r < table[j].table->rows; r++) { /* the same range for both panels */
            k.low = fmin(k.low, 0.8 * column[j][W_K][r]);
            k.high = fmax(k.high, 1.25 * column[j][W_K][r]);
        }
    if (!(k.low < k.high))
        return sp_fail(err, SP_EREFUSED, "nothing to draw: no row has a wave number");
    const sp_panel panel[2] = {
        {.tag = "(a)", .x = k, .y = {.label = axis[1]}, .curves = tables, .curve = speed},
        {.tag = "(b)", .x = k, .y = {.label = axis[2], .log = true}, .curves = curves, .curve = alpha}};
    const sp_sheet sheet = {.title = "Coherent wave", .rows = 2, .columns = 1, .panel = panel, .aspect = 0.62};
    return sp_plot_sheet(&sheet, path, err);
}

sp_status sp_plot_wave(int tables, const sp_plot_table *table, const char *path, sp_error *err) {
    sp_status status = sp_canvas_check(path, err);
    size_t rows = 0;
    if (status == SP_OK && (tables < 1 || tables > WAVES_MOST))
        status = sp_fail(err, SP_EINVAL, "%d tables: a figure shows 1 to %d", tables, WAVES_MOST);
    for (int j = 0; j < tables && status == SP_OK; j++)
        rows += (size_t)table[j].table->rows;
    if (status == SP_OK && rows == 0)
        status = sp_fail(err, SP_EREFUSED, "nothing to draw: the table of waves has no row");
    if (status != SP_OK)
        return status;
    double *memory = sp_alloc(WAVE_COLUMNS * rows, sizeof *memory);
    if (!memory)
        return sp_fail_memory(err, WAVE_COLUMNS * rows * sizeof *memory);
    status = draw_wave(tables, table, memory, path, err);
    sp_free(memory);
    return status;
}
