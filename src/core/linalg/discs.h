#ifndef SP_DISCS_H
#define SP_DISCS_H
/* Where the eigenvalues of a matrix without symmetry lie, for certain. */

#include <sonopack/network.h>

typedef struct sp_discs {
    int64_t n;
    double *re, *im; /* [n] centres; of a conjugate pair the one above the real axis comes first */
    double *radius;  /* [n] */
} sp_discs;

/* Discs whose union holds all eigenvalues of a (all of its entries given, dense in memory: 32 n^2 bytes); a connected
 * part of the union that consists of m discs holds m of them. By block Gershgorin of V^-1 A V, V the eigenvectors that
 * LAPACK finds, with bounds of all rounding. SP_EREFUSED where V is too near a singular matrix. */
sp_status sp_discs_make(const sp_sparse *a, sp_discs *out, sp_error *err);
void sp_discs_free(sp_discs *d);

#endif
