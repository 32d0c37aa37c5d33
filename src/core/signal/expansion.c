/* Terms, sums and error bounds of the Chebyshev expansion. */
#include "base/base.h"
#include "numeric/bessel.h"
#include "signal/chebyshev.h"

#include <float.h>
#include <math.h>

/* Weight of |J_(2k+1)| or |J_2k| in the tail: |b^T W_k a| <= (2k+1) |a||b|, |b^T T_k a| <= |a||b|. */
static double weight(bool velocity, int64_t k) { return velocity ? 2 * (double)k + 1 : 1; }

/* Rounding: see rounding(). */
#define MOMENT_ROUNDING 5.0
#define PHASE_ROUNDING  5.0

/* J_(2k+1) or J_2k at x for k < *n, all that are not negligible there. Above x they fall with the order and rise with
 * x, so the last time has the largest tail. */
static sp_status bessel_terms(double x, bool velocity, int64_t *n, double **j, sp_error *err) {
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
 * exp(2k |Im theta|). cosh(2 Im theta) = (|X + 1| + |X - 1|)/2 is convex in X, so that its largest value is at a corner
 * of the rectangle: at that beyond lambda = 0, or at that at Omega^2. */
double sp_expansion_spread(const sp_network *net) {
    const double square = sp_network_omega_bound(net) * sp_network_omega_bound(net);
    if (!net->carried || !(square > 0))
        return 0;
    const double down = sp_network_soft(net) / square, side = sp_network_skew(net) / square;
    return acosh(fmax(hypot(1 + down, side) + hypot(down, side), hypot(1, side) + side));
}

double sp_expansion_growth(double spread) { return spread > 0 ? 10 : 1.0001; }

/* Logarithm of a bound of |J_m(x)|: Kapteyn's inequality [DLMF 10.14.8]. */
static double log_bessel(double m, double x) {
    if (m <= x || m == 0)
        return 0;
    const double z = x / m, root = sqrt(1 - z * z);
    return z > 0 ? m * (log(z) + root - log1p(root)) : -HUGE_VAL;
}

double sp_expansion_tail(double x, bool velocity, double spread, int64_t first) {
    const double factor = 1 + sqrt(2.0);
    double sum = 0, before = HUGE_VAL;
    /* from where each term is less than half of the one before the rest is less than the last one */
    for (int64_t k = first;; k++) {
        const double term = weight(velocity, k) * exp((double)k * spread + log_bessel(2 * (double)k + velocity, x));
        sum += term;
        if (!isfinite(sum) || (term <= 0.5 * before && 2 * (double)k > x && term <= 1e-3 * sum))
            return factor * (sum + term);
        before = term;
    }
}

/* The first k with a small enough tail, by doubling steps and halving them again. */
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
    sp_status status = bessel_terms(omega * until, velocity, &n, &j, err);
    if (status != SP_OK)
        return status;
    while (n > 1) {
        sum += weight(velocity, n - 1) * fabs(j[n - 1]);
        if (sum > tail)
            break;
        n--;
    }
    sp_free(j);
    *terms = n;
    return SP_OK;
}

/* Rounding, as it adds up: moment k carries the independent errors of some k/2 steps (k, if it was not met half way),
 * each a few DBL_EPSILON of its terms; Omega t is known to DBL_EPSILON of itself. The factors leave room for 5 times
 * what is seen. */
static double rounding(const pass *p, int64_t column, double x, int64_t n, const double *j) {
    double moments = 0, signal = 0;
    for (int64_t k = 0; k < n && k < p->n; k++) {
        const double size = p->size[k * p->columns + column], mu = p->mu[k * p->columns + column];
        const double own = j[k] * size * sqrt(1 + (double)k), term = j[k] * mu;
        moments += own * own;
        signal += term * term;
    }
    return DBL_EPSILON * (MOMENT_ROUNDING * sqrt(moments) + PHASE_ROUNDING * (1 + x) * sqrt(signal));
}

static sp_status find_errors(const pass *p, double omega, double last, double *errors, sp_error *err) {
    const double scale = p->velocity ? 2 / omega : 2, x = omega * last;
    double *j = NULL, tail = 0, sum = 0;
    int64_t terms = 0;
    sp_status status = bessel_terms(x, p->velocity, &terms, &j, err);
    if (status != SP_OK)
        return status;
    for (int64_t k = p->n; k < terms && !(p->spread > 0); k++)
        tail += weight(p->velocity, k) * fabs(j[k]);
    if (p->spread > 0)
        tail = sp_expansion_tail(x, p->velocity, p->spread, p->n);
    else
        tail += 2 * weight(p->velocity, terms) * fabs(j[terms - 1]); /* those left out as negligible */
    for (int64_t k = 0; k < terms && k < p->n; k++)
        sum += fabs(j[k]);
    tail += sum * sp_recurrence_dropped(&p->r, p->n);
    for (int64_t c = 0; c < p->columns; c++) {
        double low = 0; /* moments of orders that count as 0, those of a spread being no smaller than others */
        for (int64_t k = terms; k < p->n && p->spread > 0; k++)
            low += 1e-20 * fabs(p->mu[k * p->columns + c]);
        errors[c] = scale * (p->reach[c] * tail + low + rounding(p, c, x, terms, j));
    }
    sp_free(j);
    return SP_OK;
}

sp_status sp_expansion_sum(const pass *p, double omega, int64_t n, const double *t, int64_t stride, double *f,
                           double *errors, sp_error *err) {
    const double scale = p->velocity ? 2 / omega : 2;
    double *x = sp_alloc((size_t)n, sizeof *x), *room = NULL;
    sp_status status = SP_OK;
    if (p->columns > 1)
        room = sp_alloc((size_t)sp_bessel_scratch(p->n, p->columns), sizeof *room);
    if (!x || (p->columns > 1 && !room)) {
        status = sp_fail_memory(err, ((size_t)n + (size_t)sp_bessel_scratch(p->n, p->columns)) * sizeof *x);
        goto out;
    }
    for (int64_t l = 0; l < n; l++)
        x[l] = omega * t[l];
    if (p->columns == 1)
        sp_bessel_series(p->n, p->mu, p->velocity, n, x, f);
    else
        sp_bessel_series_many(p->n, p->columns, p->mu, p->velocity, n, x, f, stride, room);
    for (int64_t c = 0; c < p->columns; c++)
        for (int64_t l = 0; l < n; l++)
            f[c * stride + l] *= scale;
    status = find_errors(p, omega, t[n - 1], errors, err);
out:
    sp_free(x);
    sp_free(room);
    return status;
}
