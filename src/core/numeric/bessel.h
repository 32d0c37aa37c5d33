#ifndef SP_BESSEL_H
#define SP_BESSEL_H
/* Bessel functions J_m(x) of integer orders by downward (Miller) recurrence, and sums of them. Absolute errors are a
 * few 1e-16 per J_m, times sqrt(x) for large x, because x itself is rounded. */

#include <sonopack/visibility.h>

#include <stdint.h>

/* Number of orders that matter, x + 30 + 15 cbrt(x), made even; x >= 0. J_m(x) is below 1e-20 from this order on. */
SP_SHARED int64_t sp_bessel_orders(double x);

/* j[m] = J_m(x) for m < n and finite x >= 0. */
SP_SHARED void sp_bessel_j(double x, int64_t n, double *j);

/* Neumann series f[l] = sum_{k < n} c[k] J_(2k + parity)(x[l]) with parity 0 or 1. x is finite, ascending and >= 0.
 * Visits only the orders that matter for each x. */
void sp_bessel_series(int64_t n, const double *c, int parity, int64_t count, const double *x, double *f);

/* The same for several series that share the Bessel functions: c[n][columns], f[s * stride + l]. scratch:
 * sp_bessel_scratch() doubles, aligned to 64 bytes. */
int64_t sp_bessel_scratch(int64_t n, int64_t columns);
void sp_bessel_series_many(int64_t n, int64_t columns, const double *c, int parity, int64_t count, const double *x,
                           double *f, int64_t stride, double *scratch);

/* Airy function Ai(x) and its derivative for finite x. Relative errors are 1e-14 for |x| < 9 (of the envelope where the
 * functions oscillate), and (1 + |x|^(3/2)) 2e-16 beyond. */
void sp_airy(double x, double *ai, double *slope);

#endif
