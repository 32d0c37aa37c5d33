/* The energy of a signal between two frequencies. */
#include "inference/design.h"

#include <math.h>

/* The end of the record fades by the second half of a Hann window over its last third, lest its cut spreads over all
 * frequencies. */
static double fade(int32_t n, int32_t l) {
    const double from = 2.0 / 3 * (n - 1), x = (l - from) / (n - 1 - from);
    return x > 0 ? 0.5 * (1 + cos(M_PI * x)) : 1;
}

/* The integral of |F(omega)|^2 over the band is a double sum of F_l F_m times the kernel sin(w t)/t of the differences
 * of times, at both edges of the band. */
static double lag_kernel(double t, double low, double high) {
    return t == 0 ? high - low : (sin(high * t) - sin(low * t)) / t;
}

double sp_design_band(int32_t n, double spacing, const double *f, double low, double high, double *scratch,
                      double *weight) {
    double energy = 0;
    for (int32_t l = 0; l < n; l++) {
        scratch[l] = fade(n, l) * f[l];
        weight[l] = 0;
    }
    for (int32_t lag = 0; lag < n; lag++) {
        const double scale = spacing * spacing * lag_kernel(lag * spacing, low, high) / M_PI * (lag == 0 ? 1 : 2);
        double sum = 0;
        for (int32_t l = 0; l + lag < n; l++) {
            sum += scratch[l] * scratch[l + lag];
            weight[l] += scale * scratch[l + lag];
            weight[l + lag] += scale * scratch[l];
        }
        energy += scale * sum;
    }
    for (int32_t l = 0; l < n; l++)
        weight[l] *= fade(n, l);
    return energy;
}
