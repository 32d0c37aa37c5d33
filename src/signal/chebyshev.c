#include "signal/chebyshev.h"
#include "base/base.h"
#include "network/kernel.h"
#include "numeric/bessel.h"
#include "signal/job.h"

#include <float.h>
#include <math.h>

typedef double pair __attribute__((vector_size(16)));
typedef pair pair_memory __attribute__((may_alias));
typedef int64_t bits __attribute__((vector_size(16)));

static inline pair absolute(pair x) { return (pair)((bits)x & (bits){INT64_MAX, INT64_MAX}); }

void sp_expansion_free(sp_expansion *e) {
    sp_free(e->mu);
    sp_free(e->size);
    *e = (sp_expansion){0};
}

/* Weight of |J_(2k+1)| or |J_2k| in the tail: |b^T W_k a| <= (2k+1) |a||b|, |b^T T_k a| <= |a||b|. */
static double weight(bool velocity, int64_t k) { return velocity ? 2 * (double)k + 1 : 1; }

/* Rounding: see rounding(). */
#define MOMENT_ROUNDING 5.0
#define PHASE_ROUNDING  5.0

/* J_(2k+1) or J_2k at x for k < *n, all that are not negligible there. Above x they fall with the order and rise with
 * x, so the last time has the largest tail. */
static sp_status bessel_terms(double x, bool velocity, int64_t *n, double **j, sp_error *err) {
    const int64_t orders = sp_bessel_orders(x);
    double *all = sp_alloc((size_t)orders, sizeof *all);
    if (!all)
        return sp_fail_memory(err, (size_t)orders * sizeof *all);
    sp_bessel_j(x, orders, all);
    *n = orders / 2;
    for (int64_t k = 0; k < *n; k++)
        all[k] = all[2 * k + velocity];
    *j = all;
    return SP_OK;
}

sp_status sp_expansion_terms(double omega, double until, bool velocity, double tail, int64_t *terms, sp_error *err) {
    double *j = NULL, sum = 0;
    int64_t n = 0;
    sp_status status = bessel_terms(omega * until, velocity, &n, &j, err);
    if (status != SP_OK)
        return status;
    while (n > 1) {
        sum += weight(velocity, n - 1) * fabs(j[n - 1]);
        if (sum > tail)
            break;
        n--;
    }
    sp_free(j);
    *terms = n;
    return SP_OK;
}

/* Two vectors, interleaved by degree of freedom: a-side (from the source, U_k = W_k a or T_k a) and b-side (from the
 * detector, T_k b), as displacements. */
typedef struct state {
    int64_t dofs;
    double *u, *v, *force; /* [dofs][2]: U_k, U_k - U_(k-1), K U_k */
    double *step;          /* [dofs] 4/(Omega^2 m) */
    const double *mass;    /* [dofs] */
} state;

/* Moments of one step: b_(k+1) . a_k and b_(k+1) . a_(k+1), and the same with absolute values. */
typedef struct products {
    pair dot, size;
} products;

/* One step of both recurrences, U_(k+1) = U_k + V_(k+1), V_(k+1) = V_k - (4/Omega^2) M^-1 K U_k: the three-term
 * recurrence of T and W in the form that keeps rounding small. Clears the forces. */
static products advance(const state *s, pair factor) {
    enum { WAYS = 4 }; /* independent sums, added in a fixed order */
    pair dot[WAYS] = {{0, 0}}, size[WAYS] = {{0, 0}};
    pair_memory *restrict u = (pair_memory *)s->u, *restrict v = (pair_memory *)s->v;
    pair_memory *restrict force = (pair_memory *)s->force;
    const double *restrict mass = s->mass, *restrict step = s->step;
    for (int64_t k = 0; k < s->dofs; k += WAYS) {
        const int many = s->dofs - k < WAYS ? (int)(s->dofs - k) : WAYS;
        for (int q = 0; q < many; q++) {
            const pair old = u[k + q], push = v[k + q] - (factor * step[k + q]) * force[k + q], now = old + push;
            const pair product = (mass[k + q] * now[1]) * (pair){old[0], now[0]};
            force[k + q] = (pair){0, 0};
            v[k + q] = push;
            u[k + q] = now;
            dot[q] += product;
            size[q] += absolute(product);
        }
    }
    return (products){(dot[0] + dot[1]) + (dot[2] + dot[3]), (size[0] + size[1]) + (size[2] + size[3])};
}

/* Squares of the norms |a-side|, |b-side| with the mass. */
static pair squares(const state *s) {
    pair sum = {0, 0};
    for (int64_t k = 0; k < s->dofs; k++) {
        const pair x = ((const pair_memory *)s->u)[k];
        sum += s->mass[k] * (x * x);
    }
    return sum;
}

static void state_free(state *s) {
    sp_free(s->u);
    sp_free(s->v);
    sp_free(s->force);
    sp_free(s->step);
}

static sp_status state_make(const sp_network *net, const double *sent, const double *seen, bool velocity, double omega,
                            state *s, sp_error *err) {
    const size_t dofs = (size_t)sp_network_dofs(net);
    *s = (state){.dofs = (int64_t)dofs, .mass = net->mass};
    s->u = sp_alloc(2 * dofs, sizeof *s->u);
    s->v = sp_alloc(2 * dofs, sizeof *s->v);
    s->force = sp_alloc(2 * dofs, sizeof *s->force);
    s->step = sp_alloc(dofs, sizeof *s->step);
    if (!s->u || !s->v || !s->force || !s->step)
        return sp_fail_memory(err, 7 * dofs * sizeof(double));
    for (size_t k = 0; k < dofs; k++) {
        s->u[2 * k] = velocity ? sent[k] / net->mass[k] : sent[k];
        s->u[2 * k + 1] = seen[k] / net->mass[k];
        /* W_(-1) = -1; T_(-1) = T_1 is met by half a first step */
        s->v[2 * k] = velocity ? 2 * s->u[2 * k] : 0;
        s->step[k] = 4 / (omega * omega * net->mass[k]);
    }
    return SP_OK;
}

/* Both sides are carried half the way only, for b^T T_m W_k a = 1/2 b^T (W_(k+m) + W_(k-m)) a, W_(-k-1) = -W_k, and
 * T_m T_k = 1/2 (T_(k+m) + T_|k-m|). */
static void find_moments(const sp_network *net, state *s, sp_expansion *e) {
    const pair first = squares(s);
    e->reach = sqrt(first[0]) * sqrt(first[1]);
    for (int64_t k = 0; k < s->dofs; k++) {
        const double term = s->mass[k] * s->u[2 * k] * s->u[2 * k + 1];
        e->mu[0] += term;
        e->size[0] += fabs(term);
    }
    int64_t k = 0;
    for (; 2 * k + 1 < e->n; k++) {
        pair factor = {1, 1};
        if (k == 0)
            factor = (pair){e->velocity ? 1 : 0.5, 0.5};
        sp_network_add_pair(net, s->u, s->force);
        const products p = advance(s, factor);
        double back = e->velocity ? e->mu[0] : -e->mu[1];
        if (k == 0)
            back = e->velocity ? e->mu[0] : -p.dot[0];
        e->mu[2 * k + 1] = 2 * p.dot[0] + back;
        e->size[2 * k + 1] = 2 * p.size[0];
        if (2 * k + 2 < e->n) {
            e->mu[2 * k + 2] = 2 * p.dot[1] - e->mu[0];
            e->size[2 * k + 2] = 2 * p.size[1];
        }
    }
    if (!e->velocity)
        e->mu[0] *= 0.5;
    const pair last = squares(s);
    const double growth = weight(e->velocity, k) * 1.0001;
    e->bounded = last[0] <= growth * growth * first[0] && last[1] <= 1.0002 * first[1];
}

sp_status sp_expansion_make(const sp_network *net, const double *sent, const double *seen, bool velocity, double omega,
                            int64_t terms, sp_expansion *out, sp_error *err) {
    sp_expansion e = {.n = terms, .omega = omega, .velocity = velocity};
    state s = {0};
    sp_status status = state_make(net, sent, seen, velocity, omega, &s, err);
    if (status != SP_OK)
        goto out;
    e.mu = sp_alloc((size_t)terms, sizeof *e.mu);
    e.size = sp_alloc((size_t)terms, sizeof *e.size);
    if (!e.mu || !e.size) {
        status = sp_fail_memory(err, 2 * (size_t)terms * sizeof *e.mu);
        goto out;
    }
    find_moments(net, &s, &e);
out:
    state_free(&s);
    if (status == SP_OK)
        *out = e;
    else
        sp_expansion_free(&e);
    return status;
}

/* Rounding, as it adds up: moment k carries the independent errors of some k/2 steps, each a few DBL_EPSILON of its
 * terms; Omega t is known to DBL_EPSILON of itself. The factors leave room for 5 times what is seen. */
static double rounding(const sp_expansion *e, double x, int64_t n, const double *j) {
    double moments = 0, signal = 0;
    for (int64_t k = 0; k < n && k < e->n; k++) {
        const double own = j[k] * e->size[k] * sqrt(1 + (double)k), term = j[k] * e->mu[k];
        moments += own * own;
        signal += term * term;
    }
    return DBL_EPSILON * (MOMENT_ROUNDING * sqrt(moments) + PHASE_ROUNDING * (1 + x) * sqrt(signal));
}

sp_status sp_expansion_sum(const sp_expansion *e, int32_t n, const double *t, double *f, double *error, sp_error *err) {
    const double scale = e->velocity ? 2 / e->omega : 2, last = e->omega * t[n - 1];
    double *x = NULL, *j = NULL, tail = 0;
    int64_t terms = 0;
    sp_status status = bessel_terms(last, e->velocity, &terms, &j, err);
    if (status != SP_OK)
        return status;
    x = sp_alloc((size_t)n, sizeof *x);
    if (!x) {
        status = sp_fail_memory(err, (size_t)n * sizeof *x);
        goto out;
    }
    for (int32_t l = 0; l < n; l++)
        x[l] = e->omega * t[l];
    sp_bessel_series(e->n, e->mu, e->velocity, n, x, f);
    for (int32_t l = 0; l < n; l++)
        f[l] *= scale;
    for (int64_t k = e->n; k < terms; k++)
        tail += weight(e->velocity, k) * fabs(j[k]);
    tail += 2 * weight(e->velocity, terms) * fabs(j[terms - 1]); /* those left out as negligible */
    *error = scale * (e->reach * tail + rounding(e, last, terms, j));
out:
    sp_free(x);
    sp_free(j);
    return status;
}

/* Moments beyond what fits any machine's patience and memory. */
enum { TERMS_MAX = 20000000 };

sp_status sp_signal_by_chebyshev(const signal_job *job, sp_signal *s, sp_error *err) {
    const sp_signal_options *o = job->options;
    int64_t terms;
    if (0.5 * s->omega_max * o->until > TERMS_MAX)
        return sp_fail(err, SP_EREFUSED, "until = %g needs %.3g matrix products, %d at the most; take the dense method",
                       o->until, 0.5 * s->omega_max * o->until, TERMS_MAX);
    sp_status status = sp_expansion_terms(s->omega_max, o->until, job_moves(job), 1e-8 * o->tolerance, &terms, err);
    for (int32_t a = 0; a < s->sources; a++)
        for (int32_t b = 0; b < s->detectors && status == SP_OK; b++) {
            sp_expansion e = {0};
            status = sp_expansion_make(job->net, job_source(job, a), job_detector(job, b), job_moves(job), s->omega_max,
                                       terms, &e, err);
            if (status == SP_OK && !e.bounded)
                status =
                    sp_fail(err, SP_EREFUSED, "the motion grows without bound: the network is unstable (prestress)");
            if (status == SP_OK)
                status = sp_expansion_sum(&e, s->n, s->t, signal_pair(s, a, b), &s->errors[a * s->detectors + b], err);
            sp_expansion_free(&e);
        }
    s->products = (int32_t)(terms - 1);
    return status;
}
