/* Shift-invert Lanczos by ARPACK: the only file that calls it. ARPACK returns the eigenvalues nearest to the shift, of
 * which some lie outside the interval that is searched, and it may miss a copy of a degenerate one. So it is called
 * again, with more eigenvalues, or orthogonally to those found, until the number is the wanted one. */
#include "base/base.h"
#include "linalg/arrays.h"
#include "linalg/lanczos.h"

#include <arpack.h>
#include <cblas.h>
#include <float.h>
#include <limits.h>
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

enum { ROUNDS_MAX = 20, RESTARTS_MAX = 300, SPARE = 4, BASIS_MORE = 20 };

typedef struct search {
    sp_ldl *factor;
    const sp_lanczos_spec *spec;
    int64_t n, solves;
    a_int nev, ncv;
    double tolerance;
    double *basis, *residual, *workd, *workl, *value,
        *part;     /* [ncv][n], [n], [3][n], [ncv (ncv + 8)], [nev], scratch */
    a_int *select; /* [ncv] */
    double *memory;
} search;

/* ARPACK's reverse communication and all that it remembers between its calls are static. */
static pthread_mutex_t one_search = PTHREAD_MUTEX_INITIALIZER;

/* x -= Q (Q' x) for `count` orthonormal vectors, twice: once would leave a part of the order of the rounding errors of
 * what was removed. */
static void remove_known(const search *z, const double *q, int64_t count, double *x) {
    for (int pass = 0; pass < 2 && count > 0; pass++) {
        cblas_dgemv(CblasColMajor, CblasTrans, (int)z->n, (int)count, 1, q, (int)z->n, x, 1, 0, z->part, 1);
        cblas_dgemv(CblasColMajor, CblasNoTrans, (int)z->n, (int)count, -1, q, (int)z->n, z->part, 1, 1, x, 1);
    }
}

static void remove_all(const search *z, const sp_lanczos_pairs *found, double *x) {
    remove_known(z, z->spec->locked, z->spec->locked_count, x);
    remove_known(z, found->vector, found->count, x);
}

static sp_status allocate(search *z, int64_t known, sp_error *err) {
    const size_t n = (size_t)z->n, ncv = (size_t)z->ncv;
    const sp_array arrays[] = {{&z->basis, ncv * n},
                               {&z->residual, n},
                               {&z->workd, 3 * n},
                               {&z->workl, ncv * (ncv + 8)},
                               {&z->value, (size_t)z->nev},
                               {&z->part, (size_t)known + 1},
                               {0}};
    z->select = sp_alloc(ncv, sizeof *z->select);
    if (!z->select)
        return sp_fail_memory(err, ncv * sizeof *z->select);
    return sp_arrays_make(arrays, &z->memory, err);
}

static void release(search *z) {
    sp_free(z->memory);
    sp_free(z->select);
    z->memory = NULL;
    z->select = NULL;
}

/* The basis, from a start without symmetry; *converged: number of Ritz pairs. */
static sp_status iterate(search *z, const sp_lanczos_pairs *found, a_int iparam[11], a_int ipntr[11], sp_error *err) {
    a_int ido = 0, info = 1; /* 1: the start is given */
    const a_int n = (a_int)z->n, size = z->ncv * (z->ncv + 8);
    for (int64_t k = 0; k < z->n; k++)
        z->residual[k] = 1 + 0.5 * sin(2.0 * (double)k * (double)k + 1);
    remove_all(z, found, z->residual);
    memset(iparam, 0, 11 * sizeof *iparam);
    iparam[0] = 1; /* exact shifts */
    iparam[2] = RESTARTS_MAX;
    iparam[3] = 1;
    iparam[6] = 3; /* shift-invert */
    for (;;) {
        dsaupd_c(&ido, "I", n, "LM", z->nev, z->tolerance, z->residual, z->ncv, z->basis, n, iparam, ipntr, z->workd,
                 z->workl, size, &info);
        if (ido != 1 && ido != -1)
            break;
        double *x = z->workd + ipntr[0] - 1, *y = z->workd + ipntr[1] - 1;
        sp_ldl_solve_one(z->factor, x, y);
        remove_all(z, found, y);
        z->solves++;
    }
    if (info < 0 || info > 3)
        return sp_fail(err, SP_EFAILED, "ARPACK: dsaupd failed (info = %d)", (int)info);
    return SP_OK; /* 1: restarts are used up; 2, 3: no shifts left. Pairs that converged are still good. */
}

/* Vectors of the converged pairs, in place of the basis; returns their number, or -1. */
static int64_t extract(search *z, a_int iparam[11], a_int ipntr[11]) {
    const a_int n = (a_int)z->n, size = z->ncv * (z->ncv + 8);
    a_int info = 0;
    if (iparam[4] < 1)
        return 0;
    dseupd_c(1, "A", z->select, z->value, z->basis, n, sp_ldl_sigma(z->factor), "I", n, "LM", z->nev, z->tolerance,
             z->residual, z->ncv, z->basis, n, iparam, ipntr, z->workd, z->workl, size, &info);
    return info == 0 ? iparam[4] : -1;
}

/* Appends the pairs in the interval. *reached: distance from the shift within which all are known, apart from copies.
 */
static sp_status keep(const search *z, int64_t count, sp_lanczos_pairs *found, double *reached, sp_error *err) {
    const double sigma = sp_ldl_sigma(z->factor);
    const int64_t n = z->n;
    int64_t inside = 0;
    *reached = count == z->nev ? 0 : NAN;
    for (int64_t k = 0; k < count; k++) {
        inside += z->value[k] > z->spec->low && z->value[k] < z->spec->high;
        *reached = fmax(*reached, fabs(z->value[k] - sigma));
    }
    if (inside == 0)
        return SP_OK;
    double *value = sp_alloc((size_t)(found->count + inside), sizeof *value);
    double *vector = sp_alloc((size_t)(found->count + inside), (size_t)n * sizeof *vector);
    if (!value || !vector) {
        sp_free(value);
        sp_free(vector);
        return sp_fail_memory(err, (size_t)(found->count + inside) * (size_t)(n + 1) * sizeof *vector);
    }
    if (found->count > 0) {
        memcpy(value, found->value, (size_t)found->count * sizeof *value);
        memcpy(vector, found->vector, (size_t)(found->count * n) * sizeof *vector);
    }
    int64_t at = found->count;
    for (int64_t k = 0; k < count; k++)
        if (z->value[k] > z->spec->low && z->value[k] < z->spec->high) {
            double *x = vector + at * n;
            value[at++] = z->value[k];
            memcpy(x, z->basis + k * n, (size_t)n * sizeof *x);
            cblas_dscal((int)n, 1 / sqrt(cblas_ddot((int)n, x, 1, x, 1)), x, 1);
        }
    sp_free(found->value);
    sp_free(found->vector);
    *found = (sp_lanczos_pairs){at, value, vector, found->solves};
    return SP_OK;
}

/* One run of ARPACK for `wanted` eigenvalues nearest to the shift and orthogonal to those found. */
static sp_status run(search *z, int64_t wanted, sp_lanczos_pairs *found, double *reached, sp_error *err) {
    const int64_t known = z->spec->locked_count + found->count, most = z->n - known;
    a_int iparam[11], ipntr[11];
    if (wanted + 2 > most || z->n > INT_MAX / 3)
        return sp_fail(err, SP_EREFUSED, "ARPACK: %lld modes of %lld degrees of freedom, must be fewer",
                       (long long)wanted, (long long)most);
    z->nev = (a_int)wanted;
    z->ncv = (a_int)(2 * wanted + BASIS_MORE < most ? 2 * wanted + BASIS_MORE : most);
    sp_status status = allocate(z, known, err);
    if (status == SP_OK) {
        pthread_mutex_lock(&one_search);
        status = iterate(z, found, iparam, ipntr, err);
        const int64_t count = status == SP_OK ? extract(z, iparam, ipntr) : 0;
        pthread_mutex_unlock(&one_search);
        if (count < 0)
            status = sp_fail(err, SP_EFAILED, "ARPACK: dseupd failed");
        if (status == SP_OK)
            status = keep(z, count, found, reached, err);
    }
    release(z);
    return status;
}

static int by_value(const void *a, const void *b, void *context) {
    const double *value = context, x = value[*(const int64_t *)a], y = value[*(const int64_t *)b];
    return x != y ? (x < y ? -1 : 1) : 0;
}

/* Moves the pairs to `out`, in ascending order. */
static sp_status sort_pairs(int64_t n, const sp_lanczos_pairs *p, sp_lanczos_pairs *out, sp_error *err) {
    const size_t count = (size_t)p->count;
    int64_t *order = sp_alloc(count, sizeof *order);
    sp_lanczos_pairs sorted = {p->count, sp_alloc(count, sizeof *sorted.value),
                               sp_alloc(count, (size_t)n * sizeof *sorted.vector), p->solves};
    const bool there = order && sorted.value && sorted.vector;
    for (int64_t k = 0; there && k < p->count; k++)
        order[k] = k;
    if (there)
        qsort_r(order, count, sizeof *order, by_value, p->value);
    for (int64_t k = 0; there && k < p->count; k++) {
        sorted.value[k] = p->value[order[k]];
        memcpy(sorted.vector + k * n, p->vector + order[k] * n, (size_t)n * sizeof *sorted.vector);
    }
    sp_free(order);
    if (there)
        *out = sorted;
    else
        sp_lanczos_free(&sorted);
    return there ? SP_OK : sp_fail_memory(err, count * (size_t)n * sizeof *sorted.vector);
}

sp_status sp_arpack(sp_ldl *factor, int64_t n, const sp_lanczos_spec *spec, sp_lanczos_pairs *out, sp_error *err) {
    const double sigma = sp_ldl_sigma(factor), span = fmax(spec->high - sigma, sigma - spec->low);
    search z = {.factor = factor, .spec = spec, .n = n};
    sp_lanczos_pairs found = {0};
    sp_status status = SP_OK;
    int64_t outside = 0;
    /* the error of a soft mode is to be small beside the mode itself, as in sp_lanczos; the softest matters most */
    const double softest = fmax(spec->low, -spec->floor), apart = sigma - softest;
    z.tolerance = spec->tolerance * (apart > 0 ? fmin(1, fmax(spec->floor, fabs(softest)) / apart) : 0.5);
    z.tolerance = fmax(z.tolerance, 4 * DBL_EPSILON);
    for (int round = 0; status == SP_OK && found.count < spec->wanted; round++) {
        const int64_t before = found.count, left = spec->wanted - before;
        double reached = 0;
        status = run(&z, left + outside + SPARE, &found, &reached, err);
        /* those outside the interval will be found again */
        outside = reached < span ? outside + left - (found.count - before) + left / 2 + SPARE : outside;
        const bool hopeless = found.count == before && !(reached < span);
        if (status == SP_OK && found.count < spec->wanted && (hopeless || round == ROUNDS_MAX))
            status = sp_fail(err, SP_EREFUSED, "ARPACK: %lld of %lld modes near omega^2 = %.6g converged",
                             (long long)found.count, (long long)spec->wanted, sigma);
    }
    found.solves = z.solves;
    if (status == SP_OK)
        status = sort_pairs(n, &found, out, err);
    sp_lanczos_free(&found);
    return status;
}
