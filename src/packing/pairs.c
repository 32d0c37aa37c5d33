#include "packing/pairs.h"

#include "base/base.h"
#include "packing/contact.h"

#include <math.h>
#include <string.h>

void pair_list_free(pair_list *p) {
    sp_free(p->i);
    sp_free(p->j);
    sp_free(p->from);
    sp_free(p->shift);
    sp_free(p->reach);
    sp_free(p->e);
    sp_free(p->c);
    sp_free(p->ft);
    sp_free(p->d);
    sp_free(p->spin);
    sp_free(p->f);
    sp_free(p->kn);
    *p = (pair_list){0};
}

/* A list with room for capacity pairs; inner lists carry the kernel's scratch. */
static sp_status pair_list_alloc(pair_list *p, int32_t capacity, bool inner, sp_error *err) {
    const size_t n = (size_t)capacity;
    pair_list q = {.capacity = capacity};
    q.i = sp_alloc(n, sizeof *q.i);
    q.j = sp_alloc(n, sizeof *q.j);
    q.shift = sp_alloc(n, sizeof *q.shift);
    q.reach = sp_alloc(n, sizeof *q.reach);
    q.ft = sp_alloc(n, sizeof *q.ft);
    bool ok = q.i && q.j && q.shift && q.reach && q.ft;
    if (inner) {
        q.from = sp_alloc(n, sizeof *q.from);
        q.e = sp_alloc(n, sizeof *q.e);
        q.c = sp_alloc(n, sizeof *q.c);
        q.d = sp_alloc(4 * n, sizeof *q.d);
        q.spin = sp_alloc(n, sizeof *q.spin);
        q.f = sp_alloc(4 * n, sizeof *q.f);
        q.kn = sp_alloc(n, sizeof *q.kn);
        ok = ok && q.from && q.e && q.c && q.d && q.spin && q.f && q.kn;
    }
    if (!ok) {
        pair_list_free(&q);
        return sp_fail_memory(err, n * (inner ? 136 : 32));
    }
    *p = q;
    return SP_OK;
}

/* ---- outer list ---------------------------------------------------------------------------------------------- */

typedef struct cell_grid {
    int64_t nx, ny;
    double wx, wy;
} cell_grid;

static cell_grid grid_for(const dynamics *d, double range) {
    cell_grid grid = {.nx = (int64_t)(d->width / range), .ny = (int64_t)(d->piston_y / range)};
    grid.nx = grid.nx > 0 ? grid.nx : 1;
    grid.ny = grid.ny > 0 ? grid.ny : 1;
    grid.wx = d->width / (double)grid.nx;
    grid.wy = d->piston_y / (double)grid.ny;
    return grid;
}

/* Whatever a motion that has blown up gives, not a number included, ends in some cell: it is found out later. */
static int64_t row_of(const cell_grid *grid, double y) {
    const double row = floor(y / grid->wy);
    return row >= (double)grid->ny ? grid->ny - 1 : row > 0 ? (int64_t)row : 0;
}

static int64_t column_of(const cell_grid *grid, double x) {
    const double column = floor(x / grid->wx);
    return column >= (double)grid->nx ? grid->nx - 1 : column > 0 ? (int64_t)column : 0;
}

static sp_status sort_into_cells(dynamics *d, const cell_grid *grid, sp_error *err) {
    const int64_t cells = grid->nx * grid->ny;
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
        grain *g = &d->g[i];
        g->x -= d->width * floor(g->x / d->width);
        int64_t cell = row_of(grid, g->y) * grid->nx + column_of(grid, g->x);
        d->cell_next[i] = d->cell_head[cell];
        d->cell_head[cell] = i;
    }
    return SP_OK;
}

/* The tangential force that the old list has for a pair: its pairs are in rows by i. */
static double old_force(const pair_list *old, const int32_t *row, int32_t i, int32_t j) {
    for (int32_t k = row[i]; k < row[i + 1]; k++)
        if (old->j[k] == j)
            return old->ft[k];
    return 0;
}

static sp_status push_pair(pair_list *p, int32_t i, int32_t j, sp_error *err) {
    if (p->n == p->capacity) {
        pair_list more;
        sp_status status = pair_list_alloc(&more, 2 * p->capacity, false, err);
        if (status != SP_OK)
            return status;
        const size_t n = (size_t)p->n;
        memcpy(more.i, p->i, n * sizeof *p->i);
        memcpy(more.j, p->j, n * sizeof *p->j);
        memcpy(more.shift, p->shift, n * sizeof *p->shift);
        memcpy(more.reach, p->reach, n * sizeof *p->reach);
        memcpy(more.ft, p->ft, n * sizeof *p->ft);
        more.n = p->n;
        pair_list_free(p);
        *p = more;
    }
    p->i[p->n] = i;
    p->j[p->n] = j;
    p->n++;
    return SP_OK;
}

/* All j > i near i, from the 3 x 3 cells around it (each column once, however few there are). */
static sp_status pairs_of(const dynamics *d, const cell_grid *grid, double gap, int32_t i, pair_list *p,
                          sp_error *err) {
    const grain *g = &d->g[i];
    const int64_t row = row_of(grid, g->y), column = column_of(grid, g->x);
    const int64_t columns = grid->nx < 3 ? grid->nx : 3;
    for (int64_t y = row - 1; y <= row + 1; y++)
        for (int64_t k = 0; y >= 0 && y < grid->ny && k < columns; k++) {
            int64_t x = (column - 1 + k + grid->nx) % grid->nx;
            for (int32_t j = d->cell_head[y * grid->nx + x]; j >= 0; j = d->cell_next[j]) {
                if (j <= i)
                    continue;
                const grain *h = &d->g[j];
                double dx = h->x - g->x, dy = h->y - g->y, shift = -d->width * nearbyint(dx / d->width);
                double reach = g->r + h->r;
                dx += shift;
                if (!(dx * dx + dy * dy < (reach + gap) * (reach + gap)))
                    continue;
                sp_status status = push_pair(p, i, j, err);
                if (status != SP_OK)
                    return status;
                p->shift[p->n - 1] = shift;
                p->reach[p->n - 1] = reach;
            }
        }
    return SP_OK;
}

sp_status pairs_rebuild(dynamics *d, double gap, sp_error *err) {
    pair_list p = {0};
    double r_max = 0;
    for (int32_t i = 0; i < d->n; i++)
        r_max = fmax(r_max, d->g[i].r);
    const cell_grid grid = grid_for(d, 2 * r_max + gap);
    pairs_return(d);
    int32_t *row = sp_alloc((size_t)d->n + 1, sizeof *row);
    sp_status status = row ? SP_OK : sp_fail_memory(err, (size_t)d->n * sizeof *row);
    if (status == SP_OK)
        status = sort_into_cells(d, &grid, err);
    if (status == SP_OK)
        status = pair_list_alloc(&p, 4 * d->n + 16, false, err);
    if (status != SP_OK)
        goto out;
    for (int32_t k = 0; k < d->outer.n; k++)
        row[d->outer.i[k] + 1]++;
    for (int32_t i = 0; i < d->n; i++)
        row[i + 1] += row[i];
    for (int32_t i = 0; i < d->n; i++) {
        int32_t first = p.n;
        status = pairs_of(d, &grid, gap, i, &p, err);
        if (status != SP_OK)
            goto out;
        for (int32_t k = first; k < p.n; k++)
            p.ft[k] = old_force(&d->outer, row, i, p.j[k]);
    }
    pair_list_free(&d->outer);
    d->outer = p;
    p = (pair_list){0};
    d->inner.n = 0;
    d->outer_gap = gap;
    d->outer_travel = 0;
    d->rebuilds++;
out:
    pair_list_free(&p);
    sp_free(row);
    return status;
}

/* ---- inner list ---------------------------------------------------------------------------------------------- */

void pairs_return(dynamics *d) {
    for (int32_t k = 0; k < d->inner.n; k++)
        d->outer.ft[d->inner.from[k]] = d->inner.ft[k];
}

static void refill_walls(dynamics *d, double gap) {
    for (int side = 0; side < 2; side++) {
        wall_list *wall = &d->wall[side];
        wall->n = 0;
        for (int32_t i = 0; i < d->n; i++) {
            double distance = side == 0 ? d->g[i].y : d->piston_y - d->g[i].y;
            if (distance - d->g[i].r < gap)
                wall->i[wall->n++] = i;
        }
    }
}

sp_status pairs_refill(dynamics *d, double gap, sp_error *err) {
    pairs_return(d);
    pair_list *inner = &d->inner;
    const pair_list *outer = &d->outer;
    if (inner->capacity < outer->n) {
        pair_list more;
        sp_status status = pair_list_alloc(&more, outer->n + outer->n / 4, true, err);
        if (status != SP_OK)
            return status;
        pair_list_free(inner);
        *inner = more;
    }
    int32_t n = 0;
    for (int32_t k = 0; k < outer->n; k++) {
        const grain *a = &d->g[outer->i[k]], *b = &d->g[outer->j[k]];
        double x = b->x - a->x + outer->shift[k], y = b->y - a->y, range = outer->reach[k] + gap;
        if (x * x + y * y >= range * range)
            continue;
        inner->i[n] = outer->i[k];
        inner->j[n] = outer->j[k];
        inner->from[n] = k;
        inner->shift[n] = outer->shift[k];
        inner->reach[n] = outer->reach[k];
        inner->e[n] = contact_stiffness(a->r, b->r);
        inner->c[n] = 2.0 * d->law.damping / sqrt(a->inv_m + b->inv_m); /* 1/m_eff = 1/m_i + 1/m_j */
        inner->ft[n] = outer->ft[k];
        n++;
    }
    inner->n = n;
    refill_walls(d, gap);
    d->inner_gap = gap;
    d->inner_travel = 0;
    d->refills++;
    return SP_OK;
}

/* Steps that an inner list should last, and the widest outer gap in diameters. */
enum { REFILL_STEPS = 12 };
static const double OUTER_GAP = 0.4, INNER_GAP_MIN = 2e-3, INNER_GAP_MAX = 0.15;

sp_status dynamics_refresh(dynamics *d, sp_error *err) {
    if (d->inner_travel < d->inner_gap && d->outer_travel < d->outer_gap)
        return SP_OK;
    const double gap = fmin(INNER_GAP_MAX, fmax(INNER_GAP_MIN, 2 * d->v_max * d->dt * REFILL_STEPS));
    if (!(d->outer_travel + gap < d->outer_gap)) {
        sp_status status = pairs_rebuild(d, OUTER_GAP, err);
        if (status != SP_OK)
            return status;
    }
    return pairs_refill(d, gap, err);
}
