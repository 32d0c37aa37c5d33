/* Draws displacements at one time, as in Fig. 3 of Somfai et al. 2005. */
#include "figure/view.h"

#include "base/base.h"

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
    double scale; /* arrow length [d] per displacement; 0: nothing moves */
    int32_t cut;  /* number of arrows that were cut */
} snapshot;

static double length_of(const snapshot *s, int32_t i) {
    const double *u = s->u + (int64_t)i * s->net->dof;
    return s->net->dim == 1 ? fabs(u[0]) : hypot(u[0], u[1]);
}

static int ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Localized oscillations near the source are much larger than the wave, so the scale follows most of the grains. */
static sp_status choose_scale(snapshot *s, double diameter, sp_error *err) {
    double *length = sp_alloc((size_t)s->net->n, sizeof *length), largest = 0;
    if (!length)
        return sp_fail_memory(err, (size_t)s->net->n * sizeof *length);
    size_t moving = 0;
    for (int32_t i = 0; i < s->net->n; i++)
        largest = fmax(largest, length_of(s, i));
    for (int32_t i = 0; i < s->net->n; i++)
        if (largest > 0 && length_of(s, i) >= MOVING * largest)
            length[moving++] = length_of(s, i);
    if (moving > 0) {
        qsort(length, moving, sizeof *length, ascending);
        s->scale = LENGTH * diameter / length[(size_t)(TYPICAL * (double)(moving - 1) + 0.5)];
        for (size_t k = 0; k < moving; k++)
            s->cut += s->scale * length[k] > LONGEST * diameter;
    }
    sp_free(length);
    return SP_OK;
}

static void draw_arrows(const view *v, const snapshot *s) {
    const double longest = LONGEST * v->diameter;
    cairo_set_line_width(v->c->cr, fmax(0.4, fmin(0.8, 0.08 * v->diameter * v->scale)));
    for (int pass = 0; pass < 2; pass++) { /* arrows that were cut lie on top */
        sp_canvas_colour(v->c, sp_figure_ink(pass == 0 ? 0 : CUT));
        for (int32_t i = 0; i < s->net->n; i++) {
            const double *u = s->u + (int64_t)i * s->net->dof, length = s->scale * length_of(s, i);
            if ((length > longest) != (pass == 1))
                continue;
            const double scale = s->scale * v->scale * (length > longest ? longest / length : 1);
            const double dx = s->net->dim == 1 ? 0 : scale * u[0], dy = -scale * u[s->net->dim - 1];
            const int32_t grain = s->net->grain[i];
            sp_view_arrow(v, sp_view_x(v, sp_view_across(v, grain)), sp_view_y(v, sp_view_up(v, grain)), dx, dy);
        }
    }
}

/* Key: the time, the length of an arrow, and the colour of arrows that were cut. */
static void draw_key(const view *v, const snapshot *s, double t) {
    const text_style plain = {TEXT_LEGEND, 0.0, 0.5, 0.0};
    const double y = v->c->height - 0.5 * KEY, d = v->diameter * v->scale;
    char number[64], text[160];
    sp_figure_text_number(number, sizeof number, t, 4);
    snprintf(text, sizeof text, "|t| = %s", number);
    sp_canvas_colour(v->c, sp_figure_ink(0));
    sp_figure_text_draw(v->c, text, MARGIN, y, plain);
    double x = MARGIN + sp_figure_text_width(v->c, text, TEXT_LEGEND) + 14;
    if (!(s->scale > 0) || v->c->width < 150)
        return;
    const double length = d * fmax(1, ceil(10 / d));
    cairo_set_line_width(v->c->cr, fmax(0.5, fmin(0.8, 0.08 * d)));
    sp_view_arrow(v, x, y, length, 0);
    sp_figure_text_number(number, sizeof number, length / v->scale / s->scale, 2);
    snprintf(text, sizeof text, "= %s", number);
    sp_figure_text_draw(v->c, text, x + length + 4, y, plain);
    if (s->cut == 0)
        return;
    snprintf(text, sizeof text, "%d longer, cut", s->cut);
    x = v->c->width - MARGIN - sp_figure_text_width(v->c, text, TEXT_LEGEND);
    sp_figure_text_draw(v->c, text, x, y, plain);
    sp_canvas_colour(v->c, sp_figure_ink(CUT));
    sp_view_arrow(v, x - 16, y, 12, 0);
}

static sp_status draw(const sp_packing *p, snapshot *s, double t, const char *path, sp_error *err) {
    canvas c = {0};
    view v = sp_view_make(p);
    colour *fill = sp_alloc((size_t)p->n, sizeof *fill);
    sp_status status = fill ? choose_scale(s, v.diameter, err) : sp_fail_memory(err, (size_t)p->n * sizeof *fill);
    v.c = &c;
    if (status == SP_OK)
        status = sp_view_open(&v, path, "Packing: displacements after a pulse", err);
    if (status == SP_OK) {
        for (int32_t i = 0; i < p->n; i++)
            fill[i] = RATTLER_GREY;
        for (int32_t i = 0; i < s->net->n; i++)
            fill[s->net->grain[i]] = GRAIN_GREY;
        sp_view_begin(&v, fill);
        sp_view_walls(&v);
        draw_arrows(&v, s);
        sp_view_end(&v);
        draw_key(&v, s, t);
    }
    status = sp_canvas_close(&c, status, err);
    sp_free(fill);
    return status;
}

sp_status sp_plot_snapshot(const sp_packing *p, const sp_network *net, const double *u, double t, const char *path,
                           sp_error *err) {
    snapshot s = {.net = net, .u = u};
    const sp_status status = sp_view_check_field(p, net, u, "", path, err);
    if (status != SP_OK)
        return status;
    return draw(p, &s, t, path, err);
}
