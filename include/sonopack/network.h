#ifndef SONOPACK_NETWORK_H
#define SONOPACK_NETWORK_H
/* The network that carries sound: springs between the grains that are not rattlers, and K as an operator and as a
 * sparse matrix. M u'' = -K u (Eq. (1) of Somfai et al. 2005) with both walls fixed.
 *
 * With prestress K is J, the derivative of the contact forces with all that the forces at rest add to it. Forces along
 * the normals add a symmetric part. Tangential forces add one that is not symmetric: no energy belongs to it. */

#include <sonopack/packing.h>
#include <sonopack/sparse.h>
#include <sonopack/status.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sp_network_options {
    double threshold;  /* contacts with fn > threshold x p (x d^2) carry; 1e-4 */
    bool prestress;    /* add what the forces at rest do as contacts turn; false as in the paper */
    bool sliding_free; /* k_t = 0 on contacts at the Coulomb limit (within 1%); false as in the paper */
} sp_network_options;
SP_API sp_network_options sp_network_options_default(void);

/* One spring. The relative displacement at the contact point is B u = (u_j - u_i) - (rotations with lever arms). */
typedef struct sp_spring {
    int32_t i, j;    /* grains of the network (0 .. n-1); j may be SP_BOTTOM or SP_TOP (fixed) */
    int32_t contact; /* its row in the packing */
    double n[3];     /* unit normal from i to j */
    double kn, kt;   /* stiffnesses [E* d] */
    double kp;       /* -F_n / r, transverse stiffness of the prestress; 0 if not asked for */
    double ri, rj;   /* lever arms: radii; rj = 0 for a rigid wall [d] */
} sp_spring;

/* The tangential force of a spring at rest, and how it turns. It is laid across the new normal, whose change is the
 * transverse displacement times 1/r, and in three dimensions it turns about the normal by half the sum of the grains'
 * rotations. */
typedef struct sp_carried {
    double ft[3]; /* on i [E* d^2] */
    double turn;  /* 1/r; 0 at a wall, whose normal is fixed [1/d] */
} sp_carried;

/* Degrees of freedom a grain: 1D 1; 2D 3 (x, y, angle) or 2 without friction; 3D 6 or 3. Order: translations, then
 * rotations. Vectors over the network are [n][dof]. */
typedef struct sp_network {
    int dim, dof;
    int32_t n;     /* grains that carry */
    int32_t n_all; /* grains of the packing */
    int32_t rattlers;
    int32_t n_springs;
    int32_t *grain; /* [n] index in the packing */
    double *mass;   /* [n][dof] masses, then moments of inertia */
    double *x;      /* [n][3] centres */
    double *r;      /* [n] radii */
    sp_spring *springs;
    double box[3];
    double pressure;
    int32_t n_bulk;      /* springs between grains come first: rows 0 .. n_bulk-1; those of walls follow */
    double *length;      /* [n_springs] from centre i to centre j, or to the wall [d] */
    bool prestress;      /* some kp is not 0 */
    double omega_bound;  /* what sp_network_omega_bound returns */
    sp_carried *carried; /* [n_springs]; NULL: K is symmetric (no prestress, or no tangential forces at rest) */
    double skew;         /* what sp_network_skew returns */
    double soft;         /* what sp_network_soft returns */
} sp_network;

SP_API sp_network sp_network_none(void);
/* SP_EREFUSED when no grain carries. */
SP_API sp_status sp_network_make(const sp_packing *p, const sp_network_options *opt, sp_network *out, sp_error *err);
SP_API void sp_network_free(sp_network *net);
SP_API int64_t sp_network_dofs(const sp_network *net); /* n x dof */

/* out = K u, [n][dof] each, must not overlap. Allocates nothing, cannot fail. */
SP_API void sp_network_apply(const sp_network *net, const double *u, double *out);
/* out = K^T u: the same where K is symmetric. */
SP_API void sp_network_apply_transposed(const sp_network *net, const double *u, double *out);
/* u^T K u as a sum of squares over springs (prestress: of signed squares): accurate for soft modes where u . (K u) is
 * not. */
SP_API double sp_network_energy2(const sp_network *net, const double *u);
/* An upper bound of the largest eigenfrequency, a few percent above it (Collatz and Wielandt, from row sums). Where K
 * is not symmetric: of that of its symmetric part. */
SP_API double sp_network_omega_bound(const sp_network *net);
/* With A = M^-1/2 K M^-1/2: bounds of |A - A^T|/2, exactly 0 where K is symmetric, and of how far the eigenvalues of
 * (A + A^T)/2 may lie below 0, exactly 0 without prestress. All values of A, x^T A x for complex x of length 1, lie in
 * the rectangle from -soft to omega_bound^2 and from -i skew to i skew, and so do its eigenvalues omega^2. */
SP_API double sp_network_skew(const sp_network *net);
SP_API double sp_network_soft(const sp_network *net);
/* SP_EREFUSED for a K that is not symmetric, with a message that says so, for `what` ("the dense method") that needs
 * it. */
SP_API sp_status sp_network_need_symmetry(const sp_network *net, const char *what, sp_error *err);

typedef enum sp_source {
    SP_SOURCE_IMPULSE = 0, /* momentum of each bottom grain = k_n of its wall contact (times the normal) */
    SP_SOURCE_VELOCITY,    /* velocity = k_n, literally as in the paper */
    SP_SOURCE_DISPLACEMENT /* displacement = k_n: initial condition B */
} sp_source;

/* Where a source acts or a detector listens. */
typedef enum sp_place_kind {
    SP_PLACE_WALL = 0, /* the bottom wall of a source, the top wall of a detector */
    SP_PLACE_PART,     /* a part of that wall: the grains whose centres lie in from <= x < to */
    SP_PLACE_GRAIN, /* one grain: what its contact with that wall is to the whole wall; a grain without such a contact
                       is given a unit of momentum, velocity or displacement, and felt by the net force on it */
    SP_PLACE_PLANE  /* detectors only: momentum flux through a horizontal plane, the force of all that lies below
                       (by centres) on what lies above */
} sp_place_kind;
typedef struct sp_place {
    sp_place_kind kind;
    bool shear;      /* along x; false: normal, along up */
    double from, to; /* part [d] */
    double height;   /* plane [d] */
    int32_t grain;   /* index in the packing */
} sp_place;
SP_API sp_place sp_place_wall(void); /* the whole wall, normal */

/* Source as a vector [n][dof] of momenta (impulse, velocity) or displacements; detector as a row: F_sig = det . u, the
 * force on the wall, along up (or x). SP_EINVAL for a place that is none, SP_EREFUSED for one without springs. */
SP_API sp_status sp_network_source_at(const sp_network *net, sp_source source, const sp_place *at, double *out,
                                      sp_error *err);
SP_API sp_status sp_network_detector_at(const sp_network *net, const sp_place *at, double *out, sp_error *err);
/* Where the flux through the plane at `height` is carried: the mean height of the middles of the contacts that cross
 * it, each with its force under an even vertical strain as its weight. Between two rows of a lattice it is half way,
 * wherever the plane lies. NAN where nothing crosses it. */
SP_API double sp_network_plane_height(const sp_network *net, double height);
/* The same for the whole walls, normal. */
SP_API sp_status sp_network_source(const sp_network *net, sp_source source, double *out, sp_error *err);
SP_API sp_status sp_network_detector(const sp_network *net, double *out, sp_error *err);

/* The dashpots of the contacts as a network of their own, whose K is the damping matrix C of M u'' + C u' + K u = 0: a
 * fraction zeta > 0 of critical damping, c = 2 zeta sqrt(m_eff k) for k = k_n and k_t, 1/m_eff = 1/m_i + 1/m_j (at a
 * wall the grain's mass). */
SP_API sp_status sp_network_damping(const sp_network *net, double zeta, sp_network *out, sp_error *err);

/* K assembled: the lower triangle of its symmetric part, diagonal first; or all of it. */
SP_API sp_status sp_network_assemble(const sp_network *net, sp_sparse *out, sp_error *err);
SP_API sp_status sp_network_assemble_whole(const sp_network *net, sp_sparse *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
