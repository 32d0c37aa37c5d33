/* Runs the recurrence of a signal backwards with its adjoint. */
#include "sensitivity/reverse.h"

#include "base/base.h"
#include "sensitivity/reverse_rows.h"

#include <math.h>
#include <string.h>

enum { NORMS_EVERY = 16 };

static int kinds_of(const sp_operator *op) { return op->kind.rotations ? 2 : 1; }

static size_t vector_size(const sp_operator *op) { return ((size_t)op->n + 1) * (size_t)op->row; }

void sp_reverse_free(reverse *r) {
    sp_pool_free(r->pool);
    for (int q = 0; q < 2; q++) {
        if (r->of[q].next != r->of[q].u)
            sp_free(r->of[q].next);
        sp_free(r->of[q].u);
        sp_free(r->of[q].v);
    }
    sp_free(r->first);
    sp_free(r->quads);
    sp_free(r->index);
    sp_free(r->sums);
    sp_free(r->weight);
    sp_free(r->force);
    sp_free(r->density);
    sp_free(r->active);
    *r = (reverse){0};
}

static int32_t chunk_of(const sp_operator *op, int32_t row) {
    int32_t low = 0, high = op->chunk[op->blocks] - 1;
    while (low < high) {
        const int32_t middle = low + (high - low + 1) / 2;
        if (op->chunk_row[middle] <= row)
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

static int32_t block_of_chunk(const sp_operator *op, int32_t chunk) {
    int32_t b = 0;
    while (op->chunk[b + 1] <= chunk)
        b++;
    return b;
}

/* The chunk that has a spring: of the lower of its rows in a block, so that its products are taken before these rows
 * move; of i if it leads to another block. */
static int32_t home_of(const sp_operator *op, const sp_spring *s) {
    const int32_t i = op->row_of[s->i], j = s->j < 0 ? i : op->row_of[s->j];
    const int32_t ci = chunk_of(op, i), cj = chunk_of(op, j);
    return block_of_chunk(op, ci) == block_of_chunk(op, cj) && cj < ci ? cj : ci;
}

/* Numbers of springs of the chunks in next[chunk + 1] become the places of their first springs in next[chunk]. Each
 * chunk begins with a quad of its own. */
static void number_quads(int32_t chunks, int64_t *next, int64_t *first) {
    int64_t at = 0;
    for (int32_t c = 0; c < chunks; c++) {
        first[c] = at;
        next[c] = 4 * at;
        at += (next[c + 1] + 3) / 4;
    }
    first[chunks] = at;
}

/* Fills the last quad of each chunk with springs from a row to itself, whose sums nobody reads. */
static void fill_up(reverse *r, int32_t chunk) {
    const sp_operator *op = r->op;
    for (int64_t q = r->first[chunk]; q < r->first[chunk + 1]; q++) {
        quad_rows *rows = (quad_rows *)quad_rows_behind(op->kind.dim, r->quads + q * multiply_quad(op->kind.dim));
        for (int s = 0; s < 4; s++) {
            rows[s] = rows[4 + s] = op->chunk_row[chunk] * op->row;
            r->index[4 * q + s] = -1;
        }
    }
}

static void put_spring(reverse *r, int32_t k, int64_t place) {
    const sp_operator *op = r->op;
    const sp_spring *s = &r->net->springs[k];
    double *numbers = r->quads + place / 4 * multiply_quad(op->kind.dim) + place % 4;
    quad_rows *rows =
        (quad_rows *)quad_rows_behind(op->kind.dim, r->quads + place / 4 * multiply_quad(op->kind.dim)) + place % 4;
    for (int a = 0; a < op->kind.dim; a++)
        numbers[4 * (ptrdiff_t)a] = s->n[a];
    rows[0] = op->row_of[s->i] * op->row;
    rows[4] = (s->j < 0 ? op->n : op->row_of[s->j]) * op->row;
    r->index[place] = k;
}

static sp_status sort_springs(reverse *r, sp_error *err) {
    const int32_t chunks = r->op->chunk[r->op->blocks], springs = r->net->n_springs;
    int32_t *home = sp_alloc((size_t)springs, sizeof *home);
    int64_t *next = sp_alloc((size_t)chunks + 1, sizeof *next);
    r->first = sp_alloc((size_t)chunks + 1, sizeof *r->first);
    bool fits = home && next && r->first;
    for (int32_t k = 0; k < springs && fits; k++)
        next[(home[k] = home_of(r->op, &r->net->springs[k])) + 1]++;
    if (fits) {
        number_quads(chunks, next, r->first);
        const size_t quads = (size_t)r->first[chunks];
        r->quads = sp_alloc(quads, (size_t)multiply_quad(r->op->kind.dim) * sizeof *r->quads);
        r->index = sp_alloc(quads, 4 * sizeof *r->index);
        r->sums = sp_alloc(quads, 8 * (size_t)r->width * sizeof *r->sums);
        fits = r->quads && r->index && r->sums;
    }
    for (int32_t c = 0; c < chunks && fits; c++)
        fill_up(r, c);
    for (int32_t k = 0; k < springs && fits; k++)
        put_spring(r, k, next[home[k]]++);
    sp_free(home);
    sp_free(next);
    return fits ? SP_OK : sp_fail_memory(err, (size_t)springs * (size_t)r->width * 2 * sizeof *r->sums);
}

void sp_reverse_products(const reverse *r, int64_t place, double *out) {
    const double *sums = r->sums + place / 4 * 8 * r->width + 2 * (place % 4);
    for (int a = 0; a < r->width; a++)
        out[a] = 0.5 * (sums[8 * (ptrdiff_t)a] + sums[8 * (ptrdiff_t)a + 1]);
}

static sp_status allocate(reverse *r, int threads, sp_error *err) {
    const sp_operator *op = r->op;
    const size_t size = vector_size(op), parts = (size_t)threads;
    bool fits = true;
    for (int q = 0; q < 2; q++) {
        reverse_pair *p = &r->of[q];
        p->u = sp_alloc(size, sizeof *p->u);
        p->v = sp_alloc(size, sizeof *p->v);
        p->next = op->blocks == 1 ? p->u : sp_alloc(size, sizeof *p->next);
        fits = fits && p->u && p->v && p->next;
    }
    r->weight = sp_alloc((size_t)op->n, 2 * (size_t)kinds_of(op) * sizeof *r->weight);
    r->force = sp_alloc(parts, (size_t)op->largest * (size_t)op->row * sizeof *r->force);
    r->density = sp_alloc(r->masses ? size / 2 : 1, sizeof *r->density);
    r->active = sp_alloc((size_t)op->blocks, sizeof *r->active);
    if (!fits || !r->weight || !r->force || !r->density || !r->active)
        return sp_fail_memory(err, 6 * size * sizeof(double));
    return SP_OK;
}

sp_status sp_reverse_make(const forward *f, bool whole, bool masses, int threads, reverse *out, sp_error *err) {
    const int size = f->net->dof, blocks = f->op.blocks;
    threads = threads < 1 ? 1 : threads < blocks ? threads : blocks;
    reverse r = {.op = &f->op,
                 .net = f->net,
                 .omega = f->omega,
                 .whole = whole,
                 .masses = masses,
                 .width = whole ? size * (size + 1) / 2 : 2};
    r.of[0] = (reverse_pair){.lane = 0, .since = f->since[0], .second = f->velocity};
    r.of[1] = (reverse_pair){.lane = 1, .since = f->since[1]};
    sp_status status = allocate(&r, threads, err);
    if (status == SP_OK)
        status = sort_springs(&r, err);
    if (status == SP_OK)
        status = sp_pool_make(threads, &r.pool, err);
    if (status != SP_OK) {
        sp_reverse_free(&r);
        return status;
    }
    sp_recurrence_weights(r.op, r.net->mass, r.omega, r.weight);
    *out = r;
    return SP_OK;
}

static void begin(reverse *r, const double *u, const double *v) {
    const size_t size = vector_size(r->op), quads = (size_t)r->first[r->op->chunk[r->op->blocks]];
    for (int q = 0; q < 2; q++) {
        reverse_pair *p = &r->of[q];
        for (size_t k = 0; k < size; k++) {
            const bool field = (int)(k % 2) == p->lane;
            p->u[k] = field ? u[k] - v[k] : 0;
            p->v[k] = field ? -v[k] : 0;
        }
        if (p->next != p->u)
            memset(p->next, 0, size * sizeof *p->next);
    }
    memset(r->sums, 0, quads * 8 * (size_t)r->width * sizeof *r->sums);
    if (r->masses)
        memset(r->density, 0, size / 2 * sizeof *r->density);
    r->rough = 0;
}

/* ---- steps ---------------------------------------------------------------------------------------------------- */

static void advance_chunk(const reverse *r, int32_t block, int32_t chunk, double *force) {
    const sp_operator *op = r->op;
    const reverse_pair *p = &r->of[r->step.pair], *other = &r->of[1 - r->step.pair];
    const ptrdiff_t at = (ptrdiff_t)op->chunk_row[chunk] * op->row;
    const reverse_rows of = {.u = p->u + at,
                             .other_u = other->u + at,
                             .other_v = other->v + at,
                             .weight = r->weight + (ptrdiff_t)op->chunk_row[chunk] * 2 * kinds_of(op),
                             .v = p->v + at,
                             .next = p->next + at,
                             .force = force,
                             .density = r->masses ? r->density + at / 2 : NULL,
                             .count = op->chunk_row[chunk + 1] - op->chunk_row[chunk],
                             .alone = other->since[block] > r->k,
                             .lane = p->lane,
                             .step = r->step};
    sp_reverse_advance(op->kind.dim, op->dof, &of);
}

static void multiply_chunk(const reverse *r, int32_t chunk) {
    const sp_operator *op = r->op;
    const int64_t first = r->first[chunk];
    const multiply_job job = {.dim = op->kind.dim,
                              .rotations = op->kind.rotations,
                              .whole = r->whole,
                              .quads = r->quads + first * multiply_quad(op->kind.dim),
                              .count = r->first[chunk + 1] - first,
                              .share = r->step.share,
                              .sums = r->sums + first * 8 * r->width};
    if (op->wide)
        sp_multiply_wide(&job, r->of[r->step.pair].u);
    else
        sp_multiply(&job, r->of[r->step.pair].u);
}

static void visit_blocks(void *data, int part, int parts) {
    const reverse *r = data;
    const sp_operator *op = r->op;
    const double *u = r->of[r->step.pair].u;
    double *force = r->force + (size_t)part * (size_t)op->largest * (size_t)op->row;
    for (int32_t k = sp_pool_share(r->n_active, part, parts); k < sp_pool_share(r->n_active, part + 1, parts); k++) {
        const int32_t b = r->active[k];
        for (int32_t c = op->chunk[b]; c < op->chunk[b + 1]; c++) {
            if (r->step.has_adjoint)
                multiply_chunk(r, c);
            sp_operator_force(op, b, c, u, force);
            advance_chunk(r, b, c, force + (ptrdiff_t)(op->chunk_row[c] - op->first[b]) * op->row);
        }
    }
}

static void clear_rows(const reverse *r, double *x, int32_t block, bool one_lane, int lane) {
    const sp_operator *op = r->op;
    const ptrdiff_t end = (ptrdiff_t)op->first[block + 1] * op->row;
    for (ptrdiff_t k = (ptrdiff_t)op->first[block] * op->row; k < end; k++)
        if (!one_lane || k % 2 == lane)
            x[k] = 0;
}

/* After the step from k to k - 1. A field that has not reached a block is 0 there. Its adjoint is still needed in the
 * next step, and then no more. After the last step of the first field the other one still takes it up: where source and
 * detector share a grain, that is a part of the derivative. */
static void retire_blocks(const reverse *r, int64_t k) {
    const reverse_pair *p = &r->of[r->step.pair];
    if (k == 0)
        return;
    for (int32_t b = 0; b < r->op->blocks; b++) {
        if (p->since[b] == k) {
            clear_rows(r, p->u, b, true, p->lane);
            clear_rows(r, p->v, b, true, p->lane);
        } else if (p->since[b] == k + 1) {
            clear_rows(r, p->u, b, false, 0);
            clear_rows(r, p->v, b, false, 0);
            clear_rows(r, p->next, b, false, 0);
        }
    }
}

static void find_active(reverse *r, int64_t k) {
    r->n_active = 0;
    for (int32_t b = 0; b < r->op->blocks; b++)
        if (r->of[r->step.pair].since[b] <= k)
            r->active[r->n_active++] = b;
}

/* Squares of the norms of both lanes in the metric of the masses. */
static pair squares_of(const reverse *r, const double *u) {
    const sp_operator *op = r->op;
    const int kinds = kinds_of(op);
    pair sum = {0, 0};
    for (int64_t k = 0; k < op->n; k++)
        for (int a = 0; a < op->dof; a++) {
            const pair x = *(const pair_memory *)(u + k * op->row + quad_component(a));
            sum += r->weight[2 * kinds * k + (a >= op->kind.dim)] * (x * x);
        }
    return sum;
}

/* Rounding errors of k steps grow as their root, and that of the phase Omega t as k, with a smaller factor. */
static void add_rough(reverse *r, int64_t k) {
    const double weight = sqrt(1 + (double)k) + 0.2 * (double)k;
    for (int q = 0; q < 2; q++) {
        const pair squares = squares_of(r, r->of[q].u);
        r->rough += NORMS_EVERY * weight * sqrt(squares[0]) * sqrt(squares[1]);
    }
}

static void step(reverse *r, int64_t k) {
    reverse_pair *p = &r->of[r->step.pair];
    r->k = k;
    find_active(r, k);
    sp_pool_run(r->pool, visit_blocks, r);
    double *old = p->u;
    p->u = p->next;
    p->next = old;
    retire_blocks(r, k);
}

static void step_both(reverse *r, int64_t k, const reverse_work *w) {
    const double dk = k <= w->last ? w->d[k] : 0, ek = k <= w->last ? w->e[k] : 0, up = k < w->last ? w->e[k + 1] : 0;
    if (k % NORMS_EVERY == 0)
        add_rough(r, k);
    for (int q = 0; q < 2; q++) {
        r->step = (reverse_step){.pair = q,
                                 .p = dk + (q == 0 ? up : ek),
                                 .q = q == 0 ? up : dk,
                                 .d = q == 0 ? dk : ek,
                                 .share = k > 0 || r->of[q].second ? 1 : 0.5,
                                 .has_adjoint = k <= w->last};
        step(r, k);
    }
}

/* ---- the end -------------------------------------------------------------------------------------------------- */

/* Copies the lane of a vector to one over the network. */
static void take_lane(const reverse *r, const double *u, int lane, double *out) {
    const sp_operator *op = r->op;
    for (int64_t k = 0; k < op->n; k++)
        for (int a = 0; a < op->dof; a++)
            out[(int64_t)op->grain[k] * op->dof + a] =
                u[k * op->row + quad_component(a) + lane] / op->scale[k * op->dof + a];
}

/* The derivative by the first vector. In the last step the recurrence gives x = y + 2X alpha_1 - alpha_2, y being what
 * the other pair adds. For W, whose A_1 = (2X + 1) A_0, it is x + alpha_1; for T, whose A_1 = X A_0, it is y + X
 * alpha_1
 * - alpha_2 = (x + y - alpha_2)/2. before: u - v of the adjoint before the step, alpha_2; added: y. */
static void end_adjoint(int64_t n, bool second, const double *x, const double *one, const double *two,
                        const double *added, double *out) {
    for (int64_t k = 0; k < n; k++)
        out[k] = second ? x[k] + one[k] : 0.5 * (x[k] + added[k] - two[k]);
}

/* Fields and adjoints at k = 0. The adjoints of the last step need what came before it. */
static void end(reverse *r, const reverse_work *w) {
    const int64_t n = sp_network_dofs(r->net);
    const double up = w->last > 0 ? w->e[1] : 0;
    double *previous = w->x; /* v of the adjoint */
    for (int q = 0; q < 2; q++) {
        const reverse_pair *p = &r->of[q];
        take_lane(r, p->u, p->lane, w->first[q]);
        take_lane(r, p->u, 1 - p->lane, w->one[q]);
        take_lane(r, p->v, 1 - p->lane, previous);
        for (int64_t k = 0; k < n; k++)
            w->two[q][k] = w->one[q][k] - previous[k];
    }
    take_lane(r, r->of[1].v, r->of[1].lane, w->added); /* B_0 - B_1 */
    for (int64_t k = 0; k < n; k++)
        w->added[k] = (w->d[0] + up) * w->first[1][k] - up * w->added[k];
    step_both(r, 0, w);
    for (int q = 0; q < 2; q++) {
        const reverse_pair *p = &r->of[q];
        take_lane(r, p->u, 1 - p->lane, w->x);
        for (int64_t k = 0; k < n && q == 1; k++)
            w->added[k] = w->d[0] * w->first[0][k];
        end_adjoint(n, p->second, w->x, w->one[q], w->two[q], w->added, w->of[q]);
    }
}

void sp_reverse_run(reverse *r, const struct snapshot *from, const reverse_work *w) {
    begin(r, from->u, from->v);
    for (int64_t k = from->step - 1; k > 0; k--)
        step_both(r, k, w);
    end(r, w);
}
