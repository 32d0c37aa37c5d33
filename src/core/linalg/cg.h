#ifndef SP_CG_H
#define SP_CG_H
/* Solves A x = b for a symmetric operator without negative eigenvalues, which may be singular, by preconditioned
 * conjugate gradients. */

#include <sonopack/status.h>
#include <stdint.h>

/* out = operator(in), [n] each, without overlap. */
typedef sp_status (*cg_operator)(void *with, const double *in, double *out, sp_error *err);

typedef struct cg_problem {
    int64_t n;
    cg_operator apply, precondition; /* A, and an approximate inverse of A, symmetric and positive definite */
    void *with;                      /* first argument of both functions */
    const double *zero; /* [n] a direction p with p . A p <= sum zero p^2 counts as one of A's null space */
    double goal;        /* stop at |b - A x| <= goal */
    int steps_max;
} cg_problem;
/* Starts from x = 0. Stops also where the rest of b is in the null space, so that nothing can be done about it. Then
 * and after steps_max steps x is the best found, and no error. SP_ENOMEM, and the errors of the operators. */
sp_status sp_cg(const cg_problem *p, const double *b, double *x, sp_error *err);

#endif
