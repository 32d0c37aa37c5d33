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

typedef struct single {
    sp_statistic statistic;
    void *user;
} single;

static void measure_single(const int64_t *size, const int64_t *const *pick, double *value, void *user) {
    const single *one = user;
    *value = one->statistic(size, pick, one->user);
}

sp_status sp_bootstrap(int groups, const int64_t *size, sp_statistic statistic, void *user,
                       const sp_bootstrap_options *opt, double *standard_error, sp_error *err) {
    single one = {statistic, user};
    for (int g = 0; g < groups && opt->resamples >= 2; g++)
        if (size[g] < 2) {
            *standard_error = NAN;
            return SP_OK;
        }
    return sp_bootstrap_many(groups, size, 1, measure_single, &one, opt, standard_error, err);
}
