/* Propagates two vectors by the Chebyshev recurrence, block by block and in parallel. */
#include "signal/recurrence.h"
#include "base/base.h"
#include "base/clones.h"

#include <math.h>
#include <string.h>

typedef pair pair_memory __attribute__((may_alias));
typedef int64_t bits __attribute__((vector_size(16)));

/* With fewer blocks, waking other threads is not worthwhile. */
enum { BLOCKS_SHARED = 32, DOF_MAX = 6, ROW = 8 };
/* A block stays asleep while the squares of what reaches it are below this fraction of those of U_0. */
#define TINY 1e-80
/* Vectors of this many bytes exceed all caches, so results are written past the caches. */
#define PAST_CACHES (1.6e7)

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

static int kinds_of(const sp_operator *op) { return op->quad ? 2 : op->dof; }

static void set_weights(recurrence *r, const double *mass, double omega) {
    const sp_operator *op = r->op;
    const int kinds = kinds_of(op);
    for (int64_t k = 0; k < op->n; k++)
        for (int q = 0; q < kinds; q++) {
            const int a = op->quad && q == 1 ? op->dim : q;
            const double scale = op->scale[k * op->dof + a];
            const double m = mass[(int64_t)op->grain[k] * op->dof + a] / (scale * scale);
            double *w = r->weight + 2 * kinds * k;
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
        set_weights(&r, mass, omega);
    r.past_caches = (double)size * sizeof(double) > PAST_CACHES;
    if (status == SP_OK)
        *out = r;
    else
        sp_recurrence_free(&r);
    return status;
}

/* Mass of component a of a row. */
static double mass_of(const recurrence *r, int64_t row, int a) {
    const int kinds = kinds_of(r->op);
    return r->weight[2 * kinds * row + (r->op->quad ? a / r->op->dim : a)];
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
        const int64_t grain = row->at[k] / r->op->row;
        const double m = mass_of(r, grain, (int)(row->at[k] % r->op->row / 2)), value = row->value[k] / m;
        r->u[row->at[k] + lane] = value;
        r->v[row->at[k] + lane] = second ? 2 * value : 0;
        r->start[lane] += m * value * value;
        r->awake[block_of(r->op, grain)] = 1;
    }
}

double sp_recurrence_norm(const recurrence *r, const sparse_row *row) {
    double squares = 0;
    for (int64_t k = 0; k < row->n; k++)
        squares +=
            row->value[k] * row->value[k] / mass_of(r, row->at[k] / r->op->row, (int)(row->at[k] % r->op->row / 2));
    return sqrt(squares);
}

/* ---- one step of a chunk -------------------------------------------------------------------------------------- */

static ALWAYS_INLINE pair absolute(pair x) { return (pair)((bits)x & (bits){INT64_MAX, INT64_MAX}); }

/* Takes the forces and clears them. */
static ALWAYS_INLINE void advance_rows(const recurrence *r, int dof, int row, bool quad, bool doubled, int32_t chunk,
                                       double *restrict force, recurrence_products *sum) {
    const int kinds = quad ? 2 : dof;
    const int32_t first = r->op->chunk_row[chunk], count = r->op->chunk_row[chunk + 1] - first;
    const double *u = r->u + (ptrdiff_t)first * row, *weight = r->weight + (ptrdiff_t)first * 2 * kinds;
    double *next = r->next + (ptrdiff_t)first * row, *v = r->v + (ptrdiff_t)first * row;
    pair dot[DOF_MAX] = {{0, 0}}, size[DOF_MAX] = {{0, 0}};
    for (ptrdiff_t k = 0; k < count; k++, weight += 2 * kinds)
        for (int a = 0; a < dof; a++) {
            const ptrdiff_t at = k * row + 2 * a;
            const double mass = weight[quad ? a / 2 : a], step = weight[kinds + (quad ? a / 2 : a)];
            const pair old = *(const pair_memory *)(u + at);
            const pair pull = *(const pair_memory *)(force + at);
            const pair push = *(const pair_memory *)(v + at) - step * pull;
            const pair now = old + push;
            *(pair_memory *)(force + at) = (pair){0, 0};
            *(pair_memory *)(v + at) = push;
            *(pair_memory *)(next + at) = now;
            if (doubled) {
                const pair product = (mass * now[1]) * (pair){old[0], now[0]};
                dot[a] += product;
                size[a] += absolute(product);
            }
        }
    for (int a = 1; a < dof; a++) {
        dot[0] += dot[a];
        size[0] += size[a];
    }
    sum->dot += dot[0];
    sum->size += size[0];
}

#if defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) &&     \
    defined(__x86_64__)
typedef double v4 __attribute__((vector_size(32), aligned(32), may_alias));
typedef double v8 __attribute__((vector_size(64), aligned(64), may_alias));
typedef int64_t i8 __attribute__((vector_size(64), aligned(64)));

/* The same for rows of quads, one row at a time. */
__attribute__((target("arch=x86-64-v4,prefer-vector-width=512"))) static void
advance_wide(const recurrence *r, bool doubled, int32_t chunk, double *restrict force, recurrence_products *sum) {
    const i8 positive = {INT64_MAX, INT64_MAX, INT64_MAX, INT64_MAX, INT64_MAX, INT64_MAX, INT64_MAX, INT64_MAX};
    const int32_t first = r->op->chunk_row[chunk], count = r->op->chunk_row[chunk + 1] - first;
    const v4 *weight = (const v4 *)r->weight + first;
    const v8 *u = (const v8 *)r->u + first;
    v8 *next = (v8 *)r->next + first, *v = (v8 *)r->v + first, *pull = (v8 *)force;
    v8 dot = {0}, size = {0};
    for (ptrdiff_t k = 0; k < count; k++) {
        const v8 mass = __builtin_shufflevector(weight[k], weight[k], 0, 0, 0, 0, 1, 1, 1, 1);
        const v8 step = __builtin_shufflevector(weight[k], weight[k], 2, 2, 2, 2, 3, 3, 3, 3);
        const v8 old = u[k], push = v[k] - step * pull[k], now = old + push;
        pull[k] = (v8){0};
        v[k] = push;
        if (r->past_caches)
            __builtin_ia32_movntpd512((double *)&next[k], now);
        else
            next[k] = now;
        if (doubled) {
            const v8 second = __builtin_shufflevector(now, now, 1, 1, 3, 3, 5, 5, 7, 7);
            const v8 product = (mass * second) * __builtin_shufflevector(old, now, 0, 8, 2, 10, 4, 12, 6, 14);
            dot += product;
            size += (v8)((i8)product & positive);
        }
    }
    if (r->past_caches)
        __builtin_ia32_sfence();
    sum->dot += ((pair){dot[0], dot[1]} + (pair){dot[2], dot[3]}) + (pair){dot[4], dot[5]};
    sum->size += ((pair){size[0], size[1]} + (pair){size[2], size[3]}) + (pair){size[4], size[5]};
}
#else
static void advance_wide(const recurrence *r, bool doubled, int32_t chunk, double *force, recurrence_products *sum) {
    (void)r, (void)doubled, (void)chunk, (void)force, (void)sum;
}
#endif

static void advance(const recurrence *r, int32_t chunk, double *force, recurrence_products *sum) {
    const sp_operator *op = r->op;
    if (op->wide)
        advance_wide(r, r->doubled, chunk, force, sum);
    else if (op->quad)
        advance_rows(r, 3, ROW, true, r->doubled, chunk, force, sum);
    else
        switch (op->dof) {
        case 1: advance_rows(r, 1, 2, false, r->doubled, chunk, force, sum); break;
        case 2: advance_rows(r, 2, 4, false, r->doubled, chunk, force, sum); break;
        case 3: advance_rows(r, 3, 6, false, r->doubled, chunk, force, sum); break;
        case 6: advance_rows(r, 6, 12, false, r->doubled, chunk, force, sum); break;
        default: break;
        }
}

static pair block_squares(const recurrence *r, int32_t block, const double *u) {
    const sp_operator *op = r->op;
    pair sum = {0, 0};
    for (int64_t k = op->first[block]; k < op->first[block + 1]; k++)
        for (int a = 0; a < op->dof; a++) {
            const pair x = *(const pair_memory *)(u + k * op->row + 2 * a);
            sum += mass_of(r, k, a) * (x * x);
        }
    return sum;
}

/* Wakes a block, or drops what has arrived in it. */
static uint8_t wake(const recurrence *r, int32_t block) {
    const sp_operator *op = r->op;
    const pair squares = block_squares(r, block, r->next);
    const double tiny = op->inner.carried ? 0 : TINY; /* with a nonsymmetric K, what is dropped might have grown */
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
        recurrence_products sum = {{0, 0}, {0, 0}};
        for (int32_t c = op->chunk[b]; c < op->chunk[b + 1]; c++) {
            double *own = force + (ptrdiff_t)(op->chunk_row[c] - op->first[b]) * op->row;
            sp_operator_force(op, b, c, r->u, force);
            if (r->step == 0)
                halve_first(r, c, own);
            advance(r, c, own, &sum);
        }
        r->dots[b] = sum.dot;
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
    recurrence_products sum = {{0, 0}, {0, 0}};
    find_active(r);
    sp_pool_run(r->pool, visit_blocks, r);
    for (int32_t k = 0; k < r->n_active; k++) {
        const int32_t b = r->active[k];
        sum.dot += r->dots[b];
        sum.size += r->sizes[b];
        r->dropped += r->awake[b] == 2;
        r->awake[b] = r->awake[b] == 1;
    }
    double *old = r->u;
    r->u = r->next;
    r->next = old;
    r->step++;
    return sum;
}

double sp_recurrence_dropped(const recurrence *r, int64_t terms) {
    /* What is dropped would have grown like U_j = sin((j+1) theta)/sin(theta), at most terms + 1 times; the other
     * vector is at most 2 terms + 1. */
    const double n = 2 * (double)terms + 1;
    return r->dropped == 0 ? 0 : 4 * sqrt(TINY) * (double)r->dropped * n * n;
}

pair sp_recurrence_product(const recurrence *r, const sparse_row *row, pair *size) {
    enum { WAYS = 4 }; /* independent sums, added in a fixed order */
    pair sum[WAYS] = {{0, 0}}, magnitude[WAYS] = {{0, 0}};
    int64_t k = 0;
    for (; k + WAYS <= row->n; k += WAYS)
        for (int q = 0; q < WAYS; q++) {
            const pair term = row->value[k + q] * *(const pair_memory *)(r->u + row->at[k + q]);
            sum[q] += term;
            magnitude[q] += absolute(term);
        }
    for (; k < row->n; k++) {
        const pair term = row->value[k] * *(const pair_memory *)(r->u + row->at[k]);
        sum[0] += term;
        magnitude[0] += absolute(term);
    }
    *size = (magnitude[0] + magnitude[1]) + (magnitude[2] + magnitude[3]);
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

pair sp_recurrence_squares(const recurrence *r) {
    pair sum = {0, 0};
    for (int32_t b = 0; b < r->op->blocks; b++)
        if (r->awake[b])
            sum += block_squares(r, b, r->u);
    return sum;
}
