/* Draws displacements at one time, as in Fig. 3 of Somfai et al. 2005. */
#include "figure/view.h"

#include "base/base.h"
#include "figure/text.h"

#include <math.h>
#include <sonopack/figure/plot.h>
#include <stdio.h>
#include <stdlib.h>

#define TYPICAL 0.70 /* this fraction of the moving grains ... */
#define LENGTH  0.8  /* ... has arrows shorter than this [mean diameters] */
#define LONGEST 1.7  /* longest arrow [mean diameters] */
#define MOVING  0.01 /* least displacement of a moving grain, relative to the largest */
#define CUT     2    /* ink of arrows that were cut */

typedef struct snapshot {
    const sp_network *net;
    const double *u;
    double t;
    double scale; /* arrow length [d] per displacement; 0: nothing moves */
    int32_t cut;  /* number of arrows that were cut */
} snapshot;

static double length_of(const snapshot *s, int32_t i) {
    const double *u = s->u + (int64_t)i * s->net->dof;
    const double flat = s->net->dim == 1 ? fabs(u[0]) : hypot(u[0], u[1]);
    return s->net->dim == 3 ? hypot(flat, u[2]) : flat;
}

static int ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Localized oscillations near the source are much larger than the wave, so the scale follows most of the grains, in all
 * frames together. */
static sp_status choose_scale(const sp_network *net, int frames, const sp_plot_frame *frame, double diameter,
                              double *scale, sp_error *err) {
    const size_t room = (size_t)net->n * (size_t)frames;
    double *length = sp_alloc(room, sizeof *length), largest = 0;
    size_t all = 0, moving = 0;
    *scale = 0;
    if (!length)
        return sp_fail_memory(err, room * sizeof *length);
    for (int k = 0; k < frames; k++) {
        const snapshot s = {.net = net, .u = frame[k].u};
        for (int32_t i = 0; i < net->n; i++) {
            length[all] = length_of(&s, i);
            largest = fmax(largest, length[all++]);
        }
    }
    for (size_t k = 0; k < all; k++)
        if (largest > 0 && length[k] >= MOVING * largest)
            length[moving++] = length[k];
    if (moving > 0) {
        qsort(length, moving, sizeof *length, ascending);
        *scale = LENGTH * diameter / length[(size_t)(TYPICAL * (double)(moving - 1) + 0.5)];
    }
    sp_free(length);
    return SP_OK;
}

static void count_cut(snapshot *s, double diameter) {
    s->cut = 0;
    for (int32_t i = 0; i < s->net->n; i++)
        s->cut += s->scale * length_of(s, i) > LONGEST * diameter;
}

/* Points for each unit of a grain's displacement; arrows that are too long are cut. */
static double arrow_scale(const view *v, const snapshot *s, int32_t i, bool *cut) {
    const double longest = LONGEST * v->diameter, length = s->scale * length_of(s, i);
    *cut = length > longest;
    return s->scale * v->scale * (*cut ? longest / length : 1);
}

static void draw_arrows(const view *v, const snapshot *s) {
    cairo_set_line_width(v->c->cr, fmax(0.4, fmin(0.8, 0.08 * v->diameter * v->scale)));
    for (int pass = 0; pass < 2; pass++) { /* arrows that were cut lie on top */
        sp_canvas_colour(v->c, sp_figure_ink(pass == 0 ? 0 : CUT));
        for (int32_t i = 0; i < s->net->n; i++) {
            const double *u = s->u + (int64_t)i * s->net->dof;
            const int32_t grain = s->net->grain[i];
            bool cut;
            const double scale = arrow_scale(v, s, i, &cut);
            if (cut == (pass == 1))
                sp_view_arrow_inside(v, sp_view_x(v, sp_view_across(v, grain)), sp_view_y(v, sp_view_up(v, grain)),
                                     s->net->dim == 1 ? 0 : scale * u[0], -scale * u[s->net->dim - 1]);
        }
    }
}

/* Key: the time; on a line of its own the length of an arrow, and the colour of arrows that were cut. */
static void draw_key(const view *v, const void *user) {
    const snapshot *s = user;
    const text_style plain = {TEXT_LEGEND, 0.0, 0.5, 0.0};
    const double d = v->diameter * v->scale, y = sp_view_line(v, 1);
    char number[64], text[160];
    sp_figure_text_number(number, sizeof number, s->t, 4);
    snprintf(text, sizeof text, "|t| = %s |d| (|\xcf\x81|/|E|*)^{1/2}", number);
    sp_canvas_colour(v->c, sp_figure_ink(0));
    sp_figure_text_draw(v->c, text, MARGIN, sp_view_line(v, 0), plain);
    if (s->net->rattlers > 0)
        sp_view_count_rattlers(v, 0, s->net->rattlers);
    if (!(s->scale > 0))
        return;
    const double length = d * fmax(1, ceil(10 / d));
    double x = MARGIN;
    cairo_set_line_width(v->c->cr, fmax(0.5, fmin(0.8, 0.08 * d)));
    sp_view_arrow(v, x, y, length, 0);
    sp_figure_text_number(number, sizeof number, length / v->scale / s->scale, 2);
    snprintf(text, sizeof text, "= %s |d|", number);
    sp_figure_text_draw(v->c, text, x + length + 4, y, plain);
    if (s->cut == 0)
        return;
    snprintf(text, sizeof text, "%d longer, cut", s->cut);
    x = v->c->width - MARGIN - sp_figure_text_width(v->c, text, TEXT_LEGEND);
    sp_figure_text_draw(v->c, text, x, y, plain);
    sp_canvas_colour(v->c, sp_figure_ink(CUT));
    sp_view_arrow(v, x - 16, y, 12, 0);
}

static sp_status draw_flat(const view *v, const snapshot *s, sp_error *err) {
    colour *fill = sp_alloc((size_t)s->net->n_all, sizeof *fill);
    if (!fill)
        return sp_fail_memory(err, (size_t)s->net->n_all * sizeof *fill);
    for (int32_t i = 0; i < s->net->n_all; i++)
        fill[i] = RATTLER_GREY;
    for (int32_t i = 0; i < s->net->n; i++)
        fill[s->net->grain[i]] = GRAIN_GREY;
    sp_view_begin(v, fill);
    sp_view_walls(v);
    draw_arrows(v, s);
    sp_view_end(v);
    sp_free(fill);
    return SP_OK;
}

static sp_status draw_solid(const view *v, const snapshot *s, sp_error *err) {
    view_mark *mark = sp_alloc((size_t)s->net->n_all, sizeof *mark);
    if (!mark)
        return sp_fail_memory(err, (size_t)s->net->n_all * sizeof *mark);
    for (int32_t i = 0; i < s->net->n_all; i++)
        mark[i] = (view_mark){.fill = RATTLER_GREY};
    for (int32_t i = 0; i < s->net->n; i++) {
        const double *u = s->u + (int64_t)i * s->net->dof;
        bool cut;
        const double scale = arrow_scale(v, s, i, &cut);
        mark[s->net->grain[i]] = (view_mark){.fill = GRAIN_GREY,
                                             .ink = sp_figure_ink(cut ? CUT : 0),
                                             .dx = scale * u[v->axis],
                                             .dy = -scale * u[v->rise]};
    }
    const sp_status status = sp_view_draw_solid(v, mark, 0, NULL, err);
    sp_free(mark);
    return status;
}

static sp_status draw_view(const view *v, const void *user, sp_error *err) {
    return v->p->dim == 3 ? draw_solid(v, user, err) : draw_flat(v, user, err);
}

static sp_status draw(const sp_packing *p, snapshot *s, const char *path, sp_error *err) {
    canvas c = {0};
    view v[VIEWS] = {0};
    const view_figure what = {"Packing: displacements after a pulse", 2, draw_view, draw_key, s};
    sp_view_make_all(p, what.lines, &c, v);
    count_cut(s, v[0].diameter);
    return sp_view_draw_all(v, &what, path, err);
}

sp_status sp_plot_snapshot_frames(const sp_packing *p, const sp_network *net, int frames, const sp_plot_frame *frame,
                                  sp_error *err) {
    double scale = 0;
    if (frames < 1)
        return sp_fail(err, SP_EINVAL, "%d frames, must be 1 or more", frames);
    sp_status status = SP_OK;
    for (int k = 0; k < frames && status == SP_OK; k++)
        status = sp_view_check_field(p, net, frame[k].u, "", frame[k].path, err);
    if (status == SP_OK)
        status = choose_scale(net, frames, frame, sp_view_make(p, 2).diameter, &scale, err);
    for (int k = 0; k < frames && status == SP_OK; k++) {
        snapshot s = {.net = net, .u = frame[k].u, .t = frame[k].t, .scale = scale};
        status = draw(p, &s, frame[k].path, err);
    }
    return status;
}

sp_status sp_plot_snapshot(const sp_packing *p, const sp_network *net, const double *u, double t, const char *path,
                           sp_error *err) {
    const sp_plot_frame one = {.t = t, .u = u, .path = path};
    return sp_plot_snapshot_frames(p, net, 1, &one, err);
}
