#ifndef SP_GENERAL_H
#define SP_GENERAL_H
/* Dense nonsymmetric eigenproblems (LAPACK). */

#include <sonopack/status.h>
#include <stdint.h>

/* All eigenvalues re + i im of a (n x n by columns, overwritten) and their right eigenvectors [n][n]. Of a complex pair
 * the eigenvalue with positive imaginary part comes first; its two rows hold the real and the imaginary part of its
 * eigenvector. */
SP_SHARED sp_status sp_eigen_general(int64_t n, double *a, double *re, double *im, double *vectors, sp_error *err);

#endif
