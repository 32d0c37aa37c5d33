#ifndef SP_GMRES_H
#define SP_GMRES_H
/* Solves A x = b for a nonsymmetric operator by GMRES, preconditioned from the right. A few steps suffice if the
 * operator differs from the preconditioner by a matrix of low rank. */

#include <sonopack/status.h>
#include <stdint.h>

/* out = operator(in), [n] each, without overlap. */
typedef sp_status (*gmres_operator)(void *with, const double *in, double *out, sp_error *err);

typedef struct gmres_problem {
    int64_t n;
    gmres_operator apply, precondition; /* A, and an approximate inverse of A */
    void *with;                         /* first argument of both functions */
    double tolerance;                   /* stop at |b - A x| <= tolerance |b| */
    int steps_max;                      /* number of basis vectors; there are no restarts */
} gmres_problem;
/* Starts from x = 0 and returns the x with the smallest residual found. *residual: |b - A x|/|b|. */
sp_status sp_gmres(const gmres_problem *p, const double *b, double *x, double *residual, sp_error *err);

#endif
