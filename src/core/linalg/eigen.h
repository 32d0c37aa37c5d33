#ifndef SP_EIGEN_H
#define SP_EIGEN_H
/* Dense symmetric eigenproblems (LAPACK). Matrices are n x n by columns, the lower triangle given. */

#include <sonopack/status.h>
#include <stdint.h>

/* All eigenvalues w, ascending; a is overwritten with the orthonormal eigenvectors in its columns. */
sp_status sp_eigen_all(int64_t n, double *a, double *w, sp_error *err);

/* A = Q T Q^T with T tridiagonal; Q stays hidden in a. Reduce once, then take all values, and vectors of a few. */
typedef struct sp_tridiagonal {
    int64_t n;
    double *a;           /* borrowed from the caller */
    double *d, *e, *tau; /* diagonal, subdiagonal, reflectors */
} sp_tridiagonal;
sp_status sp_tridiagonal_make(int64_t n, double *a, sp_tridiagonal *out, sp_error *err);
void sp_tridiagonal_free(sp_tridiagonal *t);
/* All eigenvalues, ascending. */
sp_status sp_tridiagonal_values(const sp_tridiagonal *t, double *w, sp_error *err);
/* Orthonormal eigenvectors of the `count` lowest, [count][n]. */
sp_status sp_tridiagonal_vectors(const sp_tridiagonal *t, int64_t count, double *vectors, sp_error *err);

/* out[c][v] = column c . vector v, for columns [columns][n] and vectors [count][n]. */
void sp_project(int64_t n, int64_t count, const double *vectors, int columns, const double *column, double *out);
/* Largest |x . y - (same vector)| over all pairs of `count` vectors of length n, [count][n]. */
sp_status sp_orthogonality(int64_t n, int64_t count, const double *vectors, double *largest, sp_error *err);

#endif
