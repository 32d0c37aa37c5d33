#ifndef SP_PASS_H
#define SP_PASS_H
/* Moments b^T W_k a or b^T T_k a of sources a and detectors b from one recurrence, for as many k as needed. A single
 * pair uses doubling: one lane propagates the source and one the detector, and each step gives two moments. For several
 * pairs a pass propagates two sources (or two detectors if these are fewer), and each step gives the products with all
 * observers. */

#include "signal/recurrence.h"

typedef struct pass {
    recurrence r;
    bool doubled;                  /* one lane for the source and one for the detector */
    bool velocity;                 /* moments of W, else of T */
    int32_t lanes, observer_count; /* number of propagated vectors; number of observers */
    const sparse_row *observers;   /* [observers] */
    int64_t columns;               /* moments per step: 1, or lanes x observers, lane by lane */
    int64_t n, capacity;           /* moments known, and moments for which there is memory */
    double *mu;                    /* [capacity][columns] moments; mu_0 of T is halved */
    double *size;                  /* [capacity][columns] sums of the absolute values of their terms */
    double *norms;                 /* [columns] |a| |b| */
    double first;                  /* mu_0 of a doubled pass */
    double spread;                 /* as in the plan */
} pass;

typedef struct pass_plan {
    const sp_operator *op;
    const double *mass;
    double omega;
    int threads;
    bool velocity, doubled;
    double spread; /* sp_expansion_spread; must be 0 for doubling */
    int64_t terms; /* upper limit of their number */
    int32_t lanes, observer_count;
    const sparse_row *propagated; /* [lanes] vectors to propagate; with doubling: the source */
    const sparse_row *observers;  /* [observers]; with doubling: the detector */
} pass_plan;

sp_status sp_pass_make(const pass_plan *plan, pass *out, sp_error *err);
/* Computes at least n moments, up to the plan's number of terms. */
void sp_pass_extend(pass *p, int64_t n);
void sp_pass_free(pass *p);
/* Whether |T_k b| and |W_k a| stay within their bounds, so that no frequency is above Omega or imaginary. */
bool sp_pass_bounded(const pass *p);

/* F of all columns at n ascending times, f[column * stride + l], and upper bounds of the errors: remainder and
 * rounding. */
sp_status sp_pass_sum(const pass *p, double omega, int64_t n, const double *t, int64_t stride, double *f,
                      double *errors, sp_error *err);

#endif
