#ifndef SONOPACK_ELASTIC_H
#define SONOPACK_ELASTIC_H
/* Elastic moduli from imposed strain (Somfai et al. 2005, Eqs. (7), (8), Table II), from the probes of its Appendix B
 * (Tables IV and V), and at finite strain. */

#include <sonopack/network.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Axes as in the paper; without walls read "along the up axis" for "from wall to wall". In 2D, 1 is along the walls and
 * 2 from wall to wall; C33 is the shear modulus. In 3D, 1 and 2 are along the walls and 3 from wall to wall; C33 is the
 * longitudinal modulus from wall to wall, and C44 (23), C55 (13), C66 (12) are the shear moduli in Voigt's notation. */
typedef struct sp_moduli {
    double c11, c12, c22,
        c33; /* C11; C12; C22; C33, in 2D the shear modulus, in 3D the longitudinal one. NAN where not computed [E*] */
    double c13, c23, c44, c55, c66; /* C13; C23; C44; C55; C66. NAN in 2D [E*] */
    double c_l,
        c_t; /* speed of longitudinal waves from wall to wall, Eq. (8): in 2D sqrt(C22/Phi3*), in 3D sqrt(C33/Phi3*);
                speed of transverse waves: in 2D sqrt(C33/Phi3*), in 3D sqrt((C44 + C55)/(2 Phi3*)) [sqrt(E* / rho)] */
    double residual; /* largest |K u - f|/|f| of the solves; forces on free spins (sp_moduli_make) count a thousandth */
    double bulk, shear; /* K and G of the whole tensor, as in sp_elasticity; NAN in 1D and where parts of it are [E*] */
    double error11, error12, error22, error33, error13, error23, error44, error55,
        error66;                    /* bound of the error of the modulus of these indices [E*] */
    double error_bulk, error_shear; /* of K; of G [E*] */
} sp_moduli;

/* Moduli of the linear springs. One sparse Cholesky factorization serves all strains. Strains along the walls act
 * through the periodic images, all others by displacing the top wall. Without walls all strains act
 * through the periodic images; between walls on all sides, all walls take part. The walls' contact points follow the
 * strain affinely, so C12 = C21. phi3s: sp_packing_density, which is Phi3* of sp_statics for spheres of unit density;
 * NAN: no speeds. Floppy parts carry no stress and do no harm. With prestress and friction the free spin of a sphere
 * with two contacts is left out, and a turn of 1 is part of the errors. A modulus C11 .. C66 on the diagonal is set to
 * 0 if it is within its error of 0. With prestress it may be negative: the grains resist every displacement, but the
 * packing gives way to the strain; a speed that needs it is NAN. Shear moduli under a piston are NAN if the walls have
 * no friction. SP_EREFUSED for a piston or box without contacts at the walls, if no chain of springs connects the
 * walls, if the network as a whole is floppy or unstable, and if a strain does work on a motion that nothing resists
 * (only with prestress): the moduli do not exist then, and the reason names grains that move. */
SP_API sp_status sp_moduli_make(const sp_network *net, double phi3s, sp_moduli *out, sp_error *err);

enum { SP_STRAINS_MAX = 6 };

/* The whole stiffness tensor in Voigt's notation: strains and stresses 11, 22, 12 in 2D, and 11, 22, 33, 23, 13, 12 in
 * 3D; a shear strain is 2 e_12 = du_1/dx_2. The last axis is the up axis; a chain has one strain. c is symmetric to
 * rounding if K is. With prestress, c is the second derivative of the energy by the displacement gradients, over the
 * volume. bulk is -V dp/dV; then it is (dim - 1)/dim p more than the average of c, because areas change, too. */
typedef struct sp_elasticity {
    int strains;                              /* 1, 3 or 6 */
    double c[SP_STRAINS_MAX][SP_STRAINS_MAX]; /* stress a due to strain b [E*]; NAN where undefined, as in sp_moduli */
    double error[SP_STRAINS_MAX][SP_STRAINS_MAX]; /* bounds of the errors of c [E*] */
    double bulk, bulk_error;   /* bulk modulus K, Voigt's average: that of the tensor over all directions; bound of its
                                  error [E*] */
    double shear, shear_error; /* the same for the shear modulus G; bound of its error [E*] */
    double anisotropy,
        anisotropy_error; /* |c - isotropic part| over |c|, as norms of tensors, 0 if isotropic; bound of its error */
    double residual;      /* largest |K u - f|/|f| of the solves */
} sp_elasticity;

/* The whole tensor by the strains of sp_moduli_make. moduli: the same with its names, as from sp_moduli_make; may be
 * NULL. bulk, shear and anisotropy are NAN in 1D, and where parts of c are. Fails as sp_moduli_make does. */
SP_API sp_status sp_elasticity_make(const sp_network *net, double phi3s, sp_moduli *moduli, sp_elasticity *out,
                                    sp_error *err);

typedef enum sp_probe_kind {
    SP_PROBE_SINE = 0, /* body force f0 sin(n pi y/L), walls fixed; Eqs. (B1), (B2) */
    SP_PROBE_LINES     /* grains on the lines y = k L/(n + 1) displaced alternately, n odd; Eq. (B3) */
} sp_probe_kind;
typedef struct sp_probe {
    sp_probe_kind kind;
    int32_t n; /* half waves or lines, >= 1 */
} sp_probe;
/* Apparent moduli of one probe, from its elastic energy [E*]. */
typedef struct sp_probe_moduli {
    double along; /* motion from wall to wall: C22, in 3D C33 [E*] */
    double shear; /* motion along x: C33, in 3D C55. NAN for chains, for lines between walls without friction, and for
                     the sine if only one wall has friction [E*] */
    double error_along, error_shear; /* bound of the error of `along`; of `shear` [E*] */
    double left_out; /* sine: part of the body force, as sum f^2/m, that acts on floppy motions and is therefore left
                        out; the larger of both directions, 0 without floppy motions */
    double concentrated; /* sine: largest part of the energy in a single grain. About 1/grains as a rule; near 1 the
                            moduli are those of the contacts of one loose grain */
    int32_t grain;       /* that grain, index in the packing */
} sp_probe_moduli;
/* Probes on smaller scales. out [count]: results of probe [count]. global: if not NULL, as from sp_moduli_make; the
 * probes share its factorization where possible. Grains on a line take the displacement of the continuum at their
 * centres; their rotations are free. The lines at the walls are the walls. Walls without friction are sheared by cos(n
 * pi y/L) in place of the sine, which has the same energy (B2). SP_EINVAL for an invalid n. SP_EREFUSED for a probe
 * finer than the grains, for a sine without phi3s, for cells other than the piston's, and as sp_moduli_make. */
SP_API sp_status sp_moduli_probe(const sp_network *net, double phi3s, int32_t count, const sp_probe *probe,
                                 sp_moduli *global, sp_probe_moduli *out, sp_error *err);

/* ---- moduli of parts of a packing -------------------------------------------------------------------------------- */

/* Local moduli (Mizuno, Mossa and Barrat, Phys. Rev. E 87, 042306, 2013): local changes of the stress for a strain of
 * the whole. Equal parallelepipeds, squares or cubes in a cell with right angles, fill the cell; each contact belongs
 * to them by the lengths of its branch line, from centre to centre or wall, in them. The mean of c over the parts is c
 * of the whole. Not symmetric, since strains are those of the whole. */
typedef struct sp_local_moduli {
    int32_t n;        /* parts; that along x comes first */
    int strains;      /* 3 in 2D, 6 in 3D, in the order of sp_elasticity */
    double *x;        /* [n][3] centres of the parts [d] */
    double *c;        /* [n][strains][strains] stress a due to strain b; NAN where undefined, as in sp_moduli [E*] */
    double *bulk;     /* [n] K, as in sp_elasticity; with prestress all have the same term of the pressure [E*] */
    double *shear;    /* [n] G, the same [E*] */
    double *error;    /* [n] bound of the errors of c; with prestress an estimate of that [E*] */
    double *grains;   /* [n] grains of the network with their centre in the part */
    double *contacts; /* [n] contacts, by the parts of their branch lines */
    double *whole;    /* [strains][strains] c of the whole packing [E*] */
    double whole_bulk, whole_shear; /* K of the whole packing; G of the whole packing [E*] */
    double whole_error;             /* bound of the errors of `whole` [E*] */
    double edge_x, edge_y, edge_z;  /* edge of a part along x; along y; along z: the cell's over a number [d] */
} sp_local_moduli;
SP_API sp_local_moduli sp_local_moduli_none(void);
/* width: the edges are about this [d]. A part without a contact has moduli of 0. SP_EINVAL for a width below the mean
 * diameter, SP_EREFUSED for a chain, where prestress and friction leave the spin of a sphere free (sp_moduli_make),
 * and as sp_moduli_make. */
SP_API sp_status sp_local_moduli_make(const sp_network *net, double width, sp_local_moduli *out, sp_error *err);
SP_API void sp_local_moduli_free(sp_local_moduli *m);

/* ---- between two rings ------------------------------------------------------------------------------------------- */

/* Moduli of the elastic annulus, in the plane, that answers like a packing between two rings. The inner ring grows by a
 * small part of its radius a, and the outer one, of radius b, stays: by Lame's solution the pressures on them rise by
 * 2 (K + G b^2/a^2)/(b^2/a^2 - 1) and 2 (K + G)/(b^2/a^2 - 1) times this part. Or it turns by a small angle: its torque
 * is 4 pi a^2 d G/(1 - a^2/b^2) times the angle. Layers of grains at the rings take part, so that K and G differ from
 * those of the material by a part of about d/a and d/(b - a). */
typedef struct sp_ring_moduli {
    double p_inner, p_outer; /* pressure on the rings over the growth of the inner one [E*] */
    double torque;           /* over the angle; 0 if smooth grains or rings let it turn freely [E* d^3] */
    double bulk, shear;      /* K and G by the growth [E*] */
    double shear_turn;       /* G by the torque; NAN where nothing resists it [E*] */
    double error_bulk, error_shear, error_shear_turn; /* bounds [E*] */
    double residual;                                  /* largest relative residual of the solves */
} sp_ring_moduli;
/* One sparse factorization. SP_EREFUSED in other cells, and as sp_moduli_make. */
SP_API sp_status sp_ring_moduli_make(const sp_network *net, sp_ring_moduli *out, sp_error *err);

/* ---- response to a load ------------------------------------------------------------------------------------------ */

typedef enum sp_load_kind {
    SP_LOAD_FORCE = 0, /* a force of 1 on a grain, along an axis; where the packing can move as a whole, in a periodic
                          cell or between smooth walls, balanced by the opposite one, spread over all masses */
    SP_LOAD_DIPOLE,    /* two forces of 1 that push the ends of a spring apart, along its normal */
    SP_LOAD_SWELL,     /* a grain that grows: its radius by 1 of itself */
    SP_LOAD_STRAIN     /* an affine strain of 1, as of sp_moduli_make; u is what the grains add to it */
} sp_load_kind;

typedef struct sp_load {
    sp_load_kind kind;
    int32_t at;   /* grain of the network, or spring */
    int32_t axis; /* FORCE: 0 .. dim-1. STRAIN: 11, 22, 12; in 3D 11, 22, 33, 23, 13, 12 */
} sp_load;

/* Displacements of the grains between fixed walls, or in a fixed cell. Extension is positive, as in K. */
typedef struct sp_response {
    int64_t n, springs; /* degrees of freedom; contacts of the network */
    double *u; /* [n] displacements, rotations as in the network; where the packing can move as a whole its centre of
                  mass stays, between smooth rings its mean angle */
    double *fn,
        *ft; /* [springs] change of the normal force, positive in compression; size of the change of the tangential
                force. Of a strain with its affine part, of a dipole without the forces that are applied */
    double *force; /* [springs][3] change of the force on i, of which these are parts */
    double work;   /* half of the load times u: of a strain the nonaffine part of - C V/2 */
    double error;  /* u is exact for a load that differs by this part of it: residual and rounding */
} sp_response;
SP_API sp_response sp_response_none(void);
/* One sparse factorization. SP_EINVAL for a load that does not exist. SP_EREFUSED if K is not symmetric, if the load
 * moves what no spring holds, and as sp_moduli_make. */
SP_API sp_status sp_response_make(const sp_network *net, const sp_load *load, sp_response *out, sp_error *err);
SP_API void sp_response_free(sp_response *r);

/* The amplitude of the load nearest to 0, of either sign, at which the normal force of a spring is 0, and at which its
 * forces are at Coulomb's limit |Ft + e dFt| = mu (Fn + e dFn), if it kept responding as it does; INFINITY: none, as of
 * slides without friction. A contact at the limit slides at 0. p: the packing of the network. */
SP_API void sp_response_limits(const sp_packing *p, const sp_network *net, const sp_response *r, int32_t spring,
                               double *opens, double *slides);

/* ---- finite strain ---------------------------------------------------------------------------------------------- */

typedef struct sp_finite_strain_options {
    double strain; /* imposed strain of Eq. (7), positive: compression; 1e-6. Each contact follows it along a straight
                      path */
    bool turning; /* contact normals and forces rotate with the contacts. false: they stay fixed, as for springs without
                     prestress, so that small strains give the moduli of sp_moduli_make; true */
} sp_finite_strain_options;
SP_API sp_finite_strain_options sp_finite_strain_options_default(void);

/* Moduli at finite strain: changes of the nominal stress over the strain. */
typedef struct sp_finite_strain {
    sp_moduli moduli;            /* its errors are NAN, and the speeds without phi3s */
    int32_t sliding, lost, made; /* contacts that slide; that open; that close: each the maximum over all strains */
    int32_t solves, factors;     /* linear systems solved; factorizations */
    double residual;             /* largest |residual force| over the forces of the affine strain */
} sp_finite_strain;

/* Strains the packing with its full contact law (Hertz, incremental friction, Coulomb's limit, contacts that open and
 * close) and finds the new equilibrium by Newton's method. net: the network of this packing; its springs are the
 * contacts at rest, and rattlers are excluded. SP_EREFUSED if the residual does not fall below 1e-6, which happens
 * where the packing yields, and as sp_moduli_make. */
SP_API sp_status sp_moduli_finite_strain(const sp_packing *p, const sp_network *net, double phi3s,
                                         const sp_finite_strain_options *opt, sp_finite_strain *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
