/* One point for each row, one symbol for each method, and the frontier of the fastest runs at each error. */
#include "base/base.h"
#include "figure/figure.h"

#include <math.h>
#include <sonopack/figure/plot.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { METHODS_MAX = 28 };
/* Smaller errors are rounding errors. */
#define LOG_LEAST (-17.0)

/* One row of the case: logarithms of error and time. */
typedef struct point {
    double error, seconds;
    int method;
} point;

typedef struct clouds {
    int n, methods;
    point *point;                    /* [n] sorted by error, then by time */
    const char *method[METHODS_MAX]; /* in the order of the table */
    double *x, *y;                   /* [n] grouped by method */
    double *edge_x, *edge_y;         /* [2 n + 1] frontier as a staircase */
    int edges;
} clouds;

static void clouds_free(clouds *c) {
    sp_free(c->point);
    sp_free(c->x);
}

static int by_error(const void *a, const void *b) {
    const point *p = a, *q = b;
    if (p->error != q->error)
        return p->error < q->error ? -1 : 1;
    return (p->seconds > q->seconds) - (p->seconds < q->seconds);
}

/* Methods of other programs have names "PROGRAM METHOD". */
static bool is_rival(const char *method) { return strchr(method, ' ') != NULL; }
/* `auto' selects one of the other methods. */
static bool is_choice(const char *method) { return strcmp(method, "auto") == 0; }

static sp_status method_of(clouds *c, const char *name, int *out, sp_error *err) {
    for (int k = 0; k < c->methods; k++)
        if (strcmp(c->method[k], name) == 0) {
            *out = k;
            return SP_OK;
        }
    if (c->methods == METHODS_MAX)
        return sp_fail(err, SP_EREFUSED, "more than %d methods in one figure", METHODS_MAX);
    c->method[c->methods] = name;
    *out = c->methods++;
    return SP_OK;
}

typedef struct columns {
    int name, method, seconds, error;
} columns;

static sp_status find_columns(const sp_table *t, columns *at, sp_error *err) {
    *at = (columns){sp_table_find_column(t, "case"), sp_table_find_column(t, "method"),
                    sp_table_find_column(t, "seconds"), sp_table_find_column(t, "error")};
    if (at->name < 0 || at->method < 0 || at->seconds < 0 || at->error < 0)
        return sp_fail(err, SP_EINVAL, "the table lacks one of the columns case, method, seconds, error of a bench");
    if (t->column[at->name].kind != SP_CELL_TEXT || t->column[at->method].kind != SP_CELL_TEXT)
        return sp_fail(err, SP_EINVAL, "columns case and method hold numbers: must be names");
    return SP_OK;
}

static sp_status read_points(const sp_table *t, const char *only, clouds *c, sp_error *err) {
    columns at;
    sp_status status = find_columns(t, &at, err);
    for (int64_t row = 0; row < t->rows && status == SP_OK; row++) {
        const sp_cell *cell = t->cells + row * t->columns;
        const double error = sp_table_number(t, row, at.error), seconds = sp_table_number(t, row, at.seconds);
        int method = 0;
        if (strcmp(cell[at.name].text, only) != 0 || is_choice(cell[at.method].text) ||
            !(error >= 0 && seconds > 0 && isfinite(error + seconds)))
            continue;
        status = method_of(c, cell[at.method].text, &method, err);
        if (status == SP_OK)
            c->point[c->n++] = (point){fmax(log10(error), LOG_LEAST), log10(seconds), method};
    }
    if (status == SP_OK && c->n == 0)
        status = sp_fail(err, SP_EREFUSED,
                         "nothing to draw: no row of case %.80s has a time and an error, must be as in "
                         "the column case",
                         only);
    return status;
}

static void add_edge(clouds *c, double x, double y) {
    c->edge_x[c->edges] = x;
    c->edge_y[c->edges++] = y;
}

/* From the most accurate point to the fastest one, and on to the edge of the figure, where the legend has space above.
 */
static void find_frontier(clouds *c) {
    const double far = 400;
    double least = HUGE_VAL;
    for (int k = 0; k < c->n; k++) {
        const point *p = &c->point[k];
        if (p->seconds >= least)
            continue;
        if (c->edges > 0)
            add_edge(c, p->error, least);
        add_edge(c, p->error, p->seconds);
        least = p->seconds;
    }
    add_edge(c, far, least);
}

/* One series for each method, its points joined. */
static void make_series(clouds *c, char label[][64], series *all) {
    static const marker shapes[] = {MARKER_CIRCLE, MARKER_SQUARE, MARKER_TRIANGLE, MARKER_DIAMOND};
    int used = 0, count[2] = {0, 0};
    for (int m = 0; m < c->methods; m++) {
        const bool rival = is_rival(c->method[m]);
        const int k = count[rival]++;
        sp_figure_text_escape(label[m], sizeof label[m], c->method[m], 30);
        all[m] = (series){.x = c->x + used,
                          .y = c->y + used,
                          .ink = sp_figure_ink(1 + k % (INKS - 1)),
                          .dash = DASH_DOTTED,
                          .width = 0.6,
                          .marker = shapes[(k + k / 4) % 4],
                          .open = rival,
                          .label = label[m],
                          .group = rival};
        for (int q = 0; q < c->n; q++)
            if (c->point[q].method == m) {
                c->x[used] = c->point[q].error;
                c->y[used++] = c->point[q].seconds;
                all[m].n++;
            }
    }
}

static void set_axes(figure *f, const clouds *c, const char *only) {
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    char name[128], plain[128];
    for (int k = 0; k < c->n; k++) {
        low[0] = fmin(low[0], c->point[k].error);
        high[0] = fmax(high[0], c->point[k].error);
        low[1] = fmin(low[1], c->point[k].seconds);
        high[1] = fmax(high[1], c->point[k].seconds);
    }
    sp_axis_log(&f->axes.x, low[0] - 0.6, high[0] + 0.6, 2.0);
    sp_axis_log(&f->axes.y, low[1] - 0.3, high[1] + 0.3, 2.0);
    /* name of the packing file without its ending */
    const char *dot = strrchr(only, '.');
    const int length = (int)(dot && strchr(only, ':') && strlen(dot) <= 4 ? dot - only : (ptrdiff_t)strlen(only));
    snprintf(plain, sizeof plain, "%.*s", length, only);
    for (int most = 40; most >= 6; most -= 2) {
        sp_figure_text_escape(name, sizeof name, plain, most);
        snprintf(f->axes.x.label, sizeof f->axes.x.label, "relative error  (%s)", name);
        if (sp_figure_text_width(f->canvas, f->axes.x.label, TEXT_LABEL) < 0.8 * f->canvas->width)
            break;
    }
    snprintf(f->axes.y.label, sizeof f->axes.y.label, "CPU time  [s]");
}

static sp_status draw(clouds *c, const char *only, const char *path, sp_error *err) {
    canvas sheet;
    char label[METHODS_MAX][64];
    series all[METHODS_MAX + 1];
    sp_status status = sp_canvas_open(&sheet, path, "Run time against error", CANVAS_COLUMN, 0.9 * CANVAS_COLUMN, err);
    if (status == SP_OK) {
        find_frontier(c);
        all[0] = (series){
            .n = c->edges, .x = c->edge_x, .y = c->edge_y, .ink = {0.55, 0.55, 0.55}, .dash = DASH_SOLID, .width = 0.8};
        figure f = {.canvas = &sheet, .series = all};
        make_series(c, label, all + 1);
        f.n = 1 + c->methods;
        set_axes(&f, c, only);
        sp_figure_draw(&f);
    }
    return sp_canvas_close(&sheet, status, err);
}

sp_status sp_plot_pareto(const sp_table *bench, const char *only, const char *path, sp_error *err) {
    clouds c = {0};
    columns at;
    const size_t rows = (size_t)bench->rows;
    sp_status status = sp_canvas_check(path, err);
    if (status == SP_OK)
        status = find_columns(bench, &at, err);
    if (status != SP_OK)
        return status;
    if (rows == 0)
        return sp_fail(err, SP_EREFUSED, "nothing to draw: the table has no rows");
    if (!only)
        only = bench->cells[at.name].text;
    c.point = sp_alloc(rows, sizeof *c.point);
    c.x = sp_alloc(6 * rows + 2, sizeof *c.x);
    status = c.point && c.x ? SP_OK : sp_fail_memory(err, rows * (sizeof *c.point + 6 * sizeof *c.x));
    if (status == SP_OK) {
        c.y = c.x + rows;
        c.edge_x = c.x + 2 * rows;
        c.edge_y = c.x + 4 * rows + 1;
        status = read_points(bench, only, &c, err);
    }
    if (status == SP_OK) {
        qsort(c.point, (size_t)c.n, sizeof *c.point, by_error);
        status = draw(&c, only, path, err);
    }
    clouds_free(&c);
    return status;
}
