#include "plot/figure.h"

#include "base/base.h"
#include "packing/contact.h"

#include <math.h>
#include <sonopack/plot.h>
#include <stdio.h>

/* Where packing and canvas meet. across and up are a grain's coordinates, in diameters d. */
typedef struct view {
    canvas *c;
    const sp_packing *p;
    double scale;              /* pt a diameter */
    double left, floor;        /* of the box's lower left corner [pt] */
    double low, width, height; /* lateral start and width, and height of the box [d] */
    double diameter;           /* mean of the grains [d] */
    bool periodic;
} view;

#define MARGIN  3.0  /* [pt] */
#define WALL    4.0  /* thickness of a wall [pt] */
#define KEY     15.0 /* line of text below the bottom wall [pt] */
#define TALLEST (22.0 / 2.54 * 72.0)
/* The width of a line of mean strength, in mean diameters; and the largest width. */
#define MEAN_WIDTH    0.10
#define LARGEST_WIDTH 1.0

static const colour rattler_grey = {0.72, 0.72, 0.72}, grain_grey = {0.96, 0.96, 0.96}, rim_grey = {0.55, 0.55, 0.55};

static colour link_ink(sp_plot_links links) { return figure_ink(links == SP_PLOT_FORCES ? 1 : 2); }

static double across(const view *v, int32_t i) {
    double x = v->p->dim == 1 ? 0.0 : v->p->x[3 * i];
    return v->periodic ? x - v->width * floor(x / v->width) : x;
}

static double up(const view *v, int32_t i) { return v->p->x[3 * i + v->p->dim - 1]; }

static double canvas_x(const view *v, double x) { return v->left + (x - v->low) * v->scale; }
static double canvas_y(const view *v, double y) { return v->floor - y * v->scale; }

static view make_view(const sp_packing *p) {
    view v = {.p = p, .periodic = p->dim > 1, .height = sp_packing_height(p)};
    double largest = 0.0;
    for (int32_t i = 0; i < p->n; i++) {
        v.diameter += 2.0 * p->r[i] / p->n;
        largest = fmax(largest, p->r[i]);
    }
    v.low = v.periodic ? 0.0 : -1.1 * largest;
    v.width = v.periodic ? p->box[0] : 2.2 * largest;
    v.scale = fmin((CANVAS_COLUMN - 2.0 * MARGIN) / v.width, (TALLEST - 2.0 * (MARGIN + WALL) - KEY) / v.height);
    v.left = 0.5 * (CANVAS_COLUMN - v.width * v.scale);
    v.floor = MARGIN + WALL + v.height * v.scale;
    return v;
}

/* Grains with their images at the periodic edges: rattlers grey. */
static void draw_grains(const view *v, const uint8_t *rattler) {
    cairo_t *cr = v->c->cr;
    cairo_set_line_width(cr, fmin(0.4, 0.05 * v->scale));
    for (int32_t i = 0; i < v->p->n; i++) {
        double r = v->p->r[i], x = across(v, i);
        for (int image = -1; image <= 1; image++) {
            double at = x + image * v->width;
            if (image != 0 && (!v->periodic || at + r < 0.0 || at - r > v->width))
                continue;
            cairo_new_path(cr);
            cairo_arc(cr, canvas_x(v, at), canvas_y(v, up(v, i)), r * v->scale, 0.0, 6.283185307179586);
            canvas_colour(v->c, rattler[i] ? rattler_grey : grain_grey);
            cairo_fill_preserve(cr);
            canvas_colour(v->c, rim_grey);
            cairo_stroke(cr);
        }
    }
}

static double contact_value(const sp_packing *p, const sp_contact *k, sp_plot_links links) {
    if (links == SP_PLOT_FORCES)
        return k->fn;
    double e = k->j < 0 ? contact_wall_stiffness(p->r[k->i], p->wall) : contact_stiffness(p->r[k->i], p->r[k->j]);
    return contact_normal_stiffness(e, fmax(k->overlap, 0.0));
}

/* From centre to centre, or to the wall; along the contact's own normal, so that a contact across the periodic edge
 * points out of the box and is drawn from both sides. */
static void draw_link(const view *v, const sp_contact *k, double width) {
    cairo_t *cr = v->c->cr;
    const sp_packing *p = v->p;
    double reach = p->r[k->i] + (k->j < 0 ? 0.0 : p->r[k->j]) - k->overlap;
    double nx = p->dim == 1 ? 0.0 : k->n[0], ny = k->n[p->dim - 1];
    double x = across(v, k->i), y = up(v, k->i), ex = x + nx * reach, ey = y + ny * reach;
    cairo_set_line_width(cr, width);
    for (int image = -1; image <= 1; image++) {
        double shift = image * v->width;
        if (image != 0 && (!v->periodic || (fmax(x, ex) + shift < 0.0 || fmin(x, ex) + shift > v->width)))
            continue;
        cairo_move_to(cr, canvas_x(v, x + shift), canvas_y(v, y));
        cairo_line_to(cr, canvas_x(v, ex + shift), canvas_y(v, ey));
        cairo_stroke(cr);
    }
}

/* Lines of width proportional to the value, MEAN_WIDTH at the mean; gives that mean, NAN without links. */
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
    canvas_colour(v->c, link_ink(links));
    cairo_set_line_cap(v->c->cr, CAIRO_LINE_CAP_ROUND);
    for (int32_t k = 0; k < p->n_contacts; k++)
        if (carrying[k]) {
            double part = contact_value(p, &p->contacts[k], links) / sum * count;
            draw_link(v, &p->contacts[k], fmin(MEAN_WIDTH * part, LARGEST_WIDTH) * diameter);
        }
    cairo_set_line_cap(v->c->cr, CAIRO_LINE_CAP_BUTT);
    return sum / count;
}

static void draw_walls(const view *v) {
    cairo_t *cr = v->c->cr;
    double left = v->left, width = v->width * v->scale, top = canvas_y(v, v->height);
    canvas_colour(v->c, (colour){0.25, 0.25, 0.25});
    cairo_rectangle(cr, left, top - WALL, width, WALL);
    cairo_rectangle(cr, left, v->floor, width, WALL);
    cairo_fill(cr);
    if (!v->periodic)
        return;
    /* the periodic edges */
    const double dash[2] = {2.0, 2.0};
    cairo_set_dash(cr, dash, 2, 0.0);
    cairo_set_line_width(cr, 0.5);
    cairo_move_to(cr, left, top);
    cairo_line_to(cr, left, v->floor);
    cairo_move_to(cr, left + width, top);
    cairo_line_to(cr, left + width, v->floor);
    cairo_stroke(cr);
    cairo_set_dash(cr, dash, 0, 0.0);
}

/* Below the bottom wall: what a line of mean width stands for, and the grey of rattlers. */
static void draw_key(const view *v, sp_plot_links links, double mean, int32_t rattlers) {
    cairo_t *cr = v->c->cr;
    const text_style plain = {TEXT_LEGEND, 0.0, 0.5, 0.0};
    double x = MARGIN, y = v->c->height - 0.5 * KEY;
    char number[64], text[192];
    if (mean > 0.0) {
        canvas_colour(v->c, link_ink(links));
        cairo_set_line_width(cr, MEAN_WIDTH * v->diameter * v->scale);
        cairo_move_to(cr, x, y);
        cairo_line_to(cr, x + 17.0, y);
        cairo_stroke(cr);
        text_number(number, sizeof number, mean, 3);
        snprintf(text, sizeof text,
                 links == SP_PLOT_FORCES ? "mean |F|_{n} = %s |E|*|d|^{2}" : "mean |k|_{n} = %s |E|*|d|", number);
        canvas_colour(v->c, figure_ink(0));
        text_draw(v->c, text, x + 22.0, y, plain);
    }
    snprintf(text, sizeof text, rattlers == 1 ? "%d rattler" : "%d rattlers", rattlers);
    x = v->c->width - MARGIN - text_width(v->c, text, TEXT_LEGEND);
    canvas_colour(v->c, figure_ink(0));
    text_draw(v->c, text, x, y, plain);
    cairo_arc(cr, x - 8.0, y, 3.2, 0.0, 6.283185307179586);
    canvas_colour(v->c, rattler_grey);
    cairo_fill_preserve(cr);
    canvas_colour(v->c, rim_grey);
    cairo_set_line_width(cr, 0.4);
    cairo_stroke(cr);
}

static sp_status draw(const sp_packing *p, sp_plot_links links, double threshold, const char *path, sp_error *err) {
    canvas c = {0};
    int32_t rattlers;
    uint8_t *rattler = sp_alloc((size_t)p->n, 1), *carrying = sp_alloc((size_t)p->n_contacts, 1);
    sp_status status = SP_OK;
    if (!rattler || !carrying)
        status = sp_fail_memory(err, (size_t)p->n + (size_t)p->n_contacts);
    if (status == SP_OK)
        status = sp_packing_rattlers(p, threshold, rattler, carrying, &rattlers, err);
    if (status != SP_OK)
        goto out;
    view v = make_view(p);
    v.c = &c;
    status = canvas_open(&c, path, links == SP_PLOT_FORCES ? "Packing: normal forces" : "Packing: normal stiffnesses",
                         CANVAS_COLUMN, v.floor + WALL + KEY, err);
    if (status != SP_OK)
        goto out;
    cairo_save(c.cr);
    cairo_rectangle(c.cr, v.left, MARGIN, v.width * v.scale, v.floor + WALL - MARGIN);
    cairo_clip(c.cr);
    draw_grains(&v, rattler);
    double mean = draw_links(&v, links, carrying);
    draw_walls(&v);
    cairo_restore(c.cr);
    draw_key(&v, links, mean, rattlers);
    status = canvas_save(&c, err);
out:
    canvas_free(&c);
    sp_free(rattler);
    sp_free(carrying);
    return status;
}

sp_status sp_plot_network(const sp_packing *p, sp_plot_links links, double threshold, const char *path, sp_error *err) {
    sp_status status = canvas_check(path, err);
    if (status == SP_OK)
        status = sp_packing_check(p, err);
    if (status != SP_OK)
        return status;
    if (p->dim == 3)
        return sp_fail(err, SP_EREFUSED, "%s: a packing in 3 dimensions has no flat picture: must be in 1 or 2", path);
    return draw(p, links, threshold, path, err);
}
