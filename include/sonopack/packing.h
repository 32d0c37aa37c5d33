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
#include <stddef.h>
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
SP_API sp_packing sp_packing_none(void);
/* Arrays for n grains and n_contacts contacts, zeroed. */
SP_API sp_status sp_packing_alloc(sp_packing *p, int dim, int32_t n, int32_t n_contacts, sp_error *err);
SP_API void sp_packing_free(sp_packing *p);

/* Puts the contacts into their order. */
SP_API void sp_packing_sort(sp_packing *p);

/* Area of a wall [d^2], and height between walls [d]. */
SP_API double sp_packing_wall_area(const sp_packing *p);
SP_API double sp_packing_height(const sp_packing *p);

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
SP_API sp_status sp_packing_check(const sp_packing *p, sp_error *err);

/* Physics: force and torque balance of the grains that carry (threshold: fraction of p x d^2 above which a contact
 * carries), Coulomb, walls against p, contacts against positions. Never changes the packing. */
SP_API sp_status sp_packing_audit(const sp_packing *p, double threshold, sp_audit *audit, sp_error *err);
/* The largest relative measure of an audit, and its first fault: a pair that is not listed, or a measure above the
 * tolerance. reason = "" if there is none. */
SP_API double sp_audit_worst(const sp_audit *audit, double tolerance, char *reason, size_t size);

/* Which grains are rattlers: fewer than 2 force-carrying contacts (friction = 0: fewer than dim + 1; 1D: 2), walls
 * included, removed again and again until none is left. carrying[c] says whether contact c belongs to the network.
 * Either array may be NULL. threshold as a fraction of the pressure (1e-4 by default). */
SP_API sp_status sp_packing_rattlers(const sp_packing *p, double threshold, uint8_t *rattler, uint8_t *carrying,
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
    /* shear over vertical stress: positive where what lies below pushes what lies above towards +x; s32: towards +y, in
       three dimensions (else NAN) */
    double s12_over_s2, s32_over_s2;
    double mobilised; /* fraction of the carrying contacts, walls included, with |F_t| >= 0.99 mu F_n; NAN without
                         friction */
} sp_statics;

SP_API sp_status sp_statics_make(const sp_packing *p, double threshold, double margin, sp_statics *out, sp_error *err);

/* ---- making packings ---------------------------------------------------------------------------------------- */

/* SP_PACK_FILE: a packing that is there already is compressed or decompressed further. */
typedef enum sp_pack_kind { SP_PACK_PISTON = 0, SP_PACK_CHAIN, SP_PACK_TRIANGULAR, SP_PACK_FILE } sp_pack_kind;

/* Laws of the diameters, see docs/physics.md. */
typedef enum sp_sizes { SP_SIZES_UNIFORM = 0, SP_SIZES_BIDISPERSE, SP_SIZES_LOGNORMAL, SP_SIZES_LIST } sp_sizes;
enum { SP_DIAMETERS_MAX = 1000000 }; /* numbers in a list of diameters */
enum { SP_HISTORY_MAX = 1000 };      /* pressures in a history */

/* What shrinks under the pressure: the height, or the sides as well until the horizontal stress is the pressure too. */
typedef enum sp_compression { SP_COMPRESSION_PISTON = 0, SP_COMPRESSION_ISOTROPIC } sp_compression;

/* Where the damping, the piston, the gas and the time step come from that the spec leaves open. DEFAULT and SOMFAI2005
 * are one motion until the grains are nearly at rest. QUICK is braked early: it takes an eighth to two fifths of the
 * steps, and is another material, above all in tall boxes (docs/physics.md, Preparation). */
typedef enum sp_protocol { SP_PROTOCOL_DEFAULT = 0, SP_PROTOCOL_SOMFAI2005, SP_PROTOCOL_QUICK } sp_protocol;

/* Everything that decides a packing. sp_pack_spec_default() fills it with the defaults of docs/physics.md. A plain
 * value: copies share the list of diameters, which whoever made it keeps until the last copy has been used. */
typedef struct sp_pack_spec {
    sp_pack_kind kind;
    int dim;
    int32_t grains;
    double width;    /* period along x [d] */
    double depth;    /* period along y in three dimensions [d]; 0: the width */
    double pressure; /* [E*] */
    double friction; /* mu */
    double poisson;  /* nu */
    sp_sizes sizes;
    double diameter_min, diameter_max; /* limits of the law [d]; both 0: its own, for uniform diameters 0.8 .. 1.2 under
                                          the piston and 1 in ordered packings */
    double large_fraction;             /* bidisperse: grains with diameter_max over all */
    double size_spread;                /* lognormal: standard deviation of ln d */
    const double *diameters;           /* list: of the grains in their order [d]; NULL: none */
    int32_t diameter_count;            /* at least as many as grains */
    sp_compression compression;
    sp_protocol protocol;
    bool reference; /* the plain path: no tricks that change rounding or skip steps */
    uint64_t seed;
    double tolerance;     /* largest elastic acceleration at the end [E* / (rho d)]; 0: min(1e-10, 1e-6 p), over the
                             smallest diameter where that is above 1 */
    double damping;       /* zeta, fraction of critical at a contact, while the packing forms; 0: the protocol's own */
    double piston_mass;   /* per unit of wall area [rho d]; 0: the protocol's own */
    double gas_fraction;  /* of the starting gas: area (2D) or volume (3D) fraction; 0: the protocol's own */
    double time_step;     /* over the largest stable one (packing/piston.c); 0: the protocol's own */
    double calm;          /* global damping starts once the largest acceleration is below calm x p; 0: never, < 0: the
                             protocol's own */
    double drag;          /* rate of the global damping at p = 1e-4 [sqrt(E* / rho)/d]; scales as p^(1/3); < 0: the
                             protocol's own */
    double calm_damping;  /* zeta once the global damping has started; 0: the protocol's own */
    double viscous_limit; /* Coulomb's limit of the whole tangential force, viscous part included, over that of its
                             elastic part, until the global damping starts (from then on 1); 0: the protocol's own */
    int64_t max_steps;    /* refuse after that many; 0: a bound from the pressure and the height */
    const double
        *history; /* pressures that are gone through first, each to its equilibrium [E*]; shared like diameters */
    int32_t history_count;
    uint64_t content; /* SP_PACK_FILE: sp_packing_hash of the packing to start from; 0: whatever is given */
} sp_pack_spec;

SP_API sp_pack_spec sp_pack_spec_default(void);
/* Values and their combination (box narrower than 4 grains, gas too dense, ...). SP_EINVAL with the field. */
SP_API sp_status sp_pack_spec_check(const sp_pack_spec *spec, sp_error *err);
/* How many grains make a box about that high, to one or two percent for the default law: height x width (x depth) over
 * the mean area (volume) of a grain, times the usual area fraction 0.815 (volume fraction 0.6) of a packing under the
 * piston. SP_EINVAL for other kinds, whose height follows from the grains, and for more than 1e8 grains. */
SP_API sp_status sp_pack_spec_fill(const sp_pack_spec *spec, double height, int32_t *grains, sp_error *err);

/* Progress of a making; return false to stop it (SP_EINTERRUPTED). */
typedef struct sp_pack_progress {
    const char *phase; /* "flight" of the gas, "compaction", or "equilibration" */
    int64_t steps;
    double height, strain; /* strain: 1 - height / height at the start */
    double residual;       /* largest elastic acceleration now, to be brought below the tolerance */
    double fraction;       /* of the work that is done, a guess in 0 .. 1 */
} sp_pack_progress;
typedef bool (*sp_pack_watch)(const sp_pack_progress *progress, void *user);

/* Makes one packing: a function of spec alone, bit for bit. SP_EFAILED when it never comes to rest, blows up or a
 * grain escapes: never a wrong packing. watch may be NULL. */
SP_API sp_status sp_packing_make(const sp_pack_spec *spec, sp_pack_watch watch, void *user, sp_packing *out,
                                 sp_error *err);

/* What a making may use and tell beside its spec; none of it changes the packing. */
typedef struct sp_pack_hooks {
    sp_pack_watch watch; /* may be NULL */
    void *user;          /* passed to watch, save and stage */
    int threads;         /* for packings of thousands of grains; 0 and 1: none beside the caller's */
    /* Called now and then with the whole state as bytes, to be kept until the next call; may be NULL. */
    sp_status (*save)(const void *state, size_t size, void *user, sp_error *err);
    const void *state; /* bytes that save was given by a making of the same spec that did not end; NULL: from the start.
                          The packing is the same, bit for bit. SP_EFORMAT if they are not, or are damaged. */
    size_t state_size;
    const sp_packing *from; /* the packing that kind SP_PACK_FILE starts from */
    /* Called with the packing at each pressure of the history, index from 0; may be NULL. */
    sp_status (*stage)(const sp_packing *packing, int32_t index, void *user, sp_error *err);
} sp_pack_hooks;
SP_API sp_status sp_packing_make_with(const sp_pack_spec *spec, const sp_pack_hooks *hooks, sp_packing *out,
                                      sp_error *err);

/* Whether bytes are the state of some making. */
SP_API bool sp_pack_is_state(const void *state, size_t size);
/* Whether these bytes are the whole state of a making of this spec, and at which step: else SP_EFORMAT. For
 * SP_PACK_FILE the spec must have gone through sp_pack_spec_from. */
SP_API sp_status sp_pack_state_check(const sp_pack_spec *spec, const void *state, size_t size, int64_t *steps,
                                     sp_error *err);

/* What a packing is made of as one number, 63 bits: the same for equal grains, contacts and box only. */
SP_API uint64_t sp_packing_hash(const sp_packing *p);
/* Fills in what SP_PACK_FILE takes from the packing: dimension, grains, box, sizes and content. SP_EINVAL where the
 * spec has another value for one of them (its default is none), or the packing is no start. */
SP_API sp_status sp_pack_spec_from(sp_pack_spec *spec, const sp_packing *from, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
