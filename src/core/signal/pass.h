#ifndef SP_PASS_H
#define SP_PASS_H
/* Moments b^T W_k a or b^T T_k a of sources a and detectors b out of one recurrence, for as many k as are asked for.
 * One pair is met half way: one lane carries the source, one the detector, and each step gives two moments. With more
 * of them a pass carries two sources (or two detectors, where these are fewer), and every step is seen by all others.
 */

#include "signal/recurrence.h"

typedef struct pass {
    recurrence r;
    bool doubled;           /* a lane each, met half way */
    bool velocity;          /* moments of W, else of T */
    int32_t lanes, others;  /* places carried; places that see them */
    const sparse_row *seen; /* [others] */
    int64_t columns;        /* moments of a step: 1, or lanes x others, lane by lane */
    int64_t n, room;        /* moments of each column: known; there is room for */
    double *mu, *size;      /* [room][columns]; the sum of the absolute values of a moment's terms; mu_0 of T halved */
    double *reach;          /* [columns] |a| |b| */
    double first;           /* mu_0 of a doubled pass */
    double spread;          /* of the plan */
} pass;

typedef struct pass_plan {
    const sp_operator *op;
    const double *mass;
    double omega;
    int threads;
    bool velocity, doubled;
    double spread; /* sp_expansion_spread; above 0 none is met half way */
    int64_t terms; /* at the most */
    int32_t lanes, others;
    const sparse_row *carried; /* [lanes]; doubled: the source */
    const sparse_row *seen;    /* [others] */
} pass_plan;

sp_status sp_pass_make(const pass_plan *plan, pass *out, sp_error *err);
/* n moments at least, up to the plan's number of terms. */
void sp_pass_extend(pass *p, int64_t n);
void sp_pass_free(pass *p);
/* |T_k b| and |W_k a| stay within what is allowed: no frequency is above Omega, none imaginary. */
bool sp_pass_bounded(const pass *p);

/* F of all columns of a pass at n ascending times, f[column * stride + l], and bounds of their errors: the tail and
 * rounding. */
sp_status sp_pass_sum(const pass *p, double omega, int64_t n, const double *t, int64_t stride, double *f,
                      double *errors, sp_error *err);

#endif
