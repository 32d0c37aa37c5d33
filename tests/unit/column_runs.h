#ifndef TEST_COLUMN_RUNS_H
#define TEST_COLUMN_RUNS_H
/* Runs of the tapped column with their rows kept. */
#include "base/base.h"
#include "test.h"

#include <sonopack/tapped/tapped.h>

typedef struct column_rows {
    int32_t width; /* N + 1 */
    int64_t n, done;
    double *t, *y, *v;
    sp_tapped_report report;
} column_rows;

static inline sp_status column_keep(double t, const double *y, const double *v, void *user, sp_error *err) {
    column_rows *rows = user;
    if (rows->done >= rows->n || t != rows->t[rows->done])
        return sp_fail(err, SP_EFAILED, "a row that was not asked for");
    memcpy(rows->y + rows->done * rows->width, y, (size_t)rows->width * sizeof *y);
    memcpy(rows->v + rows->done * rows->width, v, (size_t)rows->width * sizeof *v);
    rows->done++;
    return SP_OK;
}

/* n rows, equally spaced from `from` to `to`. */
static inline column_rows column_run(const sp_tapped_spec *c, int64_t n, double from, double to) {
    column_rows rows = {.width = c->particles + 1, .n = n};
    const size_t size = (size_t)(n * rows.width);
    rows.t = malloc((size_t)n * sizeof *rows.t);
    rows.y = malloc(size * sizeof *rows.y);
    rows.v = malloc(size * sizeof *rows.v);
    assert_true(rows.t && rows.y && rows.v);
    for (int64_t k = 0; k < n; k++)
        rows.t[k] = n > 1 ? from + (double)k * (to - from) / (double)(n - 1) : from;
    assert_ok(sp_tapped_run(c, n, rows.t, column_keep, &rows, &rows.report, &err));
    assert_int_equal(rows.done, n);
    return rows;
}

static inline double column_y(const column_rows *rows, int64_t k, int32_t i) { return rows->y[k * rows->width + i]; }
static inline double column_v(const column_rows *rows, int64_t k, int32_t i) { return rows->v[k * rows->width + i]; }

static inline void column_rows_free(column_rows *rows) {
    free(rows->t);
    free(rows->y);
    free(rows->v);
    sp_tapped_report_free(&rows->report);
}

/* Mean |difference| of the particles' positions. */
static inline double column_mean(const column_rows *a, const column_rows *b) {
    double sum = 0;
    for (int64_t k = 0; k < a->n; k++)
        for (int32_t i = 1; i < a->width; i++)
            sum += fabs(column_y(a, k, i) - column_y(b, k, i));
    return sum / (double)(a->n * (a->width - 1));
}

/* Slope of the straight line through (ln x, ln y). */
static inline double column_order(int n, const double *x, const double *y) {
    double mx = 0, my = 0, xx = 0, xy = 0;
    for (int k = 0; k < n; k++) {
        mx += log(x[k]) / n;
        my += log(y[k]) / n;
    }
    for (int k = 0; k < n; k++) {
        xx += (log(x[k]) - mx) * (log(x[k]) - mx);
        xy += (log(x[k]) - mx) * (log(y[k]) - my);
    }
    return xy / xx;
}

#endif
