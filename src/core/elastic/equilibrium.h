#ifndef SP_EQUILIBRIUM_H
#define SP_EQUILIBRIUM_H
/* K u = f for the displacements of grains between fixed walls, all or some of them free. A K that is not symmetric has
 * an LU factor in the place of Cholesky's, and its transposed can be solved with too. */

#include "elastic/stiffness.h"
#include "linalg/cholesky.h"
#include "linalg/lu.h"

/* What makes K invertible where parts of the network are floppy. Either is so small that refinement takes it out
 * again. */
typedef enum equilibrium_raise {
    RAISE_NONE = 0,
    RAISE_DIAGONAL, /* the diagonal by a fraction of itself: loads by spring forces, whatever the solution */
    RAISE_MASS      /* by masses: what other loads leave over are accelerations of floppy parts */
} equilibrium_raise;

/* Without symmetry a free spin is one but for forces that do not quite balance, so that it has a little stiffness, of
 * either sign, and a little load: a fraction to raise by that is well above, or it would turn a hundred times a strain.
 */
#define RAISE_LOOSE 1e-6

typedef struct sp_equilibrium {
    const sp_network *net;
    sp_sparse k;       /* K itself: its lower triangle, or all of it if it is not symmetric */
    int64_t *diagonal; /* [count] where in k.x */
    sp_cholesky *factor;
    sp_lu *lu;       /* not symmetric; else NULL */
    double *solid;   /* not symmetric: the values of the matrix that lu is the factor of; its pattern is that of k */
    bool transposed; /* K^T u = f is meant; the caller's choice, false */
    equilibrium_raise raised;
    double raise;    /* fraction of the diagonal, or so many times M, that was added */
    bool slips;      /* neither wall grips: the whole floats sideways */
    bool grips;      /* both walls do */
    int64_t count;   /* free degrees of freedom */
    int64_t *chosen; /* [count] which they are, ascending; NULL: all */
    double *work;    /* [2][dofs], and [2][count] behind */
} sp_equilibrium;

sp_equilibrium sp_equilibrium_none(void);
/* SP_EREFUSED for a network without springs at both walls, or none that lead from wall to wall, or one that is
 * unstable. */
sp_status sp_equilibrium_make(const sp_network *net, sp_equilibrium *out, sp_error *err);
/* Another factor of the same, floppy K, raised by this fraction; 0: the smallest that serves. */
sp_status sp_equilibrium_raise(sp_equilibrium *e, equilibrium_raise raise, double fraction, sp_error *err);
/* A system of those degrees of freedom alone that held[] (dofs) does not hold. */
sp_status sp_equilibrium_hold(const sp_equilibrium *e, const uint8_t *held, sp_equilibrium *out, sp_error *err);
void sp_equilibrium_free(sp_equilibrium *e);

/* x = F^-1 b with F what was factored, [count] each. */
sp_status sp_equilibrium_apply(const sp_equilibrium *e, const double *b, double *x, sp_error *err);
/* Adds to u (which may be anything but for held degrees of freedom, which keep their values) what makes K u = f, with
 * refinement until the residual |K u - f| over free degrees of freedom, which goes into *residual, stays the same: one
 * step for a factor of K itself, a few for a raised one. */
sp_status sp_equilibrium_solve(sp_equilibrium *e, const double *f, double *u, double *residual, sp_error *err);
/* rest = f - K u, 0 at what is held; its length is returned. */
double sp_equilibrium_rest(sp_equilibrium *e, const double *f, const double *u, double *rest);

#endif
