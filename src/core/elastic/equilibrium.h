#ifndef SP_EQUILIBRIUM_H
#define SP_EQUILIBRIUM_H
/* Solves K u = f for the displacements of grains between fixed walls, with all or some degrees of freedom free. A
 * symmetric K is factored by Cholesky, a nonsymmetric one by LU, which also solves with K^T. */

#include "elastic/stiffness.h"
#include "linalg/cholesky.h"
#include "linalg/lu.h"

/* How K is made invertible where parts of the network are floppy. The shift is so small that refinement removes its
 * effect. */
typedef enum equilibrium_shift {
    SHIFT_NONE = 0,
    SHIFT_DIAGONAL, /* adds a fraction of the diagonal; for loads that consist of spring forces */
    SHIFT_MASS      /* adds a multiple of M; other loads then accelerate floppy parts */
} equilibrium_shift;

/* Shift of a nonsymmetric K. Since forces at rest do not balance exactly, a free spin has a small stiffness of either
 * sign and a small load. The shift must be well above that stiffness, or the spin would be a hundred times the
 * strain. */
#define SHIFT_NONSYMMETRIC 1e-6

typedef struct sp_equilibrium {
    const sp_network *net;
    sp_sparse k;       /* K itself: the lower triangle, or all entries if K is not symmetric */
    int64_t *diagonal; /* [count] position of each diagonal entry in k.x */
    sp_cholesky *factor;
    sp_lu *lu;        /* nonsymmetric K only; else NULL */
    double *factored; /* nonsymmetric K only: values of the matrix that lu factored; its pattern is that of k */
    bool transposed;  /* solve K^T u = f; set by the caller, false */
    equilibrium_shift shift_kind;
    double shift;       /* the fraction of the diagonal, or multiple of M, that was added */
    bool slips;         /* neither wall has friction: the whole network can move sideways */
    bool grips;         /* both walls have friction */
    int64_t count;      /* number of free degrees of freedom */
    int64_t *free_dofs; /* [count] the free degrees of freedom, ascending; NULL: all */
    double *work;       /* scratch: [2][dofs], then [2][count] */
} sp_equilibrium;

sp_equilibrium sp_equilibrium_none(void);
/* SP_EREFUSED if a wall has no springs, if no chain of springs leads from wall to wall, and if the network is unstable.
 */
sp_status sp_equilibrium_make(const sp_network *net, sp_equilibrium *out, sp_error *err);
/* Factors the same floppy K again with this shift; 0: the smallest that serves. */
sp_status sp_equilibrium_shift(sp_equilibrium *e, equilibrium_shift kind, double fraction, sp_error *err);
/* A system in which only the degrees of freedom with fixed[] = 0 are free; fixed [dofs]. */
sp_status sp_equilibrium_restrict(const sp_equilibrium *e, const uint8_t *fixed, sp_equilibrium *out, sp_error *err);
void sp_equilibrium_free(sp_equilibrium *e);

/* x = F^-1 b, where F is the factored matrix; [count] each. */
sp_status sp_equilibrium_apply(const sp_equilibrium *e, const double *b, double *x, sp_error *err);
/* Changes u so that K u = f. On entry u may be anything; fixed degrees of freedom keep their values. Refines until the
 * residual |K u - f| over the free degrees of freedom no longer falls: one step without a shift, a few steps with one.
 * *residual: its last value. */
sp_status sp_equilibrium_solve(sp_equilibrium *e, const double *f, double *u, double *residual, sp_error *err);
/* Residual vector f - K u, 0 where fixed; returns its norm. */
double sp_equilibrium_residual(sp_equilibrium *e, const double *f, const double *u, double *rest);

#endif
