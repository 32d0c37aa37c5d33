/* Draws arrival times and local exponents of fronts against distance, as Figs. 6 and 7 of Somfai et al. 2005. */
#include "figure/series_table.h"

#include "base/base.h"
#include "figure/canvas.h"
#include "figure/look.h"
#include "figure/unit.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { TIMES = 3, MARKS_IN_INSET = 4, LABEL_ROOM = 320 };

static const quantity times[TIMES] = {Q_T10, Q_T_PEAK, Q_T_ZERO};
static const sp_mark time_marks[TIMES] = {SP_MARK_TRIANGLE, SP_MARK_CIRCLE, SP_MARK_SQUARE};
static const sp_dash time_dashes[TIMES] = {SP_DASH_SOLID, SP_DASH_DASHED, SP_DASH_DOTTED};
static const char *const time_names[TIMES] = {"|t|_{10}", "|t|_{peak}", "|t|_{zero}"};

enum { AXIS_ROOM = UNIT_MARKUP + 40 };

/* The axis of distances: of a chain they are numbers of grains. */
static const char *distance_label(const front_groups *g, char out[AXIS_ROOM]) {
    if (g->chain)
        snprintf(out, AXIS_ROOM, "length of the chain  [grains]");
    else
        sp_unit_label("distance", g->distance_unit, out, AXIS_ROOM);
    return out;
}

/* The unit of a speed, distance over time, as markup; "" if one of them is unknown. */
static void speed_unit(const front_groups *g, char out[UNIT_MARKUP]) {
    char distance[UNIT_MARKUP], time[UNIT_MARKUP];
    sp_unit_markup(g->distance_unit, distance);
    sp_unit_markup(g->time_unit, time);
    out[0] = '\0';
    if (sp_unit_same(g->distance_unit, UNIT_LENGTH) && sp_unit_same(g->time_unit, UNIT_TIME))
        sp_unit_markup(UNIT_SPEED, out);
    else if (*distance && *time)
        snprintf(out, UNIT_MARKUP, strpbrk(time, "/ ") ? "%.90s/(%.90s)" : "%.90s/%.90s", distance, time);
}

/* ---- lines ------------------------------------------------------------------------------------------------------ */

typedef struct line {
    double x[2], y[2];
    double speed; /* NAN: no line */
} line;

/* Least-squares line through the points of a group. False with fewer than two distances. */
static bool fit_line(const front_group *g, quantity q, line *out) {
    const double *x = g->value[Q_DISTANCE], *y = g->value[q];
    double n = 0, mx = 0, my = 0, sxx = 0, sxy = 0, low = INFINITY, high = -INFINITY;
    for (int64_t k = 0; k < g->n; k++) {
        if (!isfinite(x[k]) || !isfinite(y[k]))
            continue;
        n += 1;
        mx += (x[k] - mx) / n;
        my += (y[k] - my) / n;
        low = fmin(low, x[k]);
        high = fmax(high, x[k]);
    }
    for (int64_t k = 0; k < g->n; k++)
        if (isfinite(x[k]) && isfinite(y[k])) {
            sxx += (x[k] - mx) * (x[k] - mx);
            sxy += (x[k] - mx) * (y[k] - my);
        }
    if (!(n >= 2) || !(sxx > 1e-12 * mx * mx))
        return false;
    const double slope = sxy / sxx;
    *out = (line){{low, high}, {my + slope * (low - mx), my + slope * (high - mx)}, slope > 0 ? 1 / slope : NAN};
    return true;
}

/* ---- arrival times ---------------------------------------------------------------------------------------------- */

typedef struct arrivals {
    const front_groups *g;
    sp_curve *curve;
    line *line;
    char (*label)[LABEL_ROOM];
    int curves;
    bool speeds; /* the legend has speeds */
    char unit[UNIT_MARKUP + 40];
} arrivals;

/* A line through points is no line on a logarithmic axis, and may pass below zero. */
static bool is_bent(void) { return sp_look_is_log('x', 0) || sp_look_is_log('y', 0); }

/* Adds the points of one group. A single group has one colour for each mark and shows the speed of its line; several
 * groups have one colour each. */
static void add_group(arrivals *a, int k) {
    const front_group *g = &a->g->group[k];
    const bool alone = a->g->n == 1;
    for (int m = 0; m < TIMES; m++) {
        line *l = &a->line[TIMES * k + m];
        char *label = a->label[TIMES * k + m];
        const int ink = alone ? m + 1 : sp_group_ink(a->g, k);
        const bool fitted = fit_line(g, times[m], l);
        if (fitted && !is_bent())
            a->curve[a->curves++] =
                (sp_curve){.n = 2, .x = l->x, .y = l->y, .ink = ink, .dash = time_dashes[m], .width = 0.7};
        if (alone && fitted && isfinite(l->speed)) {
            char number[40];
            sp_figure_text_number(number, sizeof number, l->speed, 3);
            const bool chain = a->g->chain && strcmp(a->g->time_unit, "l/c") == 0;
            snprintf(label, sizeof *a->label, chain ? "%s,  |v| = %s |c|" : "%s,  |c| = %s", time_names[m], number);
            a->speeds = !chain;
        } else if (alone) {
            snprintf(label, sizeof *a->label, "%s", time_names[m]);
        } else if (m == 0) {
            snprintf(label, sizeof *a->label, "%s", g->label);
        }
        a->curve[a->curves++] = (sp_curve){.label = *label ? label : NULL,
                                           .n = g->n,
                                           .x = g->value[Q_DISTANCE],
                                           .y = g->value[times[m]],
                                           .error = g->error[times[m]],
                                           .ink = ink,
                                           .dash = SP_DASH_NONE,
                                           .mark = time_marks[m],
                                           .open = m != 1};
    }
}

/* Several groups: explains the marks once, in black. */
static void add_mark_names(arrivals *a) {
    for (int m = 0; m < TIMES && a->g->n > 1; m++)
        a->curve[a->curves++] =
            (sp_curve){.label = time_names[m], .n = 0, .dash = SP_DASH_NONE, .mark = time_marks[m], .open = m != 1};
}

/* A last line of the legend: the unit of its speeds. */
static void add_speed_unit(arrivals *a) {
    char unit[UNIT_MARKUP];
    speed_unit(a->g, unit);
    if (!a->speeds || !*unit)
        return;
    snprintf(a->unit, sizeof a->unit, "|c|  [%s]", unit);
    a->curve[a->curves++] = (sp_curve){.label = a->unit, .dash = SP_DASH_NONE};
}

static double height_at(const sp_plot_trace *s, double time) {
    for (int64_t k = 1; k < s->n; k++)
        if (s->t[k - 1] <= time && time <= s->t[k] && s->t[k] > s->t[k - 1])
            return s->f[k - 1] + (s->f[k] - s->f[k - 1]) * (time - s->t[k - 1]) / (s->t[k] - s->t[k - 1]);
    return NAN;
}

/* Inset: a signal with its three marks, up to twice its zero crossing. point: storage for the marks. */
static sp_panel sample_panel(const sp_plot_trace *s, sp_curve curve[MARKS_IN_INSET], double point[TIMES][2],
                             char label[2][AXIS_ROOM]) {
    sp_unit_label("|t|", s->t_unit ? s->t_unit : UNIT_TIME, label[0], AXIS_ROOM);
    sp_unit_label("|F|_{sig}", !s->t_unit ? UNIT_FORCE : s->f_unit ? s->f_unit : "", label[1], AXIS_ROOM);
    const double when[TIMES] = {s->t10, s->t_peak, s->t_zero};
    curve[0] = (sp_curve){.n = s->n, .x = s->t, .y = s->f, .width = 0.8};
    for (int m = 0; m < TIMES; m++) {
        point[m][0] = when[m];
        point[m][1] = height_at(s, when[m]);
        curve[1 + m] = (sp_curve){.n = 1,
                                  .x = &point[m][0],
                                  .y = &point[m][1],
                                  .ink = m + 1,
                                  .dash = SP_DASH_NONE,
                                  .mark = time_marks[m],
                                  .open = m != 1};
    }
    return (sp_panel){.x = {.label = label[0], .low = NAN, .high = s->t_zero > 0 ? 2 * s->t_zero : NAN},
                      .y = {.label = label[1]},
                      .curves = MARKS_IN_INSET,
                      .curve = curve,
                      .zero_line = true};
}

static double lowest(const front_groups *g) {
    double low = 0;
    for (int k = 0; k < g->n; k++)
        for (int m = 0; m < TIMES; m++)
            for (int64_t r = 0; r < g->group[k].n; r++)
                low = fmin(low, g->group[k].value[times[m]][r]);
    return low;
}

static sp_status draw_arrivals(const front_groups *g, const sp_plot_trace *sample, const char *path, sp_error *err) {
    const size_t rows = TIMES * (size_t)g->n;
    sp_curve inner[MARKS_IN_INSET];
    double point[TIMES][2];
    char inner_label[2][AXIS_ROOM];
    arrivals a = {.g = g, .curve = sp_alloc(2 * rows + TIMES + 1, sizeof *a.curve)};
    a.line = sp_alloc(rows, sizeof *a.line);
    a.label = sp_alloc(rows, sizeof *a.label);
    sp_status status = a.curve && a.line && a.label ? SP_OK : sp_fail_memory(err, rows * sizeof *a.curve);
    if (status == SP_OK) {
        for (int k = 0; k < g->n; k++)
            add_group(&a, k);
        add_mark_names(&a);
        add_speed_unit(&a);
        sp_panel inset = {0};
        if (sample)
            inset = sample_panel(sample, inner, point, inner_label);
        char x[AXIS_ROOM], y[AXIS_ROOM];
        const sp_panel panel = {.x = {.label = distance_label(g, x), .low = 0, .high = NAN},
                                .y = {.label = sp_unit_label("|t|", g->time_unit, y, sizeof y),
                                      .low = lowest(g) < 0 ? NAN : 0,
                                      .high = NAN},
                                .curves = a.curves,
                                .curve = a.curve,
                                .inset = sample ? &inset : NULL};
        const sp_sheet sheet = {
            .title = "Arrival of the first front", .rows = 1, .columns = 1, .panel = &panel, .aspect = 0.85};
        status = sp_plot_sheet(&sheet, path, err);
    }
    sp_free(a.curve);
    sp_free(a.line);
    sp_free(a.label);
    return status;
}

sp_status sp_plot_fronts(int tables, const sp_plot_table *table, const sp_plot_trace *sample, const char *path,
                         sp_error *err) {
    front_groups g = {0};
    sp_status status = sp_canvas_check(path, err);
    if (status == SP_OK)
        status = sp_front_groups_read(tables, table, &g, err);
    if (status == SP_OK && g.mixed)
        status = sp_fail(err, SP_EINVAL,
                         "chains beside packings: their distances and times have other units, must be of one kind");
    if (status == SP_OK)
        status = draw_arrivals(&g, sample, path, err);
    sp_front_groups_free(&g);
    return status;
}

/* ---- exponents -------------------------------------------------------------------------------------------------- */

static sp_curve group_curve(const front_groups *g, int k, quantity x, quantity y, bool label) {
    const front_group *of = &g->group[k];
    return (sp_curve){.label = label && of->label[0] ? of->label : NULL,
                      .n = of->n,
                      .x = of->value[x],
                      .y = of->value[y],
                      .error = of->error[y],
                      .ink = sp_group_ink(g, k),
                      .dash = sp_group_dash(k),
                      .mark = sp_group_mark(k),
                      .width = 0.7};
}

static bool has(const front_groups *g, quantity x, quantity y) {
    for (int k = 0; k < g->n; k++)
        for (int64_t r = 0; r < g->group[k].n; r++)
            if (isfinite(g->group[k].value[x][r]) && isfinite(g->group[k].value[y][r]))
                return true;
    return false;
}

/* The x axis of both panels covers the distances of all points: also those of exponents beyond the last distance. */
static void distances(const front_groups *g, char label[AXIS_ROOM], sp_axis *x) {
    static const quantity both[] = {Q_DISTANCE, Q_BETWEEN};
    double low = INFINITY, high = 0;
    for (int k = 0; k < g->n; k++)
        for (int64_t r = 0; r < 2 * g->group[k].n; r++) {
            const front_group *of = &g->group[k];
            const double d = of->value[both[r % 2]][r / 2];
            if (r % 2 == 1 && isnan(of->value[Q_GAMMA][r / 2]) && isnan(of->value[Q_ALPHA][r / 2]))
                continue;
            low = isfinite(d) ? fmin(low, d) : low;
            high = isfinite(d) ? fmax(high, d) : high;
        }
    *x = (sp_axis){.label = distance_label(g, label), .log = true, .low = 0.85 * low, .high = high / 0.85};
}

static sp_status draw_exponents(const front_groups *g, const char *path, sp_error *err) {
    const bool peaks = g->n <= 2 && has(g, Q_BETWEEN, Q_ALPHA_PEAK);
    const size_t n = (size_t)g->n;
    sp_curve *curve = sp_alloc(5 * n, sizeof *curve);
    sp_axis x;
    char label[AXIS_ROOM], inner[3][AXIS_ROOM];
    int lowers = 0;
    if (!curve)
        return sp_fail_memory(err, 5 * n * sizeof *curve);
    sp_curve *upper = curve, *lower = curve + n, *sizes = curve + 3 * n;
    distances(g, label, &x);
    for (int k = 0; k < g->n; k++) {
        upper[k] = group_curve(g, k, Q_BETWEEN, Q_GAMMA, true);
        lower[lowers] = group_curve(g, k, Q_BETWEEN, Q_ALPHA, false);
        if (peaks && g->n == 1)
            lower[lowers].label = "|t|_{zero} \xe2\x88\x92 |t|_{10}";
        lowers++;
        if (peaks) {
            lower[lowers] = group_curve(g, k, Q_BETWEEN, Q_ALPHA_PEAK, false);
            lower[lowers].open = true;
            lower[lowers].dash = SP_DASH_DOTTED;
            lower[lowers++].label = g->n == 1 ? "|t|_{zero} \xe2\x88\x92 |t|_{peak}" : NULL;
        }
        sizes[k] = group_curve(g, k, Q_DISTANCE, Q_AMPLITUDE, false);
        sizes[n + (size_t)k] = group_curve(g, k, Q_DISTANCE, Q_WIDTH, false);
    }
    if (g->chain)
        snprintf(inner[0], sizeof inner[0], "grains");
    else
        sp_unit_label("|L|", g->distance_unit, inner[0], sizeof inner[0]);
    sp_unit_label("|A|", g->amplitude_unit, inner[1], sizeof inner[1]);
    sp_unit_label("|W|", g->width_unit, inner[2], sizeof inner[2]);
    const sp_axis across = {.label = inner[0], .log = true};
    const sp_panel inset[2] = {
        {.x = across, .y = {.label = inner[1], .log = true}, .curves = g->n, .curve = sizes},
        {.x = across, .y = {.label = inner[2], .log = true}, .curves = g->n, .curve = sizes + n}};
    const sp_panel panel[2] = {{.tag = "(a)",
                                .x = x,
                                .y = {.label = "|\xce\xb3|_{eff}"},
                                .curves = g->n,
                                .curve = upper,
                                .inset = has(g, Q_DISTANCE, Q_AMPLITUDE) ? &inset[0] : NULL},
                               {.tag = "(b)",
                                .x = x,
                                .y = {.label = "|\xce\xb1|_{eff}"},
                                .curves = lowers,
                                .curve = lower,
                                .inset = has(g, Q_DISTANCE, Q_WIDTH) ? &inset[1] : NULL}};
    const sp_sheet sheet = {
        .title = "Decay and broadening of the first front", .rows = 2, .columns = 1, .panel = panel, .aspect = 0.72};
    sp_status status = sp_plot_sheet(&sheet, path, err);
    sp_free(curve);
    return status;
}

sp_status sp_plot_scaling(int tables, const sp_plot_table *table, const char *path, sp_error *err) {
    front_groups g = {0};
    sp_status status = sp_canvas_check(path, err);
    if (status == SP_OK)
        status = sp_front_groups_read(tables, table, &g, err);
    if (status == SP_OK && (!has(&g, Q_BETWEEN, Q_GAMMA) || !has(&g, Q_BETWEEN, Q_ALPHA)))
        status = sp_fail(err, SP_EREFUSED,
                         "nothing to draw: no interval of distances has gamma and alpha; must be of "
                         "`sonopack table scaling' or `planes', or `chain front'");
    if (status == SP_OK)
        status = draw_exponents(&g, path, err);
    sp_front_groups_free(&g);
    return status;
}
