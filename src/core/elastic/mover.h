#ifndef SP_MOVER_H
#define SP_MOVER_H
/* What the files of rigid motions share. */

#include "elastic/rigid.h"
#include "linalg/ldl.h"

#include <math.h>

enum { LANES = SP_LDL_LANES };

typedef struct mover {
    sp_rigid *r;
    sp_network net; /* springs of stiffness 1 between grains and walls, which are grains behind the others */
    int32_t *row;   /* [n springs] of each of them its spring in r->net */
    sp_sparse k;
    sp_ldl *factor;
    double top;    /* the size of B^T B */
    double *v, *x; /* [LANES][dofs] random motions; solutions */
    double *force; /* [LANES][springs][MOST] random forces of the rows */
    bool *point;   /* [n] grains whose rotation nothing holds, so that they are points */
    int32_t *up;   /* union-find of grains and walls, then contacts */
} mover;

/* The random motion of a grain or wall. */
static inline const double *sp_mover_motion(const mover *m, int lane, int32_t i) {
    return m->v + ((int64_t)lane * m->net.n + i) * m->net.dof;
}

/* Whether a difference of random motions, whose grains move by about 1, or of forces, is 0 but for rounding. squares: a
 * sum over all vectors. */
static inline bool sp_mover_none(mover *m, double squares) {
    const double nothing = 2e-6, size = sqrt(squares / LANES);
    if (size <= nothing)
        m->r->equal = fmax(m->r->equal, size);
    else
        m->r->apart = fmin(m->r->apart, size);
    return size <= nothing;
}

/* Labels of contacts: of grains with spins and of disks, whose contacts have one cluster each; ... */
sp_status sp_mover_bodies(mover *m, sp_error *err);
/* ... and of smooth spheres, where a contact may be the hinge of several. */
sp_status sp_mover_hinges(mover *m, sp_error *err);

#endif
