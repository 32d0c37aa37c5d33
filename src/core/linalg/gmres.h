#ifndef SP_GMRES_H
#define SP_GMRES_H
/* A x = b for an operator that need not be symmetric, by GMRES with a preconditioner from the right. Few steps suffice
 * where the operator differs from the preconditioner by a matrix of low rank. */

#include <sonopack/status.h>
#include <stdint.h>

/* out = operator(in), [n] each, which do not overlap. */
typedef sp_status (*gmres_operator)(void *with, const double *in, double *out, sp_error *err);

typedef struct gmres_problem {
    int64_t n;
    gmres_operator apply, precondition; /* A, and an approximate inverse of it */
    void *with;                         /* first argument of both */
    double tolerance;                   /* |b - A x| over |b| that is aimed at */
    int steps_max;                      /* no restarts: as many vectors are kept */
} gmres_problem;
/* The x of least residual that was reached, from x = 0; `residual` (over |b|) tells how far that is. */
sp_status sp_gmres(const gmres_problem *p, const double *b, double *x, double *residual, sp_error *err);

#endif
