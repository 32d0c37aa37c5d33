/* Neighbour lists. */
#include "packing/pairs.h"

#include "base/base.h"
#include "packing/contact.h"
#include "packing/kernel.h"

#include <math.h>
#include <string.h>

/* ---- lists --------------------------------------------------------------------------------------------------- */

void sp_pair_list_free(pair_list *p) {
    sp_free(p->i);
    sp_free(p->j);
    sp_free(p->from);
    sp_free(p->image);
    sp_free(p->reach);
    sp_free(p->ft);
    sp_free(p->e2);
    sp_free(p->sm);
    sp_free(p->at_i);
    sp_free(p->at_j);
    *p = (pair_list){0};
}

/* Allocates a list for capacity pairs; inner lists have additional arrays for the kernel. */
static sp_status pair_list_alloc(pair_list *p, int dim, int32_t capacity, bool inner, sp_error *err) {
    const size_t n = (size_t)capacity, sides = (size_t)dim - 1, forces = (size_t)sp_dynamics_layout(dim).forces;
    pair_list q = {.capacity = capacity};
    q.i = sp_alloc(n, sizeof *q.i);
    q.j = sp_alloc(n, sizeof *q.j);
    q.image = sp_alloc(sides * n, sizeof *q.image);
    q.reach = sp_alloc(n, sizeof *q.reach);
    q.ft = sp_alloc(forces * n, sizeof *q.ft);
    q.e2 = sp_alloc(n, sizeof *q.e2);
    q.sm = sp_alloc(n, sizeof *q.sm);
    bool ok = q.i && q.j && q.image && q.reach && q.ft && q.e2 && q.sm;
    if (inner) {
        q.from = sp_alloc(n, sizeof *q.from);
        q.at_i = sp_alloc(n, sizeof *q.at_i);
        q.at_j = sp_alloc(n, sizeof *q.at_j);
        ok = ok && q.from && q.at_i && q.at_j;
    }
    if (!ok) {
        sp_pair_list_free(&q);
        return sp_fail_memory(err, n * 8 * (6 + sides + forces));
    }
    *p = q;
    return SP_OK;
}

static sp_status grow(pair_list *p, int dim, sp_error *err) {
    pair_list more;
    sp_status status = pair_list_alloc(&more, dim, 2 * p->capacity, false, err);
    if (status != SP_OK)
        return status;
    const size_t n = (size_t)p->n;
    memcpy(more.i, p->i, n * sizeof *p->i);
    memcpy(more.j, p->j, n * sizeof *p->j);
    memcpy(more.reach, p->reach, n * sizeof *p->reach);
    memcpy(more.e2, p->e2, n * sizeof *p->e2);
    memcpy(more.sm, p->sm, n * sizeof *p->sm);
    for (int a = 0; a < dim - 1; a++)
        memcpy(more.image + (int64_t)a * more.capacity, p->image + (int64_t)a * p->capacity, n * sizeof *p->image);
    for (int a = 0; a < sp_dynamics_layout(dim).forces; a++)
        memcpy(more.ft + (int64_t)a * more.capacity, p->ft + (int64_t)a * p->capacity, n * sizeof *p->ft);
    more.n = p->n;
    sp_pair_list_free(p);
    *p = more;
    return SP_OK;
}

void sp_pairs_return(dynamics *d) {
    if (d->inner.n == 0)
        return; /* the arrays may not exist yet */
    for (int a = 0; a < d->at.forces; a++) {
        const double *from = d->inner.ft + (int64_t)a * d->inner.capacity;
        double *to = d->outer.ft + (int64_t)a * d->outer.capacity;
        for (int32_t k = 0; k < d->inner.n; k++)
            to[d->inner.from[k]] = from[k];
    }
}

/* ---- outer list ---------------------------------------------------------------------------------------------- */

/* There is one grid for each octave of grain sizes, so that a cell holds a few grains for any range of sizes. A pair
 * belongs to the octave of its smaller grain, which searches the grid of the larger one. */
enum { OCTAVES = 8 };
typedef struct cell_grid {
    int64_t n[3], first; /* cells along each axis; index of the first cell in cell_head */
    double width[3];
    bool used;
} cell_grid;

static int octave_of(const dynamics *d, double r) {
    int octave = 0;
    for (double limit = 0.5 * d->r_max; r < limit && octave < OCTAVES - 1; limit *= 0.5)
        octave++;
    return octave;
}

static cell_grid grid_for(const dynamics *d, double range, int64_t grains) {
    cell_grid grid = {.n = {1, 1, 1}, .width = {1, 1, 1}};
    int64_t cells = 1;
    for (int a = 0; a < d->dim; a++) {
        const double length = a < d->dim - 1 ? d->side[a] : d->piston_y;
        const double most = fmin(floor(length / range), 1e6);
        grid.n[a] = most > 1 ? (int64_t)most : 1;
        cells *= grid.n[a];
    }
    for (; cells > 8 * grains + 64;) { /* thin gas: no need for many more cells than grains */
        int64_t *longest = &grid.n[0];
        for (int a = 1; a < d->dim; a++)
            longest = grid.n[a] > *longest ? &grid.n[a] : longest;
        cells = cells / *longest * ((*longest + 1) / 2);
        *longest = (*longest + 1) / 2;
    }
    for (int a = 0; a < d->dim; a++)
        grid.width[a] = (a < d->dim - 1 ? d->side[a] : d->piston_y) / (double)grid.n[a];
    return grid;
}

/* Positions may be wild or not finite after the motion has blown up. Any cell will do: sp_dynamics_sane detects this
 * later. */
static int64_t place_of(const cell_grid *grid, int a, double x) {
    const double place = floor(x / grid->width[a]);
    return place >= (double)grid->n[a] ? grid->n[a] - 1 : place > 0 ? (int64_t)place : 0;
}

static int64_t cell_of(const cell_grid *grid, int dim, const double *x) {
    int64_t cell = 0;
    for (int a = dim - 1; a >= 0; a--)
        cell = cell * grid->n[a] + place_of(grid, a, x[a]);
    return grid->first + cell;
}

static sp_status sort_into_cells(dynamics *d, double gap, cell_grid grids[OCTAVES], sp_error *err) {
    int64_t population[OCTAVES] = {0}, cells = 0;
    for (int32_t i = 0; i < d->n; i++)
        population[octave_of(d, dynamics_radius(d, i))]++;
    for (int o = 0; o < OCTAVES; o++) {
        const double r_max = ldexp(d->r_max, -o);
        grids[o] = grid_for(d, 2 * r_max + gap, population[o]);
        grids[o].used = population[o] > 0;
        grids[o].first = cells;
        cells += grids[o].used ? grids[o].n[0] * grids[o].n[1] * grids[o].n[2] : 0;
    }
    if (cells > d->cells) {
        sp_free(d->cell_head);
        d->cell_head = sp_alloc((size_t)cells, sizeof *d->cell_head);
        d->cells = d->cell_head ? cells : 0;
        if (!d->cell_head)
            return sp_fail_memory(err, (size_t)cells * sizeof *d->cell_head);
    }
    for (int64_t c = 0; c < cells; c++)
        d->cell_head[c] = -1;
    for (int32_t i = d->n - 1; i >= 0; i--) {
        double *g = dynamics_grain(d, i);
        for (int a = 0; a < d->dim - 1; a++)
            g[a] -= d->side[a] * floor(g[a] / d->side[a]);
        const int64_t cell = cell_of(&grids[octave_of(d, g[d->at.r])], d->dim, g);
        d->cell_next[i] = d->cell_head[cell];
        d->cell_head[cell] = i;
    }
    return SP_OK;
}

/* Copies tangential forces from the old list, whose pairs are sorted by i. */
static void carry_forces(const dynamics *d, const int32_t *row, pair_list *p, int32_t first) {
    const pair_list *old = &d->outer;
    for (int32_t k = first; k < p->n; k++)
        for (int32_t q = row[p->i[k]]; q < row[p->i[k] + 1]; q++)
            if (old->j[q] == p->j[k])
                for (int a = 0; a < d->at.forces; a++)
                    p->ft[k + (int64_t)a * p->capacity] = old->ft[q + (int64_t)a * old->capacity];
}

/* The search decides which grain of a pair is i, so each pair is entered both ways. */
sp_status sp_pairs_give(dynamics *d, const pair_force *force, int32_t count, sp_error *err) {
    const int32_t n = 2 * count;
    const int forces = d->at.forces;
    pair_list p = {0};
    int32_t *next = sp_alloc((size_t)d->n + 1, sizeof *next);
    sp_status status = next ? SP_OK : sp_fail_memory(err, (size_t)d->n * sizeof *next);
    if (status == SP_OK)
        status = pair_list_alloc(&p, d->dim, n + 1, false, err);
    if (status != SP_OK)
        goto out;
    for (int32_t k = 0; k < n; k++)
        next[(k % 2 ? force[k / 2].j : force[k / 2].i) + 1]++;
    for (int32_t i = 0; i < d->n; i++)
        next[i + 1] += next[i];
    for (int32_t k = 0; k < n; k++) {
        const pair_force *f = &force[k / 2];
        const double sign = k % 2 && d->dim == 3 ? -1 : 1;
        const int32_t at = next[k % 2 ? f->j : f->i]++;
        p.i[at] = k % 2 ? f->j : f->i;
        p.j[at] = k % 2 ? f->i : f->j;
        for (int a = 0; a < forces; a++)
            p.ft[at + (int64_t)a * p.capacity] = sign * f->ft[a];
    }
    p.n = n;
    sp_pair_list_free(&d->outer);
    d->outer = p;
    d->outer_travel = INFINITY;
out:
    sp_free(next);
    return status;
}

/* Appends a pair. */
static sp_status push_pair(const dynamics *d, int32_t i, int32_t j, const double image[2], pair_list *p,
                           sp_error *err) {
    const double *g = dynamics_grain(d, i), *h = dynamics_grain(d, j);
    sp_status status = p->n == p->capacity ? grow(p, d->dim, err) : SP_OK;
    if (status != SP_OK)
        return status;
    const int32_t k = p->n++;
    p->i[k] = i;
    p->j[k] = j;
    p->reach[k] = g[d->at.r] + h[d->at.r];
    p->e2[k] = 2.0 * contact_stiffness(g[d->at.r], h[d->at.r]);
    p->sm[k] = sqrt(p->e2[k] / (g[d->at.inv_m] + h[d->at.inv_m])); /* 1/m_eff = 1/m_i + 1/m_j */
    for (int a = 0; a < d->dim - 1; a++)
        p->image[k + (int64_t)a * p->capacity] = image[a];
    return SP_OK;
}

/* Appends the pairs of grain i in one cell that are closer than the gap. same: the cell is of i's own octave, where a
 * pair belongs to the lower index. Compiled for both dimensions. */
static inline sp_status pairs_in_cell(const dynamics *d, int64_t cell, double gap, int32_t i, bool same, pair_list *p,
                                      const int dim, sp_error *err) {
    const double *g = dynamics_grain(d, i), r = g[d->at.r] + gap;
    for (int32_t j = d->cell_head[cell]; j >= 0; j = d->cell_next[j]) {
        if (same && j <= i)
            continue;
        const double *h = dynamics_grain(d, j), range = r + h[d->at.r];
        double image[2] = {0, 0}, square = 0;
        for (int a = 0; a < dim; a++) {
            double x = h[a] - g[a];
            if (a < dim - 1) { /* both lie in [0, period) */
                image[a] = x > 0.5 * d->side[a] ? -1 : x < -0.5 * d->side[a] ? 1 : 0;
                x += image[a] * d->side[a];
            }
            square += x * x;
        }
        sp_status status = square < range * range ? push_pair(d, i, j, image, p, err) : SP_OK;
        if (status != SP_OK)
            return status;
    }
    return SP_OK;
}

/* Searches the cells of one grid around grain i, each cell once even if there are few. */
static sp_status pairs_in_grid(const dynamics *d, const cell_grid *grid, double gap, int32_t i, bool same, pair_list *p,
                               sp_error *err) {
    const double *g = dynamics_grain(d, i);
    int64_t from[3] = {0, 0, 0}, count[3] = {1, 1, 1}, next[3];
    sp_status status = SP_OK;
    for (int a = 0; a < d->dim; a++) {
        const int64_t place = place_of(grid, a, g[a]);
        if (a == d->dim - 1) {
            from[a] = place > 0 ? place - 1 : 0;
            count[a] = (place + 1 < grid->n[a] ? place + 1 : grid->n[a] - 1) - from[a] + 1;
        } else {
            from[a] = place > 0 ? place - 1 : grid->n[a] - 1;
            count[a] = grid->n[a] < 3 ? grid->n[a] : 3;
        }
    }
    next[2] = from[2];
    for (int64_t z = 0; z < count[2] && status == SP_OK; z++, next[2] = next[2] + 1 < grid->n[2] ? next[2] + 1 : 0) {
        next[1] = from[1];
        for (int64_t y = 0; y < count[1]; y++, next[1] = next[1] + 1 < grid->n[1] ? next[1] + 1 : 0) {
            next[0] = from[0];
            for (int64_t x = 0; x < count[0] && status == SP_OK; x++) {
                const int64_t cell = grid->first + (next[2] * grid->n[1] + next[1]) * grid->n[0] + next[0];
                status = d->dim == 2 ? pairs_in_cell(d, cell, gap, i, same, p, 2, err)
                                     : pairs_in_cell(d, cell, gap, i, same, p, 3, err);
                next[0] = next[0] + 1 < grid->n[0] ? next[0] + 1 : 0;
            }
        }
    }
    return status;
}

static sp_status find_pairs(dynamics *d, double gap, const cell_grid grids[OCTAVES], const int32_t *row, pair_list *p,
                            sp_error *err) {
    sp_status status = SP_OK;
    for (int32_t i = 0; i < d->n && status == SP_OK; i++) {
        const int octave = octave_of(d, dynamics_radius(d, i));
        const int32_t first = p->n;
        for (int o = octave; o >= 0 && status == SP_OK; o--)
            if (grids[o].used)
                status = pairs_in_grid(d, &grids[o], gap, i, o == octave, p, err);
        carry_forces(d, row, p, first);
    }
    return status;
}

sp_status sp_pairs_rebuild(dynamics *d, double gap, sp_error *err) {
    pair_list p = {0};
    cell_grid grids[OCTAVES];
    sp_pairs_return(d);
    int32_t *row = sp_alloc((size_t)d->n + 1, sizeof *row);
    sp_status status = row ? SP_OK : sp_fail_memory(err, (size_t)d->n * sizeof *row);
    if (status == SP_OK)
        status = sort_into_cells(d, gap, grids, err);
    if (status == SP_OK) {
        const int32_t room = d->outer.n + d->outer.n / 8 + 16, usual = 4 * d->n + 16;
        status = pair_list_alloc(&p, d->dim, room > usual ? room : usual, false, err);
    }
    if (status != SP_OK)
        goto out;
    for (int32_t k = 0; k < d->outer.n; k++)
        row[d->outer.i[k] + 1]++;
    for (int32_t i = 0; i < d->n; i++)
        row[i + 1] += row[i];
    status = find_pairs(d, gap, grids, row, &p, err);
    if (status != SP_OK)
        goto out;
    sp_pair_list_free(&d->outer);
    d->outer = p;
    p = (pair_list){0};
    d->inner.n = 0;
    d->outer_gap = gap;
    d->outer_travel = d->outer_strain = 0;
    for (int32_t i = 0; i < d->n; i++)
        memcpy(d->listed + (int64_t)d->dim * i, dynamics_grain(d, i), (size_t)d->dim * sizeof *d->listed);
    d->rebuilds++;
out:
    sp_pair_list_free(&p);
    sp_free(row);
    return status;
}

/* ---- inner list ---------------------------------------------------------------------------------------------- */

static void refill_walls(dynamics *d, double gap) {
    const int up = d->dim - 1;
    for (int side = 0; side < 2; side++) {
        wall_list *wall = &d->wall[side];
        wall->n = 0;
        for (int32_t i = 0; i < d->n; i++) {
            const double *g = dynamics_grain(d, i);
            double distance = side == 0 ? g[up] : d->piston_y - g[up];
            if (distance - g[d->at.r] < gap)
                wall->i[wall->n++] = i;
        }
    }
}

/* Copies the pairs of the outer list that are closer than the gap. Compiled for both dimensions. */
static inline int32_t select_near(dynamics *d, double gap, const int dim) {
    pair_list *inner = &d->inner;
    const pair_list *outer = &d->outer;
    const int stride = dim == 2 ? 8 : 16, forces = dim == 2 ? 1 : 3;
    int32_t n = 0;
    for (int32_t k = 0; k < outer->n; k++) {
        const int32_t i = stride * outer->i[k], j = stride * outer->j[k];
        const double *g = d->g + i, *h = d->g + j, range = outer->reach[k] + gap;
        double square = 0;
        for (int a = 0; a < dim; a++) {
            double x = h[a] - g[a];
            if (a < dim - 1)
                x += outer->image[k + (int64_t)a * outer->capacity] * d->side[a];
            square += x * x;
        }
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
        for (int a = 0; a < dim - 1; a++)
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
    inner->n = d->dim == 2 ? select_near(d, gap, 2) : select_near(d, gap, 3);
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
static void give_row(force_rows *f, int32_t i, int32_t row) {
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
    const int64_t rows = 2 * (int64_t)p->padded + d->wall[0].n + d->wall[1].n + 1;
    if (rows > INT32_MAX / d->at.row)
        return sp_fail(err, SP_ENOMEM, "%d pairs of neighbours: more than a list can number", p->n);
    sp_status status = rows_alloc(d, rows, err);
    if (status != SP_OK)
        return status;
    f->other = p->padded;
    f->wall[0] = 2 * p->padded;
    f->wall[1] = f->wall[0] + d->wall[0].n;
    f->zero = f->wall[1] + d->wall[1].n;
    memset(f->row + (int64_t)f->zero * d->at.row, 0, (size_t)d->at.row * sizeof *f->row);
    memset(f->count, 0, (size_t)d->n * sizeof *f->count);
    f->chained = 0;
    for (int32_t i = 0; i < d->n; i++)
        f->further[i] = -1;
    for (int64_t s = 0; s < SLOTS * (int64_t)d->n; s++)
        f->slot[s] = size * f->zero;
    for (int32_t k = 0; k < p->n; k++) {
        give_row(f, p->i[k], size * k);
        give_row(f, p->j[k], size * (f->other + k));
    }
    for (int side = 0; side < 2; side++)
        for (int32_t k = 0; k < d->wall[side].n; k++)
            give_row(f, d->wall[side].i[k], size * (f->wall[side] + k));
    return SP_OK;
}

sp_status sp_pairs_refill(dynamics *d, double gap, sp_error *err) {
    sp_pairs_return(d);
    if (d->inner.capacity < d->outer.n + 8) {
        pair_list more;
        sp_status status = pair_list_alloc(&more, d->dim, d->outer.n + d->outer.n / 4 + 8, true, err);
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
 * but stay near. */
static double displacement(const dynamics *d) {
    double worst = 0;
    for (int32_t i = 0; i < d->n; i++) {
        const double *g = dynamics_grain(d, i), *from = d->listed + (int64_t)d->dim * i;
        double square = 0;
        for (int a = 0; a < d->dim; a++)
            square += (g[a] - from[a]) * (g[a] - from[a]);
        worst = square > worst ? square : worst;
    }
    return 2 * sqrt(worst) + d->outer_strain;
}

double sp_dynamics_narrowest(const dynamics *d) { return 2 * (2 * d->r_max + OUTER_GAP * d->scale); }

sp_status sp_dynamics_refresh(dynamics *d, sp_error *err) {
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
    return sp_pairs_refill(d, gap, err);
}
