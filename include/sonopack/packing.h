#ifndef SONOPACK_PACKING_H
#define SONOPACK_PACKING_H
/* A packing: grains at rest under pressure, and the contacts that hold them.
 *
 * Units: length = mean grain diameter d, pressure = E* (modified Young modulus E/(1-nu^2) of one grain),
 * mass = grain material has unit density; hence force E* d^2 and time d / sqrt(E* / rho).
 * Grains are spheres in any dimension. The up axis (between the walls) is dim-1: x in 1D, y in 2D, z in 3D;
 * the other axes are periodic. The bottom wall is at 0, the top wall at the height. */

#include <sonopack/status.h>
#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { SP_BOTTOM = -1, SP_TOP = -2 }; /* contact partners that are walls */

/* One contact, i < j for two grains. In 2D ft = Ft (-ny, nx) with Ft the scalar of the text files. */
typedef struct sp_contact {
    int32_t i, j;   /* grains from 0; j may be SP_BOTTOM or SP_TOP */
    double n[3];    /* unit normal, from i to j */
    double overlap; /* R_i + R_j - r_ij, or R_i - distance to the wall [d] */
    double fn;      /* normal elastic force, >= 0 in compression [E* d^2] */
    double ft[3];   /* tangential elastic force on i [E* d^2] */
} sp_contact;

/* How walls answer a grain: rigid plane (Hertz with R = inf, E* of one grain), or as if the wall
 * were a fixed grain like its neighbour ("identical springs" of the 1D chain, Somfai et al. 2005, App. C). */
typedef enum sp_wall { SP_WALL_RIGID = 0, SP_WALL_GRAIN = 1 } sp_wall;

typedef struct sp_packing {
    int dim;   /* 1, 2 or 3 */
    int32_t n; /* grains */
    int32_t n_contacts;
    double *x; /* [n][3] centres, unused axes 0 [d] */
    double *r; /* [n] radii [d] */
    sp_contact
        *contacts;   /* [n_contacts], in order: pairs by (i, j), then the bottom wall's by i, then the top wall's */
    double box[3];   /* periods; box[dim-1] is the height; unused axes 1 [d] */
    double pressure; /* force on a wall over its area (2D: width x d; 1D: d^2) [E*] */
    double friction; /* Coulomb's mu; 0: no tangential springs, no rotations */
    double poisson;  /* nu of the grain material */
    sp_wall wall;
    /* how it was made; 0, NAN or NULL where unknown (imported packings) */
    uint64_t seed;
    int64_t steps;   /* time steps of the compression */
    double residual; /* largest elastic acceleration (angular: times R) at the end [E* / (rho d)] */
    double seconds;  /* CPU time that the making took; in no file, for equal packings make equal files */
    char *scene;     /* text of the scene with every value, as sp_scene_text gives it; may be NULL */
} sp_packing;

/* An empty packing, safe to free. */
sp_packing sp_packing_none(void);
/* Arrays for n grains and n_contacts contacts, zeroed. */
sp_status sp_packing_alloc(sp_packing *p, int dim, int32_t n, int32_t n_contacts, sp_error *err);
void sp_packing_free(sp_packing *p);

/* Puts the contacts into their order. */
void sp_packing_sort(sp_packing *p);

/* Area of a wall [d^2], and height between walls [d]. */
double sp_packing_wall_area(const sp_packing *p);
double sp_packing_height(const sp_packing *p);

/* What an audit found (sp_packing_audit). Relative measures, 0 for a perfect packing. */
typedef struct sp_audit {
    double force_residual;    /* largest |sum of contact forces| on a grain of the network over p x (mean diameter)^2 */
    double torque_residual;   /* largest |torque|/R likewise */
    double wall_residual;     /* largest | |F_wall| / (p A) - 1 | of the two walls */
    double law_residual;      /* largest relative difference between fn and Hertz's law at the stored overlap, above
                                 rounding of a text file */
    double geometry_residual; /* largest |overlap - overlap from the positions| over the largest overlap */
    double coulomb_excess;    /* largest |ft|/(mu fn) - 1, 0 if none is above */
    int32_t missing;          /* pairs that overlap but are not listed as contacts */
    int32_t carrying;         /* force-carrying contacts of the network */
    int32_t rattlers;
} sp_audit;

/* Structure only: sizes, indices, finite numbers, unit normals, radii > 0, grains in the box, sorted, no double
 * contact. Run on everything that comes from a file. SP_EFORMAT with the first fault. */
sp_status sp_packing_check(const sp_packing *p, sp_error *err);

/* Physics: force and torque balance of the grains that carry (threshold: fraction of p x d^2 above which a contact
 * carries), Coulomb, walls against p, contacts against positions. Never changes the packing. */
sp_status sp_packing_audit(const sp_packing *p, double threshold, sp_audit *audit, sp_error *err);

/* Which grains are rattlers: fewer than 2 force-carrying contacts (friction = 0: fewer than dim + 1; 1D: 2), walls
 * included, removed again and again until none is left. carrying[c] says whether contact c belongs to the network.
 * Either array may be NULL. threshold as a fraction of the pressure (1e-4 by default). */
sp_status sp_packing_rattlers(const sp_packing *p, double threshold, uint8_t *rattler, uint8_t *carrying,
                              int32_t *n_rattlers, sp_error *err);

/* Table I of Somfai et al. 2005: bulk averages, layers of `margin` (3) diameters at both walls left out, partly
 * covered spheres counted by their part. NAN where the bulk is empty. */
typedef struct sp_statics {
    double phi2, phi3, phi3s; /* area fraction, volume fraction in a layer one diameter thick, same without rattlers */
    double zs, f0;            /* force-carrying contacts per non-rattler grain; fraction of rattlers in percent */
    double n_over_p;          /* mean normal force of carrying contacts over p d^2 */
    double z2, z3;            /* <N^a>/<N>^a, Eq. (5) */
    double f2, f2s;           /* <n_up^2>, Eq. (6), over all and over contacts above the mean force */
    double s1_over_s2;        /* horizontal over vertical stress, all carrying contacts, walls included */
} sp_statics;

sp_status sp_statics_make(const sp_packing *p, double threshold, double margin, sp_statics *out, sp_error *err);

/* ---- making packings ---------------------------------------------------------------------------------------- */

typedef enum sp_pack_kind { SP_PACK_PISTON = 0, SP_PACK_CHAIN, SP_PACK_TRIANGULAR } sp_pack_kind;

/* Everything that decides a packing. sp_pack_spec_default() fills it with the defaults of docs/physics.md. */
typedef struct sp_pack_spec {
    sp_pack_kind kind;
    int dim;
    int32_t grains;
    double width;                      /* period sideways [d] */
    double pressure;                   /* [E*] */
    double friction;                   /* mu */
    double poisson;                    /* nu */
    double diameter_min, diameter_max; /* uniform diameters [d]; equal: monodisperse; both 0: the kind's own, 0.8 .. 1.2
                                          for the piston, 1 for ordered packings */
    uint64_t seed;
    double tolerance;    /* largest elastic acceleration at the end [E* / (rho d)]; 0: min(1e-10, 1e-6 p) */
    double damping;      /* zeta, fraction of critical at a contact, while the packing forms */
    double piston_mass;  /* per unit of wall area [rho d] */
    double gas_fraction; /* area fraction of the starting gas */
    double time_step;    /* dt / sqrt(m_min / k_max) */
    double calm;         /* global damping starts once the largest acceleration is below calm x p */
    double drag;         /* rate of the global damping at p = 1e-4 [sqrt(E* / rho)/d]; scales as p^(1/3) */
    int64_t max_steps;   /* refuse after that many; 0: a bound from the pressure and the height */
} sp_pack_spec;

sp_pack_spec sp_pack_spec_default(void);
/* Values and their combination (box narrower than 4 grains, gas too dense, ...). SP_EINVAL with the field. */
sp_status sp_pack_spec_check(const sp_pack_spec *spec, sp_error *err);

/* Progress of a making; return false to stop it (SP_EINTERRUPTED). */
typedef struct sp_pack_progress {
    const char *phase; /* "compaction" or "equilibration" */
    int64_t steps;
    double height, residual;
} sp_pack_progress;
typedef bool (*sp_pack_watch)(const sp_pack_progress *progress, void *user);

/* Makes one packing: a function of spec alone, bit for bit. SP_EFAILED when it never comes to rest, blows up or a
 * grain escapes: never a wrong packing. watch may be NULL. */
sp_status sp_packing_make(const sp_pack_spec *spec, sp_pack_watch watch, void *user, sp_packing *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
