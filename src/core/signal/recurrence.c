/* Propagates two vectors by the Chebyshev recurrence, block by block and in parallel. */
#include "signal/recurrence.h"
#include "base/base.h"
#include "base/clones.h"

#include <math.h>
#include <string.h>

typedef int64_t bits __attribute__((vector_size(16)));

/* With fewer blocks, waking other threads is not worthwhile. */
enum { BLOCKS_SHARED = 32, DOF_MAX = 6, LINE = 8 };
/* A block stays asleep while the squares of what reaches it are below this fraction of those of U_0. */
#define TINY 1e-80
/* Vectors of this many bytes exceed all caches, so results are written past the caches. */
#define PAST_CACHES (1.6e7)

sp_status sp_sparse_row_make(int64_t n, const double *vector, sparse_row *out, sp_error *err) {
    int64_t count = 0;
    for (int64_t k = 0; k < n; k++)
        count += vector[k] != 0;
    *out = (sparse_row){0, sp_alloc((size_t)count, sizeof *out->at), sp_alloc((size_t)count, sizeof *out->value)};
    if (!out->at || !out->value)
        return sp_fail_memory(err, (size_t)count * (sizeof *out->at + sizeof *out->value));
    for (int64_t k = 0; k < n; k++)
        if (vector[k] != 0) {
            out->at[out->n] = k;
            out->value[out->n++] = vector[k];
        }
    return SP_OK;
}

void sp_sparse_row_free(sparse_row *row) {
    sp_free(row->at);
    sp_free(row->value);
    *row = (sparse_row){0};
}

void sp_sparse_row_turn(const sp_operator *op, const double *mass, sparse_row *row) {
    for (int64_t k = 0; k < row->n; k++) {
        const int64_t dof = row->at[k], of = op->row_of[dof / op->dof];
        row->at[k] = sp_operator_at(op, dof);
        row->value[k] = row->value[k] * (mass ? mass[dof] : 1) / op->scale[of * op->dof + dof % op->dof];
    }
}

void sp_recurrence_free(recurrence *r) {
    sp_pool_free(r->pool);
    if (r->next != r->u)
        sp_free(r->next);
    sp_free(r->u);
    sp_free(r->v);
    sp_free(r->weight);
    sp_free(r->force);
    sp_free(r->awake);
    sp_free(r->active);
    sp_free(r->dots);
    sp_free(r->sizes);
    *r = (recurrence){0};
}

/* Masses of a grain: of translations, and of rotations. */
static int kinds_of(const sp_operator *op) { return op->kind.rotations ? 2 : 1; }

void sp_recurrence_weights(const sp_operator *op, const double *mass, double omega, double *weight) {
    const int kinds = kinds_of(op);
    for (int64_t k = 0; k < op->n; k++)
        for (int q = 0; q < kinds; q++) {
            const int a = q == 1 ? op->kind.dim : 0;
            const double scale = op->scale[k * op->dof + a];
            const double m = mass[(int64_t)op->grain[k] * op->dof + a] / (scale * scale);
            double *w = weight + 2 * kinds * k;
            w[q] = m;
            w[kinds + q] = 4 / (omega * omega * m);
        }
}

sp_status sp_recurrence_make(const sp_operator *op, const double *mass, double omega, int threads, recurrence *out,
                             sp_error *err) {
    recurrence r = {.op = op};
    const size_t size = ((size_t)op->n + 1) * (size_t)op->row, blocks = (size_t)op->blocks;
    sp_status status = SP_OK;
    threads = op->blocks < BLOCKS_SHARED || threads < 1 ? 1 : threads < op->blocks ? threads : op->blocks;
    r.u = sp_alloc(size, sizeof *r.u);
    r.v = sp_alloc(size, sizeof *r.v);
    r.next = op->blocks == 1 ? r.u : sp_alloc(size, sizeof *r.next);
    r.weight = sp_alloc((size_t)op->n, 2 * (size_t)kinds_of(op) * sizeof *r.weight);
    r.force = sp_alloc((size_t)threads, (size_t)op->largest * (size_t)op->row * sizeof *r.force);
    r.awake = sp_alloc(blocks, sizeof *r.awake);
    r.active = sp_alloc(blocks, sizeof *r.active);
    r.dots = sp_alloc(blocks, sizeof *r.dots);
    r.sizes = sp_alloc(blocks, sizeof *r.sizes);
    if (!r.u || !r.v || !r.next || !r.weight || !r.force || !r.awake || !r.active || !r.dots || !r.sizes)
        status = sp_fail_memory(err, 4 * size * sizeof(double));
    else
        status = sp_pool_make(threads, &r.pool, err);
    if (status == SP_OK)
        sp_recurrence_weights(op, mass, omega, r.weight);
    r.past_caches = (double)size * sizeof(double) > PAST_CACHES;
    if (status == SP_OK)
        *out = r;
    else
        sp_recurrence_free(&r);
    return status;
}

/* Mass of a component of a vector, given its index. */
static double mass_of(const recurrence *r, int64_t at) {
    const sp_operator *op = r->op;
    const bool turns = op->kind.rotations && at % op->row >= quad_component(op->kind.dim);
    return r->weight[2 * kinds_of(op) * (at / op->row) + turns];
}

static int32_t block_of(const sp_operator *op, int64_t row) {
    int32_t low = 0, high = op->blocks - 1;
    while (low < high) {
        const int32_t middle = low + (high - low + 1) / 2;
        if (op->first[middle] <= row)
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

void sp_recurrence_start(recurrence *r, int lane, bool second, const sparse_row *row) {
    r->second[lane] = second;
    r->start[lane] = 0;
    for (int64_t k = 0; k < row->n; k++) {
        const double m = mass_of(r, row->at[k]), value = row->value[k] / m;
        r->u[row->at[k] + lane] = value;
        r->v[row->at[k] + lane] = second ? 2 * value : 0;
        r->start[lane] += m * value * value;
        r->awake[block_of(r->op, row->at[k] / r->op->row)] = 1;
    }
}

double sp_recurrence_norm(const recurrence *r, const sparse_row *row) {
    double squares = 0;
    for (int64_t k = 0; k < row->n; k++)
        squares += row->value[k] * row->value[k] / mass_of(r, row->at[k]);
    return sqrt(squares);
}

/* ---- one step of a chunk -------------------------------------------------------------------------------------- */

static ALWAYS_INLINE pair absolute(pair x) { return (pair)((bits)x & (bits){INT64_MAX, INT64_MAX}); }

/* Products of chunks or blocks so far. */
typedef struct product_sums {
    pair_sum dot;
    pair size;
} product_sums;

/* What a chunk's rows need, from its first row on. */
typedef struct rows {
    const double *u, *weight;
    double *v, *next, *force;
    ptrdiff_t count;
    bool doubled;
} rows;

/* Takes the forces and clears them. */
static ALWAYS_INLINE void advance_rows(int dim, int dof, rows of, product_sums *sum) {
    const int kinds = dof > dim ? 2 : 1, row = quad_row(dof);
    pair dot[DOF_MAX] = {{0, 0}}, size[DOF_MAX] = {{0, 0}};
    for (ptrdiff_t k = 0; k < of.count; k++, of.weight += 2 * kinds)
        for (int a = 0; a < dof; a++) {
            const ptrdiff_t at = k * row + quad_component(a);
            const double mass = of.weight[a >= dim], step = of.weight[kinds + (a >= dim)];
            const pair old = *(const pair_memory *)(of.u + at);
            const pair pull = *(const pair_memory *)(of.force + at);
            const pair push = *(const pair_memory *)(of.v + at) - step * pull;
            const pair now = old + push;
            *(pair_memory *)(of.force + at) = (pair){0, 0};
            *(pair_memory *)(of.v + at) = push;
            *(pair_memory *)(of.next + at) = now;
            if (of.doubled) {
                const pair product = (mass * now[1]) * (pair){old[0], now[0]};
                dot[a] += product;
                size[a] += absolute(product);
            }
        }
    for (int a = 1; a < dof; a++) {
        dot[0] += dot[a];
        size[0] += size[a];
    }
    pair_add(&sum->dot, dot[0]);
    sum->size += size[0];
}

CLONES static void advance(int dim, int dof, rows of, product_sums *sum) {
    switch (10 * dim + dof) {
    case 11: advance_rows(1, 1, of, sum); break;
    case 22: advance_rows(2, 2, of, sum); break;
    case 23: advance_rows(2, 3, of, sum); break;
    case 33: advance_rows(3, 3, of, sum); break;
    default: advance_rows(3, 6, of, sum); break;
    }
}

#ifdef MACHINES
#pragma GCC push_options
#pragma GCC target("arch=x86-64-v4,prefer-vector-width=512")
typedef double v8 __attribute__((vector_size(64), aligned(64), may_alias));
typedef double v4 __attribute__((vector_size(32), aligned(32), may_alias));
typedef int64_t i8 __attribute__((vector_size(64), aligned(64)));

/* One of a grain's masses or step widths for each component of a line. In 2D with friction a line has components of
 * both kinds. */
static ALWAYS_INLINE v8 spread(int dim, int dof, int line, const double *x) {
    const double one = x[line], two = dim == 2 && dof == 3 ? x[1] : one;
    return (v8){one, one, one, one, two, two, two, two};
}

/* A line, or half a line for rows of two components. */
static ALWAYS_INLINE v8 line_at(int dof, const double *x) {
    return dof > 2 ? *(const v8 *)x : (v8)__builtin_ia32_pd512_256pd(*(const v4 *)x);
}

static ALWAYS_INLINE void set_line(int dof, double *x, v8 value, bool past_caches) {
    const v4 half = __builtin_shufflevector(value, value, 0, 1, 2, 3);
    if (dof == 2 && past_caches)
        __builtin_ia32_movntpd256(x, half);
    else if (dof == 2)
        *(v4 *)x = half;
    else if (past_caches)
        __builtin_ia32_movntpd512(x, value);
    else
        *(v8 *)x = value;
}

/* What advance_rows does, by lines of three components and in the same order. */
static ALWAYS_INLINE void advance_lines(int dim, int dof, rows of, bool past_caches, bool doubled, product_sums *sum) {
    const int kinds = dof > dim ? 2 : 1, lines = dof == 6 ? 2 : 1;
    const i8 positive = {INT64_MAX, INT64_MAX, INT64_MAX, INT64_MAX, INT64_MAX, INT64_MAX, INT64_MAX, INT64_MAX};
    v8 dot[2] = {{0}}, size[2] = {{0}};
    for (ptrdiff_t k = 0; k < of.count; k++, of.weight += 2 * kinds)
        for (int q = 0; q < lines; q++) {
            const ptrdiff_t at = k * quad_row(dof) + q * LINE;
            const v8 old = line_at(dof, of.u + at), pull = line_at(dof, of.force + at);
            const v8 push = line_at(dof, of.v + at) - spread(dim, dof, q, of.weight + kinds) * pull;
            const v8 now = old + push;
            set_line(dof, of.force + at, (v8){0}, false);
            set_line(dof, of.v + at, push, false);
            set_line(dof, of.next + at, now, past_caches);
            if (doubled) {
                const v8 second = __builtin_shufflevector(now, now, 1, 1, 3, 3, 5, 5, 7, 7);
                const v8 first = __builtin_shufflevector(old, now, 0, 8, 2, 10, 4, 12, 6, 14);
                const v8 product = (spread(dim, dof, q, of.weight) * second) * first;
                dot[q] += product;
                size[q] += (v8)((i8)product & positive);
            }
        }
    pair all[2] = {{0, 0}, {0, 0}};
    for (int a = 0; a < dof; a++) {
        all[0] += (pair){dot[a / 3][2 * (a % 3)], dot[a / 3][2 * (a % 3) + 1]};
        all[1] += (pair){size[a / 3][2 * (a % 3)], size[a / 3][2 * (a % 3) + 1]};
    }
    pair_add(&sum->dot, all[0]);
    sum->size += all[1];
    if (past_caches)
        __builtin_ia32_sfence();
}

static ALWAYS_INLINE void advance_each(int dim, int dof, rows of, bool past_caches, product_sums *sum) {
    if (past_caches)
        of.doubled ? advance_lines(dim, dof, of, true, true, sum) : advance_lines(dim, dof, of, true, false, sum);
    else
        of.doubled ? advance_lines(dim, dof, of, false, true, sum) : advance_lines(dim, dof, of, false, false, sum);
}

static void advance_wide(int dim, int dof, rows of, bool past_caches, product_sums *sum) {
    switch (10 * dim + dof) {
    case 22: advance_each(2, 2, of, past_caches, sum); break;
    case 23: advance_each(2, 3, of, past_caches, sum); break;
    case 33: advance_each(3, 3, of, past_caches, sum); break;
    default: advance_each(3, 6, of, past_caches, sum); break;
    }
}
#pragma GCC pop_options
#else
static void advance_wide(int dim, int dof, rows of, bool past_caches, product_sums *sum) {
    (void)dim, (void)dof, (void)of, (void)past_caches, (void)sum;
}
#endif

static void advance_chunk(const recurrence *r, int32_t chunk, double *force, product_sums *sum) {
    const sp_operator *op = r->op;
    const int32_t first = op->chunk_row[chunk];
    const ptrdiff_t at = (ptrdiff_t)first * op->row;
    const rows of = {.u = r->u + at,
                     .weight = r->weight + (ptrdiff_t)first * 2 * kinds_of(op),
                     .v = r->v + at,
                     .next = r->next + at,
                     .force = force,
                     .count = op->chunk_row[chunk + 1] - first,
                     .doubled = r->doubled};
    if (op->wide)
        advance_wide(op->kind.dim, op->dof, of, r->past_caches, sum);
    else
        advance(op->kind.dim, op->dof, of, sum);
}

pair sp_recurrence_block_squares(const recurrence *r, int32_t block, const double *u) {
    const sp_operator *op = r->op;
    pair sum = {0, 0};
    for (int64_t k = op->first[block]; k < op->first[block + 1]; k++)
        for (int a = 0; a < op->dof; a++) {
            const int64_t at = k * op->row + quad_component(a);
            const pair x = *(const pair_memory *)(u + at);
            sum += mass_of(r, at) * (x * x);
        }
    return sum;
}

/* Wakes a block, or drops what has arrived in it. */
static uint8_t wake(const recurrence *r, int32_t block) {
    const sp_operator *op = r->op;
    const pair squares = sp_recurrence_block_squares(r, block, r->next);
    const double tiny = op->kind.carried ? 0 : TINY; /* with a nonsymmetric K, what is dropped might have grown */
    if (squares[0] > tiny * r->start[0] || squares[1] > tiny * r->start[1] || !isfinite(squares[0] + squares[1]))
        return 1;
    const ptrdiff_t at = (ptrdiff_t)op->first[block] * op->row;
    const size_t size = (size_t)(op->first[block + 1] - op->first[block]) * (size_t)op->row * sizeof(double);
    memset(r->next + at, 0, size);
    memset(r->v + at, 0, size);
    r->dots[block] = r->sizes[block] = (pair){0, 0};
    return squares[0] + squares[1] > 0 ? 2 : 0;
}

/* Half a first step, because T_(-1) = T_1. */
static void halve_first(const recurrence *r, int32_t chunk, double *force) {
    const int64_t size = (int64_t)(r->op->chunk_row[chunk + 1] - r->op->chunk_row[chunk]) * r->op->row;
    for (int64_t k = 0; k < size; k++)
        force[k] *= r->second[k % 2] ? 1 : 0.5;
}

static void visit_blocks(void *data, int part, int parts) {
    const recurrence *r = data;
    const sp_operator *op = r->op;
    double *force = r->force + (size_t)part * (size_t)op->largest * (size_t)op->row;
    const int64_t begin = (int64_t)r->n_active * part / parts, end = (int64_t)r->n_active * (part + 1) / parts;
    for (int64_t k = begin; k < end; k++) {
        const int32_t b = r->active[k];
        product_sums sum = {0};
        for (int32_t c = op->chunk[b]; c < op->chunk[b + 1]; c++) {
            double *own = force + (ptrdiff_t)(op->chunk_row[c] - op->first[b]) * op->row;
            sp_operator_force(op, b, c, r->u, force);
            if (r->step == 0)
                halve_first(r, c, own);
            advance_chunk(r, c, own, &sum);
        }
        r->dots[b] = pair_total(&sum.dot);
        r->sizes[b] = sum.size;
        if (!r->awake[b])
            r->awake[b] = wake(r, b);
    }
}

/* Lists blocks that are awake and their neighbours, in order. */
static void find_active(recurrence *r) {
    const sp_operator *op = r->op;
    r->n_active = 0;
    for (int32_t b = 0; b < op->blocks; b++) {
        bool active = r->awake[b];
        for (int32_t k = op->adjacent_first[b]; k < op->adjacent_first[b + 1] && !active; k++)
            active = r->awake[op->adjacent[k]];
        if (active)
            r->active[r->n_active++] = b;
    }
}

recurrence_products sp_recurrence_step(recurrence *r) {
    product_sums sum = {0};
    find_active(r);
    sp_pool_run(r->pool, visit_blocks, r);
    for (int32_t k = 0; k < r->n_active; k++) {
        const int32_t b = r->active[k];
        pair_add(&sum.dot, r->dots[b]);
        sum.size += r->sizes[b];
        r->dropped += r->awake[b] == 2;
        r->awake[b] = r->awake[b] == 1;
    }
    double *old = r->u;
    r->u = r->next;
    r->next = old;
    r->step++;
    return (recurrence_products){pair_total(&sum.dot), sum.size};
}

double sp_recurrence_dropped(const recurrence *r, int64_t terms) {
    /* What is dropped would have grown like U_j = sin((j+1) theta)/sin(theta), at most terms + 1 times; the other
     * vector is at most 2 terms + 1. */
    const double n = 2 * (double)terms + 1;
    return r->dropped == 0 ? 0 : 4 * sqrt(TINY) * (double)r->dropped * n * n;
}

pair sp_recurrence_product(const recurrence *r, const sparse_row *row, pair *size) {
    pair_sum sum = {0};
    *size = (pair){0, 0};
    for (int64_t k = 0; k < row->n; k++) {
        const pair term = row->value[k] * *(const pair_memory *)(r->u + row->at[k]);
        pair_add(&sum, term);
        *size += absolute(term);
    }
    return pair_total(&sum);
}

pair sp_recurrence_squares(const recurrence *r) {
    pair sum = {0, 0};
    for (int32_t b = 0; b < r->op->blocks; b++)
        if (r->awake[b])
            sum += sp_recurrence_block_squares(r, b, r->u);
    return sum;
}
