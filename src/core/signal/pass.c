/* Extends the moments of one pass of the Chebyshev recurrence. */
#include "signal/pass.h"
#include "base/base.h"
#include "signal/expansion.h"

#include <math.h>

void sp_pass_free(pass *p) {
    sp_recurrence_free(&p->r);
    sp_free(p->mu);
    sp_free(p->size);
    sp_free(p->norms);
    *p = (pass){0};
}

/* Moment 0, and norms. */
static void begin(const pass_plan *plan, pass *p) {
    pair size;
    sp_recurrence_start(&p->r, 0, plan->velocity, &plan->propagated[0]);
    if (plan->doubled)
        sp_recurrence_start(&p->r, 1, false, &plan->observers[0]);
    else if (plan->lanes == 2)
        sp_recurrence_start(&p->r, 1, plan->velocity, &plan->propagated[1]);
    for (int32_t q = 0; q < p->observer_count; q++) {
        const pair mu = sp_recurrence_product(&p->r, &p->observers[q], &size);
        for (int32_t lane = 0; lane < p->lanes; lane++) {
            p->mu[lane * p->observer_count + q] = p->velocity ? mu[lane] : 0.5 * mu[lane];
            p->size[lane * p->observer_count + q] = size[lane];
            p->norms[lane * p->observer_count + q] =
                sqrt(p->r.start[lane]) * sp_recurrence_norm(&p->r, &p->observers[q]);
        }
        p->first = mu[0];
    }
    p->n = 1;
}

sp_status sp_pass_make(const pass_plan *plan, pass *out, sp_error *err) {
    pass p = {.doubled = plan->doubled,
              .velocity = plan->velocity,
              .lanes = plan->doubled ? 1 : plan->lanes,
              .observer_count = plan->observer_count,
              .spread = plan->spread,
              .observers = plan->observers,
              .capacity = plan->terms + 2};
    p.columns = (int64_t)p.lanes * p.observer_count;
    const size_t count = (size_t)p.columns;
    sp_status status = sp_recurrence_make(plan->op, plan->mass, plan->omega, plan->threads, &p.r, err);
    if (status == SP_OK) {
        p.mu = sp_alloc((size_t)p.capacity, count * sizeof *p.mu);
        p.size = sp_alloc((size_t)p.capacity, count * sizeof *p.size);
        p.norms = sp_alloc(count, sizeof *p.norms);
        if (!p.mu || !p.size || !p.norms)
            status = sp_fail_memory(err, 2 * (size_t)p.capacity * count * sizeof *p.mu);
    }
    if (status != SP_OK) {
        sp_pass_free(&p);
        return status;
    }
    begin(plan, &p);
    p.r.doubled = p.doubled;
    *out = p;
    return SP_OK;
}

static int64_t dofs_of(const pass *p) { return (int64_t)p->r.op->n * p->r.op->dof; }

/* Of both lanes, where signal_size asks for them. */
static pair squares_of(const pass *p) {
    return dofs_of(p) <= SIGNAL_FEW_DOFS ? sp_recurrence_squares(&p->r) : (pair){0, 0};
}

/* b^T T_m W_k a = b^T (W_(k+m) + W_(k-m)) a/2, W_(-k-1) = -W_k, and T_m T_k = (T_(k+m) + T_|m-k|)/2, for m = k + 1 and
 * for both at k + 1. */
static void extend_doubled(pass *p) {
    const int64_t k = p->r.step;
    const recurrence_products of = sp_recurrence_step(&p->r);
    double back = p->velocity ? p->first : -p->mu[1];
    if (k == 0 && !p->velocity)
        back = -of.dot[0];
    const pair squares = squares_of(p);
    const double norms = sqrt(squares[0]) * sqrt(squares[1]);
    p->mu[2 * k + 1] = 2 * of.dot[0] + back;
    p->size[2 * k + 1] = 2 * signal_size(dofs_of(p), of.size[0], norms);
    p->mu[2 * k + 2] = 2 * of.dot[1] - p->first;
    p->size[2 * k + 2] = 2 * signal_size(dofs_of(p), of.size[1], norms);
    p->n += 2;
}

static void extend_plainly(pass *p) {
    sp_recurrence_step(&p->r);
    const pair squares = squares_of(p);
    double *mu = p->mu + p->n * p->columns, *size = p->size + p->n * p->columns;
    for (int32_t q = 0; q < p->observer_count; q++) {
        pair magnitude;
        const pair sum = sp_recurrence_product(&p->r, &p->observers[q], &magnitude);
        for (int32_t lane = 0; lane < p->lanes; lane++) {
            mu[lane * p->observer_count + q] = sum[lane];
            const double seen = p->norms[lane * p->observer_count + q] / sqrt(p->r.start[lane]);
            size[lane * p->observer_count + q] = signal_size(dofs_of(p), magnitude[lane], seen * sqrt(squares[lane]));
        }
    }
    p->n++;
}

void sp_pass_extend(pass *p, int64_t n) {
    while (p->n < n && p->n + 2 <= p->capacity) {
        if (p->doubled)
            extend_doubled(p);
        else
            extend_plainly(p);
    }
}

bool sp_pass_bounded(const pass *p) {
    const pair now = sp_recurrence_squares(&p->r);
    bool bounded = true;
    for (int lane = 0; lane < 2; lane++) {
        const double growth = (p->r.second[lane] ? 2 * (double)p->r.step + 1 : 1) * sp_expansion_growth(p->spread);
        bounded = bounded && now[lane] <= growth * growth * p->r.start[lane];
    }
    return bounded;
}
