/* Fits a power law. */
#include "base/base.h"
#include "numeric/statistics.h"

#include <math.h>
#include <sonopack/study/study.h>

sp_status sp_fit_power(int64_t n, const double *x, const double *y, const double *y_err, double *exponent,
                       double *exponent_err, double *prefactor, sp_error *err) {
    if (n < 3)
        return sp_fail(err, SP_EINVAL, "power law: %lld points, at least 3 are needed", (long long)n);
    sp_status status = SP_OK;
    double *memory = sp_alloc((size_t)n, 3 * sizeof *memory);
    if (!memory)
        return sp_fail_memory(err, (size_t)n * 3 * sizeof *memory);
    double *lx = memory, *ly = memory + n, *le = memory + 2 * n;
    for (int64_t k = 0; k < n; k++) {
        if (!(x[k] > 0 && isfinite(x[k])) || !(y[k] > 0 && isfinite(y[k])) || (y_err && !(y_err[k] > 0))) {
            status = sp_fail(err, SP_EINVAL, "power law: point %lld is (%g, %g) with error %g; positive numbers needed",
                             (long long)k, x[k], y[k], y_err ? y_err[k] : NAN);
            goto out;
        }
        lx[k] = log(x[k]);
        ly[k] = log(y[k]);
        le[k] = y_err ? y_err[k] / y[k] : 1;
    }
    sp_line line;
    status = sp_fit_line(n, lx, ly, y_err ? le : NULL, &line, err);
    if (status != SP_OK)
        goto out;
    /* scatter beyond the given errors increases the error of the exponent; smaller scatter does not decrease it */
    double scatter = y_err ? fmax(1, sqrt(line.chi2 / (double)line.freedom)) : 1;
    *exponent = line.slope;
    *exponent_err = line.slope_err * scatter;
    *prefactor = exp(line.intercept);
out:
    sp_free(memory);
    return status;
}
