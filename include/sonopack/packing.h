#ifndef SONOPACK_PACKING_H
#define SONOPACK_PACKING_H
/* Packings: grains at rest under pressure, and their contacts.
 *
 * Units: lengths in mean grain diameters d; pressures in E*, the modified Young modulus E/(1-nu^2) of a grain; grains
 * have unit density rho. Hence forces are in E* d^2 and times in d / sqrt(E* / rho).
 *
 * Grains are spheres in any dimension. The up axis is axis dim-1: x in 1D, y in 2D, z in 3D. Under the piston it leads
 * from the bottom wall at 0 to the top wall at the height, and the other axes are periodic. Other cells are periodic
 * along all axes, or have walls on all sides (sp_cell). */

#include <sonopack/status.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Contact partners that are walls: two across the up axis, two across x (2D and 3D), two across y (3D). The second of
 * each pair lies at the end of the box edge. */
enum { SP_BOTTOM = -1, SP_TOP = -2, SP_LEFT = -3, SP_RIGHT = -4, SP_FRONT = -5, SP_BACK = -6 };

/* A contact. For two grains i < j. In 2D ft = Ft (-ny, nx), where Ft is the scalar in text files. */
typedef struct sp_contact {
    int32_t i, j;   /* index of a grain; of another grain, or a wall, SP_BOTTOM .. SP_BACK */
    double n[3];    /* unit normal from i to j */
    double overlap; /* R_i + R_j - r_ij, or R_i - distance to the wall [d] */
    double fn;      /* normal elastic force, >= 0 in compression [E* d^2] */
    double ft[3];   /* tangential elastic force on i [E* d^2] */
    double kn, kt;  /* normal stiffness; tangential stiffness, where they are measured or belong to another law.
                       Both 0: Hertz's and Mindlin's at this overlap [E* d] */
    double mu;      /* Coulomb's coefficient, where it is not that of the packing; 0: that of the packing */
} sp_contact;

/* Contact law at the walls. RIGID: a rigid plane (Hertz with R = inf and E* of one grain). GRAIN: the wall responds
 * like a fixed grain identical to the one that touches it ("identical springs" of the 1D chain, Somfai et al. 2005,
 * App. C). ELASTIC: a plane of the grains' own material (R = inf and half of E*), as in DEM programs. */
typedef enum sp_wall { SP_WALL_RIGID = 0, SP_WALL_GRAIN = 1, SP_WALL_ELASTIC = 2 } sp_wall;

/* What bounds the grains. PISTON: walls at the bottom and the top, periodic sideways. PERIODIC: no walls, periodic
 * along all axes. BOX: walls on all sides. RING (2D): two circles about (box[0]/2, box[0]/2); the inner one is the
 * bottom, the outer one the top, and `up` is outwards. */
typedef enum sp_cell { SP_CELL_PISTON = 0, SP_CELL_PERIODIC, SP_CELL_BOX, SP_CELL_RING } sp_cell;

/* The material of the grains in SI units, which turns dimensionless numbers into those of an experiment. It has no
 * influence on them. */
typedef struct sp_material {
    double young;    /* Young's modulus E [Pa]; 0: the material is not known */
    double poisson;  /* Poisson's ratio: E* = E/(1 - poisson^2) */
    double density;  /* rho [kg/m^3] */
    double diameter; /* mean grain diameter d [m] */
} sp_material;
/* SP_EINVAL names the value that is out of range: E, rho and d are positive, the ratio is 0 .. 0.5. */
SP_API sp_status sp_material_check(const sp_material *m, sp_error *err);
SP_API double sp_material_modulus(const sp_material *m); /* E* = E/(1 - nu^2) [Pa] */
/* Reads "E=70e9,nu=0.22,rho=2500,d=1e-3", in any order, and checks the values. SP_EINVAL names the value at fault. */
SP_API sp_status sp_material_read(const char *text, sp_material *out, sp_error *err);
/* Writes a material in that form, with the digits that read back exactly. Returns text. */
enum { SP_MATERIAL_TEXT = 160 };
SP_API char *sp_material_text(const sp_material *m, char text[SP_MATERIAL_TEXT]);

enum { SP_SERIES_STRAINS = 6 };

typedef struct sp_packing {
    int dim;   /* 1, 2 or 3 */
    int32_t n; /* number of grains */
    int32_t n_contacts;
    double *x;            /* [n][3] centres, 0 on unused axes [d] */
    double *r;            /* [n] radii [d] */
    double *mass;         /* [n] masses [rho d^3], or NULL: spheres of unit density. Both or neither: */
    double *inertia;      /* [n] moments of inertia [rho d^5] */
    int32_t *species;     /* [n] material of each grain, from 0 (sp_types), or NULL: one material */
    sp_contact *contacts; /* [n_contacts] sorted: pairs by (i, j), then the walls in the order of SP_BOTTOM .. SP_BACK,
                             each by i */
    sp_cell cell;         /* what bounds the grains */
    double box[3];        /* edges: periods, or distances of walls; box[dim-1] is the height; 1 on unused axes. RING:
                             diameter of the outer wall, and distance between the walls [d] */
    double tilt[3]; /* PERIODIC: xy, xz, yz of the lattice vectors (box[0], 0, 0), (xy, box[1], 0), (xz, yz, box[2]), at
                       most half of the edge in their direction; 0 for the other cells and on unused axes [d] */
    double pressure; /* force on the top wall over its area (2D: width x d; 1D: d^2); without a piston the mean of the
                        normal stresses [E*] */
    double gravity;  /* acceleration against the up axis [E* / (rho d)] */
    double friction; /* Coulomb coefficient mu; 0: no tangential forces, no rotations */
    double poisson;  /* Poisson's ratio nu of the grain material */
    sp_wall wall;    /* how the walls respond */
    sp_material material; /* of the grains */
    uint64_t seed;        /* of the random numbers; 0: unknown (imported packings), as NAN and NULL of what follows */
    int64_t steps;        /* time steps of the compression */
    double residual;      /* largest elastic acceleration (angular: times R) at the end [E* / (rho d)] */
    double seconds;       /* CPU time of the compression [s]; not saved, so that equal packings give equal files */
    char *scene;          /* complete scene as text (sp_scene_text) */
    double frame; /* number or time step in the series of packings that this one is of; NAN: it is of none. Then: */
    double
        strain[SP_SERIES_STRAINS]; /* of its cell since the first: xx, yy, zz, yz, xz, xy; compression positive, the
                                      normal ones logarithmic; NAN on axes that do not exist, and of shear with walls */
} sp_packing;

/* Returns an empty packing, which is safe to free. */
SP_API sp_packing sp_packing_none(void);
/* Allocates zeroed arrays for n grains and n_contacts contacts. SP_EINVAL for a bad size, SP_ENOMEM. */
SP_API sp_status sp_packing_alloc(sp_packing *p, int dim, int32_t n, int32_t n_contacts, sp_error *err);
SP_API void sp_packing_free(sp_packing *p);
/* Allocates mass and inertia, filled in as of spheres of unit density. SP_ENOMEM. */
SP_API sp_status sp_packing_alloc_masses(sp_packing *p, sp_error *err);
/* Allocates species, all 0. SP_ENOMEM. */
SP_API sp_status sp_packing_alloc_species(sp_packing *p, sp_error *err);

/* Sorts the contacts into the order of sp_packing.contacts. */
SP_API void sp_packing_sort(sp_packing *p);

/* Fills in what is NAN in the contacts: the overlap or the normal force, each from the other by Hertz's law or as a
 * linear spring of the stiffness kn; kt as Mindlin's part of kn. SP_EINVAL names the contact if both overlap and force
 * are NAN or one is negative, and if it joins no grains of the packing. */
SP_API sp_status sp_packing_complete(sp_packing *p, sp_error *err);

/* Area across the up axis, of a ring that of the outer wall [d^2]; edge along the up axis [d]; volume [d^3]. */
SP_API double sp_packing_wall_area(const sp_packing *p);
SP_API double sp_packing_height(const sp_packing *p);
SP_API double sp_packing_volume(const sp_packing *p);
/* Whether the packing repeats along an axis 0 .. dim-1. */
SP_API bool sp_packing_periodic(const sp_packing *p, int axis);
/* Whether the packing has this wall, SP_BOTTOM .. SP_BACK. */
SP_API bool sp_packing_has_wall(const sp_packing *p, int32_t wall);
/* The axis across a flat wall, and the direction of its outer normal along this axis (outwards), -1 or 1. */
SP_API int sp_packing_wall_axis(const sp_packing *p, int32_t wall);
SP_API double sp_packing_wall_side(int32_t wall);

/* Whether all grains are spheres of unit density, and all contacts follow the law of Hertz and Mindlin. Only such
 * packings have forces away from rest; all others are known at rest, where they are linear networks. */
SP_API bool sp_packing_hertzian(const sp_packing *p);
/* SP_EREFUSED if it is not. `what` names what needs a contact law, such as "the nonlinear motion". */
SP_API sp_status sp_packing_need_law(const sp_packing *p, const char *what, sp_error *err);

/* Results of sp_packing_audit: relative errors, all 0 for a perfect packing. */
typedef struct sp_audit {
    double force_residual;  /* largest net force on a grain over p x (mean diameter)^2; of a rattler what exceeds the
                               threshold of a carrying contact */
    double torque_residual; /* largest net torque over R, in the same unit */
    double wall_residual; /* piston: largest difference between the force on a wall and its load, over p A. Other cells:
                             | mean pressure / p - 1 |, and in a box the sum of all walls' forces over p A */
    double law_residual;  /* largest relative difference between fn and Hertz's law at the stored overlap, beyond the
                             rounding of a text file; contacts with a stiffness of their own are left out */
    double geometry_residual; /* largest |overlap - overlap from the positions| over the largest overlap */
    double coulomb_excess;    /* largest |ft|/(mu fn) - 1, or 0 if Coulomb's law holds everywhere */
    int32_t missing;          /* overlaps that are not listed as contacts: of pairs, of grains and walls, and of grains
                                 with a second image of another or an image of themselves, which cannot be listed */
    int32_t carrying;         /* force-carrying contacts */
    int32_t rattlers;         /* grains without enough contacts to be held */
    double inertia_excess;    /* largest I/(m R^2) - 1, or 0: no mass lies outside of its grain */
    double acceleration; /* largest of a grain [E* / (rho d)], angular ones times R: sp_packing.residual without that
                            of the cell */
} sp_audit;

/* Checks the structure of a packing: sizes, indices, finite numbers, unit normals, positive radii, grains inside the
 * box, sorted contacts, no contact twice. Use it on everything read from a file. SP_EFORMAT with the first fault. */
SP_API sp_status sp_packing_check(const sp_packing *p, sp_error *err);

/* Checks the physics of a packing: balance of forces and torques, Coulomb's law, wall forces against the pressure,
 * contacts against positions. A contact carries force if fn > threshold x p d^2. SP_ENOMEM. */
SP_API sp_status sp_packing_audit(const sp_packing *p, double threshold, sp_audit *audit, sp_error *err);
/* Returns the largest relative error of an audit, and writes its first fault to reason: a missing contact, or an error
 * above the tolerance. reason is "" if there is none. */
SP_API double sp_audit_worst(const sp_audit *audit, double tolerance, char *reason, size_t size);

/* Finds rattlers: grains with fewer than 2 force-carrying contacts (without friction: fewer than dim + 1, or with a
 * weight dim, on which a grain rests), walls included. They are removed repeatedly until none is left. Outputs, either
 * of which may be NULL: rattler[n], and carrying[n_contacts], which tells whether a contact belongs to the force
 * network. threshold: force of a carrying contact over p d^2; usually 1e-4. SP_EINVAL for nan,
 * SP_ENOMEM. */
SP_API sp_status sp_packing_rattlers(const sp_packing *p, double threshold, uint8_t *rattler, uint8_t *carrying,
                                     int32_t *n_rattlers, sp_error *err);

/* Averages of Table I of Somfai et al. 2005 over the bulk: layers of thickness `margin` (usually 3 d) at all walls are
 * left out, and spheres that reach into them count in part. Without walls the bulk is the whole cell. NAN if it is
 * empty. */
typedef struct sp_statics {
    double phi2, phi3,
        phi3s;         /* area fraction; volume fraction of a layer one diameter thick; the same without rattlers */
    double zs, f0;     /* force-carrying contacts per non-rattler grain; fraction of rattlers [percent] */
    double n_over_p;   /* mean normal force of carrying contacts over p d^2 */
    double z2, z3;     /* <N^2>/<N>^2, Eq. (5); the same with third powers */
    double f2, f2s;    /* <n_up^2>, Eq. (6), over all contacts; over those above the mean force */
    double s1_over_s2; /* horizontal over vertical stress, from all carrying contacts, walls included */
    double s12_over_s2, s32_over_s2; /* shear stress over vertical stress, positive if the lower part pushes the upper
                                        part towards +x; the same towards +y, NAN in two dimensions */
    double
        mobilised; /* fraction of carrying contacts, walls included, with |F_t| >= 0.99 mu F_n; NAN without friction */
    double s_xx, s_yy, s_zz, s_yz, s_xz,
        s_xy; /* mean stress of the whole packing on these axes, from all carrying contacts, walls included; positive in
                 compression. NAN on axes that the packing does not have [E*] */
} sp_statics;

/* In a ring vertical means along the radius, horizontal along circles, and +x clockwise; s_xx .. s_xy keep the axes. */
SP_API sp_status sp_statics_make(const sp_packing *p, double threshold, double margin, sp_statics *out, sp_error *err);
/* Mass over volume of the grains that are no rattlers [rho], in the same bulk: the density that long waves feel. For
 * spheres of unit density it is phi3s. NAN if the bulk is empty. SP_ENOMEM. */
SP_API sp_status sp_packing_density(const sp_packing *p, double threshold, double margin, double *out, sp_error *err);
/* The same where the rattlers are known: rattler [n], or NULL if none is one. Reads no contacts. */
SP_API double sp_packing_density_of(const sp_packing *p, const uint8_t *rattler, double margin);

/* Stresses of a packing between two rings, from all carrying contacts. r is the radius, t leads along circles,
 * counterclockwise. In equilibrium p_outer b^2 - p_inner a^2 = (s_rr + s_tt)(b^2 - a^2)/2 and t_outer b^2 = t_inner a^2
 * for rings of the radii a and b. */
typedef struct sp_ring_statics {
    double p_inner, p_outer; /* normal force on the inner and the outer ring over its circumference [E*] */
    double t_inner, t_outer; /* tangential force along t, of what is inside of a ring on what is outside, over its
                                circumference [E*] */
    double s_rr, s_tt, s_rt; /* mean stress of the packing, positive in compression [E*] */
} sp_ring_statics;
/* SP_EREFUSED in other cells, SP_ENOMEM. */
SP_API sp_status sp_ring_statics_make(const sp_packing *p, double threshold, sp_ring_statics *out, sp_error *err);

/* ---- compression -------------------------------------------------------------------------------------------- */

/* PISTON: a gas compressed by a piston. CHAIN, TRIANGULAR: ordered. FILE: compresses or decompresses a given
 * packing. MINIMUM: smooth grains at random places, at a minimum of their energy. */
typedef enum sp_pack_kind {
    SP_PACK_PISTON = 0,
    SP_PACK_CHAIN,
    SP_PACK_TRIANGULAR,
    SP_PACK_FILE,
    SP_PACK_MINIMUM
} sp_pack_kind;

/* Distributions of the diameters; see docs/physics.md. */
typedef enum sp_sizes {
    SP_SIZES_UNIFORM = 0,
    SP_SIZES_BIDISPERSE,
    SP_SIZES_LOGNORMAL,
    SP_SIZES_LIST,
    SP_SIZES_TYPES
} sp_sizes;
enum { SP_DIAMETERS_MAX = 1000000 }; /* most entries of a list of diameters */
enum { SP_HISTORY_MAX = 1000 };      /* most pressures of a history */

/* PISTON: only the height shrinks. ISOTROPIC: the periods shrink too, until the horizontal stress equals the
 * pressure. */
typedef enum sp_compression { SP_COMPRESSION_PISTON = 0, SP_COMPRESSION_ISOTROPIC } sp_compression;

/* Sets the damping, piston mass, gas fraction and time step that the spec leaves open. DEFAULT and SOMFAI2005 are
 * identical until the grains are nearly at rest. QUICK dissipates earlier and needs 1/8 to 2/5 of the steps, but gives
 * a different material, especially in tall boxes. AFFINE compresses the gas by a homogeneous strain until the walls
 * carry the pressure, which takes hardly more steps in tall boxes; another material again (docs/physics.md,
 * Preparation). */
typedef enum sp_protocol {
    SP_PROTOCOL_DEFAULT = 0,
    SP_PROTOCOL_SOMFAI2005,
    SP_PROTOCOL_QUICK,
    SP_PROTOCOL_AFFINE
} sp_protocol;

/* Tangential stiffness while a packing forms. CONSTANT: that of full stick up to Coulomb's limit, as in the paper.
 * HISTORY: it falls as the slip spreads over the contact, and recovers at each reversal (Mindlin and Deresiewicz 1953;
 * docs/physics.md, Loading history); in 2D only. */
typedef enum sp_tangential { SP_TANGENTIAL_CONSTANT = 0, SP_TANGENTIAL_HISTORY } sp_tangential;

/* What decides masses and moments of inertia: balls, or in two dimensions disks of thickness d. */
typedef enum sp_shape { SP_SHAPE_SPHERE = 0, SP_SHAPE_DISK } sp_shape;

/* Grains of several materials, which are mixed at random: lists of a number for each, or NULL for those of one
 * material. Of two grains 1/E12 = 1/E1* + 1/E2*, and Mindlin's stiffness has 1/G12 = (2 - nu1)/G1 + (2 - nu2)/G2. */
enum { SP_TYPES_MAX = 8 };
typedef struct sp_types {
    const double *fraction; /* of the number of grains; their sum is 1 */
    const double *diameter; /* [d]; for SP_SIZES_TYPES */
    const double *modulus;  /* E* of each, in the unit E*; NULL: 1 */
    const double *poisson;  /* NULL: that of the spec */
    const double *density;  /* [rho]; NULL: 1 */
    const double *friction; /* of pairs 11, 12, .., 22, ..; walls: of a grain and its like. NULL: that of the spec */
    int32_t fractions, diameters, moduli, poissons, densities, frictions; /* lengths of the lists */
} sp_types;

/* Components of the cell that a strain path leaves out. FIXED: they do not strain. STRESS: they hold their stress. */
typedef enum sp_lateral { SP_LATERAL_FIXED = 0, SP_LATERAL_STRESS } sp_lateral;

/* Everything that determines a packing. sp_pack_spec_default() fills in the defaults of docs/physics.md. Copies share
 * the lists; whoever allocated these keeps them until the last copy is unused. */
typedef struct sp_pack_spec {
    sp_pack_kind kind;
    sp_cell cell; /* what bounds the grains; not PISTON: for kinds PISTON (a gas) and FILE */
    int dim;
    int32_t grains;
    double width;    /* period along x [d]; without a piston about the edge along x of the packing, where the default
                        value means equal edges */
    double depth;    /* period along y in 3D [d]; 0: the width */
    double pressure; /* [E*]; with a stress its mean normal stress, or the default */
    double friction; /* Coulomb coefficient mu */
    double poisson;  /* Poisson's ratio nu */
    sp_types types;  /* none: one material */
    sp_shape shape;
    sp_sizes sizes;
    double diameter_min, diameter_max; /* limits of the distribution [d]; both 0: its default, which for uniform is 0.8
                                          .. 1.2 under the piston and 1 in ordered packings */
    double large_fraction;             /* bidisperse: fraction of grains with diameter_max */
    double size_spread;                /* lognormal: standard deviation of ln d */
    const double *diameters;           /* list: diameters of the grains [d]; NULL: none */
    int32_t diameter_count;            /* at least the number of grains */
    sp_compression compression;
    sp_protocol protocol;
    bool reference; /* use the reference code (packing/plain.c), which is slow and simple */
    uint64_t seed;
    double tolerance; /* largest elastic acceleration at the end [E* / (rho d)]; 0: min(1e-10, 1e-6 p), divided by the
                         smallest diameter if that exceeds 1 */
    double damping; /* fraction zeta of critical damping at contacts, while the packing forms; 0: set by the protocol */
    double piston_mass;  /* per wall area [rho d]; 0: set by the protocol */
    double gas_fraction; /* area (2D) or volume (3D) fraction of the initial gas; 0: set by the protocol */
    double time_step;    /* over the largest stable one (packing/piston.c); 0: set by the protocol */
    double lag;          /* part of the averaged velocities of dashpots that remains in a step; < 0: by the protocol */
    double calm; /* global damping starts once the largest acceleration is below calm x p; 0: never; -1: set by the
                    protocol */
    double drag; /* rate of the global damping at p = 1e-4 [sqrt(E* / rho)/d]; scales as p^(1/3); -1: set by the
                    protocol */
    double calm_damping;  /* zeta once the global damping has started; 0: set by the protocol */
    double viscous_limit; /* limit of the total tangential force, viscous part included, over the Coulomb limit of its
                             elastic part; from the start of the global damping on, it is 1. 0: set by the protocol */
    double strain_rate; /* of the edges of a cell without a piston, until the grains carry 0.01 p [sqrt(p / rho)/d]; 0:
                           0.03, or as little as lets elastic waves cross the cell */
    int64_t max_steps;  /* fail after this many; 0: a bound from the pressure and the height */
    const double *history; /* pressures [E*] to be equilibrated at first, in this order */
    int32_t history_count;
    const double *stress; /* target of cells without a piston: xx, yy, xy in 2D, xx, yy, zz, yz, xz, xy in 3D,
                             compression positive [E*]; the cell takes the shape that holds it. NULL: the mean normal
                             stress is the pressure, and the cell keeps its shape */
    int32_t stress_count;
    const double *strain; /* path of a cell without a piston after the last pressure: components as of stress */
    int32_t strain_count;
    const double *turns; /* multiples of `strain` to which the path goes in turn; NULL: 1 */
    int32_t turn_count;
    int32_t strain_steps; /* from 0 to 1 of the path, each of which ends at rest */
    sp_lateral lateral;
    int32_t stages; /* end after so many packings; 0: after all */
    double gravity; /* cell PISTON: acceleration against the up axis [E* / (rho d)] */
    sp_tangential tangential;
    double fraction;     /* SP_PACK_MINIMUM: area or volume fraction of the grains, overlaps counted twice; 0: the
                            pressure is given */
    double law_exponent; /* a of F = 4/3 E12 R12^(2 - a) n^a; other than 3/2 in periodic cells alone */
    uint64_t content;    /* required sp_packing_hash of the initial packing; 0: any, or none */
} sp_pack_spec;

SP_API sp_pack_spec sp_pack_spec_default(void);
/* Checks the values and their combination, for example a box narrower than 4 grains or too dense a gas. SP_EINVAL names
 * the field. */
SP_API sp_status sp_pack_spec_check(const sp_pack_spec *spec, sp_error *err);
/* Returns the spec with all open values filled in: limits of the diameters (for a list: its extremes), depth,
 * tolerance, and the values set by the protocol. Resolving a spec twice changes nothing. */
SP_API sp_pack_spec sp_pack_spec_resolve(const sp_pack_spec *given);
/* Number of packings that a run makes one after another: at each pressure of the history, at the pressure, and after
 * each step of the path. */
SP_API int32_t sp_pack_stages(const sp_pack_spec *spec);
/* Pressure of a stage, 0 .. sp_pack_stages - 1 [E*]. */
SP_API double sp_pack_stage_pressure(const sp_pack_spec *spec, int32_t stage);
/* The strain of a stage along the path: of its largest component, with the sign of that. 0 up to the pressure. */
SP_API double sp_pack_stage_strain(const sp_pack_spec *spec, int32_t stage);
/* Moment <d^k>, k >= 0, of the distribution of diameters (of a list: of its entries). This and the next two expect a
 * spec that is checked and resolved. */
SP_API double sp_sizes_moment(const sp_pack_spec *spec, int k);
/* Radii r [grains] of all grains. */
SP_API void sp_radii_draw(const sp_pack_spec *spec, double *r);
/* The gas that a compression begins with: places grains at random without overlap at the gas fraction of the spec,
 * between walls at 0 and *height (2D and 3D). x is [grains][3]; unused axes are not written. SP_EFAILED if a grain
 * finds no free place. */
SP_API sp_status sp_gas_make(const sp_pack_spec *spec, const double *r, double *x, double *height, sp_error *err);
/* Estimates the number of grains that fill a box of the given height [d], to 1 or 2 percent for the default sizes:
 * height x width (x depth) over the mean grain area (volume), times the typical area fraction 0.815 (volume fraction
 * 0.6) under the piston. SP_EINVAL for other kinds, whose height follows from the grains, and for more than 1e8
 * grains. */
SP_API sp_status sp_pack_spec_fill(const sp_pack_spec *spec, double height, int32_t *grains, sp_error *err);

/* Progress of a compression. The callback returns false to stop it (SP_EINTERRUPTED). */
typedef struct sp_pack_progress {
    const char *phase;     /* "placing" (of many grains), "flight" (of the gas), "compaction" or "equilibration" */
    int64_t steps;         /* time steps so far */
    double height, strain; /* distance of the walls [d]; 1 - height / initial height */
    double residual;       /* current largest elastic acceleration, compared with the tolerance [E* / (rho d)] */
    double fraction;       /* estimated fraction of the work done, 0 .. 1 */
} sp_pack_progress;
typedef bool (*sp_pack_watch)(const sp_pack_progress *progress, void *user);

/* Creates a packing. It depends on the spec alone, bit for bit. watch may be NULL. SP_EINVAL for a bad spec, SP_EFAILED
 * if the grains do not come to rest, the motion blows up or a grain escapes, SP_EINTERRUPTED, SP_ENOMEM. */
SP_API sp_status sp_packing_make(const sp_pack_spec *spec, sp_pack_watch watch, void *user, sp_packing *out,
                                 sp_error *err);

/* Options of a run that do not affect the packing. */
typedef struct sp_pack_hooks {
    sp_pack_watch watch; /* may be NULL */
    void *user;          /* passed to watch, save and stage */
    int threads;         /* used from 5000 disks or 3000 spheres on; 0 or 1: the caller's thread only */
    /* Called now and then with the complete state, to be kept until the next call; may be NULL. An error ends the
     * run. */
    sp_status (*save)(const void *state, size_t size, void *user, sp_error *err);
    const void *state; /* State to resume from, as given to `save` in an interrupted run with the same spec; NULL: start
                          anew. The packing is the same, bit for bit. SP_EFORMAT if the state is damaged or belongs to
                          another spec. */
    size_t state_size;
    const sp_packing *from; /* initial packing of SP_PACK_FILE, or of SP_PACK_MINIMUM in place of random places */
    /* Called with the packing of each stage but the last, index from 0; may be NULL. An error ends the run. */
    sp_status (*stage)(const sp_packing *packing, int32_t index, void *user, sp_error *err);
} sp_pack_hooks;
SP_API sp_status sp_packing_make_with(const sp_pack_spec *spec, const sp_pack_hooks *hooks, sp_packing *out,
                                      sp_error *err);

/* Whether bytes look like a saved state. */
SP_API bool sp_pack_is_state(const void *state, size_t size);
/* Checks a saved state completely: SP_EFORMAT if it is damaged or belongs to another spec. Writes the step it was saved
 * at. For SP_PACK_FILE call sp_pack_spec_from first. */
SP_API sp_status sp_pack_state_check(const sp_pack_spec *spec, const void *state, size_t size, int64_t *steps,
                                     sp_error *err);

/* A 63-bit hash of the grains, contacts and box, never 0. */
SP_API uint64_t sp_packing_hash(const sp_packing *p);
/* Copies dimension, number of grains, box, size limits and hash of the initial packing to a spec of kind SP_PACK_FILE.
 * SP_EINVAL if the spec has set one of them to another value, or if the packing cannot be compressed. */
SP_API sp_status sp_pack_spec_from(sp_pack_spec *spec, const sp_packing *from, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
