/* Two views of a packing in three dimensions. */
#include "figure/view.h"

#include "base/base.h"
#include "figure/text.h"

#include <math.h>
#include <stdlib.h>

#define GAP   14.0 /* between the views [pt] */
#define STRIP 11.0 /* below the bottom wall, with the names of the axes [pt] */
#define SIZE  0.5  /* of a grain as drawn, over its own */
#define PALE  0.75 /* how much of the colour of the farthest grains is white */

#define TALLEST (22.0 / 2.54 * 72.0)

void sp_view_make_solid(const sp_packing *p, int lines, view v[VIEWS]) {
    const double room = CANVAS_COLUMN - 2.0 * MARGIN - GAP, width = p->box[0] + p->box[1];
    view one = sp_view_make(p, lines);
    one.below += STRIP;
    one.scale = fmin(room / width, (TALLEST - 2.0 * (MARGIN + WALL) - one.below) / one.height);
    one.low = 0.0;
    one.floor = MARGIN + WALL + one.height * one.scale;
    one.left = 0.5 * (CANVAS_COLUMN - width * one.scale - GAP);
    for (int k = 0; k < VIEWS; k++) {
        v[k] = one;
        v[k].axis = k;
        v[k].width = p->box[k];
    }
    v[1].left += p->box[0] * one.scale + GAP;
}

/* With x to the right and z up, y points away from the viewer; with y to the right, x points to the viewer. */
double sp_view_towards(const view *v, const double *vector) { return v->axis == 0 ? -vector[1] : vector[0]; }

/* A grain and its distance from the viewer, 0 .. 1 of the box. */
typedef struct distant {
    double far;
    int32_t grain;
} distant;

static double distance_of(const view *v, int32_t i) {
    const int away = 1 - v->axis;
    const double period = v->p->box[away], x = v->p->x[3 * i + away], part = x / period - floor(x / period);
    return v->axis == 0 ? part : 1 - part;
}

static int farthest_first(const void *a, const void *b) {
    const distant *p = a, *q = b;
    if (p->far != q->far)
        return p->far > q->far ? -1 : 1;
    return (p->grain > q->grain) - (p->grain < q->grain);
}

static colour at_distance(colour ink, double far) { return sp_view_mix(ink, (colour){1, 1, 1}, PALE * far); }

static void draw_grain(const view *v, const distant *d, const view_mark *mark) {
    cairo_t *cr = v->c->cr;
    const double r = SIZE * v->p->r[d->grain], x = sp_view_across(v, d->grain),
                 y = sp_view_y(v, sp_view_up(v, d->grain));
    for (int image = -1; image <= 1; image++) {
        const double at = x + image * v->width;
        if (image != 0 && (at + r < 0.0 || at - r > v->width))
            continue;
        cairo_new_path(cr);
        cairo_arc(cr, sp_view_x(v, at), y, r * v->scale, 0.0, 6.283185307179586);
        sp_canvas_colour(v->c, at_distance(mark->fill, d->far));
        cairo_fill_preserve(cr);
        cairo_set_line_width(cr, fmin(0.4, 0.05 * v->scale));
        sp_canvas_colour(v->c, at_distance(RIM_GREY, d->far));
        cairo_stroke(cr);
    }
}

static void draw_arrow(const view *v, const distant *d, const view_mark *mark) {
    const double x = sp_view_x(v, sp_view_across(v, d->grain)), y = sp_view_y(v, sp_view_up(v, d->grain));
    sp_canvas_colour(v->c, at_distance(mark->ink, d->far));
    cairo_set_line_width(v->c->cr, fmax(0.4, fmin(0.9, 0.08 * v->diameter * v->scale)));
    sp_view_arrow(v, x - mark->from * mark->dx, y - mark->from * mark->dy, mark->dx, mark->dy);
}

/* The axes, as a small cross of arrows below the lower left corner. */
static void name_axes(const view *v) {
    const text_style plain = {TEXT_LEGEND, 0.0, 0.5, 0.0};
    const double x = v->left, y = v->floor + WALL + STRIP - 1.5, arm = 12.0;
    sp_canvas_colour(v->c, sp_figure_ink(0));
    cairo_set_line_width(v->c->cr, 0.6);
    sp_view_arrow(v, x + 1.0, y, arm, 0.0);
    sp_view_arrow(v, x + 1.0, y, 0.0, -8.0);
    sp_figure_text_draw(v->c, v->axis == 0 ? "|x|" : "|y|", x + arm + 4.0, y - 2.0, plain);
    sp_figure_text_draw(v->c, "|z|", x + 4.0, y - 5.5, (text_style){TEXT_SCRIPT, 0.0, 0.5, 0.0});
}

void sp_view_explain_depth(const view *v) {
    const text_style right = {TEXT_LEGEND, 1.0, 0.5, 0.0};
    sp_canvas_colour(v->c, sp_figure_ink(0));
    sp_figure_text_draw(v->c, "far grains pale", v->c->width - MARGIN, sp_view_line(v, 0), right);
}

sp_status sp_view_draw_solid(const view *v, const view_mark *mark, sp_error *err) {
    const int32_t n = v->p->n;
    distant *order = sp_alloc((size_t)n, sizeof *order);
    if (!order)
        return sp_fail_memory(err, (size_t)n * sizeof *order);
    for (int32_t i = 0; i < n; i++)
        order[i] = (distant){distance_of(v, i), i};
    qsort(order, (size_t)n, sizeof *order, farthest_first);
    cairo_save(v->c->cr);
    cairo_rectangle(v->c->cr, v->left, MARGIN, v->width * v->scale, v->floor + WALL - MARGIN);
    cairo_clip(v->c->cr);
    sp_view_walls(v);
    for (int32_t k = 0; k < n; k++)
        draw_grain(v, &order[k], &mark[order[k].grain]);
    for (int32_t k = 0; k < n; k++) /* above all grains: nearer ones would hide heads */
        draw_arrow(v, &order[k], &mark[order[k].grain]);
    cairo_restore(v->c->cr);
    name_axes(v);
    sp_free(order);
    return SP_OK;
}
