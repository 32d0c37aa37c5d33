/* The bulk of a packing, and parts of grains in it. */
#include "packing/bulk.h"

#include <math.h>
#include <stddef.h>

static const double PI = 3.14159265358979323846;

bulk sp_bulk_of(const sp_packing *p, double margin) {
    bulk b = {.dim = p->dim, .volume = 1};
    bool empty = false;
    for (int a = 0; a < p->dim; a++) {
        b.bounded[a] = !sp_packing_periodic(p, a);
        b.low[a] = b.bounded[a] ? margin : 0;
        b.high[a] = b.bounded[a] ? p->box[a] - margin : p->box[a];
        b.volume *= b.high[a] - b.low[a];
        empty = empty || !(b.high[a] > b.low[a]);
    }
    if (empty)
        b.volume = 0;
    return b;
}

bool sp_bulk_has(const bulk *b, const double x[3]) {
    for (int a = 0; a < b->dim; a++)
        if (b->bounded[a] && !(x[a] >= b->low[a] && x[a] <= b->high[a]))
            return false;
    return true;
}

bool sp_bulk_has_contact(const bulk *b, const sp_packing *p, const sp_contact *c) {
    double point[3];
    for (int a = 0; a < 3; a++)
        point[a] = p->x[3 * (size_t)c->i + (size_t)a] + c->n[a] * (p->r[c->i] - 0.5 * c->overlap);
    return sp_bulk_has(b, point);
}

/* Fraction of a disc or ball of radius r at height y that lies below a level. */
static double disc_below(double level, double y, double r) {
    double s = fmax(-1, fmin(1, (level - y) / r));
    return 0.5 + (asin(s) + s * sqrt(1 - s * s)) / PI;
}

static double ball_below(double level, double y, double r) {
    double s = fmax(-1, fmin(1, (level - y) / r));
    return 0.25 * (2 + 3 * s - s * s * s);
}

static double segment_below(double level, double y, double r) { return 0.5 + 0.5 * fmax(-1, fmin(1, (level - y) / r)); }

/* Boundaries across one axis, from the centre of a grain. */
typedef struct slab {
    double low, high;
} slab;

static double between(int dim, const slab *s, double r) {
    if (dim == 3)
        return ball_below(s->high, 0, r) - ball_below(s->low, 0, r);
    if (dim == 2)
        return disc_below(s->high, 0, r) - disc_below(s->low, 0, r);
    return segment_below(s->high, 0, r) - segment_below(s->low, 0, r);
}

/* Fraction of a ball, disc or segment (dim 3, 2, 1) within all slabs, which are upright on each other: a sum over
 * slices across the first. */
static double within(int dim, int slabs, const slab *s, double r) {
    enum { SLICES = 64 };
    if (slabs < 2)
        return slabs == 0 ? 1 : between(dim, s, r);
    const double from = asin(fmax(-1, fmin(1, s->low / r))), to = asin(fmax(-1, fmin(1, s->high / r)));
    double sum = 0;
    for (int k = 0; k < SLICES; k++) {
        const double c = cos(from + (to - from) * (k + 0.5) / SLICES);
        sum += (dim == 3 ? 0.75 * c * c * c : 2 / PI * c * c) * within(dim - 1, slabs - 1, s + 1, r * c);
    }
    return sum * (to - from) / SLICES;
}

static double part(const bulk *b, int dim, const double x[3], double r) {
    slab cut[3];
    int slabs = 0;
    for (int a = 0; a < b->dim; a++) {
        const slab s = {b->low[a] - x[a], b->high[a] - x[a]};
        if (b->bounded[a] && (s.low > -r || s.high < r))
            cut[slabs++] = s;
    }
    return within(dim, slabs, cut, r);
}

double sp_bulk_ball(const bulk *b, const double x[3], double r) { return part(b, 3, x, r); }

double sp_bulk_disc(const bulk *b, const double x[3], double r) { return part(b, 2, x, r); }
