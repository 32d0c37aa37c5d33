#ifndef SP_VIBRATE_H
#define SP_VIBRATE_H
/* Nonlinear motion of a finished packing about its rest state: Hertz's law, incremental friction with Coulomb's limit,
 * contacts that open and close, fixed walls. Forces are computed as changes from those at rest, without differences of
 * large numbers, so the small residual forces of the packing have no effect. Walls and periodic images can be displaced
 * to impose strains. */

#include <sonopack/network.h>
#include <sonopack/packing.h>

/* A pair, or a grain and a wall, that touches or may touch. Vectors have 3 components in every dimension. */
typedef struct touching {
    int32_t i, j;           /* j may be a wall */
    double n0[3], n[3];     /* normal from i to j, at rest and now */
    double length, overlap; /* distance of the centres and overlap at rest; a negative overlap is a gap */
    double e, m_eff;        /* E12 sqrt(R12); 1/(1/m_i + 1/m_j) */
    double arm_i, arm_j;    /* radii; 0 for a wall */
    double fn0, ft0[3];     /* elastic forces at rest; the tangential one on i */
    double shift[3];        /* displacement of the wall or periodic image at j, besides that of grain j */
    double kn;              /* current normal stiffness; 0: open */
    double held;            /* factor by which Coulomb's limit reduced the tangential force; 1: no sliding */
    double ft[3];           /* change of the tangential elastic force on i */
    double fn;              /* change of the normal elastic force */
    double force[3];        /* change of the whole force on i */
} touching;

/* Work at the tangential spring of a contact since rest, for balances of energy. */
typedef struct spring_work {
    double whole;   /* integral of (ft0 + ft) . ds over the tangential displacement s at the contact */
    double slid;    /* the part of it that was rubbed away: the integral over the sliding */
    double carried; /* integral of ft0 . ds without the sliding */
} spring_work;

typedef struct vibration {
    int dim;
    int32_t n, count;
    touching *touch; /* [count] contacts of the packing in its order, then gaps that may close */
    double *mass;    /* [n][2] mass and moment of inertia */
    double *u, *v;   /* [n][6] displacement and velocity: translations, then rotations */
    double *a;       /* [n][6] acceleration */
    double *now;     /* [n][6] velocity at the dashpots */
    double friction, eta, damping;
    sp_damping_kind damping_kind; /* ZETA at first; of another kind damping is its value, as for networks */
    double damping_ratio;         /* c_t/c_n of the other kinds */
    bool turns;                   /* grains can rotate */
    bool straight;                /* normals stay fixed, as for springs without prestress */
    spring_work *work; /* [count] is kept if it is not NULL, for which the owner provides and frees the memory */
    double reach;      /* gaps up to this width are watched; no grain may move by more than half of it */
} vibration;

/* Creates a packing at rest, u = v = 0. damping: zeta of the dashpots, 0 for none. SP_ENOMEM. */
sp_status sp_vibration_make(const sp_packing *p, double damping, vibration *out, sp_error *err);
/* The same with gaps watched up to `radii` times the smallest radius instead of 0.4: grains may move farther, and more
 * pairs take more time. Without a wall the gaps must stay below a quarter of the period. */
sp_status sp_vibration_make_wide(const sp_packing *p, double damping, double radii, vibration *out, sp_error *err);
void sp_vibration_free(vibration *m);
/* Returns to rest. The caller then sets u and v and calls sp_vibration_begin. */
void sp_vibration_rest(vibration *m);
/* Computes the forces for given u and v. Tangential springs stretch as along a straight path to u. */
void sp_vibration_begin(vibration *m);
/* One step h of velocity Verlet. */
void sp_vibration_step(vibration *m, double h);
/* Whether all numbers are finite and no grain has moved farther than `reach` allows. */
bool sp_vibration_sane(const vibration *m);

#endif
