/* Pulse shapes: strength, extent, and checks of parameters. */
#include <sonopack/pulse.h>

#include "base/base.h"

#include <math.h>

#define PI 3.14159265358979323846
/* Where exp(-x^2/2) and exp(-x^2) are below 1e-16. */
#define GAUSS_REACH  8.6
#define RICKER_REACH 6.6

static sp_status positive(const char *name, double value, sp_error *err) {
    if (value > 0 && isfinite(value))
        return SP_OK;
    return sp_fail(err, SP_EINVAL, "pulse: %s = %g, must be above 0", name, value);
}

static sp_status check_points(const sp_pulse *p, sp_error *err) {
    if (p->n < 2 || !p->t || !p->s)
        return sp_fail(err, SP_EINVAL, "pulse: a table of %lld points, must be 2 or more", (long long)p->n);
    for (int64_t k = 0; k < p->n; k++) {
        if (!isfinite(p->t[k]) || !isfinite(p->s[k]))
            return sp_fail(err, SP_EINVAL, "pulse: point %lld is not finite", (long long)k + 1);
        if (k > 0 && p->t[k] < p->t[k - 1])
            return sp_fail(err, SP_EINVAL, "pulse: t = %g of point %lld is below that of the point before it, %g",
                           p->t[k], (long long)k + 1, p->t[k - 1]);
    }
    if (!(p->t[p->n - 1] > p->t[0]))
        return sp_fail(err, SP_EINVAL, "pulse: all points are at t = %g, must be at different times", p->t[0]);
    return SP_OK;
}

sp_status sp_pulse_check(const sp_pulse *p, sp_error *err) {
    sp_status status = SP_OK;
    switch (p->kind) {
    case SP_PULSE_DELTA: return SP_OK;
    case SP_PULSE_GAUSS:
    case SP_PULSE_SQUARE: return positive("width", p->width, err);
    case SP_PULSE_RICKER: return positive("omega", p->omega, err);
    case SP_PULSE_SINE:
        status = positive("omega", p->omega, err);
        return status == SP_OK ? positive("cycles", p->cycles, err) : status;
    case SP_PULSE_TABLE: return check_points(p, err);
    }
    return sp_fail(err, SP_EINVAL, "pulse of kind %d, must be one of sp_pulse_kind", (int)p->kind);
}

void sp_pulse_span(const sp_pulse *p, double *first, double *last) {
    double reach = 0;
    *first = *last = 0;
    switch (p->kind) {
    case SP_PULSE_GAUSS: reach = GAUSS_REACH * p->width; break;
    case SP_PULSE_RICKER: reach = 2 * RICKER_REACH / p->omega; break;
    case SP_PULSE_SINE: *last = 2 * PI * p->cycles / p->omega; break;
    case SP_PULSE_SQUARE: *last = p->width; break;
    case SP_PULSE_TABLE:
        *first = p->t[0];
        *last = p->t[p->n - 1];
        break;
    default: break;
    }
    if (reach > 0) {
        *first = -reach;
        *last = reach;
    }
}

/* Uses the last point at or before t, so that a jump gives its later value. */
static double interpolate(const sp_pulse *p, double t) {
    if (t < p->t[0] || t > p->t[p->n - 1])
        return 0;
    int64_t low = 0, high = p->n - 1;
    while (high - low > 1) {
        const int64_t middle = (low + high) / 2;
        if (p->t[middle] <= t)
            low = middle;
        else
            high = middle;
    }
    const double step = p->t[high] - p->t[low];
    if (!(step > 0))
        return p->s[high];
    const double part = (t - p->t[low]) / step;
    return p->s[low] * (1 - part) + p->s[high] * part;
}

double sp_pulse_strength(const sp_pulse *p, double t) {
    double q;
    switch (p->kind) {
    case SP_PULSE_GAUSS: q = t / p->width; return exp(-0.5 * q * q) / (p->width * sqrt(2 * PI));
    case SP_PULSE_RICKER: q = 0.5 * p->omega * t; return (1 - 2 * q * q) * exp(-q * q);
    case SP_PULSE_SINE:
        q = p->omega * t;
        return q <= 0 || q >= 2 * PI * p->cycles ? 0 : 0.5 * sin(q) * (1 - cos(q / p->cycles));
    case SP_PULSE_SQUARE: return t < 0 || t > p->width ? 0 : 1 / p->width;
    case SP_PULSE_TABLE: return interpolate(p, t);
    default: return 0;
    }
}
