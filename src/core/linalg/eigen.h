#ifndef SP_EIGEN_H
#define SP_EIGEN_H
/* Dense eigenproblems (LAPACK). Matrices are n x n by columns; of symmetric ones only the lower triangle is read. */

#include <sonopack/status.h>
#include <stdint.h>

/* All eigenvalues w in ascending order. Overwrites a with the orthonormal eigenvectors, by columns. */
sp_status sp_eigen_all(int64_t n, double *a, double *w, sp_error *err);

/* All eigenvalues w in ascending order, without vectors. Destroys a. Reduces it to a band and the band to tridiagonal
 * form: nearly all of the work is products of matrices, while a reduction in one stage reads the whole matrix once for
 * each column. */
sp_status sp_eigen_values(int64_t n, double *a, double *w, sp_error *err);

/* A = Q T Q^T with a tridiagonal T; Q is stored in a. One reduction gives all eigenvalues, and eigenvectors of the
 * lowest ones. */
typedef struct sp_tridiagonal {
    int64_t n;
    double *a;           /* the caller's matrix, not freed */
    double *d, *e, *tau; /* diagonal, subdiagonal, scalar factors of the reflectors */
} sp_tridiagonal;
sp_status sp_tridiagonal_make(int64_t n, double *a, sp_tridiagonal *out, sp_error *err);
void sp_tridiagonal_free(sp_tridiagonal *t);
/* All eigenvalues in ascending order. */
sp_status sp_tridiagonal_values(const sp_tridiagonal *t, double *w, sp_error *err);
/* Orthonormal eigenvectors of the `count` lowest eigenvalues, [count][n]. */
sp_status sp_tridiagonal_vectors(const sp_tridiagonal *t, int64_t count, double *vectors, sp_error *err);

/* out[c][v] = column c . vector v, with columns [columns][n] and vectors [count][n]. */
void sp_project(int64_t n, int64_t count, const double *vectors, int64_t columns, const double *column, double *out);
/* out [columns][n] = sums of vectors [count][n] with the weights c [columns][count]; or these are taken away from out.
 */
void sp_combine(int64_t n, int64_t count, const double *vectors, int64_t columns, const double *c, double *out);
void sp_take_away(int64_t n, int64_t count, const double *vectors, int64_t columns, const double *c, double *out);
/* Vectors [count][n] become an orthonormal basis of the space that they span. tau: [count]. */
sp_status sp_orthonormalize(int64_t n, int64_t count, double *vectors, double *tau, sp_error *err);
/* Makes a column orthogonal to orthonormal vectors [count][n]. work: [count]. */
void sp_project_out(int64_t n, int64_t count, const double *vectors, double *column, double *work);
/* Largest |x . y - delta| over all pairs of vectors [count][n], delta = 1 for x with itself and 0 otherwise. */
sp_status sp_orthogonality(int64_t n, int64_t count, const double *vectors, double *largest, sp_error *err);

/* All eigenvalues re + i im of a (n x n by columns, overwritten) and their right eigenvectors [n][n]. Of a complex pair
 * the eigenvalue with positive imaginary part comes first; its two rows hold the real and the imaginary part of its
 * eigenvector. */
SP_SHARED sp_status sp_eigen_general(int64_t n, double *a, double *re, double *im, double *vectors, sp_error *err);

#endif
