#include "base/base.h"
#include "linalg/blas.h"
#include "linalg/eigen.h"

#include <math.h>
#include <string.h>

static double dot(int64_t n, const double *x, const double *y) {
    double sum = 0;
    for (int64_t k = 0; k < n; k++)
        sum += x[k] * y[k];
    return sum;
}

/* The recurrence without reorthogonalisation: lost orthogonality repeats converged values and spoils none. Fills the
 * diagonal d and the subdiagonal e of the tridiagonal matrix; returns its order. */
static int lanczos(int64_t n, sp_operator apply, void *user, int steps, double *vectors, double *d, double *e) {
    double *v = vectors, *old = vectors + n, *next = vectors + 2 * n;
    for (int step = 0; step < steps; step++) {
        apply(user, v, next);
        d[step] = dot(n, v, next);
        for (int64_t k = 0; k < n; k++)
            next[k] -= d[step] * v[k] + (step > 0 ? e[step - 1] * old[k] : 0);
        e[step] = sqrt(dot(n, next, next));
        if (!(e[step] > 1e-14 * fabs(d[0]))) /* an invariant subspace: its values are exact */
            return step + 1;
        double *spare = old;
        old = v;
        v = next;
        next = spare;
        for (int64_t k = 0; k < n; k++)
            v[k] /= e[step];
    }
    return steps;
}

sp_status sp_lanczos_largest(int64_t n, sp_operator apply, void *user, const double *start, int steps, double *largest,
                             sp_error *err) {
    sp_status status = SP_OK;
    double *vectors = NULL, *d = NULL;
    const double norm = sqrt(dot(n, start, start));
    if (!(norm > 0 && isfinite(norm)) || steps < 1)
        return sp_fail(err, SP_EINVAL, "Lanczos: |start| = %g and %d steps, must both be above 0", norm, steps);
    vectors = sp_alloc(3 * (size_t)n, sizeof *vectors);
    d = sp_alloc(2 * (size_t)steps, sizeof *d);
    if (!vectors || !d) {
        status = sp_fail_memory(err, 3 * (size_t)n * sizeof *vectors);
        goto out;
    }
    for (int64_t k = 0; k < n; k++)
        vectors[k] = start[k] / norm;
    double *e = d + steps;
    const int order = lanczos(n, apply, user, steps, vectors, d, e);
    const lapack_int info = LAPACKE_dsterf(order, d, e);
    if (info != 0 || !isfinite(d[order - 1]))
        status = sp_fail(err, SP_EFAILED, "Lanczos: dsterf failed (info = %d)", (int)info);
    else
        *largest = d[order - 1];
out:
    sp_free(d);
    sp_free(vectors);
    return status;
}
