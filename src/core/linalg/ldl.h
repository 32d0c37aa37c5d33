#ifndef SP_LDL_H
#define SP_LDL_H
/* LDL' of A - sigma with sigma anywhere, also inside the spectrum: how many eigenvalues lie below sigma (Sylvester's
 * law of inertia), and solves with eight right-hand sides at once. */

#include <sonopack/network.h>

enum { SP_LDL_LANES = 8 }; /* right-hand sides of a solve */

typedef struct sp_ldl sp_ldl;

/* Ordering and pattern of the factor; serves every sigma. Keeps a copy of a. */
sp_status sp_ldl_make(const sp_sparse *a, sp_ldl **out, sp_error *err);
/* Replaces the factor by that of A - sigma. SP_EREFUSED where a pivot is zero (no rows are exchanged): another sigma,
 * next to this one, will do. After a failure there is no factor. */
sp_status sp_ldl_factor(sp_ldl *f, double sigma, sp_error *err);
double sp_ldl_sigma(const sp_ldl *f);
/* The number of negative pivots: of the eigenvalues below sigma of a matrix that is within sp_ldl_error of A. */
int64_t sp_ldl_negative(const sp_ldl *f);
/* Bound of |E|, where the factor is exactly that of A - sigma + E. Small pivots that spoil the digits show here. */
double sp_ldl_error(const sp_ldl *f);
/* Entries of the factor: a solve takes twice as many products for each right-hand side. */
int64_t sp_ldl_entries(const sp_ldl *f);
/* x = (A - sigma)^-1 b for [8][n]; x may be b. Allocates nothing, cannot fail. */
void sp_ldl_solve(sp_ldl *f, const double *b, double *x);
void sp_ldl_free(sp_ldl *f);

#endif
