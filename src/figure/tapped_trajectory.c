/* Figure of the positions of a column's particles against time, as Fig. 1 of Blackmore et al. 2011. */
#include "figure/tapped_table.h"

#include "base/base.h"

#include <math.h>
#include <stdio.h>

enum { LINES_MOST = 40, NAMED_MOST = 6, TAPS_MOST = 40, ROWS_MOST = 20000, BUCKETS = 5000 };

typedef struct picture {
    const tapped_table *s;
    int stride, shown; /* every stride-th particle is drawn, counted from the top */
    double *t, *value; /* [rows] */
    int64_t points;    /* most points of one curve */
    double *memory;    /* free part of the memory for points */
    sp_curve curve[LINES_MOST + 3 + TAPS_MOST];
    char label[NAMED_MOST + 1][TAPPED_LABEL];
    double low, high; /* of all positions */
    double tap[TAPS_MOST][2], ends[2];
    int curves;
} picture;

/* Keeps the lowest and the highest point of each of many equal intervals, in their order. A curve of millions of points
 * then looks the same. */
static int64_t thin(int64_t rows, const double *t, const double *y, double *x, double *to) {
    const int64_t run = rows > ROWS_MOST ? (rows + BUCKETS - 1) / BUCKETS : 1;
    int64_t n = 0;
    for (int64_t k = 0; k < rows; k += run) {
        int64_t low = k, high = k;
        for (int64_t q = k; q < k + run && q < rows; q++) {
            low = !(y[q] >= y[low]) ? q : low;
            high = !(y[q] <= y[high]) ? q : high;
        }
        const int64_t one = low < high ? low : high, two = low < high ? high : low;
        x[n] = t[one];
        to[n++] = y[one];
        if (two != one) {
            x[n] = t[two];
            to[n++] = y[two];
        }
    }
    return n;
}

static sp_curve *add_line(picture *p, int column) {
    const int64_t rows = p->s->table->rows, most = p->points;
    sp_curve *c = &p->curve[p->curves++];
    sp_tapped_table_values(p->s, column, p->value);
    *c = (sp_curve){.n = thin(rows, p->t, p->value, p->memory, p->memory + most), .x = p->memory};
    c->y = p->memory + most;
    p->memory += 2 * most;
    for (int64_t k = 0; k < c->n; k++)
        if (isfinite(c->y[k])) {
            p->low = fmin(p->low, c->y[k]);
            p->high = fmax(p->high, c->y[k]);
        }
    return c;
}

/* A few particles get a colour and a legend entry each, lowest first; of many, neighbours alternate between two. */
static void add_particles(picture *p) {
    const int n = p->s->particles;
    for (int k = 0; k < p->shown; k++) {
        const int particle = n - (p->shown - 1 - k) * p->stride;
        sp_curve *c = add_line(p, p->s->first + particle - 1);
        c->ink = n <= NAMED_MOST ? 1 + k : k % 2 == 0 ? 1 : 6;
        c->width = n <= NAMED_MOST ? 0.8 : p->shown <= 15 ? 0.7 : 0.5;
        if (n <= NAMED_MOST) {
            snprintf(p->label[k], TAPPED_LABEL, "|y|_{%d}", particle);
            c->label = p->label[k];
        } else if (k == 0) {
            if (p->stride == 1)
                snprintf(p->label[0], TAPPED_LABEL, "|y|_{1} \xe2\x80\xa6 |y|_{%d}", n);
            else
                snprintf(p->label[0], TAPPED_LABEL, "|y|_{%d}, |y|_{%d} \xe2\x80\xa6 |y|_{%d}", particle,
                         particle + p->stride, n);
            c->label = p->label[0];
        }
    }
}

/* Lines at the starts of the taps. */
static void add_taps(picture *p) {
    const double period = sp_tapped_table_setting(p->s, "period"), from = p->t[0], to = p->t[p->s->table->rows - 1];
    if (!isfinite(period) || (to - from) / period > TAPS_MOST - 1)
        return;
    for (double k = ceil(from / period + 1e-9); k * period < to - 1e-9 * (to - from); k += 1) {
        const int at = p->curves;
        double *x = p->tap[(int)(k - ceil(from / period + 1e-9))];
        x[0] = x[1] = k * period;
        p->curve[at] = (sp_curve){.n = 2, .x = x, .y = p->ends, .ink = -1, .dash = SP_DASH_DASHED, .width = 0.4};
        p->curves++;
    }
}

/* The floor, shaded below. */
static void add_floor(picture *p, double *foot) {
    sp_curve *c = add_line(p, p->s->floor);
    c->label = "floor |y|_{0}";
    c->width = 1.2;
    c->lower = foot;
    c->upper = c->y;
}

static sp_status draw(picture *p, double *foot, const char *path, sp_error *err) {
    const tapped_table *s = p->s;
    char x[TAPPED_LABEL], y[TAPPED_LABEL];
    add_particles(p);
    if (s->floor >= 0)
        add_floor(p, foot);
    if (!(p->low <= p->high))
        return sp_fail(err, SP_EREFUSED, "nothing to draw: no position is finite");
    const double range = p->high > p->low ? p->high - p->low : 1;
    p->ends[0] = p->low - 0.04 * range;
    p->ends[1] = p->high + 0.04 * range;
    for (int64_t k = 0; k < p->points; k++)
        foot[k] = p->ends[0];
    add_taps(p);
    const sp_panel panel = {
        .x = {.label = sp_tapped_axis_label(s, "|t|", s->abscissa, x),
              .low = p->t[0],
              .high = p->t[s->table->rows - 1]},
        .y = {.label = sp_tapped_axis_label(s, "|y|", s->first, y), .low = p->ends[0], .high = p->ends[1]},
        .curves = p->curves,
        .curve = p->curve,
        .tight = true};
    const sp_sheet sheet = {
        .title = "Trajectories of a tapped column", .rows = 1, .columns = 1, .panel = &panel, .aspect = 0.85};
    return sp_plot_sheet(&sheet, path, err);
}

sp_status sp_tapped_draw_trajectory(const tapped_table *s, const char *path, sp_error *err) {
    const int n = s->particles, stride = (n + LINES_MOST - 1) / LINES_MOST;
    const size_t rows = (size_t)s->table->rows, points = rows > ROWS_MOST ? 2 * BUCKETS : rows;
    picture *p = sp_alloc(1, sizeof *p);
    if (!p)
        return sp_fail_memory(err, sizeof *p);
    *p = (picture){.s = s, .stride = stride, .shown = (n + stride - 1) / stride, .low = INFINITY, .high = -INFINITY};
    p->points = (int64_t)points;
    const size_t count = 2 * rows + (2 * (size_t)p->shown + 3) * points;
    double *memory = sp_alloc(count, sizeof *memory);
    sp_status status = memory ? SP_OK : sp_fail_memory(err, count * sizeof *memory);
    if (status == SP_OK) {
        p->t = memory;
        p->value = memory + rows;
        p->memory = memory + 2 * rows + points;
        status = sp_tapped_table_abscissa(s, p->t, err);
    }
    if (status == SP_OK)
        status = draw(p, memory + 2 * rows, path, err);
    sp_free(memory);
    sp_free(p);
    return status;
}
