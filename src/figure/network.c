/* Draws a packing with its contact network. */
#include "figure/view.h"

#include "base/base.h"
#include "packing/contact.h"

#include <math.h>
#include <sonopack/figure/plot.h>
#include <stdio.h>

/* Line width of a contact of mean strength, and the largest line width [mean diameters]. */
#define MEAN_WIDTH    0.10
#define LARGEST_WIDTH 1.0
#define SLENDER       0.4 /* in three dimensions, where many lines lie behind each other, relative to that */

static colour link_ink(sp_plot_links links) { return sp_figure_ink(links == SP_PLOT_FORCES ? 1 : 2); }

static double contact_value(const sp_packing *p, const sp_contact *k, sp_plot_links links) {
    return links == SP_PLOT_FORCES ? k->fn : contact_kn(p, k);
}

void sp_view_link(const view *v, const sp_contact *k, double width) {
    cairo_t *cr = v->c->cr;
    const sp_packing *p = v->p;
    double reach = p->r[k->i] + (k->j < 0 ? 0.0 : p->r[k->j]) - k->overlap;
    double nx = p->dim == 1 ? 0.0 : k->n[0], ny = k->n[p->dim - 1];
    double x = sp_view_across(v, k->i), y = sp_view_up(v, k->i), ex = x + nx * reach, ey = y + ny * reach;
    const int across = v->periodic ? 1 : 0, up = v->tiled ? 1 : 0;
    cairo_set_line_width(cr, width);
    for (int b = -up; b <= up; b++)
        for (int a = -across; a <= across; a++) {
            const double shift = a * v->width + b * v->slant, rise = b * v->height;
            const bool beside = fmax(x, ex) + shift < v->low || fmin(x, ex) + shift > v->low + v->span;
            const bool beyond = fmax(y, ey) + rise < 0.0 || fmin(y, ey) + rise > v->height;
            if ((a != 0 || b != 0) && (beside || (v->tiled && beyond)))
                continue;
            cairo_move_to(cr, sp_view_x(v, x + shift), sp_view_y(v, y + rise));
            cairo_line_to(cr, sp_view_x(v, ex + shift), sp_view_y(v, ey + rise));
            cairo_stroke(cr);
        }
}

/* The contacts that carry load: their mean value, NAN without contacts, and how wide a line is. */
typedef struct chains {
    const sp_packing *p;
    sp_plot_links links;
    uint8_t *rattler, *carrying;
    int32_t rattlers;
    double mean;
} chains;

static double mean_of(const chains *s) {
    double sum = 0.0, count = 0.0;
    for (int32_t k = 0; k < s->p->n_contacts; k++)
        if (s->carrying[k]) {
            sum += contact_value(s->p, &s->p->contacts[k], s->links);
            count += 1.0;
        }
    return sum > 0.0 ? sum / count : NAN;
}

/* The unit of widths [pt]. */
static double mean_diameter(const view *v) { return v->diameter * v->scale * (v->p->dim == 3 ? SLENDER : 1.0); }

/* Width proportional to the value, MEAN_WIDTH at the mean [pt]. */
static double width_of(const chains *s, const view *v, int32_t k) {
    const double part = contact_value(s->p, &s->p->contacts[k], s->links) / s->mean;
    return fmin(MEAN_WIDTH * part, LARGEST_WIDTH) * mean_diameter(v);
}

static void draw_links(const view *v, const chains *s) {
    sp_canvas_colour(v->c, link_ink(s->links));
    cairo_set_line_cap(v->c->cr, CAIRO_LINE_CAP_ROUND);
    for (int32_t k = 0; k < s->p->n_contacts && s->mean > 0.0; k++)
        if (s->carrying[k])
            sp_view_link(v, &s->p->contacts[k], width_of(s, v, k));
    cairo_set_line_cap(v->c->cr, CAIRO_LINE_CAP_BUTT);
}

/* Key below the bottom wall: the value of a line of mean width, and the grey of rattlers. */
static void draw_key(const view *v, const void *user) {
    const chains *s = user;
    cairo_t *cr = v->c->cr;
    const double x = MARGIN, y = sp_view_line(v, 0);
    char number[64], text[192];
    if (s->mean > 0.0) {
        sp_canvas_colour(v->c, link_ink(s->links));
        cairo_set_line_width(cr, fmax(0.2, MEAN_WIDTH * mean_diameter(v)));
        cairo_move_to(cr, x, y);
        cairo_line_to(cr, x + 17.0, y);
        cairo_stroke(cr);
        sp_figure_text_number(number, sizeof number, s->mean, 3);
        snprintf(text, sizeof text,
                 s->links == SP_PLOT_FORCES ? "mean |F|_{n} = %s |E|*|d|^{2}" : "mean |k|_{n} = %s |E|*|d|", number);
        sp_canvas_colour(v->c, sp_figure_ink(0));
        sp_figure_text_draw(v->c, text, x + 22.0, y, (text_style){TEXT_LEGEND, 0.0, 0.5, 0.0});
    }
    sp_view_count_rattlers(v, 0, s->rattlers);
}

static sp_status draw_flat(const view *v, const chains *s, sp_error *err) {
    colour *fill = sp_alloc((size_t)s->p->n, sizeof *fill);
    if (!fill)
        return sp_fail_memory(err, (size_t)s->p->n * sizeof *fill);
    for (int32_t i = 0; i < s->p->n; i++)
        fill[i] = s->rattler[i] ? RATTLER_GREY : GRAIN_GREY;
    sp_view_begin(v, fill);
    draw_links(v, s);
    sp_view_walls(v);
    sp_view_end(v);
    sp_free(fill);
    return SP_OK;
}

static int32_t make_links(const view *v, const chains *s, view_link *link) {
    const sp_packing *p = s->p;
    int32_t n = 0;
    for (int32_t k = 0; k < p->n_contacts && s->mean > 0.0; k++)
        if (s->carrying[k])
            link[n++] = sp_view_link_of(p, &p->contacts[k], width_of(s, v, k), link_ink(s->links));
    return n;
}

static sp_status draw_solid(const view *v, const chains *s, sp_error *err) {
    view_mark *mark = sp_alloc((size_t)s->p->n, sizeof *mark);
    view_link *link = sp_alloc((size_t)s->p->n_contacts, sizeof *link);
    sp_status status = mark && link ? SP_OK : sp_fail_memory(err, (size_t)s->p->n_contacts * sizeof *link);
    if (status == SP_OK) {
        for (int32_t i = 0; i < s->p->n; i++)
            mark[i] = (view_mark){.fill = s->rattler[i] ? RATTLER_GREY : GRAIN_GREY};
        status = sp_view_draw_solid(v, mark, make_links(v, s, link), link, err);
    }
    sp_free(mark);
    sp_free(link);
    return status;
}

static sp_status draw_view(const view *v, const void *user, sp_error *err) {
    return v->p->dim == 3 ? draw_solid(v, user, err) : draw_flat(v, user, err);
}

static sp_status draw_views(const chains *s, const char *path, sp_error *err) {
    static const char *const titles[] = {"Packing: normal forces", "Packing: normal stiffnesses"};
    canvas c = {0};
    view v[VIEWS] = {0};
    const view_figure what = {titles[s->links != SP_PLOT_FORCES], 1, draw_view, draw_key, s};
    sp_view_make_all(s->p, what.lines, &c, v);
    return sp_view_draw_all(v, &what, path, err);
}

sp_status sp_plot_network(const sp_packing *p, sp_plot_links links, double threshold, const char *path, sp_error *err) {
    chains s = {.p = p, .links = links};
    sp_status status = sp_view_check(p, path, err);
    if (status != SP_OK)
        return status;
    s.rattler = sp_alloc((size_t)p->n, 1);
    s.carrying = sp_alloc((size_t)p->n_contacts, 1);
    if (!s.rattler || !s.carrying)
        status = sp_fail_memory(err, (size_t)p->n + (size_t)p->n_contacts);
    if (status == SP_OK)
        status = sp_packing_rattlers(p, threshold, s.rattler, s.carrying, &s.rattlers, err);
    if (status == SP_OK) {
        s.mean = mean_of(&s);
        status = draw_views(&s, path, err);
    }
    sp_free(s.rattler);
    sp_free(s.carrying);
    return status;
}
