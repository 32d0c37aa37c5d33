#ifndef SP_STATISTICS_H
#define SP_STATISTICS_H
/* Mean, standard deviation and bootstrap errors of samples, and straight lines through points. A NAN in the input of
 * the first three gives NAN: nothing is left out silently. */

#include <sonopack/status.h>
#include <stdint.h>

SP_SHARED double sp_mean(int64_t n, const double *x);           /* NAN for n < 1 */
SP_SHARED double sp_sd(int64_t n, const double *x);             /* standard deviation with n - 1; NAN for n < 2 */
SP_SHARED double sp_standard_error(int64_t n, const double *x); /* of the mean: sd / sqrt(n) */

/* A statistic of samples in groups. Of group g it uses samples pick[g][0 .. size[g]-1], numbered from 0, possibly with
 * repetitions. */
typedef double (*sp_statistic)(const int64_t *size, const int64_t *const *pick, void *user);

typedef struct sp_bootstrap_options {
    int32_t resamples; /* 1000 */
    uint64_t seed;     /* 1; the same samples in the same order give the same error, bit for bit */
} sp_bootstrap_options;
SP_SHARED sp_bootstrap_options sp_bootstrap_options_default(void);

/* Bootstrap standard error of a statistic: its standard deviation over resamples, with each group resampled separately,
 * with replacement. A resample has one sample fewer than the group. The error of a mean is then sd / sqrt(n) on
 * average; with n samples it would be too small by sqrt((n-1)/n), which is 30% for n = 2 (McCarthy and Snowden, Vital
 * Health Stat. 2, no. 95, 1985). *standard_error is NAN if a group has fewer than 2 samples, or the statistic is not
 * finite in more than one resample in ten. SP_EINVAL, SP_ENOMEM. */
SP_SHARED sp_status sp_bootstrap(int groups, const int64_t *size, sp_statistic statistic, void *user,
                                 const sp_bootstrap_options *opt, double *standard_error, sp_error *err);

/* Several statistics of the same resample: writes value[0 .. values-1]. Groups of fewer than 2 samples have size 0;
 * values that depend on them must be NAN. */
typedef void (*sp_statistics_of)(const int64_t *size, const int64_t *const *pick, double *value, void *user);
/* Bootstrap errors standard_error[values] of several statistics, from the same resamples, as by sp_bootstrap, for any
 * number of groups. */
sp_status sp_bootstrap_many(int groups, const int64_t *size, int values, sp_statistics_of statistics, void *user,
                            const sp_bootstrap_options *opt, double *standard_error, sp_error *err);

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
