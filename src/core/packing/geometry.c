/* What bounds a packing: its edges, lattice vectors and walls; and pairs of its grains. */
#include "packing/geometry.h"

#include "base/base.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *const sp_wall_names[] = {"rigid", "grain", "elastic", NULL};
const char *const sp_side_names[] = {"bottom", "top", "left", "right", "front", "back", NULL};
const char *const sp_cell_names[] = {"piston", "periodic", "box", NULL};

bool sp_wall_read(const char *word, sp_wall *out) {
    for (int k = 0; sp_wall_names[k]; k++)
        if (strcmp(word, sp_wall_names[k]) == 0) {
            *out = (sp_wall)k;
            return true;
        }
    return false;
}

double sp_packing_height(const sp_packing *p) { return p->box[p->dim - 1]; }

double sp_packing_wall_area(const sp_packing *p) {
    double area = 1.0;
    for (int k = 0; k < p->dim - 1; k++)
        area *= p->box[k];
    return area;
}

double sp_packing_volume(const sp_packing *p) { return sp_packing_wall_area(p) * sp_packing_height(p); }

bool sp_packing_periodic(const sp_packing *p, int axis) {
    return p->cell == SP_CELL_PERIODIC || (p->cell == SP_CELL_PISTON && axis < p->dim - 1);
}

int sp_packing_wall_axis(const sp_packing *p, int32_t wall) {
    return wall >= SP_TOP ? p->dim - 1 : wall >= SP_RIGHT ? 0 : 1;
}

double sp_packing_wall_side(int32_t wall) { return wall % 2 == 0 ? 1 : -1; }

bool sp_packing_has_wall(const sp_packing *p, int32_t wall) {
    if (wall >= SP_TOP)
        return p->cell != SP_CELL_PERIODIC;
    return p->cell == SP_CELL_BOX && sp_packing_wall_axis(p, wall) < p->dim - 1;
}

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

double sp_packing_wall_distance(const sp_packing *p, int32_t i, int32_t wall) {
    const int axis = sp_packing_wall_axis(p, wall);
    const double x = p->x[3 * (size_t)i + (size_t)axis];
    return sp_packing_wall_side(wall) < 0 ? x : p->box[axis] - x;
}

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
