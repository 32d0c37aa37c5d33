/* Davidson's method for the lowest eigenvalues of a matrix that is nearly symmetric. The basis is orthonormal, so that
 * values on it stay in the field of values of A: those with the lowest real parts converge, as in the symmetric
 * problem. Left and right vectors are close to each other, and each basis vector serves both. */
#include "linalg/two_sided.h"
#include "base/base.h"
#include "base/vector.h"
#include "linalg/arrays.h"
#include "linalg/eigen.h"
#include "linalg/lanczos.h"

#include <cblas.h>
#include <lapacke.h> /* includes complex.h */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#undef I

enum { ROUNDS_MAX = 60, BASIS = 6 }; /* vectors of the basis for each eigenvalue: more make the small problem dear */

typedef struct search {
    sp_ldl *factor;
    const sp_sparse *a;
    const sp_two_sided_spec *spec;
    int64_t n, room, p;     /* length of a vector, vectors for which there is room, those in the basis */
    double *basis;          /* [room][n] */
    double *h;              /* basis A basis^T by columns, leading dimension room */
    double *image;          /* [2 x eigenvalues + 8][n] */
    double *small, *y, *yi; /* [room][room] copy of h, its eigenvectors, their inverse */
    double *re, *im, *part; /* [room], [room], [room][2 x eigenvalues] */
    double *memory;
    sp_two_sided t;
} search;

void sp_sparse_apply(const sp_sparse *a, bool transposed, const double *x, double *out) {
    if (!transposed)
        memset(out, 0, (size_t)a->n * sizeof *out);
    for (int64_t c = 0; c < a->n; c++) {
        double sum = 0;
        for (int64_t q = a->p[c]; q < a->p[c + 1]; q++) {
            if (transposed)
                sum += a->x[q] * x[a->i[q]];
            else
                out[a->i[q]] += a->x[q] * x[c];
        }
        if (transposed)
            out[c] = sum;
    }
}

void sp_two_sided_free(sp_two_sided *t) {
    sp_free(t->re); /* one block */
    *t = (sp_two_sided){0};
}

static sp_status allocate(search *z, sp_error *err) {
    const int64_t count = z->spec->wanted + z->spec->more, most = 2 * count + SP_LDL_LANES;
    z->room = BASIS * count + most;
    const size_t n = (size_t)z->n, m = (size_t)z->room, k = (size_t)count;
    const sp_array result[] = {{&z->t.re, k}, {&z->t.im, k}, {&z->t.right, k * n}, {&z->t.left, k * n}, {0}};
    const sp_array arrays[] = {{&z->basis, m * n},
                               {&z->h, m * m},
                               {&z->image, (size_t)most * n},
                               {&z->small, m * m},
                               {&z->y, m * m},
                               {&z->yi, m * m},
                               {&z->re, m},
                               {&z->im, m},
                               {&z->part, m * (size_t)most},
                               {0}};
    double *block;
    const sp_status status = sp_arrays_make(result, &block, err);
    return status == SP_OK ? sp_arrays_make(arrays, &z->memory, err) : status;
}

/* Orthonormalizes the `count` columns behind the basis, twice against it: the first time leaves rounding errors of what
 * was removed. */
static sp_status orthonormalize(search *z, int64_t count, sp_error *err) {
    const int64_t n = z->n;
    double *fresh = z->basis + z->p * n;
    sp_status status = SP_OK;
    for (int pass = 0; pass < 2 && status == SP_OK; pass++) {
        if (z->p > 0) {
            sp_project(n, z->p, z->basis, count, fresh, z->part);
            sp_take_away(n, z->p, z->basis, count, z->part, fresh);
        }
        for (int64_t c = 0; c < count; c++)
            cblas_dscal((int)n, 1 / fmax(sp_norm(n, fresh + c * n), 1e-300), fresh + c * n, 1);
        status = sp_orthonormalize(n, count, fresh, z->part, err);
    }
    return status;
}

/* z->part becomes the block of h at `row` and `column`. */
static void put_block(search *z, int64_t row, int64_t column, int64_t rows, int64_t columns) {
    for (int64_t c = 0; c < columns; c++)
        memcpy(z->h + (column + c) * z->room + row, z->part + c * rows, (size_t)rows * sizeof *z->h);
}

/* The columns behind the basis join it. */
static sp_status grow(search *z, int64_t count, sp_error *err) {
    const int64_t n = z->n, p = z->p;
    double *fresh = z->basis + p * n;
    const sp_status status = orthonormalize(z, count, err);
    for (int64_t c = 0; c < count; c++)
        sp_sparse_apply(z->a, false, fresh + c * n, z->image + c * n);
    sp_project(n, p + count, z->basis, count, z->image, z->part);
    put_block(z, 0, p, p + count, count);
    for (int64_t c = 0; c < count && p > 0; c++)
        sp_sparse_apply(z->a, true, fresh + c * n, z->image + c * n);
    if (p > 0) {
        sp_project(n, count, z->image, p, z->basis, z->part);
        put_block(z, p, 0, count, p);
    }
    z->p += count;
    return status;
}

static int by_real_part(const void *a, const void *b, void *context) {
    const int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    const double *re = context;
    return re[x] != re[y] ? (re[x] < re[y] ? -1 : 1) : (x > y) - (x < y); /* pairs stay together */
}

/* Eigenvalues that are 0 within the goal get an orthonormal basis of their space: their own vectors may be as good as
 * dependent. */
static sp_status join_zeros(search *z, sp_error *err) {
    const int64_t p = z->p;
    int count = 0;
    for (int64_t k = 0; k < p; k++)
        if (hypot(z->re[k], z->im[k]) < 0.5 * z->spec->goal)
            memcpy(z->small + p * count++, z->y + k * p, (size_t)p * sizeof *z->y);
    const sp_status status = count > 0 ? sp_orthonormalize(p, count, z->small, z->part, err) : SP_OK;
    for (int64_t k = p; k-- > 0;)
        if (hypot(z->re[k], z->im[k]) < 0.5 * z->spec->goal) {
            memcpy(z->y + k * p, z->small + p * --count, (size_t)p * sizeof *z->y);
            z->re[k] = z->im[k] = 0;
        }
    return status;
}

/* Eigenvalues and vectors of h, and the inverse of the vectors. */
static sp_status solve_small(search *z, sp_error *err) {
    const int p = (int)z->p;
    int *pivots = sp_alloc((size_t)p, sizeof *pivots);
    if (!pivots)
        return sp_fail_memory(err, (size_t)p * sizeof *pivots);
    for (int c = 0; c < p; c++)
        memcpy(z->small + (int64_t)c * p, z->h + c * z->room, (size_t)p * sizeof *z->small);
    sp_status status = sp_eigen_general(p, z->small, z->re, z->im, z->y, err);
    if (status == SP_OK)
        status = join_zeros(z, err);
    memcpy(z->yi, z->y, (size_t)p * (size_t)p * sizeof *z->y);
    if (status == SP_OK && (LAPACKE_dgetrf(LAPACK_COL_MAJOR, p, p, z->yi, p, pivots) != 0 ||
                            LAPACKE_dgetri(LAPACK_COL_MAJOR, p, z->yi, p, pivots) != 0))
        status = sp_fail(err, SP_EREFUSED, "the eigenvectors are linearly dependent");
    sp_free(pivots);
    return status;
}

/* The lowest eigenvalues of h and their vectors become those of A. */
static sp_status find_pairs(search *z, sp_error *err) {
    const int64_t p = z->p, n = z->n;
    sp_two_sided *t = &z->t;
    sp_status status = solve_small(z, err);
    int64_t *order = sp_alloc((size_t)p, sizeof *order);
    if (!order)
        return sp_fail_memory(err, (size_t)p * sizeof *order);
    for (int64_t k = 0; k < p; k++)
        order[k] = k;
    qsort_r(order, (size_t)p, sizeof *order, by_real_part, z->re);
    t->count = z->spec->wanted + z->spec->more;
    t->count -= z->im[order[t->count - 1]] > 0;
    for (int64_t k = 0; k < t->count && status == SP_OK; k++) {
        t->re[k] = z->re[order[k]];
        t->im[k] = z->im[order[k]];
        memcpy(z->small + k * p, z->y + order[k] * p, (size_t)p * sizeof *z->y);
        cblas_dcopy((int)p, z->yi + order[k], (int)p, z->part + k * p, 1);
    }
    t->wanted = z->spec->wanted + (t->im[z->spec->wanted - 1] > 0);
    sp_free(order);
    sp_combine(n, p, z->basis, t->count, z->small, t->right);
    sp_combine(n, p, z->basis, t->count, z->part, t->left);
    return status;
}

void sp_two_sided_residuals(const sp_two_sided *t, const sp_sparse *a, bool left, double *out) {
    const int64_t n = t->n;
    for (int64_t k = 0; k < t->count; k++) {
        const double *x = (left ? t->left : t->right) + k * n, turn = left ? -t->im[k] : t->im[k];
        const double *other = t->im[k] > 0 ? x + n : t->im[k] < 0 ? x - n : x;
        double *r = out + k * n;
        sp_sparse_apply(a, left, x, r);
        for (int64_t q = 0; q < n; q++)
            r[q] -= t->re[k] * x[q] - turn * other[q];
    }
}

/* Writes behind the basis what lessens the residuals that are too large; *count: so many. t->count is lowered to the
 * pairs that are good enough once there are enough of them; then *count = 0. */
static void correct(search *z, int64_t *count) {
    sp_two_sided *t = &z->t;
    const int64_t n = z->n, all = t->count;
    const double wide = 1e-3 * (t->re[all - 1] - t->re[t->wanted - 1]);
    double *fresh = z->basis + z->p * n;
    int64_t good = all;
    *count = 0;
    for (int side = 0; side < 2; side++) {
        sp_two_sided_residuals(t, z->a, side == 1, z->image);
        for (int64_t k = 0; k < all; k++) {
            const double *r = z->image + k * n, size = sp_norm(n, (side ? t->left : t->right) + k * n);
            const double goal = z->spec->goal, zero = t->re[k] == 0 && t->im[k] == 0 ? 100 * goal : goal;
            if (sp_norm(n, r) <= size * (k < t->wanted ? zero : fmax(goal, wide)))
                continue;
            good = k < good ? k : good;
            memcpy(fresh + (*count)++ * n, r, (size_t)n * sizeof *r);
        }
    }
    if (good >= t->wanted + (all - t->wanted) / 2) {
        t->count = good - (t->im[good - 1] > 0);
        *count = 0;
    }
    memset(fresh + *count * n, 0, (size_t)(SP_LDL_LANES * n) * sizeof *fresh);
    for (int64_t c = 0; c < *count; c += SP_LDL_LANES)
        sp_ldl_solve(z->factor, fresh + c * n, fresh + c * n);
}

/* A basis that is full begins again with the pairs found. */
static sp_status restart(search *z, sp_error *err) {
    const size_t block = (size_t)(z->t.count * z->n) * sizeof *z->basis;
    z->p = 0;
    memcpy(z->basis, z->t.right, block);
    sp_status status = grow(z, z->t.count, err);
    memcpy(z->basis + z->p * z->n, z->t.left, block);
    return status == SP_OK ? grow(z, z->t.count, err) : status;
}

static sp_status start(search *z, sp_error *err) {
    const double sigma = sp_ldl_sigma(z->factor);
    const int64_t count = z->spec->wanted + z->spec->more;
    sp_lanczos_pairs p = {0};
    const sp_lanczos_spec spec = {
        .low = -HUGE_VAL, .high = HUGE_VAL, .wanted = count, .tolerance = 1e-4, .floor = fabs(sigma)};
    sp_status status = sp_lanczos(z->factor, z->n, &spec, &p, err);
    if (status == SP_OK) {
        memcpy(z->basis, p.vector, (size_t)(count * z->n) * sizeof *z->basis);
        status = grow(z, count, err);
    }
    sp_lanczos_free(&p);
    return status;
}

sp_status sp_two_sided_make(sp_ldl *factor, const sp_sparse *a, const sp_two_sided_spec *spec, sp_two_sided *out,
                            sp_error *err) {
    search z = {.factor = factor, .a = a, .spec = spec, .n = a->n, .t = {.n = a->n}};
    int64_t count = 1;
    sp_status status = allocate(&z, err);
    if (status == SP_OK)
        status = start(&z, err);
    for (int round = 0; status == SP_OK && count > 0; round++) {
        status = find_pairs(&z, err);
        if (status == SP_OK && z.p > BASIS * z.t.count) {
            status = restart(&z, err);
            if (status == SP_OK)
                status = find_pairs(&z, err);
        }
        if (status == SP_OK)
            correct(&z, &count);
        if (status == SP_OK && count > 0)
            status = round < ROUNDS_MAX ? grow(&z, count, err)
                                        : sp_fail(err, SP_EREFUSED, "%lld motions did not converge in %d rounds",
                                                  (long long)z.t.wanted, ROUNDS_MAX);
    }
    sp_free(z.memory);
    if (status == SP_OK)
        *out = z.t;
    else
        sp_two_sided_free(&z.t);
    return status;
}
