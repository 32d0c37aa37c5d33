/* Straight-line fits. */
#include "numeric/fit.h"

#include "base/base.h"

#include <math.h>

static sp_status check(int64_t n, const double *x, const double *y, const double *y_err, sp_error *err) {
    if (n < 2)
        return sp_fail(err, SP_EINVAL, "straight line: %lld points, at least 2 are needed", (long long)n);
    for (int64_t k = 0; k < n; k++) {
        if (!isfinite(x[k]) || !isfinite(y[k]))
            return sp_fail(err, SP_EINVAL, "straight line: point %lld is (%g, %g), finite numbers are needed",
                           (long long)k, x[k], y[k]);
        if (y_err && !(y_err[k] > 0 && isfinite(1 / y_err[k]) && isfinite(y_err[k])))
            return sp_fail(err, SP_EINVAL, "straight line: error of point %lld is %g, a positive number is needed",
                           (long long)k, y_err[k]);
    }
    return SP_OK;
}

sp_status sp_fit_line(int64_t n, const double *x, const double *y, const double *y_err, sp_line *out, sp_error *err) {
    sp_status status = check(n, x, y, y_err, err);
    if (status != SP_OK)
        return status;
    /* weights relative to the smallest error, so that squares neither overflow nor underflow */
    double unit = y_err ? y_err[0] : 1;
    for (int64_t k = 1; y_err && k < n; k++)
        unit = fmin(unit, y_err[k]);
    double w = 0, wx = 0, wy = 0;
    for (int64_t k = 0; k < n; k++) {
        double weight = y_err ? (unit / y_err[k]) * (unit / y_err[k]) : 1;
        w += weight;
        wx += weight * x[k];
        wy += weight * y[k];
    }
    double mx = wx / w, my = wy / w, wxx = 0, wxy = 0;
    for (int64_t k = 0; k < n; k++) {
        double weight = y_err ? (unit / y_err[k]) * (unit / y_err[k]) : 1;
        wxx += weight * (x[k] - mx) * (x[k] - mx);
        wxy += weight * (x[k] - mx) * (y[k] - my);
    }
    if (!(wxx > 0) || !isfinite(wxx))
        return sp_fail(err, SP_EINVAL, "straight line: all %lld points are at x = %g", (long long)n, mx);
    sp_line line = {.slope = wxy / wxx, .freedom = n - 2};
    line.intercept = my - line.slope * mx;
    for (int64_t k = 0; k < n; k++) {
        double off = (y[k] - my - line.slope * (x[k] - mx)) / (y_err ? y_err[k] : 1);
        line.chi2 += off * off;
    }
    double deviation = unit; /* of a point of weight 1 */
    if (!y_err)
        deviation = n > 2 ? sqrt(line.chi2 / (double)(n - 2)) : NAN;
    line.slope_err = deviation / sqrt(wxx);
    line.intercept_err = deviation * sqrt(1 / w + mx * mx / wxx);
    *out = line;
    return SP_OK;
}
