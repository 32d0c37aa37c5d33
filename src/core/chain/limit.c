/* The first front of a chain's signal. Near its front the signal is as smooth as an Airy function, so a Chebyshev
 * series through a few dozen values represents it up to rounding. */
#include <sonopack/chain.h>

#include "base/base.h"

#include <math.h>

enum { POINTS = 48, SAMPLES = 400 };

typedef struct series {
    double from, to;
    double c[POINTS];
} series;

/* Clenshaw's sum. */
static double value(const series *s, double t) {
    const double x = (2 * t - s->from - s->to) / (s->to - s->from);
    double b1 = 0, b2 = 0;
    for (int k = POINTS - 1; k > 0; k--) {
        const double b = 2 * x * b1 - b2 + s->c[k];
        b2 = b1;
        b1 = b;
    }
    return x * b1 - b2 + s->c[0];
}

static series derivative(const series *s) {
    series d = {.from = s->from, .to = s->to};
    for (int k = POINTS - 1; k > 0; k--)
        d.c[k - 1] = (k + 1 < POINTS ? d.c[k + 1] : 0) + 2 * k * s->c[k];
    d.c[0] *= 0.5;
    for (int k = 0; k < POINTS; k++)
        d.c[k] *= 2 / (s->to - s->from);
    return d;
}

static sp_status fit(int64_t grains, sp_chain_source source, series *s, sp_error *err) {
    double t[POINTS], f[POINTS];
    for (int l = 0; l < POINTS; l++) {
        const double x = -cos((l + 0.5) * M_PI / POINTS);
        t[l] = 0.5 * (s->from + s->to) + 0.5 * (s->to - s->from) * x;
    }
    const sp_status status = sp_chain_signal(grains, source, POINTS, t, f, err);
    for (int k = 0; k < POINTS && status == SP_OK; k++) {
        s->c[k] = 0;
        for (int l = 0; l < POINTS; l++) {
            const double x = fmin(fmax((2 * t[l] - s->from - s->to) / (s->to - s->from), -1), 1);
            s->c[k] += (k ? 2.0 : 1.0) / POINTS * f[l] * cos(k * acos(x));
        }
    }
    return status;
}

/* The point between `low` and `high` at which the series crosses `level`. */
static double find_crossing(const series *s, double low, double high, double level) {
    const int up = value(s, low) < level;
    for (int step = 0; step < 200; step++) {
        const double middle = 0.5 * (low + high);
        if (!(middle > low && middle < high))
            break;
        if ((value(s, middle) < level) == up)
            low = middle;
        else
            high = middle;
    }
    return 0.5 * (low + high);
}

sp_status sp_chain_front(int64_t grains, sp_chain_source source, sp_front *out, sp_error *err) {
    const double length = (double)grains + 1, unit = cbrt(length);
    /* From 1e-3 of the peak to beyond the zero, but before the next crest. In (16), t - N is -1.3 N^(1/3) (A) or -1.6
     * N^(1/3) (B) at a tenth of the peak, 0.5 N^(1/3) or 0 at the zero, 2 N^(1/3) or 1.7 N^(1/3) at the crest. */
    series s = {.from = fmax(0, length - 2.6 * unit), .to = length + unit};
    if (grains == 1 && source == SP_CHAIN_DISPLACEMENT)
        return sp_fail(err, SP_EREFUSED,
                       "chain: no front: one displaced ball presses the wall from the beginning; at "
                       "least 2 are needed");
    sp_status status = fit(grains, source, &s, err);
    if (status != SP_OK)
        return status;
    const series slope = derivative(&s);
    const double step = (s.to - s.from) / SAMPLES;
    double sample[SAMPLES + 1];
    int top = 0, rise = 1, fall;
    for (int k = 0; k <= SAMPLES; k++) {
        sample[k] = value(&s, s.from + k * step);
        top = sample[k] > sample[top] ? k : top;
    }
    for (fall = top; fall < SAMPLES && sample[fall] > 0;)
        fall++;
    if (top == 0 || top == SAMPLES || !(sample[fall] <= 0))
        return sp_fail(err, SP_EFAILED, "chain: no front of %lld grains about t = %g", (long long)grains, length);
    sp_front front = {.crossings = 1};
    front.t_peak = find_crossing(&slope, s.from + (top - 1) * step, s.from + (top + 1) * step, 0);
    front.amplitude = value(&s, front.t_peak);
    const double level = sp_front_options_default().rise * front.amplitude;
    while (rise < top && sample[rise] < level)
        rise++;
    front.t10 = find_crossing(&s, s.from + (rise - 1) * step, s.from + rise * step, level);
    front.t_zero = find_crossing(&s, s.from + (fall - 1) * step, s.from + fall * step, 0);
    front.width = front.t_zero - front.t10;
    *out = front;
    return SP_OK;
}

/* A: Ai'' = 0 at w = 0 and Ai' = 0 at -1.01879. B: (w Ai)' = 0 at 0.88405 and w Ai = 0 at 0. A tenth of the peak is at
 * w = 2.50944 and 3.24289. Times are half of w. */
sp_chain_limit sp_chain_limit_of(sp_chain_source source) {
    if (source == SP_CHAIN_VELOCITY)
        return (sp_chain_limit){.gamma = 2.0 / 3,
                                .alpha = 1.0 / 3,
                                .height = 2.0705552303424544,
                                .width = 1.7641168190534679,
                                .width_peak = 0.50939648582373554};
    return (sp_chain_limit){.gamma = 1,
                            .alpha = 1.0 / 3,
                            .height = 2.1876316129669413,
                            .width = 1.6214446990283565,
                            .width_peak = 0.44202522927618648};
}
