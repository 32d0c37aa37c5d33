#ifndef SP_CHOLESKY_H
#define SP_CHOLESKY_H
/* Factors of sparse positive definite matrices. */

#include <sonopack/network.h>

typedef struct sp_cholesky sp_cholesky;

/* Factors a symmetric positive definite matrix: the lower triangle, the diagonal entry of each column first.
 * SP_EREFUSED if the matrix is singular or indefinite in double precision. Scaling rows and columns does not change
 * what is refused. */
sp_status sp_cholesky_make(const sp_sparse *a, sp_cholesky **out, sp_error *err);
/* The same in two steps: an ordering for all matrices with this pattern, and the factor of one matrix, which replaces
 * the last factor. After SP_EREFUSED the factor must not be used. */
sp_status sp_cholesky_analyze(const sp_sparse *a, sp_cholesky **out, sp_error *err);
sp_status sp_cholesky_factorize(sp_cholesky *c, const sp_sparse *a, sp_error *err);
/* x = A^-1 b for `columns` right-hand sides, [columns][n] each. Needs no memory and cannot fail. */
void sp_cholesky_solve(sp_cholesky *c, int columns, const double *b, double *x);
void sp_cholesky_free(sp_cholesky *c);

#endif
