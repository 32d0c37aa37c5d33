/* Draws a mode of vibration, as in Figs. 9 and 10 of Somfai et al. 2005. */
#include "figure/view.h"

#include "base/base.h"
#include "figure/text.h"

#include <math.h>
#include <sonopack/figure/plot.h>
#include <stdio.h>

#define LONGEST  1.5 /* longest arrow [mean diameters] */
#define FARTHEST 0.5 /* how far a grain moves in a movie, over the length of its arrow */

/* Two inks whose tints show the direction of rotation, a light and a dark one. */
static colour turn_ink(bool counterclockwise) { return sp_figure_ink(counterclockwise ? 5 : 1); }

typedef struct motion {
    const sp_network *net;
    const double *u;
    double largest, turn; /* largest translation, and largest rotation times radius */
    int64_t number;
    double omega;
    double swing;  /* u is shown times this */
    double part;   /* of the period that has passed; < 0: no movie */
    double *shift; /* [n_all][3] of grains that move [d]; NULL: they rest */
} motion;

static const double *of_grain(const motion *m, int32_t i) { return m->u + (int64_t)i * m->net->dof; }

static double translation(const motion *m, int32_t i) {
    const double *u = of_grain(m, i);
    const double flat = m->net->dim == 1 ? fabs(u[0]) : hypot(u[0], u[1]);
    return m->net->dim == 3 ? hypot(flat, u[2]) : flat;
}

/* Rotation times radius, positive counterclockwise, as it is seen in the view. */
static double turning(const motion *m, const view *v, int32_t i) {
    const double *u = of_grain(m, i);
    if (m->net->dof == 6)
        return m->net->r[i] * sp_view_towards(v, u + 3);
    return m->net->dim == 2 && m->net->dof == 3 ? m->net->r[i] * u[2] : 0;
}

/* Size of the rotation times radius, about any axis. */
static double turned(const motion *m, int32_t i) {
    const double *u = of_grain(m, i);
    if (m->net->dof == 6)
        return m->net->r[i] * hypot(hypot(u[3], u[4]), u[5]);
    return m->net->dim == 2 && m->net->dof == 3 ? m->net->r[i] * fabs(u[2]) : 0;
}

/* White, tinted by the rotation relative to the largest translation or rotation. */
static colour tint(const motion *m, const view *v, int32_t i) {
    const double most = fmax(m->turn, m->largest), t = most > 0 ? m->swing * turning(m, v, i) / most : 0;
    return sp_view_mix((colour){1, 1, 1}, turn_ink(t > 0), fmin(1, fabs(t)));
}

static void choose_colours(const motion *m, const view *v, colour *fill) {
    for (int32_t i = 0; i < m->net->n_all; i++)
        fill[i] = RATTLER_GREY;
    for (int32_t i = 0; i < m->net->n; i++)
        fill[m->net->grain[i]] = tint(m, v, i);
}

/* Points for each unit of translation. */
static double arrow_scale(const motion *m, const view *v) {
    const double longest = (m->net->dim == 1 ? 0.9 : LONGEST) * v->diameter * v->scale;
    return m->largest > 0 ? m->swing * longest / m->largest : 0;
}

/* An arrow is centred on its grain, so that it hides less of the neighbours. */
static void draw_arrows(const view *v, const motion *m) {
    const double scale = arrow_scale(m, v);
    sp_canvas_colour(v->c, sp_figure_ink(0));
    cairo_set_line_width(v->c->cr, fmax(0.4, fmin(0.9, 0.1 * v->diameter * v->scale)));
    for (int32_t i = 0; i < m->net->n; i++) {
        const double *u = of_grain(m, i);
        const double dx = m->net->dim == 1 ? 0 : scale * u[0], dy = -scale * u[m->net->dim - 1];
        const int32_t grain = m->net->grain[i];
        sp_view_arrow_inside(v, sp_view_x(v, sp_view_across(v, grain)) - 0.5 * dx,
                             sp_view_y(v, sp_view_up(v, grain)) - 0.5 * dy, dx, dy);
    }
}

/* Writes the mode, in smaller letters where the number of rattlers stands on the same line. */
static void draw_name(const view *v, const char *text, int32_t rattlers) {
    char count[40];
    snprintf(count, sizeof count, "%d rattlers", rattlers);
    const double taken = rattlers > 0 ? sp_figure_text_width(v->c, count, TEXT_LEGEND) + 20.0 : 0.0;
    const double room = v->c->width - 2 * MARGIN - taken, wide = sp_figure_text_width(v->c, text, TEXT_LEGEND);
    sp_canvas_colour(v->c, sp_figure_ink(0));
    sp_figure_text_draw(v->c, text, MARGIN, sp_view_line(v, 0),
                        (text_style){TEXT_LEGEND * fmin(1.0, fmax(0.7, room / wide)), 0.0, 0.5, 0.0});
}

/* Key below the bottom wall: the mode, and on a line of its own the meaning of the tints. */
static void draw_key(const view *v, const void *user) {
    const motion *m = user;
    const text_style plain = {TEXT_LEGEND, 0.0, 0.5, 0.0};
    char value[64], text[256];
    sp_figure_text_number(value, sizeof value, m->omega, 4);
    const int length = snprintf(text, sizeof text, "|n| = %lld,  |\xcf\x89| = %s (|E|*/|\xcf\x81|)^{1/2}/|d|",
                                (long long)m->number, value);
    if (m->part >= 0)
        snprintf(text + length, sizeof text - (size_t)length, ",  |t| = %.2f |T|", m->part);
    draw_name(v, text, m->net->dim < 3 ? m->net->rattlers : 0);
    if (m->net->rattlers > 0) /* a text of the first line leaves no room in a movie of three dimensions */
        sp_view_count_rattlers(v, m->net->dim == 3 ? 1 + (m->turn > 0) : 0, m->net->rattlers);
    if (!(m->turn > 0))
        return;
    static const char *const words[] = {"counterclockwise", "clockwise"};
    double x = MARGIN;
    sp_figure_text_draw(v->c, "rotation:", x, sp_view_line(v, 1), plain);
    x += sp_figure_text_width(v->c, "rotation:", TEXT_LEGEND) + 10.0;
    for (int k = 0; k < 2; k++) {
        sp_view_disc(v, x, sp_view_line(v, 1), turn_ink(k == 0));
        sp_canvas_colour(v->c, sp_figure_ink(0));
        sp_figure_text_draw(v->c, words[k], x + 7.0, sp_view_line(v, 1), plain);
        x += sp_figure_text_width(v->c, words[k], TEXT_LEGEND) + 22.0;
    }
}

static sp_status draw_flat(const view *v, const motion *m, sp_error *err) {
    colour *fill = sp_alloc((size_t)m->net->n_all, sizeof *fill);
    if (!fill)
        return sp_fail_memory(err, (size_t)m->net->n_all * sizeof *fill);
    choose_colours(m, v, fill);
    sp_view_begin(v, fill);
    sp_view_walls(v);
    draw_arrows(v, m);
    sp_view_end(v);
    sp_free(fill);
    return SP_OK;
}

static sp_status draw_solid(const view *v, const motion *m, sp_error *err) {
    const double scale = arrow_scale(m, v);
    view_mark *mark = sp_alloc((size_t)m->net->n_all, sizeof *mark);
    if (!mark)
        return sp_fail_memory(err, (size_t)m->net->n_all * sizeof *mark);
    for (int32_t i = 0; i < m->net->n_all; i++)
        mark[i] = (view_mark){.fill = RATTLER_GREY};
    for (int32_t i = 0; i < m->net->n; i++) {
        const double *u = of_grain(m, i);
        mark[m->net->grain[i]] = (view_mark){.fill = tint(m, v, i),
                                             .ink = sp_figure_ink(0),
                                             .dx = scale * u[v->axis],
                                             .dy = -scale * u[v->rise],
                                             .from = 0.5};
    }
    const sp_status status = sp_view_draw_solid(v, mark, 0, NULL, err);
    sp_free(mark);
    return status;
}

/* Moves the grains along their arrows. */
static void move_grains(const view *v, const motion *m) {
    const double scale = FARTHEST * arrow_scale(m, v) / v->scale;
    for (int32_t i = 0; i < m->net->n; i++)
        for (int a = 0; a < m->net->dim; a++)
            m->shift[3 * m->net->grain[i] + a] = scale * of_grain(m, i)[a];
}

static sp_status draw_view(const view *v, const void *user, sp_error *err) {
    return v->p->dim == 3 ? draw_solid(v, user, err) : draw_flat(v, user, err);
}

static sp_status draw(const sp_packing *p, const motion *m, const char *path, sp_error *err) {
    canvas c = {0};
    view v[VIEWS] = {0};
    const view_figure what = {"Packing: displacements of a mode", 1 + (m->turn > 0), draw_view, draw_key, m};
    sp_view_make_all(p, what.lines, &c, v);
    for (int k = 0; k < VIEWS; k++)
        v[k].shift = m->shift;
    if (m->shift)
        move_grains(&v[0], m);
    return sp_view_draw_all(v, &what, path, err);
}

static motion begin(const sp_network *net, const double *u, int64_t number, double omega) {
    motion m = {.net = net, .u = u, .number = number, .omega = omega, .swing = 1, .part = -1};
    for (int32_t i = 0; i < net->n; i++) {
        m.largest = fmax(m.largest, translation(&m, i));
        m.turn = fmax(m.turn, turned(&m, i));
    }
    return m;
}

sp_status sp_plot_mode(const sp_packing *p, const sp_network *net, const double *u, int64_t number, double omega,
                       const char *path, sp_error *err) {
    const sp_status status = sp_view_check_field(p, net, u, " of the mode", path, err);
    if (status != SP_OK)
        return status;
    const motion m = begin(net, u, number, omega);
    return draw(p, &m, path, err);
}

sp_status sp_plot_mode_frames(const sp_packing *p, const sp_network *net, const double *u, int64_t number, double omega,
                              int frames, const char *const *path, sp_error *err) {
    if (frames < 1)
        return sp_fail(err, SP_EINVAL, "%d frames, must be 1 or more", frames);
    sp_status status = sp_view_check_field(p, net, u, " of the mode", path[0], err);
    if (status != SP_OK)
        return status;
    motion m = begin(net, u, number, omega);
    m.shift = sp_alloc((size_t)p->n, 3 * sizeof *m.shift);
    if (!m.shift)
        return sp_fail_memory(err, (size_t)p->n * 3 * sizeof *m.shift);
    for (int k = 0; k < frames && status == SP_OK; k++) {
        m.part = (double)k / frames;
        m.swing = cos(6.283185307179586 * m.part);
        status = draw(p, &m, path[k], err);
    }
    sp_free(m.shift);
    return status;
}
