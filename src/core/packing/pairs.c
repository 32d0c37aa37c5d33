/* The outer neighbour list, found by cells. */
#include "packing/pairs.h"

#include "base/base.h"
#include "packing/contact.h"
#include "packing/deform.h"
#include "packing/geometry.h"

#include <math.h>
#include <string.h>

/* ---- memory -------------------------------------------------------------------------------------------------- */

void sp_pair_list_free(pair_list *p) {
    sp_free(p->integers);
    sp_free(p->reals);
    *p = (pair_list){0};
}

static int real_planes(int dim) { return 3 + dim + grain_layout_of(dim).forces; }

sp_status sp_pair_list_alloc(pair_list *p, int dim, int32_t capacity, bool inner, sp_error *err) {
    const size_t n = ((size_t)capacity + 15) / 16 * 16, integers = inner ? 5 : 2, reals = (size_t)real_planes(dim);
    pair_list q = {.capacity = (int32_t)n};
    q.integers = n <= INT32_MAX ? sp_alloc(integers * n, sizeof *q.integers) : NULL;
    q.reals = n <= INT32_MAX ? sp_alloc(reals * n, sizeof *q.reals) : NULL;
    if (!q.integers || !q.reals) {
        sp_pair_list_free(&q);
        return sp_fail_memory(err, n * (integers * sizeof *q.integers + reals * sizeof *q.reals));
    }
    q.i = q.integers;
    q.j = q.i + n;
    if (inner) {
        q.at_i = q.j + n;
        q.at_j = q.at_i + n;
        q.from = q.at_j + n;
    }
    q.reach = q.reals;
    q.e2 = q.reach + n;
    q.sm = q.e2 + n;
    q.image = q.sm + n;
    q.ft = q.image + (size_t)dim * n;
    *p = q;
    return SP_OK;
}

/* Doubles the capacity of an outer list. */
static sp_status grow(pair_list *p, int dim, sp_error *err) {
    pair_list more;
    sp_status status = sp_pair_list_alloc(&more, dim, 2 * p->capacity, false, err);
    if (status != SP_OK)
        return status;
    for (int64_t k = 0; k < 2; k++)
        memcpy(more.integers + k * more.capacity, p->integers + k * p->capacity, (size_t)p->n * sizeof *p->integers);
    for (int64_t k = 0; k < real_planes(dim); k++)
        memcpy(more.reals + k * more.capacity, p->reals + k * p->capacity, (size_t)p->n * sizeof *p->reals);
    more.n = p->n;
    sp_pair_list_free(p);
    *p = more;
    return SP_OK;
}

void sp_pairs_store_forces(dynamics *d) {
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

/* Moves a grain into the cell along its periodic axes. */
static void wrap(const dynamics *d, const sp_packing *cell, double *g) {
    if (d->cell == SP_CELL_PERIODIC) {
        double x[3] = {g[0], g[1], d->dim == 3 ? g[2] : 0};
        sp_packing_wrap(cell, x);
        memcpy(g, x, (size_t)d->dim * sizeof *g);
    } else if (d->cell == SP_CELL_PISTON) {
        for (int a = 0; a < d->dim - 1; a++)
            g[a] -= d->period[a] * floor(g[a] / d->period[a]);
    }
}

static sp_status sort_into_cells(dynamics *d, double gap, sp_error *err) {
    int64_t population[SP_OCTAVES] = {0};
    cells *c = &d->cells;
    for (int32_t i = 0; i < d->n; i++)
        population[sp_cells_octave(c, dynamics_radius(d, i))]++;
    sp_deform_reduce(d);
    sp_deform_box(d, c->box);
    const sp_packing cell = sp_dynamics_cell(d);
    sp_status status = sp_cells_reset(c, population, gap, err);
    for (int32_t i = d->n - 1; i >= 0 && status == SP_OK; i--) {
        double *g = dynamics_grain(d, i), place[3];
        wrap(d, &cell, g);
        sp_cells_enter(c, sp_cells_octave(c, g[d->at.r]), i, sp_deform_place(d, g, place));
    }
    return status;
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
sp_status sp_pairs_set_forces(dynamics *d, const pair_force *force, int32_t count, sp_error *err) {
    const int32_t n = 2 * count;
    const int forces = d->at.forces;
    pair_list p = {0};
    int32_t *next = sp_alloc((size_t)d->n + 1, sizeof *next);
    sp_status status = next ? SP_OK : sp_fail_memory(err, (size_t)d->n * sizeof *next);
    if (status == SP_OK)
        status = sp_pair_list_alloc(&p, d->dim, n + 1, false, err);
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
static sp_status push_pair(const dynamics *d, int32_t i, int32_t j, const double image[3], pair_list *p,
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
    for (int a = 0; a < d->dim; a++)
        p->image[k + (int64_t)a * p->capacity] = image[a];
    return SP_OK;
}

/* Replaces x by its shortest image in a cell that may have walls or lattice vectors along any axis. inverse: of the
 * periods, 0 along axes with walls. */
static inline void nearest(const dynamics *d, const int dim, const double inverse[3], double x[3], double image[3]) {
    for (int a = dim - 1; a >= 0; a--) {
        image[a] = -nearbyint(x[a] * inverse[a]);
        x[a] += image[a] * dynamics_edge(d, a);
        if (a >= 1)
            x[0] += image[a] * d->tilt[a - 1];
        if (a == 2)
            x[1] += image[a] * d->tilt[2];
    }
}

/* Appends the pairs of grain i in one cell that are closer than the gap. same: the cell is of i's own octave, where a
 * pair belongs to the lower index. Compiled for both dimensions, and for the piston (inverse NULL). */
static inline sp_status pairs_in_cell(const dynamics *d, int64_t cell, double gap, int32_t i, bool same,
                                      const double *inverse, pair_list *p, const int dim, sp_error *err) {
    const double *g = dynamics_grain(d, i), r = g[d->at.r] + gap;
    for (int32_t j = d->cells.head[cell]; j >= 0; j = d->cells.next[j]) {
        if (same && j <= i)
            continue;
        const double *h = dynamics_grain(d, j), range = r + h[d->at.r];
        double x[3], image[3] = {0, 0, 0}, square = 0;
        for (int a = 0; a < dim; a++) {
            x[a] = h[a] - g[a];
            if (!inverse && a < dim - 1) { /* both lie in [0, period) */
                image[a] = x[a] > 0.5 * d->period[a] ? -1 : x[a] < -0.5 * d->period[a] ? 1 : 0;
                x[a] += image[a] * d->period[a];
            }
        }
        if (inverse)
            nearest(d, dim, inverse, x, image);
        for (int a = 0; a < dim; a++)
            square += x[a] * x[a];
        sp_status status = square < range * range ? push_pair(d, i, j, image, p, err) : SP_OK;
        if (status != SP_OK)
            return status;
    }
    return SP_OK;
}

static sp_status pairs_near(const dynamics *d, int64_t cell, double gap, int32_t i, bool same, const double *inverse,
                            pair_list *p, sp_error *err) {
    if (d->cell == SP_CELL_PISTON)
        return d->dim == 2 ? pairs_in_cell(d, cell, gap, i, same, NULL, p, 2, err)
                           : pairs_in_cell(d, cell, gap, i, same, NULL, p, 3, err);
    return d->dim == 2 ? pairs_in_cell(d, cell, gap, i, same, inverse, p, 2, err)
                       : pairs_in_cell(d, cell, gap, i, same, inverse, p, 3, err);
}

static sp_status find_pairs(dynamics *d, double gap, const int32_t *row, pair_list *p, sp_error *err) {
    sp_status status = SP_OK;
    double inverse[3] = {0, 0, 0};
    for (int a = 0; a < d->dim && d->cell == SP_CELL_PERIODIC; a++)
        inverse[a] = 1 / dynamics_edge(d, a);
    for (int32_t i = 0; i < d->n && status == SP_OK; i++) {
        const int octave = sp_cells_octave(&d->cells, dynamics_radius(d, i));
        const int32_t first = p->n;
        for (int o = octave; o >= 0; o--) {
            int64_t cell[SP_CELLS_NEAR];
            double place[3];
            const double *at = sp_deform_place(d, dynamics_grain(d, i), place);
            const int count = d->cells.grid[o].used ? sp_cells_near(&d->cells, o, at, cell) : 0;
            for (int k = 0; k < count && status == SP_OK; k++)
                status = pairs_near(d, cell[k], gap, i, o == octave, inverse, p, err);
        }
        carry_forces(d, row, p, first);
    }
    return status;
}

sp_status sp_pairs_rebuild(dynamics *d, double gap, sp_error *err) {
    pair_list p = {0};
    sp_pairs_store_forces(d);
    int32_t *row = sp_alloc((size_t)d->n + 1, sizeof *row);
    sp_status status = row ? SP_OK : sp_fail_memory(err, (size_t)d->n * sizeof *row);
    if (status == SP_OK)
        status = sort_into_cells(d, gap, err);
    if (status == SP_OK) {
        const int32_t likely = d->outer.n + d->outer.n / 8 + 16, usual = 4 * d->n + 16;
        status = sp_pair_list_alloc(&p, d->dim, likely > usual ? likely : usual, false, err);
    }
    if (status != SP_OK)
        goto out;
    for (int32_t k = 0; k < d->outer.n; k++)
        row[d->outer.i[k] + 1]++;
    for (int32_t i = 0; i < d->n; i++)
        row[i + 1] += row[i];
    status = find_pairs(d, gap, row, &p, err);
    if (status != SP_OK)
        goto out;
    sp_pair_list_free(&d->outer);
    d->outer = p;
    p = (pair_list){0};
    d->inner.n = 0;
    d->outer_gap = gap;
    d->outer_travel = d->outer_strain = 0;
    sp_deform_keep(d);
    for (int32_t i = 0; i < d->n; i++)
        memcpy(d->listed + (int64_t)d->dim * i, dynamics_grain(d, i), (size_t)d->dim * sizeof *d->listed);
    d->rebuilds++;
out:
    sp_pair_list_free(&p);
    sp_free(row);
    return status;
}
