/* Means and bootstrap errors. */
#include "numeric/statistics.h"

#include "base/base.h"
#include "numeric/random.h"

#include <math.h>

double sp_mean(int64_t n, const double *x) {
    if (n < 1)
        return NAN;
    double sum = 0;
    for (int64_t k = 0; k < n; k++)
        sum += x[k];
    return sum / (double)n;
}

double sp_sd(int64_t n, const double *x) {
    if (n < 2)
        return NAN;
    double mean = sp_mean(n, x), squares = 0, sum = 0;
    for (int64_t k = 0; k < n; k++) {
        squares += (x[k] - mean) * (x[k] - mean);
        sum += x[k] - mean;
    }
    /* the second term corrects the rounding of the mean */
    double variance = (squares - sum * sum / (double)n) / (double)(n - 1);
    return variance < 0 ? 0 : sqrt(variance);
}

double sp_standard_error(int64_t n, const double *x) { return sp_sd(n, x) / sqrt((double)n); }

sp_bootstrap_options sp_bootstrap_options_default(void) { return (sp_bootstrap_options){.resamples = 1000, .seed = 1}; }

/* Standard deviation of the finite ones among n numbers, which are moved to the front. NAN if more than one in ten is
 * not finite. */
static double spread_of_finite(int64_t n, double *value) {
    int64_t finite = 0;
    for (int64_t k = 0; k < n; k++)
        if (isfinite(value[k]))
            value[finite++] = value[k];
    return 10 * finite >= 9 * n ? sp_sd(finite, value) : NAN;
}

sp_status sp_bootstrap(int groups, const int64_t *size, sp_statistic statistic, void *user,
                       const sp_bootstrap_options *opt, double *standard_error, sp_error *err) {
    if (groups < 1 || groups > SP_BOOTSTRAP_GROUPS || opt->resamples < 2)
        return sp_fail(err, SP_EINVAL, "bootstrap: %d groups and %d resamples; 1 to %d groups and at least 2 resamples",
                       groups, opt->resamples, SP_BOOTSTRAP_GROUPS);
    size_t total = 0;
    int64_t drawn[SP_BOOTSTRAP_GROUPS] = {0};
    for (int g = 0; g < groups; g++) {
        if (size[g] < 2) {
            *standard_error = NAN;
            return SP_OK;
        }
        drawn[g] = size[g] - 1;
        total += (size_t)drawn[g];
    }
    sp_status status = SP_OK;
    int64_t *numbers = sp_alloc(total, sizeof *numbers);
    double *value = sp_alloc((size_t)opt->resamples, sizeof *value);
    if (!numbers || !value) {
        status = sp_fail_memory(err, total * sizeof *numbers + (size_t)opt->resamples * sizeof *value);
        goto out;
    }
    sp_random random = sp_random_make(opt->seed, SP_STREAM_BOOTSTRAP);
    for (int32_t k = 0; k < opt->resamples; k++) {
        const int64_t *pick[SP_BOOTSTRAP_GROUPS] = {0};
        int64_t *next = numbers;
        for (int g = 0; g < groups; g++) {
            pick[g] = next;
            for (int64_t s = 0; s < drawn[g]; s++)
                *next++ = (int64_t)sp_random_below(&random, (uint64_t)size[g]);
        }
        value[k] = statistic(drawn, pick, user);
    }
    *standard_error = spread_of_finite(opt->resamples, value);
out:
    sp_free(numbers);
    sp_free(value);
    return status;
}

sp_status sp_bootstrap_many(int groups, const int64_t *size, int values, sp_statistics_of statistics, void *user,
                            const sp_bootstrap_options *opt, double *standard_error, sp_error *err) {
    if (groups < 1 || values < 1 || opt->resamples < 2)
        return sp_fail(err, SP_EINVAL,
                       "bootstrap: %d groups, %d values and %d resamples; at least 1, 1 and 2 are needed", groups,
                       values, opt->resamples);
    size_t total = 1;
    for (int g = 0; g < groups; g++)
        total += size[g] > 1 ? (size_t)size[g] - 1 : 0;
    const size_t resamples = (size_t)opt->resamples;
    sp_status status = SP_OK;
    int64_t *numbers = sp_alloc(total, sizeof *numbers), *drawn = sp_alloc((size_t)groups, sizeof *drawn);
    const int64_t **pick = sp_alloc((size_t)groups, sizeof(const int64_t *));
    double *value = sp_alloc((size_t)values * resamples, sizeof *value);
    double *one = sp_alloc((size_t)values, sizeof *one);
    if (!numbers || !drawn || !pick || !value || !one) {
        status = sp_fail_memory(err, total * sizeof *numbers + (size_t)values * resamples * sizeof *value);
        goto out;
    }
    sp_random random = sp_random_make(opt->seed, SP_STREAM_BOOTSTRAP);
    for (size_t k = 0; k < resamples; k++) {
        int64_t *next = numbers;
        for (int g = 0; g < groups; g++) {
            pick[g] = next;
            drawn[g] = size[g] > 1 ? size[g] - 1 : 0;
            for (int64_t s = 0; s < drawn[g]; s++)
                *next++ = (int64_t)sp_random_below(&random, (uint64_t)size[g]);
        }
        statistics(drawn, pick, one, user);
        for (int v = 0; v < values; v++)
            value[(size_t)v * resamples + k] = one[v];
    }
    for (int v = 0; v < values; v++)
        standard_error[v] = spread_of_finite(opt->resamples, value + (size_t)v * resamples);
out:
    sp_free(numbers);
    sp_free(drawn);
    sp_free(pick);
    sp_free(value);
    sp_free(one);
    return status;
}
