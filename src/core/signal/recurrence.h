#ifndef SP_RECURRENCE_H
#define SP_RECURRENCE_H
/* Two vectors (lanes) propagated by U_(k+1) = 2 X U_k - U_(k-1), X = 1 - 2 M^-1 K/Omega^2. The form used is U_(k+1) =
 * U_k + V_(k+1), V_(k+1) = V_k - (4/Omega^2) M^-1 K U_k, which keeps rounding errors small. */

#include "base/pool.h"
#include "network/operator.h"

/* A sparse vector over the network, or in an operator's order with the units of forces. */
typedef struct sparse_row {
    int64_t n;
    int64_t *at; /* [n] degree of freedom, or index in lane 0 */
    double *value;
} sparse_row;
/* The numbers of a vector [n] that are not 0. Free the row after a failure, too. */
sp_status sp_sparse_row_make(int64_t n, const double *vector, sparse_row *out, sp_error *err);
void sp_sparse_row_free(sparse_row *row);
/* From the network's order to the operator's. mass: factors that make momenta of displacements; NULL: none. */
void sp_sparse_row_turn(const sp_operator *op, const double *mass, sparse_row *row);

typedef struct recurrence {
    const sp_operator *op;
    sp_pool *pool;
    int64_t step;
    double *u, *v;   /* [n + 1][row] U_k, U_k - U_(k-1) */
    double *next;    /* U_(k+1); with a single block it shares memory with U_k */
    double *weight;  /* [n][2 kinds] masses and 4/(Omega^2 m), of translations and, if there are any, rotations */
    double *force;   /* [threads][rows of the largest block][row] */
    uint8_t *awake;  /* [blocks] whether U_k or V_k is nonzero */
    int32_t *active; /* [n_active] blocks to visit in a step: those awake and their neighbours */
    int32_t n_active;
    pair *dots;       /* [blocks] mass-weighted products of lane 1 of U_(k+1) with lane 0 of U_k and of U_(k+1) */
    pair *sizes;      /* [blocks] the same with absolute values of the terms */
    bool doubled;     /* compute these products */
    bool past_caches; /* the vectors exceed all caches */
    bool second[2];   /* for each lane: U is W, else T */
    double start[2];  /* squares of the norms of U_0 */
    int64_t dropped;  /* blocks left asleep although something tiny reached them */
} recurrence;

/* Both lanes start at 0. threads: 1 or more; few blocks are handled by one thread. */
sp_status sp_recurrence_make(const sp_operator *op, const double *mass, double omega, int threads, recurrence *out,
                             sp_error *err);
void sp_recurrence_free(recurrence *r);
/* Starts a lane with M^-1 row, as W_0 with W_(-1) = -W_0 or as T_0 with T_(-1) = T_1. */
void sp_recurrence_start(recurrence *r, int lane, bool second, const sparse_row *row);

typedef struct recurrence_products {
    pair dot, size;
} recurrence_products;
/* Advances both lanes by one step. The products are 0 unless r->doubled. */
recurrence_products sp_recurrence_step(recurrence *r);

/* Bound of the error due to blocks left asleep, in T_m W_k and T_m T_k between normalized starting vectors, for m and k
 * up to `terms`. */
double sp_recurrence_dropped(const recurrence *r, int64_t terms);
/* row . U_k of both lanes; *size: sums of the absolute values of the terms. */
pair sp_recurrence_product(const recurrence *r, const sparse_row *row, pair *size);
/* The size of the terms of a product, for its rounding errors, from the sum of their absolute values and the product of
 * the norms. A component may have errors of the size of its neighbours, which are larger by far where masses differ.
 * In many terms that is rare; in networks of few degrees of freedom, whose modes are few, the norms count. */
enum { SIGNAL_FEW_DOFS = 100, SIGNAL_FEW_ROUNDING = 3 };
static inline double signal_size(int64_t dofs, double terms, double norms) {
    return dofs <= SIGNAL_FEW_DOFS && terms > 0 ? SIGNAL_FEW_ROUNDING * norms : terms;
}
/* Norm of M^-1 row in the metric of the masses. */
double sp_recurrence_norm(const recurrence *r, const sparse_row *row);
/* Masses and 4/(Omega^2 m) of each grain, as in `weight`. */
void sp_recurrence_weights(const sp_operator *op, const double *mass, double omega, double *weight);
/* Squared norms of both lanes of a block of u, and of U_k, in the metric of the masses. */
pair sp_recurrence_block_squares(const recurrence *r, int32_t block, const double *u);
pair sp_recurrence_squares(const recurrence *r);

#endif
