/* Studentised bootstrap intervals, of kept samples and of one at a time, and Student's t distribution. */
#include "numeric/interval.h"

#include "base/base.h"
#include "numeric/random.h"
#include "numeric/statistics.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Limit of t, in units of Student's quantile. */
static const double largest = 2;
/* Errors below this fraction of the error of all samples are rounding. */
static const double rounding = 1e-9;

sp_interval_options sp_interval_options_default(void) { return (sp_interval_options){.level = 0.95, .seed = 1}; }

int32_t sp_interval_resamples(double level) {
    const double needed = ceil(10 / (1 - level) - 1e-6);
    return needed > 1000 ? (int32_t)needed : 1000;
}

sp_status sp_level_check(double level, sp_error *err) {
    if (!(level >= SP_LEVEL_LEAST && level <= SP_LEVEL_MOST))
        return sp_fail(err, SP_EINVAL, "interval of level %g: must be %g to %g", level, SP_LEVEL_LEAST, SP_LEVEL_MOST);
    return SP_OK;
}

/* ---- quantiles -------------------------------------------------------------------------------------------------- */

double sp_quantile(int64_t n, const double *ascending, double p) {
    const double at = p * (double)(n + 1) - 1;
    if (!(at > 0))
        return ascending[0];
    if (at >= (double)(n - 1))
        return ascending[n - 1];
    const int64_t below = (int64_t)at;
    return ascending[below] + (at - (double)below) * (ascending[below + 1] - ascending[below]);
}

/* Probability of |T| < t: finite sums for integer degrees of freedom (Abramowitz and Stegun, 26.7.3 and 26.7.4). */
static double student_within(double t, int64_t freedom) {
    const double angle = atan2(t, sqrt((double)freedom)), c = cos(angle), s = sin(angle);
    const int64_t first = freedom % 2 ? 1 : 0;
    double term = freedom % 2 ? c : 1, sum = freedom > 1 ? term : 0;
    for (int64_t k = first + 2; k <= freedom - 2; k += 2) {
        term *= c * c * (double)(k - 1) / (double)k;
        sum += term;
    }
    return freedom % 2 ? (angle + s * sum) * M_2_PI : s * sum;
}

double sp_student_quantile(double p, int64_t freedom) {
    const double within = fabs(2 * p - 1);
    double low = 0, high = 1;
    while (student_within(high, freedom) < within && high < 1e12)
        high *= 2;
    while (high - low > 1e-12 * high) {
        const double middle = 0.5 * (low + high);
        *(student_within(middle, freedom) < within ? &low : &high) = middle;
        if (middle <= low && middle >= high)
            break;
    }
    return copysign(0.5 * (low + high), p - 0.5);
}

/* ---- intervals -------------------------------------------------------------------------------------------------- */

static int ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* t of a resample; infinite if its error is below 1e-9 of `scatter`, the error of all samples. */
static double t_of(double deviation, double error, double scatter) {
    if (error > rounding * scatter)
        return deviation / error;
    if (!(error >= 0) || isnan(deviation))
        return NAN;
    return fabs(deviation) > rounding * scatter ? copysign(INFINITY, deviation) : 0;
}

/* value - t_high error .. value - t_low error from the t of n resamples, some of which may be NAN or infinite.
 * `freedom` is that of Student's quantile. Reorders t. */
static sp_interval interval_of_t(int64_t n, double *t, double level, int64_t freedom, double value, double error) {
    static const sp_interval none = {NAN, NAN};
    if (freedom < 1 || !isfinite(value) || !isfinite(error))
        return none;
    const double tail = 0.5 * (1 - level), most = largest * sp_student_quantile(1 - tail, freedom);
    int64_t count = 0;
    for (int64_t k = 0; k < n; k++)
        if (!isnan(t[k]))
            t[count++] = fmax(-most, fmin(most, t[k]));
    if (count < 1 || 10 * count < 9 * n)
        return none;
    qsort(t, (size_t)count, sizeof *t, ascending);
    return (sp_interval){value - sp_quantile(count, t, 1 - tail) * error, value - sp_quantile(count, t, tail) * error};
}

/* Resamples and their results. */
typedef struct drawing {
    int64_t *numbers; /* drawn samples of all groups */
    const int64_t **pick;
    double *value, *error; /* [values] for all samples */
    double *one, *one_error;
    double *t; /* [values][resamples] */
} drawing;

static void drawing_free(drawing *d) {
    sp_free(d->numbers);
    sp_free(d->pick);
    sp_free(d->value);
    sp_free(d->t);
}

static sp_status drawing_make(const sp_interval_problem *p, size_t resamples, drawing *d, sp_error *err) {
    const size_t values = (size_t)p->values;
    size_t total = 0;
    for (int g = 0; g < p->groups; g++)
        total += (size_t)p->size[g];
    d->numbers = sp_alloc(total, sizeof *d->numbers);
    d->pick = sp_alloc((size_t)p->groups, sizeof(const int64_t *));
    d->value = sp_alloc(4 * values, sizeof *d->value);
    d->t = sp_alloc(values * resamples, sizeof *d->t);
    if (!d->numbers || !d->pick || !d->value || !d->t)
        return sp_fail_memory(err, total * sizeof *d->numbers + values * resamples * sizeof *d->t);
    d->error = d->value + values;
    d->one = d->error + values;
    d->one_error = d->one + values;
    for (int64_t g = 0, *next = d->numbers; g < p->groups; next += p->size[g++]) {
        d->pick[g] = next;
        for (int64_t s = 0; s < p->size[g]; s++)
            next[s] = s;
    }
    return SP_OK;
}

sp_status sp_intervals(const sp_interval_problem *p, const sp_interval_options *opt, sp_interval *out, sp_error *err) {
    if (p->groups < 1 || p->values < 1)
        return sp_fail(err, SP_EINVAL, "intervals of %d groups and %d values: must be 1 or more of both", p->groups,
                       p->values);
    sp_status status = sp_level_check(opt->level, err);
    if (status != SP_OK)
        return status;
    int64_t least = p->size[0];
    for (int g = 1; g < p->groups; g++)
        least = p->size[g] < least ? p->size[g] : least;
    for (int v = 0; v < p->values && least < 2; v++)
        out[v] = (sp_interval){NAN, NAN};
    if (least < 2)
        return SP_OK;
    const size_t resamples = (size_t)sp_interval_resamples(opt->level);
    drawing d = {0};
    status = drawing_make(p, resamples, &d, err);
    if (status != SP_OK)
        goto out;
    p->measure(p->size, d.pick, d.value, d.error, p->user);
    sp_random random = sp_random_make(opt->seed, SP_STREAM_BOOTSTRAP);
    for (size_t k = 0; k < resamples; k++) {
        for (int64_t g = 0, *next = d.numbers; g < p->groups; next += p->size[g++])
            for (int64_t s = 0; s < p->size[g]; s++)
                next[s] = (int64_t)sp_random_below(&random, (uint64_t)p->size[g]);
        p->measure(p->size, d.pick, d.one, d.one_error, p->user);
        for (int v = 0; v < p->values; v++)
            d.t[(size_t)v * resamples + k] = t_of(d.one[v] - d.value[v], d.one_error[v], d.error[v]);
    }
    for (int v = 0; v < p->values; v++)
        out[v] = interval_of_t((int64_t)resamples, d.t + (size_t)v * resamples, opt->level, least - 1, d.value[v],
                               d.error[v]);
out:
    drawing_free(&d);
    return status;
}

/* ---- means ------------------------------------------------------------------------------------------------------ */

typedef struct deviations {
    int values;
    const double *mean; /* [values] */
    const double *d;    /* [n][values] deviations from the mean */
    double *sum;        /* [2][values] scratch: sums and sums of squares over the drawn samples */
} deviations;

static void measure_means(const int64_t *size, const int64_t *const *pick, double *value, double *error, void *user) {
    const deviations *of = user;
    const int values = of->values;
    double *restrict sum = of->sum, *restrict squares = of->sum + values;
    for (int v = 0; v < 2 * values; v++)
        of->sum[v] = 0;
    for (int64_t k = 0; k < size[0]; k++) {
        const double *restrict d = of->d + pick[0][k] * values;
        for (int v = 0; v < values; v++) {
            sum[v] += d[v];
            squares[v] += d[v] * d[v];
        }
    }
    const double n = (double)size[0];
    for (int v = 0; v < values; v++) {
        const double variance = (squares[v] - sum[v] * sum[v] / n) / (n - 1);
        value[v] = of->mean[v] + sum[v] / n;
        error[v] = variance < 0 ? 0 : sqrt(variance / n);
    }
}

sp_status sp_intervals_of_means(int64_t n, int values, const double *const *x, const sp_interval_options *opt,
                                sp_interval *out, sp_error *err) {
    if (n < 2 || values < 1) {
        for (int v = 0; v < values; v++)
            out[v] = (sp_interval){NAN, NAN};
        return sp_level_check(opt->level, err);
    }
    const size_t m = (size_t)values;
    double *memory = sp_alloc(((size_t)n + 3) * m, sizeof *memory);
    if (!memory)
        return sp_fail_memory(err, ((size_t)n + 3) * m * sizeof *memory);
    double *mean = memory, *d = memory + 3 * m;
    for (int v = 0; v < values; v++) {
        mean[v] = sp_mean(n, x[v]);
        for (int64_t k = 0; k < n; k++)
            d[(size_t)k * m + (size_t)v] = x[v][k] - mean[v];
    }
    deviations of = {values, mean, d, memory + m};
    const sp_interval_problem problem = {1, &n, values, measure_means, &of};
    const sp_status status = sp_intervals(&problem, opt, out, err);
    sp_free(memory);
    return status;
}

/* ---- one sample at a time ---------------------------------------------------------------------------------------- */

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
            t[count++] = t_of(one - mean, one_error, error);
        }
        out[k] = interval_of_t(count, t, r->level, r->count - 1, r->first[k] + mean, error);
    }
    sp_free(t);
    return SP_OK;
}
