#ifndef SP_DYNAMICS_H
#define SP_DYNAMICS_H
/* The motion of grains under a piston in 2D and 3D: state, neighbour lists, forces and one time step. The protocol that
 * makes a packing of it is in piston.c. */

#include "base/pool.h"

#include <sonopack/packing.h>
#include <stdbool.h>
#include <stdint.h>

/* Where a grain's numbers lie in its line of `stride` doubles (one cache line in 2D, two in 3D): what a contact reads
 * of a grain lies together. Positions first (x not wrapped between list rebuilds), then velocities; w is R times the
 * angular velocity (2D: one number). */
typedef struct grain_layout {
    int stride, v, w, r, inv_m;
    int row, turn; /* doubles of a row of forces, and where its turning force begins */
    int forces;    /* numbers of a pair's tangential force */
} grain_layout;

/* Pairs that may touch. Two of these exist: `outer`, from cells, with all pairs closer than a wide gap, which keeps the
 * tangential forces; and `inner`, the few of them that can touch within the next steps, on which the kernel works.
 * Arrays with more than one number a pair are planes of `capacity` numbers each. */
typedef struct pair_list {
    int32_t n, capacity;
    int32_t padded; /* inner: n and as many pairs that never touch as fill whole vectors */
    int32_t *i, *j;
    int32_t *at_i, *at_j; /* inner: where their lines of numbers begin */
    int32_t *from;        /* inner: place in outer */
    double *image;        /* [dim-1] periods to be added to x_j - x_i */
    double *reach;        /* R_i + R_j */
    double *ft;           /* elastic tangential force on i: 2D along (-ny, nx), 3D [3] */
    double *e2;           /* 2 E12 sqrt(R12) */
    double *sm;           /* sqrt(m_eff 2 E12 sqrt(R12)) */
} pair_list;

/* Grains near a wall, in the order of their numbers. */
typedef struct wall_list {
    int32_t n;
    int32_t *i;
} wall_list;

/* Where the forces on each grain are found: rows of the pair's (i, then j further down), the walls' rows, and a row of
 * zeros that fills up. Grains with more than SLOTS neighbours have the rest in a chain. */
enum { SLOTS = 6 };
typedef struct force_rows {
    int64_t capacity;
    double *row;      /* [rows][layout.row]: force, turning force (2D: fx fy t s; 3D: fx fy fz s, q, 0) */
    int32_t *slot;    /* [n][SLOTS] where rows begin */
    int32_t *count;   /* [n] rows of this grain */
    int32_t *further; /* [n] head of the chain, -1 */
    int32_t *chain;   /* [2 capacity] pairs (where the row begins, next) */
    int32_t chained;
    int32_t other, wall[2], zero; /* where the rows of the j, of the walls, and the row of zeros are */
} force_rows;

/* Contact parameters of a run. */
typedef struct contact_law {
    double friction, eta, sqrt_eta, damping;
    double viscous_limit; /* Coulomb's limit of the whole tangential force over that of its elastic part */
} contact_law;

typedef struct dynamics {
    int dim;
    grain_layout at;
    int32_t n;
    double side[2];      /* periods */
    double side_rate[2]; /* their relative rates of change */
    double area, pressure;
    contact_law law;
    bool plain;      /* the reference path: all pairs near, one at a time, no tricks (plain.c) */
    double *g;       /* [n + 1][stride]: the last one is nowhere */
    double *plain_f; /* [n][6] forces of the plain path */
    double piston_y, piston_v, piston_mass;
    double wall_force[2]; /* total force on bottom and top wall, last evaluation */
    double *wall_ft[2];   /* [n][dim-1] elastic tangential force on the grain at the bottom and top wall */
    wall_list wall[2];
    pair_list outer, inner;
    force_rows rows;
    double r_max, m_min;
    double scale;                      /* of the grains: the power of two that is nearest to their mean diameter */
    double outer_gap, inner_gap;       /* gaps up to which pairs are listed */
    double outer_travel, inner_travel; /* bound of relative displacement since the lists were made */
    double outer_strain;               /* the part of it by the sides' motion */
    double *listed;                    /* [n][dim] where the grains were when the outer list was made */
    double v_max;                      /* largest speed of a grain or the piston */
    double rate;     /* largest sum of sqrt(m_eff k_n)/m over the contacts of a grain, last step: 1/5 of the largest
                        eigenvalue of the contacts' viscous rates at critical damping (measured within 5%) */
    double k_max;    /* plain path: largest stiffness */
    double piston_k; /* sum of the stiffnesses that carried the piston then */
    double drag;     /* rate of the global damping, 0 at first */
    double dt;       /* last step */
    int64_t rebuilds, refills;
    int32_t *cell_head, *cell_next; /* cells of the outer list */
    int64_t cells;
    sp_pool *pool; /* may be NULL */
} dynamics;

grain_layout sp_dynamics_layout(int dim);

/* Grains at rest at x [n][3] with radii r between walls at 0 and height. */
sp_status sp_dynamics_make(const sp_pack_spec *spec, const double *r, const double *x, double height, dynamics *out,
                           sp_error *err);
void sp_dynamics_free(dynamics *d);

static inline double *dynamics_grain(const dynamics *d, int32_t i) { return d->g + (int64_t)d->at.stride * i; }
static inline double dynamics_radius(const dynamics *d, int32_t i) { return dynamics_grain(d, i)[d->at.r]; }

/* The list that holds the tangential forces. */
static inline const pair_list *dynamics_pairs(const dynamics *d) { return d->plain ? &d->outer : &d->inner; }

/* Makes the lists anew where the grains may have outrun them. SP_ENOMEM. */
sp_status sp_dynamics_refresh(dynamics *d, sp_error *err);
/* Forces at the present positions and velocities; tangential springs advance by the relative velocity times dt_past,
 * the time of the last drift. The lists must be fresh. */
void sp_dynamics_forces(dynamics *d, double dt_past);
/* Kick and drift by dt with the forces above (leapfrog: velocities half a step behind positions). */
void sp_dynamics_advance(dynamics *d, double dt);

/* The force on a grain in the last evaluation, and its turning force (torque/R; 2D: turn[0]). */
void sp_dynamics_force_on(const dynamics *d, int32_t i, double force[3], double turn[3]);
/* Mean pressure on the sides along axis a (0 or 1) by the contacts' elastic forces: sum of F_a r_a over the volume. */
double sp_dynamics_side_pressure(const dynamics *d, int a);
/* Largest acceleration in the last evaluation of sp_dynamics_forces, viscous forces included (angular: times R; the
 * piston's included); infinite as long as the grains carry less than half of the piston's load. */
double sp_dynamics_acceleration(const dynamics *d);
/* How far from rest: largest acceleration by elastic forces alone (angular: times R; the piston's included), and the
 * difference between the elastic pressure on the piston and p. Needs fresh lists. SP_ENOMEM. */
sp_status sp_dynamics_residual(const dynamics *d, double *residual, double *wall_imbalance, sp_error *err);
/* Finite and nowhere absurd: no grain through a wall, no overlap above 0.8 radii. */
bool sp_dynamics_sane(const dynamics *d);
/* Sides nearer to each other than this would let two grains touch through both, of which one is listed. */
double sp_dynamics_narrowest(const dynamics *d);

#endif
