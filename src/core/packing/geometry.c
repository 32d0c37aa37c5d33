/* Pairs of grains in a finished packing. */
#include "packing/geometry.h"

#include "base/base.h"

#include <math.h>
#include <stdlib.h>

void sp_packing_separation(const sp_packing *p, int32_t i, int32_t j, double d[3]) {
    for (int a = 0; a < 3; a++)
        d[a] = p->x[3 * (size_t)j + (size_t)a] - p->x[3 * (size_t)i + (size_t)a];
    sp_packing_nearest(p, d);
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
