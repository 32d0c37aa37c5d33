/* Draws a packing whose grains are coloured by a column of a table. */
#include "figure/view.h"

#include "base/base.h"

#include <math.h>
#include <sonopack/figure/plot.h>
#include <stdio.h>

/* FACTOR: around 1, on a scale of logarithms. SIGNED: around 0. PART: from 0 upwards. */
typedef enum scale_kind { SCALE_FACTOR = 0, SCALE_SIGNED, SCALE_PART } scale_kind;

static const struct {
    const char *name, *words;
    scale_kind scale;
} columns[] = {{"factor", "factor", SCALE_FACTOR},
               {"probability", "probability", SCALE_PART},
               {"by_mass", "per ln |m|", SCALE_SIGNED},
               {"by_radius", "per ln |R|", SCALE_SIGNED}};
enum { COLUMNS = sizeof columns / sizeof *columns };

typedef struct tints {
    const sp_packing *p;
    uint8_t *rattler;
    int32_t rattlers;
    double *value;  /* [grains] -1 .. 1; NAN: not in the table */
    double largest; /* the value that -1 and 1 stand for; a factor: its logarithm */
    int column;     /* of `columns` */
} tints;

/* ---- the table ------------------------------------------------------------------------------------------------ */

static double on_scale(int column, double value) { return columns[column].scale == SCALE_FACTOR ? log(value) : value; }

static sp_status find_column(const sp_table *t, int *column, int *at, sp_error *err) {
    for (*column = 0; *column < COLUMNS; ++*column)
        if ((*at = sp_table_find_column(t, columns[*column].name)) >= 0)
            return SP_OK;
    return sp_fail(
        err, SP_EINVAL,
        "no column factor, probability, by_mass or by_radius beside that of the grains: such tables come from "
        "`sonopack design --rows grains', `coda' and `sensitivity --by mass'");
}

static sp_status read_values(tints *s, const sp_table *t, sp_error *err) {
    int at = -1;
    const int grain = sp_table_find_column(t, "grain");
    sp_status status = find_column(t, &s->column, &at, err);
    if (status == SP_OK && grain < 0)
        status = sp_fail(err, SP_EINVAL, "no column grain");
    for (int32_t i = 0; i < s->p->n && status == SP_OK; i++)
        s->value[i] = NAN;
    for (int64_t row = 0; row < t->rows && status == SP_OK; row++) {
        const double i = sp_table_number(t, row, grain), value = on_scale(s->column, sp_table_number(t, row, at));
        if (!(i >= 0 && i < s->p->n))
            return sp_fail(err, SP_EINVAL, "grain %g, the packing has %d: the table is of another packing", i, s->p->n);
        if (!isfinite(value))
            return sp_fail(err, SP_EINVAL, "row %lld: must have finite numbers", (long long)row + 1);
        s->value[(int32_t)i] = value;
        s->largest = fmax(s->largest, fabs(value));
    }
    if (status == SP_OK && !(s->largest > 0))
        status = sp_fail(err, SP_EREFUSED, "all grains are alike: there is nothing to draw");
    for (int32_t i = 0; i < s->p->n && status == SP_OK; i++)
        s->value[i] /= s->largest;
    return status;
}

/* ---- drawing -------------------------------------------------------------------------------------------------- */

/* From the light grey of grains to orange above, to blue below. */
static colour tint(double value) { return sp_view_mix(GRAIN_GREY, sp_figure_ink(value > 0 ? 2 : 1), fabs(value)); }

static colour fill_of(const tints *s, int32_t i) {
    if (s->rattler[i])
        return RATTLER_GREY;
    return isnan(s->value[i]) ? (colour)GRAIN_GREY : tint(s->value[i]);
}

/* Squares from the lowest tint to the highest one, and what the ends mean. */
static void draw_key(const view *v, const void *user) {
    const tints *s = user;
    enum { STEPS = 9 };
    cairo_t *cr = v->c->cr;
    char low[64], high[64], text[192];
    const bool part = columns[s->column].scale == SCALE_PART, factor = columns[s->column].scale == SCALE_FACTOR;
    const double side = 7.0, x = MARGIN, y = sp_view_line(v, 0);
    for (int k = 0; k < STEPS; k++) {
        const double value = part ? k / (STEPS - 1.0) : 2.0 * k / (STEPS - 1.0) - 1.0;
        sp_canvas_colour(v->c, tint(value));
        cairo_rectangle(cr, x + side * k, y - 0.5 * side, side, side);
        cairo_fill(cr);
    }
    sp_figure_text_number(low, sizeof low, part ? 0 : factor ? exp(-s->largest) : -s->largest, 3);
    sp_figure_text_number(high, sizeof high, factor ? exp(s->largest) : s->largest, 3);
    snprintf(text, sizeof text, "%s: %s to %s", columns[s->column].words, low, high);
    sp_canvas_colour(v->c, sp_figure_ink(0));
    sp_figure_text_draw(v->c, text, x + side * STEPS + 5.0, y, (text_style){TEXT_LEGEND, 0.0, 0.5, 0.0});
    sp_view_count_rattlers(v, 1, s->rattlers);
}

static sp_status draw_flat(const view *v, const tints *s, sp_error *err) {
    colour *fill = sp_alloc((size_t)s->p->n, sizeof *fill);
    if (!fill)
        return sp_fail_memory(err, (size_t)s->p->n * sizeof *fill);
    for (int32_t i = 0; i < s->p->n; i++)
        fill[i] = fill_of(s, i);
    sp_view_begin(v, fill);
    sp_view_walls(v);
    sp_view_end(v);
    sp_free(fill);
    return SP_OK;
}

static sp_status draw_solid(const view *v, const tints *s, sp_error *err) {
    view_mark *mark = sp_alloc((size_t)s->p->n, sizeof *mark);
    if (!mark)
        return sp_fail_memory(err, (size_t)s->p->n * sizeof *mark);
    for (int32_t i = 0; i < s->p->n; i++)
        mark[i] = (view_mark){.fill = fill_of(s, i)};
    sp_status status = sp_view_draw_solid(v, mark, 0, NULL, err);
    sp_free(mark);
    return status;
}

static sp_status draw_view(const view *v, const void *user, sp_error *err) {
    return v->p->dim == 3 ? draw_solid(v, user, err) : draw_flat(v, user, err);
}

static sp_status draw_views(const tints *s, const char *path, sp_error *err) {
    canvas c = {0};
    view v[VIEWS] = {0};
    const view_figure what = {"Packing: its grains by a column of a table", 2, draw_view, draw_key, s};
    sp_view_make_all(s->p, what.lines, &c, v);
    return sp_view_draw_all(v, &what, path, err);
}

sp_status sp_plot_grains(const sp_packing *p, const sp_table *t, double threshold, const char *path, sp_error *err) {
    tints s = {.p = p};
    sp_status status = sp_view_check(p, path, err);
    if (status != SP_OK)
        return status;
    s.rattler = sp_alloc((size_t)p->n, 1);
    s.value = sp_alloc((size_t)p->n, sizeof *s.value);
    if (!s.rattler || !s.value)
        status = sp_fail_memory(err, 9 * (size_t)p->n);
    if (status == SP_OK)
        status = sp_packing_rattlers(p, threshold, s.rattler, NULL, &s.rattlers, err);
    if (status == SP_OK)
        status = read_values(&s, t, err);
    if (status == SP_OK)
        status = draw_views(&s, path, err);
    sp_free(s.rattler);
    sp_free(s.value);
    return status;
}
