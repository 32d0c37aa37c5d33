/* Draws a packing with what each contact does to a quantity. */
#include "figure/view.h"

#include "base/base.h"

#include <math.h>
#include <sonopack/figure/plot.h>
#include <stdio.h>
#include <stdlib.h>

/* Width of the line of the largest size, and the thinnest line [mean diameters]. Lines grow as the root of the size, as
 * areas of symbols do: the sizes span orders of magnitude. */
#define LARGEST_WIDTH  0.65
#define THINNEST_WIDTH 0.02
#define SLENDER        0.5 /* in three dimensions, where many lines lie behind each other, relative to that */

typedef struct strengths {
    const sp_packing *p;
    const sp_table *t;
    uint8_t *rattler;
    int32_t rattlers;
    double *value;  /* [contacts]; NAN: not in the table */
    int32_t *order; /* [drawn] contacts by ascending size: large ones are drawn last */
    int32_t drawn;
    double largest;
} strengths;

static colour ink_of(double value) { return sp_figure_ink(value > 0 ? 2 : 1); }

static double width_of(const strengths *s, const view *v, double value) {
    const double width = LARGEST_WIDTH * sqrt(fabs(value) / s->largest);
    return fmax(width, THINNEST_WIDTH) * v->diameter * v->scale * (s->p->dim == 3 ? SLENDER : 1);
}

/* ---- the table ------------------------------------------------------------------------------------------------ */

static sp_status read_values(strengths *s, sp_error *err) {
    static const char *const names[] = {"by_kn", "by_kt"};
    const int contact = sp_table_find_column(s->t, "contact");
    const int column[] = {sp_table_find_column(s->t, names[0]), sp_table_find_column(s->t, names[1])};
    if (contact < 0 || (column[0] < 0 && column[1] < 0))
        return sp_fail(err, SP_EINVAL,
                       "no columns contact and by_kn or by_kt, which a table of `sonopack sensitivity "
                       "--by kn,kt' has");
    for (int32_t k = 0; k < s->p->n_contacts; k++)
        s->value[k] = NAN;
    for (int64_t row = 0; row < s->t->rows; row++) {
        const double k = sp_table_number(s->t, row, contact);
        double sum = 0;
        if (!(k >= 0 && k < s->p->n_contacts))
            return sp_fail(err, SP_EINVAL, "contact %g, the packing has %d: the table is of another packing", k,
                           s->p->n_contacts);
        for (int q = 0; q < 2; q++)
            sum += column[q] < 0 ? 0 : sp_table_number(s->t, row, column[q]);
        if (!isfinite(sum))
            return sp_fail(err, SP_EINVAL, "row %lld: must have finite numbers", (long long)row + 1);
        s->value[(int32_t)k] = sum;
        s->largest = fmax(s->largest, fabs(sum));
    }
    return s->largest > 0 ? SP_OK : sp_fail(err, SP_EREFUSED, "all derivatives are 0: there is nothing to draw");
}

/* Sorting needs the values; each thread draws its own figure. */
static _Thread_local const double *sorted;

static int by_size(const void *a, const void *b) {
    const double x = fabs(sorted[*(const int32_t *)a]), y = fabs(sorted[*(const int32_t *)b]);
    if (x != y)
        return x < y ? -1 : 1;
    return *(const int32_t *)a < *(const int32_t *)b ? -1 : 1;
}

static void sort(strengths *s) {
    for (int32_t k = 0; k < s->p->n_contacts; k++)
        if (!isnan(s->value[k]))
            s->order[s->drawn++] = k;
    sorted = s->value;
    qsort(s->order, (size_t)s->drawn, sizeof *s->order, by_size);
}

/* ---- drawing -------------------------------------------------------------------------------------------------- */

static void draw_links(const view *v, const strengths *s) {
    cairo_set_line_cap(v->c->cr, CAIRO_LINE_CAP_ROUND);
    for (int32_t q = 0; q < s->drawn; q++) {
        const int32_t k = s->order[q];
        sp_canvas_colour(v->c, ink_of(s->value[k]));
        sp_view_link(v, &s->p->contacts[k], width_of(s, v, s->value[k]));
    }
    cairo_set_line_cap(v->c->cr, CAIRO_LINE_CAP_BUTT);
}

static double key_line(const view *v, double x, double y, double width, double value, const char *text) {
    cairo_t *cr = v->c->cr;
    sp_canvas_colour(v->c, ink_of(value));
    cairo_set_line_width(cr, width);
    cairo_move_to(cr, x, y);
    cairo_line_to(cr, x + 14.0, y);
    cairo_stroke(cr);
    sp_canvas_colour(v->c, sp_figure_ink(0));
    sp_figure_text_draw(v->c, text, x + 18.0, y, (text_style){TEXT_LEGEND, 0.0, 0.5, 0.0});
    return x + 18.0;
}

/* Below the bottom wall: which colour is which, and the size of the widest line. */
static void draw_key(const view *v, const void *user) {
    const strengths *s = user;
    char number[64], text[192];
    const char *of = sp_table_get_text(s->t, "quantity");
    const double wide = fmin(width_of(s, v, s->largest), 5.0);
    snprintf(text, sizeof text, "stiffer: larger %.40s", of ? of : "quantity");
    key_line(v, MARGIN, sp_view_line(v, 0), wide, 1, text);
    key_line(v, MARGIN, sp_view_line(v, 1), wide, -1, "stiffer: smaller");
    sp_view_count_rattlers(v, 0, s->rattlers);
    sp_figure_text_number(number, sizeof number, s->largest, 3);
    snprintf(text, sizeof text, "widest: %s per ln |k|", number);
    sp_figure_text_draw(v->c, text, v->c->width - MARGIN, sp_view_line(v, 1), (text_style){TEXT_LEGEND, 1.0, 0.5, 0.0});
}

static sp_status draw_flat(const view *v, const strengths *s, sp_error *err) {
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

static sp_status draw_solid(const view *v, const strengths *s, sp_error *err) {
    view_mark *mark = sp_alloc((size_t)s->p->n, sizeof *mark);
    view_link *link = sp_alloc((size_t)s->drawn, sizeof *link);
    sp_status status = mark && link ? SP_OK : sp_fail_memory(err, (size_t)s->drawn * sizeof *link);
    for (int32_t i = 0; i < s->p->n && status == SP_OK; i++)
        mark[i] = (view_mark){.fill = s->rattler[i] ? RATTLER_GREY : GRAIN_GREY};
    for (int32_t q = 0; q < s->drawn && status == SP_OK; q++) {
        const int32_t k = s->order[q];
        link[q] = sp_view_link_of(s->p, &s->p->contacts[k], width_of(s, v, s->value[k]), ink_of(s->value[k]));
    }
    if (status == SP_OK)
        status = sp_view_draw_solid(v, mark, s->drawn, link, err);
    sp_free(mark);
    sp_free(link);
    return status;
}

static sp_status draw_view(const view *v, const void *user, sp_error *err) {
    return v->p->dim == 3 ? draw_solid(v, user, err) : draw_flat(v, user, err);
}

static sp_status draw_views(const strengths *s, const char *path, sp_error *err) {
    canvas c = {0};
    view v[VIEWS] = {0};
    const view_figure what = {"Packing: sensitivity of its contacts", 2, draw_view, draw_key, s};
    sp_view_make_all(s->p, what.lines, &c, v);
    return sp_view_draw_all(v, &what, path, err);
}

sp_status sp_plot_sensitivity(const sp_packing *p, const sp_table *t, double threshold, const char *path,
                              sp_error *err) {
    strengths s = {.p = p, .t = t};
    sp_status status = sp_view_check(p, path, err);
    if (status != SP_OK)
        return status;
    s.rattler = sp_alloc((size_t)p->n, 1);
    s.value = sp_alloc((size_t)p->n_contacts, sizeof *s.value);
    s.order = sp_alloc((size_t)p->n_contacts, sizeof *s.order);
    if (!s.rattler || !s.value || !s.order)
        status = sp_fail_memory(err, (size_t)p->n + 12 * (size_t)p->n_contacts);
    if (status == SP_OK)
        status = sp_packing_rattlers(p, threshold, s.rattler, NULL, &s.rattlers, err);
    if (status == SP_OK)
        status = read_values(&s, err);
    if (status == SP_OK) {
        sort(&s);
        status = draw_views(&s, path, err);
    }
    sp_free(s.rattler);
    sp_free(s.value);
    sp_free(s.order);
    return status;
}
