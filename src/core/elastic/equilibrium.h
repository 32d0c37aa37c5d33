#ifndef SP_EQUILIBRIUM_H
#define SP_EQUILIBRIUM_H
/* Solves K u = f for the displacements of grains between fixed walls or in a periodic cell, with all or some degrees of
 * freedom free. The symmetric part of K is factored by Cholesky, with a shift where parts of the network are floppy. If
 * that is not K itself, it preconditions GMRES, which also solves with K^T. */

#include "linalg/ldl.h"

/* What is added to a singular K before it is factored. It changes the way to the solution, not the solution. */
typedef enum equilibrium_shift {
    SHIFT_NONE = 0,
    SHIFT_DIAGONAL, /* a fraction of the diagonal */
    SHIFT_MASS      /* a multiple of M, which tells what a load does to floppy parts */
} equilibrium_shift;

/* A free rotation of a sphere with two contacts, under prestress and friction. Its only stiffness is due to the
 * imbalance of the forces at rest, which says nothing of the material. Springs of their own hold such spheres: push
 * push^T is added to K. Nothing loads them, so they have no effect but to choose the rotation. */
typedef struct equilibrium_spin {
    int64_t column;   /* of the first degree of freedom that takes part */
    int width;        /* 6, or 3 if the sphere's centre is fixed on the axis */
    double motion[6]; /* a rotation of 1 */
    double push[6];
} equilibrium_spin;

typedef struct sp_equilibrium {
    const sp_network *net;
    sp_sparse k; /* symmetric part of K: the lower triangle, the diagonal entry of each column first */
    sp_ldl *factor;
    bool transposed; /* whether K^T replaces K in a solve */
    equilibrium_shift shift_kind;
    double shift;       /* the fraction of the diagonal, or multiple of M, that was added */
    double lift;        /* a further multiple of M, where the symmetric part of K is indefinite */
    bool slips;         /* neither wall has friction: the whole network can move sideways */
    bool grips;         /* both walls have friction, or all sides of the cell take part in a strain */
    int loose;          /* the whole network can move along this many of the first axes */
    int64_t count;      /* number of free degrees of freedom */
    int64_t *free_dofs; /* [count] the free degrees of freedom, ascending; NULL: all */
    int32_t spins;
    bool weighed;           /* whether masses weigh them */
    equilibrium_spin *spin; /* [spins] */
    double *work;           /* scratch: [2][dofs], then [5][count] */
} sp_equilibrium;

sp_equilibrium sp_equilibrium_none(void);
/* SP_EREFUSED if the bottom or top wall has no springs, if no chain of springs leads from wall to wall, and if the
 * network is unstable.
 */
sp_status sp_equilibrium_make(const sp_network *net, sp_equilibrium *out, sp_error *err);
/* Factors the same floppy K again with this shift; 0: the smallest that serves. */
sp_status sp_equilibrium_shift(sp_equilibrium *e, equilibrium_shift kind, double fraction, sp_error *err);
/* Weighs the motion of spins that are held with masses instead of K's diagonal, and factors again: no force on such a
 * sphere changes its angular momentum about the line through its contacts, which is then 0. */
sp_status sp_equilibrium_weigh_spins(sp_equilibrium *e, sp_error *err);
/* A system in which only the degrees of freedom with fixed[] = 0 are free; fixed [dofs]. */
sp_status sp_equilibrium_restrict(const sp_equilibrium *e, const uint8_t *fixed, sp_equilibrium *out, sp_error *err);
void sp_equilibrium_free(sp_equilibrium *e);

/* The degree of freedom of column c of K. */
static inline int64_t sp_equilibrium_dof(const sp_equilibrium *e, int64_t c) {
    return e->free_dofs ? e->free_dofs[c] : c;
}
/* out += factor times the springs that hold spins, applied to `in`; [count] each. */
void sp_equilibrium_add_spins(const sp_equilibrium *e, double factor, const double *in, double *out);
/* x = F^-1 b, where F is the factored matrix; [count] each. */
void sp_equilibrium_apply(const sp_equilibrium *e, const double *b, double *x);

/* Changes u so that K u = f. On entry u may be anything; fixed degrees of freedom keep their values. Ends where the
 * residual is of the size of the rounding errors of K u and f, or no longer falls. Where K is singular this u is one of
 * many solutions, or, if the load f does work on a motion that K does not resist, no solution: the residual is then the
 * part of f that does the work. scale: size of the terms that were added to f. *residual: |f - K u| over the free
 * degrees of freedom, with a thousandth of the forces on spins that are held. */
sp_status sp_equilibrium_solve(sp_equilibrium *e, const double *f, double scale, double *u, double *residual,
                               sp_error *err);
/* w = K^-T f, 0 where fixed: the change of f . u for a unit residual of K u. SP_EREFUSED if its own residual is above
 * 1e-8 of f. */
sp_status sp_equilibrium_weights(sp_equilibrium *e, const double *f, double scale, double *w, sp_error *err);
/* Residual vector f - K u, 0 where fixed; returns its norm. */
double sp_equilibrium_residual(sp_equilibrium *e, const double *f, const double *u, double *rest);
/* Sum over the spins that are held of |work| of `rest` on a unit rotation, times the larger of `least` and how far the
 * sphere moves in u. */
double sp_equilibrium_spin_work(const sp_equilibrium *e, const double *rest, double least, const double *u);
/* The residual f - K^T w, whose work that is for an energy or a stress that belongs to f; NULL if no spins are held.
 * Scratch, until the next solve. */
const double *sp_equilibrium_spin_rest(sp_equilibrium *e, const double *f, const double *w);
/* SP_EREFUSED, for a residual that is too large: `what` with the grains that have most of the residual of f and u.
 * load: size of the load, to which the residual is compared. */
sp_status sp_equilibrium_refuse(sp_equilibrium *e, const char *what, double load, const double *f, const double *u,
                                sp_error *err);

#endif
