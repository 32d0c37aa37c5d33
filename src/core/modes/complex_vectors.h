#ifndef SP_COMPLEX_VECTORS_H
#define SP_COMPLEX_VECTORS_H
/* Right and left vectors of the rows of complex modes. */

#include <sonopack/modes.h>

/* Eigenpairs of A = M^-1/2 J M^-1/2 as sp_discs has them, and which of them each row has. */
typedef struct sp_vector_pairs {
    const double *im, *right, *left; /* [pairs], [pairs][dofs] */
    const double *origin;            /* [m->n] of each row of the modes the number of its eigenvalue */
} sp_vector_pairs;

/* Fills right .. left_im, residual and orthogonality. */
sp_status sp_complex_vectors_make(const sp_network *net, const sp_vector_pairs *p, sp_complex_modes *m, sp_error *err);

#endif
