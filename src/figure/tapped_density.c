/* Figure of the density along a tapped column: profiles at rest and after taps, and three particles against time. */
#include "figure/tapped_table.h"

#include <math.h>
#include <stdio.h>

enum { PROFILES = 6, PLACES = 3, MARKED_MOST = 40, LABEL_ROOM = 200 };

/* Finds the row nearest to a time, by bisection. */
static int64_t row_at(int64_t rows, const double *t, double time) {
    int64_t low = 0, high = rows - 1;
    while (high - low > 1) {
        const int64_t middle = low + (high - low) / 2;
        if (t[middle] <= time)
            low = middle;
        else
            high = middle;
    }
    return fabs(t[high] - time) < fabs(t[low] - time) ? high : low;
}

/* Chooses the first row and those at .99T, 1.99T, ...; of many taps the first, the last and some in between. Without a
 * known period the rows are evenly spaced. number: of the tap, or 0 if unknown. */
static int choose_rows(const tapped_table *s, const double *t, int64_t row[PROFILES], double number[PROFILES]) {
    const int64_t rows = s->table->rows;
    const double period = sp_tapped_table_setting(s, "period"), taps = floor((t[rows - 1] - t[0]) / period + 0.02);
    int n = 0;
    row[n] = 0;
    number[n++] = 0;
    for (int k = 1; k < PROFILES; k++) {
        const double tap = taps < PROFILES ? k : 1 + round((k - 1) * (taps - 1) / (PROFILES - 2));
        if (isfinite(period) && tap > taps)
            break;
        const int64_t at = isfinite(period) ? row_at(rows, t, t[0] + (tap - 0.01) * period)
                                            : (int64_t)llround((double)(rows - 1) * k / (PROFILES - 1));
        if (at > row[n - 1]) {
            row[n] = at;
            number[n++] = isfinite(period) && fabs(t[0]) < 1e-9 * period ? tap : 0;
        }
    }
    return n;
}

static void profile(const tapped_table *s, int64_t row, double *y, double *rho) {
    for (int k = 0; k < s->particles; k++) {
        const double height = sp_table_number(s->table, row, s->first + k);
        const double value = sp_table_number(s->table, row, s->density + k);
        y[k] = isfinite(height) ? height : NAN;
        rho[k] = isfinite(value) ? value : NAN;
    }
}

static int profile_curves(const tapped_table *s, const double *t, double *memory, sp_curve *curve,
                          char (*label)[LABEL_ROOM]) {
    static const sp_mark marks[] = {SP_MARK_CIRCLE, SP_MARK_SQUARE, SP_MARK_TRIANGLE, SP_MARK_DIAMOND};
    int64_t row[PROFILES];
    double tap[PROFILES];
    const int n = choose_rows(s, t, row, tap), size = s->particles;
    for (int k = 0; k < n; k++) {
        char number[40], unit[80], of_tap[40];
        double *y = memory + 2 * k * size;
        profile(s, row[k], y, y + size);
        sp_figure_text_number(number, sizeof number, t[row[k]], 3);
        sp_figure_text_escape(unit, sizeof unit, s->table->column[s->abscissa].unit, 12);
        of_tap[0] = '\0';
        if (tap[k] > 0)
            snprintf(of_tap, sizeof of_tap, "tap %.0f, ", tap[k]);
        snprintf(label[k], LABEL_ROOM, "%s|t| = %s%s%s", of_tap, number, *unit ? " " : "", unit);
        curve[k] = (sp_curve){.label = label[k],
                              .n = size,
                              .x = y,
                              .y = y + size,
                              .ink = k,
                              .dash = (sp_dash)(k % 4),
                              .mark = size <= MARKED_MOST ? marks[k % 4] : SP_MARK_NONE,
                              .open = k % 2,
                              .width = 0.8};
    }
    return n;
}

/* Curves for the lowest, a middle and the highest particle. */
static int time_curves(const tapped_table *s, const double *t, double *memory, sp_curve *curve,
                       char (*label)[LABEL_ROOM]) {
    const int place[PLACES] = {1, (s->particles + 1) / 2, s->particles};
    int n = 0;
    for (int k = 0; k < PLACES; k++) {
        if (k > 0 && place[k] == place[k - 1])
            continue;
        double *to = memory + n * s->table->rows;
        snprintf(label[n], LABEL_ROOM, "particle %d", place[k]);
        sp_tapped_table_values(s, s->density + place[k] - 1, to);
        curve[n] = (sp_curve){.label = label[n], .n = s->table->rows, .x = t, .y = to, .ink = 1 + n, .width = 0.7};
        curve[n].dash = n == 1 ? SP_DASH_DASHED : SP_DASH_SOLID;
        n++;
    }
    return n;
}

static sp_status draw(const tapped_table *s, double *memory, const char *path, sp_error *err) {
    const int64_t rows = s->table->rows;
    sp_curve curve[PROFILES], late[PLACES];
    char label[PROFILES][LABEL_ROOM], place[PLACES][LABEL_ROOM];
    char x[2][TAPPED_LABEL], y[TAPPED_LABEL];
    sp_status status = sp_tapped_table_abscissa(s, memory, err);
    if (status != SP_OK)
        return status;
    const int profiles = profile_curves(s, memory, memory + (1 + PLACES) * rows, curve, label);
    const int places = time_curves(s, memory, memory + rows, late, place);
    sp_tapped_axis_label(s, "density |\xcf\x81|", s->density, y);
    const sp_panel panel[2] = {
        {.tag = "(a)",
         .x = {.label = sp_tapped_axis_label(s, "height |y|", s->first, x[0])},
         .y = {.label = y},
         .curves = profiles,
         .curve = curve,
         .tight = true},
        {.tag = "(b)",
         .x = {.label = sp_tapped_axis_label(s, "|t|", s->abscissa, x[1]), .low = memory[0], .high = memory[rows - 1]},
         .y = {.label = y},
         .curves = places,
         .curve = late}};
    const sp_sheet sheet = {
        .title = "Density of a tapped column", .rows = 2, .columns = 1, .panel = panel, .aspect = 0.72};
    return sp_plot_sheet(&sheet, path, err);
}

sp_status sp_tapped_draw_density(const tapped_table *s, const char *path, sp_error *err) {
    const size_t count = (1 + PLACES) * (size_t)s->table->rows + 2 * PROFILES * (size_t)s->particles;
    return sp_tapped_draw_with_memory(draw, count, s, path, err);
}
