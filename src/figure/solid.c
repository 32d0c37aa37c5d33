/* Three views of a packing in three dimensions. */
#include "figure/view.h"

#include "base/base.h"
#include "figure/text.h"
#include "packing/geometry.h"

#include <math.h>
#include <stdlib.h>

#define GAP   10.0 /* between the views [pt] */
#define STRIP 11.0 /* below the bottom wall, with the names of the axes [pt] */
#define SIZE  0.5  /* of a grain as drawn, over its own */
#define PALE  0.75 /* how much of the colour of the farthest grains is white */

#define TALLEST (22.0 / 2.54 * 72.0)

/* The axes of a view, the part of the box that it shows, and how tilted that looks. */
static void show_axes(view *v, int across, int rise) {
    v->axis = across;
    v->rise = rise;
    v->above = rise == 1;
    v->tiled = v->p->cell == SP_CELL_PERIODIC || (v->above && v->p->cell == SP_CELL_PISTON);
    v->width = v->p->box[across];
    v->height = v->p->box[rise];
    v->slant = sp_view_tilt(v->p, across, rise);
    v->low = fmin(0.0, v->slant);
    v->span = v->width + fabs(v->slant);
}

void sp_view_make_solid(const sp_packing *p, int lines, view v[VIEWS]) {
    view one = sp_view_make(p, lines);
    const double sides = one.boxed ? 2.0 * WALL : 0.0; /* of one view */
    const double room = CANVAS_COLUMN - 2.0 * MARGIN - GAP - 2.0 * sides;
    one.below += STRIP;
    const double around = 2.0 * MARGIN + 3.0 * WALL + STRIP + GAP + one.below + 0.5 * sides;
    for (int k = 0; k < VIEWS; k++)
        v[k] = one;
    show_axes(&v[0], 0, 2);
    show_axes(&v[1], 1, 2);
    show_axes(&v[2], 0, 1);
    const double width = v[0].span + v[1].span;
    const double scale = fmin(room / fmax(width, v[2].span), (TALLEST - around) / (one.height + p->box[1]));
    for (int k = 0; k < VIEWS; k++) {
        v[k].scale = scale;
        v[k].floor = MARGIN + WALL + one.height * scale;
        v[k].left = 0.5 * (CANVAS_COLUMN - width * scale - GAP - sides);
    }
    v[1].left += v[0].span * scale + GAP + sides;
    v[2].floor += WALL + STRIP + GAP + p->box[1] * scale + 0.5 * sides;
}

/* With x to the right and z up, y points away from the viewer; with y to the right, x points to the viewer; with y up,
 * z does. */
double sp_view_towards(const view *v, const double *vector) {
    return v->above ? vector[2] : v->axis == 0 ? -vector[1] : vector[0];
}

/* A thing and its distance from the viewer, 0 .. 1 of the box. */
typedef struct distant {
    double far;
    int32_t number;
} distant;

/* Of a place at `along' from a grain, in the direction of view. */
static double distance_of(const view *v, int32_t i, double along) {
    const int away = 3 - v->axis - v->rise;
    const double period = away == 2 ? sp_packing_height(v->p) : v->p->box[away], x = v->p->x[3 * i + away] + along;
    double place[3] = {0, 0, 0}, s[3];
    for (int a = 0; a < 3; a++)
        place[a] = v->p->x[3 * i + a];
    sp_packing_fractions(v->p, place, s);
    const bool walls = !sp_packing_periodic(v->p, away);
    const double deep = v->p->cell == SP_CELL_PERIODIC ? s[away] + along / period : x / period;
    const double part = walls ? fmax(0, fmin(1, deep)) : deep - floor(deep);
    return away == 1 ? part : 1 - part;
}

static int farthest_first(const void *a, const void *b) {
    const distant *p = a, *q = b;
    if (p->far != q->far)
        return p->far > q->far ? -1 : 1;
    return (p->number > q->number) - (p->number < q->number);
}

static colour at_distance(colour ink, double far) { return sp_view_mix(ink, (colour){1, 1, 1}, PALE * far); }

static void disc(const view *v, double x, double y, double dx, double dy) {
    const double r = 0.5 * hypot(dx, dy);
    cairo_new_path(v->c->cr);
    cairo_arc(v->c->cr, x + 0.5 * dx, y + 0.5 * dy, r, 0.0, 6.283185307179586);
    cairo_fill_preserve(v->c->cr);
}

static void ring(const view *v, double x, double y, double dx, double dy) {
    cairo_new_path(v->c->cr);
    cairo_arc(v->c->cr, x + 0.5 * dx, y + 0.5 * dy, 0.5 * hypot(dx, dy), 0.0, 6.283185307179586);
    cairo_stroke(v->c->cr);
}

static void stroke(const view *v, double x, double y, double dx, double dy) {
    cairo_move_to(v->c->cr, x, y);
    cairo_line_to(v->c->cr, x + dx, y + dy);
    cairo_stroke(v->c->cr);
}

/* A disc is given to sp_view_repeat as one of its diameters. */
static void draw_grain(const view *v, const distant *d, const view_mark *mark) {
    const double r = SIZE * v->p->r[d->number] * v->scale, half = r * 0.70710678118654752;
    const double x = sp_view_x(v, sp_view_across(v, d->number)) - half,
                 y = sp_view_y(v, sp_view_up(v, d->number)) - half;
    sp_canvas_colour(v->c, at_distance(mark->fill, d->far));
    sp_view_repeat(v, x, y, 2 * half, 2 * half, disc);
    cairo_set_line_width(v->c->cr, fmin(0.4, 0.05 * v->scale));
    sp_canvas_colour(v->c, at_distance(RIM_GREY, d->far));
    sp_view_repeat(v, x, y, 2 * half, 2 * half, ring);
}

static void draw_arrow(const view *v, const distant *d, const view_mark *mark) {
    const double x = sp_view_x(v, sp_view_across(v, d->number)), y = sp_view_y(v, sp_view_up(v, d->number));
    sp_canvas_colour(v->c, at_distance(mark->ink, d->far));
    cairo_set_line_width(v->c->cr, fmax(0.4, fmin(0.9, 0.08 * v->diameter * v->scale)));
    sp_view_arrow_inside(v, x - mark->from * mark->dx, y - mark->from * mark->dy, mark->dx, mark->dy);
}

static void draw_link(const view *v, double far, const view_link *k) {
    sp_canvas_colour(v->c, at_distance(k->ink, far));
    cairo_set_line_width(v->c->cr, k->width);
    sp_view_repeat(v, sp_view_x(v, sp_view_across(v, k->grain)), sp_view_y(v, sp_view_up(v, k->grain)),
                   k->reach[v->axis] * v->scale, -k->reach[v->rise] * v->scale, stroke);
}

/* The axes, as a small cross of arrows below the lower left corner. */
static void name_axes(const view *v) {
    static const char *const names[] = {"|x|", "|y|", "|z|"};
    const text_style plain = {TEXT_LEGEND, 0.0, 0.5, 0.0};
    const double x = v->left, y = v->floor + (v->tiled ? 0.0 : WALL) + STRIP - 1.5, arm = 12.0;
    sp_canvas_colour(v->c, sp_figure_ink(0));
    cairo_set_line_width(v->c->cr, 0.6);
    sp_view_arrow(v, x + 1.0, y, arm, 0.0);
    sp_view_arrow(v, x + 1.0, y, 0.0, -8.0);
    sp_figure_text_draw(v->c, names[v->axis], x + arm + 4.0, y - 2.0, plain);
    sp_figure_text_draw(v->c, names[v->rise], x + 4.0, y - 5.5, (text_style){TEXT_SCRIPT, 0.0, 0.5, 0.0});
}

void sp_view_explain_depth(const view *v, int line) {
    const text_style plain = {TEXT_LEGEND, 0.0, 0.5, 0.0};
    sp_canvas_colour(v->c, sp_figure_ink(0));
    sp_figure_text_draw(v->c, "grains at half their size, far ones pale", MARGIN, sp_view_line(v, line), plain);
}

static void draw_links(const view *v, int32_t links, const view_link *link, distant *order) {
    const int away = 3 - v->axis - v->rise;
    for (int32_t k = 0; k < links; k++)
        order[k] = (distant){distance_of(v, link[k].grain, 0.5 * link[k].reach[away]), k};
    qsort(order, (size_t)links, sizeof *order, farthest_first);
    cairo_set_line_cap(v->c->cr, CAIRO_LINE_CAP_ROUND);
    for (int32_t k = 0; k < links; k++)
        draw_link(v, order[k].far, &link[order[k].number]);
    cairo_set_line_cap(v->c->cr, CAIRO_LINE_CAP_BUTT);
}

sp_status sp_view_draw_solid(const view *v, const view_mark *mark, int32_t links, const view_link *link,
                             sp_error *err) {
    const int32_t n = v->p->n, most = n > links ? n : links;
    distant *order = sp_alloc((size_t)most, sizeof *order);
    if (!order)
        return sp_fail_memory(err, (size_t)most * sizeof *order);
    cairo_save(v->c->cr);
    sp_view_clip(v);
    for (int32_t i = 0; i < n; i++)
        order[i] = (distant){distance_of(v, i, 0), i};
    qsort(order, (size_t)n, sizeof *order, farthest_first);
    for (int32_t k = 0; k < n; k++)
        draw_grain(v, &order[k], &mark[order[k].number]);
    for (int32_t k = 0; k < n; k++) /* above all grains: nearer ones would hide heads */
        draw_arrow(v, &order[k], &mark[order[k].number]);
    draw_links(v, links, link, order);
    sp_view_walls(v);
    cairo_restore(v->c->cr);
    name_axes(v);
    sp_free(order);
    return SP_OK;
}

view_link sp_view_link_of(const sp_packing *p, const sp_contact *k, double width, colour ink) {
    const double reach = p->r[k->i] + (k->j < 0 ? 0.0 : p->r[k->j]) - k->overlap;
    return (view_link){
        .grain = k->i, .reach = {reach * k->n[0], reach * k->n[1], reach * k->n[2]}, .width = width, .ink = ink};
}

/* ---- figures ---------------------------------------------------------------------------------------------------- */

static int views_of(const sp_packing *p) { return p->dim == 3 ? VIEWS : 1; }

void sp_view_make_all(const sp_packing *p, int lines, canvas *c, view v[VIEWS]) {
    const int views = views_of(p);
    if (views > 1)
        sp_view_make_solid(p, lines + 1, v);
    else
        v[0] = sp_view_make(p, lines);
    for (int k = 0; k < views; k++)
        v[k].c = c;
}

sp_status sp_view_draw_all(const view v[VIEWS], const view_figure *f, const char *path, sp_error *err) {
    const int views = views_of(v->p);
    sp_status status = sp_view_open(&v[views - 1], path, f->title, err);
    for (int k = 0; k < views && status == SP_OK; k++)
        status = f->draw(&v[k], f->user, err);
    if (status == SP_OK)
        f->draw_key(&v[0], f->user);
    if (status == SP_OK && views > 1)
        sp_view_explain_depth(&v[0], f->lines);
    return sp_canvas_close(v->c, status, err);
}
