#ifndef SP_KRYLOV_H
#define SP_KRYLOV_H
/* Solve A x = b by preconditioned steps: conjugate gradients for a symmetric operator without negative eigenvalues,
 * which may be singular, and GMRES, preconditioned from the right, for any other. A few steps suffice if the operator
 * differs from the preconditioner by a matrix of low rank. Both start from x = 0. */

#include <sonopack/status.h>
#include <stdint.h>

/* out = operator(in), [n] each, without overlap. */
typedef void (*krylov_operator)(void *with, const double *in, double *out);

typedef struct krylov_problem {
    int64_t n;
    krylov_operator apply, precondition; /* A, and an approximate inverse of A; for sp_cg symmetric and positive */
    void *with;                          /* first argument of both functions */
    double goal;                         /* stop at |b - A x| <= goal */
    int steps_max;                       /* of GMRES also the number of basis vectors: there are no restarts */
} krylov_problem;

/* zero [n]: a direction p with p . A p <= sum zero p^2 counts as one of A's null space. Stops also where the rest of b
 * is in the null space, so that nothing can be done about it. Then and after steps_max steps x is the best found, and
 * no error. SP_ENOMEM. */
sp_status sp_cg(const krylov_problem *p, const double *zero, const double *b, double *x, sp_error *err);
/* x has the smallest residual found. *residual: |b - A x|/|b|. SP_ENOMEM. */
sp_status sp_gmres(const krylov_problem *p, const double *b, double *x, double *residual, sp_error *err);

#endif
