/* Signals of the chain of equal balls in closed form, and its first front. */
#include "base/base.h"
#include "numeric/bessel.h"

#include <math.h>
#include <sonopack/chain.h>
#include <stdbool.h>

enum { LONGEST = 1000000000 };

double sp_chain_omega(int64_t grains, int64_t n) { return 2 * sin((double)n * M_PI / (2 * ((double)grains + 1))); }

/* Sines of angles below pi/2 are exact to rounding; pi minus a rounded angle would not be. */
double sp_chain_amplitude(int64_t grains, int64_t n, sp_chain_source source) {
    const double length = (double)grains + 1, rest = length - (double)n;
    if (source == SP_CHAIN_VELOCITY)
        return 2 / length * sin(rest * M_PI / (2 * length)); /* cos(k/2) */
    return 2 / length * sin(fmin((double)n, rest) * M_PI / length);
}

static sp_status check(int64_t grains, sp_chain_source source, int64_t n, const double *t, sp_error *err) {
    if (grains < 1 || grains > LONGEST)
        return sp_fail(err, SP_EINVAL, "chain: %lld grains; must be 1 .. %d", (long long)grains, (int)LONGEST);
    if (source != SP_CHAIN_VELOCITY && source != SP_CHAIN_DISPLACEMENT)
        return sp_fail(err, SP_EINVAL, "chain: source %d; must be a velocity or a displacement", (int)source);
    for (int64_t l = 0; l < n; l++)
        if (!(t[l] >= 0) || !isfinite(t[l]) || (l > 0 && t[l] < t[l - 1]))
            return sp_fail(err, SP_EINVAL,
                           "chain: time %lld is %.17g; must be a number >= 0 and not below the one before",
                           (long long)l, t[l]);
    return SP_OK;
}

/* In an infinite chain a displaced ball causes the displacement J_2j(2t) j balls away (Neumann's generating function of
 * the dispersion relation (C2)). Walls act as mirrors: the images are balls displaced by +1 at 1 + 2qL and by -1 at -1
 * + 2qL, L = N + 1, for all q. At ball N they give, with M = L, 3L, 5L, ...,
 *     F_B = sum_M  J_(2M-4) - 2 J_2M + J_(2M+4),
 * and integrated over time, with d/dt J_m(2t) = J_(m-1) - J_(m+1),
 *     F_A = sum_M  J_(2M-3) + J_(2M-1) - J_(2M+1) - J_(2M+3),   all at 2t.
 * These coefficients are the moments of the chain for Omega = 2, where a step of the recurrence moves a pulse by one
 * ball. A wall spring K_wall = (1 - r) K adds r u_1 to a step of the first ball. With z for one step, the wave it emits
 * becomes z/(1 - r z), the response of the last ball to an arriving wave (1 - z^2)/(1 - r z), and the echo -z (z -
 * r)/(1 - r z). The moments are the power series of
 *     P(z)/((1 - r z)^2 - z^(2N) (z - r)^2),  P_A = z^(N-1) (1 + z)(1 - z^2),  P_B = z^(N-1) (1 - z^2)^2.
 * c[k] is the coefficient of J_2k (B) or J_(2k+1) (A). */
static void moments(const sp_chain *chain, int64_t n, double *c) {
    static const double kick[] = {1, 1, -1, -1, 0}, shift[] = {1, 0, -2, 0, 1};
    const double *image = chain->source == SP_CHAIN_VELOCITY ? kick : shift;
    const double r = 1 - chain->wall;
    const int64_t first = chain->grains - 1, echo = 2 * chain->grains;
    for (int64_t k = first; k < n; k++) {
        double value = k - first < 5 ? image[k - first] : 0;
        if (k > first)
            value += 2 * r * c[k - 1];
        if (k > first + 1)
            value -= r * r * c[k - 2];
        if (k >= first + echo)
            value += r * r * c[k - echo];
        if (k >= first + echo + 1)
            value -= 2 * r * c[k - echo - 1];
        if (k >= first + echo + 2)
            value += c[k - echo - 2];
        c[k] = value;
    }
}

sp_status sp_chain_walls_signal(const sp_chain *chain, int64_t n, const double *t, double *f, sp_error *err) {
    sp_status status = check(chain->grains, chain->source, n, t, err);
    if (status == SP_OK && !(chain->wall > 0 && chain->wall < 2))
        return sp_fail(err, SP_EINVAL, "chain: wall springs of %g times the others; must be above 0 and below 2",
                       chain->wall);
    if (status != SP_OK || n < 1)
        return status;
    if (!(8 * t[n - 1] < 0.5 * sp_memory_limit()))
        return sp_fail(err, SP_EINVAL, "chain: t = %g needs %.3g GB, %.3g are available", t[n - 1], 8e-9 * t[n - 1],
                       0.5e-9 * sp_memory_limit());
    const int64_t orders = sp_bessel_orders(2 * t[n - 1]) / 2 + 1;
    double *c = sp_alloc((size_t)orders, sizeof *c), *x = sp_alloc((size_t)n, sizeof *x);
    if (c && x) {
        moments(chain, orders, c);
        for (int64_t l = 0; l < n; l++)
            x[l] = 2 * t[l];
        sp_bessel_series(orders, c, chain->source == SP_CHAIN_VELOCITY, n, x, f);
        for (int64_t l = 0; l < n; l++)
            f[l] *= chain->wall;
    } else {
        status = sp_fail_memory(err, (size_t)(orders + n) * sizeof *c);
    }
    sp_free(x);
    sp_free(c);
    return status;
}

double sp_chain_signal_error(const sp_chain *chain, double t) {
    const bool equal = !(chain->wall < 1 || chain->wall > 1);
    return 1e-15 * (1 + (equal ? pow(t + t * t / ((double)chain->grains + 1), 0.25) : t));
}

sp_status sp_chain_signal(int64_t grains, sp_chain_source source, int64_t n, const double *t, double *f,
                          sp_error *err) {
    const sp_chain chain = {.grains = grains, .source = source, .wall = 1};
    return sp_chain_walls_signal(&chain, n, t, f, err);
}

/* Near the front J_m(2t) -> t^(-1/3) Ai((m - 2t)/t^(1/3)). The combinations above are its first and second difference,
 * -8 t^(-2/3) Ai' and 16 t^(-1) Ai''. */
sp_status sp_chain_airy(int64_t grains, sp_chain_source source, int64_t n, const double *t, double *f, sp_error *err) {
    sp_status status = check(grains, source, n, t, err);
    if (status != SP_OK)
        return status;
    for (int64_t l = 0; l < n; l++) {
        const double root = cbrt(t[l]), w = 2 * ((double)grains - t[l]) / root;
        double ai, slope;
        f[l] = 0;
        if (!(w < 1e3)) /* exp(-2e4), and t = 0 */
            continue;
        sp_airy(w, &ai, &slope);
        f[l] = source == SP_CHAIN_VELOCITY ? -8 * slope / (root * root) : 16 * w * ai / t[l];
    }
    return SP_OK;
}

/* ---- the first front --------------------------------------------------------------------------------------------- */

/* Near its front the signal is as smooth as an Airy function, so a Chebyshev series through a few dozen values
 * represents it up to rounding. */
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
