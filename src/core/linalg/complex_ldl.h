#ifndef SP_COMPLEX_LDL_H
#define SP_COMPLEX_LDL_H
/* LDL' factorization of complex symmetric matrices, without exchanges of rows. Numbers are pairs (real, imaginary). */

#include <sonopack/network.h>
#include <sonopack/status.h>

typedef struct sp_complex_ldl sp_complex_ldl;

/* Orders the pattern of a, a lower triangle (values are not read), for all matrices with this pattern. net: as for
 * sp_supernodes_make. */
sp_status sp_complex_ldl_make(const sp_sparse *a, const sp_network *net, sp_complex_ldl **out, sp_error *err);
/* Factors the matrix with the values x [a->p[n]][2]; replaces the last factor. SP_EREFUSED if a pivot is zero. Small
 * pivots may spoil the factor: look at the residual of a solution. */
sp_status sp_complex_ldl_factor(sp_complex_ldl *f, const double *x, sp_error *err);
/* x = A^-1 b for `count` right-hand sides, [count][n][2] each. x may be b. */
sp_status sp_complex_ldl_solve(sp_complex_ldl *f, int count, const double *b, double *x, sp_error *err);
void sp_complex_ldl_free(sp_complex_ldl *f);

#endif
