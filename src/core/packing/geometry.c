/* Pairs of grains in a finished packing. */
#include "packing/geometry.h"

#include "base/base.h"

#include <math.h>
#include <stdlib.h>

/* Subtracts a multiple of the lattice vector of an axis. */
static void shift(const sp_packing *p, int axis, double periods, double d[3]) {
    d[axis] -= p->box[axis] * periods;
    if (axis >= 1)
        d[0] -= p->tilt[axis == 1 ? 0 : 1] * periods;
    if (axis == 2)
        d[1] -= p->tilt[2] * periods;
}

void sp_packing_nearest(const sp_packing *p, double d[3]) {
    for (int a = p->dim - 1; a >= 0; a--) {
        const double periods = sp_packing_periodic(p, a) ? nearbyint(d[a] / p->box[a]) : 0;
        if (periods != 0)
            shift(p, a, periods, d);
    }
}

void sp_packing_fractions(const sp_packing *p, const double x[3], double s[3]) {
    s[2] = x[2] / p->box[2];
    s[1] = (x[1] - p->tilt[2] * s[2]) / p->box[1];
    s[0] = (x[0] - p->tilt[0] * s[1] - p->tilt[1] * s[2]) / p->box[0];
}

void sp_packing_wrap(const sp_packing *p, double x[3]) {
    for (int a = p->dim - 1; a >= 0; a--) {
        double s[3];
        sp_packing_fractions(p, x, s);
        const double periods = sp_packing_periodic(p, a) ? floor(s[a]) : 0;
        if (periods != 0)
            shift(p, a, periods, x);
        sp_packing_fractions(p, x, s);
        if (sp_packing_periodic(p, a) && s[a] >= 1) /* a tiny negative coordinate rounds to the far end */
            shift(p, a, 1, x);
    }
}

void sp_packing_separation(const sp_packing *p, int32_t i, int32_t j, double d[3]) {
    for (int a = 0; a < 3; a++)
        d[a] = p->x[3 * (size_t)j + (size_t)a] - p->x[3 * (size_t)i + (size_t)a];
    sp_packing_nearest(p, d);
}

double sp_packing_wall_distance(const sp_packing *p, int32_t i, int32_t wall) {
    const int axis = sp_packing_wall_axis(p, wall);
    const double x = p->x[3 * (size_t)i + (size_t)axis];
    return sp_packing_wall_side(wall) < 0 ? x : p->box[axis] - x;
}

typedef struct elevated {
    double y;
    int32_t i;
} elevated;

static int by_height(const void *a, const void *b) {
    const elevated *x = a, *y = b;
    if (x->y != y->y)
        return x->y < y->y ? -1 : 1;
    return x->i < y->i ? -1 : x->i > y->i;
}

/* Visits the pairs of grain k of the sorted list with higher grains, and the walls. In a periodic cell the lowest
 * grains follow the highest. */
static sp_status visit_above(const sp_packing *p, const elevated *sorted, int32_t k, double range, sp_pair_visit *visit,
                             void *user, sp_error *err) {
    const int32_t i = sorted[k].i;
    const double far = sorted[k].y + p->r[i] + range, height = sp_packing_height(p);
    const int32_t last = sp_packing_periodic(p, p->dim - 1) ? k + p->n : p->n;
    sp_status status = SP_OK;
    for (int32_t q = k + 1; q < last && status == SP_OK; q++) {
        const bool around = q >= p->n;
        const elevated *other = &sorted[around ? q - p->n : q];
        if (other->y + (around ? height : 0) > far)
            break;
        status = visit(i < other->i ? i : other->i, i < other->i ? other->i : i, user, err);
    }
    for (int32_t wall = SP_BOTTOM; wall >= SP_BACK && status == SP_OK; wall--)
        if (sp_packing_has_wall(p, wall))
            status = visit(i, wall, user, err);
    return status;
}

sp_status sp_packing_sweep(const sp_packing *p, double gap, sp_pair_visit *visit, void *user, sp_error *err) {
    elevated *sorted = sp_alloc((size_t)p->n, sizeof *sorted);
    if (!sorted)
        return sp_fail_memory(err, (size_t)p->n * sizeof *sorted);
    double largest = 0;
    for (int32_t i = 0; i < p->n; i++) {
        sorted[i] = (elevated){p->x[3 * (int64_t)i + p->dim - 1], i};
        largest = fmax(largest, p->r[i]);
    }
    qsort(sorted, (size_t)p->n, sizeof *sorted, by_height);
    sp_status status = SP_OK;
    for (int32_t k = 0; k < p->n && status == SP_OK; k++)
        status = visit_above(p, sorted, k, largest + gap, visit, user, err);
    sp_free(sorted);
    return status;
}
