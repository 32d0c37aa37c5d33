/* Draws a mode of vibration, as in Figs. 9 and 10 of Somfai et al. 2005. */
#include "figure/view.h"

#include "base/base.h"

#include <math.h>
#include <sonopack/figure/plot.h>
#include <stdio.h>

/* Two inks whose tints show the direction of rotation. */
static colour turn_ink(bool anticlockwise) { return sp_figure_ink(anticlockwise ? 5 : 6); }

typedef struct motion {
    const sp_network *net;
    const double *u;
    double largest, turn; /* largest translation, and largest rotation times radius */
} motion;

static double translation(const motion *m, int32_t i) {
    const double *u = m->u + (int64_t)i * m->net->dof;
    return m->net->dim == 1 ? fabs(u[0]) : hypot(u[0], u[1]);
}

static double turning(const motion *m, int32_t i) {
    return m->net->dof == 3 ? m->net->r[i] * m->u[(int64_t)i * 3 + 2] : 0;
}

static colour mix(colour a, colour b, double part) {
    return (colour){a.r + part * (b.r - a.r), a.g + part * (b.g - a.g), a.b + part * (b.b - a.b)};
}

/* Tints each grain by its rotation, relative to the largest translation or rotation. */
static void choose_colours(const motion *m, colour *fill) {
    const double most = fmax(m->turn, m->largest);
    for (int32_t i = 0; i < m->net->n_all; i++)
        fill[i] = RATTLER_GREY;
    for (int32_t i = 0; i < m->net->n; i++) {
        const double t = most > 0 ? turning(m, i) / most : 0;
        fill[m->net->grain[i]] = mix((colour){1, 1, 1}, turn_ink(t > 0), fmin(1, fabs(t)));
    }
}

/* The longest arrow is 1.5 diameters. An arrow is centred on its grain, so that it hides less of the neighbours. */
static void draw_arrows(const view *v, const motion *m) {
    const double longest = (m->net->dim == 1 ? 0.9 : 1.5) * v->diameter * v->scale;
    const double scale = m->largest > 0 ? longest / m->largest : 0;
    sp_canvas_colour(v->c, sp_figure_ink(0));
    cairo_set_line_width(v->c->cr, fmax(0.4, fmin(0.9, 0.1 * v->diameter * v->scale)));
    for (int32_t i = 0; i < m->net->n; i++) {
        const double *u = m->u + (int64_t)i * m->net->dof;
        const double dx = m->net->dim == 1 ? 0 : scale * u[0], dy = -scale * u[m->net->dim - 1];
        const int32_t grain = m->net->grain[i];
        sp_view_arrow(v, sp_view_x(v, sp_view_across(v, grain)) - 0.5 * dx,
                      sp_view_y(v, sp_view_up(v, grain)) - 0.5 * dy, dx, dy);
    }
}

static void disc(canvas *c, double x, double y, colour ink) {
    cairo_new_path(c->cr);
    cairo_arc(c->cr, x, y, 3.2, 0.0, 6.283185307179586);
    sp_canvas_colour(c, ink);
    cairo_fill_preserve(c->cr);
    sp_canvas_colour(c, RIM_GREY);
    cairo_set_line_width(c->cr, 0.4);
    cairo_stroke(c->cr);
}

/* Key below the bottom wall: the mode, and the meaning of the tints. */
static void draw_key(const view *v, const motion *m, int64_t number, double omega) {
    const text_style plain = {TEXT_LEGEND, 0.0, 0.5, 0.0};
    const double y = v->c->height - 0.5 * KEY;
    char value[64], text[192];
    sp_figure_text_number(value, sizeof value, omega, 4);
    snprintf(text, sizeof text, "|n| = %lld,  |\xcf\x89| = %s", (long long)number, value);
    sp_canvas_colour(v->c, sp_figure_ink(0));
    sp_figure_text_draw(v->c, text, MARGIN, y, plain);
    if (!(m->turn > 0) || v->c->width < 150)
        return;
    static const char *const words[] = {"turns left", "right"};
    double x = v->c->width - MARGIN;
    for (int k = 1; k >= 0; k--) {
        x -= sp_figure_text_width(v->c, words[k], TEXT_LEGEND);
        sp_canvas_colour(v->c, sp_figure_ink(0));
        sp_figure_text_draw(v->c, words[k], x, y, plain);
        x -= 8.0;
        disc(v->c, x, y, turn_ink(k == 0));
        x -= 10.0;
    }
}

static sp_status draw(const sp_packing *p, motion *m, int64_t number, double omega, const char *path, sp_error *err) {
    canvas c = {0};
    colour *fill = sp_alloc((size_t)p->n, sizeof *fill);
    if (!fill)
        return sp_fail_memory(err, (size_t)p->n * sizeof *fill);
    view v = sp_view_make(p);
    v.c = &c;
    sp_status status = sp_view_open(&v, path, "Packing: displacements of a mode", err);
    if (status == SP_OK) {
        choose_colours(m, fill);
        sp_view_begin(&v, fill);
        sp_view_walls(&v);
        draw_arrows(&v, m);
        sp_view_end(&v);
        draw_key(&v, m, number, omega);
    }
    status = sp_canvas_close(&c, status, err);
    sp_free(fill);
    return status;
}

sp_status sp_plot_mode(const sp_packing *p, const sp_network *net, const double *u, int64_t number, double omega,
                       const char *path, sp_error *err) {
    motion m = {.net = net, .u = u};
    const sp_status status = sp_view_check_field(p, net, u, " of the mode", path, err);
    if (status != SP_OK)
        return status;
    for (int32_t i = 0; i < net->n; i++) {
        m.largest = fmax(m.largest, translation(&m, i));
        m.turn = fmax(m.turn, fabs(turning(&m, i)));
    }
    return draw(p, &m, number, omega, path, err);
}
