#ifndef SP_RECURRENCE_H
#define SP_RECURRENCE_H
/* Two vectors (lanes) carried from step to step by U_(k+1) = 2 X U_k - U_(k-1), X = 1 - 2 M^-1 K/Omega^2, in the form
 * U_(k+1) = U_k + V_(k+1), V_(k+1) = V_k - (4/Omega^2) M^-1 K U_k, which keeps rounding small. */

#include "base/pool.h"
#include "network/operator.h"

typedef double pair __attribute__((vector_size(16)));

/* Numbers over the values of an operator's vectors, most of them 0: forces, as those that K gives. */
typedef struct sparse_row {
    int64_t n;
    int64_t *at; /* [n] place in lane 0 */
    double *value;
} sparse_row;

typedef struct recurrence {
    const sp_operator *op;
    sp_pool *pool;
    int64_t step;
    double *u, *v;   /* [n + 1][row] U_k, U_k - U_(k-1) */
    double *next;    /* U_(k+1); with one block it takes the place of U_k */
    double *weight;  /* [n][2 kinds] masses and 4/(Omega^2 m): of each dof, or of translations and of the rotation */
    double *force;   /* [threads][rows of the largest block][row] */
    uint8_t *awake;  /* [blocks] whether U_k or V_k is not 0 there */
    int32_t *active; /* [n_active] blocks that a step must visit: those awake, and those beside them */
    int32_t n_active;
    pair *dots;       /* [blocks] mass-weighted products of lane 1 of U_(k+1) with lane 0 of U_k and of U_(k+1) */
    pair *sizes;      /* [blocks] the same with absolute values */
    bool doubled;     /* whether dots are wanted */
    bool past_caches; /* the vectors are too large for any */
    bool second[2];   /* of a lane: U is W, else T */
    double start[2];  /* squares of the norms of U_0 */
    int64_t dropped;  /* blocks that were left asleep although something tiny had come there */
} recurrence;

/* Both lanes are 0. threads: 1 or more; few blocks are the work of one. */
sp_status sp_recurrence_make(const sp_operator *op, const double *mass, double omega, int threads, recurrence *out,
                             sp_error *err);
void sp_recurrence_free(recurrence *r);
/* Starts a lane with M^-1 row: as W_0, W_(-1) = -W_0, or as T_0, T_(-1) = T_1. */
void sp_recurrence_start(recurrence *r, int lane, bool second, const sparse_row *row);

typedef struct recurrence_products {
    pair dot, size;
} recurrence_products;
/* One step; the products are 0 unless r->doubled. */
recurrence_products sp_recurrence_step(recurrence *r);

/* What leaving blocks asleep may have changed in any entry of T_m W_k and T_m T_k between starting vectors of norm 1,
 * m and k up to `terms`. */
double sp_recurrence_dropped(const recurrence *r, int64_t terms);
/* row . U_k of both lanes, and the sums of the absolute values of the terms. */
pair sp_recurrence_seen(const recurrence *r, const sparse_row *row, pair *size);
/* |M^-1 row| with the mass. */
double sp_recurrence_norm(const recurrence *r, const sparse_row *row);
/* Squares of the norms of both lanes, with the mass. */
pair sp_recurrence_squares(const recurrence *r);

#endif
