#ifndef SP_LANCZOS_H
#define SP_LANCZOS_H
/* Eigenpairs of a sparse symmetric A near a shift: block Lanczos on (A - sigma)^-1. */

#include "linalg/ldl.h"

typedef struct sp_lanczos_spec {
    double low, high;     /* open interval of eigenvalues of A that are wanted */
    int64_t wanted;       /* how many of them; those nearest to the shift where the interval holds more */
    double tolerance;     /* |A x - lambda x| at most, over |lambda - sigma| and over |lambda| or the floor */
    double floor;         /* > 0 */
    int64_t locked_count; /* vectors that are known already: the search is orthogonal to them */
    const double *locked; /* [locked_count][n], orthonormal */
} sp_lanczos_spec;

/* Converged pairs of the interval, eigenvalues ascending; `wanted` of them at least. */
typedef struct sp_lanczos_pairs {
    int64_t count;
    double *value;     /* [count] */
    double *vector;    /* [count][n], orthonormal */
    int64_t solves;    /* right-hand sides */
    double seconds[3]; /* of CPU time: solves, orthogonalisation, small eigenproblems and vectors */
} sp_lanczos_pairs;

/* The factor holds the shift. SP_EREFUSED without convergence, or where the order is too small for `wanted`. */
sp_status sp_lanczos(sp_ldl *factor, int64_t n, const sp_lanczos_spec *spec, sp_lanczos_pairs *out, sp_error *err);
void sp_lanczos_free(sp_lanczos_pairs *p);

#endif
