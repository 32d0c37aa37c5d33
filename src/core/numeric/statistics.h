#ifndef SP_STATISTICS_H
#define SP_STATISTICS_H
/* Mean, spread and bootstrap errors of samples. NAN in, NAN out: nothing is left out silently. */

#include <sonopack/status.h>
#include <stdint.h>

SP_SHARED double sp_mean(int64_t n, const double *x);           /* NAN for n < 1 */
SP_SHARED double sp_sd(int64_t n, const double *x);             /* one standard deviation, n - 1 below; NAN for n < 2 */
SP_SHARED double sp_standard_error(int64_t n, const double *x); /* of the mean: sd / sqrt(n) */

enum { SP_BOOTSTRAP_GROUPS = 4 };

/* A statistic of samples in groups: of group g the samples pick[g][0 .. size[g]-1], numbered from 0; some may be there
 * several times. */
typedef double (*sp_statistic)(const int64_t *size, const int64_t *const *pick, void *user);

typedef struct sp_bootstrap_options {
    int32_t resamples; /* 1000 */
    uint64_t seed;     /* fixed: the same samples in the same order give the same error, bit for bit */
} sp_bootstrap_options;
SP_SHARED sp_bootstrap_options sp_bootstrap_options_default(void);

/* Standard error of a statistic: its standard deviation over resamples in which every group is drawn anew, with
 * replacement and by itself. One sample fewer is drawn than a group has (size[g] - 1 is what the statistic gets): the
 * error of a mean is then sd / sqrt(n) on average, while n drawn ones make it too small by sqrt((n-1)/n), which is 30%
 * for two samples (McCarthy and Snowden, Vital Health Stat. 2, no. 95, 1985). *standard_error is NAN where a group has
 * fewer than 2 samples or the statistic is not finite in more than one resample in ten. */
SP_SHARED sp_status sp_bootstrap(int groups, const int64_t *size, sp_statistic statistic, void *user,
                                 const sp_bootstrap_options *opt, double *standard_error, sp_error *err);

/* Many statistics of the same resamples, so that their errors belong together: writes value[0 .. values-1]. A group of
 * fewer than 2 samples has size 0 in resamples, where what depends on it must be NAN. */
typedef void (*sp_statistics_of)(const int64_t *size, const int64_t *const *pick, double *value, void *user);
/* standard_error[values], by the rule of sp_bootstrap for each; any number of groups. */
sp_status sp_bootstrap_many(int groups, const int64_t *size, int values, sp_statistics_of statistics, void *user,
                            const sp_bootstrap_options *opt, double *standard_error, sp_error *err);

#endif
