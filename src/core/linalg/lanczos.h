#ifndef SP_LANCZOS_H
#define SP_LANCZOS_H
/* Eigenpairs of a sparse symmetric A near a shift: block Lanczos on (A - sigma)^-1. */

#include "linalg/ldl.h"

typedef struct sp_lanczos_spec {
    double low, high;     /* open interval of the wanted eigenvalues of A */
    int64_t wanted;       /* minimum number of pairs; those nearest to the shift if the interval holds more */
    int64_t below;        /* and at least as many below the shift (ARPACK does not look at it) */
    double tolerance;     /* |A x - lambda x| <= tolerance times |lambda - sigma|, and times max(|lambda|, floor) */
    double floor;         /* > 0 */
    int64_t locked_count; /* number of known eigenvectors; the search is orthogonal to them */
    const double *locked; /* [locked_count][n], orthonormal */
} sp_lanczos_spec;

/* Converged pairs in the interval, at least `wanted`, eigenvalues ascending. */
typedef struct sp_lanczos_pairs {
    int64_t count;
    double *value;  /* [count] */
    double *vector; /* [count][n], orthonormal */
    int64_t solves; /* right-hand sides */
} sp_lanczos_pairs;

/* factor: the factor of A - sigma. SP_EREFUSED without convergence, and if n is too small for `wanted`. */
sp_status sp_lanczos(sp_ldl *factor, int64_t n, const sp_lanczos_spec *spec, sp_lanczos_pairs *out, sp_error *err);
/* The same search by implicitly restarted Lanczos (ARPACK), one right-hand side after another. ARPACK keeps its state
 * in static variables, so one search runs at a time in a process; others wait. */
sp_status sp_arpack(sp_ldl *factor, int64_t n, const sp_lanczos_spec *spec, sp_lanczos_pairs *out, sp_error *err);
void sp_lanczos_free(sp_lanczos_pairs *p);

#endif
