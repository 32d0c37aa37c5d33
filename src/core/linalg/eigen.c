/* Dense eigenproblems with LAPACK. */
#include "linalg/eigen.h"

#include "base/base.h"

#include <cblas.h>
#include <lapacke.h> /* includes complex.h */
#include <limits.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>
#undef I

static bool lower_is_finite(int64_t n, const double *a) {
    for (int64_t c = 0; c < n; c++)
        for (int64_t r = c; r < n; r++)
            if (!isfinite(a[c * n + r]))
                return false;
    return true;
}

static sp_status check(int64_t n, const double *a, sp_error *err) {
    /* LAPACK's workspace sizes, such as 2 n^2, are 32-bit integers */
    if (n < 1 || n > 32000)
        return sp_fail(err, SP_EINVAL, "dense eigenproblem of order %lld, must be 1 .. 32000", (long long)n);
    if (!lower_is_finite(n, a))
        return sp_fail(err, SP_EINVAL, "dense eigenproblem: an entry of the matrix is not finite");
    return SP_OK;
}

static sp_status lapack_failed(const char *routine, lapack_int info, sp_error *err) {
    if (info == LAPACK_WORK_MEMORY_ERROR || info == LAPACK_TRANSPOSE_MEMORY_ERROR)
        return sp_fail(err, SP_ENOMEM, "%s: no memory", routine);
    return sp_fail(err, SP_EFAILED, "%s: no convergence (info = %d)", routine, (int)info);
}

sp_status sp_eigen_all(int64_t n, double *a, double *w, sp_error *err) {
    sp_status status = check(n, a, err);
    if (status != SP_OK)
        return status;
    const lapack_int order = (lapack_int)n;
    const size_t size = 1 + 6 * (size_t)n + 2 * (size_t)(n * n), whole = 3 + 5 * (size_t)n;
    double *work = sp_alloc(size, sizeof *work);
    lapack_int *integers = sp_alloc(whole, sizeof *integers);
    if (!work || !integers) {
        status = sp_fail_memory(err, size * sizeof *work + whole * sizeof *integers);
        goto out;
    }
    lapack_int info = LAPACKE_dsyevd_work(LAPACK_COL_MAJOR, 'V', 'L', order, a, order, w, work, (lapack_int)size,
                                          integers, (lapack_int)whole);
    if (info != 0)
        status = lapack_failed("dsyevd", info, err);
out:
    sp_free(integers);
    sp_free(work);
    return status;
}

sp_status sp_eigen_values(int64_t n, double *a, double *w, sp_error *err) {
    sp_status status = check(n, a, err);
    if (status != SP_OK)
        return status;
    const lapack_int order = (lapack_int)n;
    double best = 0, *work = NULL;
    lapack_int whole = 0, *integers = NULL;
    lapack_int info = LAPACKE_dsyevd_2stage_work(LAPACK_COL_MAJOR, 'N', 'L', order, a, order, w, &best, -1, &whole, -1);
    if (info != 0 || !(best >= 1 && best < INT_MAX))
        return lapack_failed("dsyevd_2stage", info, err);
    work = sp_alloc((size_t)best, sizeof *work);
    integers = sp_alloc((size_t)whole, sizeof *integers);
    if (!work || !integers)
        status = sp_fail_memory(err, (size_t)best * sizeof *work);
    else
        info = LAPACKE_dsyevd_2stage_work(LAPACK_COL_MAJOR, 'N', 'L', order, a, order, w, work, (lapack_int)best,
                                          integers, whole);
    if (info != 0)
        status = lapack_failed("dsyevd_2stage", info, err);
    sp_free(integers);
    sp_free(work);
    return status;
}

sp_status sp_tridiagonal_make(int64_t n, double *a, sp_tridiagonal *out, sp_error *err) {
    sp_status status = check(n, a, err);
    if (status != SP_OK)
        return status;
    const lapack_int order = (lapack_int)n, size = 64 * order;
    sp_tridiagonal t = {.n = n, .a = a};
    t.d = sp_alloc((size_t)n, sizeof *t.d);
    t.e = sp_alloc((size_t)n, sizeof *t.e);
    t.tau = sp_alloc((size_t)n, sizeof *t.tau);
    double *work = sp_alloc((size_t)size, sizeof *work);
    if (!t.d || !t.e || !t.tau || !work)
        status = sp_fail_memory(err, 67 * (size_t)n * sizeof(double));
    else {
        lapack_int info = LAPACKE_dsytrd_work(LAPACK_COL_MAJOR, 'L', order, a, order, t.d, t.e, t.tau, work, size);
        if (info != 0)
            status = lapack_failed("dsytrd", info, err);
    }
    sp_free(work);
    if (status == SP_OK)
        *out = t;
    else
        sp_tridiagonal_free(&t);
    return status;
}

void sp_tridiagonal_free(sp_tridiagonal *t) {
    sp_free(t->d);
    sp_free(t->e);
    sp_free(t->tau);
    *t = (sp_tridiagonal){0};
}

sp_status sp_tridiagonal_values(const sp_tridiagonal *t, double *w, sp_error *err) {
    double *e = sp_alloc((size_t)t->n, sizeof *e);
    if (!e)
        return sp_fail_memory(err, (size_t)t->n * sizeof *e);
    memcpy(w, t->d, (size_t)t->n * sizeof *w);
    memcpy(e, t->e, (size_t)t->n * sizeof *e);
    lapack_int info = LAPACKE_dsterf((lapack_int)t->n, w, e);
    sp_free(e);
    return info == 0 ? SP_OK : lapack_failed("dsterf", info, err);
}

sp_status sp_tridiagonal_vectors(const sp_tridiagonal *t, int64_t count, double *vectors, sp_error *err) {
    const size_t n = (size_t)t->n;
    const lapack_int order = (lapack_int)n, many = (lapack_int)count;
    lapack_int found = 0, info = 0;
    lapack_logical accurate = 0;
    sp_status status = SP_OK;
    if (count < 1 || count > t->n)
        return sp_fail(err, SP_EINVAL, "%lld eigenvectors asked for, must be 1 .. %lld", (long long)count,
                       (long long)t->n);
    double *d = sp_alloc(3 * n, sizeof *d), *work = sp_alloc(64 * n, sizeof *work);
    lapack_int *support = sp_alloc(2 * n, sizeof *support);
    if (!d || !work || !support) {
        status = sp_fail_memory(err, 69 * n * sizeof *d);
        goto out;
    }
    double *e = d + n, *w = d + 2 * n; /* dstemr overwrites both */
    memcpy(d, t->d, n * sizeof *d);
    memcpy(e, t->e, n * sizeof *e);
    info = LAPACKE_dstemr(LAPACK_COL_MAJOR, 'V', 'I', order, d, e, 0, 0, 1, many, &found, w, vectors, order, many,
                          support, &accurate);
    if (info != 0 || found != many) {
        status = lapack_failed("dstemr", info, err);
        goto out;
    }
    /* Q is a product of n-1 reflectors that act below the first row. */
    info = LAPACKE_dormtr_work(LAPACK_COL_MAJOR, 'L', 'L', 'N', order, many, t->a, order, t->tau, vectors, order, work,
                               (lapack_int)(64 * n));
    if (info != 0)
        status = lapack_failed("dormtr", info, err);
out:
    sp_free(support);
    sp_free(work);
    sp_free(d);
    return status;
}

void sp_project(int64_t n, int64_t count, const double *vectors, int64_t columns, const double *column, double *out) {
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, (int)count, (int)columns, (int)n, 1, vectors, (int)n, column,
                (int)n, 0, out, (int)count);
}

void sp_combine(int64_t n, int64_t count, const double *vectors, int64_t columns, const double *c, double *out) {
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, (int)n, (int)columns, (int)count, 1, vectors, (int)n, c,
                (int)count, 0, out, (int)n);
}

void sp_take_away(int64_t n, int64_t count, const double *vectors, int64_t columns, const double *c, double *out) {
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, (int)n, (int)columns, (int)count, -1, vectors, (int)n, c,
                (int)count, 1, out, (int)n);
}

sp_status sp_orthonormalize(int64_t n, int64_t count, double *vectors, double *tau, sp_error *err) {
    const lapack_int rows = (lapack_int)n, columns = (lapack_int)count;
    int info = LAPACKE_dgeqrf(LAPACK_COL_MAJOR, rows, columns, vectors, rows, tau);
    if (info == 0)
        info = LAPACKE_dorgqr(LAPACK_COL_MAJOR, rows, columns, columns, vectors, rows, tau);
    return info == 0 ? SP_OK : lapack_failed("dgeqrf", info, err);
}

void sp_project_out(int64_t n, int64_t count, const double *vectors, double *column, double *work) {
    if (count == 0)
        return;
    cblas_dgemv(CblasColMajor, CblasTrans, (int)n, (int)count, 1, vectors, (int)n, column, 1, 0, work, 1);
    cblas_dgemv(CblasColMajor, CblasNoTrans, (int)n, (int)count, -1, vectors, (int)n, work, 1, 1, column, 1);
}

sp_status sp_orthogonality(int64_t n, int64_t count, const double *vectors, double *largest, sp_error *err) {
    const int64_t block = 64;
    double *product = sp_alloc((size_t)(block * count), sizeof *product), most = 0;
    if (!product)
        return sp_fail_memory(err, (size_t)(block * count) * sizeof *product);
    for (int64_t first = 0; first < count;
         first += block) { /* vectors first, first + 1, ... with all vectors from first on */
        const int64_t many = count - first < block ? count - first : block, rest = count - first;
        sp_project(n, rest, vectors + first * n, many, vectors + first * n, product);
        for (int64_t c = 0; c < many; c++)
            for (int64_t r = c; r < rest; r++)
                most = fmax(most, fabs(product[c * rest + r] - (r == c)));
    }
    sp_free(product);
    *largest = most;
    return SP_OK;
}

/* ---- nonsymmetric ------------------------------------------------------------------------------------------------ */

sp_status sp_eigen_general(int64_t n, double *a, double *re, double *im, double *vectors, sp_error *err) {
    if (n < 1 || n > 32000)
        return sp_fail(err, SP_EINVAL, "dense eigenproblem of order %lld, must be 1 .. 32000", (long long)n);
    for (int64_t k = 0; k < n * n; k++)
        if (!isfinite(a[k]))
            return sp_fail(err, SP_EINVAL, "dense eigenproblem: an entry of the matrix is not finite");
    const lapack_int order = (lapack_int)n;
    double best = 0;
    lapack_int info =
        LAPACKE_dgeev_work(LAPACK_COL_MAJOR, 'N', 'V', order, a, order, re, im, NULL, 1, vectors, order, &best, -1);
    const size_t size = info == 0 && best > 4 * (double)n ? (size_t)best : 4 * (size_t)n;
    double *work = sp_alloc(size, sizeof *work);
    if (!work)
        return sp_fail_memory(err, size * sizeof *work);
    info = LAPACKE_dgeev_work(LAPACK_COL_MAJOR, 'N', 'V', order, a, order, re, im, NULL, 1, vectors, order, work,
                              (lapack_int)size);
    sp_free(work);
    return info == 0 ? SP_OK : sp_fail(err, SP_EFAILED, "dgeev: no convergence (info = %d)", (int)info);
}
