/* Encloses the eigenvalues of a nonsymmetric matrix in Gershgorin discs. */
#include "linalg/discs.h"
#include "base/base.h"
#include "base/vector.h"
#include "linalg/arrays.h"
#include "linalg/eigen.h"

#include <cblas.h>
#include <float.h>
#include <lapacke.h> /* includes complex.h */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#undef I

void sp_discs_free(sp_discs *d) {
    sp_free(d->re); /* one block */
    sp_free(d->right);
    *d = (sp_discs){0};
}

sp_status sp_discs_empty(int64_t n, sp_discs *out, sp_error *err) {
    const size_t m = (size_t)n;
    double *block;
    *out = (sp_discs){.n = n};
    const sp_array arrays[] = {{&out->re, m}, {&out->im, m}, {&out->radius, m}, {&out->from, m}, {&out->to, m}, {0}};
    return sp_arrays_make(arrays, &block, err);
}

/* Dense n x n matrices by columns: eigenvectors V, approximate inverse Y of V, residuals R = A V - V D with the
 * eigenvalues D, and a product. */
typedef struct diagonalization {
    int64_t n;
    const sp_sparse *a;
    sp_discs d;
    double *v, *y, *r, *product; /* v and y belong to d */
    double *sum, *size, *noise;  /* [n] sums over rows */
    double *memory;
} diagonalization;

static sp_status diagonalization_make(const sp_sparse *a, diagonalization *f, sp_error *err) {
    const size_t n = (size_t)a->n;
    *f = (diagonalization){.n = a->n, .a = a};
    const sp_array vectors[] = {{&f->d.right, n * n}, {&f->d.left, n * n}, {0}};
    const sp_array arrays[] = {{&f->r, n * n}, {&f->product, n * n}, {&f->sum, n}, {&f->size, n}, {&f->noise, n}, {0}};
    double *block;
    sp_status status = sp_discs_empty(a->n, &f->d, err);
    if (status == SP_OK)
        status = sp_arrays_make(vectors, &block, err);
    f->v = f->d.right;
    f->y = f->d.left;
    return status == SP_OK ? sp_arrays_make(arrays, &f->memory, err) : status;
}

static sp_status find_vectors(diagonalization *f, sp_error *err) {
    for (int64_t c = 0; c < f->n; c++)
        for (int64_t q = f->a->p[c]; q < f->a->p[c + 1]; q++)
            f->r[c * f->n + f->a->i[q]] = f->a->x[q];
    return sp_eigen_general(f->n, f->r, f->d.re, f->d.im, f->v, err);
}

static sp_status find_inverse(diagonalization *f, sp_error *err) {
    const lapack_int n = (lapack_int)f->n;
    lapack_int *pivots = sp_alloc((size_t)n, sizeof *pivots);
    if (!pivots)
        return sp_fail_memory(err, (size_t)n * sizeof *pivots);
    memcpy(f->y, f->v, (size_t)f->n * (size_t)f->n * sizeof *f->y);
    lapack_int info = LAPACKE_dgetrf_work(LAPACK_COL_MAJOR, n, n, f->y, n, pivots);
    if (info == 0) /* the product serves as dgetri's workspace of at least n */
        info = LAPACKE_dgetri_work(LAPACK_COL_MAJOR, n, f->y, n, pivots, f->product, n * (n < 64 ? n : 64));
    sp_free(pivots);
    return info == 0 ? SP_OK : sp_fail(err, SP_EREFUSED, "the eigenvectors are linearly dependent");
}

/* R = A V - V D, column by column. A pair (x, y) with eigenvalue a + i b satisfies A x = a x - b y, A y = b x + a y. */
static void find_residuals(diagonalization *f) {
    const int64_t n = f->n;
    memset(f->r, 0, (size_t)n * (size_t)n * sizeof *f->r);
    for (int64_t k = 0; k < n; k++) {
        const double *v = f->v + k * n, b = f->d.im[k], *other = b > 0 ? v + n : v - n;
        double *r = f->r + k * n;
        for (int64_t c = 0; c < n; c++)
            for (int64_t q = f->a->p[c]; q < f->a->p[c + 1]; q++)
                r[f->a->i[q]] += f->a->x[q] * v[c];
        for (int64_t i = 0; i < n; i++)
            r[i] -= f->d.re[k] * v[i] - (b != 0 ? b * other[i] : 0);
    }
}

static void multiply(int64_t n, const double *x, const double *y, double *out) {
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, (int)n, (int)n, (int)n, 1, x, (int)n, y, (int)n, 0, out,
                (int)n);
}

/* out = |X| w, X by columns. */
static void multiply_sizes(int64_t n, const double *x, const double *w, double *out) {
    memset(out, 0, (size_t)n * sizeof *out);
    for (int64_t c = 0; c < n; c++)
        for (int64_t i = 0; i < n; i++)
            out[i] += fabs(x[c * n + i]) * w[c];
}

static void row_sums(int64_t n, const double *x, double *out) {
    memset(out, 0, (size_t)n * sizeof *out);
    for (int64_t c = 0; c < n; c++)
        for (int64_t i = 0; i < n; i++)
            out[i] += fabs(x[c * n + i]);
}

/* Upper bound of the largest row sum of |1 - Y V|. */
static double inverse_error(diagonalization *f) {
    const int64_t n = f->n;
    multiply(n, f->y, f->v, f->product);
    for (int64_t i = 0; i < n; i++)
        f->product[i * n + i] -= 1;
    row_sums(n, f->product, f->sum);
    row_sums(n, f->v, f->size);
    multiply_sizes(n, f->y, f->size, f->noise);
    return sp_largest(n, f->sum) + 2 * (double)n * DBL_EPSILON * sp_largest(n, f->noise) + (double)n * DBL_EPSILON;
}

/* Bounds the rounding errors in the row sums of R. Each entry of A is a sum of terms no larger than the largest entry,
 * known to a few roundings. */
static void residual_noise(diagonalization *f) {
    const int64_t n = f->n;
    double top = 0, turn = 0;
    row_sums(n, f->v, f->size);
    memset(f->noise, 0, (size_t)n * sizeof *f->noise);
    for (int64_t q = 0; q < f->a->p[n]; q++)
        top = fmax(top, fabs(f->a->x[q]));
    for (int64_t c = 0; c < n; c++) {
        turn = fmax(turn, fabs(f->d.re[c]) + fabs(f->d.im[c]));
        for (int64_t q = f->a->p[c]; q < f->a->p[c + 1]; q++) {
            const double entries = (double)(f->a->p[c + 1] - f->a->p[c]);
            f->noise[f->a->i[q]] += DBL_EPSILON * ((entries + 4) * fabs(f->a->x[q]) + 16 * top) * f->size[c];
        }
    }
    for (int64_t i = 0; i < n; i++)
        f->noise[i] += 8 * DBL_EPSILON * turn * f->size[i];
}

/* Row sums of |W| in V^-1 A V = D + W, with W = V^-1 R = (1 - F)^-1 Y R and F = 1 - Y V. */
static sp_status find_radii(diagonalization *f, sp_error *err) {
    const int64_t n = f->n;
    const double off = inverse_error(f);
    if (!(off < 0.5))
        return sp_fail(err, SP_EREFUSED, "the eigenvectors are nearly dependent: their inverse has an error of %.2g",
                       off);
    residual_noise(f);
    row_sums(n, f->r, f->sum);
    for (int64_t i = 0; i < n; i++)
        f->noise[i] += (double)n * DBL_EPSILON * f->sum[i];
    multiply(n, f->y, f->r, f->product);
    row_sums(n, f->product, f->sum);
    multiply_sizes(n, f->y, f->noise, f->size);
    for (int64_t i = 0; i < n; i++)
        f->sum[i] = (f->sum[i] + f->size[i]) * (1 + 2 * (double)n * DBL_EPSILON);
    const double rest = off / (1 - off) * sp_largest(n, f->sum);
    for (int64_t i = 0; i < n; i++)
        f->d.radius[i] = f->sum[i] + rest;
    for (int64_t i = 0; i + 1 < n; i++) /* the two rows of a complex pair form one block, which is normal */
        if (f->d.im[i] > 0) {
            f->d.radius[i] = f->d.radius[i + 1] = f->d.radius[i] + f->d.radius[i + 1];
            i++;
        }
    return SP_OK;
}

static void project(diagonalization *f, const double *source, const double *detector) {
    const int n = (int)f->n;
    if (source)
        cblas_dgemv(CblasColMajor, CblasNoTrans, n, n, 1, f->y, n, source, 1, 0, f->d.from, 1);
    if (detector)
        cblas_dgemv(CblasColMajor, CblasTrans, n, n, 1, f->v, n, detector, 1, 0, f->d.to, 1);
}

static void transpose(int64_t n, double *x) {
    for (int64_t c = 0; c < n; c++)
        for (int64_t r = c + 1; r < n; r++) {
            const double keep = x[c * n + r];
            x[c * n + r] = x[r * n + c];
            x[r * n + c] = keep;
        }
}

/* The inverse by columns becomes left vectors, one a row. */
static void keep_vectors(bool wanted, sp_discs *d) {
    if (wanted) {
        transpose(d->n, d->left);
        return;
    }
    sp_free(d->right); /* one block */
    d->right = d->left = NULL;
}

sp_status sp_discs_make(const sp_sparse *a, const double *source, const double *detector, bool vectors, sp_discs *out,
                        sp_error *err) {
    diagonalization f;
    sp_status status = diagonalization_make(a, &f, err);
    if (status == SP_OK)
        status = find_vectors(&f, err);
    if (status == SP_OK)
        status = find_inverse(&f, err);
    if (status == SP_OK) {
        find_residuals(&f);
        status = find_radii(&f, err);
        project(&f, source, detector);
    }
    sp_free(f.memory);
    if (status == SP_OK) {
        keep_vectors(vectors, &f.d);
        *out = f.d;
    } else
        sp_discs_free(&f.d);
    return status;
}

/* ---- components ------------------------------------------------------------------------------------------------- */

static int by_left(const void *a, const void *b, void *context) {
    const sp_discs *d = context;
    const int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    const double p = d->re[x] - d->radius[x], q = d->re[y] - d->radius[y];
    return (p > q) - (p < q);
}

static int64_t root_of(int64_t *owner, int64_t k) {
    while (owner[k] != k)
        k = owner[k] = owner[owner[k]];
    return k;
}

sp_status sp_discs_connect(const sp_discs *d, int64_t *owner, sp_error *err) {
    const int64_t n = d->n;
    int64_t *order = sp_alloc((size_t)n, sizeof *order);
    if (!order)
        return sp_fail_memory(err, (size_t)n * sizeof *order);
    for (int64_t k = 0; k < n; k++)
        owner[k] = order[k] = k;
    qsort_r(order, (size_t)n, sizeof *order, by_left, (void *)d);
    for (int64_t p = 0; p < n; p++) {
        const int64_t k = order[p];
        for (int64_t q = p + 1; q < n; q++) {
            const int64_t other = order[q];
            if (d->re[other] - d->radius[other] > d->re[k] + d->radius[k])
                break;
            if (hypot(d->re[k] - d->re[other], d->im[k] - d->im[other]) <= d->radius[k] + d->radius[other])
                owner[root_of(owner, other)] = root_of(owner, k);
        }
    }
    for (int64_t k = 0; k < n; k++)
        owner[k] = root_of(owner, k);
    sp_free(order);
    return SP_OK;
}
