/* The outer neighbour list, found by cells. */
#include "packing/dynamics.h"

#include "base/base.h"
#include "packing/contact.h"
#include "packing/geometry.h"

#include <math.h>
#include <string.h>

/* ---- memory -------------------------------------------------------------------------------------------------- */

void sp_pair_list_free(pair_list *p) {
    sp_free(p->integers);
    sp_free(p->reals);
    *p = (pair_list){0};
}

sp_status sp_pair_list_alloc(pair_list *p, const dynamics *d, int32_t capacity, bool inner, sp_error *err) {
    const size_t n = ((size_t)capacity + 15) / 16 * 16, integers = inner ? 6 : 3;
    const size_t reals = (size_t)(4 + d->dim + dynamics_kept(d) + (d->law.mixed ? 2 : 0));
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
        q.span = q.from + n;
    } else {
        q.near = q.j + n;
    }
    q.reach = q.reals;
    q.e2 = q.reach + n;
    q.sm = q.e2 + n;
    q.light = q.sm + n;
    q.image = q.light + n;
    q.ft = q.image + (size_t)d->dim * n;
    q.u = q.ft + (size_t)(d->at.forces + d->at.past) * n;
    q.mu = d->law.mixed ? q.ft + (size_t)dynamics_kept(d) * n : q.reach;
    q.eta = d->law.mixed ? q.mu + n : q.reach;
    *p = q;
    return SP_OK;
}

void sp_pairs_store_part(dynamics *d, int part, int parts) {
    const int32_t n = d->inner.n; /* 0: the arrays may not exist yet */
    for (int a = 0; a < dynamics_kept(d) && n > 0; a++) {
        const double *from = d->inner.ft + (int64_t)a * d->inner.capacity;
        double *to = d->outer.ft + (int64_t)a * d->outer.capacity;
        for (int32_t k = sp_pool_share(n, part, parts); k < sp_pool_share(n, part + 1, parts); k++)
            to[d->inner.from[k]] = from[k];
    }
}

void sp_pairs_store_forces(dynamics *d) { sp_pairs_store_part(d, 0, 1); }

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

/* The search decides which grain of a pair is i, so each pair is entered both ways. */
sp_status sp_pairs_set_forces(dynamics *d, const pair_force *force, int32_t count, sp_error *err) {
    const int32_t n = 2 * count;
    const int kept = dynamics_kept(d);
    pair_list p = {0};
    int32_t *next = sp_alloc((size_t)d->n + 1, sizeof *next);
    sp_status status = next ? SP_OK : sp_fail_memory(err, (size_t)d->n * sizeof *next);
    if (status == SP_OK)
        status = sp_pair_list_alloc(&p, d, n + 1, false, err);
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
        for (int a = 0; a < kept; a++)
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

/* What the threads of a rebuild share. Each has a range of grains; the pairs of all ranges, one after the other, are in
 * the order in which one thread would find them. */
typedef struct found_pairs {
    int32_t *j;
    size_t n, capacity;
    bool failed; /* memory was short */
} found_pairs;

typedef struct search {
    dynamics *d;
    sp_packing cell;
    double gap, inverse[3]; /* inverse: of the periods, 0 along axes with walls */
    int64_t population[SP_POOL_MOST][SP_OCTAVES];
    int32_t *count; /* [n] pairs of each grain */
    double *place;  /* [n][dim + 1] positions and radii, in the order of d->cells.sorted */
    found_pairs found[SP_POOL_MOST];
    pair_list to;
} search;

static void wrap_part(void *data, int part, int parts) {
    search *s = data;
    dynamics *d = s->d;
    sp_pairs_store_part(d, part, parts);
    for (int32_t i = sp_pool_share(d->n, part, parts); i < sp_pool_share(d->n, part + 1, parts); i++) {
        wrap(d, &s->cell, dynamics_grain(d, i));
        s->population[part][sp_cells_octave(&d->cells, dynamics_radius(d, i))]++;
    }
}

static void locate_part(void *data, int part, int parts) {
    const search *s = data;
    dynamics *d = s->d;
    for (int32_t i = sp_pool_share(d->n, part, parts); i < sp_pool_share(d->n, part + 1, parts); i++) {
        double place[3];
        const double *g = dynamics_grain(d, i);
        sp_cells_locate(&d->cells, sp_cells_octave(&d->cells, g[d->at.r]), i, sp_deform_place(d, g, place));
    }
}

static void enter_part(void *data, int part, int parts) {
    const search *s = data;
    cells *c = &s->d->cells;
    sp_cells_enter_located(c, s->d->n, c->count * part / parts, c->count * (part + 1) / parts);
}

static void place_part(void *data, int part, int parts) {
    const search *s = data;
    const dynamics *d = s->d;
    for (int32_t k = sp_pool_share(d->n, part, parts); k < sp_pool_share(d->n, part + 1, parts); k++) {
        const double *g = dynamics_grain(d, d->cells.sorted[k]);
        double *to = s->place + (int64_t)(d->dim + 1) * k;
        memcpy(to, g, (size_t)d->dim * sizeof *to);
        to[d->dim] = g[d->at.r];
    }
}

static sp_status sort_into_cells(search *s, sp_error *err) {
    dynamics *d = s->d;
    int64_t population[SP_OCTAVES] = {0};
    sp_deform_reduce(d);
    s->cell = sp_dynamics_cell(d);
    sp_pool_run(d->pool, wrap_part, s);
    for (int part = 0; part < sp_pool_parts(d->pool); part++)
        for (int o = 0; o < SP_OCTAVES; o++)
            population[o] += s->population[part][o];
    sp_deform_box(d, d->cells.box);
    sp_status status = sp_cells_reset(&d->cells, population, s->gap, err);
    if (status != SP_OK)
        return status;
    sp_pool_run(d->pool, locate_part, s);
    sp_pool_run(d->pool, enter_part, s);
    sp_pool_run(d->pool, place_part, s);
    return SP_OK;
}

/* Replaces x by its shortest image in a cell that may have walls or lattice vectors along any axis. */
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

/* The shortest vector from grain i to grain j and its image; returns the square of its length. piston: both lie in
 * [0, period) of the horizontal axes. */
static inline double shortest(const search *s, const double *g, const double *h, double image[3], const int dim,
                              const bool piston) {
    const dynamics *d = s->d;
    double x[3], square = 0;
    for (int a = 0; a < dim; a++) {
        x[a] = h[a] - g[a];
        image[a] = 0;
        if (piston && a < dim - 1) {
            image[a] = x[a] > 0.5 * d->period[a] ? -1 : x[a] < -0.5 * d->period[a] ? 1 : 0;
            x[a] += image[a] * d->period[a];
        }
    }
    if (!piston)
        nearest(d, dim, s->inverse, x, image);
    for (int a = 0; a < dim; a++)
        square += x[a] * x[a];
    return square;
}

/* Lists the neighbours of grain i in one cell that are closer than the gap. same: the cell is of i's own octave, where
 * a pair belongs to the lower index. Compiled for both dimensions, and for the piston. */
static inline void neighbours_in_cell(const search *s, int64_t cell, int32_t i, bool same, found_pairs *to,
                                      const int dim, const bool piston) {
    const dynamics *d = s->d;
    const int32_t *sorted = d->cells.sorted, last = d->cells.start[cell + 1];
    int32_t first = d->cells.start[cell];
    while (same && first < last && sorted[first] <= i)
        first++;
    const double *g = dynamics_grain(d, i), r = g[d->at.r] + s->gap;
    const size_t most = to->n + (size_t)(last - first);
    if (most > to->capacity) {
        int32_t *more = sp_grow(to->j, most, &to->capacity, sizeof *more);
        to->failed = !more;
        if (!more)
            return;
        to->j = more;
    }
    for (int32_t k = first; k < last; k++) {
        const double *h = s->place + (dim + 1) * (int64_t)k, range = r + h[dim];
        double image[3];
        to->j[to->n] = sorted[k]; /* without a branch, which would often be mispredicted */
        to->n += shortest(s, g, h, image, dim, piston) < range * range;
    }
}

static void neighbours_of(const search *s, int32_t i, found_pairs *to) {
    const dynamics *d = s->d;
    const int octave = sp_cells_octave(&d->cells, dynamics_radius(d, i));
    const bool piston = d->cell == SP_CELL_PISTON;
    double place[3];
    const double *at = sp_deform_place(d, dynamics_grain(d, i), place);
    for (int o = octave; o >= 0; o--) {
        int64_t cell[SP_CELLS_NEAR];
        const int count = d->cells.grid[o].used ? sp_cells_near(&d->cells, o, at, cell) : 0;
        for (int k = 0; k < count && !to->failed; k++)
            if (piston && d->dim == 2)
                neighbours_in_cell(s, cell[k], i, o == octave, to, 2, true);
            else if (piston)
                neighbours_in_cell(s, cell[k], i, o == octave, to, 3, true);
            else if (d->dim == 2)
                neighbours_in_cell(s, cell[k], i, o == octave, to, 2, false);
            else
                neighbours_in_cell(s, cell[k], i, o == octave, to, 3, false);
    }
}

static void find_part(void *data, int part, int parts) {
    search *s = data;
    found_pairs *to = &s->found[part];
    for (int32_t i = sp_pool_share(s->d->n, part, parts); i < sp_pool_share(s->d->n, part + 1, parts); i++) {
        const size_t before = to->n;
        neighbours_of(s, i, to);
        s->count[i] = (int32_t)(to->n - before);
    }
}

static void set_pair(const search *s, int32_t k, int32_t i, int32_t j) {
    const dynamics *d = s->d;
    const pair_list *p = &s->to;
    const double *g = dynamics_grain(d, i), *h = dynamics_grain(d, j);
    double image[3];
    shortest(s, g, h, image, d->dim, d->cell == SP_CELL_PISTON);
    p->i[k] = i;
    p->j[k] = j;
    p->reach[k] = g[d->at.r] + h[d->at.r];
    const double law = d->law.exponent, r1 = g[d->at.r], r2 = h[d->at.r];
    const contact_rule *rule = dynamics_rule(d, i, j);
    p->e2[k] = rule->stiffness * (law == 1.5 ? 2.0 * contact_stiffness(r1, r2) : law * contact_strength(r1, r2, law));
    p->sm[k] = sqrt(p->e2[k] / (g[d->at.inv_m] + h[d->at.inv_m])); /* 1/m_eff = 1/m_i + 1/m_j */
    p->light[k] = fmax(g[d->at.inv_m], h[d->at.inv_m]);
    for (int a = 0; a < d->dim; a++)
        p->image[k + (int64_t)a * p->capacity] = image[a];
    if (d->law.mixed) {
        p->mu[k] = rule->friction;
        p->eta[k] = rule->eta;
    }
}

/* Copies the tangential force of a pair from the old list, in which the pairs of i are [first, last). */
static void carry_force(const search *s, int32_t k, int32_t first, int32_t last) {
    const pair_list *old = &s->d->outer, *p = &s->to;
    for (int a = 0; a < dynamics_kept(s->d); a++)
        p->ft[k + (int64_t)a * p->capacity] = 0;
    for (int32_t q = first; q < last; q++)
        if (old->j[q] == p->j[k])
            for (int a = 0; a < dynamics_kept(s->d); a++)
                p->ft[k + (int64_t)a * p->capacity] = old->ft[q + (int64_t)a * old->capacity];
}

/* First pair of a list, which is sorted by i, that belongs to grain i or a higher one. */
static int32_t first_of(const pair_list *p, int32_t i) {
    int32_t low = 0, high = p->n;
    while (low < high) {
        const int32_t middle = low + (high - low) / 2;
        if (p->i[middle] < i)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static void list_part(void *data, int part, int parts) {
    search *s = data;
    dynamics *d = s->d;
    const pair_list *old = &d->outer;
    const int32_t start = sp_pool_share(d->n, part, parts), *j = s->found[part].j;
    int32_t k = 0, first = first_of(old, start);
    for (int before = 0; before < part; before++)
        k += (int32_t)s->found[before].n;
    for (int32_t i = start; i < sp_pool_share(d->n, part + 1, parts); i++) {
        int32_t last = first;
        while (last < old->n && old->i[last] == i)
            last++;
        for (int32_t m = 0; m < s->count[i]; m++, k++) {
            set_pair(s, k, i, *j++);
            carry_force(s, k, first, last);
        }
        first = last;
        memcpy(d->listed + (int64_t)d->dim * i, dynamics_grain(d, i), (size_t)d->dim * sizeof *d->listed);
    }
}

/* Memory for the pairs that were found: that of the list before the last, if it is large enough. */
static sp_status list_alloc(search *s, sp_error *err) {
    const int parts = sp_pool_parts(s->d->pool);
    int64_t n = 0;
    for (int part = 0; part < parts; part++) {
        if (s->found[part].failed)
            return sp_fail_memory(err, s->found[part].n * sizeof *s->found[part].j);
        n += (int64_t)s->found[part].n;
    }
    if (n > INT32_MAX - INT32_MAX / 4)
        return sp_fail(err, SP_ENOMEM, "%lld pairs of neighbours: more than a list can number", (long long)n);
    s->to = s->d->spare;
    s->d->spare = (pair_list){0};
    if (n >= s->to.capacity) {
        sp_pair_list_free(&s->to);
        sp_status status = sp_pair_list_alloc(&s->to, s->d, (int32_t)(n + n / 8 + 16), false, err);
        if (status != SP_OK)
            return status;
    }
    s->to.n = (int32_t)n;
    return SP_OK;
}

static sp_status search_pairs(search *s, sp_error *err) {
    dynamics *d = s->d;
    s->count = sp_alloc((size_t)d->n, sizeof *s->count);
    s->place = sp_alloc((size_t)d->n * (size_t)(d->dim + 1), sizeof *s->place);
    if (!s->count || !s->place)
        return sp_fail_memory(err, (size_t)d->n * (sizeof *s->count + (size_t)(d->dim + 1) * sizeof *s->place));
    sp_status status = sort_into_cells(s, err);
    for (int a = 0; a < d->dim && d->cell == SP_CELL_PERIODIC; a++)
        s->inverse[a] = 1 / dynamics_edge(d, a);
    if (status == SP_OK) {
        sp_pool_run(d->pool, find_part, s);
        status = list_alloc(s, err);
    }
    if (status == SP_OK)
        sp_pool_run(d->pool, list_part, s);
    return status;
}

sp_status sp_pairs_rebuild(dynamics *d, double gap, sp_error *err) {
    search s = {.d = d, .gap = gap};
    sp_status status = search_pairs(&s, err);
    if (status == SP_OK) {
        d->spare = d->outer;
        d->outer = s.to;
        d->inner.n = 0;
        d->outer_gap = gap;
        d->outer_travel = d->outer_strain = 0;
        sp_deform_keep(d);
        d->rebuilds++;
    }
    for (int part = 0; part < SP_POOL_MOST; part++)
        sp_free(s.found[part].j);
    sp_free(s.count);
    sp_free(s.place);
    return status;
}
