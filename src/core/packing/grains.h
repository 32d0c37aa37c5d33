#ifndef SP_GRAINS_H
#define SP_GRAINS_H
/* Data of moving grains: positions and velocities, neighbour lists, and force rows. */

#include "base/pool.h"
#include "packing/cells.h"

#include <sonopack/packing.h>
#include <stdbool.h>
#include <stdint.h>

/* Layout of a grain's data, a row of `stride` doubles (one cache line in 2D, two in 3D), so that a contact finds all of
 * it together. The position comes first (x is wrapped only when the lists are rebuilt), then the velocity. w is R times
 * the angular velocity (2D: one number). */
typedef struct grain_layout {
    int stride, v, w, r, inv_m;
    int row, turn; /* doubles of a force row, and position of its torque/R */
    int forces;    /* components of a pair's tangential force */
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
    double *image;        /* [dim-1] periods to add to x_j - x_i */
    double *reach;        /* R_i + R_j */
    double *ft;           /* elastic tangential force on i: 2D along (-ny, nx); 3D [3] */
    double *e2;           /* 2 E12 sqrt(R12) */
    double *sm;           /* sqrt(m_eff 2 E12 sqrt(R12)) */
} pair_list;

/* Grains near a wall, in ascending order. */
typedef struct wall_list {
    int32_t n;
    int32_t *i;
} wall_list;

/* Where to find the forces on each grain. There is a row for i and one for j of each pair, one for each grain at a
 * wall, and a row of zeros that fills unused slots. Rows of grains with more than SLOTS neighbours continue in a linked
 * list. */
enum { SLOTS = 6 };
typedef struct force_rows {
    int64_t capacity;
    double *row;      /* [rows][layout.row] force, torque/R (2D: fx fy t s; 3D: fx fy fz s, q, 0) */
    int32_t *slot;    /* [n][SLOTS] positions of rows */
    int32_t *count;   /* [n] number of rows */
    int32_t *further; /* [n] head of the linked list, or -1 */
    int32_t *chain;   /* [2 capacity] list nodes: position of the row, next node */
    int32_t chained;
    int32_t other, wall[2], zero; /* index of the first row of the j, of the walls, and of the zero row */
} force_rows;

/* Contact parameters. */
typedef struct contact_law {
    double friction, eta, sqrt_eta, damping;
    double viscous_limit; /* limit of the total tangential force over the Coulomb limit of its elastic part */
} contact_law;

typedef struct dynamics {
    int dim;
    grain_layout at;
    int32_t n;
    double period[2];      /* periods of the horizontal axes */
    double strain_rate[2]; /* their strain rates */
    double area, pressure;
    contact_law law;
    bool plain;      /* reference code (plain.c) */
    double *g;       /* [n + 1][stride] grains; the last one is a dummy */
    double *plain_f; /* [n][6] forces of the reference code */
    double piston_y, piston_v, piston_mass;
    double wall_force[2]; /* last normal force on the bottom and top wall */
    double *wall_ft[2];   /* [n][dim-1] elastic tangential force on grains at the bottom and top wall */
    wall_list wall[2];
    pair_list outer, inner;
    force_rows rows;
    double r_max, m_min;
    double scale;                      /* the power of two nearest to the mean diameter */
    double outer_gap, inner_gap;       /* pairs are listed up to these gaps */
    double outer_travel, inner_travel; /* bounds of the relative displacement since the lists were built */
    double outer_strain;               /* part of outer_travel due to the lateral strain */
    double *listed;                    /* [n][dim] positions when the outer list was built */
    double v_max;                      /* largest speed of a grain or the piston */
    double rate;  /* last largest sum of sqrt(m_eff k_n)/m over the contacts of a grain; 1/5 of the largest viscous rate
                     at critical damping (measured, within 5%) */
    double k_max; /* reference code: largest stiffness */
    double piston_k; /* sum of the stiffnesses that act on the piston */
    double drag;     /* rate of the global damping; 0 at first */
    bool long_steps; /* steps may be too long for the stiffest grains (see inertia.h) */
    double dt;       /* length of the last step */
    int64_t rebuilds, refills;
    cells cells;   /* of the outer list */
    sp_pool *pool; /* threads; may be NULL */
} dynamics;

static inline grain_layout grain_layout_of(int dim) {
    static const grain_layout plane = {
        .stride = 8, .v = 2, .w = 4, .r = 5, .inv_m = 6, .row = 4, .turn = 2, .forces = 1};
    static const grain_layout space = {
        .stride = 16, .v = 4, .w = 8, .r = 12, .inv_m = 13, .row = 8, .turn = 4, .forces = 3};
    return dim == 3 ? space : plane;
}

static inline double *dynamics_grain(const dynamics *d, int32_t i) { return d->g + (int64_t)d->at.stride * i; }
static inline double dynamics_radius(const dynamics *d, int32_t i) { return dynamics_grain(d, i)[d->at.r]; }

/* The list that holds the current tangential forces. */
static inline const pair_list *dynamics_pairs(const dynamics *d) { return d->plain ? &d->outer : &d->inner; }

#endif
