/* One damped wave fitted to the Fourier integrals of signals at planes. */
#include "base/base.h"

#include <complex.h>
#include <math.h>
#include <sonopack/coherent.h>

sp_section sp_section_none(void) { return (sp_section){0}; }

void sp_section_free(sp_section *s) {
    sp_free(s->y);
    sp_free(s->arrival);
    sp_free(s->until);
    sp_free(s->f);
    *s = sp_section_none();
}

static const double periods = 4; /* of the wave that count after its arrival */

/* Integral of F e^(i omega t) by the trapezoidal rule, which is exact to rounding for a signal that holds no
 * frequencies beyond pi/spacing; turn[l] = e^(i omega l spacing). The second half after the arrival fades by a half
 * cosine, so that the end of the record makes no wave of its own. */
static double complex fourier(const sp_section *s, int32_t plane, double omega, const double complex *turn) {
    const double *f = s->f + (int64_t)plane * s->n, arrival = s->arrival[plane];
    const double until = fmin(s->until[plane], arrival + periods * 2 * M_PI / omega), fade = 0.5 * (arrival + until);
    double complex sum = 0.5 * f[0];
    for (int32_t l = 1; l < s->n && l * s->spacing < until; l++) {
        const double t = l * s->spacing;
        const double taper = t <= fade ? 1 : 0.5 + 0.5 * cos(M_PI * (t - fade) / (until - fade));
        sum += taper * f[l] * turn[l];
    }
    return s->spacing * sum;
}

/* What is left of the squares after the best amplitude for (k, alpha), as a part of them. */
static double misfit(int32_t n, const double *y, const double complex *z, double k, double alpha) {
    double complex along = 0;
    double wave = 0, all = 0;
    for (int32_t j = 0; j < n; j++) {
        const double complex e = cexp((I * k - alpha) * (y[j] - y[0]));
        along += z[j] * conj(e);
        wave += creal(e * conj(e));
        all += creal(z[j] * conj(z[j]));
    }
    return all > 0 ? 1 - creal(along * conj(along)) / (wave * all) : NAN;
}

/* Lowest point of the parabola through three equidistant values, from the middle one, in steps; 0 if there is none. */
static double lowest(double left, double middle, double right) {
    const double curve = left - 2 * middle + right;
    return curve > 0 ? fmax(-1, fmin(1, 0.5 * (left - right) / curve)) : 0;
}

/* Steps of the search, and the least alpha: noise may make it negative where there is hardly any. */
typedef struct search {
    double k, alpha, least;
} search;

/* From a start on the grid: by turns in k and in alpha, with ever smaller steps. The valley is round to second order
 * (k turns phases, alpha lengths), so that turns converge fast. */
static void polish(int32_t n, const double *y, const double complex *z, search step, double *k, double *alpha) {
    for (int pass = 0; pass < 60; pass++) {
        const double here = misfit(n, y, z, *k, *alpha), dk = step.k, da = step.alpha;
        const double move = lowest(misfit(n, y, z, *k - dk, *alpha), here, misfit(n, y, z, *k + dk, *alpha));
        if (misfit(n, y, z, *k + move * dk, *alpha) <= here)
            *k += move * dk;
        const double middle = fmax(step.least, *alpha - da) + da;
        const double rest[3] = {misfit(n, y, z, *k, middle - da), misfit(n, y, z, *k, middle),
                                misfit(n, y, z, *k, middle + da)};
        const double next = middle + da * lowest(rest[0], rest[1], rest[2]);
        if (misfit(n, y, z, *k, next) <= misfit(n, y, z, *k, *alpha))
            *alpha = next;
        step.k *= 0.7;
        step.alpha *= 0.7;
    }
}

static sp_status check(const sp_section *s, double omega, sp_error *err) {
    if (s->planes < 3 || s->n < 3 || !(s->spacing > 0))
        return sp_fail(err, SP_EINVAL, "coherent wave: %d planes of %d times, at least 3 of each are needed", s->planes,
                       s->n);
    for (int32_t j = 1; j < s->planes; j++)
        if (!(s->y[j] > s->y[j - 1]))
            return sp_fail(err, SP_EINVAL, "coherent wave: height %g of plane %d is not above the one before, %g",
                           s->y[j], j, s->y[j - 1]);
    if (!(omega > 0) || !(omega * s->spacing < M_PI / 2))
        return sp_fail(err, SP_EINVAL, "coherent wave: omega = %g: must be above 0 and below %g for times at %g", omega,
                       M_PI / 2 / s->spacing, s->spacing);
    return SP_OK;
}

/* Some plane's record holds a period: of less the integrals are those of the front's tail, whatever the frequency. */
static bool holds_period(const sp_section *s, double omega) {
    double longest = 0;
    for (int32_t j = 0; j < s->planes; j++)
        longest = fmax(longest, s->until[j]);
    return omega * longest >= 2 * M_PI;
}

sp_status sp_coherent_fit(const sp_section *s, double omega, sp_coherent *out, sp_error *err) {
    sp_status status = check(s, omega, err);
    if (status != SP_OK)
        return status;
    if (!holds_period(s, omega)) {
        *out = (sp_coherent){.omega = omega, .k = NAN, .alpha = NAN, .part = NAN};
        return SP_OK;
    }
    const int32_t n = s->planes;
    const double range = s->y[n - 1] - s->y[0], gap = range / (n - 1), k_most = M_PI / gap, a_most = 1 / gap;
    const double dk = 0.5 / range, a_least = -1 / range;
    double complex *z = sp_alloc((size_t)n + (size_t)s->n, sizeof *z), *turn = z + n;
    if (!z)
        return sp_fail_memory(err, ((size_t)n + (size_t)s->n) * sizeof *z);
    for (int32_t l = 0; l < s->n; l++)
        turn[l] = cexp(I * fmod(omega * (l * s->spacing), 2 * M_PI));
    for (int32_t j = 0; j < n; j++)
        z[j] = fourier(s, j, omega, turn);
    double least = INFINITY, k = NAN, alpha = NAN;
    for (double a = 0.1 / range; a < a_most; a *= 2)
        for (double trial = 0; trial <= k_most; trial += fmax(dk, 0.5 * a)) {
            const double left = misfit(n, s->y, z, trial, a);
            if (left < least) {
                least = left;
                k = trial;
                alpha = a;
            }
        }
    sp_coherent fit = {.omega = omega, .k = NAN, .alpha = NAN, .part = NAN};
    if (isfinite(least)) {
        polish(n, s->y, z, (search){fmax(dk, 0.5 * alpha), 0.5 * alpha, a_least}, &k, &alpha);
        fit.part = 1 - misfit(n, s->y, z, k, alpha);
        if (k > alpha && k > 0 && k < k_most && alpha > a_least && alpha < a_most) {
            fit.k = k;
            fit.alpha = alpha;
        }
    }
    sp_free(z);
    *out = fit;
    return SP_OK;
}
