#ifndef SONOPACK_ELASTIC_H
#define SONOPACK_ELASTIC_H
/* Elastic moduli: by imposed global strain (Table II of Somfai et al. 2005, Eqs. (7), (8)), and by the probes of its
 * Appendix B (Tables IV and V). */

#include <sonopack/network.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Axes as in the paper: in 2D 1 is along the walls, 2 from wall to wall, C33 the shear modulus of the two. In 3D 1 and
 * 2 are along the walls, 3 from wall to wall, and C44 (23), C55 (13), C66 (12) the shear moduli in Voigt's notation. */
typedef struct sp_moduli {
    double c11, c12, c22, c33;                 /* [E*]; NAN where not computed */
    double c13, c23, c44, c55, c66;            /* 3D [E*]; NAN in 2D */
    double c_l, c_t;                           /* of waves from wall to wall, Eq. (8) [sqrt(E* / rho)]: sqrt(C22/Phi3*),
                                                  sqrt(C33/Phi3*); 3D sqrt(C33/Phi3*), sqrt((C44+C55)/(2 Phi3*)) */
    double residual;                           /* largest relative residual |K u - f| / |f| of the solves */
    double error11, error12, error22, error33; /* bounds of the errors of C11 .. C33, for these springs [E*] */
} sp_moduli;

/* Sparse Cholesky, one factorisation for all strains. The walls' contact points are strained affinely too, so C12 =
 * C21. phi3s: Phi3* of sp_statics. Floppy parts carry nothing and do no harm. SP_EREFUSED for
 * a packing without walls, or one where no springs lead from wall to wall. */
sp_status sp_moduli_make(const sp_network *net, double phi3s, sp_moduli *out, sp_error *err);

typedef enum sp_probe_kind {
    SP_PROBE_SINE = 0, /* body force f0 sin(n pi y / L), walls fixed: Eqs. (B1), (B2) */
    SP_PROBE_LINES     /* grains on the lines y = k L / (n + 1) displaced by turns, n odd: Eq. (B3) */
} sp_probe_kind;
typedef struct sp_probe {
    sp_probe_kind kind;
    int32_t n; /* >= 1 */
} sp_probe;
/* Apparent moduli from the elastic energy [E*]. */
typedef struct sp_probed {
    double along;                    /* of motion from wall to wall: C22, 3D C33 */
    double shear;                    /* of motion along x: C33, 3D C55 */
    double error_along, error_shear; /* bounds of their errors, for these springs */
} sp_probed;
/* out[count] of the probes; *global, if not NULL, as from sp_moduli_make: all that can share a factor do. */
sp_status sp_moduli_probe(const sp_network *net, double phi3s, int32_t count, const sp_probe *probe, sp_moduli *global,
                          sp_probed *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
