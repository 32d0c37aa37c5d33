#ifndef SP_PASS_H
#define SP_PASS_H
/* The Chebyshev expansion of the signal, without eigenvectors. With A = M^-1/2 K M^-1/2, an upper bound Omega of the
 * frequencies and X = 1 - 2A/Omega^2 = cos(theta), the Jacobi-Anger expansion of sin(Omega t sin(theta/2)) and its
 * cosine gives
 *   F(t) = (2/Omega) sum_k J_(2k+1)(Omega t) b^T W_k(X) a,       W_k = sin((k+1/2) theta)/sin(theta/2)
 * for momenta at t = 0, and for displacements
 *   F(t) = J_0 b^T a + 2 sum_(k>0) J_2k(Omega t) b^T T_k(X) a,   T_k = cos(k theta). */

#include "signal/recurrence.h"

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

/* Upper bound of |W_k| (velocity) or |T_k| for a symmetric A. */
static inline double sp_expansion_weight(bool velocity, int64_t k) { return velocity ? 2 * (double)k + 1 : 1; }

/* ---- passes ----------------------------------------------------------------------------------------------------- */

/* Moments b^T W_k a or b^T T_k a of sources a and detectors b from one recurrence, for as many k as needed. A single
 * pair uses doubling: one lane propagates the source and one the detector, and each step gives two moments. For several
 * pairs a pass propagates two sources (or two detectors if these are fewer), and each step gives the products with all
 * observers. */
typedef struct pass {
    recurrence r;
    bool doubled;                  /* one lane for the source and one for the detector */
    bool velocity;                 /* moments of W, else of T */
    int32_t lanes, observer_count; /* number of propagated vectors; number of observers */
    const sparse_row *observers;   /* [observers] */
    int64_t columns;               /* moments per step: 1, or lanes x observers, lane by lane */
    int64_t n, capacity;           /* moments known, and moments for which there is memory */
    double *mu;                    /* [capacity][columns] moments; mu_0 of T is halved */
    double *size;                  /* [capacity][columns] sums of the absolute values of their terms */
    double *norms;                 /* [columns] |a| |b| */
    double first;                  /* mu_0 of a doubled pass */
    double spread;                 /* as in the plan */
} pass;

typedef struct pass_plan {
    const sp_operator *op;
    const double *mass;
    double omega;
    int threads;
    bool velocity, doubled;
    double spread; /* sp_expansion_spread; must be 0 for doubling */
    int64_t terms; /* upper limit of their number */
    int32_t lanes, observer_count;
    const sparse_row *propagated; /* [lanes] vectors to propagate; with doubling: the source */
    const sparse_row *observers;  /* [observers]; with doubling: the detector */
} pass_plan;

sp_status sp_pass_make(const pass_plan *plan, pass *out, sp_error *err);
/* Computes at least n moments, up to the plan's number of terms. */
void sp_pass_extend(pass *p, int64_t n);
void sp_pass_free(pass *p);
/* Whether |T_k b| and |W_k a| stay within their bounds, so that no frequency is above Omega or imaginary. */
bool sp_pass_bounded(const pass *p);

/* F of all columns at n ascending times, f[column * stride + l], and upper bounds of the errors: remainder and
 * rounding. */
sp_status sp_pass_sum(const pass *p, double omega, int64_t n, const double *t, int64_t stride, double *f,
                      double *errors, sp_error *err);

#endif
