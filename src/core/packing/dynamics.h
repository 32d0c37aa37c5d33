#ifndef SP_DYNAMICS_H
#define SP_DYNAMICS_H
/* Motion of grains in a cell in 2D and 3D: their data, neighbour lists, forces, one time step, and measures of
 * equilibrium. The compression protocol is in piston.c. */

#include "base/pool.h"
#include "packing/cell_grid.h"
#include "packing/mindlin.h"
#include "packing/types.h"

#include <sonopack/packing.h>
#include <stdbool.h>
#include <stdint.h>

/* Layout of a grain's data, a row of `stride` doubles (one cache line in 2D, two in 3D), so that a contact finds all of
 * it together. The position comes first (x is wrapped only when the lists are rebuilt), then the velocity. w is R times
 * the angular velocity (2D: one number). type is that of the material, as a double. */
typedef struct grain_layout {
    int stride, v, w, r, inv_m, type;
    int row, turn; /* doubles of a force row, and position of its torque/R */
    int forces;    /* components of a pair's tangential force */
    int past;      /* numbers of its history behind them (mindlin.h); 0 without */
    int averaged;  /* numbers of its averaged velocity behind those (dynamics.lag); 0 without */
} grain_layout;

/* Pairs that may touch. There are two lists. `outer` holds all pairs closer than a wide gap, and stores the tangential
 * forces between rebuilds. `inner` holds those of them that can touch within the next steps; the kernel works on it.
 * Arrays with several numbers per pair are stored as planes of `capacity` numbers. */
typedef struct pair_list {
    int32_t n, capacity;
    int32_t padded;    /* inner: n plus dummy pairs that fill the last vector */
    int32_t *integers; /* memory of the planes of integers, and of real numbers */
    double *reals;
    int32_t *i, *j;
    int32_t *at_i, *at_j; /* inner: position of the grains' rows in g */
    int32_t *from;        /* inner: index in outer */
    int32_t *near;        /* outer: scratch of the choice of an inner list */
    int32_t *span;        /* inner: [blocks of SPAN pairs][2] lowest and highest grain; threads skip blocks by it */
    double *image;        /* [dim] lattice vectors to add to x_j - x_i; 0 along axes with walls */
    double *reach;        /* R_i + R_j */
    double *ft;       /* elastic tangential force on i: 2D along (-ny, nx); 3D [3]; then the planes of its history */
    double *u;        /* behind these: averaged relative velocity, 2D along n and (-ny, nx), 3D [3] */
    double *e2;       /* 2 E12 sqrt(R12) */
    double *sm;       /* sqrt(m_eff 2 E12 sqrt(R12)) */
    double *light;    /* the larger 1/m */
    double *mu, *eta; /* friction and k_t/k_n, where materials are mixed; else not used */
} pair_list;

enum { SPAN = 256 }; /* pairs */

/* Where dashpots lag, the rate of a grain counts as at least this many times that of its stiffest contact: a step that
 * is stable in packings would not be so for two grains in one contact that rolls (piston.c). */
static const double SINGLE_CONTACT = 2.4;

/* Grains near a wall, in ascending order. */
typedef struct wall_list {
    int32_t n;
    int32_t *i;
    double *push; /* [n][2] normal force and stiffness of each, at the last forces */
} wall_list;

/* Where to find the forces on each grain. There is a row for each pair, which is the force on its i and the opposite of
 * that on its j, one for each grain at a wall, and a row of zeros that fills unused slots. Rows of grains with more
 * than SLOTS neighbours continue in a linked list. In two dimensions, up to BOTH_MOST grains have a second row for j:
 * these rows fit in a near cache, and reading them is faster than changing a sign. */
enum { SLOTS = 6, MOST_WALLS = 6, BOTH_MOST = 4000 };
typedef struct force_rows {
    int64_t capacity;
    double *row;      /* [rows][layout.row] force, torque/R (2D: fx fy t s; 3D: fx fy fz s and, with friction, q, 0) */
    int32_t *slot;    /* [n][SLOTS] positions of rows, + 1 for the opposite force */
    int32_t *count;   /* [n] number of rows */
    int32_t *further; /* [n] first of the linked list, or -1: 2 index of a row, + 1 for the opposite force */
    int32_t *chain;   /* [2 capacity] the next of the list, or -1 */
    bool both;        /* whether there are rows for the j of pairs */
    int32_t other, wall[MOST_WALLS], zero; /* index of the first row of the j, of the walls, and of the zero row */
} force_rows;

/* Contact parameters. */
typedef struct contact_law {
    double exponent; /* of the overlap in the normal force; 3/2 at walls */
    double friction, eta, sqrt_eta, damping;
    double viscous_limit;     /* limit of the total tangential force over the Coulomb limit of its elastic part */
    double spin;              /* m R^2/I */
    double stiffest, softest; /* largest and smallest E* of a grain */
    bool mixed;               /* contacts differ by the types of their grains: rules decide, not friction and eta */
    contact_rule pair[SP_TYPES_MAX][SP_TYPES_MAX], wall[SP_TYPES_MAX];
} contact_law;

typedef struct dynamics {
    int dim;
    grain_layout at;
    int32_t n;
    sp_cell cell;
    /* Whether the cell deforms as a whole along all axes, and the grains with it. If not, only the horizontal axes are
     * strained, without shear. True from the start in cells without a piston. Whoever changes it under a piston sets
     * outer_travel to infinity. */
    bool affine;
    double period[3];      /* edges of the horizontal axes: periods, or distances of walls; [2] is not used */
    double tilt[3];        /* PERIODIC: xy, xz, yz of the lattice vectors, as in sp_packing */
    double strain_rate[3]; /* rates d v_a / d x_a of the cell's deformation; walls at the ends of edges follow it too */
    double shear_rate[3];  /* PERIODIC: d v_x / d y, d v_x / d z, d v_y / d z */
    double gravity;        /* acceleration against the up axis */
    double area, pressure;
    contact_law law;
    bool plain;                             /* reference code (plain.c) */
    double *g;                              /* [n + 1][stride] grains; the last one is a dummy */
    double *plain_f;                        /* [n][6] forces of the reference code */
    double piston_y, piston_v, piston_mass; /* piston_y is the edge along the up axis in every cell */
    int walls;                     /* number of walls, in the order of SP_BOTTOM .. SP_BACK; PISTON: bottom and top */
    double wall_force[MOST_WALLS]; /* last normal force on each wall */
    double *wall_ft[MOST_WALLS];   /* [n][dim-1] elastic tangential force on grains at each wall; see wall_frame */
    double *wall_u[MOST_WALLS];    /* [n][dim] averaged relative velocity at each wall, along it and across */
    double *wall_past[MOST_WALLS]; /* [n][at.past] their history; NULL without */
    wall_list wall[MOST_WALLS];
    pair_list outer, inner;
    pair_list spare; /* memory for the next outer list */
    force_rows rows;
    double r_max, m_min;
    double scale;                          /* the power of two nearest to the mean diameter */
    double outer_gap, inner_gap;           /* pairs are listed up to these gaps */
    double outer_travel, inner_travel;     /* bounds of the relative displacement since the lists were built */
    double outer_strain;                   /* part of outer_travel due to the strain */
    double *listed;                        /* [n][dim] positions when the outer list was built */
    double listed_edge[3], listed_tilt[3]; /* and the cell at that time */
    double v_max; /* largest speed of a grain or the piston, or that the strain of an affine cell gives a pair */
    double rate;  /* last largest sum of sqrt(m_eff k_n)/m over the contacts of a grain; 1/5 of the largest viscous rate
                     at critical damping (measured, within 5%) */
    double k_max; /* reference code: largest stiffness */
    double piston_k; /* sum of the stiffnesses that act on the piston */
    double single;   /* largest rate of a grain in one of its contacts alone, times SINGLE_CONTACT; of use with lag */
    double drag;     /* rate of the global damping; 0 at first */
    /* Dashpots feel u in place of the relative velocity v of a contact; in each step u = v + lag (u - v), from u = v
     * where it closes. 0: u = v. Longer steps are stable (piston.c). */
    double lag;
    int32_t sparing; /* drag spares loose grains that gain speed (only where dashpots lag) */
    double dt;       /* length of the last step */
    int64_t rebuilds, refills;
    cells cells;   /* of the outer list */
    sp_pool *pool; /* threads; may be NULL */
} dynamics;

static inline grain_layout grain_layout_of(int dim) {
    static const grain_layout plane = {
        .stride = 8, .v = 2, .w = 4, .r = 5, .inv_m = 6, .type = 7, .row = 4, .turn = 2, .forces = 1};
    static const grain_layout space = {
        .stride = 16, .v = 4, .w = 8, .r = 12, .inv_m = 13, .type = 15, .row = 8, .turn = 4, .forces = 3};
    return dim == 3 ? space : plane;
}

static inline double *dynamics_grain(const dynamics *d, int32_t i) { return d->g + (int64_t)d->at.stride * i; }
static inline int dynamics_type(const dynamics *d, int32_t i) { return (int)dynamics_grain(d, i)[d->at.type]; }
/* The law of a pair, and of a grain at a wall. */
static inline const contact_rule *dynamics_rule(const dynamics *d, int32_t i, int32_t j) {
    return &d->law.pair[dynamics_type(d, i)][dynamics_type(d, j)];
}
static inline const contact_rule *dynamics_wall_rule(const dynamics *d, int32_t i) {
    return &d->law.wall[dynamics_type(d, i)];
}
static inline double dynamics_radius(const dynamics *d, int32_t i) { return dynamics_grain(d, i)[d->at.r]; }

/* Numbers of a pair that outlast a rebuild of the lists, from ft on. */
static inline int dynamics_kept(const dynamics *d) { return d->at.forces + d->at.past + d->at.averaged; }

/* Edge of the cell along an axis: a period, or the distance of its walls. */
static inline double dynamics_edge(const dynamics *d, int axis) {
    return axis == d->dim - 1 ? d->piston_y : d->period[axis];
}
/* The cell as a packing without grains, for packing/geometry.h. */
sp_packing sp_dynamics_cell(const dynamics *d);

/* The axis across wall 0 .. walls - 1, the sign of its outer normal, and the axes along it. With these, in this order,
 * (along, normal) is right-handed in 3D; wall_ft holds components along them. */
typedef struct wall_frame {
    int axis, along[2];
    double sign;
} wall_frame;
static inline wall_frame dynamics_wall(const dynamics *d, int side) {
    const int axis = side < 2 ? d->dim - 1 : side / 2 - 1;
    wall_frame f = {.axis = axis, .along = {(axis + 1) % 3, (axis + 2) % 3}, .sign = side % 2 ? 1 : -1};
    if (d->dim == 2)
        f.along[0] = f.along[1] = 1 - axis;
    return f;
}
/* Distance from the centre of a grain to a wall. */
static inline double dynamics_wall_distance(const dynamics *d, int side, const double *g) {
    const int axis = side < 2 ? d->dim - 1 : side / 2 - 1;
    return side % 2 ? dynamics_edge(d, axis) - g[axis] : g[axis];
}

/* Whether a pair of block b of a list may belong to one of the grains [first, last). Only with a pool. */
static inline bool sp_rows_may_touch(const pair_list *p, int32_t b, int32_t first, int32_t last) {
    return !p->span || (p->span[2 * (int64_t)b] < last && p->span[2 * (int64_t)b + 1] >= first);
}

/* The list that holds the current tangential forces. */
static inline const pair_list *dynamics_pairs(const dynamics *d) { return d->plain ? &d->outer : &d->inner; }

/* Creates grains at rest at x [n][3] with radii r, in the spec's cell with this edge along the up axis. Its lattice
 * vectors have no tilt. SP_ENOMEM. */
sp_status sp_dynamics_make(const sp_pack_spec *spec, const double *r, const double *x, double height, dynamics *out,
                           sp_error *err);
void sp_dynamics_free(dynamics *d);
/* Gives the grains their types, and the masses of these; type NULL: those that they have. */
void sp_dynamics_set_types(dynamics *d, const sp_pack_spec *spec, const int32_t *type);

/* Computes the forces at the current positions and velocities. Tangential springs stretch by the relative velocity
 * times dt_past, the length of the last step. The lists must be up to date. */
void sp_dynamics_forces(dynamics *d, double dt_past);
/* Advances velocities and positions by dt (leapfrog: velocities lag half a step behind positions). */
void sp_dynamics_advance(dynamics *d, double dt);

/* Last force on a grain, and torque/R (2D: turn[0]). */
void sp_dynamics_force_on(const dynamics *d, int32_t i, double force[3], double turn[3]);
/* Mean elastic pressure along the horizontal axis a (0 or 1): sum of F_a r_a over the pairs, divided by the volume. */
double sp_dynamics_lateral_pressure(const dynamics *d, int a);
/* Mean elastic stress: sum of F_a r_b over the contacts, walls included, divided by the volume; compression is
 * positive. Order: xx yy zz yz xz xy; 0 on unused axes, and xy in [5] also in 2D. The lists must be up to date. */
void sp_dynamics_stress(const dynamics *d, double stress[6]);
/* Largest acceleration of a grain (angular: times R) or the piston at the last forces, including viscous ones. Infinite
 * while the grains carry less than half of the piston's load; without a piston, of the pressure. */
double sp_dynamics_acceleration(const dynamics *d);
/* Distance from equilibrium: the largest acceleration by elastic forces and weight alone, and the difference between
 * the elastic pressure on the piston and p (0 without a piston). The lists must be up to date. SP_ENOMEM. */
sp_status sp_dynamics_residual(const dynamics *d, double *residual, double *wall_imbalance, sp_error *err);
/* Whether all numbers are finite, no grain has passed a wall, and no overlap exceeds 0.8 radii. */
bool sp_dynamics_sane(const dynamics *d);

/* ---- neighbour lists -----------------------------------------------------------------------------------------------
 */

/* Allocates a list for at least `capacity` pairs; `inner` adds the arrays of an inner list. SP_ENOMEM. */
sp_status sp_pair_list_alloc(pair_list *p, const dynamics *d, int32_t capacity, bool inner, sp_error *err);
void sp_pair_list_free(pair_list *p);
/* Rebuilds the outer list with all pairs closer than the gap, and keeps the tangential forces. SP_ENOMEM. */
sp_status sp_pairs_rebuild(dynamics *d, double gap, sp_error *err);

/* Tangential force on i of a pair (2D: ft[0] along (-ny, nx), and its history behind it). */
typedef struct pair_force {
    int32_t i, j;
    double ft[1 + MINDLIN_NUMBERS + 3];
} pair_force;
/* Sets the tangential forces of a new dynamics, before its lists are first built. Each pair at most once, in either
 * order. SP_ENOMEM. */
sp_status sp_pairs_set_forces(dynamics *d, const pair_force *force, int32_t count, sp_error *err);
/* Copies the tangential forces of the inner list to the outer one; _part: a thread's part of them. */
void sp_pairs_store_forces(dynamics *d);
void sp_pairs_store_part(dynamics *d, int part, int parts);

/* Rebuilds the lists if grains may have moved too far. SP_ENOMEM. */
sp_status sp_neighbours_refresh(dynamics *d, sp_error *err);
/* Smallest period for which a pair cannot touch through both sides of the box; only one of these contacts would be
 * listed. */
double sp_neighbours_narrowest(const dynamics *d);

/* ---- the cell and its deformation ------------------------------------------------------------------------------ */

/* A deforming cell carries its grains and walls along: x' = v + L x with the velocity gradient L of strain_rate and
 * shear_rate, which is upper triangular, so that lattice vectors keep their form (sp_packing.tilt). v is the velocity
 * beyond that. Contacts feel the difference of v + L x between the two grains. */

/* Moves the walls and lattice vectors by dt. Returns a bound of the speed at which the strain alone moves two grains
 * that may touch. */
double sp_deform_cell(dynamics *d, double dt);
/* Brings the tilts to at most half of the edges, by other lattice vectors of the same lattice. The images of listed
 * pairs are not valid after this. */
void sp_deform_reduce(dynamics *d);
/* Elastic normal force of grains i and j. */
double sp_dynamics_normal(const dynamics *d, int32_t i, int32_t j, double overlap);
/* Keeps the cell in which the outer list is made, and carries a point along from this cell to the present one. */
void sp_deform_keep(dynamics *d);
void sp_deform_carry(const dynamics *d, double x[3]);
/* The boxes that `cells` divides: distances of opposite faces of the cell, and where a grain lies in it. Returns x
 * itself unless the cell may be tilted. */
void sp_deform_box(const dynamics *d, double box[3]);
const double *sp_deform_place(const dynamics *d, const double *x, double place[3]);

#endif
