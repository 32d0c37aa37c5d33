/* How fronts change with distance: means, exponents and speeds with bootstrap errors. */
#include <sonopack/scaling.h>

#include "base/base.h"
#include "numeric/statistics.h"

#include <math.h>
#include <string.h>

/* Quantities averaged over the samples of a row. */
typedef enum mean_of { T10 = 0, T_PEAK, T_ZERO, AMPLITUDE, LOG_AMPLITUDE, WIDTH, WIDTH_PEAK, MEANS } mean_of;
/* Quantities of the bootstrap: for each interval between rows, then the fits. */
typedef enum interval { SPEED = 0, SPEED_PEAK, SPEED_ZERO, GAMMA, ALPHA, ALPHA_PEAK, INTERVALS } interval;
typedef enum fit_of { FIT_GAMMA = 0, FIT_GAMMA_LOG, FIT_ALPHA, FIT_ALPHA_PEAK, FIT_SPEED, FITS } fit_of;

static const mean_of fitted[FITS] = {AMPLITUDE, LOG_AMPLITUDE, WIDTH, WIDTH_PEAK, T10};
static const mean_of compared[INTERVALS] = {T10, T_PEAK, T_ZERO, AMPLITUDE, WIDTH, WIDTH_PEAK};

/* Means of a row, and the mean distances of the samples in them; NAN without samples. */
typedef struct means {
    double value[MEANS], distance[MEANS];
} means;

typedef struct problem {
    const sp_scaling_input *in;
    means *row;           /* [rows] of the current resample */
    double *weight[FITS]; /* [rows] errors of the points; NAN: unknown */
    bool weighted[FITS];
    int64_t used[FITS];    /* number of rows that have a point */
    double *x, *y, *error; /* [rows] of a fit */
    void *memory;
} problem;

static double value_of(const sp_front *f, mean_of m) {
    switch (m) {
    case T10: return f->t10;
    case T_PEAK: return f->t_peak;
    case T_ZERO: return f->t_zero;
    case AMPLITUDE: return f->amplitude;
    case LOG_AMPLITUDE: return f->amplitude > 0 ? log(f->amplitude) : NAN;
    case WIDTH: return f->t_zero - f->t10;
    default: return f->t_zero - f->t_peak;
    }
}

/* Means over the given samples of a row, or over all. */
static means means_of(const sp_scaling_input *in, int row, int64_t n, const int64_t *pick) {
    means sum = {{0}, {0}};
    int64_t count[MEANS] = {0};
    for (int64_t k = 0; k < n; k++) {
        const int64_t i = pick ? pick[k] : k;
        for (int m = 0; m < MEANS; m++) {
            const double value = value_of(&in->front[row][i], (mean_of)m);
            if (!isfinite(value))
                continue;
            sum.value[m] += value;
            sum.distance[m] += in->distance[row][i];
            count[m]++;
        }
    }
    for (int m = 0; m < MEANS; m++) {
        sum.value[m] = count[m] > 0 ? sum.value[m] / (double)count[m] : NAN;
        sum.distance[m] = count[m] > 0 ? sum.distance[m] / (double)count[m] : NAN;
    }
    return sum;
}

/* ---- intervals ------------------------------------------------------------------------------------------------- */

static double interval_value(const means *low, const means *high, interval what) {
    const mean_of m = compared[what];
    const double l1 = low->distance[m], l2 = high->distance[m], v1 = low->value[m], v2 = high->value[m];
    if (!(l2 > l1))
        return NAN;
    if (what <= SPEED_ZERO)
        return v2 > v1 ? (l2 - l1) / (v2 - v1) : NAN;
    if (!(v1 > 0 && v2 > 0))
        return NAN;
    const double exponent = log(v2 / v1) / log(l2 / l1);
    return what == GAMMA ? -exponent : exponent;
}

/* ---- fits ------------------------------------------------------------------------------------------------------ */

/* x and y of a row in a fit; false if it has no point. */
static bool point(const means *row, fit_of fit, double *x, double *y) {
    const double l = row->distance[fitted[fit]], v = row->value[fitted[fit]];
    const bool logarithm = fit == FIT_GAMMA || fit == FIT_ALPHA || fit == FIT_ALPHA_PEAK;
    *x = fit == FIT_SPEED ? l : log(l);
    *y = logarithm ? (v > 0 ? log(v) : NAN) : v;
    return isfinite(*x) && isfinite(*y);
}

/* Fits a line to the rows; *n: number of rows that have a point. */
static sp_status fit_rows(const problem *p, const means *row, fit_of fit, sp_line *line, int64_t *n, sp_error *err) {
    int64_t count = 0;
    for (int r = 0; r < p->in->rows; r++) {
        double x, y;
        if (!point(&row[r], fit, &x, &y))
            continue;
        p->x[count] = x;
        p->y[count] = y;
        p->error[count++] = p->weight[fit][r];
    }
    *n = count;
    return sp_fit_line(count, p->x, p->y, p->weighted[fit] ? p->error : NULL, line, err);
}

static double of_slope(fit_of fit, double slope) {
    if (fit == FIT_SPEED)
        return slope > 0 ? 1 / slope : NAN;
    return fit == FIT_GAMMA || fit == FIT_GAMMA_LOG ? -slope : slope;
}

/* Standard error of y - slope x of a row, to first order in the deviations of the samples from their means. */
static double residual_error(const sp_scaling_input *in, int row, const means *mean, fit_of fit, double slope,
                             double *scratch) {
    const mean_of m = fitted[fit];
    const double l = mean->distance[m], v = mean->value[m];
    const double dx = fit == FIT_SPEED ? 1 : 1 / l, dy = fit == FIT_SPEED || fit == FIT_GAMMA_LOG ? 1 : 1 / v;
    int64_t n = 0;
    for (int64_t k = 0; k < in->samples[row]; k++) {
        const double value = value_of(&in->front[row][k], m);
        if (isfinite(value))
            scratch[n++] = dy * (value - v) - slope * dx * (in->distance[row][k] - l);
    }
    return sp_standard_error(n, scratch);
}

/* Weights of a fit. A first fit with equal weights gives the slope from which the errors follow. */
static void find_weights(problem *p, fit_of fit, double *scratch) {
    const sp_scaling_input *in = p->in;
    sp_line line;
    int64_t n;
    p->weighted[fit] = false;
    if (fit_rows(p, p->row, fit, &line, &n, NULL) != SP_OK)
        return; /* without a fit there are no weights */
    p->used[fit] = n;
    bool all = true;
    for (int r = 0; r < in->rows; r++) {
        double x, y;
        p->weight[fit][r] = residual_error(in, r, &p->row[r], fit, line.slope, scratch);
        if (point(&p->row[r], fit, &x, &y))
            all = all && p->weight[fit][r] > 0 && isfinite(1 / p->weight[fit][r]);
    }
    p->weighted[fit] = all;
}

static void set_fit(const problem *p, fit_of fit, sp_scaling_fit *out) {
    sp_line line;
    int64_t n = 0;
    sp_scaling_fit f = {{NAN, NAN}, NAN, NAN, NAN, 0};
    if (fit_rows(p, p->row, fit, &line, &n, NULL) == SP_OK) {
        f.value.value = of_slope(fit, line.slope);
        f.fit_error = fit == FIT_SPEED ? line.slope_err / (line.slope * line.slope) : line.slope_err;
        f.prefactor = fit == FIT_SPEED ? line.intercept : exp(line.intercept);
        f.chi2 = p->weighted[fit] ? line.chi2 : NAN;
        f.freedom = line.freedom;
    }
    *out = f;
}

/* ---- errors ---------------------------------------------------------------------------------------------------- */

static void measure(const int64_t *size, const int64_t *const *pick, double *value, void *user) {
    problem *p = user;
    const sp_scaling_input *in = p->in;
    for (int r = 0; r < in->rows; r++) {
        const int g = in->joint ? 0 : r;
        p->row[r] = means_of(in, r, size[g], pick[g]);
    }
    for (int r = 0; r + 1 < in->rows; r++)
        for (int i = 0; i < INTERVALS; i++)
            *value++ = interval_value(&p->row[r], &p->row[r + 1], (interval)i);
    for (int f = 0; f < FITS; f++) {
        sp_line line;
        int64_t n;
        const sp_status status = fit_rows(p, p->row, (fit_of)f, &line, &n, NULL);
        *value++ = status == SP_OK && n == p->used[f] ? of_slope((fit_of)f, line.slope) : NAN;
    }
}

static sp_estimate mean_and_error(const sp_scaling_input *in, int row, mean_of m, double *scratch) {
    int64_t n = 0;
    for (int64_t k = 0; k < in->samples[row]; k++) {
        const double value = value_of(&in->front[row][k], m);
        if (isfinite(value))
            scratch[n++] = value;
    }
    return (sp_estimate){sp_mean(n, scratch), sp_standard_error(n, scratch)};
}

/* Means of a row. The distance is that of samples with a t10. */
static void set_row(const sp_scaling_input *in, int row, double *scratch, sp_scaling_row *out) {
    sp_estimate *const to[MEANS] = {&out->t10,           &out->t_peak, &out->t_zero,    &out->amplitude,
                                    &out->log_amplitude, &out->width,  &out->width_peak};
    for (int m = 0; m < MEANS; m++)
        *to[m] = mean_and_error(in, row, (mean_of)m, scratch);
    for (int64_t k = 0; k < in->samples[row]; k++)
        if (isfinite(in->front[row][k].t10))
            scratch[out->samples++] = in->distance[row][k];
    out->distance = (sp_estimate){sp_mean(out->samples, scratch), sp_standard_error(out->samples, scratch)};
    if (in->joint && out->distance.error > 0 && out->distance.error < 1e-12 * out->distance.value)
        out->distance.error = 0;
}

static void set_intervals(const problem *p, const double *error, sp_scaling *s) {
    static const sp_estimate none = {NAN, NAN};
    for (int r = 0; r < s->rows; r++) {
        sp_scaling_row *row = &s->row[r];
        sp_estimate *const to[INTERVALS] = {&row->speed, &row->speed_peak, &row->speed_zero,
                                            &row->gamma, &row->alpha,      &row->alpha_peak};
        const bool last = r + 1 == s->rows;
        row->between = last ? NAN : sqrt(row->distance.value * s->row[r + 1].distance.value);
        for (int i = 0; i < INTERVALS; i++)
            *to[i] =
                last ? none
                     : (sp_estimate){interval_value(&p->row[r], &p->row[r + 1], (interval)i), error[r * INTERVALS + i]};
    }
}

/* ---- all ------------------------------------------------------------------------------------------------------- */

static sp_status check_row(const sp_scaling_input *in, int row, sp_error *err) {
    if (in->samples[row] < 1)
        return sp_fail(err, SP_EINVAL, "scaling: distance %d has %lld samples, at least 1 is needed", row,
                       (long long)in->samples[row]);
    if (in->joint && in->samples[row] != in->samples[0])
        return sp_fail(err, SP_EINVAL,
                       "scaling: distance %d has %lld samples and the first %lld: must be the same packings", row,
                       (long long)in->samples[row], (long long)in->samples[0]);
    for (int64_t k = 0; k < in->samples[row]; k++)
        if (!(in->distance[row][k] > 0 && isfinite(in->distance[row][k])))
            return sp_fail(err, SP_EINVAL, "scaling: distance %g of sample %lld: must be positive",
                           in->distance[row][k], (long long)k);
    if (row > 0 &&
        !(sp_mean(in->samples[row], in->distance[row]) > sp_mean(in->samples[row - 1], in->distance[row - 1])))
        return sp_fail(err, SP_EINVAL, "scaling: mean distance %g after %g: must ascend",
                       sp_mean(in->samples[row], in->distance[row]),
                       sp_mean(in->samples[row - 1], in->distance[row - 1]));
    return SP_OK;
}

static sp_status problem_make(const sp_scaling_input *in, problem *out, sp_error *err) {
    const size_t rows = (size_t)in->rows;
    const size_t size = rows * sizeof(means) + rows * (FITS + 3) * sizeof(double);
    problem p = {.in = in, .memory = sp_alloc(size, 1)};
    if (!p.memory)
        return sp_fail_memory(err, size);
    p.row = p.memory;
    double *next = (double *)(p.row + rows);
    for (int f = 0; f < FITS; f++, next += rows)
        p.weight[f] = next;
    p.x = next;
    p.y = next + rows;
    p.error = next + 2 * rows;
    *out = p;
    return SP_OK;
}

static void set_means(problem *p) {
    for (int r = 0; r < p->in->rows; r++)
        p->row[r] = means_of(p->in, r, p->in->samples[r], NULL);
}

sp_status sp_scaling_make(const sp_scaling_input *in, sp_scaling *out, sp_error *err) {
    if (in->rows < 1)
        return sp_fail(err, SP_EINVAL, "scaling: %d distances, at least 1 is needed", in->rows);
    int64_t most = 1;
    for (int r = 0; r < in->rows; r++) {
        sp_status status = check_row(in, r, err);
        if (status != SP_OK)
            return status;
        most = in->samples[r] > most ? in->samples[r] : most;
    }
    const int values = (in->rows - 1) * INTERVALS + FITS;
    problem p = {0};
    sp_scaling s = {.rows = in->rows, .joint = in->joint};
    s.row = sp_alloc((size_t)in->rows, sizeof *s.row);
    double *scratch = sp_alloc((size_t)most, sizeof *scratch), *error = sp_alloc((size_t)values, sizeof *error);
    sp_status status = !s.row || !scratch || !error ? sp_fail_memory(err, (size_t)most * sizeof *scratch) : SP_OK;
    if (status == SP_OK)
        status = problem_make(in, &p, err);
    if (status != SP_OK)
        goto out;
    set_means(&p);
    for (int f = 0; f < FITS; f++)
        find_weights(&p, (fit_of)f, scratch);
    const sp_bootstrap_options options = sp_bootstrap_options_default();
    status = sp_bootstrap_many(in->joint ? 1 : in->rows, in->samples, values, measure, &p, &options, error, err);
    if (status != SP_OK)
        goto out;
    set_means(&p);
    for (int r = 0; r < in->rows; r++)
        set_row(in, r, scratch, &s.row[r]);
    set_intervals(&p, error, &s);
    sp_scaling_fit *const fit[FITS] = {&s.gamma, &s.gamma_log, &s.alpha, &s.alpha_peak, &s.speed};
    for (int f = 0; f < FITS; f++) {
        set_fit(&p, (fit_of)f, fit[f]);
        fit[f]->value.error = isfinite(fit[f]->value.value) ? error[(in->rows - 1) * INTERVALS + f] : NAN;
    }
    *out = s;
    s.row = NULL;
out:
    sp_free(s.row);
    sp_free(p.memory);
    sp_free(scratch);
    sp_free(error);
    return status;
}

void sp_scaling_free(sp_scaling *s) {
    sp_free(s->row);
    *s = (sp_scaling){0};
}
