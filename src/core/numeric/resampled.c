/* Poisson bootstrap intervals from one sample at a time. */
#include "numeric/resampled.h"

#include "base/base.h"
#include "numeric/random.h"

#include <math.h>
#include <string.h>

enum { BLOCK = 256 }; /* numbers whose sums stay in the first-level cache */

int sp_poisson_weight(uint64_t seed, uint64_t sample, uint64_t resample) {
    sp_random random = {seed, SP_STREAM_POISSON, sample << 24 | resample};
    const double u = sp_random_uniform(&random);
    double term = exp(-1), sum = term; /* partial sums of the distribution, to 53 bits */
    int w = 0;
    while (u >= sum && w < 20) {
        term /= ++w;
        sum += term;
    }
    return w;
}

sp_resampled sp_resampled_none(void) { return (sp_resampled){0}; }

void sp_resampled_free(sp_resampled *r) {
    sp_free(r->first);
    sp_free(r->sums);
    *r = sp_resampled_none();
}

sp_status sp_resampled_make(int32_t numbers, double level, sp_resampled *out, sp_error *err) {
    if (numbers < 1)
        return sp_fail(err, SP_EINVAL, "%d numbers to be resampled: must be 1 or more", numbers);
    sp_status status = sp_level_check(level, err);
    if (status != SP_OK)
        return status;
    sp_resampled r = {.numbers = numbers, .resamples = sp_interval_resamples(level), .level = level};
    r.seed = sp_interval_options_default().seed;
    const size_t n = (size_t)numbers, all = (size_t)r.resamples + 1, small = (1 + SP_RESAMPLED_AHEAD) * n + all;
    r.first = sp_alloc(small, sizeof *r.first); /* zeroed */
    r.sums = sp_alloc(2 * all * n, sizeof *r.sums);
    if (!r.first || !r.sums) {
        sp_resampled_free(&r);
        return sp_fail_memory(err, (small + 2 * all * n) * sizeof *r.sums);
    }
    r.ahead = r.first + n;
    r.weight = r.ahead + SP_RESAMPLED_AHEAD * n;
    *out = r;
    return SP_OK;
}

/* Adds the waiting samples to the sums of one resample. */
static void sum_up(const sp_resampled *r, const double *w, double *restrict sum, double *restrict squares) {
    for (int32_t begin = 0; begin < r->numbers; begin += BLOCK) {
        const int32_t end = begin + BLOCK < r->numbers ? begin + BLOCK : r->numbers;
        for (int j = 0; j < r->waiting; j++) {
            const double weight = w[j], *restrict x = r->ahead + (size_t)j * (size_t)r->numbers;
            if (!(weight > 0))
                continue;
            for (int32_t k = begin; k < end; k++) {
                sum[k] += weight * x[k];
                squares[k] += weight * x[k] * x[k];
            }
        }
    }
}

static void sum_up_all(sp_resampled *r) {
    const uint64_t first = (uint64_t)(r->count - r->waiting);
    for (int32_t b = 0; b <= r->resamples; b++) {
        double w[SP_RESAMPLED_AHEAD], *sum = r->sums + 2 * (size_t)b * (size_t)r->numbers;
        for (int j = 0; j < r->waiting; j++) {
            w[j] = b < r->resamples ? sp_poisson_weight(r->seed, first + (uint64_t)j, (uint64_t)b) : 1;
            r->weight[b] += w[j];
        }
        sum_up(r, w, sum, sum + r->numbers);
    }
    r->waiting = 0;
}

void sp_resampled_add(sp_resampled *r, const double *x) {
    if (r->count == 0)
        memcpy(r->first, x, (size_t)r->numbers * sizeof *x);
    double *to = r->ahead + (size_t)r->waiting * (size_t)r->numbers;
    for (int32_t k = 0; k < r->numbers; k++)
        to[k] = x[k] - r->first[k];
    r->count++;
    if (++r->waiting == SP_RESAMPLED_AHEAD)
        sum_up_all(r);
}

/* Mean deviation from the first sample in a resample, and its standard error. */
static double mean_of(const sp_resampled *r, int32_t b, int32_t number, double *error) {
    const double *sum = r->sums + 2 * (size_t)b * (size_t)r->numbers + number, weight = r->weight[b];
    const double mean = sum[0] / weight, variance = (sum[r->numbers] / weight - mean * mean) / (weight - 1);
    /* smaller variances are rounding of a difference of squares */
    *error = weight > 1 && !(variance <= 1e-15 * mean * mean) ? sqrt(variance) : 0 * mean;
    return mean;
}

int64_t sp_resampled_least(double level) {
    const double tail = 0.5 * (1 - level);
    int64_t n = 2;
    while ((double)n * exp(1 - (double)n) * (1 - exp(-1)) >= 0.25 * tail)
        n++;
    return n;
}

static sp_interval student(int64_t n, double level, double mean, double error) {
    const double half = sp_student_quantile(0.5 * (1 + level), n - 1) * error;
    return isfinite(mean) && isfinite(half) ? (sp_interval){mean - half, mean + half} : (sp_interval){NAN, NAN};
}

sp_status sp_resampled_intervals(sp_resampled *r, sp_interval *out, sp_error *err) {
    double *t = sp_alloc((size_t)r->resamples, sizeof *t);
    if (!t)
        return sp_fail_memory(err, (size_t)r->resamples * sizeof *t);
    if (r->waiting > 0)
        sum_up_all(r);
    for (int32_t k = 0; k < r->numbers; k++) {
        double error, one_error;
        int32_t count = 0;
        const double mean = mean_of(r, r->resamples, k, &error);
        if (r->count < sp_resampled_least(r->level)) {
            out[k] = r->count > 1 ? student(r->count, r->level, r->first[k] + mean, error) : (sp_interval){NAN, NAN};
            continue;
        }
        for (int32_t b = 0; b < r->resamples; b++) {
            if (!(r->weight[b] > 0))
                continue; /* empty resample */
            const double one = mean_of(r, b, k, &one_error);
            t[count++] = sp_interval_t(one - mean, one_error, error);
        }
        out[k] = sp_interval_of_t(count, t, r->level, r->count - 1, r->first[k] + mean, error);
    }
    sp_free(t);
    return SP_OK;
}
