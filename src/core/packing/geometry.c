/* Pairs of grains in a finished packing. */
#include "packing/geometry.h"

#include "base/base.h"

#include <math.h>
#include <stdlib.h>

void sp_packing_separation(const sp_packing *p, int32_t i, int32_t j, double d[3]) {
    for (int a = 0; a < 3; a++) {
        d[a] = p->x[3 * (size_t)j + (size_t)a] - p->x[3 * (size_t)i + (size_t)a];
        if (a < p->dim - 1)
            d[a] -= p->box[a] * nearbyint(d[a] / p->box[a]);
    }
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

/* Visits the pairs of grain k of the sorted list with higher grains, and the walls. */
static sp_status visit_above(const sp_packing *p, const elevated *sorted, int32_t k, double range, sp_pair_visit *visit,
                             void *user, sp_error *err) {
    const int32_t i = sorted[k].i;
    const double far = sorted[k].y + p->r[i] + range;
    sp_status status = SP_OK;
    for (int32_t q = k + 1; q < p->n && sorted[q].y <= far && status == SP_OK; q++) {
        const int32_t j = sorted[q].i;
        status = visit(i < j ? i : j, i < j ? j : i, user, err);
    }
    if (status == SP_OK)
        status = visit(i, SP_BOTTOM, user, err);
    return status == SP_OK ? visit(i, SP_TOP, user, err) : status;
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
