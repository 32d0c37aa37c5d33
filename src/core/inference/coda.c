/* Finds the place of a change from the kernels of grains. */
#include "base/base.h"

#include <math.h>
#include <sonopack/coda.h>
#include <stdlib.h>

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
    const double values = (double)c->pairs * c->times;
    const double left = out[0].misfit * square / fmax(values - 1, 1);
    const double variance = fmax(noise > 0 ? noise * noise : left, 1e-30 * square);
    for (int32_t g = 0; g < c->n; g++)
        out[g].error = out[g].error > 0 ? sqrt(variance / out[g].error) : INFINITY;
    weigh(c, square, variance, out);
    return SP_OK;
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
