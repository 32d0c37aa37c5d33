/* What bounds a packing: its edges, lattice vectors and walls; and pairs of its grains. */
#include "packing/geometry.h"

#include "base/base.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *const sp_wall_names[] = {"rigid", "grain", "elastic", NULL};
const char *const sp_side_names[] = {"bottom", "top", "left", "right", "front", "back", NULL};
const char *const sp_cell_names[] = {"piston", "periodic", "box", "ring", NULL};
const char *const sp_strain_names[SP_SERIES_STRAINS] = {"e_xx", "e_yy", "e_zz", "e_yz", "e_xz", "e_xy"};

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
    double area = p->cell == SP_CELL_RING ? M_PI : 1.0;
    for (int k = 0; k < p->dim - 1; k++)
        area *= p->box[k];
    return area;
}

double sp_packing_volume(const sp_packing *p) {
    const double volume = sp_packing_wall_area(p) * sp_packing_height(p);
    return p->cell == SP_CELL_RING ? volume * (1 - p->box[1] / p->box[0]) : volume;
}

sp_status sp_cell_need_flat(sp_cell cell, const char *what, sp_error *err) {
    if (cell != SP_CELL_RING)
        return SP_OK;
    return sp_fail(err, SP_EREFUSED, "the walls are rings: %s needs flat walls or a periodic cell", what);
}

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

void sp_packing_untilt(int dim, const double edge[2], double tilt[3]) {
    if (dim == 3) {
        const double steps = nearbyint(tilt[2] / edge[1]);
        tilt[2] -= steps * edge[1];
        tilt[1] -= steps * tilt[0];
        tilt[1] -= edge[0] * nearbyint(tilt[1] / edge[0]);
    }
    tilt[0] -= edge[0] * nearbyint(tilt[0] / edge[0]);
    if (dim == 3) /* the step above may have used a longer second vector */
        tilt[1] -= edge[0] * nearbyint(tilt[1] / edge[0]);
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

double sp_ring_level(const double box[3], const double x[3]) {
    return hypot(x[0] - 0.5 * box[0], x[1] - 0.5 * box[0]) - (0.5 * box[0] - box[1]);
}

double sp_packing_wall_distance(const sp_packing *p, int32_t i, int32_t wall) {
    const int axis = sp_packing_wall_axis(p, wall);
    const double *x = p->x + 3 * (size_t)i, at = p->cell == SP_CELL_RING ? sp_ring_level(p->box, x) : x[axis];
    return sp_packing_wall_side(wall) < 0 ? at : p->box[axis] - at;
}

void sp_packing_wall_normal(const sp_packing *p, int32_t i, int32_t wall, double n[3]) {
    const double side = sp_packing_wall_side(wall), *x = p->x + 3 * (size_t)i;
    n[0] = n[1] = n[2] = 0;
    if (p->cell != SP_CELL_RING) {
        n[sp_packing_wall_axis(p, wall)] = side;
        return;
    }
    const double from = hypot(x[0] - 0.5 * p->box[0], x[1] - 0.5 * p->box[0]);
    for (int a = 0; a < 2; a++)
        n[a] = side * (x[a] - 0.5 * p->box[0]) / from;
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

/* Columns of the packing along its last axis, in each of which the grains are sorted by height. */
typedef struct columns {
    const sp_packing *p;
    const elevated *sorted; /* [n] all grains */
    int32_t many[2];        /* along the other axes */
    int32_t *column;        /* [n] of a grain of the sorted list */
    int32_t *first;         /* [columns + 1] where a column begins in rank */
    int32_t *rank;          /* [n] places in the sorted list, column by column */
} columns;

/* As many columns as are not narrower than the range, between the planes of the lattice, and no more than grains. */
static void divide(columns *c, double range) {
    for (int a = 0; a < 2; a++) {
        double squares = 0;
        for (int b = 0; b < 3; b++) {
            double slope[3];
            sp_packing_fractions(c->p, (double[3]){b == 0, b == 1, b == 2}, slope);
            squares += slope[a] * slope[a];
        }
        const double most = pow(c->p->n, 1.0 / fmax(c->p->dim - 1, 1));
        c->many[a] = a < c->p->dim - 1 ? (int32_t)fmax(1, fmin(most, 1 / (sqrt(squares) * range))) : 1;
    }
}

static void fill(columns *c) {
    const int32_t n = c->p->n, count = c->many[0] * c->many[1];
    for (int32_t k = 0; k < n; k++) {
        double s[3];
        int32_t at[2];
        sp_packing_fractions(c->p, c->p->x + 3 * (size_t)c->sorted[k].i, s);
        for (int a = 0; a < 2; a++)
            at[a] = (int32_t)fmax(0, fmin(c->many[a] - 1, s[a] * c->many[a]));
        c->column[k] = at[0] + c->many[0] * at[1];
        c->first[c->column[k] + 1]++;
    }
    for (int32_t q = 0; q < count; q++)
        c->first[q + 1] += c->first[q];
    for (int32_t k = n; k-- > 0;) /* from the end: first[q + 1] becomes the beginning of q, and all move by one */
        c->rank[--c->first[c->column[k] + 1]] = k;
    for (int32_t q = 0; q < count; q++)
        c->first[q] = c->first[q + 1];
    c->first[count] = n;
}

/* Lists the places of the column that are higher than k, within reach; in a periodic cell the lowest follow the
 * highest, with n added. */
static int32_t list_above(const columns *c, int32_t column, int32_t k, double far, int32_t *out) {
    const int32_t n = c->p->n, *rank = c->rank, end = c->first[column + 1];
    int32_t low = c->first[column], high = end, count = 0;
    while (low < high) {
        const int32_t middle = low + (high - low) / 2;
        if (rank[middle] > k)
            high = middle;
        else
            low = middle + 1;
    }
    for (; low < end && c->sorted[rank[low]].y <= far; low++)
        out[count++] = rank[low];
    if (!sp_packing_periodic(c->p, c->p->dim - 1))
        return count;
    for (int32_t q = c->first[column]; q < end && rank[q] < k; q++)
        if (c->sorted[rank[q]].y + sp_packing_height(c->p) <= far)
            out[count++] = rank[q] + n;
        else
            break;
    return count;
}

static int by_number(const void *a, const void *b) {
    const int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;
    return (x > y) - (x < y);
}

/* Visits the pairs of grain k of the sorted list with higher grains in the columns around it, and the walls. near [n]:
 * working memory. */
static sp_status visit_above(const columns *c, int32_t k, double range, int32_t *near, sp_pair_visit *visit, void *user,
                             sp_error *err) {
    const sp_packing *p = c->p;
    const int32_t i = c->sorted[k].i, at[2] = {c->column[k] % c->many[0], c->column[k] / c->many[0]};
    const double far = c->sorted[k].y + p->r[i] + range;
    int32_t count = 0, low[2], high[2];
    for (int a = 0; a < 2; a++) { /* of two columns each is the other's neighbour once */
        low[a] = c->many[a] > 2 ? -1 : 0;
        high[a] = c->many[a] > 1 ? 1 : 0;
    }
    for (int32_t v = low[1]; v <= high[1]; v++)
        for (int32_t u = low[0]; u <= high[0]; u++) {
            const int32_t x = (at[0] + u + c->many[0]) % c->many[0], y = (at[1] + v + c->many[1]) % c->many[1];
            count += list_above(c, x + c->many[0] * y, k, far, near + count);
        }
    qsort(near, (size_t)count, sizeof *near, by_number);
    sp_status status = SP_OK;
    for (int32_t q = 0; q < count && status == SP_OK; q++) {
        const int32_t other = c->sorted[near[q] < p->n ? near[q] : near[q] - p->n].i;
        status = visit(i < other ? i : other, i < other ? other : i, user, err);
    }
    for (int32_t wall = SP_BOTTOM; wall >= SP_BACK && status == SP_OK; wall--)
        if (sp_packing_has_wall(p, wall))
            status = visit(i, wall, user, err);
    return status;
}

static elevated *sort_by_height(const sp_packing *p, double *largest) {
    elevated *sorted = sp_alloc((size_t)p->n, sizeof *sorted);
    if (!sorted)
        return NULL;
    for (int32_t i = 0; i < p->n; i++) {
        sorted[i] = (elevated){p->x[3 * (int64_t)i + p->dim - 1], i};
        *largest = fmax(*largest, p->r[i]);
    }
    qsort(sorted, (size_t)p->n, sizeof *sorted, by_height);
    return sorted;
}

sp_status sp_packing_sweep(const sp_packing *p, double gap, sp_pair_visit *visit, void *user, sp_error *err) {
    const size_t n = (size_t)p->n;
    double largest = 0;
    elevated *sorted = sort_by_height(p, &largest);
    int32_t *memory = sp_alloc(5 * n + 1, sizeof *memory);
    sp_status status = sorted && memory ? SP_OK : sp_fail_memory(err, n * (sizeof *sorted + 5 * sizeof *memory));
    if (status == SP_OK) {
        columns c = {.p = p, .sorted = sorted, .column = memory, .rank = memory + n, .first = memory + 4 * n};
        divide(&c, 2 * largest + gap);
        fill(&c);
        for (int32_t k = 0; k < p->n && status == SP_OK; k++)
            status = visit_above(&c, k, largest + gap, memory + 2 * n, visit, user, err);
    }
    sp_free(memory);
    sp_free(sorted);
    return status;
}
