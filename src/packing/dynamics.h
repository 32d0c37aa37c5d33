#ifndef SP_DYNAMICS_H
#define SP_DYNAMICS_H
/* The motion of grains under a piston in 2D: state, neighbour lists, forces and one time step. The protocol that makes
 * a packing of it is in piston.c. */

#include <sonopack/packing.h>
#include <stdbool.h>
#include <stdint.h>

/* One grain, one cache line: what a contact reads of it lies together. */
typedef struct grain {
    double x, y, vx, vy; /* centre (x not wrapped between list rebuilds) and velocity */
    double w;            /* R times angular velocity */
    double r, inv_m, pad;
} grain;

/* Force on a grain: components, and the sum of tangential forces, which turns it: R x torque = R^2 t. */
typedef struct grain_force {
    double x, y, t, pad;
} grain_force;

/* Pairs that may touch. Two of these exist: `outer`, from cells, with all pairs closer than a wide gap, which keeps the
 * tangential forces; and `inner`, the few of them that can touch within the next steps, on which the kernel works. */
typedef struct pair_list {
    int32_t n, capacity;
    int32_t *i, *j;
    int32_t *from; /* inner: place in outer */
    double *shift; /* added to x_j - x_i: the periodic image */
    double *reach; /* R_i + R_j */
    double *e;     /* E12 sqrt(R12) */
    double *c;     /* 2 zeta sqrt(m_eff) */
    double *ft;    /* elastic tangential force on i along (-ny, nx) */
    double *d;     /* scratch, 4 a pair: x, y, vx, vy of j minus those of i */
    double *spin;  /* scratch: w_i + w_j */
    double *f;     /* scratch: fx of all pairs, then fy, then t (capacity each) */
    double *kn;    /* scratch: normal stiffness, 0 if open */
} pair_list;

/* Grains near a wall, in the order of their numbers. ft lives with the grain: walls[side][i]. */
typedef struct wall_list {
    int32_t n;
    int32_t *i;
} wall_list;

/* Contact parameters of a run. */
typedef struct contact_law {
    double friction, eta, sqrt_eta, damping;
    bool limit_viscous; /* Coulomb limits the viscous tangential force too (end of the preparation) */
} contact_law;

typedef struct dynamics {
    int32_t n;
    double width, area, pressure;
    contact_law law;
    grain *g;
    grain_force *f;
    double piston_y, piston_v, piston_mass;
    double wall_force[2]; /* total force on bottom and top wall, last evaluation */
    double *wall_ft[2];   /* [n] elastic tangential force at the bottom and top wall */
    wall_list wall[2];
    pair_list outer, inner;
    double outer_gap, inner_gap;       /* gaps up to which pairs are listed */
    double outer_travel, inner_travel; /* bound of relative displacement since the lists were made */
    double v_max;                      /* largest speed of a grain or the piston */
    double k_max, m_min;               /* largest stiffness at the last evaluation; smallest mass */
    double piston_k;                   /* sum of the stiffnesses that carried the piston then */
    double drag;                       /* rate of the global damping, 0 at first */
    double dt;                         /* last step */
    int64_t rebuilds, refills;
    int32_t *cell_head, *cell_next; /* cells of the outer list */
    int64_t cells;
} dynamics;

/* Grains at rest at x [n][3] with radii r between walls at 0 and height. */
sp_status dynamics_make(const sp_pack_spec *spec, const double *r, const double *x, double height, dynamics *out,
                        sp_error *err);
void dynamics_free(dynamics *d);

/* Makes the lists anew where the grains may have outrun them. SP_ENOMEM. */
sp_status dynamics_refresh(dynamics *d, sp_error *err);
/* Forces at the present positions and velocities; tangential springs advance by the relative velocity times dt_past,
 * the time of the last drift. Fills f, wall_force, k_max. The lists must be fresh. */
void dynamics_forces(dynamics *d, double dt_past);
/* Kick and drift by dt with the forces above (leapfrog: velocities half a step behind positions). */
void dynamics_advance(dynamics *d, double dt);

/* Largest acceleration in the last evaluation of dynamics_forces, viscous forces included (angular: times R; the
 * piston's included); infinite as long as the grains carry less than half of the piston's load. */
double dynamics_acceleration(const dynamics *d);
/* How far from rest: largest acceleration by elastic forces alone (angular: times R; the piston's included), and the
 * difference between the elastic pressure on the piston and p. */
double dynamics_residual(dynamics *d, double *wall_imbalance);
/* Finite and nowhere absurd: no grain through a wall, no overlap above 0.8 radii. */
bool dynamics_sane(const dynamics *d);

#endif
