/* Finds the first wave front of a signal. */
#include <sonopack/front.h>

#include "base/base.h"

#include <math.h>
#include <stdbool.h>

/* A maximum counts once the signal has fallen below it by this fraction of the largest value. Noise of 1e-3 of the peak
 * (peak to valley 8e-3 at four standard deviations) then makes no maxima. */
static const double confirm = 0.01;

/* The parabola through the points of a peak may exceed the highest of them by this factor, and no more: it then follows
 * a fall that lies between two points, and not the peak. A resolved peak exceeds them by an eighth at most. */
static const double unresolved = 2;

sp_front_options sp_front_options_default(void) {
    return (sp_front_options){.window = 0, .rise = 0.1, .prominence = 0.2};
}

static sp_status check(int64_t n, const double *t, const double *f, const sp_front_options *opt, sp_error *err) {
    if (!(opt->rise > 0 && opt->rise < 1) || !(opt->prominence > 0 && opt->prominence < 1) || isnan(opt->window))
        return sp_fail(err, SP_EINVAL,
                       "front: rise = %g, prominence = %g, window = %g; both fractions between 0 and 1, and a number",
                       opt->rise, opt->prominence, opt->window);
    if (n < 3)
        return sp_fail(err, SP_EINVAL, "front: %lld points, at least 3 are needed", (long long)n);
    for (int64_t k = 0; k < n; k++) {
        if (!isfinite(t[k]) || !isfinite(f[k]))
            return sp_fail(err, SP_EINVAL, "front: point %lld is (t, F) = (%g, %g), finite numbers are needed",
                           (long long)k, t[k], f[k]);
        if (k > 0 && !(t[k] > t[k - 1]))
            return sp_fail(err, SP_EINVAL, "front: t = %.17g of point %lld is not above the one before, %.17g", t[k],
                           (long long)k, t[k - 1]);
    }
    return SP_OK;
}

/* Time at which the line from point k-1 to point k reaches `level`. Halving avoids overflow of differences. */
static double crossing(const double *t, const double *f, int64_t k, double level) {
    double low = 0.5 * f[k - 1], high = 0.5 * f[k], part = (0.5 * level - low) / (high - low);
    return t[k - 1] + fmin(fmax(part, 0), 1) * (t[k] - t[k - 1]);
}

/* First maximum above `least` below which the signal falls by `fall` before it rises above it. *first and *last are the
 * ends of its plateau, usually the same point. */
static bool first_maximum(int64_t n, const double *f, double least, double fall, int64_t *first, int64_t *last) {
    int64_t top = -1;
    for (int64_t k = 0; k < n; k++) {
        if (f[k] > least && (top < 0 || f[k] > f[top])) {
            top = k;
        } else if (top >= 0 && 0.5 * f[k] < 0.5 * f[top] - 0.5 * fall) {
            *first = *last = top;
            while (*last + 1 < k && f[*last + 1] == f[top])
                ++*last;
            return true;
        }
    }
    return false;
}

/* Vertex of the parabola through the highest point and its neighbours; the middle of a plateau of three or more
 * points. */
static void vertex(const double *t, const double *f, int64_t first, int64_t last, double *t_peak, double *height) {
    *t_peak = 0.5 * (t[first] + t[last]);
    *height = f[first];
    if (first == 0 || last > first + 1)
        return;
    double left = t[first] - t[first - 1], right = t[first + 1] - t[first];
    /* slopes of the two chords over the height, then Newton's form of the parabola */
    double up = (0.5 - 0.5 * (f[first - 1] / f[first])) * 2 / left;
    double down = (0.5 - 0.5 * (f[first + 1] / f[first])) * 2 / right;
    double curvature = (up + down) / (left + right);
    if (!(curvature > 0) || !isfinite(curvature))
        return;
    double slope = (up * right - down * left) / (left + right); /* at point `first` */
    double step = slope / (2 * curvature);
    *t_peak = t[first] + step;
    *height = f[first] * (1 + 0.5 * slope * step);
}

/* Upward crossings of the level up to point `peak`; *at: the point after the first of them. */
static int64_t upward_crossings(const double *f, int64_t peak, double level, int64_t *at) {
    int64_t count = 0;
    for (int64_t k = 1; k <= peak; k++)
        if (f[k - 1] < level && f[k] >= level && count++ == 0)
            *at = k;
    return count;
}

sp_status sp_front_find(int64_t n, const double *t, const double *f, const sp_front_options *opt, sp_front *out,
                        sp_error *err) {
    sp_status status = check(n, t, f, opt, err);
    if (status != SP_OK)
        return status;
    while (opt->window > 0 && n > 0 && t[n - 1] > opt->window)
        n--;
    if (n < 3)
        return sp_fail(err, SP_EREFUSED, "no front: %lld points up to the end of the window, t = %g; at least 3 needed",
                       (long long)n, opt->window);
    double largest = f[0];
    for (int64_t k = 1; k < n; k++)
        largest = fmax(largest, f[k]);
    if (!(largest > 0))
        return sp_fail(err, SP_EREFUSED, "no front: the signal is never positive up to t = %g", t[n - 1]);
    int64_t first = 0, last = 0;
    if (!first_maximum(n, f, opt->prominence * largest, confirm * largest, &first, &last))
        return sp_fail(err, SP_EREFUSED, "no front: no maximum above %g of the largest value %g up to t = %g",
                       opt->prominence, largest, t[n - 1]);
    sp_front front = {.t_zero = NAN};
    vertex(t, f, first, last, &front.t_peak, &front.amplitude);
    double level = fmin(opt->rise * front.amplitude, f[first]); /* the vertex lies above the points */
    if (f[0] >= level)
        return sp_fail(
            err, SP_EREFUSED,
            "no front: the trace starts at F = %g, above %g of the first peak's height %g: an offset must be "
            "subtracted first",
            f[0], opt->rise, front.amplitude);
    int64_t arrival = 1;
    front.crossings = upward_crossings(f, first, level, &arrival);
    front.t10 = crossing(t, f, arrival, level);
    for (int64_t k = last + 1; k < n && isnan(front.t_zero); k++)
        if (f[k] <= 0)
            front.t_zero = crossing(t, f, k, 0);
    front.width = front.t_zero - front.t10;
    if (!isfinite(front.t10) || !isfinite(front.t_peak) || !isfinite(front.amplitude))
        return sp_fail(err, SP_EREFUSED, "no front: the values of the signal, up to %g, are too large", largest);
    if (front.amplitude > unresolved * f[first] || front.t_peak < front.t10)
        return sp_fail(
            err, SP_EREFUSED,
            "no front: the first peak is not resolved: its highest point is F = %g at t = %g, and the parabola "
            "through that point and its neighbours has its vertex at F = %g, t = %g",
            f[first], t[first], front.amplitude, front.t_peak);
    *out = front;
    return SP_OK;
}
