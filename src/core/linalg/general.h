#ifndef SP_GENERAL_H
#define SP_GENERAL_H
/* Dense eigenproblems without symmetry (LAPACK). */

#include <sonopack/status.h>
#include <stdint.h>

/* All eigenvalues re + i im of a, n x n by columns, which is overwritten, and their right eigenvectors, [n][n]: of a
 * complex pair, which comes with the positive imaginary part first, real and imaginary part one behind the other. */
SP_SHARED sp_status sp_eigen_general(int64_t n, double *a, double *re, double *im, double *vectors, sp_error *err);

#endif
