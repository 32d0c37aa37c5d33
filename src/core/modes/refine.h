#ifndef SP_REFINE_H
#define SP_REFINE_H
/* Eigenvalues better than LAPACK's. The error of a dense solver is some DBL_EPSILON of the LARGEST eigenvalue, which
 * is everything for a soft mode. The Rayleigh quotient of its vector, with the energy as a sum of squares over springs,
 * is right to DBL_EPSILON of the mode's own value. */

#include <sonopack/network.h>

typedef struct sp_ritz {
    double lambda;   /* omega^2 */
    double error;    /* |lambda - exact| is at most this */
    double residual; /* |A e - lambda e| */
} sp_ritz;

/* How far LAPACK's eigenvalues of A = M^-1/2 K M^-1/2 may be off. */
double sp_lapack_error(const sp_network *net);

/* Vectors of which every eigenvalue's error is to be bounded. */
typedef struct sp_refine_set {
    int64_t count;
    const double *vectors; /* [count][n], mass weighted and orthonormal */
    const double *values;  /* [count] ascending, right to `blur`; NULL: the Rayleigh quotients are that, the larger of
                              the  residuals added to the blur */
    double blur;
    double cluster;      /* eigenvalues nearer than this, relative to themselves, are looked at together; beside those
                            that the blur does not resolve */
    double below, above; /* no other eigenvalue of A lies between these; infinite where nothing is there */
} sp_refine_set;

/* Fills ritz [count], in the order of the vectors. */
sp_status sp_modes_refine(const sp_network *net, const sp_refine_set *set, sp_ritz *ritz, sp_error *err);

/* r = A e - lambda e for a mass weighted vector e, by way of u = M^-1/2 e; all [dofs]. */
void sp_mode_residual(const sp_network *net, const double *e, double lambda, double *u, double *r);

#endif
