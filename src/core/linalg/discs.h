#ifndef SP_DISCS_H
#define SP_DISCS_H
/* Rigorous bounds of the eigenvalues of a nonsymmetric matrix. */

#include <sonopack/network.h>

typedef struct sp_discs {
    int64_t n;
    double *re, *im; /* [n] centres; of a conjugate pair, the one above the real axis comes first */
    double *radius;  /* [n] */
} sp_discs;

/* Discs whose union contains all eigenvalues of a. A connected component that consists of m discs contains exactly m
 * eigenvalues. a: all entries; dense memory, 32 n^2 bytes. Method: block Gershgorin discs of V^-1 A V with LAPACK's
 * eigenvectors V; all rounding errors are bounded. SP_EREFUSED if V is nearly singular. */
sp_status sp_discs_make(const sp_sparse *a, sp_discs *out, sp_error *err);
void sp_discs_free(sp_discs *d);

#endif
