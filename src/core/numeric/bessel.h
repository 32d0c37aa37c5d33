#ifndef SP_BESSEL_H
#define SP_BESSEL_H
/* Bessel functions J_m(x) of all needed integer orders by downward (Miller) recurrence, and sums of them. Errors are
 * absolute, a few 1e-16 for each J_m (times sqrt(x) for large x: x itself is only known to rounding). */

#include <sonopack/export.h>

#include <stdint.h>

/* Orders from here on are below 1e-20 and count as 0: x + 30 + 15 cbrt(x), made even. x >= 0. */
SP_SHARED int64_t sp_bessel_orders(double x);

/* j[m] = J_m(x) for m < n; x >= 0, finite. */
SP_SHARED void sp_bessel_j(double x, int64_t n, double *j);

/* Neumann series f[l] = sum_{k < n} c[k] J_(2k + parity)(x[l]), parity 0 or 1; x >= 0, finite, ascending. For each x
 * only the orders that matter at it are visited. */
void sp_bessel_series(int64_t n, const double *c, int parity, int64_t count, const double *x, double *f);

/* The same for several series at once, which share the Bessel functions: c[n][columns], f[s * stride + l]. room:
 * sp_bessel_scratch() numbers, aligned to 64 bytes. */
int64_t sp_bessel_scratch(int64_t n, int64_t columns);
void sp_bessel_series_many(int64_t n, int64_t columns, const double *c, int parity, int64_t count, const double *x,
                           double *f, int64_t stride, double *room);

#endif
