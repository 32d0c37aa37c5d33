/* Means, bootstrap errors, and straight-line fits. */
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

/* ---- straight lines ---------------------------------------------------------------------------------------------- */

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
