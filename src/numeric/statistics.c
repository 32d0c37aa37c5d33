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
    /* the second term removes what rounding left in the mean */
    double variance = (squares - sum * sum / (double)n) / (double)(n - 1);
    return variance < 0 ? 0 : sqrt(variance);
}

double sp_standard_error(int64_t n, const double *x) { return sp_sd(n, x) / sqrt((double)n); }

sp_bootstrap_options sp_bootstrap_options_default(void) { return (sp_bootstrap_options){.resamples = 1000, .seed = 1}; }

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
    int64_t finite = 0;
    for (int32_t k = 0; k < opt->resamples; k++) {
        const int64_t *pick[SP_BOOTSTRAP_GROUPS] = {0};
        int64_t *next = numbers;
        for (int g = 0; g < groups; g++) {
            pick[g] = next;
            for (int64_t s = 0; s < drawn[g]; s++)
                *next++ = (int64_t)sp_random_below(&random, (uint64_t)size[g]);
        }
        double v = statistic(drawn, pick, user);
        if (isfinite(v))
            value[finite++] = v;
    }
    *standard_error = 10 * finite >= 9 * (int64_t)opt->resamples ? sp_sd(finite, value) : NAN;
out:
    sp_free(numbers);
    sp_free(value);
    return status;
}
