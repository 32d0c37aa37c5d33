#ifndef SP_TWO_SIDED_H
#define SP_TWO_SIDED_H
/* The eigenvalues with the lowest real parts of a nonsymmetric A that is near its symmetric part S, with right and left
 * vectors, and discs that contain them. */

#include "linalg/discs.h"
#include "linalg/ldl.h"

typedef struct sp_two_sided_spec {
    int64_t wanted, more; /* eigenvalues wanted, and others above them that are found less accurately */
    double goal;          /* |A x - lambda x| <= goal |x| of those wanted, and the same of the left vectors */
    double noise;         /* upper bound of |a - A| */
} sp_two_sided_spec;

/* Of a complex pair the eigenvalue above the real axis comes first; its two rows hold the real and the imaginary part
 * of its right vector, and the rows of the inverse: left right^T = 1. */
typedef struct sp_two_sided {
    int64_t n, wanted, count; /* length of a vector; `wanted` and one more if a pair would be divided; all rows */
    double *re, *im;          /* [count] in ascending order of re */
    double *right, *left;     /* [count][n] */
} sp_two_sided;

/* Davidson's method with one orthonormal basis for right and left vectors. factor: that of S at a shift below the
 * wanted eigenvalues, which makes corrections of residuals; the first basis consists of S's own lowest vectors. a: all
 * entries. SP_EREFUSED without convergence. */
sp_status sp_two_sided_make(sp_ldl *factor, const sp_sparse *a, const sp_two_sided_spec *spec, sp_two_sided *out,
                            sp_error *err);
void sp_two_sided_free(sp_two_sided *t);
/* out [count][n] = A x - lambda x of the right vectors, or A^T w - lambda w of the left ones, by pairs. */
void sp_two_sided_residuals(const sp_two_sided *t, const sp_sparse *a, bool left, double *out);
/* out = A x, or A^T x. */
void sp_sparse_apply(const sp_sparse *a, bool transposed, const double *x, double *out);

/* Discs as those of sp_discs_make, of all eigenvalues with real parts below *complete: each component of discs that
 * lies below it has as many eigenvalues as discs, and there are no others. It is above the wanted ones. Factors S anew:
 * the inertia of S - mu on the complement of the left vectors bounds all other eigenvalues. SP_EREFUSED if it does not.
 */
sp_status sp_two_sided_enclose(const sp_two_sided *t, sp_ldl *factor, const sp_sparse *a, const sp_two_sided_spec *spec,
                               double *complete, sp_discs *out, sp_error *err);

#endif
