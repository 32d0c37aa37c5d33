/* Contacts of packings: Figs. 1(c) and 2 of Somfai et al. 2005. */
#include "figure/columns.h"
#include "figure/figure.h"
#include "figure/open.h"

#include "base/base.h"

#include <math.h>
#include <sonopack/figure/figure.h>
#include <sonopack/figure/plot.h>
#include <stdio.h>

enum { CURVES = 3, ROWS_MOST = 100000 };
#define PI       3.14159265358979323846
#define MARGIN   24.0 /* around the circles, for their labels [pt] */
#define LEGEND   46.0 /* below them [pt] */
#define SCALE    14.0 /* room for the radii below a quarter [pt] */
#define STRIDE   0.02 /* radians of a piece of arc */
#define AXIS_INK ((colour){0.62, 0.62, 0.62})

static const char *const names[CURVES] = {"all", "strong", "weak"};
static const char *const labels[CURVES] = {"all contacts", "strong: |F| > \xe2\x9f\xa8|F|\xe2\x9f\xa9",
                                           "weak: |F| \xe2\x89\xa4 \xe2\x9f\xa8|F|\xe2\x9f\xa9"};
static const int inks[CURVES] = {0, 2, 1}, dashes[CURVES] = {DASH_SOLID, DASH_SOLID, DASH_DASHED};
static const double widths[CURVES] = {1.6, 1.0, 1.0};

typedef struct rose {
    const sp_table *t;
    canvas *c;
    int angle, column[CURVES]; /* < 0: not in the table */
    int64_t merged;            /* rows that are drawn as one bin */
    bool quarter;              /* angles above the horizontal, 0 to 90 degrees: of directions in space */
    double x, y, scale;        /* centre, and radius of 1 [pt] */
    double largest;
} rose;

/* Few contacts in narrow bins are noise: three rows become one bin, with the middle one in its middle. */
static int64_t merge_of(const sp_table *t) {
    const double enough = 60;
    double contacts = INFINITY, dimension = 2;
    sp_table_get_number(t, "contacts", &contacts);
    sp_table_get_number(t, "dimension", &dimension);
    const bool few = contacts / (double)t->rows < enough && dimension == 2;
    return few && t->rows % 3 == 0 && t->rows >= 12 ? 3 : 1;
}

/* Row q of bin k. The first bin begins before the first row, so that it stands around it. */
static int64_t row_of(const rose *r, int64_t k, int64_t q) {
    return (k * r->merged + q - r->merged / 2 + r->t->rows) % r->t->rows;
}

/* The middle of bin k, in degrees; n bins further the same direction turned round. */
static double angle_of(const rose *r, int64_t k) {
    const int64_t n = r->t->rows / r->merged, turns = k < 0 ? -1 : k >= n ? 1 : 0;
    return sp_table_number(r->t, (k - turns * n) * r->merged, r->angle) + 180.0 * (double)turns;
}

static double value_of(const rose *r, int64_t k, int column) {
    double sum = 0;
    for (int64_t q = 0; q < r->merged; q++) {
        const double value = sp_table_number(r->t, row_of(r, k, q), column);
        sum += isnan(value) ? 0 : value;
    }
    return sum / (double)r->merged;
}

static void find_largest(rose *r) {
    r->largest = 0;
    for (int q = 0; q < CURVES; q++)
        for (int64_t k = 0; k < r->t->rows / r->merged && r->column[q] >= 0; k++)
            r->largest = fmax(r->largest, value_of(r, k, r->column[q]));
}

static sp_status check_cells(rose *r, sp_error *err) {
    for (int64_t k = 0; k < r->t->rows; k++) {
        const double angle = sp_table_number(r->t, k, r->angle);
        if (!isfinite(angle) || (k > 0 && angle <= sp_table_number(r->t, k - 1, r->angle)))
            return sp_fail(err, SP_EREFUSED, "row %lld, angle = %g: must be finite and rise from row to row",
                           (long long)k + 1, angle);
        for (int q = 0; q < CURVES; q++) {
            const double value = r->column[q] < 0 ? NAN : sp_table_number(r->t, k, r->column[q]);
            if (value < 0 || isinf(value))
                return sp_fail(err, SP_EREFUSED, "row %lld, %s = %g: a density is a finite number >= 0",
                               (long long)k + 1, names[q], value);
            r->largest = fmax(r->largest, value);
        }
    }
    if (!(r->largest > 0))
        return sp_fail(err, SP_EREFUSED, "nothing to draw: no row of %lld has a density above 0",
                       (long long)r->t->rows);
    return SP_OK;
}

/* Between rings. */
static double step_of(const rose *r) { return r->largest > 2.4 ? ceil(r->largest / 2.4) : 0.5; }

/* Every 30 degrees. */
static int spokes_of(const rose *r) { return r->quarter ? 4 : 12; }

/* Rings at 1 (thicker: isotropic) and at other round values, with their numbers; the walls' direction and up. */
static void draw_rings(const rose *r) {
    cairo_t *cr = r->c->cr;
    const double step = step_of(r), last = step * ceil(r->largest / step);
    sp_canvas_colour(r->c, AXIS_INK);
    for (double ring = step; ring <= last + 1e-9; ring += step) {
        cairo_new_path(cr);
        cairo_arc(cr, r->x, r->y, ring * r->scale, r->quarter ? -0.5 * PI : 0, r->quarter ? 0 : 2 * PI);
        cairo_set_line_width(cr, fabs(ring - 1) < 1e-9 ? 1.0 : 0.4);
        cairo_stroke(cr);
    }
    cairo_set_line_width(cr, 0.4);
    for (int k = 0; k < spokes_of(r); k++) {
        const double length = last * r->scale;
        cairo_move_to(cr, r->x, r->y);
        cairo_rel_line_to(cr, length * cos(k * PI / 6), -length * sin(k * PI / 6));
        cairo_stroke(cr);
    }
    sp_canvas_colour(r->c, sp_figure_ink(0));
    for (int k = 0; k < spokes_of(r); k++) {
        char text[16];
        const double a = k * PI / 6, reach = last * r->scale + 3;
        snprintf(text, sizeof text, "%d\xc2\xb0", 30 * k);
        sp_figure_text_draw(r->c, text, r->x + reach * cos(a), r->y - reach * sin(a),
                            (text_style){TEXT_SCRIPT, 0.5 - 0.5 * cos(a), 0.5 - 0.5 * sin(a), 0});
    }
}

/* The radii, on a scale below the circles: numbers beside the rings would hide the curves. */
static void draw_scale(const rose *r) {
    cairo_t *cr = r->c->cr;
    const double step = step_of(r), last = step * ceil(r->largest / step);
    const double y = r->quarter ? r->y + 9 : r->c->height - LEGEND + 12;
    sp_canvas_colour(r->c, sp_figure_ink(0));
    cairo_set_line_width(cr, 0.6);
    cairo_move_to(cr, r->x, y);
    cairo_rel_line_to(cr, last * r->scale, 0);
    for (double ring = 0; ring <= last + 1e-9; ring += step) {
        cairo_move_to(cr, r->x + ring * r->scale, y);
        cairo_rel_line_to(cr, 0, -3);
    }
    cairo_stroke(cr);
    for (double ring = 0; ring <= last + 1e-9; ring += step) {
        char number[32];
        sp_figure_text_number(number, sizeof number, ring, 3);
        sp_figure_text_draw(r->c, number, r->x + ring * r->scale, y + 3, (text_style){TEXT_SCRIPT, 0.5, 1, 0});
    }
    sp_figure_text_draw(r->c, "density (isotropic: 1)", r->x + 0.5 * last * r->scale, y + 14,
                        (text_style){TEXT_LEGEND, 0.5, 1, 0});
}

/* Bins as arcs; those of n and of -n. A quarter shows each once. */
static void draw_curve(const rose *r, int q) {
    cairo_t *cr = r->c->cr;
    const int64_t n = r->t->rows / r->merged;
    cairo_save(cr);
    cairo_rectangle(cr, r->x, 0, r->c->width, r->y);
    if (r->quarter)
        cairo_clip(cr);
    cairo_new_path(cr);
    for (int turn = 0; turn < 2; turn++)
        for (int64_t k = 0; k < n; k++) {
            const double radius = value_of(r, k, r->column[q]) * r->scale;
            const double at = angle_of(r, k), before = angle_of(r, k - 1), after = angle_of(r, k + 1);
            const double from = (0.5 * (at + before) + 180 * turn) * PI / 180;
            const double to = (0.5 * (at + after) + 180 * turn) * PI / 180;
            const int pieces = (int)fmin(1000, ceil(fabs(to - from) / STRIDE)) + 1;
            for (int j = 0; j <= pieces; j++) {
                const double a = from + (to - from) * j / pieces;
                cairo_line_to(cr, r->x + radius * cos(a), r->y - radius * sin(a));
            }
        }
    cairo_close_path(cr);
    sp_canvas_colour(r->c, sp_figure_ink(inks[q]));
    cairo_set_line_width(cr, widths[q]);
    sp_figure_dash(r->c, dashes[q]);
    cairo_stroke(cr);
    sp_figure_dash(r->c, DASH_SOLID);
    cairo_restore(cr);
}

static void draw_legend(const rose *r) {
    sp_canvas_colour(r->c, sp_figure_ink(0));
    if (r->quarter)
        sp_figure_text_draw(r->c, "angle above the horizontal", 4, 4, (text_style){TEXT_LEGEND, 0, 1, 0});
    double y = r->c->height - LEGEND + 10;
    for (int q = 0; q < CURVES; q++) {
        if (r->column[q] < 0)
            continue;
        const double x = 4;
        sp_canvas_colour(r->c, sp_figure_ink(inks[q]));
        cairo_set_line_width(r->c->cr, widths[q]);
        sp_figure_dash(r->c, dashes[q]);
        cairo_move_to(r->c->cr, x, y);
        cairo_line_to(r->c->cr, x + 17, y);
        cairo_stroke(r->c->cr);
        sp_figure_dash(r->c, DASH_SOLID);
        sp_canvas_colour(r->c, sp_figure_ink(0));
        sp_figure_text_draw(r->c, labels[q], x + 22, y, (text_style){TEXT_LEGEND, 0, 0.5, 0});
        y += 11;
    }
}

/* Opens the page and places the circles, or the quarter of them. */
static sp_status open_page(rose *r, canvas *c, const char *path, sp_error *err) {
    const double step = step_of(r), last = step * ceil(r->largest / step), side = CANVAS_COLUMN - 2 * MARGIN;
    double dimension = 2;
    sp_table_get_number(r->t, "dimension", &dimension);
    r->quarter = dimension == 3;
    r->c = c;
    r->x = r->quarter ? MARGIN : 0.5 * CANVAS_COLUMN;
    r->y = r->quarter ? MARGIN + side : 0.5 * CANVAS_COLUMN;
    r->scale = (r->quarter ? side : 0.5 * side) / last;
    return sp_figure_open(c, path, "Directions of contacts", CANVAS_COLUMN,
                          CANVAS_COLUMN + LEGEND + (r->quarter ? SCALE : 0), err);
}

sp_status sp_plot_angles(const sp_table *angles, const char *path, sp_error *err) {
    static const char what[] = "a table of directions has angle, all, strong, weak";
    rose r = {.t = angles, .column = {-1, -1, -1}};
    sp_status status = sp_canvas_check(path, err);
    if (status == SP_OK)
        status = sp_column_find(angles, "angle", what, &r.angle, err);
    if (status == SP_OK)
        status = sp_column_find(angles, "all", what, &r.column[0], err);
    for (int q = 1; q < CURVES && status == SP_OK; q++)
        if (sp_table_find_column(angles, names[q]) >= 0)
            status = sp_column_find(angles, names[q], what, &r.column[q], err);
    if (status == SP_OK && (angles->rows < 2 || angles->rows > ROWS_MOST))
        status = sp_fail(err, SP_EREFUSED, "%lld rows of angles, must be 2 or more", (long long)angles->rows);
    if (status == SP_OK)
        status = check_cells(&r, err);
    if (status != SP_OK)
        return status;
    r.merged = merge_of(angles);
    find_largest(&r);
    canvas c = {0};
    status = open_page(&r, &c, path, err);
    if (status == SP_OK) {
        draw_rings(&r);
        for (int q = 0; q < CURVES; q++)
            if (r.column[q] >= 0)
                draw_curve(&r, q);
        draw_scale(&r);
        draw_legend(&r);
    }
    return sp_canvas_close(&c, status, err);
}

/* ---- values ----------------------------------------------------------------------------------------------------- */

/* Steps need the edges of the bins: half way between the middles. */
static void edges(const sp_table *t, int column, double *x) {
    const int64_t n = t->rows;
    for (int64_t k = 0; k <= n; k++) {
        const int64_t a = k == 0 ? 0 : k == n ? n - 2 : k - 1;
        const double low = sp_table_number(t, a, column), high = sp_table_number(t, a + 1, column);
        x[k] = k == 0 ? low - 0.5 * (high - low) : k == n ? high + 0.5 * (high - low) : 0.5 * (low + high);
    }
}

sp_status sp_plot_contact_values(const sp_table *values, const char *path, sp_error *err) {
    static const char what[] = "a table of contact values has x, forces, stiffnesses";
    int column[3];
    sp_status status = sp_canvas_check(path, err);
    if (status == SP_OK)
        status = sp_column_find(values, "x", what, &column[0], err);
    if (status == SP_OK)
        status = sp_column_find(values, "forces", what, &column[1], err);
    if (status == SP_OK)
        status = sp_column_find(values, "stiffnesses", what, &column[2], err);
    if (status == SP_OK && values->rows < 2)
        status = sp_fail(err, SP_EREFUSED, "%lld rows of values, must be 2 or more", (long long)values->rows);
    if (status != SP_OK)
        return status;
    const size_t n = (size_t)values->rows + 1;
    double *memory = sp_alloc(3 * n, sizeof *memory);
    if (!memory)
        return sp_fail_memory(err, 3 * n * sizeof *memory);
    double *x = memory, *y[2] = {x + n, x + 2 * n};
    edges(values, column[0], x);
    for (int q = 0; q < 2; q++)
        for (int64_t k = 0; k <= values->rows; k++)
            y[q][k] = k < values->rows ? sp_table_number(values, k, column[q + 1]) : 0;
    const sp_curve curve[2] = {{.label = "normal force", .n = (int64_t)n, .x = x, .y = y[0], .ink = 1, .steps = true},
                               {.label = "normal stiffness",
                                .n = (int64_t)n,
                                .x = x,
                                .y = y[1],
                                .ink = 2,
                                .dash = SP_DASH_DASHED,
                                .steps = true}};
    const sp_panel panel = {
        .x = {.label = "|F|_{n}/\xe2\x9f\xa8|F|_{n}\xe2\x9f\xa9,  |k|_{n}/\xe2\x9f\xa8|k|_{n}\xe2\x9f\xa9"},
        .y = {.label = "probability density"},
        .curves = 2,
        .curve = curve};
    const sp_sheet sheet = {.title = "Normal forces and stiffnesses", .rows = 1, .columns = 1, .panel = &panel};
    status = sp_plot_sheet(&sheet, path, err);
    sp_free(memory);
    return status;
}
