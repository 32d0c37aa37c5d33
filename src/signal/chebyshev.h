#ifndef SP_CHEBYSHEV_H
#define SP_CHEBYSHEV_H
/* The signal without a single eigenvector. With A = M^-1/2 K M^-1/2, Omega no smaller than the largest frequency and
 * X = 1 - 2A/Omega^2 = cos(theta), the Jacobi-Anger expansion of sin(Omega t sin(theta/2)) and its cosine give
 *   F(t) = (2/Omega) sum_k J_(2k+1)(Omega t) b^T W_k(X) a,       W_k = sin((k+1/2) theta)/sin(theta/2)
 * for momenta at t = 0, and for displacements
 *   F(t) = J_0 b^T a + 2 sum_(k>0) J_2k(Omega t) b^T T_k(X) a,   T_k = cos(k theta). */

#include <sonopack/signal.h>

typedef struct sp_expansion {
    int64_t n;     /* terms */
    double omega;  /* Omega */
    bool velocity; /* W_k, else T_k */
    double *mu;    /* [n] b^T W_k a, or b^T T_k a with the zeroth halved */
    double *size;  /* [n] the sum of the absolute values of its terms */
    double reach;  /* |a| |b| */
    bool bounded;  /* |T_k b| and |W_k a| stayed within their bounds: no frequency above Omega, none imaginary */
} sp_expansion;

/* Number of terms whose tail is at most `tail`, in units of 2 reach/Omega (or 2 reach), for times up to `until`. */
sp_status sp_expansion_terms(double omega, double until, bool velocity, double tail, int64_t *terms, sp_error *err);
/* sent: [dofs] momenta or, without velocity, displacements; seen: [dofs] the detector. */
sp_status sp_expansion_make(const sp_network *net, const double *sent, const double *seen, bool velocity, double omega,
                            int64_t terms, sp_expansion *out, sp_error *err);
void sp_expansion_free(sp_expansion *e);
/* F at n ascending times, and a bound of its error: the tail and rounding. */
sp_status sp_expansion_sum(const sp_expansion *e, int32_t n, const double *t, double *f, double *error, sp_error *err);

#endif
