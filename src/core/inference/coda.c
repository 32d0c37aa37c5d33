/* Finds the place of a change from the kernels of grains. */
#include "base/base.h"

#include <math.h>
#include <sonopack/coda.h>
#include <stdlib.h>

enum { LAGS_MOST = 1000 };

static int by_probability(const void *one, const void *two) {
    const sp_coda_candidate *a = one, *b = two;
    if (a->misfit != b->misfit)
        return a->misfit < b->misfit ? -1 : 1;
    return a->grain < b->grain ? -1 : a->grain > b->grain;
}

/* Sum of a grain's kernel times the change. */
static double overlap_of(const sp_coda *c, const double *change, int32_t g) {
    const size_t times = (size_t)c->times;
    double sum = 0;
    for (size_t pair = 0; pair < (size_t)c->pairs; pair++) {
        const double *kernel = c->kernel + (pair * (size_t)c->n + (size_t)g) * times;
        for (size_t l = 0; l < times; l++)
            sum += kernel[l] * change[pair * times + l];
    }
    return sum;
}

static sp_status square_of(const sp_coda *c, const double *change, double *square, sp_error *err) {
    *square = 0;
    for (int64_t k = 0; k < (int64_t)c->pairs * c->times; k++)
        *square += change[k] * change[k];
    if (!isfinite(*square))
        return sp_fail(err, SP_EINVAL, "the change of the signals has numbers that are not finite");
    if (!(*square > 0))
        return sp_fail(err, SP_EREFUSED, "the signals do not differ: there is no change to find");
    return SP_OK;
}

/* ---- noise ------------------------------------------------------------------------------------------------------ */

/* Sum of x(t) x(t + lag) over the times of all pairs; x [pairs], `stride` apart. */
static double lagged(const sp_coda *c, const double *x, size_t stride, int32_t lag) {
    double sum = 0;
    for (int32_t pair = 0; pair < c->pairs; pair++)
        for (int32_t l = 0; l + lag < c->times; l++)
            sum += x[(size_t)pair * stride + (size_t)l] * x[(size_t)pair * stride + (size_t)(l + lag)];
    return sum;
}

/* What a fit leaves of the change is a signal, too, unless it is noise: its values at neighbouring times are alike, and
 * so are those of the kernel. Their scalar product then varies more than that of white noise, by this factor: the sum
 * over all lags of the product of both correlations. At least 1. */
static double correlated(const sp_coda *c, const double *left, const double *kernel) {
    const size_t times = (size_t)c->times;
    const int32_t lags = c->times / 4 < LAGS_MOST ? c->times / 4 : LAGS_MOST;
    const double own = lagged(c, left, times, 0), other = lagged(c, kernel, (size_t)c->n * times, 0);
    double sum = 1;
    for (int32_t lag = 1; lag <= lags && own > 0 && other > 0; lag++)
        sum += 2 * lagged(c, left, times, lag) / own * (lagged(c, kernel, (size_t)c->n * times, lag) / other);
    return fmax(sum, 1);
}

/* Variance of the noise, as it counts in sums over kernels: what was given, if the best fit leaves no more than that;
 * else what it leaves, with its correlation. Three standard errors of a variance decide. */
static sp_status noise_variance(const sp_coda *c, const double *change, double square, double noise,
                                const sp_coda_candidate *best, double *variance, sp_error *err) {
    const size_t times = (size_t)c->times, values = (size_t)c->pairs * times;
    const double rest = best->misfit * square / fmax((double)values - 1, 1);
    *variance = noise * noise;
    if (noise > 0 && rest <= noise * noise * (1 + 3 * sqrt(2.0 / (double)values)))
        return SP_OK;
    int32_t g = 0;
    while (c->grain[g] != best->grain)
        g++;
    double *left = sp_alloc(values, sizeof *left);
    if (!left)
        return sp_fail_memory(err, values * sizeof *left);
    for (size_t k = 0; k < values; k++)
        left[k] = change[k] - best->change * c->kernel[(k / times * (size_t)c->n + (size_t)g) * times + k % times];
    *variance = fmax(rest * correlated(c, left, c->kernel + (size_t)g * times), 1e-30 * square);
    sp_free(left);
    return SP_OK;
}

/* Each grain explains a part of the squared change; with noise of variance v, chi^2 = misfit x square / v. */
static void weigh(const sp_coda *c, double square, double variance, sp_coda_candidate *out) {
    double sum = 0;
    for (int32_t k = 0; k < c->n; k++) {
        out[k].probability = exp(-0.5 * (out[k].misfit - out[0].misfit) * square / variance);
        sum += out[k].probability;
    }
    for (int32_t k = 0; k < c->n; k++)
        out[k].probability /= sum;
}

sp_status sp_coda_locate(const sp_coda *c, const double *change, double noise, sp_coda_candidate *out, sp_error *err) {
    double square;
    bool any = false;
    if (!(noise >= 0 && isfinite(noise)))
        return sp_fail(err, SP_EINVAL, "noise = %g: must be 0 or above", noise);
    sp_status status = square_of(c, change, &square, err);
    if (status != SP_OK)
        return status;
    for (int32_t g = 0; g < c->n; g++) {
        const double overlap = overlap_of(c, change, g), own = c->square[g];
        any = any || own > 0;
        out[g] = (sp_coda_candidate){.grain = c->grain[g], .change = own > 0 ? overlap / own : 0, .error = own};
        out[g].misfit = own > 0 ? fmax(1 - overlap / own * overlap / square, 0) : 1;
    }
    if (!any)
        return sp_fail(err, SP_EREFUSED, "no grain has any influence on the signals in this window");
    qsort(out, (size_t)c->n, sizeof *out, by_probability);
    double variance;
    status = noise_variance(c, change, square, noise, &out[0], &variance, err);
    for (int32_t g = 0; g < c->n && status == SP_OK; g++)
        out[g].error = out[g].error > 0 ? sqrt(variance / out[g].error) : INFINITY;
    if (status == SP_OK)
        weigh(c, square, variance, out);
    return status;
}

/* before((1 + e) t) = before + e t dF/dt. */
void sp_coda_stretch(int32_t times, const double *t, const double *before, const double *change, double *stretch,
                     double *error) {
    double own = 0, overlap = 0, square = 0;
    int32_t used = 0;
    for (int32_t l = 1; l + 1 < times; l++) {
        const double slope = t[l] * (before[l + 1] - before[l - 1]) / (t[l + 1] - t[l - 1]);
        own += slope * slope;
        overlap += slope * change[l];
        square += change[l] * change[l];
        used++;
    }
    *stretch = own > 0 ? overlap / own : NAN;
    *error = own > 0 && used > 1 ? sqrt(fmax(square - overlap * overlap / own, 0) / (used - 1) / own) : NAN;
}

/* ---- what first order leaves out -------------------------------------------------------------------------------- */

static int32_t place_of(const sp_coda *c, int32_t grain) {
    int32_t g = 0;
    while (g + 1 < c->n && c->grain[g] != grain)
        g++;
    return g;
}

sp_status sp_coda_first_order(const sp_network *net, const sp_coda_options *opt, const sp_coda *c, const double *before,
                              sp_coda_candidate *found, sp_error *err) {
    const size_t values = (size_t)c->pairs * (size_t)c->times;
    const int32_t g = place_of(c, found->grain);
    double off = found->change; /* of changes that no signal can have nothing is known */
    if (found->change > -1 && found->change <= 10) {
        double *change = sp_alloc(values, sizeof *change);
        sp_status status = change ? sp_coda_signal(net, opt, found->grain, found->change, change, err)
                                  : sp_fail_memory(err, values * sizeof *change);
        for (size_t k = 0; k < values && status == SP_OK; k++)
            change[k] -= before[k];
        if (status == SP_OK)
            off = (c->square[g] > 0 ? overlap_of(c, change, g) / c->square[g] : NAN) - found->change;
        sp_free(change);
        if (status != SP_OK)
            return status;
    }
    found->error = hypot(found->error, isnan(off) ? INFINITY : off);
    return SP_OK;
}
