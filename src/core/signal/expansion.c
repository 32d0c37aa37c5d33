/* Number of terms and truncation error of the Chebyshev expansion. */
#include "signal/expansion.h"
#include "base/base.h"
#include "numeric/bessel.h"

#include <math.h>

/* Above x these functions decrease with the order and increase with x, so the last time has the largest tail. */
sp_status sp_expansion_bessel(double x, bool velocity, int64_t *n, double **j, sp_error *err) {
    const int64_t orders = sp_bessel_orders(x);
    double *all = sp_alloc((size_t)orders, sizeof *all);
    if (!all)
        return sp_fail_memory(err, (size_t)orders * sizeof *all);
    sp_bessel_j(x, orders, all);
    *n = orders / 2;
    for (int64_t k = 0; k < *n; k++)
        all[k] = all[2 * k + velocity];
    *j = all;
    return SP_OK;
}

/* With lambda = Omega^2 sin^2(theta) and X = cos(2 theta), |W_k| = |sin((2k+1) theta)/sin(theta)| is at most (2k+1)
 * exp(2k |Im theta|). cosh(2 Im theta) = (|X + 1| + |X - 1|)/2 is convex in X and therefore largest at a corner of the
 * rectangle, beyond lambda = 0 or at Omega^2. */
double sp_expansion_spread(const sp_network *net) {
    const double square = sp_network_omega_bound(net) * sp_network_omega_bound(net);
    if (!net->carried || !(square > 0))
        return 0;
    const double down = sp_network_soft(net) / square, side = sp_network_skew(net) / square;
    return acosh(fmax(hypot(1 + down, side) + hypot(down, side), hypot(1, side) + side));
}

double sp_expansion_growth(double spread) { return spread > 0 ? 10 : 1.0001; }

/* Logarithm of a bound of |J_m(x)| by Kapteyn's inequality [DLMF 10.14.8]. */
static double log_bessel(double m, double x) {
    if (m <= x || m == 0)
        return 0;
    const double z = x / m, root = sqrt(1 - z * z);
    return z > 0 ? m * (log(z) + root - log1p(root)) : -HUGE_VAL;
}

double sp_expansion_tail(double x, bool velocity, double spread, int64_t first) {
    const double factor = 1 + sqrt(2.0);
    double sum = 0, before = HUGE_VAL;
    /* once each term is less than half the one before, the remainder is less than the last term */
    for (int64_t k = first;; k++) {
        const double term =
            sp_expansion_weight(velocity, k) * exp((double)k * spread + log_bessel(2 * (double)k + velocity, x));
        sum += term;
        if (!isfinite(sum) || (term <= 0.5 * before && 2 * (double)k > x && term <= 1e-3 * sum))
            return factor * (sum + term);
        before = term;
    }
}

/* Finds the first k with a small enough tail, by bracketing and bisection. */
static int64_t terms_of_spread(double x, bool velocity, double spread, double tail) {
    int64_t low = 0, high = 8 + (int64_t)(0.5 * x);
    while (!(sp_expansion_tail(x, velocity, spread, high) <= tail)) {
        low = high;
        high += high / 4 + 8;
    }
    while (high - low > 1) {
        const int64_t middle = low + (high - low) / 2;
        if (sp_expansion_tail(x, velocity, spread, middle) <= tail)
            high = middle;
        else
            low = middle;
    }
    return high;
}

sp_status sp_expansion_terms(const sp_network *net, double until, bool velocity, double tail, int64_t *terms,
                             sp_error *err) {
    const double omega = sp_network_omega_bound(net), spread = sp_expansion_spread(net);
    double *j = NULL, sum = 0;
    int64_t n = 0;
    if (spread > 0) {
        *terms = terms_of_spread(omega * until, velocity, spread, tail);
        return SP_OK;
    }
    sp_status status = sp_expansion_bessel(omega * until, velocity, &n, &j, err);
    if (status != SP_OK)
        return status;
    while (n > 1) {
        sum += sp_expansion_weight(velocity, n - 1) * fabs(j[n - 1]);
        if (sum > tail)
            break;
        n--;
    }
    sp_free(j);
    *terms = n;
    return SP_OK;
}
