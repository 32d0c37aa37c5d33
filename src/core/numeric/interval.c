/* Studentised bootstrap intervals, and Student's t distribution. */
#include "numeric/interval.h"

#include "base/base.h"
#include "numeric/random.h"
#include "numeric/statistics.h"

#include <math.h>
#include <stdlib.h>

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

double sp_interval_t(double deviation, double error, double scatter) {
    if (error > rounding * scatter)
        return deviation / error;
    if (!(error >= 0) || isnan(deviation))
        return NAN;
    return fabs(deviation) > rounding * scatter ? copysign(INFINITY, deviation) : 0;
}

sp_interval sp_interval_of_t(int64_t n, double *t, double level, int64_t freedom, double value, double error) {
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
            d.t[(size_t)v * resamples + k] = sp_interval_t(d.one[v] - d.value[v], d.one_error[v], d.error[v]);
    }
    for (int v = 0; v < p->values; v++)
        out[v] = sp_interval_of_t((int64_t)resamples, d.t + (size_t)v * resamples, opt->level, least - 1, d.value[v],
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
