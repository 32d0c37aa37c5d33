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

static colour link_ink(sp_plot_links links) { return sp_figure_ink(links == SP_PLOT_FORCES ? 1 : 2); }

static double contact_value(const sp_packing *p, const sp_contact *k, sp_plot_links links) {
    return links == SP_PLOT_FORCES ? k->fn : contact_kn(p, k);
}

/* Draws a line from centre to centre, or to the wall, along the normal of the contact. A contact across the periodic
 * edge is drawn at both sides. */
static void draw_link(const view *v, const sp_contact *k, double width) {
    cairo_t *cr = v->c->cr;
    const sp_packing *p = v->p;
    double reach = p->r[k->i] + (k->j < 0 ? 0.0 : p->r[k->j]) - k->overlap;
    double nx = p->dim == 1 ? 0.0 : k->n[0], ny = k->n[p->dim - 1];
    double x = sp_view_across(v, k->i), y = sp_view_up(v, k->i), ex = x + nx * reach, ey = y + ny * reach;
    cairo_set_line_width(cr, width);
    for (int image = -1; image <= 1; image++) {
        double shift = image * v->width;
        if (image != 0 && (!v->periodic || (fmax(x, ex) + shift < 0.0 || fmin(x, ex) + shift > v->width)))
            continue;
        cairo_move_to(cr, sp_view_x(v, x + shift), sp_view_y(v, y));
        cairo_line_to(cr, sp_view_x(v, ex + shift), sp_view_y(v, ey));
        cairo_stroke(cr);
    }
}

/* Draws lines of width proportional to the value, MEAN_WIDTH at the mean. Returns the mean; NAN without contacts. */
static double draw_links(const view *v, sp_plot_links links, const uint8_t *carrying) {
    const sp_packing *p = v->p;
    double sum = 0.0, count = 0.0;
    for (int32_t k = 0; k < p->n_contacts; k++)
        if (carrying[k]) {
            sum += contact_value(p, &p->contacts[k], links);
            count += 1.0;
        }
    if (!(sum > 0.0))
        return NAN;
    const double diameter = v->diameter * v->scale;
    sp_canvas_colour(v->c, link_ink(links));
    cairo_set_line_cap(v->c->cr, CAIRO_LINE_CAP_ROUND);
    for (int32_t k = 0; k < p->n_contacts; k++)
        if (carrying[k]) {
            double part = contact_value(p, &p->contacts[k], links) / sum * count;
            draw_link(v, &p->contacts[k], fmin(MEAN_WIDTH * part, LARGEST_WIDTH) * diameter);
        }
    cairo_set_line_cap(v->c->cr, CAIRO_LINE_CAP_BUTT);
    return sum / count;
}

/* Key below the bottom wall: the value of a line of mean width, and the grey of rattlers. */
static void draw_key(const view *v, sp_plot_links links, double mean, int32_t rattlers) {
    cairo_t *cr = v->c->cr;
    const text_style plain = {TEXT_LEGEND, 0.0, 0.5, 0.0};
    double x = MARGIN, y = v->c->height - 0.5 * KEY;
    char number[64], text[192];
    if (mean > 0.0) {
        sp_canvas_colour(v->c, link_ink(links));
        cairo_set_line_width(cr, MEAN_WIDTH * v->diameter * v->scale);
        cairo_move_to(cr, x, y);
        cairo_line_to(cr, x + 17.0, y);
        cairo_stroke(cr);
        sp_figure_text_number(number, sizeof number, mean, 3);
        snprintf(text, sizeof text,
                 links == SP_PLOT_FORCES ? "mean |F|_{n} = %s |E|*|d|^{2}" : "mean |k|_{n} = %s |E|*|d|", number);
        sp_canvas_colour(v->c, sp_figure_ink(0));
        sp_figure_text_draw(v->c, text, x + 22.0, y, plain);
    }
    snprintf(text, sizeof text, rattlers == 1 ? "%d rattler" : "%d rattlers", rattlers);
    x = v->c->width - MARGIN - sp_figure_text_width(v->c, text, TEXT_LEGEND);
    sp_canvas_colour(v->c, sp_figure_ink(0));
    sp_figure_text_draw(v->c, text, x, y, plain);
    cairo_arc(cr, x - 8.0, y, 3.2, 0.0, 6.283185307179586);
    sp_canvas_colour(v->c, RATTLER_GREY);
    cairo_fill_preserve(cr);
    sp_canvas_colour(v->c, RIM_GREY);
    cairo_set_line_width(cr, 0.4);
    cairo_stroke(cr);
}

static sp_status draw(const sp_packing *p, sp_plot_links links, double threshold, const char *path, sp_error *err) {
    canvas c = {0};
    int32_t rattlers;
    uint8_t *rattler = sp_alloc((size_t)p->n, 1), *carrying = sp_alloc((size_t)p->n_contacts, 1);
    colour *fill = sp_alloc((size_t)p->n, sizeof *fill);
    sp_status status = SP_OK;
    if (!rattler || !carrying || !fill)
        status = sp_fail_memory(err, (size_t)p->n * (1 + sizeof *fill) + (size_t)p->n_contacts);
    if (status == SP_OK)
        status = sp_packing_rattlers(p, threshold, rattler, carrying, &rattlers, err);
    if (status != SP_OK)
        goto out;
    for (int32_t i = 0; i < p->n; i++)
        fill[i] = rattler[i] ? RATTLER_GREY : GRAIN_GREY;
    view v = sp_view_make(p, 1);
    v.c = &c;
    status =
        sp_view_open(&v, path, links == SP_PLOT_FORCES ? "Packing: normal forces" : "Packing: normal stiffnesses", err);
    if (status != SP_OK)
        goto out;
    sp_view_begin(&v, fill);
    const double mean = draw_links(&v, links, carrying);
    sp_view_walls(&v);
    sp_view_end(&v);
    draw_key(&v, links, mean, rattlers);
out:
    status = sp_canvas_close(&c, status, err);
    sp_free(fill);
    sp_free(rattler);
    sp_free(carrying);
    return status;
}

sp_status sp_plot_network(const sp_packing *p, sp_plot_links links, double threshold, const char *path, sp_error *err) {
    sp_status status = sp_view_check(p, path, err);
    if (status == SP_OK && p->dim == 3)
        status =
            sp_fail(err, SP_EREFUSED, "%s: a packing in 3 dimensions has no flat picture: must be in 1 or 2", path);
    return status == SP_OK ? draw(p, links, threshold, path, err) : status;
}
