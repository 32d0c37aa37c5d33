/* Block Lanczos iteration with thick restarts (Wu and Simon, SIAM J. Matrix Anal. Appl. 22, 602, 2000). Full
 * orthogonalization keeps degenerate eigenvalues from producing spurious copies. Directions that vanish, because there
 * are fewer distinct eigenvalues than steps, are replaced by random ones, which find further copies of an
 * eigenvalue. */
#include "linalg/lanczos.h"
#include "base/base.h"
#include "linalg/arrays.h"
#include "linalg/block.h"
#include "linalg/eigen.h"

#include <cblas.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCK = SP_BLOCK, PASSES_MAX = 4, RESTARTS_MAX = 15 };

typedef struct lanczos {
    sp_ldl *factor;
    const sp_lanczos_spec *spec;
    int64_t n, capacity, m;  /* m: columns of the basis with products in h, last block included */
    int64_t first;           /* first column that overlaps with the product of the last block in exact arithmetic */
    double *basis;           /* [capacity][n] */
    double *h;               /* basis^T (A - sigma)^-1 basis by columns: upper triangle, leading dimension capacity */
    double *next;            /* [BLOCK][n] products that become the next block */
    double *copy;            /* [BLOCK][n] */
    double *overlap, *sums;  /* [BLOCK][capacity], or of the locked vectors if they are more; of its parts */
    double b[BLOCK * BLOCK]; /* (A - sigma)^-1 last = basis h + next b, by columns */
    double *small, *theta,
        *residual;  /* eigenvectors [m][m] of h by columns, its eigenvalues, |b s| of each eigenvector s */
    int64_t *rank;  /* Ritz pairs in descending order of |theta| */
    double *memory; /* of all arrays except basis and rank */
    uint64_t random;
    sp_lanczos_pairs *out;
} lanczos;

/* SplitMix64, good enough for starting vectors. */
static double random_number(uint64_t *state) {
    uint64_t z = (*state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    z ^= z >> 31;
    return (double)(z >> 11) * 0x1p-53 - 0.5;
}

/* w -= q (q^T w) for `count` columns of q. Adds the coefficients to h, unless h is NULL. */
static void project(lanczos *z, const double *q, int64_t count, double *w, double *h) {
    if (count == 0)
        return;
    sp_pool *pool = sp_ldl_pool(z->factor);
    sp_block_dots(pool, z->n, q, count, w, z->sums, z->overlap);
    sp_block_subtract(pool, z->n, q, count, z->sums, w);
    for (int c = 0; h && c < BLOCK; c++)
        for (int64_t r = 0; r < count; r++)
            h[c * z->capacity + r] += z->overlap[c * count + r];
}

/* Faster than dnrm2, which guards against overflow; that cannot happen here. */
static double norm(int64_t n, const double *x) { return sqrt(cblas_ddot((int)n, x, 1, x, 1)); }

/* Upper Cholesky factor of the block's Gram matrix, in place. False if a column almost depends on the others. */
static bool cholesky(double g[BLOCK * BLOCK]) {
    for (int c = 0; c < BLOCK; c++) {
        const double whole = g[c * BLOCK + c];
        for (int r = 0; r <= c; r++) {
            double sum = g[c * BLOCK + r];
            for (int k = 0; k < r; k++)
                sum -= g[r * BLOCK + k] * g[c * BLOCK + k];
            if (r < c)
                g[c * BLOCK + r] = sum / g[r * BLOCK + r];
            else if (!(sum > 1e-10 * whole) || !(sum > 0))
                return false;
            else
                g[c * BLOCK + c] = sqrt(sum);
        }
    }
    return true;
}

/* w = q r with orthonormal q; false if the columns are dependent. Done twice, because the error of a single pass grows
 * with the square of the condition number. */
static bool orthonormalize(const lanczos *z, double *w, double r[BLOCK * BLOCK]) {
    const int64_t n = z->n;
    double g[2][BLOCK * BLOCK] = {{0}};
    for (int pass = 0; pass < 2; pass++) {
        sp_block_dots(NULL, n, w, BLOCK, w, z->sums, g[pass]);
        if (!cholesky(g[pass]))
            return false;
        cblas_dtrsm(CblasColMajor, CblasRight, CblasUpper, CblasNoTrans, CblasNonUnit, (int)n, BLOCK, 1, g[pass], BLOCK,
                    w, (int)n);
    }
    for (int c = 0; c < BLOCK; c++)
        for (int k = 0; k < BLOCK; k++) {
            double sum = 0;
            for (int q = k; q <= c; q++)
                sum += g[1][q * BLOCK + k] * g[0][c * BLOCK + q];
            r[c * BLOCK + k] = k <= c ? sum : 0;
        }
    return true;
}

/* Orthonormalizes column by column. A column with nothing left beyond rounding errors (relative to `scale`) becomes a
 * random direction. */
static void orthonormalize_columns(lanczos *z, double *w, int64_t known, const double scale[BLOCK]) {
    const int64_t n = z->n;
    for (int c = 0; c < BLOCK; c++) {
        double *x = w + c * n, before = norm(n, x);
        bool fresh = !(before > 1e-12 * scale[c]);
        for (int trial = 0; trial < 100; trial++) {
            if (fresh)
                for (int64_t k = 0; k < n; k++)
                    x[k] = random_number(&z->random);
            before = norm(n, x);
            cblas_dscal((int)n, 1 / before, x, 1);
            double left = 0;
            for (int pass = 0; pass < PASSES_MAX; pass++) {
                sp_project_out(n, z->spec->locked_count, z->spec->locked, x, z->overlap);
                sp_project_out(n, known, z->basis, x, z->overlap);
                sp_project_out(n, c, w, x, z->overlap);
                left = norm(n, x);
                if (!(left > 1e-10))
                    break;
                cblas_dscal((int)n, 1 / left, x, 1);
                if (left > 0.7)
                    break;
            }
            if (left > 0.7)
                break;
            fresh = true;
        }
    }
}

/* Makes w the next block: orthogonal to the basis and to the locked vectors, and orthonormal. h: the columns of the
 * last block; NULL for the first block. */
static void next_block(lanczos *z, double *w, double *h) {
    const int64_t n = z->n, known = h ? z->m : 0;
    double before[BLOCK], scale[BLOCK];
    for (int c = 0; c < BLOCK; c++)
        scale[c] = norm(n, w + c * n);
    if (h && z->first > 0) { /* overlaps that exist in exact arithmetic */
        const int64_t first = z->first;
        project(z, z->basis + first * n, known - first, w, h + first);
    }
    for (int pass = 0; pass < PASSES_MAX; pass++) {
        double kept = 1;
        for (int c = 0; c < BLOCK; c++)
            before[c] = norm(n, w + c * n);
        project(z, z->spec->locked, z->spec->locked_count, w, NULL);
        project(z, z->basis, known, w, h);
        for (int c = 0; c < BLOCK; c++) {
            const double after = norm(n, w + c * n);
            if (after > 1e-12 * scale[c])
                kept = fmin(kept, after / before[c]);
        }
        if (kept > 0.5)
            break;
    }
    memcpy(z->copy, w, (size_t)(BLOCK * n) * sizeof *w);
    bool weak = false;
    for (int c = 0; c < BLOCK; c++)
        weak = weak || !(norm(n, w + c * n) > 1e-12 * scale[c]);
    if (weak || !orthonormalize(z, w, z->b)) {
        memcpy(w, z->copy, (size_t)(BLOCK * n) * sizeof *w);
        orthonormalize_columns(z, w, known, scale);
        sp_block_dots(NULL, n, w, BLOCK, z->copy, z->sums, z->b);
    }
}

/* Extends the basis by one block. */
static void step(lanczos *z) {
    const int64_t n = z->n;
    double *last = z->basis + (z->m - BLOCK) * n;
    sp_ldl_solve(z->factor, last, z->next);
    z->out->solves += BLOCK;
    double *h = z->h + (z->m - BLOCK) * z->capacity;
    for (int c = 0; c < BLOCK; c++)
        memset(h + c * z->capacity, 0, (size_t)z->capacity * sizeof *h);
    next_block(z, z->next, h);
}

static int by_magnitude(const void *a, const void *b, void *context) {
    const double *theta = context;
    const int64_t p = *(const int64_t *)a, q = *(const int64_t *)b;
    const double x = fabs(theta[p]), y = fabs(theta[q]);
    return x != y ? (x > y ? -1 : 1) : (p > q) - (p < q);
}

/* Ritz values and residuals of the projected operator. */
static sp_status ritz(lanczos *z, sp_error *err) {
    const int64_t m = z->m;
    for (int64_t c = 0; c < m; c++)
        for (int64_t r = 0; r <= c; r++) /* lower triangle */
            z->small[r * m + c] = z->h[c * z->capacity + r];
    sp_status status = sp_eigen_all(m, z->small, z->theta, err);
    if (status != SP_OK)
        return status;
    for (int64_t k = 0; k < m; k++) {
        double squares = 0;
        for (int r = 0; r < BLOCK; r++) {
            double sum = 0;
            for (int c = 0; c < BLOCK; c++)
                sum += z->b[c * BLOCK + r] * z->small[k * m + m - BLOCK + c];
            squares += sum * sum;
        }
        z->residual[k] = sqrt(squares);
        z->rank[k] = k;
    }
    qsort_r(z->rank, (size_t)m, sizeof *z->rank, by_magnitude, z->theta);
    return SP_OK;
}

static double value_of(const lanczos *z, int64_t k) { return sp_ldl_sigma(z->factor) + 1 / z->theta[k]; }

/* Number of Ritz values in the interval that converged, up to the first that did not. *missing: how many more it takes.
 */
static int64_t converged(const lanczos *z, int64_t *missing) {
    int64_t count = 0, below = 0;
    for (int64_t q = 0; q < z->m; q++) {
        const int64_t k = z->rank[q];
        const double value = value_of(z, k);
        if (!(value > z->spec->low && value < z->spec->high))
            continue;
        const double own = fmax(fabs(value), z->spec->floor) * fabs(z->theta[k]); /* |lambda|/|lambda - sigma| */
        if (!(z->residual[k] <= z->spec->tolerance * fabs(z->theta[k]) * fmin(1, own)))
            break;
        count++;
        below += z->theta[k] < 0;
    }
    *missing = z->spec->wanted - count;
    if (*missing < z->spec->below - below)
        *missing = z->spec->below - below;
    return count;
}

/* Replaces the basis by its `keep` best Ritz vectors. Works on strips of rows, since memory for both bases is
 * lacking. */
static sp_status restart(lanczos *z, int64_t keep, sp_error *err) {
    enum { STRIP = 128 };
    const int64_t n = z->n, m = z->m;
    double *chosen = sp_alloc((size_t)(m * keep), sizeof *chosen), *strip = sp_alloc((size_t)m, STRIP * sizeof *strip);
    sp_status status = chosen && strip ? SP_OK : sp_fail_memory(err, (size_t)(m * (keep + STRIP)) * sizeof *chosen);
    if (status != SP_OK)
        goto out;
    for (int64_t q = 0; q < keep; q++)
        memcpy(chosen + q * m, z->small + z->rank[q] * m, (size_t)m * sizeof *chosen);
    for (int64_t row = 0; row < n; row += STRIP) {
        const int64_t rows = n - row < STRIP ? n - row : STRIP;
        for (int64_t c = 0; c < m; c++)
            memcpy(strip + c * STRIP, z->basis + c * n + row, (size_t)rows * sizeof *strip);
        cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, (int)rows, (int)keep, (int)m, 1, strip, STRIP, chosen,
                    (int)m, 0, z->basis + row, (int)n);
    }
    memset(z->h, 0, (size_t)(z->capacity * z->capacity) * sizeof *z->h);
    for (int64_t q = 0; q < keep; q++)
        z->h[q * z->capacity + q] = z->theta[z->rank[q]];
    z->m = keep;
out:
    sp_free(strip);
    sp_free(chosen);
    return status;
}

static int by_value(const void *a, const void *b, void *context) {
    const double *theta = context;
    const int64_t p = *(const int64_t *)a, q = *(const int64_t *)b;
    const double x = 1 / theta[p], y = 1 / theta[q];
    return x != y ? (x < y ? -1 : 1) : (p > q) - (p < q);
}

/* x = basis s + next b s/theta: one step of inverse iteration without a solve, since (A - sigma) x = basis s/theta. */
static sp_status extract_pairs(lanczos *z, int64_t count, sp_error *err) {
    const int64_t n = z->n, m = z->m;
    double *chosen = sp_alloc((size_t)(m * count), sizeof *chosen);
    double *tail = sp_alloc((size_t)count, BLOCK * sizeof *tail);
    int64_t *which = sp_alloc((size_t)count, sizeof *which), found = 0;
    sp_lanczos_pairs *p = z->out;
    sp_status status = SP_OK;
    p->value = sp_alloc((size_t)count, sizeof *p->value);
    p->vector = sp_alloc_bare((size_t)count, (size_t)n * sizeof *p->vector);
    if (!chosen || !tail || !which || !p->value || !p->vector) {
        status = sp_fail_memory(err, (size_t)(count * (n + m + BLOCK + 2)) * sizeof *chosen);
        goto out;
    }
    for (int64_t q = 0; q < m && found < count; q++) {
        const double value = value_of(z, z->rank[q]);
        if (value > z->spec->low && value < z->spec->high)
            which[found++] = z->rank[q];
    }
    qsort_r(which, (size_t)count, sizeof *which, by_value, z->theta);
    for (int64_t q = 0; q < count; q++) {
        const double *s = z->small + which[q] * m;
        p->value[q] = value_of(z, which[q]);
        memcpy(chosen + q * m, s, (size_t)m * sizeof *s);
        for (int r = 0; r < BLOCK; r++)
            for (int c = 0; c < BLOCK; c++)
                tail[q * BLOCK + r] += z->b[c * BLOCK + r] * s[m - BLOCK + c] / z->theta[which[q]];
    }
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, (int)n, (int)count, (int)m, 1, z->basis, (int)n, chosen,
                (int)m, 0, p->vector, (int)n);
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, (int)n, (int)count, BLOCK, 1, z->next, (int)n, tail, BLOCK,
                1, p->vector, (int)n);
    for (int64_t q = 0; q < count; q++)
        cblas_dscal((int)n, 1 / norm(n, p->vector + q * n), p->vector + q * n, 1);
    p->count = count;
out:
    sp_free(which);
    sp_free(tail);
    sp_free(chosen);
    return status;
}

static sp_status allocate(lanczos *z, sp_error *err) {
    const size_t n = (size_t)z->n, capacity = (size_t)z->capacity;
    const size_t overlap = capacity > (size_t)z->spec->locked_count ? capacity : (size_t)z->spec->locked_count;
    const size_t parts = (size_t)sp_block_parts(z->n);
    const sp_array arrays[] = {{&z->next, BLOCK * n},
                               {&z->copy, BLOCK * n},
                               {&z->h, capacity * capacity},
                               {&z->small, capacity * capacity},
                               {&z->overlap, overlap * BLOCK},
                               {&z->sums, overlap * BLOCK * parts},
                               {&z->theta, capacity},
                               {&z->residual, capacity},
                               {0}};
    z->rank = sp_alloc(capacity, sizeof *z->rank);
    z->basis = sp_alloc_bare(capacity, n * sizeof *z->basis); /* most searches need a part of it */
    if (!z->rank || !z->basis)
        return sp_fail_memory(err, capacity * (n + 1) * sizeof *z->basis);
    return sp_arrays_make(arrays, &z->memory, err);
}

static void append(lanczos *z) {
    memcpy(z->basis + z->m * z->n, z->next, (size_t)(BLOCK * z->n) * sizeof *z->next);
    z->m += BLOCK;
}

/* Whether the Ritz values of m columns, which cost as much as about m^2/3n further blocks, are better looked at late
 * than once too often. */
static bool is_costly(const lanczos *z, int64_t m) { return m * m > 6 * z->n; }

/* Columns until the next look. The number of converged pairs grows in proportion to that of further columns, or faster:
 * where looks are cheap they are not far apart. */
static int64_t columns_until_check(const lanczos *z, int64_t missing, double slope) {
    const bool costly = is_costly(z, z->m);
    const double more = costly ? 1.15 * (double)missing / slope + BLOCK : 0.9 * (double)missing / slope;
    return (int64_t)fmin(fmax(more, BLOCK), (costly ? 0.25 : 0.08) * (double)z->m);
}

static sp_status iterate(lanczos *z, sp_error *err) {
    const int64_t wanted = z->spec->wanted;
    int64_t check = is_costly(z, 2 * wanted) ? 2 * wanted + 4 * BLOCK : wanted + wanted / 2 + 3 * BLOCK,
            then = wanted / 2, before = 0;
    for (int restarts = 0;;) {
        append(z);
        step(z);
        const bool full = z->m + BLOCK > z->capacity;
        z->first = z->m - BLOCK;
        if (z->m < check && !full)
            continue;
        sp_status status = ritz(z, err);
        if (status != SP_OK)
            return status;
        int64_t missing;
        const int64_t count = converged(z, &missing);
        if (missing <= 0)
            return extract_pairs(z, count, err);
        const double slope = (double)(count - before + 1) / (double)(z->m - then);
        before = count;
        then = z->m;
        check = z->m + columns_until_check(z, missing, slope);
        if (full) {
            if (restarts++ == RESTARTS_MAX)
                return sp_fail(err, SP_EREFUSED, "Lanczos: %lld of %lld modes near omega^2 = %.6g converged",
                               (long long)count, (long long)wanted, sp_ldl_sigma(z->factor));
            int64_t keep = count + (z->m - count) / 2;
            keep = keep < z->capacity - 2 * BLOCK ? keep : z->capacity - 2 * BLOCK;
            status = restart(z, keep, err);
            if (status != SP_OK)
                return status;
            z->first = 0;
            check = keep + (z->capacity - keep) / 2;
            then = keep - BLOCK;
        }
    }
}

sp_status sp_lanczos(sp_ldl *factor, int64_t n, const sp_lanczos_spec *spec, sp_lanczos_pairs *out, sp_error *err) {
    sp_lanczos_pairs pairs = {0};
    lanczos z = {.factor = factor, .spec = spec, .n = n, .random = 1, .out = &pairs};
    const int64_t limit = n - spec->locked_count - BLOCK;
    z.capacity = spec->wanted * 4 + 8 * BLOCK; /* most searches need 3 times; a restart costs as much as it saves */
    z.capacity = z.capacity < limit ? z.capacity : limit;
    z.capacity -= z.capacity % BLOCK;
    if (spec->wanted < 1 || z.capacity < spec->wanted + 4 * BLOCK || n > INT32_MAX / BLOCK)
        return sp_fail(err, SP_EREFUSED, "Lanczos: %lld modes of %lld degrees of freedom, must be fewer",
                       (long long)spec->wanted, (long long)n);
    sp_status status = allocate(&z, err);
    if (status == SP_OK) {
        for (int64_t k = 0; k < BLOCK * n; k++)
            z.next[k] = random_number(&z.random);
        sp_ldl_solve(factor, z.next, z.next); /* damps the far end of the spectrum */
        next_block(&z, z.next, NULL);
        status = iterate(&z, err);
    }
    sp_free(z.memory);
    sp_free(z.basis);
    sp_free(z.rank);
    if (status == SP_OK)
        *out = pairs;
    else
        sp_lanczos_free(&pairs);
    return status;
}

void sp_lanczos_free(sp_lanczos_pairs *p) {
    sp_free(p->value);
    sp_free(p->vector);
    *p = (sp_lanczos_pairs){0};
}
