#ifndef SP_LDL_H
#define SP_LDL_H
/* LDL' factorization of A - sigma with any sigma, also inside the spectrum. It gives the number of eigenvalues below
 * sigma (Sylvester's law of inertia) and solves eight right-hand sides at once. */

#include "linalg/block.h"

#include <sonopack/network.h>

enum { SP_LDL_LANES = SP_BLOCK }; /* right-hand sides per solve */

typedef struct sp_ldl sp_ldl;

/* Orders the matrix and finds the pattern of the factor, for all sigma. Keeps a copy of a. net: as for
 * sp_supernodes_make. */
sp_status sp_ldl_make(const sp_sparse *a, const sp_network *net, sp_ldl **out, sp_error *err);
/* Lets `threads` threads factor, if the factor is large; its bits stay the same. SP_ENOMEM. */
sp_status sp_ldl_share(sp_ldl *f, int threads, sp_error *err);
sp_pool *sp_ldl_pool(const sp_ldl *f); /* of those threads; NULL: one */
/* Replaces A by another matrix with the same pattern. SP_EINVAL for entries that are not finite. */
sp_status sp_ldl_set(sp_ldl *f, const sp_sparse *a, sp_error *err);
/* Factors A - sigma; replaces the last factor. SP_EREFUSED if a pivot is zero (rows are not exchanged); try a sigma
 * nearby. After a failure there is no factor. */
sp_status sp_ldl_factor(sp_ldl *f, double sigma, sp_error *err);
double sp_ldl_sigma(const sp_ldl *f);
/* Number of negative pivots: the number of eigenvalues below sigma of a matrix within sp_ldl_error of A. */
int64_t sp_ldl_negative(const sp_ldl *f);
/* Upper bound of |E|, where the factor is exactly that of A - sigma + E. Large if small pivots have spoilt the
 * factor. */
double sp_ldl_error(const sp_ldl *f);
/* The smallest ratio of a pivot to the entry of a's diagonal that elimination made it from, for sigma = 0: how much was
 * cancelled. It does not change if rows and columns of A are scaled, so that soft grains among stiff ones do not look
 * singular. */
double sp_ldl_least_ratio(const sp_ldl *f, const sp_sparse *a);
/* x = (A - sigma)^-1 b, [8][n] each. x may be b. Needs no memory and cannot fail. */
void sp_ldl_solve(sp_ldl *f, const double *b, double *x);
/* The same for one right-hand side, [n]. */
void sp_ldl_solve_one(sp_ldl *f, const double *b, double *x);
void sp_ldl_free(sp_ldl *f);

#endif
