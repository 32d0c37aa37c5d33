/* The inner neighbour list, the force rows, and when the lists are rebuilt. */
#include "packing/neighbours.h"

#include "base/base.h"
#include "packing/deform.h"
#include "packing/pairs.h"

#include <math.h>
#include <string.h>

/* ---- inner list ---------------------------------------------------------------------------------------------- */

static void refill_walls(dynamics *d, double gap) {
    for (int side = 0; side < d->walls; side++) {
        wall_list *wall = &d->wall[side];
        wall->n = 0;
        for (int32_t i = 0; i < d->n; i++) {
            const double *g = dynamics_grain(d, i);
            if (dynamics_wall_distance(d, side, g) - g[d->at.r] < gap)
                wall->i[wall->n++] = i;
        }
    }
}

/* Adds to x the lattice vectors of pair k, beyond the period of each horizontal axis alone. */
static inline void add_tilt(const dynamics *d, const pair_list *p, int32_t k, const int dim, double x[3]) {
    const double up = p->image[k + (int64_t)(dim - 1) * p->capacity];
    x[dim - 1] += up * d->piston_y;
    x[0] += (dim == 2 ? up : p->image[k + p->capacity]) * d->tilt[0];
    if (dim == 3) {
        x[0] += up * d->tilt[1];
        x[1] += up * d->tilt[2];
    }
}

/* Copies the pairs of the outer list that are closer than the gap. Compiled for both dimensions, and for cells with
 * images along all axes. */
static inline int32_t select_near(dynamics *d, double gap, const int dim, const bool affine) {
    pair_list *inner = &d->inner;
    const pair_list *outer = &d->outer;
    const int stride = dim == 2 ? 8 : 16, forces = dim == 2 ? 1 : 3;
    int32_t n = 0;
    for (int32_t k = 0; k < outer->n; k++) {
        const int32_t i = stride * outer->i[k], j = stride * outer->j[k];
        const double *g = d->g + i, *h = d->g + j, range = outer->reach[k] + gap;
        double x[3], square = 0;
        for (int a = 0; a < dim; a++) {
            x[a] = h[a] - g[a];
            if (a < dim - 1)
                x[a] += outer->image[k + (int64_t)a * outer->capacity] * d->period[a];
        }
        if (affine)
            add_tilt(d, outer, k, dim, x);
        for (int a = 0; a < dim; a++)
            square += x[a] * x[a];
        if (square >= range * range)
            continue;
        inner->i[n] = outer->i[k];
        inner->j[n] = outer->j[k];
        inner->at_i[n] = i;
        inner->at_j[n] = j;
        inner->from[n] = k;
        inner->reach[n] = outer->reach[k];
        inner->e2[n] = outer->e2[k];
        inner->sm[n] = outer->sm[k];
        for (int a = 0; a < (affine ? dim : dim - 1); a++)
            inner->image[n + (int64_t)a * inner->capacity] = outer->image[k + (int64_t)a * outer->capacity];
        for (int a = 0; a < forces; a++)
            inner->ft[n + (int64_t)a * inner->capacity] = outer->ft[k + (int64_t)a * outer->capacity];
        n++;
    }
    return n;
}

/* Fills the inner list, and its last vector with dummy pairs. */
static void select_pairs(dynamics *d, double gap) {
    pair_list *inner = &d->inner;
    if (d->affine)
        inner->n = d->dim == 2 ? select_near(d, gap, 2, true) : select_near(d, gap, 3, true);
    else
        inner->n = d->dim == 2 ? select_near(d, gap, 2, false) : select_near(d, gap, 3, false);
    inner->padded = (inner->n + 7) / 8 * 8;
    for (int32_t k = inner->n; k < inner->padded; k++) {
        inner->i[k] = inner->j[k] = d->n;
        inner->at_i[k] = inner->at_j[k] = d->at.stride * d->n;
        inner->reach[k] = -1;
        inner->e2[k] = inner->sm[k] = 0;
        for (int a = 0; a < d->dim - 1; a++)
            inner->image[k + (int64_t)a * inner->capacity] = 1;
        for (int a = 0; a < d->at.forces; a++)
            inner->ft[k + (int64_t)a * inner->capacity] = 0;
    }
}

/* row: its position in rows.row */
static void add_row(force_rows *f, int32_t i, int32_t row) {
    if (f->count[i] < SLOTS) {
        f->slot[SLOTS * (int64_t)i + f->count[i]++] = row;
        return;
    }
    f->count[i]++;
    f->chain[2 * (int64_t)f->chained] = row;
    f->chain[2 * (int64_t)f->chained + 1] = f->further[i];
    f->further[i] = f->chained++;
}

static sp_status rows_alloc(dynamics *d, int64_t rows, sp_error *err) {
    force_rows *f = &d->rows;
    if (rows <= f->capacity)
        return SP_OK;
    const int64_t capacity = rows + rows / 4;
    sp_free(f->row);
    sp_free(f->chain);
    f->row = sp_alloc((size_t)(capacity * d->at.row), sizeof *f->row);
    f->chain = sp_alloc((size_t)(2 * capacity), sizeof *f->chain);
    f->capacity = f->row && f->chain ? capacity : 0;
    return f->capacity ? SP_OK : sp_fail_memory(err, (size_t)capacity * 8 * (size_t)(d->at.row + 1));
}

/* Assigns the force rows of all grains. */
static sp_status assign_rows(dynamics *d, sp_error *err) {
    force_rows *f = &d->rows;
    const pair_list *p = &d->inner;
    const int32_t size = d->at.row;
    int64_t rows = 2 * (int64_t)p->padded + 1;
    for (int side = 0; side < d->walls; side++)
        rows += d->wall[side].n;
    if (rows > INT32_MAX / d->at.row)
        return sp_fail(err, SP_ENOMEM, "%d pairs of neighbours: more than a list can number", p->n);
    sp_status status = rows_alloc(d, rows, err);
    if (status != SP_OK)
        return status;
    f->other = p->padded;
    f->zero = 2 * p->padded;
    for (int side = 0; side < d->walls; side++) {
        f->wall[side] = f->zero;
        f->zero += d->wall[side].n;
    }
    memset(f->row + (int64_t)f->zero * d->at.row, 0, (size_t)d->at.row * sizeof *f->row);
    memset(f->count, 0, (size_t)d->n * sizeof *f->count);
    f->chained = 0;
    for (int32_t i = 0; i < d->n; i++)
        f->further[i] = -1;
    for (int64_t s = 0; s < SLOTS * (int64_t)d->n; s++)
        f->slot[s] = size * f->zero;
    for (int32_t k = 0; k < p->n; k++) {
        add_row(f, p->i[k], size * k);
        add_row(f, p->j[k], size * (f->other + k));
    }
    for (int side = 0; side < d->walls; side++)
        for (int32_t k = 0; k < d->wall[side].n; k++)
            add_row(f, d->wall[side].i[k], size * (f->wall[side] + k));
    return SP_OK;
}

/* Selects the inner list, the walls' lists and the force rows. */
static sp_status refill(dynamics *d, double gap, sp_error *err) {
    sp_pairs_store_forces(d);
    if (d->inner.capacity < d->outer.n + 8) {
        pair_list more;
        sp_status status = sp_pair_list_alloc(&more, d->dim, d->outer.n + d->outer.n / 4 + 8, true, err);
        if (status != SP_OK)
            return status;
        sp_pair_list_free(&d->inner);
        d->inner = more;
    }
    select_pairs(d, gap);
    refill_walls(d, gap);
    d->inner_gap = gap;
    d->inner_travel = 0;
    d->refills++;
    return assign_rows(d, err);
}

/* Number of steps that an inner list should last; gaps in units of `scale`. */
enum { REFILL_STEPS = 10 };
static const double OUTER_GAP = 0.4, INNER_GAP_MIN = 2e-3, INNER_GAP_MAX = 0.15;

/* Bound of the relative displacement since the outer list was built, from the positions: oscillating grains travel far
 * but stay near. What a deforming cell carries along moves together. */
static double displacement(const dynamics *d) {
    double worst = 0;
    for (int32_t i = 0; i < d->n; i++) {
        const double *g = dynamics_grain(d, i);
        double from[3] = {0, 0, 0}, square = 0;
        memcpy(from, d->listed + (int64_t)d->dim * i, (size_t)d->dim * sizeof *from);
        if (d->affine)
            sp_deform_carry(d, from);
        for (int a = 0; a < d->dim; a++)
            square += (g[a] - from[a]) * (g[a] - from[a]);
        worst = square > worst ? square : worst;
    }
    return 2 * sqrt(worst) + d->outer_strain;
}

double sp_neighbours_narrowest(const dynamics *d) { return 2 * (2 * d->r_max + OUTER_GAP * d->scale); }

sp_status sp_neighbours_refresh(dynamics *d, sp_error *err) {
    if (d->inner_travel < d->inner_gap && d->outer_travel < d->outer_gap)
        return SP_OK;
    const double outer = OUTER_GAP * d->scale;
    if (d->plain) {
        sp_status status = sp_pairs_rebuild(d, outer, err);
        refill_walls(d, outer);
        d->inner_gap = INFINITY;
        return status;
    }
    const double soon = 2 * d->v_max * d->dt * REFILL_STEPS;
    const double gap = fmin(INNER_GAP_MAX * d->scale, fmax(INNER_GAP_MIN * d->scale, soon));
    if (!(d->outer_travel + gap < d->outer_gap))
        d->outer_travel = isfinite(d->outer_travel) ? fmin(d->outer_travel, displacement(d)) : INFINITY;
    if (!(d->outer_travel + gap < d->outer_gap)) {
        sp_status status = sp_pairs_rebuild(d, outer, err);
        if (status != SP_OK)
            return status;
    }
    return refill(d, gap, err);
}
