#ifndef SP_EXPANSION_H
#define SP_EXPANSION_H
/* The Chebyshev expansion of the signal, without eigenvectors. With A = M^-1/2 K M^-1/2, an upper bound Omega of the
 * frequencies and X = 1 - 2A/Omega^2 = cos(theta), the Jacobi-Anger expansion of sin(Omega t sin(theta/2)) and its
 * cosine gives
 *   F(t) = (2/Omega) sum_k J_(2k+1)(Omega t) b^T W_k(X) a,       W_k = sin((k+1/2) theta)/sin(theta/2)
 * for momenta at t = 0, and for displacements
 *   F(t) = J_0 b^T a + 2 sum_(k>0) J_2k(Omega t) b^T T_k(X) a,   T_k = cos(k theta). */

#include <sonopack/network.h>

/* Growth exponent of a nonsymmetric A; 0 if A is symmetric. The field of values of A lies in a rectangle of the complex
 * plane (sp_network_skew). There |W_k| <= (2k+1) exp(k spread) and |T_k| <= exp(k spread), and 1 + sqrt 2 times this
 * bounds the norms of the matrices (Crouzeix and Palencia, SIAM J. Matrix Anal. Appl. 38, 649, 2017). */
double sp_expansion_spread(const sp_network *net);

/* Number of terms whose remainder is at most `tail`, in units of 2 |a| |b|/Omega (or 2 |a| |b|), for times up to
 * `until`. */
sp_status sp_expansion_terms(const sp_network *net, double until, bool velocity, double tail, int64_t *terms,
                             sp_error *err);
/* Upper bound of the sum over k >= first of |J_(2k+1)(x) W_k| or |J_2k(x) T_k| for a spread above 0. */
double sp_expansion_tail(double x, bool velocity, double spread, int64_t first);

/* Allowed growth factor of the moments. A symmetric A is unstable if |W_k a| exceeds (2k+1)|a| beyond rounding errors.
 * With a nonsymmetric A the motion may grow for some time. */
double sp_expansion_growth(double spread);

/* J_(2k+1)(x) or J_2k(x) for k < *n: all that are not negligible at x. Free *j with sp_free. */
sp_status sp_expansion_bessel(double x, bool velocity, int64_t *n, double **j, sp_error *err);
/* Upper bound of |W_k| (velocity) or |T_k| for a symmetric A. */
static inline double sp_expansion_weight(bool velocity, int64_t k) { return velocity ? 2 * (double)k + 1 : 1; }

#endif
