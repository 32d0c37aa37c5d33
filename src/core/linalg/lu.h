#ifndef SP_LU_H
#define SP_LU_H
/* Sparse real linear systems without symmetry (UMFPACK). */

#include <sonopack/network.h>

typedef struct sp_lu sp_lu;

/* Ordering for matrices with these entries, all of them, of a symmetric pattern; its p and i must outlive it. */
sp_status sp_lu_make(const sp_sparse *a, sp_lu **out, sp_error *err);
/* LU of a matrix with the same pattern, in the place of the one before. SP_EREFUSED for a singular one. */
sp_status sp_lu_factor(sp_lu *f, const sp_sparse *a, sp_error *err);
/* x = A^-1 b, or A^-T b, with a the matrix that was factored. x may not be b. */
sp_status sp_lu_solve(const sp_lu *f, const sp_sparse *a, bool transposed, const double *b, double *x, sp_error *err);
void sp_lu_free(sp_lu *f);

#endif
