#ifndef SP_COMPLEX_H
#define SP_COMPLEX_H
/* Sparse complex linear systems (UMFPACK, as linalg/lu.h). Complex numbers are pairs (real, imaginary), one behind the
 * other. */

#include <sonopack/status.h>
#include <stdint.h>

typedef struct sp_complex_solver sp_complex_solver;

/* Ordering for matrices of a symmetric pattern, all entries by columns (p [n + 1], i [p[n]] rows, ascending); the
 * arrays must outlive the solver. One ordering serves any number of matrices. */
sp_status sp_complex_make(int64_t n, const int64_t *p, const int64_t *i, sp_complex_solver **out, sp_error *err);
/* LU of the matrix with the entries x [p[n]][2]. SP_EREFUSED for a singular one. */
sp_status sp_complex_factor(sp_complex_solver *s, const double *x, sp_error *err);
/* Solves A v = b with the last matrix factored, its entries x again (for refinement). [n][2] each. */
sp_status sp_complex_solve(sp_complex_solver *s, const double *x, const double *b, double *v, sp_error *err);
void sp_complex_free(sp_complex_solver *s);

#endif
