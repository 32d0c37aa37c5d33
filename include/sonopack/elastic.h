#ifndef SONOPACK_ELASTIC_H
#define SONOPACK_ELASTIC_H
/* Moduli by imposed global strain (Table II of Somfai et al. 2005, Eqs. (7), (8)). 2D. */

#include <sonopack/network.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sp_moduli {
    double c11, c12, c22, c33;                 /* [E*]; NAN where not computed */
    double c_l, c_t;                           /* sqrt(C22/Phi3*), sqrt(C33/Phi3*), Eq. (8) [sqrt(E* / rho)] */
    double residual;                           /* largest relative residual |K u - f| / |f| of the solves */
    double error11, error12, error22, error33; /* bounds of the errors of C11 .. C33, for these springs [E*] */
} sp_moduli;

/* Sparse Cholesky, one factorisation for all strains. The walls' contact points are strained affinely too, so C12 =
 * C21. phi3s: Phi3* of sp_statics. Floppy parts carry nothing and do no harm. SP_EREFUSED for
 * a packing without walls, or one where no springs lead from wall to wall. */
sp_status sp_moduli_make(const sp_network *net, double phi3s, sp_moduli *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
