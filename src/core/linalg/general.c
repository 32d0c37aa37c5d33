/* Dense nonsymmetric eigenproblems with LAPACK. */
#include "linalg/general.h"
#include "base/base.h"
#include "linalg/blas.h"

#include <math.h>

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
