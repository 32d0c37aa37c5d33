#ifndef SP_FIT_H
#define SP_FIT_H
/* Weighted linear regression. */

#include <sonopack/status.h>
#include <stdint.h>

typedef struct sp_line {
    double slope, intercept;
    double slope_err, intercept_err; /* from y_err, or without it from the scatter (NAN for 2 points) */
    double chi2;                     /* sum of squared deviations over squared errors (1 without y_err) */
    int64_t freedom;                 /* degrees of freedom, n - 2 */
} sp_line;

/* Fits y = intercept + slope x to n points, weighted with 1 / y_err^2, or equally if y_err is NULL. SP_EINVAL for fewer
 * than 2 points, values that are not finite, errors that are not positive, or equal x. */
SP_SHARED sp_status sp_fit_line(int64_t n, const double *x, const double *y, const double *y_err, sp_line *out,
                                sp_error *err);

#endif
