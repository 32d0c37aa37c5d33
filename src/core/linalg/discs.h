#ifndef SP_DISCS_H
#define SP_DISCS_H
/* Rigorous bounds of the eigenvalues of a nonsymmetric matrix. */

#include <sonopack/network.h>

typedef struct sp_discs {
    int64_t n;
    double *re, *im;   /* [n] centres; of a conjugate pair, the one above the real axis comes first */
    double *radius;    /* [n] */
    double *from, *to; /* [n] V^-1 source and V^T detector, with LAPACK's real vectors: of a pair the real part and then
                          the imaginary one of the vector above the axis */
    double *right, *left; /* [n][n] these vectors V, one a row, and V^-1; NULL if they were not wanted */
} sp_discs;

/* Without vectors, and all numbers 0. */
sp_status sp_discs_empty(int64_t n, sp_discs *out, sp_error *err);

/* Discs whose union contains all eigenvalues of a. A connected component that consists of m discs contains exactly m
 * eigenvalues. a: all entries; dense memory, 32 n^2 bytes. source, detector: [n], or NULL. Method: block Gershgorin
 * discs of V^-1 A V with LAPACK's eigenvectors V; all rounding errors are bounded, those of `from` and `to` are not.
 * SP_EREFUSED if V is nearly singular. */
sp_status sp_discs_make(const sp_sparse *a, const double *source, const double *detector, bool vectors, sp_discs *out,
                        sp_error *err);
/* The connected components: owner [n] is one disc of each. SP_ENOMEM. */
sp_status sp_discs_connect(const sp_discs *d, int64_t *owner, sp_error *err);
void sp_discs_free(sp_discs *d);

#endif
