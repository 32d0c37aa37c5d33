#ifndef SP_REFINE_H
#define SP_REFINE_H
/* Eigenvalues more accurate than LAPACK's. A dense solver has an error of about DBL_EPSILON times the largest
 * eigenvalue, which can exceed that of a soft mode. The Rayleigh quotient of the vector, computed as a sum of squares
 * over springs, has an error of about DBL_EPSILON times the mode's own eigenvalue. */

#include <sonopack/network.h>

enum { SP_PAIRS_MAX = 256 }; /* largest cluster with zero modes and soft ones whose errors are small */

typedef struct sp_ritz {
    double lambda;   /* omega^2 */
    double error;    /* upper bound of |lambda - exact| */
    double residual; /* |A e - lambda e| */
    double rounding; /* upper bound of |lambda - e . A e| */
} sp_ritz;

/* Error of LAPACK's eigenvalues of A = M^-1/2 K M^-1/2. */
double sp_lapack_error(const sp_network *net);

/* Vectors whose eigenvalues are to be refined. */
typedef struct sp_refine_set {
    int64_t count;
    const double *vectors; /* [count][n], mass weighted and orthonormal */
    const double *values;  /* [count] eigenvalues, ascending, with an error of at most blur; NULL: use the Rayleigh
                              quotients and add the largest residual to blur */
    double blur;
    double cluster; /* eigenvalues within this relative distance belong to one cluster, as do those within the blur */
    int64_t soft;   /* so many of the first vectors are one cluster, whatever their eigenvalues */
    double below, above; /* all other eigenvalues of A lie below `below` or above `above`; infinite if there are none */
} sp_refine_set;

/* Fills ritz [count] in the order of the vectors. */
sp_status sp_modes_refine(const sp_network *net, const sp_refine_set *set, sp_ritz *ritz, sp_error *err);

/* r = A e - lambda e for a mass-weighted vector e; u = M^-1/2 e is scratch. All [dofs]. */
void sp_mode_residual(const sp_network *net, const double *e, double lambda, double *u, double *r);

#endif
