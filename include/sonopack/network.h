#ifndef SONOPACK_NETWORK_H
#define SONOPACK_NETWORK_H
/* The elastic network: springs between the grains that are not rattlers, and its stiffness matrix K. The equation of
 * motion is M u'' = -K u (Eq. (1) of Somfai et al. 2005), with all walls fixed. A cell without walls can be translated
 * as a whole: K then has dim zero modes of its own.
 *
 * With prestress, K is the full derivative of the contact forces, including the rotation of the forces at rest. The
 * normal forces add a symmetric part. Tangential forces add a part that is not symmetric and has no energy. */

#include <sonopack/packing.h>
#include <sonopack/sparse.h>
#include <sonopack/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Tangential stiffness of a spring, with q = |F_t|/(mu F_n) at rest (Mindlin and Deresiewicz 1953; docs/physics.md,
 * Loading history). A motion that goes back and forth feels that of CONSTANT in the limit of small amplitudes, since
 * the stick is full after each reversal. LOADING is felt by motion that goes on along F_t of a first loading. LOWEST is
 * the least that any history leaves, for either sense. In 3D the factors count along F_t and across, where the theory
 * has full stick: the networks are then too soft, and still bounds. */
typedef enum sp_springs {
    SP_SPRINGS_CONSTANT = 0, /* k_t of full stick, as in the paper */
    SP_SPRINGS_LOADING,      /* (1 - q)^(1/3) of it */
    SP_SPRINGS_LOWEST        /* ((1 - q)/2)^(1/3) of it */
} sp_springs;

typedef struct sp_network_options {
    double threshold;      /* contacts with fn > threshold x p d^2 carry force; 1e-4 */
    bool prestress;        /* include the rotation of the forces at rest; false as in the paper */
    bool sliding_free;     /* k_t = 0 at contacts within 1% of the Coulomb limit; false as in the paper */
    sp_springs tangential; /* CONSTANT as in the paper; the others refuse packings with stiffnesses of their own */
} sp_network_options;
SP_API sp_network_options sp_network_options_default(void);

/* A spring. The relative displacement at the contact point is B u = (u_j - u_i) - (rotations times lever arms). */
typedef struct sp_spring {
    int32_t i, j;    /* grain of the network (0 .. n-1); another, or a wall, SP_BOTTOM .. SP_BACK (fixed) */
    int32_t contact; /* its index in the packing */
    double n[3];     /* unit normal from i to j */
    double kn, kt;   /* normal stiffness; tangential stiffness [E* d] */
    double kp;       /* transverse stiffness of the prestress, -F_n x sp_carried.turn, 0 without prestress [E* d] */
    double ri, rj;   /* lever arms: the radii; rj = 0 for a rigid wall [d] */
} sp_spring;

/* The tangential force of a spring at rest. It rotates with the contact: the normal turns by the transverse
 * displacement over r, and in 3D the force also turns about the normal by half the sum of the grains' rotations. */
typedef struct sp_carried {
    double ft[3]; /* force on i [E* d^2] */
    double turn;  /* 1/r; 0 at a flat wall, whose normal is fixed; 1/r at an inner ring, -1/r at an outer one, with the
                     distance r from its centre [1/d] */
} sp_carried;

/* A network. Degrees of freedom per grain: 1 in 1D; 3 in 2D (x, y, angle), or 2 without friction; 6 in 3D, or 3.
 * Translations come first, then rotations. Vectors over the network are [n][dof]. */
typedef struct sp_network {
    int dim, dof;  /* dimension; degrees of freedom of a grain */
    int32_t n;     /* force-carrying grains */
    int32_t n_all; /* grains of the packing */
    int32_t rattlers;
    int32_t n_springs;
    int32_t *grain;     /* [n] index in the packing */
    double *mass;       /* [n][dof] masses [rho d^3], then moments of inertia */
    double *x;          /* [n][3] centres [d] */
    double *r;          /* [n] radii [d] */
    sp_spring *springs; /* [n_springs] those between grains first */
    double box[3];
    double pressure;     /* of the packing [E*] */
    int32_t n_bulk;      /* springs 0 .. n_bulk-1 join two grains, the others a grain and a wall */
    double *length;      /* [n_springs] distance of the centres, or of centre and wall [d] */
    bool prestress;      /* whether some kp is not 0 */
    double omega_bound;  /* result of sp_network_omega_bound */
    sp_carried *carried; /* [n_springs], or NULL if K is symmetric (no prestress, or no tangential forces at rest) */
    double skew;         /* result of sp_network_skew */
    double soft;         /* result of sp_network_soft */
    sp_cell cell;        /* what bounds the grains of the packing */
    double tilt[3];      /* as in sp_packing [d] */
} sp_network;

SP_API sp_network sp_network_none(void);
/* Builds the network of a packing. SP_EREFUSED if no grain carries force, SP_ENOMEM. */
SP_API sp_status sp_network_make(const sp_packing *p, const sp_network_options *opt, sp_network *out, sp_error *err);
SP_API void sp_network_free(sp_network *net);
SP_API int64_t sp_network_dofs(const sp_network *net); /* n x dof */

/* out = K u. Arrays are [n][dof] and must not overlap. Allocates nothing and cannot fail. */
SP_API void sp_network_apply(const sp_network *net, const double *u, double *out);
/* out = K^T u; the same as sp_network_apply if K is symmetric. */
SP_API void sp_network_apply_transposed(const sp_network *net, const double *u, double *out);
/* u^T K u as a sum over springs of squares (with prestress: of squares with either sign). This is accurate for soft
 * modes, for which u . (K u) is not. */
SP_API double sp_network_energy2(const sp_network *net, const double *u);
/* Upper bound of the largest eigenfrequency, typically a few percent above it (Collatz-Wielandt, from row sums). If K
 * is not symmetric: of its symmetric part. */
SP_API double sp_network_omega_bound(const sp_network *net);
/* Bounds for A = M^-1/2 K M^-1/2. skew: norm of (A - A^T)/2, exactly 0 if K is symmetric. soft: how far eigenvalues of
 * (A + A^T)/2 may lie below 0, exactly 0 without prestress. The numerical range of A, and so its eigenvalues omega^2,
 * lies within real parts -soft .. omega_bound^2 and imaginary parts -skew .. skew. */
SP_API double sp_network_skew(const sp_network *net);
SP_API double sp_network_soft(const sp_network *net);
/* SP_EREFUSED if K is not symmetric. `what` names the method that needs symmetry, such as "the dense method". */
SP_API sp_status sp_network_need_symmetry(const sp_network *net, const char *what, sp_error *err);

typedef enum sp_source {
    SP_SOURCE_IMPULSE = 0, /* momentum of each bottom grain = k_n of its wall contact, along the normal */
    SP_SOURCE_VELOCITY,    /* velocity = k_n, as the paper states literally */
    SP_SOURCE_DISPLACEMENT /* displacement = k_n: initial condition B */
} sp_source;

/* Location of a source or detector. */
typedef enum sp_place_kind {
    SP_PLACE_WALL = 0, /* the bottom wall for a source, the top wall for a detector */
    SP_PLACE_PART,     /* part of that wall: grains with centres in from <= x < to */
    SP_PLACE_GRAIN,    /* one grain: its share of what WALL would give. A grain without a contact to that wall gets unit
                          momentum, velocity or displacement, and is detected by the net force on it. */
    SP_PLACE_PLANE, /* of a ring a circle. detector: momentum flux through a horizontal plane, the force of all grains
                       centred below it on those above. In a periodic cell this is the plane in the cell, which its
                       images cross again at every period. Source: each grain whose centre is at most half a mean
                       diameter (0.5 d) below the plane, or less than that above it, gets unit momentum, velocity or
                       displacement */
    SP_PLACE_DISC   /* in 3D a circle of that wall: grains with centres within diameter/2 of (x, y), across periods */
} sp_place_kind;
typedef struct sp_place {
    sp_place_kind kind;
    bool shear;      /* along x; false: along the up axis (of a wall: along its normals; in a ring: along the radius) */
    double from, to; /* of PART [d] */
    double height;   /* of PLANE [d] */
    int32_t grain;   /* of GRAIN: index in the packing */
    double x, y, diameter; /* of DISC [d] */
} sp_place;
SP_API sp_place sp_place_wall(void); /* The whole wall, along its normal. */
/* Reads a place as the command writes it: bottom or inner (source), top or outer (detector), part:X0:X1,
 * disc:X:Y:DIAMETER, plane:Y or grain:I, optionally followed by :normal or :shear; a component alone stands for the
 * whole wall. *component, or NULL: whether the text names one. SP_EINVAL for any other text. */
SP_API sp_status sp_place_read(const char *text, bool source, sp_place *out, bool *component, sp_error *err);
enum { SP_PLACE_TEXT = 100 };
/* The place as sp_place_read reads it, with its component. Returns text. */
SP_API char *sp_place_text(const sp_place *at, bool source, char text[SP_PLACE_TEXT]);

/* Whether any spring leads to the wall, SP_BOTTOM or SP_TOP. Without, the wall is no source and no detector. */
SP_API bool sp_network_touches(const sp_network *net, int32_t wall);

/* Source vector [n][dof]: momenta (impulse, velocity) or displacements. Detector row [n][dof]: the force on the wall is
 * det . u. At a wall every contact acts along its own normal (shear: across it), so that a packing that is turned as a
 * whole has the same signal; between level walls this is the up axis (x). SP_EINVAL for an invalid place, SP_EREFUSED
 * for a wall or part of it in a cell without walls, for a place without springs or grains, and for one that the axes of
 * the box describe (a plane, a part, a grain that touches no wall, shear in 3D) where a wall is inclined to them. */
SP_API sp_status sp_network_source_at(const sp_network *net, sp_source source, const sp_place *at, double *out,
                                      sp_error *err);
SP_API sp_status sp_network_detector_at(const sp_network *net, const sp_place *at, double *out, sp_error *err);
/* Height of the contacts that carry the flux through a plane: the mean height of their midpoints, weighted with their
 * force under a uniform vertical strain. Between two rows of a lattice it is half way, wherever the plane lies. NAN if
 * nothing crosses the plane. */
SP_API double sp_network_plane_height(const sp_network *net, double height);
/* Source and detector for the whole walls along their normals. */
SP_API sp_status sp_network_source(const sp_network *net, sp_source source, double *out, sp_error *err);
SP_API sp_status sp_network_detector(const sp_network *net, double *out, sp_error *err);

/* How the dashpot of a contact follows from its spring and its grains. 1/m_eff = 1/m_i + 1/m_j; at a wall it is the
 * grain's mass. c_n acts on the relative velocity along the normal. c_t acts on the rest of it at the contact point,
 * with the rotations; in a network without rotations on that of the centres (zeta: not at all). */
typedef enum sp_damping_kind {
    SP_DAMPING_ZETA =
        0,            /* a fraction of critical damping: c_n = 2 value sqrt(m_eff k_n), c_t = 2 value sqrt(m_eff k_t) */
    SP_DAMPING_GAMMA, /* the same at all contacts: c_n = value [E* d^2/sqrt(E* / rho)], c_t = ratio c_n */
    SP_DAMPING_MASS   /* in proportion to mass: c_n = value m_eff, value in [sqrt(E* / rho)/d], c_t = ratio c_n */
} sp_damping_kind;
typedef struct sp_damping {
    sp_damping_kind kind;
    double value;
    double ratio; /* c_t/c_n of GAMMA and MASS */
} sp_damping;
/* Reads "0.1" (ZETA), "gamma:0.1", "mass:0.1", and "gamma:0.1:0.05", "mass:0.1:0.05" with a tangential value of its
 * own. Without it ratio is 1. SP_EINVAL. */
SP_API sp_status sp_damping_read(const char *text, sp_damping *out, sp_error *err);
/* Network of the contacts' dashpots: its K is the damping matrix C of M u'' + C u' + K u = 0. value > 0, ratio >= 0.
 * SP_EINVAL, SP_ENOMEM. */
SP_API sp_status sp_network_dashpots(const sp_network *net, const sp_damping *law, sp_network *out, sp_error *err);
/* The same of kind ZETA. */
SP_API sp_status sp_network_damping(const sp_network *net, double zeta, sp_network *out, sp_error *err);

/* Assembles K: the lower triangle of its symmetric part, diagonal first; or the whole matrix. SP_ENOMEM. */
SP_API sp_status sp_network_assemble(const sp_network *net, sp_sparse *out, sp_error *err);
SP_API sp_status sp_network_assemble_whole(const sp_network *net, sp_sparse *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
