/* Size distributions of the grains. */
#include "base/base.h"
#include "numeric/random.h"
#include "packing/prepare.h"

#include <math.h>

static const double PI = 3.14159265358979323846, LN2 = 0.69314718055994530942;
static const double FARTHEST = 8; /* in standard deviations from the median; beyond this, fewer than one draw in 1e14 */

/* exp and log for sizes. Those of the C library differ in their last bits between machines, which would give different
 * packings. These two use only operations that are rounded alike everywhere, and are accurate to about 1e-16. */
static double same_exp(double x) {
    const double k = nearbyint(x / LN2), rest = x - k * LN2;
    double sum = 1;
    for (int n = 18; n > 0; n--) /* |rest| < 0.35 */
        sum = 1 + rest / n * sum;
    return ldexp(sum, (int)k);
}

static double same_log(double x) {
    int k;
    double m = frexp(x, &k);
    if (m < 0.70710678118654752440) {
        m *= 2;
        k--;
    }
    const double t = (m - 1) / (m + 1); /* |t| < 0.172, ln m = 2 artanh t */
    double sum = 0;
    for (int n = 27; n > 0; n -= 2)
        sum = sum * t * t + 1.0 / n;
    return k * LN2 + 2 * t * sum;
}

/* ln of the median, for which the mean of the unrestricted distribution is the unit of length. */
static double log_median(const sp_pack_spec *s) { return -0.5 * s->size_spread * s->size_spread; }

void sp_sizes_limits(const sp_pack_spec *s, double *low, double *high) {
    *low = s->diameter_min;
    *high = s->diameter_max;
    if (s->sizes == SP_SIZES_LIST) {
        *low = INFINITY;
        *high = 0;
        for (int32_t i = 0; i < s->grains && i < s->diameter_count && s->diameters; i++) {
            *low = fmin(*low, s->diameters[i]);
            *high = fmax(*high, s->diameters[i]);
        }
    } else if (*low == 0 && *high == 0) {
        const bool ordered = s->kind != SP_PACK_PISTON;
        *low = ordered && s->sizes == SP_SIZES_UNIFORM ? 1.0 : 0.8;
        *high = ordered && s->sizes == SP_SIZES_UNIFORM ? 1.0 : 1.2;
        if (s->sizes == SP_SIZES_LOGNORMAL) {
            *low = same_exp(log_median(s) - 3 * s->size_spread);
            *high = same_exp(log_median(s) + 3 * s->size_spread);
        }
    }
}

/* Probability of a normal variable between a and b, computed from the nearer tail to keep its digits. */
static double normal_part(double a, double b) {
    return a > 0 ? 0.5 * (erfc(a * sqrt(0.5)) - erfc(b * sqrt(0.5)))
                 : 0.5 * (erfc(-b * sqrt(0.5)) - erfc(-a * sqrt(0.5)));
}

double sp_sizes_within(const sp_pack_spec *s) {
    const double m = log_median(s), w = s->size_spread;
    if (w == 0)
        return s->diameter_min <= 1 && s->diameter_max >= 1 ? 1 : 0;
    return normal_part((log(s->diameter_min) - m) / w, (log(s->diameter_max) - m) / w);
}

/* <d^k> of a lognormal distribution with limits: the normal distribution of ln d, shifted by k times the spread. */
static double lognormal_moment(const sp_pack_spec *s, int k) {
    const double m = log_median(s), w = s->size_spread;
    if (w == 0)
        return 1;
    if (s->diameter_min == s->diameter_max)
        return pow(s->diameter_max, k);
    const double a = (log(s->diameter_min) - m) / w, b = (log(s->diameter_max) - m) / w;
    return exp(k * m + 0.5 * k * k * w * w) * normal_part(a - k * w, b - k * w) / normal_part(a, b);
}

double sp_sizes_moment(const sp_pack_spec *s, int k) {
    const double a = s->diameter_min, b = s->diameter_max;
    double sum = 0;
    switch (s->sizes) {
    case SP_SIZES_UNIFORM: /* (b^(k+1) - a^(k+1)) / ((k+1) (b - a)), also for equal limits */
        for (int i = 0; i <= k; i++)
            sum += pow(a, i) * pow(b, k - i);
        return sum / (k + 1);
    case SP_SIZES_BIDISPERSE: return (1 - s->large_fraction) * pow(a, k) + s->large_fraction * pow(b, k);
    case SP_SIZES_LOGNORMAL: return lognormal_moment(s, k);
    case SP_SIZES_LIST:
        for (int32_t i = 0; i < s->grains && i < s->diameter_count; i++)
            sum += pow(s->diameters[i], k);
        return sum / s->grains;
    }
    return NAN;
}

double sp_sizes_mean_area(const sp_pack_spec *s) { return PI / 4 * sp_sizes_moment(s, 2); }
double sp_sizes_mean_volume(const sp_pack_spec *s) { return PI / 6 * sp_sizes_moment(s, 3); }

static void draw_uniform(const sp_pack_spec *s, sp_random *stream, double *r) {
    for (int32_t i = 0; i < s->grains; i++)
        r[i] = 0.5 * (s->diameter_min + (s->diameter_max - s->diameter_min) * sp_random_uniform(stream));
}

/* Gives the nearest whole number of grains to the large fraction, at random indices. */
static void draw_bidisperse(const sp_pack_spec *s, sp_random *stream, double *r) {
    uint64_t large = (uint64_t)floor(s->large_fraction * s->grains + 0.5);
    for (int32_t i = 0; i < s->grains; i++) {
        const bool one = sp_random_below(stream, (uint64_t)(s->grains - i)) < large;
        r[i] = 0.5 * (one ? s->diameter_max : s->diameter_min);
        large -= one;
    }
}

/* Rejection from the rectangle around the normal density between the limits, which is as fast in a tail as in the
 * middle. */
static void draw_lognormal(const sp_pack_spec *s, sp_random *stream, double *r) {
    const double m = log_median(s), w = s->size_spread, low = s->diameter_min, high = s->diameter_max;
    double a = 0, b = 0;
    if (w > 0 && low < high) {
        a = fmax(-FARTHEST, (same_log(low) - m) / w);
        b = fmin(FARTHEST, (same_log(high) - m) / w);
    }
    const double top = a > 0 ? a : b < 0 ? b : 0; /* position of the maximum */
    for (int32_t i = 0; i < s->grains; i++) {
        double z;
        do
            z = a + (b - a) * sp_random_uniform(stream);
        while (sp_random_uniform(stream) >= same_exp(0.5 * (top * top - z * z)));
        r[i] = 0.5 * fmin(fmax(same_exp(m + w * z), low), high);
    }
}

bool sp_sizes_alike(const sp_pack_spec *spec) { return spec->diameter_max < 1.2 * spec->diameter_min; }

void sp_radii_draw(const sp_pack_spec *s, double *r) {
    sp_random stream = sp_random_make(s->seed, SP_STREAM_DIAMETERS);
    switch (s->sizes) {
    case SP_SIZES_UNIFORM: draw_uniform(s, &stream, r); break;
    case SP_SIZES_BIDISPERSE: draw_bidisperse(s, &stream, r); break;
    case SP_SIZES_LOGNORMAL: draw_lognormal(s, &stream, r); break;
    case SP_SIZES_LIST:
        for (int32_t i = 0; i < s->grains; i++)
            r[i] = 0.5 * s->diameters[i];
        break;
    }
}
