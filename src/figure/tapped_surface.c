/* Draws surfaces y(z, t) of the lattice and the continua side by side, as in Fig. 2 of Blackmore et al. 2011. The
 * colour shows what the height alone does not: the displacement from the first row, or the density. */
#include "figure/open.h"
#include "figure/tapped_table.h"
#include "figure/tapped_view.h"

#include "base/base.h"
#include "figure/look.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { TABLES_MOST = 6, TIMES_MOST = 600, LABELS_MOST = 200, MESH_TIMES = 32, MESH_LABELS = 25, ACROSS = 3 };

#define WIDE 504.0 /* two columns of print and the gap between them [pt] */
#define BAR  33.0  /* height of the colour bar with its ticks [pt] */

typedef struct limits {
    double low, high;
} limits;

typedef struct picture {
    const tapped_table *s;
    surface face;
    double *memory;
} picture;

typedef struct gallery {
    int tables;
    picture of[TABLES_MOST];
    limits t, y, shade, label;
    canvas canvas;
} gallery;

static void widen(limits *l, double value) {
    if (!isfinite(value))
        return;
    l->low = fmin(l->low, value);
    l->high = fmax(l->high, value);
}

/* Index of item k of `shown` items spread evenly over n, including the first and the last. */
static int64_t pick(int64_t n, int shown, int k) { return shown > 1 ? (n - 1) * k / (shown - 1) : 0; }

/* ---- reading ---------------------------------------------------------------------------------------------------- */

static void read_cells(gallery *g, picture *p, const int64_t *row, double *y, double *shade) {
    const tapped_table *s = p->s;
    for (int j = 0; j < p->face.columns; j++) {
        const int particle = (int)p->face.z[j];
        const int tint = s->density >= 0 ? s->density + particle - 1 : -1;
        const double start = sp_table_number(s->table, 0, s->first + particle - 1);
        for (int k = 0; k < p->face.rows; k++) {
            const int64_t at = (int64_t)j * p->face.rows + k;
            y[at] = sp_table_number(s->table, row[k], s->first + particle - 1);
            shade[at] = tint < 0 ? y[at] - start : sp_table_number(s->table, row[k], tint);
            widen(&g->y, y[at]);
            widen(&g->shade, shade[at]);
        }
    }
}

static sp_status read_table(gallery *g, picture *p, sp_error *err) {
    const tapped_table *s = p->s;
    const int64_t all = s->table->rows;
    const int rows = (int)(all < TIMES_MOST ? all : TIMES_MOST);
    const int columns = s->particles < LABELS_MOST ? s->particles : LABELS_MOST;
    const size_t cells = (size_t)rows * (size_t)columns,
                 count = (size_t)all + 2 * (size_t)rows + (size_t)columns + 2 * cells;
    int64_t row[TIMES_MOST];
    if (s->particles < 2)
        return sp_fail(err, SP_EINVAL, "%d particle: a surface needs two or more", s->particles);
    p->memory = sp_alloc(count, sizeof *p->memory);
    if (!p->memory)
        return sp_fail_memory(err, count * sizeof *p->memory);
    double *every = p->memory, *t = every + all, *floor = t + rows, *z = floor + rows, *y = z + columns;
    const sp_status status = sp_tapped_table_abscissa(s, every, err);
    if (status != SP_OK)
        return status;
    for (int k = 0; k < rows; k++) {
        row[k] = pick(all, rows, k);
        t[k] = every[row[k]];
        widen(&g->t, t[k]);
        floor[k] = s->floor >= 0 ? sp_table_number(s->table, row[k], s->floor) : NAN;
        widen(&g->y, floor[k]);
    }
    for (int j = 0; j < columns; j++)
        z[j] = 1 + (double)pick(s->particles, columns, j);
    widen(&g->label, s->particles);
    p->face = (surface){.rows = rows, .columns = columns, .t = t, .z = z, .y = y, .shade = y + cells};
    p->face.floor = s->floor >= 0 ? floor : NULL;
    p->face.every_t = (rows + MESH_TIMES - 1) / MESH_TIMES;
    p->face.every_z = (columns + MESH_LABELS - 1) / MESH_LABELS;
    read_cells(g, p, row, y, y + cells);
    return SP_OK;
}

/* Title of a table: its model, or the name of its file where another table has the same model. */
static void name_table(const gallery *g, int k, char *out, size_t size) {
    static const char *const known[][2] = {{"longwave", "long wave"}, {"bsr", "BSR"}};
    const char *model = sp_table_get_text(g->of[k].s->table, "model");
    char file[130], name[60];
    bool twice = false;
    sp_figure_text_escape(file, sizeof file, g->of[k].s->label ? g->of[k].s->label : "", g->of[k].s->named ? 40 : 24);
    sp_figure_text_escape(name, sizeof name, model ? model : "", 24);
    for (size_t q = 0; model && q < sizeof known / sizeof *known; q++)
        if (strcmp(model, known[q][0]) == 0)
            snprintf(name, sizeof name, "%s", known[q][1]);
    for (int j = 0; j < g->tables && model; j++) {
        const char *other = sp_table_get_text(g->of[j].s->table, "model");
        twice = twice || (j != k && other && strcmp(other, model) == 0);
    }
    if (g->of[k].s->named)
        snprintf(out, size, "%s", file);
    else if (model && !twice)
        snprintf(out, size, "%s", name);
    else
        snprintf(out, size, "%s", g->tables > 1 ? file : name);
}

static sp_status read_all(gallery *g, const tapped_table *s, sp_error *err) {
    sp_status status = SP_OK;
    for (int k = 0; k < g->tables && status == SP_OK; k++) {
        g->of[k].s = &s[k];
        if ((s[k].density >= 0) != (s[0].density >= 0))
            return sp_fail(err, SP_EINVAL, "trajectories and densities have no common scale: must be all of one kind");
        status = read_table(g, &g->of[k], err);
        if (status != SP_OK && g->tables > 1)
            sp_fail_prefix(err, "table %d", k + 1);
    }
    if (status == SP_OK && !(g->y.low <= g->y.high && g->shade.low <= g->shade.high))
        status = sp_fail(err, SP_EREFUSED, "nothing to draw: no position is finite");
    return status;
}

/* Scales the values to the range of the colours. */
static void scale_shades(gallery *g) {
    const bool is_signed = g->of[0].s->density < 0;
    const double most = fmax(fabs(g->shade.low), fabs(g->shade.high));
    const double range = is_signed ? most : g->shade.high - g->shade.low, zero = is_signed ? 0 : g->shade.low;
    for (int k = 0; k < g->tables; k++) {
        surface *f = &g->of[k].face;
        double *shade = g->of[k].memory + (f->shade - g->of[k].memory);
        for (int64_t q = 0; q < (int64_t)f->rows * f->columns; q++)
            shade[q] = range > 0 ? (shade[q] - zero) / range : 0;
        f->is_signed = is_signed;
    }
}

/* ---- drawing ---------------------------------------------------------------------------------------------------- */

/* Draws the colour bar with its axis below. */
static void draw_bar(gallery *g, const char *label) {
    enum { STRIPS = 128 };
    canvas *c = &g->canvas;
    const double wide = fmin(0.6 * c->width, 200), left = 0.5 * (c->width - wide), high = 7, size = TEXT_LEGEND;
    const double most = fmax(fabs(g->shade.low), fabs(g->shade.high));
    const bool is_signed = g->of[0].face.is_signed;
    axes a = {.left = left - 20, .top = c->height - BAR, .width = wide + 40, .height = BAR};
    a.x.size = a.y.size = size;
    sp_axis_linear(&a.y, 0, 1);
    sp_axis_linear(&a.x, g->shade.low, g->shade.high);
    snprintf(a.x.label, sizeof a.x.label, "%s", label);
    sp_axes_layout(&a, c);
    a.x.from = left;
    a.x.to = left + wide;
    for (int k = 0; k < STRIPS; k++) {
        const double value = g->shade.low + (g->shade.high - g->shade.low) * (k + 0.5) / STRIPS;
        sp_canvas_colour(c, is_signed ? sp_scene3_signed_colour(most > 0 ? value / most : 0)
                                      : sp_scene3_colour((k + 0.5) / STRIPS));
        cairo_rectangle(c->cr, left + wide * k / STRIPS, a.top, wide / STRIPS + (k + 1 < STRIPS ? 0.3 : 0), high);
        cairo_fill(c->cr);
    }
    sp_canvas_colour(c, (colour){0, 0, 0});
    cairo_set_line_width(c->cr, 0.6);
    cairo_rectangle(c->cr, left, a.top, wide, high);
    for (int k = 0; k < a.x.ticks; k++) {
        const double x = sp_axis_place(&a.x, a.x.tick[k].at);
        cairo_move_to(c->cr, x, a.top + high);
        cairo_rel_line_to(c->cr, 0, a.x.tick[k].major ? 3 : 1.6);
    }
    cairo_stroke(c->cr);
    for (int k = 0; k < a.x.ticks; k++)
        if (a.x.tick[k].label[0])
            sp_figure_text_draw(c, a.x.tick[k].label, sp_axis_place(&a.x, a.x.tick[k].at), a.top + high + 4.5,
                                (text_style){size, 0.5, 1.0, 0.0});
    sp_figure_text_draw(c, a.x.label, 0.5 * c->width, c->height - 3, (text_style){size, 0.5, 0.0, 0.0});
}

/* Sets the name of an axis with its unit and the power of ten taken out of the tick labels. */
static void name_axis(axis *a, const char *name, const tapped_table *s, int column) {
    char unit[120];
    sp_figure_text_escape(unit, sizeof unit, column >= 0 ? s->table->column[column].unit : "", 24);
    sp_axis_name(a, name, unit);
}

static void draw_panel(gallery *g, int k, double left, double top, double width, double height) {
    const tapped_table *s = g->of[k].s;
    const double size = TEXT_LEGEND, head = 1.6 * size;
    scene3 view = {.c = &g->canvas, .left = left, .top = top + head, .width = width, .height = height - head};
    char title[160], name[140];
    view.letters = size;
    sp_axis_linear(&view.time, g->t.low, g->t.high);
    sp_axis_linear(&view.label, g->label.low, g->label.high);
    sp_axis_linear(&view.height_axis, g->y.low, g->y.high);
    name_axis(&view.time, "|t|", s, s->abscissa);
    name_axis(&view.height_axis, "|y|", s, s->first);
    snprintf(view.label.label, sizeof view.label.label, "particle");
    sp_scene3_layout(&view);
    sp_scene3_draw(&view, &g->of[k].face);
    name_table(g, k, name, sizeof name);
    if (g->tables > 1)
        snprintf(title, sizeof title, "(%c)  %s", 'a' + k, name);
    else
        snprintf(title, sizeof title, "%s", name);
    sp_canvas_colour(&g->canvas, (colour){0, 0, 0});
    sp_figure_text_draw(&g->canvas, title, left + 0.5 * width, top + 3, (text_style){TEXT_LABEL, 0.5, 1.0, 0.0});
}

static sp_status draw_all(gallery *g, const char *path, sp_error *err) {
    const int across = g->tables < ACROSS ? g->tables : g->tables == 4 ? 2 : ACROSS;
    const int down = (g->tables + across - 1) / across;
    const double width = (across == 1 ? 1.25 * CANVAS_COLUMN : WIDE) / across,
                 height = (across == 1 ? 0.80 : 0.74) * width + 20;
    const tapped_table *s = g->of[0].s;
    char label[TAPPED_LABEL];
    sp_status status = sp_figure_open(&g->canvas, path, "Solution surfaces of a tapped column", width * across,
                                      height * down + BAR, err);
    if (status != SP_OK)
        return status;
    for (int k = 0; k < g->tables; k++)
        draw_panel(g, k, k % across * width, (double)(k / across) * height, width, height);
    if (s->density >= 0)
        sp_tapped_axis_label(s, "density |\xcf\x81|", s->density, label);
    else
        sp_tapped_axis_label(s, "|y|(|t|) \xe2\x88\x92 |y|(0)", s->first, label);
    draw_bar(g, label);
    return sp_canvas_save(&g->canvas, err);
}

sp_status sp_tapped_draw_surfaces(int tables, const tapped_table *s, const char *path, sp_error *err) {
    const limits none = {INFINITY, -INFINITY};
    if (sp_look_has_axes())
        return sp_fail(err, SP_EINVAL, "look.x, look.y, look.log: a surface has no flat axes to change");
    gallery *g = sp_alloc(1, sizeof *g);
    if (!g)
        return sp_fail_memory(err, sizeof *g);
    *g = (gallery){.tables = tables, .t = none, .y = none, .shade = none};
    g->label = (limits){s[0].floor >= 0 ? 0 : 1, 0};
    sp_status status = read_all(g, s, err);
    if (status == SP_OK) {
        scale_shades(g);
        status = draw_all(g, path, err);
    }
    for (int k = 0; k < tables; k++)
        sp_free(g->of[k].memory);
    sp_canvas_free(&g->canvas);
    sp_free(g);
    return status;
}
