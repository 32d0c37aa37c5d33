#ifndef SONOPACK_MODES_H
#define SONOPACK_MODES_H
/* Eigenfrequencies and eigenmodes of K u = omega^2 M u. */

#include <sonopack/network.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sp_modes_options {
    bool vectors;     /* false: frequencies only */
    sp_source source; /* for a; b is the force on the top wall */
} sp_modes_options;
sp_modes_options sp_modes_options_default(void);

/* Modes in ascending order; the zero modes of rattlers (dof each) come first and have no vector here.
 * u^(n) = M^(-1/2) e^(n) with e orthonormal. Signal: F(t) = sum a_n b_n sin(omega_n t) (Eq. (3)), or cos for a
 * displacement source. */
typedef struct sp_modes {
    int64_t n;             /* rows below: n_zero rattler modes and one for each degree of freedom of the network */
    int64_t n_rattler;     /* zero modes that belong to rattlers: rows 0 .. n_rattler-1 */
    int64_t n_zero;        /* all modes with omega reported as 0, those included */
    int64_t dofs;          /* length of a vector: network n x dof */
    double *omega;         /* [n] sqrt(E* / rho)/d */
    double *error;         /* [n] bound of the error of omega */
    double *a, *b;         /* [n] source and detector amplitudes; NULL without vectors */
    double *participation; /* [n] (sum w)^2 / (N sum w^2), w = |e|^2 of each of the network's N grains, rattlers left
                              out (1/N for a mode of a rattler); NULL without vectors */
    double *vectors;       /* [n - n_rattler][dofs], e^(n) (mass weighted), the sign makes the largest part positive;
                              NULL without vectors */
    double residual;       /* largest |A e - omega^2 e| / omega_max^2 over modes; NAN without vectors */
    double orthogonality;  /* largest |e_m . e_n - delta|; NAN without vectors */
} sp_modes;

sp_modes sp_modes_none(void);
/* All modes with LAPACK (dense: memory 8 (n dof)^2 bytes twice; refuses above 20000 degrees of freedom). */
sp_status sp_modes_dense(const sp_network *net, const sp_modes_options *opt, sp_modes *out, sp_error *err);
void sp_modes_free(sp_modes *m);

#ifdef __cplusplus
}
#endif
#endif
