#ifndef SP_REVERSE_H
#define SP_REVERSE_H
/* The recurrence of a signal run backwards together with its adjoint, which gives the derivatives of a functional
 * J = sum_k C_k b^T P_k a of its moments.
 *
 * Forwards, the doubled pass of a signal has A_k = P_k M^-1 a and B_k = T_k M^-1 b, and each step two moments. So
 *
 *   J = sum_k E_k B_k.M A_(k-1) + D_k B_k.M A_k.
 *
 * Backwards, A and B come from the same three-term recurrence, and the adjoint vectors from
 *
 *   alpha_k = D_k B_k + E_(k+1) B_(k+1) + 2 X alpha_(k+1) - alpha_(k+2),
 *   beta_k  = D_k A_k + E_k A_(k-1)     + 2 X beta_(k+1)  - beta_(k+2).
 *
 * One product with K serves a field and its adjoint, which are the two lanes of a vector. A spring's stiffness has the
 * derivative dJ = -(4/Omega^2) sum_k (alpha_(k+1).dK A_k + beta_(k+1).dK B_k). */

#include "base/pool.h"
#include "sensitivity/forward.h"
#include "sensitivity/reverse_rows.h"

/* Two lanes: a field and its adjoint. */
typedef struct reverse_pair {
    double *u, *v, *next; /* [n + 1][row] */
    int lane;             /* of the field; the adjoint has the other one */
    const int32_t *since; /* [blocks] first k with the field in this block */
    bool second;          /* the field is of the second kind (W): its first step is a whole one */
} reverse_pair;

typedef struct reverse {
    const sp_operator *op;
    const sp_network *net;
    sp_pool *pool;
    double omega;
    bool whole, masses;
    reverse_pair of[2]; /* A with alpha in lanes 0 and 1, B with beta in lanes 1 and 0 */
    int64_t *first;     /* [chunks + 1] first quad of springs of each chunk (reverse_rows.h) */
    double *quads;
    int32_t *index; /* [quads][4] the spring in the network; -1 for those that fill up a quad */
    int width;
    double *sums;    /* [quads][width][4][2] sums of products */
    double *weight;  /* [n][2 kinds] masses and 4/(Omega^2 m) as in signal/recurrence.h */
    double *force;   /* [threads][rows of the largest block][row] */
    double *density; /* [n + 1][row/2] masses: sums for dJ/dm of each component */
    int32_t *active, n_active;
    int64_t k;    /* of the step: from k to k - 1 */
    double rough; /* sum of |adjoint| |field| over the steps taken, weighted with the errors of k steps */
    reverse_step step;
} reverse;

/* What a functional asks of the run, and what it gives. */
typedef struct reverse_work {
    int64_t last;
    double *d, *e;                       /* [last + 2] D_k and E_k for k <= last; they are 0 beyond */
    double *of[2];                       /* [dofs] the derivatives of J by A_0 and B_0 in the metric of the masses */
    double *first[2];                    /* [dofs] A_0 and B_0, over the network */
    double *one[2], *two[2], *x, *added; /* [dofs] scratch */
    double *memory;                      /* of all arrays */
} reverse_work;

/* whole, masses: as in sp_products. The forward pass must outlive it. */
sp_status sp_reverse_make(const forward *f, bool whole, bool masses, int threads, reverse *out, sp_error *err);
void sp_reverse_free(reverse *r);
/* Sums of products of a spring, [width], given its place in the quads. */
void sp_reverse_products(const reverse *r, int64_t place, double *out);
/* Starts behind step m of a doubled pass with its vectors u and v (lane 0: A, lane 1: B), and runs from k = m - 1 to 0.
 */
void sp_reverse_run(reverse *r, const struct snapshot *from, const reverse_work *w);

#endif
