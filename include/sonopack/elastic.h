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
    double c11, c12, c22, c33;      /* [E*]; NAN where not computed */
    double c13, c23, c44, c55, c66; /* 3D [E*]; NAN in 2D */
    double c_l, c_t;                /* of waves from wall to wall, Eq. (8) [sqrt(E* / rho)]: sqrt(C22/Phi3*),
                                       sqrt(C33/Phi3*); 3D sqrt(C33/Phi3*), sqrt((C44+C55)/(2 Phi3*)) */
    double residual;                /* largest relative residual |K u - f| / |f| of the solves */
    double error11, error12, error22, error33, error13, error23, error44, error55,
        error66; /* bounds of the errors of C11 .. C66, for these springs [E*] */
} sp_moduli;

/* Sparse Cholesky, one factorisation for all strains: along the periodic axes and in their plane through the periodic
 * images, all others by the top wall. The walls' contact points are strained affinely too, so C12 = C21. phi3s: Phi3*
 * of sp_statics; without it (NAN) no speeds. Floppy parts carry nothing and do no harm; C11 .. C66 on
 * the diagonal are 0 where they are within their error of it. Shear by walls that do not grip (no friction) is NAN.
 * SP_EREFUSED for a packing without walls, one where no springs lead from wall to wall, and one that is floppy as a
 * whole. */
SP_API sp_status sp_moduli_make(const sp_network *net, double phi3s, sp_moduli *out, sp_error *err);

typedef enum sp_probe_kind {
    SP_PROBE_SINE = 0, /* body force f0 sin(n pi y / L), walls fixed: Eqs. (B1), (B2) */
    SP_PROBE_LINES     /* grains on the lines y = k L / (n + 1) displaced by turns, n odd: Eq. (B3) */
} sp_probe_kind;
typedef struct sp_probe {
    sp_probe_kind kind;
    int32_t n; /* >= 1 */
} sp_probe;
/* Apparent moduli from the elastic energy [E*]. */
typedef struct sp_probe_moduli {
    double along; /* of motion from wall to wall: C22, 3D C33 */
    double shear; /* of motion along x: C33, 3D C55; NAN for chains, of lines between walls that do not grip, and of the
                     sine where one wall alone grips */
    double error_along, error_shear; /* bounds of their errors, for these springs */
    double left_out;                 /* sine: the larger share of the body force, as sum f^2/m, that acts on motions
                                        of floppy parts that no spring resists, which is left out; 0 where there are none */
    double concentrated; /* sine: the largest share of one grain in the energy; some 1/grains, near 1 for a grain that
                            hangs loose, and the moduli are then those of its contacts */
    int32_t grain;       /* that grain, index in the packing */
} sp_probe_moduli;
/* out[count] of the probes; *global, if not NULL, as from sp_moduli_make: all that can share a factor do. Grains on a
 * line are displaced as the continuum is at their centres, their rotations are free; the lines at the walls are the
 * walls. Walls that do not grip are sheared by cos(n pi y/L) in place of the sine: it has the same energy (B2) between
 * walls that feel no shear. SP_EINVAL for an n that is none (lines: even), SP_EREFUSED for one finer than the grains, a
 * sine without phi3s, and as above. */
SP_API sp_status sp_moduli_probe(const sp_network *net, double phi3s, int32_t count, const sp_probe *probe,
                                 sp_moduli *global, sp_probe_moduli *out, sp_error *err);

/* ---- finite strain ---------------------------------------------------------------------------------------------- */

typedef struct sp_finite_strain_options {
    double strain; /* one of (7): positive shrinks; 1e-6. Contacts follow it in one stroke. */
    bool turning;  /* contact normals turn, and their forces with them; false: they stay, as springs without prestress
                      have it, so that a strain of nothing gives the moduli of sp_moduli_make; true */
} sp_finite_strain_options;
SP_API sp_finite_strain_options sp_finite_strain_options_default(void);

/* Changes of the nominal stress (forces and areas at rest) over the strain. */
typedef struct sp_finite_strain {
    sp_moduli moduli;            /* NAN: errors; c_l and c_t without phi3s */
    int32_t sliding, lost, made; /* contacts that slide, open, and close: the most under any of the strains */
    int32_t solves, factors;
    double residual; /* largest |force on the grains| left over that of the homogeneous strain */
} sp_finite_strain;

/* The packing with its full contact law (Hertz, incremental friction, Coulomb's limit, contacts that open and close)
 * strained and brought to equilibrium again, by Newton steps with the factor of K, made anew where contacts have
 * changed too much. net: of this packing; its springs are the contacts at rest, rattlers stay out. SP_EREFUSED where
 * the residual does not fall below 1e-6, as where the packing yields, and as sp_moduli_make. */
SP_API sp_status sp_moduli_finite_strain(const sp_packing *p, const sp_network *net, double phi3s,
                                         const sp_finite_strain_options *opt, sp_finite_strain *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
