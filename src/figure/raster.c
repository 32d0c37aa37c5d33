/* Marks the cells of a frame that data cover, and finds free places. */
#include "figure/raster.h"

#include "base/base.h"

#include <math.h>
#include <string.h>

enum { MANY = 50000 };

#define CELL   1.5 /* side of a cell [pt] */
#define AROUND 2.5 /* margin around a rectangle [pt] */
#define STRIDE 3.0 /* distance of the places tried [pt] */

sp_status sp_raster_open(raster *r, const canvas *c, sp_error *err) {
    const size_t across = (size_t)(c->width / CELL) + 2, up = (size_t)(c->height / CELL) + 2;
    *r = (raster){.taken = sp_alloc(across * up, 1)};
    r->sum = sp_alloc((across + 1) * (up + 1), sizeof *r->sum);
    return r->taken && r->sum ? SP_OK : sp_fail_memory(err, (across + 1) * (up + 1) * sizeof *r->sum);
}

void sp_raster_free(raster *r) {
    sp_free(r->taken);
    sp_free(r->sum);
    *r = (raster){0};
}

/* ---- what is taken ---------------------------------------------------------------------------------------------- */

static int clamp(double cell, int most) { return !(cell >= 0) ? 0 : cell >= most ? most - 1 : (int)cell; }

/* Limits a position to a range in which differences are finite. */
static double near_enough(double place) { return fmax(-1e7, fmin(1e7, place)); }

void sp_raster_mark_box(raster *r, const rectangle *b) {
    const int x0 = clamp((b->x - r->left) / CELL, r->across), y0 = clamp((b->y - r->top) / CELL, r->up);
    const int x1 = clamp((b->x + b->width - r->left) / CELL, r->across);
    const int y1 = clamp((b->y + b->height - r->top) / CELL, r->up);
    if (b->x > r->left + r->width || b->y > r->top + r->height || b->x + b->width < r->left ||
        b->y + b->height < r->top)
        return;
    for (int y = y0; y <= y1; y++)
        memset(r->taken + (size_t)y * (size_t)r->across + x0, 1, (size_t)(x1 - x0 + 1));
}

bool sp_clip_segment(const double low[2], const double high[2], const double start[2], const double delta[2],
                     double *from, double *to) {
    *from = 0.0;
    *to = 1.0;
    for (int d = 0; d < 2; d++) {
        if (delta[d] == 0.0) {
            if (start[d] < low[d] || start[d] > high[d])
                return false;
            continue;
        }
        const double one = (low[d] - start[d]) / delta[d], two = (high[d] - start[d]) / delta[d];
        *from = fmax(*from, fmin(one, two));
        *to = fmin(*to, fmax(one, two));
    }
    return *from <= *to;
}

/* Marks the cells of the part of a segment inside the frame. */
static void mark_segment(raster *r, double ax, double ay, double bx, double by) {
    ax = near_enough(ax);
    ay = near_enough(ay);
    bx = near_enough(bx);
    by = near_enough(by);
    const double delta[2] = {bx - ax, by - ay}, start[2] = {ax, ay};
    const double low[2] = {r->left, r->top}, high[2] = {r->left + r->width, r->top + r->height};
    double from, to;
    if (!sp_clip_segment(low, high, start, delta, &from, &to))
        return;
    const int steps = (int)fmin(1e5, (to - from) * hypot(delta[0], delta[1]) / (0.7 * CELL)) + 1;
    for (int k = 0; k <= steps; k++) {
        const double part = from + (to - from) * k / steps;
        const int x = clamp((ax + part * delta[0] - r->left) / CELL, r->across);
        const int y = clamp((ay + part * delta[1] - r->top) / CELL, r->up);
        r->taken[(size_t)y * (size_t)r->across + (size_t)x] = 1;
    }
}

static void mark_series(raster *r, const figure *f, const series *s) {
    const axis *ax = &f->axes.x, *ay = &f->axes.y;
    const double reach = s->marker == MARKER_NONE ? 0.3 : 2.6;
    const int64_t stride = 1 + s->n / MANY; /* a subset of very many points is enough to show the curve */
    bool before = false;
    double last_x = 0.0, last_y = 0.0;
    for (int64_t k = 0; k < s->n; k += stride) {
        const double x = sp_axis_place(ax, s->x[k]), y = sp_axis_place(ay, s->y[k]);
        if (s->low && isfinite(x) && isfinite(s->low[k]) && isfinite(s->high[k]))
            mark_segment(r, x, sp_axis_place(ay, s->low[k]), x, sp_axis_place(ay, s->high[k]));
        if (s->fill_low && isfinite(x) && isfinite(s->fill_low[k]) && isfinite(s->fill_high[k]))
            mark_segment(r, x, sp_axis_place(ay, s->fill_low[k]), x, sp_axis_place(ay, s->fill_high[k]));
        const bool here = isfinite(x) && isfinite(y);
        if (here && s->marker != MARKER_NONE)
            sp_raster_mark_box(r, &(rectangle){x - reach, y - reach, 2 * reach, 2 * reach});
        if (here && before && s->dash != DASH_NONE)
            mark_segment(r, last_x, last_y, x, y);
        before = here;
        last_x = x;
        last_y = y;
    }
}

void sp_raster_mark(raster *r, const figure *f) {
    const axis *x = &f->axes.x, *y = &f->axes.y;
    r->left = x->from;
    r->top = y->to;
    r->width = fmax(x->to - x->from, 0.0);
    r->height = fmax(y->from - y->to, 0.0);
    r->across = (int)(r->width / CELL) + 1;
    r->up = (int)(r->height / CELL) + 1;
    memset(r->taken, 0, (size_t)r->across * (size_t)r->up);
    for (int k = 0; k < f->n; k++)
        mark_series(r, f, &f->series[k]);
    if (f->zero_line)
        mark_segment(r, x->from, sp_axis_place(y, 0.0), x->to, sp_axis_place(y, 0.0));
}

/* ---- what is free ----------------------------------------------------------------------------------------------- */

static void add_up(raster *r) {
    const size_t row = (size_t)r->across + 1;
    memset(r->sum, 0, row * sizeof *r->sum);
    for (int y = 0; y < r->up; y++) {
        const int32_t *above = r->sum + (size_t)y * row;
        int32_t *to = r->sum + (size_t)(y + 1) * row, line = 0;
        to[0] = 0;
        for (int x = 0; x < r->across; x++) {
            line += r->taken[(size_t)y * (size_t)r->across + (size_t)x];
            to[x + 1] = above[x + 1] + line;
        }
    }
}

static int32_t covered(const raster *r, const rectangle *b) {
    const size_t row = (size_t)r->across + 1;
    const size_t x0 = (size_t)clamp((b->x - AROUND - r->left) / CELL, r->across);
    const size_t y0 = (size_t)clamp((b->y - AROUND - r->top) / CELL, r->up);
    const size_t x1 = (size_t)clamp((b->x + b->width + AROUND - r->left) / CELL, r->across) + 1;
    const size_t y1 = (size_t)clamp((b->y + b->height + AROUND - r->top) / CELL, r->up) + 1;
    return r->sum[y1 * row + x1] - r->sum[y0 * row + x1] - r->sum[y1 * row + x0] + r->sum[y0 * row + x0];
}

int32_t sp_raster_find(raster *r, rectangle *b, double from_frame, bool corners) {
    const double wide = r->width - 2 * from_frame - b->width, high = r->height - 2 * from_frame - b->height;
    const int nx = corners ? 1 : (int)ceil(wide / STRIDE), ny = corners ? 1 : (int)ceil(high / STRIDE);
    int32_t least = INT32_MAX;
    double nearest = INFINITY;
    rectangle best = *b;
    if (!(wide >= 0 && high >= 0))
        return INT32_MAX;
    add_up(r);
    for (int j = 0; j <= ny; j++)
        for (int i = 0; i <= nx; i++) {
            const double x = nx > 0 ? wide * i / nx : 0, y = ny > 0 ? high * j / ny : 0;
            rectangle here = *b;
            here.x = r->left + from_frame + x;
            here.y = r->top + from_frame + y;
            const int32_t covers = covered(r, &here);
            /* distances in points that favour upper and left corners */
            const double off =
                hypot(fmin(x, wide - x), fmin(y, high - y)) + (y > 0.5 * high ? 4 : 0) + (x > 0.5 * wide ? 2 : 0);
            if (covers < least || (covers == least && off < nearest)) {
                least = covers;
                nearest = off;
                best = here;
            }
        }
    *b = best;
    return least;
}
