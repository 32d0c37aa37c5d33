/* Draws series of points on axes. */
#include "figure/figure.h"

#include <math.h>

#define BAND 0.22 /* opacity of a band */

/* ---- lines ---------------------------------------------------------------------------------------------------- */

/* Points of a line that fall into the same column of 0.06 pt (a quarter of a pixel in PNG). Only the first, lowest,
 * highest and last are drawn. A signal of a million points then looks the same, but is drawn quickly and gives a small
 * file. */
typedef struct pen {
    cairo_t *cr;
    bool down; /* a path has been started */
    double column;
    int64_t first, last, lowest, highest; /* indices of points in the column; first < 0: none */
} pen;

static double place_x(const figure *f, const series *s, int64_t k) { return sp_axis_place(&f->axes.x, s->x[k]); }
static double place_y(const figure *f, const series *s, int64_t k) { return sp_axis_place(&f->axes.y, s->y[k]); }

static void pen_to(pen *p, const figure *f, const series *s, int64_t k) {
    if (p->down)
        cairo_line_to(p->cr, place_x(f, s, k), place_y(f, s, k));
    else
        cairo_move_to(p->cr, place_x(f, s, k), place_y(f, s, k));
    p->down = true;
}

static void pen_flush(pen *p, const figure *f, const series *s) {
    if (p->first < 0)
        return;
    const int64_t one = p->lowest < p->highest ? p->lowest : p->highest;
    const int64_t two = p->lowest < p->highest ? p->highest : p->lowest;
    pen_to(p, f, s, p->first);
    if (one != p->first)
        pen_to(p, f, s, one);
    if (two != one && two != p->first)
        pen_to(p, f, s, two);
    if (p->last != two && p->last != p->first)
        pen_to(p, f, s, p->last);
    p->first = -1;
}

static void draw_line(const figure *f, const series *s) {
    pen p = {.cr = f->canvas->cr, .first = -1};
    for (int64_t k = 0; k < s->n; k++) {
        if (!isfinite(s->x[k]) || !isfinite(s->y[k])) {
            pen_flush(&p, f, s);
            p.down = false;
            continue;
        }
        double column = floor(place_x(f, s, k) / 0.06);
        if (p.first >= 0 && column == p.column) {
            p.last = k;
            p.lowest = s->y[k] < s->y[p.lowest] ? k : p.lowest;
            p.highest = s->y[k] > s->y[p.highest] ? k : p.highest;
            continue;
        }
        pen_flush(&p, f, s);
        p.column = column;
        p.first = p.last = p.lowest = p.highest = k;
    }
    pen_flush(&p, f, s);
    sp_canvas_colour(f->canvas, s->ink);
    cairo_set_line_width(p.cr, s->width);
    sp_figure_dash(f->canvas, s->dash);
    cairo_stroke(p.cr);
    sp_figure_dash(f->canvas, DASH_SOLID);
}

/* Fills a light band between two curves, one polygon for each run of finite points. */
static void draw_band(const figure *f, const series *s) {
    cairo_t *cr = f->canvas->cr;
    for (int64_t first = 0, last; first < s->n; first = last + 1) {
        for (last = first; last < s->n; last++)
            if (!isfinite(s->x[last]) || !isfinite(s->fill_low[last]) || !isfinite(s->fill_high[last]))
                break;
        for (int64_t k = first; k < last; k++)
            cairo_line_to(cr, place_x(f, s, k), sp_axis_place(&f->axes.y, s->fill_high[k]));
        for (int64_t k = last - 1; k >= first; k--)
            cairo_line_to(cr, place_x(f, s, k), sp_axis_place(&f->axes.y, s->fill_low[k]));
        if (last > first)
            cairo_close_path(cr);
        cairo_new_sub_path(cr);
    }
    cairo_set_source_rgba(cr, s->ink.r, s->ink.g, s->ink.b, BAND);
    cairo_fill(cr);
}

static void draw_errors(const figure *f, const series *s) {
    const double cap = 0.75 * sp_marker_radius(f->legend > 0.0 ? f->legend : TEXT_LEGEND);
    cairo_t *cr = f->canvas->cr;
    for (int64_t k = 0; k < s->n; k++) {
        if (!isfinite(s->low[k]) || !isfinite(s->high[k]) || !isfinite(s->x[k]))
            continue;
        double x = place_x(f, s, k), low = sp_axis_place(&f->axes.y, s->low[k]),
               high = sp_axis_place(&f->axes.y, s->high[k]);
        cairo_move_to(cr, x, low);
        cairo_line_to(cr, x, high);
        cairo_move_to(cr, x - cap, low);
        cairo_line_to(cr, x + cap, low);
        cairo_move_to(cr, x - cap, high);
        cairo_line_to(cr, x + cap, high);
    }
    sp_canvas_colour(f->canvas, s->ink);
    cairo_set_line_width(cr, 0.7);
    cairo_stroke(cr);
}

/* The frame does not clip markers: those with centres outside are left out. */
static void draw_markers(const figure *f, const series *s) {
    const axis *x = &f->axes.x, *y = &f->axes.y;
    const double slack_x = 1e-9 * (x->high - x->low), slack_y = 1e-9 * (y->high - y->low);
    const double radius = sp_marker_radius(f->legend > 0.0 ? f->legend : TEXT_LEGEND);
    for (int64_t k = 0; k < s->n; k++) {
        if (!isfinite(s->x[k]) || !isfinite(s->y[k]) || s->x[k] < x->low - slack_x || s->x[k] > x->high + slack_x ||
            s->y[k] < y->low - slack_y || s->y[k] > y->high + slack_y)
            continue;
        const double at[2] = {place_x(f, s, k), place_y(f, s, k)};
        sp_marker_draw_sized(f->canvas, s->marker, at, s->open, s->ink, radius);
    }
}

/* ---- the whole ------------------------------------------------------------------------------------------------ */

static void paint_curves(const figure *f) {
    canvas *c = f->canvas;
    cairo_save(c->cr);
    cairo_rectangle(c->cr, f->axes.x.from, f->axes.y.to, f->axes.x.to - f->axes.x.from, f->axes.y.from - f->axes.y.to);
    cairo_clip(c->cr);
    for (int k = 0; k < f->n; k++)
        if (f->series[k].fill_low)
            draw_band(f, &f->series[k]);
    if (f->zero_line) {
        double y = sp_axis_place(&f->axes.y, 0.0);
        sp_canvas_colour(c, (colour){0.6, 0.6, 0.6});
        cairo_set_line_width(c->cr, 0.5);
        cairo_move_to(c->cr, f->axes.x.from, y);
        cairo_line_to(c->cr, f->axes.x.to, y);
        cairo_stroke(c->cr);
    }
    for (int k = 0; k < f->n; k++) {
        if (f->series[k].dash != DASH_NONE)
            draw_line(f, &f->series[k]);
        if (f->series[k].low)
            draw_errors(f, &f->series[k]);
    }
    cairo_restore(c->cr);
}

void sp_figure_paint(const figure *f) {
    paint_curves(f);
    sp_axes_draw(&f->axes, f->canvas);
    for (int k = 0; k < f->n; k++)
        if (f->series[k].marker == MARKER_DOT)
            sp_figure_dots(f, &f->series[k]);
        else if (f->series[k].marker != MARKER_NONE)
            draw_markers(f, &f->series[k]);
}
