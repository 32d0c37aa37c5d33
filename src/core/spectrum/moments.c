/* Chebyshev moments of a spectrum, and densities from them. */
#include "spectrum/moments.h"
#include "base/base.h"
#include "linalg/arrays.h"
#include "network/apply.h"
#include "network/quads.h"

#include <math.h>

void sp_moments_free(moment_set *m) {
    sp_free(m->xx); /* one block */
    *m = (moment_set){0};
}

/* u: T_k; v: T_k - T_(k-1); force: K T_k, cleared in each step. */
typedef struct chain {
    int64_t dofs;
    double *u, *v, *force, *step; /* [dofs][2], step [dofs]: 4/(Omega^2 m) */
    const double *mass;
    double *memory;
} chain;

static sp_status chain_make(const sp_network *net, const double *start, double omega, chain *c, sp_error *err) {
    const size_t n = (size_t)sp_network_dofs(net);
    *c = (chain){.dofs = (int64_t)n, .mass = net->mass};
    const sp_array arrays[] = {{&c->u, 2 * n}, {&c->v, 2 * n}, {&c->force, 2 * n}, {&c->step, n}, {0}};
    const sp_status status = sp_arrays_make(arrays, &c->memory, err);
    if (status != SP_OK)
        return status;
    for (size_t k = 0; k < n; k++) {
        c->u[2 * k] = start[2 * k];
        c->u[2 * k + 1] = start[2 * k + 1];
        c->step[k] = 4 / (omega * omega * net->mass[k]);
    }
    return SP_OK;
}

/* <now|now> and <now|old> of each vector; of the two: x now y now, and x old y now + x now y old. */
typedef struct products {
    pair now, old, both;
} products;

static products squares(const chain *c) {
    pair_sum now = {0}, both = {0};
    for (int64_t k = 0; k < c->dofs; k++) {
        const pair x = ((const pair_memory *)c->u)[k];
        pair_add(&now, c->mass[k] * (x * x));
        pair_add(&both, (pair){c->mass[k] * x[0] * x[1], 0});
    }
    return (products){.now = pair_total(&now), .both = pair_total(&both)};
}

/* T_(k+1) = T_k + V_(k+1), V_(k+1) = V_k - (4/Omega^2) M^-1 K T_k: this form of the recurrence keeps rounding errors
 * small. The first step is half a step, since T_(-1) = T_1. */
static products advance(const chain *c, double factor) {
    pair_sum now_now = {0}, now_old = {0}, both = {0};
    pair_memory *restrict u = (pair_memory *)c->u, *restrict v = (pair_memory *)c->v;
    pair_memory *restrict force = (pair_memory *)c->force;
    for (int64_t k = 0; k < c->dofs; k++) {
        const pair old = u[k], push = v[k] - (factor * c->step[k]) * force[k], now = old + push;
        const pair weighed = c->mass[k] * now;
        force[k] = (pair){0, 0};
        v[k] = push;
        u[k] = now;
        pair_add(&now_now, weighed * now);
        pair_add(&now_old, weighed * old);
        pair_add(&both, (pair){weighed[0] * now[1], old[0] * weighed[1] + weighed[0] * old[1]});
    }
    return (products){pair_total(&now_now), pair_total(&now_old), pair_total(&both)};
}

/* T_m T_k = (T_(m+k) + T_|m-k|)/2 gives two moments per matrix product. */
static sp_status find_moments(const sp_network *net, const chain *c, moment_set *m, sp_error *err) {
    const products first = squares(c);
    m->xx[0] = first.now[0];
    m->yy[0] = first.now[1];
    m->xy[0] = first.both[0];
    m->reach = sqrt(first.now[0]) * sqrt(first.now[1]);
    products p = first;
    for (int64_t k = 0; 2 * k + 1 < m->n; k++) {
        sp_network_add_pair(net, c->u, c->force);
        p = advance(c, k == 0 ? 0.5 : 1);
        if (k == 0) {
            m->xx[1] = p.old[0];
            m->yy[1] = p.old[1];
            m->xy[1] = 0.5 * p.both[1];
        } else {
            m->xx[2 * k + 1] = 2 * p.old[0] - m->xx[1];
            m->yy[2 * k + 1] = 2 * p.old[1] - m->yy[1];
            m->xy[2 * k + 1] = p.both[1] - m->xy[1];
        }
        if (2 * k + 2 < m->n) {
            m->xx[2 * k + 2] = 2 * p.now[0] - m->xx[0];
            m->yy[2 * k + 2] = 2 * p.now[1] - m->yy[0];
            m->xy[2 * k + 2] = 2 * p.both[0] - m->xy[0];
        }
    }
    /* |T_k x| <= |x| if all frequencies are between 0 and Omega */
    if (!(p.now[0] <= 1.0002 * first.now[0] && p.now[1] <= 1.0002 * first.now[1]))
        return sp_fail(err, SP_EREFUSED, "the motion grows without bound: the network is unstable (prestress)");
    return SP_OK;
}

sp_status sp_moments_make(const sp_network *net, int64_t n, const double *start, moment_set *out, sp_error *err) {
    moment_set m = {.n = n, .omega = sp_network_omega_bound(net)};
    chain c = {0};
    if (!(n > 0 && m.omega > 0))
        return sp_fail(err, SP_EREFUSED, "%lld moments of a spectrum up to %g, must be above 0", (long long)n, m.omega);
    sp_status status = sp_network_need_symmetry(net, "a spectrum by moments", err);
    if (status == SP_OK)
        status = chain_make(net, start, m.omega, &c, err);
    if (status != SP_OK)
        goto out;
    const sp_array moments[] = {{&m.xx, (size_t)n}, {&m.yy, (size_t)n}, {&m.xy, (size_t)n}, {0}};
    double *block;
    status = sp_arrays_make(moments, &block, err);
    if (status == SP_OK)
        status = find_moments(net, &c, &m, err);
out:
    sp_free(c.memory);
    if (status == SP_OK)
        *out = m;
    else
        sp_moments_free(&m);
    return status;
}

int64_t sp_moments_for_width(double omega, double width) { return (int64_t)ceil(0.5 * M_PI * omega / width) + 1; }

double sp_moments_width(double omega, int64_t n) { return 0.5 * M_PI * omega / (double)n; }

void sp_moments_jackson(int64_t n, double *g) {
    const double turn = M_PI / (double)(n + 1);
    for (int64_t k = 0; k < n; k++)
        g[k] = ((double)(n - k + 1) * cos(turn * (double)k) + sin(turn * (double)k) / tan(turn)) / (double)(n + 1);
}

double sp_moments_phase(double omega, double frequency) {
    return frequency < omega ? 2 * asin(frequency / omega) : M_PI;
}

/* Sums c_k, or c_k/k, times cosines over k >= 1 with c_k = g_k mu_k (Clenshaw). Returns the last value, which times
 * sin(phi) is the sum with sines; *cosines: the sum with cosines. */
static double clenshaw(int64_t n, const double *g, const double *mu, bool over_k, double phi, double *cosines) {
    const double twice = 2 * cos(phi);
    double one = 0, two = 0;
    for (int64_t k = n - 1; k >= 1; k--) {
        const double here = (g ? g[k] : 1) * mu[k] / (over_k ? (double)k : 1) + twice * one - two;
        two = one;
        one = here;
    }
    *cosines = 0.5 * twice * one - two;
    return one;
}

double sp_moments_density(double omega, int64_t n, const double *g, const double *mu, double frequency) {
    const double phi = sp_moments_phase(omega, frequency), slope = 0.5 * omega * cos(0.5 * phi);
    if (!(frequency < omega) || frequency < 0) /* no modes there; above Omega the slope is a rounding error of 0 */
        return 0;
    double cosines;
    clenshaw(n, g, mu, false, phi, &cosines);
    return ((g ? g[0] : 1) * mu[0] + 2 * cosines) / (M_PI * slope);
}

double sp_moments_integral(double omega, int64_t n, const double *g, const double *mu, double frequency) {
    const double phi = sp_moments_phase(omega, frequency);
    double cosines;
    const double sines = clenshaw(n, g, mu, true, phi, &cosines);
    return ((g ? g[0] : 1) * mu[0] * phi + 2 * sin(phi) * sines) / M_PI;
}
