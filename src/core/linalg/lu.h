#ifndef SP_LU_H
#define SP_LU_H
/* LU factorisation of complex sparse matrices without symmetry (UMFPACK). */

#include <sonopack/status.h>
#include <stdbool.h>
#include <stdint.h>

typedef struct sp_lu sp_lu;

/* Fill-reducing ordering for n x n matrices of one pattern: all entries in compressed columns, p [n + 1] and i [p[n]],
 * rows ascending. The pattern must be symmetric. p and i must outlive *out. One ordering serves any number of matrices
 * with this pattern. The values of the matrix and of vectors are pairs (real, imaginary). SP_EINVAL if is_complex is
 * false. */
sp_status sp_lu_make(int64_t n, const int64_t *p, const int64_t *i, bool is_complex, sp_lu **out, sp_error *err);
/* Factors the matrix with the values x [p[n]]; replaces the last factor. SP_EREFUSED if the matrix is singular. */
sp_status sp_lu_factor(sp_lu *f, const double *x, sp_error *err);
/* v = A^-1 b, or A^-T b if transposed. x: the values that were factored, needed for refinement.
 * v and b must not overlap. */
sp_status sp_lu_solve(const sp_lu *f, const double *x, bool transposed, const double *b, double *v, sp_error *err);
void sp_lu_free(sp_lu *f);

#endif
