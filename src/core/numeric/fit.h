#ifndef SP_FIT_H
#define SP_FIT_H
/* Weighted least squares. */

#include <sonopack/status.h>
#include <stdint.h>

typedef struct sp_line {
    double slope, intercept;
    double slope_err, intercept_err; /* from the errors given; without errors from the scatter (NAN for 2 points) */
    double chi2;                     /* sum of squared deviations over squared errors (errors of 1 if none are given) */
    int64_t freedom;                 /* n - 2 */
} sp_line;

/* y = intercept + slope x, every point weighted with 1 / y_err^2; y_err NULL: equal weights. SP_EINVAL for fewer than 2
 * points, what is not finite, an error that is not positive, or a single x. */
SP_SHARED sp_status sp_fit_line(int64_t n, const double *x, const double *y, const double *y_err, sp_line *out,
                                sp_error *err);

#endif
