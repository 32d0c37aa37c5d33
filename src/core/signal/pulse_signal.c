/* Signals of pulses of any shape: the response to a short pulse, convolved with the pulse. */
#include "base/base.h"
#include "base/vector.h"
#include "signal/convolve.h"
#include "signal/job.h"

#include <float.h>
#include <math.h>

enum { FINE_POINTS = 16, COARSE_POINTS = 14, TIMES_MAX = 50000000 };
/* Time step of the response over 1/Omega: 50 steps in the shortest period. */
#define FINE_STEP 0.125

/* Largest |s| and integral of |s| before `until`. */
static void pulse_bounds(const sp_pulse *p, double until, double *most, double *integral) {
    enum { STEPS = 20000 };
    double first, last;
    sp_pulse_span(p, &first, &last);
    last = fmax(first, fmin(last, until));
    *most = *integral = 0;
    if (p->kind == SP_PULSE_TABLE) {
        for (int64_t k = 0; k < p->n && (k == 0 ? p->t[0] : p->t[k - 1]) < until; k++) {
            *most = fmax(*most, fabs(p->s[k]));
            if (k > 0)
                *integral += (p->t[k] - p->t[k - 1]) * fmax(fabs(p->s[k]), fabs(p->s[k - 1]));
        }
        return;
    }
    for (int k = 0; k < STEPS; k++) {
        const double s = fabs(sp_pulse_strength(p, first + (last - first) * (k + 0.5) / STEPS));
        *most = fmax(*most, s);
        *integral += s * (last - first) / STEPS;
    }
    *most *= 1.01;
    *integral *= 1.01;
}

/* Error of F due to that of the response and to rounding. Interpolation between 16 equally spaced points multiplies it
 * by at most 2 in the middle. Where it is one-sided, near t = 0 without a mirror, it does so by 513, 56, 13, 5, 3 in
 * successive intervals. */
static double response_error(const sp_pulse *p, const sp_response *g, double until, double error, double largest) {
    const double middle = 2, end = g->mirror == 0 ? 513 : 0, intervals = 1.2;
    double most, integral;
    pulse_bounds(p, until, &most, &integral);
    return (error + 8 * DBL_EPSILON * largest) * (middle * integral + end * fmin(integral, most * intervals * g->step));
}

/* One signal, with a fine and a coarse rule. The coarse rule is worse by orders of magnitude, so the difference exceeds
 * the error of the fine one. */
static sp_status convolve_pair(const sp_response *g, const sp_pulse *pulse, double omega, double response_bound,
                               const sp_signal *s, double *f, double *error, sp_error *err) {
    const double panel = sp_pulse_panel(pulse, omega);
    const sp_quadrature fine = {1, FINE_POINTS, 16, panel}, coarse = {2, COARSE_POINTS, 12, panel};
    double *check = sp_alloc((size_t)s->n, sizeof *check), worst = 0;
    sp_status status = check ? SP_OK : sp_fail_memory(err, (size_t)s->n * sizeof *check);
    if (status == SP_OK)
        status = sp_convolve(g, pulse, &fine, s->n, s->t, f, err);
    if (status == SP_OK)
        status = sp_convolve(g, pulse, &coarse, s->n, s->t, check, err);
    for (int32_t l = 0; l < s->n && status == SP_OK; l++)
        worst = fmax(worst, fabs(f[l] - check[l]));
    if (status == SP_OK)
        *error = worst + response_error(pulse, g, s->t[s->n - 1], response_bound, sp_largest(g->n, g->g));
    sp_free(check);
    return status;
}

/* Times of the response: from 0 to the last one needed, and some beyond for interpolation. */
static sp_status response_options(const sp_network *net, const sp_signal_options *opt, const sp_pulse *pulse,
                                  sp_signal_options *o, sp_error *err) {
    double first, last;
    const double step = FINE_STEP / sp_network_omega_bound(net);
    sp_pulse_span(pulse, &first, &last);
    const double until = opt->until - fmin(first, 0), steps = ceil(until / step) + 2 * FINE_POINTS;
    if (!(steps < TIMES_MAX))
        return sp_fail(err, SP_EREFUSED, "pulse: the response up to t = %g needs %.3g times, must be at most %d", until,
                       steps, TIMES_MAX);
    *o = *opt;
    o->points = (int32_t)steps + 1;
    o->until = step * steps;
    o->tolerance = 0.25 * opt->tolerance; /* with a pulse of both signs F may shrink more than its error */
    return SP_OK;
}

static sp_status check_errors(const sp_signal *s, double tolerance, sp_error *err) {
    for (int32_t q = 0; q < s->sources * s->detectors; q++) {
        const double largest = sp_largest(s->n, s->f + (int64_t)q * s->n);
        if (!(s->errors[q] <= tolerance * largest))
            return sp_fail(err, SP_EREFUSED,
                           "pulse: error bound %.3g is %.2g of the largest |F| = %.3g, must be at most %.2g",
                           s->errors[q], s->errors[q] / largest, largest, tolerance);
    }
    return SP_OK;
}

sp_status sp_signal_pulse(const sp_network *net, const sp_signal_options *opt, const sp_pulse *pulse, sp_signal *out,
                          sp_error *err) {
    sp_signal g = sp_signal_none(), s = sp_signal_none();
    sp_signal_options o;
    sp_status status = sp_pulse_check(pulse, err);
    if (status != SP_OK)
        return status;
    if (pulse->kind == SP_PULSE_DELTA)
        return sp_signal_make(net, opt, out, err);
    if (opt->method == SP_SIGNAL_DYNAMICS)
        return sp_fail(err, SP_EINVAL,
                       "pulse: method dynamics is nonlinear and allows no convolution, must be another method");
    if (opt->front)
        return sp_fail(err, SP_EINVAL, "pulse: only signals of a short pulse can end after the front");
    if (opt->points < 2 || !(opt->until > 0 && isfinite(opt->until)))
        return sp_fail(err, SP_EINVAL, "%d points until t = %g, must be 2 or more until a time above 0", opt->points,
                       opt->until);
    status = response_options(net, opt, pulse, &o, err);
    if (status == SP_OK)
        status = sp_signal_make(net, &o, &g, err);
    if (status == SP_OK)
        status = sp_signal_allocate(opt, g.sources, g.detectors, &s, err);
    s.omega_max = g.omega_max;
    s.products = g.products;
    s.method = g.method;
    s.step = g.step;
    s.modes = g.modes;
    for (int32_t q = 0; q < g.sources * g.detectors && status == SP_OK; q++) {
        const int mirror = o.damping > 0 ? 0 : o.source == SP_SOURCE_DISPLACEMENT ? 1 : -1;
        const sp_response r = {g.n, o.until / (g.n - 1), g.f + (int64_t)q * g.n, mirror};
        status = convolve_pair(&r, pulse, g.omega_max, g.errors[q], &s, s.f + (int64_t)q * s.n, &s.errors[q], err);
        if (status == SP_OK)
            s.error = fmax(s.error, s.errors[q]);
    }
    if (status == SP_OK)
        status = check_errors(&s, opt->tolerance, err);
    sp_signal_free(&g);
    if (status == SP_OK)
        *out = s;
    else
        sp_signal_free(&s);
    return status;
}
