#ifndef SP_REFINE_H
#define SP_REFINE_H
/* Eigenvalues more accurate than LAPACK's. A dense solver has an error of about DBL_EPSILON times the largest
 * eigenvalue, which can exceed that of a soft mode. The Rayleigh quotient of the vector, computed as a sum of squares
 * over springs, has an error of about DBL_EPSILON times the mode's own eigenvalue. */

#include "network/null_motions.h"

#include <sonopack/modes.h>
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

/* Which eigenvalues are zero. By definition those below sp_zero_limit: springs between grains make no mode that is so
 * soft, and a motion that stretches no spring has an eigenvalue far below it in spite of rounding. */

/* Largest eigenvalue omega^2 of M^-1/2 K M^-1/2 that counts as zero. */
double sp_zero_limit(const sp_network *net);

/* Finds how many of the eigenvalues are zero. ritz [count]: refined, in any order of those that are zero and of those
 * that are not, but zeros first; all eigenvalues that are not among them are above the limit. known: number of null
 * motions among them. SP_EREFUSED if it cannot be decided, and for an eigenvalue that is certainly negative. */
sp_status sp_zeros_count(const sp_network *net, int64_t count, const sp_ritz *ritz, int64_t known, int64_t *zeros,
                         sp_error *err);

/* Number of the softest modes that an eigensolver may have mixed with zero modes: up to the first wide gap between
 * eigenvalues, which ascend and have errors of `blur`. 0 if none can be a zero mode. above: the next eigenvalue. */
int64_t sp_zeros_near(int64_t count, const double *values, double blur, double above);

/* Turns the first `count` of the orthonormal vectors [count][dofs], which span the softest modes, so that zero modes
 * and soft modes part. An eigensolver mixes them if their eigenvalues differ by less than its error. Does nothing if
 * all of them are zero modes. */
sp_status sp_zeros_part(const sp_network *net, int64_t count, double *vectors, sp_error *err);

/* The numbers of zero modes, from the null motions and the number of other zero modes. */
sp_zero_modes sp_zeros_sum(const sp_network *net, const sp_null_motions *known, int64_t mechanisms);

#endif
