/* Draws a surface over two axes in parallel projection, with its walls and axes. */
#include "figure/tapped_view.h"

#include "base/base.h"

#include <math.h>
#include <stdio.h>

/* Lengths of the axes for time, label and height before the projection, and the angles of view. */
#define LONG_TIME  1.55
#define LONG_LABEL 1.0
#define TALL       1.15
#define AZIMUTH    0.52 /* time axis towards the viewer */
#define ELEVATION  0.42
#define IMAGE_DPI  450.0
#define TICK       3.0 /* [pt] */

typedef struct point {
    double x, y;
} point;
/* Coordinates along the axes, each 0 .. 1. */
typedef struct point3 {
    double time, label, height;
} point3;

/* Projects such coordinates to the plane, with y downwards. */
static point project(double time, double label, double height) {
    const double p = LONG_TIME * time, q = LONG_LABEL * label, h = TALL * height;
    const double across = p * cos(AZIMUTH) + q * sin(AZIMUTH), depth = q * cos(AZIMUTH) - p * sin(AZIMUTH);
    return (point){across, -(h * cos(ELEVATION) + depth * sin(ELEVATION))};
}

static point place(const scene3 *s, double time, double label, double height) {
    const point p = project(time, label, height);
    return (point){s->x0 + s->scale * p.x, s->y0 + s->scale * p.y};
}

static double part_of(const axis *a, double value) { return (sp_axis_unit(a, value) - a->low) / (a->high - a->low); }
static double tick_part(const axis *a, int k) { return (a->tick[k].at - a->low) / (a->high - a->low); }

static colour between(const unsigned char a[3], const unsigned char b[3], double f) {
    return (colour){((1 - f) * a[0] + f * b[0]) / 255, ((1 - f) * a[1] + f * b[1]) / 255,
                    ((1 - f) * a[2] + f * b[2]) / 255};
}

/* The colour at a place of a list, between 0 and 1. */
static colour along(int n, const unsigned char (*step)[3], double part) {
    const double at = (n - 1) * fmin(1, fmax(0, part));
    const int k = at < n - 1 ? (int)at : n - 2;
    return between(step[k], step[k + 1], at - k);
}

colour sp_scene3_signed_colour(double part) {
    static const unsigned char step[5][3] = {
        {0, 34, 78}, {66, 78, 108}, {140, 140, 140}, {203, 187, 104}, {254, 232, 56}};
    return along(5, step, 0.5 + 0.5 * part);
}

colour sp_scene3_colour(double part) {
    static const unsigned char step[5][3] = {
        {255, 250, 215}, {190, 226, 182}, {80, 184, 190}, {40, 112, 178}, {18, 38, 100}};
    return along(5, step, part);
}

/* ---- layout ----------------------------------------------------------------------------------------------------- */

/* Chooses the ticks of an axis of this length, as in a plain frame. */
static void choose(canvas *c, axis *a, double letters, double length) {
    axes plain = {.x = *a, .y = *a, .width = length + 4 * letters, .height = length};
    plain.x.size = plain.y.size = letters;
    plain.x.label[0] = plain.y.label[0] = '\0';
    sp_axes_layout(&plain, c);
    a->ticks = plain.x.ticks;
    for (int k = 0; k < a->ticks; k++)
        a->tick[k] = plain.x.tick[k];
}

void sp_axis_keep_whole_ticks(axis *a, double low) {
    int kept = 0;
    for (int k = 0; k < a->ticks; k++) {
        const double at = a->tick[k].at;
        if (fabs(at - round(at)) > 1e-6 || at < low)
            continue;
        a->tick[kept] = a->tick[k];
        if (a->tick[k].major)
            snprintf(a->tick[kept].label, sizeof a->tick[kept].label, "%.0f", round(at));
        kept++;
    }
    a->ticks = kept;
}

static double widest(const scene3 *s, const axis *a) {
    double width = 0;
    for (int k = 0; k < a->ticks; k++)
        width = fmax(width, sp_figure_text_width(s->c, a->tick[k].label, s->letters));
    return width;
}

void sp_scene3_layout(scene3 *s) {
    const point left = project(0, 0, 0), right = project(1, 1, 0), low = project(1, 0, 0), high = project(0, 1, 1);
    const double line = 1.3 * s->letters;
    double west = 4 * line, east = 3 * line;
    for (int pass = 0; pass < 2; pass++) {
        const double across = s->width - west - east, tall = s->height - 2.9 * line - 2;
        s->scale = fmin(across / (right.x - left.x), tall / (low.y - high.y));
        choose(s->c, &s->time, s->letters, 0.9 * s->scale * LONG_TIME);
        choose(s->c, &s->label, s->letters, s->scale * LONG_LABEL);
        sp_axis_keep_whole_ticks(&s->label, 0.5); /* particles count from 1 */
        choose(s->c, &s->height_axis, s->letters, s->scale * TALL);
        west = widest(s, &s->height_axis) + line + 2 * TICK + 7;
        east = widest(s, &s->label) + line + TICK;
    }
    s->x0 = s->left + west + 0.5 * (s->width - west - east - s->scale * (right.x - left.x)) - s->scale * left.x;
    s->y0 = s->top + 2 - s->scale * high.y;
}

/* ---- walls and axes --------------------------------------------------------------------------------------------- */

static void line(const scene3 *s, point3 from, point3 to) {
    const point a = place(s, from.time, from.label, from.height), b = place(s, to.time, to.label, to.height);
    cairo_move_to(s->c->cr, a.x, a.y);
    cairo_line_to(s->c->cr, b.x, b.y);
}

static void draw_walls(const scene3 *s) {
    cairo_t *cr = s->c->cr;
    cairo_set_line_width(cr, 0.35);
    sp_canvas_colour(s->c, (colour){0.8, 0.8, 0.8});
    for (int k = 0; k < s->height_axis.ticks; k++)
        if (s->height_axis.tick[k].major) {
            const double h = tick_part(&s->height_axis, k);
            line(s, (point3){0, 0, h}, (point3){0, 1, h});
            line(s, (point3){0, 1, h}, (point3){1, 1, h});
        }
    for (int k = 0; k < s->time.ticks; k++)
        if (s->time.tick[k].major) {
            const double p = tick_part(&s->time, k);
            line(s, (point3){p, 0, 0}, (point3){p, 1, 0});
            line(s, (point3){p, 1, 0}, (point3){p, 1, 1});
        }
    for (int k = 0; k < s->label.ticks; k++)
        if (s->label.tick[k].major) {
            const double q = tick_part(&s->label, k);
            line(s, (point3){0, q, 0}, (point3){1, q, 0});
            line(s, (point3){0, q, 0}, (point3){0, q, 1});
        }
    cairo_stroke(cr);
    cairo_set_line_width(cr, 0.5);
    sp_canvas_colour(s->c, (colour){0.55, 0.55, 0.55});
    line(s, (point3){0, 0, 1}, (point3){0, 1, 1});
    line(s, (point3){0, 1, 1}, (point3){1, 1, 1});
    line(s, (point3){0, 1, 0}, (point3){0, 1, 1});
    line(s, (point3){0, 1, 0}, (point3){1, 1, 0});
    line(s, (point3){0, 0, 0}, (point3){0, 1, 0});
    line(s, (point3){1, 1, 0}, (point3){1, 1, 1});
    cairo_stroke(cr);
}

/* Draws the ticks of an axis along `out` [pt]. */
static void draw_ticks(const scene3 *s, const axis *a, int which, point out, text_style style) {
    cairo_t *cr = s->c->cr;
    for (int k = 0; k < a->ticks; k++) {
        const double part = tick_part(a, k);
        const point at = which == 0 ? place(s, part, 0, 0) : which == 1 ? place(s, 1, part, 0) : place(s, 0, 0, part);
        const double length = a->tick[k].major ? TICK : 0.55 * TICK;
        cairo_move_to(cr, at.x, at.y);
        cairo_rel_line_to(cr, length * out.x, length * out.y);
        cairo_stroke(cr);
        if (a->tick[k].label[0])
            sp_figure_text_draw(s->c, a->tick[k].label, at.x + (TICK + 2) * out.x, at.y + (TICK + 2) * out.y, style);
    }
}

/* Writes the name of an axis beside the middle of its edge, parallel to it. */
static void draw_name(const scene3 *s, const axis *a, point from, point to, double off) {
    const double length = hypot(to.x - from.x, to.y - from.y), angle = atan2(from.y - to.y, to.x - from.x);
    const point across = {-(to.y - from.y) / length, (to.x - from.x) / length};
    const double wide = sp_figure_text_width(s->c, a->label, s->letters);
    const double size = wide > 1.15 * length ? fmax(6, s->letters * 1.15 * length / wide) : s->letters;
    sp_figure_text_draw(s->c, a->label, 0.5 * (from.x + to.x) + off * across.x, 0.5 * (from.y + to.y) + off * across.y,
                        (text_style){size, 0.5, off > 0 ? 1.0 : 0.0, angle});
}

static point unit(point from, point to) {
    const double length = hypot(to.x - from.x, to.y - from.y);
    return (point){(to.x - from.x) / length, (to.y - from.y) / length};
}

/* Distance from the edge at which the name of the particle axis clears the tick labels, which begin at the ends of the
 * ticks. */
static double beside_labels(const scene3 *s, point out, point along) {
    const point across = {-along.y, along.x};
    const double ends = (TICK + 2) * (out.x * across.x + out.y * across.y);
    return ends + widest(s, &s->label) * across.x + 0.5 * s->letters * across.y + 4;
}

static void draw_axes(const scene3 *s) {
    const double size = s->letters;
    const point front = place(s, 0, 0, 0), corner = place(s, 1, 0, 0), back = place(s, 1, 1, 0);
    const point high = place(s, 0, 0, 1);
    cairo_set_line_width(s->c->cr, 0.7);
    sp_canvas_colour(s->c, (colour){0, 0, 0});
    line(s, (point3){0, 0, 0}, (point3){1, 0, 0});
    line(s, (point3){1, 0, 0}, (point3){1, 1, 0});
    line(s, (point3){0, 0, 0}, (point3){0, 0, 1});
    cairo_stroke(s->c->cr);
    draw_ticks(s, &s->time, 0, unit(back, corner), (text_style){size, 0.6, 1.0, 0.0});
    draw_ticks(s, &s->label, 1, unit(front, corner), (text_style){size, 0.0, 0.7, 0.0});
    draw_ticks(s, &s->height_axis, 2, (point){-1, 0}, (text_style){size, 1.0, 0.5, 0.0});
    draw_name(s, &s->time, front, corner, TICK + 2 + 1.35 * size);
    draw_name(s, &s->label, corner, back, beside_labels(s, unit(front, corner), unit(corner, back)));
    draw_name(s, &s->height_axis, front, high, -(TICK + 7 + widest(s, &s->height_axis)));
}

/* ---- the surface ------------------------------------------------------------------------------------------------ */

static point corner_of(const scene3 *s, const surface *f, int column, int row) {
    const double y = f->y[(size_t)column * (size_t)f->rows + (size_t)row];
    return place(s, part_of(&s->time, f->t[row]), part_of(&s->label, f->z[column]), part_of(&s->height_axis, y));
}

/* Shade of a cell: the steeper it falls with time, the darker. Flat cells keep the colour of the scale. */
static double light_of(const scene3 *s, const surface *f, int column, int row) {
    const size_t at = (size_t)column * (size_t)f->rows + (size_t)row;
    const double rise = (f->y[at + 1] - f->y[at]) / (s->height_axis.high - s->height_axis.low) * TALL;
    const double run = (f->t[row + 1] - f->t[row]) / (s->time.high - s->time.low) * LONG_TIME;
    return 1 - 0.17 * tanh(0.7 * fmax(0, -rise / run));
}

static void mesh_line(cairo_t *cr, point a, point b, double opacity) {
    cairo_set_source_rgba(cr, 0, 0, 0, opacity);
    cairo_set_line_width(cr, 0.3);
    cairo_move_to(cr, a.x, a.y);
    cairo_line_to(cr, b.x, b.y);
    cairo_stroke(cr);
}

static void draw_cell(const scene3 *s, const surface *f, cairo_t *cr, int column, int row) {
    const size_t at = (size_t)column * (size_t)f->rows + (size_t)row, next = at + (size_t)f->rows;
    if (!isfinite(f->y[at] + f->y[at + 1] + f->y[next] + f->y[next + 1]))
        return;
    const point a = corner_of(s, f, column, row), b = corner_of(s, f, column, row + 1);
    const point c = corner_of(s, f, column + 1, row + 1), d = corner_of(s, f, column + 1, row);
    const double mean = 0.25 * (f->shade[at] + f->shade[at + 1] + f->shade[next] + f->shade[next + 1]);
    const colour ink = f->is_signed ? sp_scene3_signed_colour(mean) : sp_scene3_colour(mean);
    const double light = light_of(s, f, column, row);
    cairo_set_source_rgb(cr, light * ink.r, light * ink.g, light * ink.b);
    cairo_move_to(cr, a.x, a.y);
    cairo_line_to(cr, b.x, b.y);
    cairo_line_to(cr, c.x, c.y);
    cairo_line_to(cr, d.x, d.y);
    cairo_close_path(cr);
    cairo_fill_preserve(cr);
    cairo_set_line_width(cr, 0.25); /* an outline of the same colour hides the seams */
    cairo_stroke(cr);
    /* edges that later cells do not cover */
    if (column + 2 == f->columns)
        mesh_line(cr, d, c, 0.7);
    else if ((column + 1) % f->every_z == 0)
        mesh_line(cr, d, c, 0.5);
    if (column == 0)
        mesh_line(cr, a, b, 0.7);
    if (row + 2 == f->rows)
        mesh_line(cr, b, c, 0.5);
    if (row % f->every_t == 0 || row == 0)
        mesh_line(cr, a, d, 0.2);
}

/* Paints the cells from back to front, which for a surface over a grid is the order of its indices. */
static void draw_cells(const scene3 *s, const surface *f, cairo_t *cr) {
    cairo_set_line_join(cr, CAIRO_LINE_JOIN_ROUND);
    for (int column = f->columns - 2; column >= 0; column--)
        for (int row = 0; row + 1 < f->rows; row++)
            draw_cell(s, f, cr, column, row);
    if (!f->floor)
        return;
    cairo_new_path(cr);
    for (int row = 0; row < f->rows; row++) {
        const point p = place(s, part_of(&s->time, f->t[row]), part_of(&s->label, f->floor_at),
                              part_of(&s->height_axis, f->floor[row]));
        if (isfinite(p.y))
            cairo_line_to(cr, p.x, p.y);
        else
            cairo_new_sub_path(cr);
    }
    cairo_set_source_rgb(cr, 0, 0, 0);
    cairo_set_line_width(cr, 0.9);
    cairo_stroke(cr);
}

/* Draws the surface. Vector figures get it as an image, because tens of thousands of cells would make them slow. */
static void draw_surface(const scene3 *s, const surface *f) {
    if (s->c->kind == CANVAS_PNG) {
        cairo_save(s->c->cr);
        draw_cells(s, f, s->c->cr);
        cairo_restore(s->c->cr);
        return;
    }
    const double scale = IMAGE_DPI / 72;
    cairo_surface_t *image =
        cairo_image_surface_create(CAIRO_FORMAT_ARGB32, (int)ceil(s->width * scale), (int)ceil(s->height * scale));
    cairo_t *cr = cairo_create(image);
    cairo_scale(cr, scale, scale);
    cairo_translate(cr, -s->left, -s->top);
    draw_cells(s, f, cr);
    cairo_destroy(cr);
    cairo_save(s->c->cr);
    cairo_translate(s->c->cr, s->left, s->top);
    cairo_scale(s->c->cr, 1 / scale, 1 / scale);
    cairo_set_source_surface(s->c->cr, image, 0, 0); /* an error of the image becomes an error of the canvas */
    cairo_paint(s->c->cr);
    cairo_restore(s->c->cr);
    cairo_surface_destroy(image);
}

void sp_scene3_draw(const scene3 *s, const surface *f) {
    draw_walls(s);
    draw_surface(s, f);
    draw_axes(s);
}
