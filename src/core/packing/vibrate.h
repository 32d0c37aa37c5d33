#ifndef SP_VIBRATE_H
#define SP_VIBRATE_H
/* The motion of a finished packing about its rest, with the full contact law: Hertz, incremental friction with
 * Coulomb's limit, contacts that open and close, fixed walls. Forces are changes against those at rest, computed as
 * such: no small difference of large numbers, and what little the packing is off its equilibrium moves nothing. Walls
 * and periodic images may be moved, for strains. */

#include <sonopack/packing.h>

/* A pair, or a grain and a wall, that touches or may. Vectors have 3 components in every dimension. */
typedef struct touching {
    int32_t i, j;           /* j may be SP_BOTTOM or SP_TOP */
    double n0[3], n[3];     /* normal from i to j at rest and now */
    double length, overlap; /* from centre to centre, and overlap, at rest (below 0: a gap) */
    double e, m_eff;        /* E12 sqrt(R12); 1/(1/m_i + 1/m_j) */
    double arm_i, arm_j;    /* radii; 0 for a wall */
    double fn0, ft0[3];     /* elastic forces at rest; tangential: on i */
    double shift[3];        /* displacement of j's side beside that of grain j: of moving walls and periodic images */
    double kn;              /* now; 0: open */
    double held;            /* part of the tangential force that Coulomb's limit leaves; 1: the contact sticks */
    double ft[3];           /* change of the tangential elastic force on i */
    double fn;              /* change of the normal elastic force */
    double force[3];        /* change of the whole force on i */
} touching;

typedef struct vibration {
    int dim;
    int32_t n, count;
    touching *touch; /* [count]: the packing's contacts in their order, then gaps that may close */
    double *mass;    /* [n][2] mass and moment of inertia */
    double *u, *v;   /* [n][6] displacement and velocity: translation, rotation */
    double *a;       /* [n][6] acceleration */
    double *now;     /* [n][6] velocity that the dashpots see */
    double friction, eta, damping;
    bool turns;    /* grains rotate */
    bool straight; /* normals stay those at rest, and forces with them: what springs without prestress are */
    double reach;  /* gaps up to here are watched: no grain may move by more than half of it */
} vibration;

/* At rest, u = v = 0. damping: zeta of the dashpots; 0 for none. */
sp_status sp_vibration_make(const sp_packing *p, double damping, vibration *out, sp_error *err);
void sp_vibration_free(vibration *m);
/* Back to rest; the caller sets u and v afterwards and calls sp_vibration_begin. */
void sp_vibration_rest(vibration *m);
/* Forces at the u and v that were set; tangential springs are stretched by u as by one straight path. */
void sp_vibration_begin(vibration *m);
/* One step of velocity Verlet. */
void sp_vibration_step(vibration *m, double h);
/* Whether all is finite and no grain has moved farther than gaps are watched. */
bool sp_vibration_sane(const vibration *m);

#endif
