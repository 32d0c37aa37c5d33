/* The inner neighbour list, the rows of forces, and when the lists are rebuilt. Threads share the grains: each finds
 * the rows of its own in ascending order, and skips blocks of pairs that are not near. */
#include "base/base.h"
#include "packing/dynamics.h"

#include <math.h>
#include <string.h>

/* ---- rows of forces ---------------------------------------------------------------------------------------------- */

/* row: its index. opposite: 1 for the j of a pair, whose force is opposite, else 0. */
static void add_row(force_rows *f, int32_t i, int32_t row, int32_t opposite, int32_t size) {
    if (f->count[i] < SLOTS) {
        f->slot[SLOTS * (int64_t)i + f->count[i]++] = size * row + opposite;
        return;
    }
    const int32_t node = 2 * row + opposite;
    f->count[i]++;
    f->chain[node] = f->further[i];
    f->further[i] = node;
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

static void find_spans(void *data, int part, int parts) {
    pair_list *p = &((dynamics *)data)->inner;
    const int32_t blocks = (p->n + SPAN - 1) / SPAN, end = sp_pool_share(blocks, part + 1, parts);
    for (int32_t b = sp_pool_share(blocks, part, parts); b < end; b++) {
        int32_t low = INT32_MAX, high = -1;
        for (int32_t k = SPAN * b; k < p->n && k < SPAN * (b + 1); k++) {
            const int32_t i = p->i[k], j = p->j[k], less = i < j ? i : j, more = i < j ? j : i;
            low = less < low ? less : low;
            high = more > high ? more : high;
        }
        p->span[2 * (int64_t)b] = low;
        p->span[2 * (int64_t)b + 1] = high;
    }
}

/* The rows of the pairs [from, to) that belong to grains [first, last). */
static void assign_pairs(force_rows *f, const pair_list *p, int32_t from, int32_t to, int32_t size, int32_t first,
                         int32_t last) {
    for (int32_t k = from; k < to; k++) {
        if (p->i[k] >= first && p->i[k] < last)
            add_row(f, p->i[k], k, 0, size);
        if (p->j[k] >= first && p->j[k] < last)
            add_row(f, p->j[k], f->other + k, f->both ? 0 : 1, size);
    }
}

static void assign_all_pairs(force_rows *f, const pair_list *p, int32_t size) {
    for (int32_t k = 0; k < p->n; k++) {
        add_row(f, p->i[k], k, 0, size);
        add_row(f, p->j[k], f->other + k, f->both ? 0 : 1, size);
    }
}

static void assign_part(void *data, int part, int parts) {
    dynamics *d = data;
    force_rows *f = &d->rows;
    const pair_list *p = &d->inner;
    const int32_t size = d->at.row, blocks = (p->n + SPAN - 1) / SPAN;
    const int32_t first = sp_pool_share(d->n, part, parts), last = sp_pool_share(d->n, part + 1, parts);
    memset(f->count + first, 0, (size_t)(last - first) * sizeof *f->count);
    for (int32_t i = first; i < last; i++)
        f->further[i] = -1;
    for (int64_t s = SLOTS * (int64_t)first; s < SLOTS * (int64_t)last; s++)
        f->slot[s] = size * f->zero;
    for (int32_t b = 0; b < blocks && parts > 1; b++)
        if (sp_rows_may_touch(p, b, first, last))
            assign_pairs(f, p, SPAN * b, SPAN * (b + 1) < p->n ? SPAN * (b + 1) : p->n, size, first, last);
    if (parts == 1)
        assign_all_pairs(f, p, size);
    for (int side = 0; side < d->walls; side++)
        for (int32_t k = 0; k < d->wall[side].n; k++)
            if (d->wall[side].i[k] >= first && d->wall[side].i[k] < last)
                add_row(f, d->wall[side].i[k], f->wall[side] + k, 0, size);
}

/* Lays out the rows for the inner list and the walls' lists. */
static sp_status assign_rows(dynamics *d, sp_error *err) {
    force_rows *f = &d->rows;
    const pair_list *p = &d->inner;
    f->other = f->both ? p->padded : 0;
    f->zero = f->other + p->padded;
    int64_t rows = (int64_t)f->zero + 1;
    for (int side = 0; side < d->walls; side++)
        rows += d->wall[side].n;
    if (rows > INT32_MAX / d->at.row)
        return sp_fail(err, SP_ENOMEM, "%d pairs of neighbours: more than a list can number", p->n);
    sp_status status = rows_alloc(d, rows, err);
    if (status != SP_OK)
        return status;
    for (int side = 0; side < d->walls; side++) {
        f->wall[side] = f->zero;
        f->zero += d->wall[side].n;
    }
    memset(f->row + (int64_t)f->zero * d->at.row, 0, (size_t)d->at.row * sizeof *f->row);
    if (d->pool)
        sp_pool_run(d->pool, find_spans, d);
    sp_pool_run(d->pool, assign_part, d);
    return SP_OK;
}

/* ---- inner list ---------------------------------------------------------------------------------------------- */

/* What the threads of a refill share: each chooses from a part of the outer list and of the grains. */
typedef struct refill_work {
    dynamics *d;
    double gap;
    int32_t pairs[SP_POOL_MOST]; /* number chosen by each part */
    int32_t at_wall[MOST_WALLS][SP_POOL_MOST];
} refill_work;

/* Lists the grains of a part that are near a wall, at the place of its first grain. */
static int32_t choose_at_wall(dynamics *d, int side, double gap, int32_t first, int32_t last) {
    int32_t *i_near = d->wall[side].i + first, n = 0;
    for (int32_t i = first; i < last; i++) {
        const double *g = dynamics_grain(d, i);
        if (dynamics_wall_distance(d, side, g) - g[d->at.r] < gap)
            i_near[n++] = i;
    }
    return n;
}

/* Moves the lists of all parts together. */
static void join_walls(const refill_work *work, int parts) {
    dynamics *d = work->d;
    for (int side = 0; side < d->walls; side++) {
        wall_list *wall = &d->wall[side];
        wall->n = 0;
        for (int part = 0; part < parts; part++) {
            const int32_t count = work->at_wall[side][part];
            memmove(wall->i + wall->n, wall->i + sp_pool_share(d->n, part, parts), (size_t)count * sizeof *wall->i);
            wall->n += count;
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

/* Lists the pairs [first, last) of the outer list that are closer than the gap, at the place of the first. Compiled for
 * both dimensions, and for cells with images along all axes. */
static inline int32_t choose_near(const dynamics *d, double gap, int32_t first, int32_t last, const int dim,
                                  const bool affine) {
    const pair_list *outer = &d->outer;
    const int stride = dim == 2 ? 8 : 16;
    int32_t *near = outer->near + first, n = 0;
    for (int32_t k = first; k < last; k++) {
        const double *g = d->g + stride * (int64_t)outer->i[k], *h = d->g + stride * (int64_t)outer->j[k];
        const double range = outer->reach[k] + gap;
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
        near[n] = k; /* without a branch, which would often be mispredicted */
        n += !(square >= range * range);
    }
    return n;
}

/* Also stores the tangential forces of the old inner list, before `fill_part` reads them. */
static void choose_part(void *data, int part, int parts) {
    refill_work *work = data;
    dynamics *d = work->d;
    const int32_t first = sp_pool_share(d->outer.n, part, parts), last = sp_pool_share(d->outer.n, part + 1, parts);
    sp_pairs_store_part(d, part, parts);
    if (d->affine)
        work->pairs[part] = d->dim == 2 ? choose_near(d, work->gap, first, last, 2, true)
                                        : choose_near(d, work->gap, first, last, 3, true);
    else
        work->pairs[part] = d->dim == 2 ? choose_near(d, work->gap, first, last, 2, false)
                                        : choose_near(d, work->gap, first, last, 3, false);
    for (int side = 0; side < d->walls; side++)
        work->at_wall[side][part] =
            choose_at_wall(d, side, work->gap, sp_pool_share(d->n, part, parts), sp_pool_share(d->n, part + 1, parts));
}

/* Copies pairs of the outer list to the inner one. near: their indices. Compiled for both dimensions. */
static inline void copy_pairs(const dynamics *d, const int32_t *near, int32_t first, int32_t last, const int dim,
                              const int images) {
    const pair_list *inner = &d->inner, *outer = &d->outer;
    const int32_t stride = dim == 2 ? 8 : 16;
    for (int32_t n = first; n < last; n++) {
        const int32_t k = near[n - first];
        inner->i[n] = outer->i[k];
        inner->j[n] = outer->j[k];
        inner->at_i[n] = stride * outer->i[k];
        inner->at_j[n] = stride * outer->j[k];
        inner->from[n] = k;
        inner->reach[n] = outer->reach[k];
        inner->e2[n] = outer->e2[k];
        inner->sm[n] = outer->sm[k];
        inner->light[n] = outer->light[k];
        for (int a = 0; a < images; a++)
            inner->image[n + (int64_t)a * inner->capacity] = outer->image[k + (int64_t)a * outer->capacity];
        for (int a = 0; a < (dim == 2 ? 1 : 3); a++)
            inner->ft[n + (int64_t)a * inner->capacity] = outer->ft[k + (int64_t)a * outer->capacity];
        for (int a = d->at.forces; a < dynamics_kept(d); a++)
            inner->ft[n + (int64_t)a * inner->capacity] = outer->ft[k + (int64_t)a * outer->capacity];
        if (d->law.mixed) {
            inner->mu[n] = outer->mu[k];
            inner->eta[n] = outer->eta[k];
        }
    }
}

/* Fills the inner list with the pairs that a part has chosen, after those of the parts before it. */
static void fill_part(void *data, int part, int parts) {
    const refill_work *work = data;
    const dynamics *d = work->d;
    const int32_t *near = d->outer.near + sp_pool_share(d->outer.n, part, parts);
    int32_t first = 0;
    for (int before = 0; before < part; before++)
        first += work->pairs[before];
    const int32_t last = first + work->pairs[part];
    if (d->dim == 2)
        d->affine ? copy_pairs(d, near, first, last, 2, 2) : copy_pairs(d, near, first, last, 2, 1);
    else
        d->affine ? copy_pairs(d, near, first, last, 3, 3) : copy_pairs(d, near, first, last, 3, 2);
}

/* Fills the last vector of the inner list with dummy pairs. */
static void pad(dynamics *d) {
    pair_list *inner = &d->inner;
    inner->padded = (inner->n + 7) / 8 * 8;
    for (int32_t k = inner->n; k < inner->padded; k++) {
        inner->i[k] = inner->j[k] = d->n;
        inner->at_i[k] = inner->at_j[k] = d->at.stride * d->n;
        inner->reach[k] = -1;
        inner->e2[k] = inner->sm[k] = inner->light[k] = 0;
        if (d->law.mixed)
            inner->mu[k] = inner->eta[k] = 0;
        for (int a = 0; a < d->dim - 1; a++)
            inner->image[k + (int64_t)a * inner->capacity] = 1;
        for (int a = 0; a < dynamics_kept(d); a++)
            inner->ft[k + (int64_t)a * inner->capacity] = 0;
    }
}

/* Memory for n pairs. What the old list holds has been stored. */
static sp_status inner_alloc(dynamics *d, int32_t n, sp_error *err) {
    if (d->inner.capacity >= n + 8)
        return SP_OK;
    sp_pair_list_free(&d->inner);
    return sp_pair_list_alloc(&d->inner, d, n + n / 4 + 8, true, err);
}

/* Selects the inner list, the walls' lists and the force rows. */
static sp_status refill(dynamics *d, double gap, sp_error *err) {
    refill_work work = {.d = d, .gap = gap};
    const int parts = sp_pool_parts(d->pool);
    sp_pool_run(d->pool, choose_part, &work);
    int32_t n = 0;
    for (int part = 0; part < parts; part++)
        n += work.pairs[part];
    sp_status status = inner_alloc(d, n, err);
    if (status != SP_OK)
        return status;
    sp_pool_run(d->pool, fill_part, &work);
    d->inner.n = n;
    pad(d);
    join_walls(&work, parts);
    d->inner_gap = gap;
    d->inner_travel = 0;
    d->refills++;
    return assign_rows(d, err);
}

/* Lists the grains at walls alone. */
static void refill_walls(dynamics *d, double gap) {
    refill_work work = {.d = d};
    for (int side = 0; side < d->walls; side++)
        work.at_wall[side][0] = choose_at_wall(d, side, gap, 0, d->n);
    join_walls(&work, 1);
}

/* Number of steps that an inner list should last; gaps in units of `scale`. */
enum { REFILL_STEPS = 10 };
static const double OUTER_GAP = 0.5, INNER_GAP_MIN = 2e-3, INNER_GAP_MAX = 0.15;

typedef struct displacements {
    const dynamics *d;
    double square[SP_POOL_MOST]; /* largest of each part */
} displacements;

/* Bound of the relative displacement since the outer list was built, from the positions: oscillating grains travel far
 * but stay near. What a deforming cell carries along moves together. */
static void displace_part(void *data, int part, int parts) {
    displacements *work = data;
    const dynamics *d = work->d;
    double worst = 0;
    for (int32_t i = sp_pool_share(d->n, part, parts); i < sp_pool_share(d->n, part + 1, parts); i++) {
        const double *g = dynamics_grain(d, i);
        double from[3] = {0, 0, 0}, square = 0;
        memcpy(from, d->listed + (int64_t)d->dim * i, (size_t)d->dim * sizeof *from);
        if (d->affine)
            sp_deform_carry(d, from);
        for (int a = 0; a < d->dim; a++)
            square += (g[a] - from[a]) * (g[a] - from[a]);
        worst = square > worst ? square : worst;
    }
    work->square[part] = worst;
}

static double displacement(const dynamics *d) {
    displacements work = {.d = d};
    double worst = 0;
    sp_pool_run(d->pool, displace_part, &work);
    for (int part = 0; part < SP_POOL_MOST; part++)
        worst = fmax(worst, work.square[part]);
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
