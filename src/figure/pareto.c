/* One point for each row, one symbol for each method, and the frontier of the fastest runs at each error. */
#include "base/base.h"
#include "figure/canvas.h"
#include "figure/marks.h"
#include "figure/markup.h"

#include <math.h>
#include <sonopack/figure/figure.h>
#include <sonopack/figure/plot.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { METHODS_MAX = 28 };
/* Smaller errors are rounding errors. */
#define LEAST 1e-17

/* One row of the case. */
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
    if (t->column[at->name].kind != SP_COLUMN_TEXT || t->column[at->method].kind != SP_COLUMN_TEXT)
        return sp_fail(err, SP_EINVAL, "columns case and method hold numbers: must be names");
    return SP_OK;
}

static sp_status read_points(const sp_table *t, const char *only, clouds *c, sp_error *err) {
    columns at;
    sp_status status = find_columns(t, &at, err);
    for (int64_t row = 0; row < t->rows && status == SP_OK; row++) {
        const sp_entry *cell = t->cells + row * t->columns;
        const double error = sp_table_number(t, row, at.error), seconds = sp_table_number(t, row, at.seconds);
        int method = 0;
        if (strcmp(cell[at.name].text, only) != 0 || is_choice(cell[at.method].text) ||
            !(error >= 0 && seconds > 0 && isfinite(error + seconds)))
            continue;
        status = method_of(c, cell[at.method].text, &method, err);
        if (status == SP_OK)
            c->point[c->n++] = (point){fmax(error, LEAST), seconds, method};
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
    const double far = 1e300;
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

/* One curve for each method, its points joined. */
static void make_curves(clouds *c, char label[][64], sp_curve *all) {
    static const sp_mark marks[] = {SP_MARK_CIRCLE, SP_MARK_SQUARE, SP_MARK_TRIANGLE, SP_MARK_DIAMOND};
    int used = 0, count[2] = {0, 0};
    for (int m = 0; m < c->methods; m++) {
        const bool rival = is_rival(c->method[m]);
        const int k = count[rival]++;
        sp_figure_text_escape(label[m], sizeof label[m], c->method[m], 30);
        all[m] = (sp_curve){.x = c->x + used,
                            .y = c->y + used,
                            .ink = 1 + k % (INKS - 1),
                            .dash = SP_DASH_DOTTED,
                            .width = 0.6,
                            .mark = marks[(k + k / 4) % 4],
                            .open = rival,
                            .label = label[m]};
        for (int q = 0; q < c->n; q++)
            if (c->point[q].method == m) {
                c->x[used] = c->point[q].error;
                c->y[used++] = c->point[q].seconds;
                all[m].n++;
            }
    }
}

/* "relative error  (case)", with the name of the packing file without its ending. */
static void label_error(const char *only, char *out, size_t size) {
    char name[128], plain[128];
    const char *dot = strrchr(only, '.');
    const int length = (int)(dot && strchr(only, ':') && strlen(dot) <= 4 ? dot - only : (ptrdiff_t)strlen(only));
    snprintf(plain, sizeof plain, "%.*s", length, only);
    sp_figure_text_escape(name, sizeof name, plain, 32);
    snprintf(out, size, "relative error  (%s)", name);
}

static sp_status draw(clouds *c, const char *only, const char *path, sp_error *err) {
    char label[METHODS_MAX][64], x[160];
    sp_curve all[METHODS_MAX + 1];
    double low = INFINITY, high = 0;
    find_frontier(c);
    all[0] = (sp_curve){.n = c->edges, .x = c->edge_x, .y = c->edge_y, .ink = -1, .width = 0.8};
    make_curves(c, label, all + 1);
    label_error(only, x, sizeof x);
    for (int k = 0; k < c->n; k++) {
        low = fmin(low, c->point[k].error);
        high = fmax(high, c->point[k].error);
    }
    const double beyond = pow(10, fmax(0.6, 1 - 0.5 * log10(high / low)));
    const sp_panel panel = {.x = {.label = x, .log = true, .low = low / beyond, .high = high * beyond},
                            .y = {.label = "CPU time  [s]", .log = true},
                            .curves = 1 + c->methods,
                            .curve = all};
    const sp_sheet sheet = {.title = "Run time against error", .rows = 1, .columns = 1, .panel = &panel, .aspect = 0.9};
    return sp_plot_sheet(&sheet, path, err);
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
