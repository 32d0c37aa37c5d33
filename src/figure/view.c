/* Draws the grains and walls of a packing. */
#include "figure/view.h"
#include "figure/open.h"

#include "base/base.h"
#include "figure/text.h"

#include <math.h>
#include <stdio.h>

#define TALLEST (22.0 / 2.54 * 72.0)

static double height_of(const view *v, int32_t i) {
    return v->p->x[3 * i + v->rise] + (v->shift ? v->shift[3 * i + v->rise] : 0.0);
}

/* Upwards first: in a tilted box the image above lies beside. */
double sp_view_across(const view *v, int32_t i) {
    double x = v->p->dim == 1 ? 0.0 : v->p->x[3 * i + v->axis];
    if (v->shift && v->p->dim > 1)
        x += v->shift[3 * i + v->axis];
    if (v->tiled)
        x -= v->slant * floor(height_of(v, i) / v->height);
    const double start = v->tiled ? v->slant * (sp_view_up(v, i) / v->height) : 0.0;
    return v->periodic ? x - v->width * floor((x - start) / v->width) : x;
}

double sp_view_up(const view *v, int32_t i) {
    const double y = height_of(v, i);
    return v->tiled ? y - v->height * floor(y / v->height) : y;
}

double sp_view_tilt(const sp_packing *p, int across, int rise) {
    return rise > across ? p->tilt[across + rise - 1] : 0.0;
}

double sp_view_x(const view *v, double x) { return v->left + (x - v->low) * v->scale; }
double sp_view_y(const view *v, double y) { return v->floor - y * v->scale; }

view sp_view_make(const sp_packing *p, int lines) {
    view v = {.p = p,
              .periodic = p->dim > 1 && p->cell != SP_CELL_BOX,
              .tiled = p->cell == SP_CELL_PERIODIC,
              .boxed = p->dim > 1 && p->cell == SP_CELL_BOX,
              .height = sp_packing_height(p),
              .rise = p->dim - 1,
              .below = KEY + (lines - 1) * LINE};
    double largest = 0.0;
    for (int32_t i = 0; i < p->n; i++) {
        v.diameter += 2.0 * p->r[i] / p->n;
        largest = fmax(largest, p->r[i]);
    }
    v.slant = p->dim == 2 ? p->tilt[0] : 0.0;
    v.low = p->dim > 1 ? fmin(0.0, v.slant) : -1.1 * largest;
    v.width = p->dim > 1 ? p->box[0] : 2.2 * largest;
    v.span = v.width + fabs(v.slant);
    v.scale = fmin((CANVAS_COLUMN - 2.0 * (MARGIN + (v.boxed ? WALL : 0.0))) / v.span,
                   (TALLEST - 2.0 * (MARGIN + WALL) - v.below) / v.height);
    v.left = 0.5 * (CANVAS_COLUMN - v.span * v.scale);
    v.floor = MARGIN + WALL + v.height * v.scale;
    return v;
}

/* Draws a grain with its centre at (x, y) [d], if it reaches into the frame. */
static void draw_grain(const view *v, double x, double y, double r, colour fill) {
    cairo_t *cr = v->c->cr;
    if (v->periodic && (x + r < v->low || x - r > v->low + v->span))
        return;
    if (v->tiled && (y + r < 0.0 || y - r > v->height))
        return;
    cairo_new_path(cr);
    cairo_arc(cr, sp_view_x(v, x), sp_view_y(v, y), r * v->scale, 0.0, 6.283185307179586);
    sp_canvas_colour(v->c, fill);
    cairo_fill_preserve(cr);
    sp_canvas_colour(v->c, RIM_GREY);
    cairo_stroke(cr);
}

static void draw_grains(const view *v, const colour *fill) {
    const int across = v->periodic ? 1 : 0, up = v->tiled ? 1 : 0;
    cairo_set_line_width(v->c->cr, fmin(0.4, 0.05 * v->scale));
    for (int32_t i = 0; i < v->p->n; i++)
        for (int b = -up; b <= up; b++)
            for (int a = -across; a <= across; a++)
                draw_grain(v, sp_view_across(v, i) + a * v->width + b * v->slant, sp_view_up(v, i) + b * v->height,
                           v->p->r[i], fill[i]);
}

sp_status sp_view_open(const view *v, const char *path, const char *title, sp_error *err) {
    return sp_figure_open(v->c, path, title, CANVAS_COLUMN, v->floor + WALL + v->below, err);
}

void sp_view_begin(const view *v, const colour *fill) {
    cairo_save(v->c->cr);
    sp_view_clip(v);
    draw_grains(v, fill);
}

/* The four corners of a tilted box, as a path. */
static void outline(const view *v) {
    const double corner[4][2] = {{0, 0}, {v->width, 0}, {v->width + v->slant, v->height}, {v->slant, v->height}};
    for (int k = 0; k < 4; k++)
        cairo_line_to(v->c->cr, sp_view_x(v, corner[k][0]), sp_view_y(v, corner[k][1]));
    cairo_close_path(v->c->cr);
}

void sp_view_clip(const view *v) {
    const double top = sp_view_top(v), below = v->tiled ? 0.0 : WALL, beside = v->boxed ? WALL : 0.0;
    if (v->slant != 0)
        outline(v);
    else
        cairo_rectangle(v->c->cr, v->left - beside, top, v->width * v->scale + 2.0 * beside, v->floor + below - top);
    cairo_clip(v->c->cr);
}

void sp_view_end(const view *v) { cairo_restore(v->c->cr); }

void sp_view_walls(const view *v) {
    cairo_t *cr = v->c->cr;
    double left = v->left, width = v->width * v->scale, top = sp_view_y(v, v->height);
    sp_canvas_colour(v->c, (colour){0.25, 0.25, 0.25});
    const double beside = v->boxed ? WALL : 0.0; /* walls overlap at the corners, so that no seam shows */
    if (!v->tiled) {
        cairo_rectangle(cr, left - beside, top - WALL, width + 2.0 * beside, WALL);
        cairo_rectangle(cr, left - beside, v->floor, width + 2.0 * beside, WALL);
        cairo_fill(cr);
    }
    if (v->boxed) {
        cairo_rectangle(cr, left - WALL, top - WALL, WALL, v->floor - top + 2.0 * WALL);
        cairo_rectangle(cr, left + width, top - WALL, WALL, v->floor - top + 2.0 * WALL);
        cairo_fill(cr);
    }
    if (!v->periodic)
        return;
    /* periodic edges */
    const double dash[2] = {2.0, 2.0};
    cairo_set_dash(cr, dash, 2, 0.0);
    cairo_set_line_width(cr, 0.5);
    if (v->slant != 0) {
        outline(v);
        cairo_stroke(cr);
        cairo_set_dash(cr, dash, 0, 0.0);
        return;
    }
    cairo_move_to(cr, left, top);
    cairo_line_to(cr, left, v->floor);
    cairo_move_to(cr, left + width, top);
    cairo_line_to(cr, left + width, v->floor);
    if (v->tiled) {
        cairo_move_to(cr, left, top);
        cairo_line_to(cr, left + width, top);
        cairo_move_to(cr, left, v->floor);
        cairo_line_to(cr, left + width, v->floor);
    }
    cairo_stroke(cr);
    cairo_set_dash(cr, dash, 0, 0.0);
}

void sp_view_arrow(const view *v, double x, double y, double dx, double dy) {
    canvas *c = v->c;
    const double length = hypot(dx, dy), head = fmin(3.6, 0.45 * length);
    if (!(length > 0.15))
        return;
    const double ex = dx / length, ey = dy / length, tip_x = x + dx, tip_y = y + dy;
    cairo_move_to(c->cr, x, y);
    cairo_line_to(c->cr, tip_x - 0.8 * head * ex, tip_y - 0.8 * head * ey);
    cairo_stroke(c->cr);
    cairo_move_to(c->cr, tip_x, tip_y);
    cairo_line_to(c->cr, tip_x - head * ex - 0.42 * head * ey, tip_y - head * ey + 0.42 * head * ex);
    cairo_line_to(c->cr, tip_x - head * ex + 0.42 * head * ey, tip_y - head * ey - 0.42 * head * ex);
    cairo_close_path(c->cr);
    cairo_fill(c->cr);
}

double sp_view_top(const view *v) { return sp_view_y(v, v->height) - (v->tiled ? 0.0 : WALL); }

/* Whether a span of the canvas meets another. */
static bool reaches(double a, double b, double low, double high) { return fmax(a, b) >= low && fmin(a, b) <= high; }

void sp_view_repeat(const view *v, double x, double y, double dx, double dy, view_draw *draw) {
    const double wide = v->width * v->scale, tall = v->height * v->scale, frame = v->span * v->scale, margin = 4.0;
    for (int across = v->periodic ? -1 : 0; across <= (v->periodic ? 1 : 0); across++)
        for (int up = v->tiled ? -1 : 0; up <= (v->tiled ? 1 : 0); up++) { /* downwards on the canvas */
            const double at = x + across * wide - up * v->slant * v->scale, high = y + up * tall;
            const bool seen = reaches(at, at + dx, v->left - margin, v->left + frame + margin) &&
                              (!v->tiled || reaches(high, high + dy, v->floor - tall - margin, v->floor + margin));
            if ((across == 0 && up == 0) || seen)
                draw(v, at, high, dx, dy);
        }
}

/* How far an arrow from x to x + dx must move along itself to stay between low and high, as a part of its length. */
static double way_inside(double x, double dx, double low, double high) {
    const double over = low - fmin(x, x + dx), under = fmax(x, x + dx) - high;
    return dx == 0 ? 0 : over > 0 ? over / dx : under > 0 ? -under / dx : 0;
}

void sp_view_arrow_inside(const view *v, double x, double y, double dx, double dy) {
    const double top = sp_view_y(v, v->height), clear = 1.0;
    if (!v->tiled) {
        const double part = way_inside(y, dy, top + clear, v->floor - clear);
        y += part * dy;
        x += part * dx;
    }
    if (v->boxed) {
        const double part = way_inside(x, dx, v->left + clear, v->left + v->width * v->scale - clear);
        y += part * dy;
        x += part * dx;
    }
    sp_view_repeat(v, x, y, dx, dy, sp_view_arrow);
}

void sp_view_count_rattlers(const view *v, int line, int32_t rattlers) {
    char text[40];
    snprintf(text, sizeof text, rattlers == 1 ? "%d rattler" : "%d rattlers", rattlers);
    const double x = v->c->width - MARGIN - sp_figure_text_width(v->c, text, TEXT_LEGEND), y = sp_view_line(v, line);
    sp_canvas_colour(v->c, sp_figure_ink(0));
    sp_figure_text_draw(v->c, text, x, y, (text_style){TEXT_LEGEND, 0.0, 0.5, 0.0});
    sp_view_disc(v, x - 8.0, y, RATTLER_GREY);
    sp_canvas_colour(v->c, sp_figure_ink(0));
}

double sp_view_line(const view *v, int line) {
    const double last = v->c->height - 0.5 * KEY, lines = floor((v->below - KEY) / LINE);
    return last - (lines - line) * LINE;
}

void sp_view_disc(const view *v, double x, double y, colour ink) {
    cairo_t *cr = v->c->cr;
    cairo_new_path(cr);
    cairo_arc(cr, x, y, 3.2, 0.0, 6.283185307179586);
    sp_canvas_colour(v->c, ink);
    cairo_fill_preserve(cr);
    sp_canvas_colour(v->c, RIM_GREY);
    cairo_set_line_width(cr, 0.4);
    cairo_stroke(cr);
}

colour sp_view_mix(colour a, colour b, double part) {
    return (colour){a.r + part * (b.r - a.r), a.g + part * (b.g - a.g), a.b + part * (b.b - a.b)};
}

sp_status sp_view_check(const sp_packing *p, const char *path, sp_error *err) {
    const sp_status status = sp_canvas_check(path, err);
    return status == SP_OK ? sp_packing_check(p, err) : status;
}

sp_status sp_view_check_field(const sp_packing *p, const sp_network *net, const double *u, const char *of,
                              const char *path, sp_error *err) {
    const sp_status status = sp_view_check(p, path, err);
    if (status != SP_OK)
        return status;
    if (net->n_all != p->n || net->dim != p->dim)
        return sp_fail(err, SP_EINVAL, "a network of %d grains for a packing of %d, must be its own", net->n_all, p->n);
    for (int64_t k = 0; k < sp_network_dofs(net); k++)
        if (!isfinite(u[k]))
            return sp_fail(err, SP_EREFUSED, "displacement %lld%s is not finite", (long long)k, of);
    return SP_OK;
}
