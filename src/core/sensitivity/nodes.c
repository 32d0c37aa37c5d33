/* Functionals of a signal as weights of the moments of its expansion. */
#include "sensitivity/nodes.h"

#include "base/base.h"
#include "numeric/bessel.h"
#include "signal/job.h"

#include <math.h>

/* What is left out of a functional, relative to the sum of its weights. */
#define TAIL 1e-18

enum { RULE = 16, ORDER_MAX = 3 };

void sp_nodes_free(sp_nodes *nodes) {
    sp_free(nodes->at);
    *nodes = (sp_nodes){0};
}

void sp_moment_weights_free(sp_moment_weights *w) {
    sp_free(w->c);
    *w = (sp_moment_weights){0};
}

double sp_nodes_last(const sp_nodes *nodes) {
    double last = 0;
    for (int64_t k = 0; k < nodes->n; k++)
        last = fmax(last, nodes->at[k].t);
    return last;
}

static sp_status add_node(sp_nodes *nodes, double t, int order, double weight, sp_error *err) {
    struct sp_node *at = sp_grow(nodes->at, (size_t)nodes->n + 1, &nodes->capacity, sizeof *at);
    if (!at)
        return sp_fail_memory(err, ((size_t)nodes->n + 1) * sizeof *at);
    nodes->at = at;
    at[nodes->n++] = (struct sp_node){t, weight, order};
    return SP_OK;
}

sp_status sp_nodes_check_pulse(const sp_pulse *pulse, sp_error *err) {
    if (!pulse)
        return SP_OK;
    sp_status status = sp_pulse_check(pulse, err);
    if (status == SP_OK && pulse->kind != SP_PULSE_DELTA && pulse->kind != SP_PULSE_GAUSS &&
        pulse->kind != SP_PULSE_RICKER)
        return sp_fail(err, SP_EINVAL, "pulse: sensitivities need a short pulse, gauss or ricker");
    return status;
}

/* Abscissas and weights of Gauss's rule with 16 nodes on -1 .. 1; the other half has the opposite signs. */
static const double RULE_AT[RULE / 2] = {0.0950125098376374402, 0.2816035507792589132, 0.4580167776572273863,
                                         0.6178762444026437484, 0.7554044083550030339, 0.8656312023878317439,
                                         0.9445750230732325761, 0.9894009349916499326};
static const double RULE_WEIGHT[RULE / 2] = {0.1894506104550684963, 0.1826034150449235889, 0.1691565193950025382,
                                             0.1495959888165767321, 0.1246289712555338720, 0.0951585116824927848,
                                             0.0622535239386478929, 0.0271524594117540949};

/* ds/dt of a gauss or ricker pulse. */
static double pulse_slope(const sp_pulse *p, double t) {
    if (p->kind == SP_PULSE_GAUSS)
        return -t / (p->width * p->width) * sp_pulse_strength(p, t);
    const double q = 0.5 * p->omega * t;
    return 0.5 * p->omega * (4 * q * q * q - 6 * q) * exp(-q * q);
}

/* What the derivative of the integral has from its upper end, where the response begins: G(0) and G'(0). */
static sp_status add_ends(sp_nodes *nodes, const sp_pulse *pulse, double t, int order, double weight, sp_error *err) {
    sp_status status = SP_OK;
    if (order >= 1)
        status = add_node(nodes, 0, order - 1, weight * sp_pulse_strength(pulse, t), err);
    if (order == 2 && status == SP_OK)
        status = add_node(nodes, 0, 0, weight * pulse_slope(pulse, t), err);
    return status;
}

sp_status sp_nodes_add(sp_nodes *nodes, const sp_pulse *pulse, double limit, double t, int order, double weight,
                       sp_error *err) {
    if (!pulse || pulse->kind == SP_PULSE_DELTA)
        return add_node(nodes, t, order, weight, err);
    double first, last;
    sp_pulse_span(pulse, &first, &last);
    last = fmin(last, t);
    const double length = last - first;
    const int64_t panels = length > 0 ? (int64_t)ceil(length / sp_pulse_panel(pulse, limit)) : 0;
    sp_status status = SP_OK;
    for (int64_t k = 0; k < panels && status == SP_OK; k++)
        for (int q = 0; q < RULE && status == SP_OK; q++) {
            const double side = q % 2 == 0 ? RULE_AT[q / 2] : -RULE_AT[q / 2], half = 0.5 * length / (double)panels;
            const double when = first + half * (2 * (double)k + 1 + side);
            status = add_node(nodes, fmax(t - when, 0), order,
                              weight * half * RULE_WEIGHT[q / 2] * sp_pulse_strength(pulse, when), err);
        }
    return status == SP_OK ? add_ends(nodes, pulse, t, order, weight, err) : status;
}

/* The derivative of J_m of some order, from J_(m - order) .. J_(m + order). */
static double bessel_derivative(int64_t n, const double *j, int64_t m, int order) {
    static const double binomial[ORDER_MAX + 1][ORDER_MAX + 1] = {{1}, {1, 1}, {1, 2, 1}, {1, 3, 3, 1}};
    double sum = 0;
    for (int q = 0; q <= order; q++) {
        const int64_t at = m - order + 2 * q, size = at < 0 ? -at : at;
        const double value = size < n ? j[size] : 0;
        sum += (q % 2 ? -1 : 1) * binomial[order][q] * (at < 0 && size % 2 ? -value : value);
    }
    return ldexp(sum, -order);
}

/* Adds factor x the derivative of the signal at a time to the weights of the moments. */
static void add_time(double omega, bool velocity, double t, int order, double factor, int64_t orders, double *j,
                     double *c) {
    const double scale = (velocity ? 2 / omega : 2) * pow(omega, order) * factor;
    sp_bessel_j(omega * t, orders, j);
    for (int64_t k = 0; 2 * k + 1 < orders; k++)
        c[k] += (k == 0 && !velocity ? 0.5 : 1) * scale * bessel_derivative(orders, j, 2 * k + velocity, order);
}

/* |dP_k/dX| on -1 .. 1 is at most the sum of 2 |U_(k-1-j)| |P_j|. */
static double steepness(bool velocity, int64_t k) {
    const double n = (double)k;
    return velocity ? n * (n + 1) * (2 * n + 1) / 3 + 1 : n * n + 1;
}

/* Leaves out the last terms where they do not matter. */
static void cut(sp_moment_weights *w, bool velocity) {
    double sum = 0, steep = 0, all = 0;
    for (int64_t k = 0; k < w->terms; k++)
        all += fabs(w->c[k]);
    while (w->terms > 2) {
        const int64_t k = w->terms - 1;
        const double more = fabs(w->c[k]) * (velocity ? 2 * (double)k + 1 : 1);
        const double more_steep = fabs(w->c[k]) * steepness(velocity, k);
        if (steep + more_steep > TAIL * all * (double)k)
            break;
        sum += more;
        steep += more_steep;
        w->terms--;
    }
    /* orders that were set to 0 */
    w->tail = sum + 1e-20 * all;
    w->steep = steep + 1e-20 * all * steepness(velocity, w->terms);
}

sp_status sp_nodes_weights(const sp_nodes *nodes, double omega, bool velocity, const double *power,
                           sp_moment_weights *out, sp_error *err) {
    const int64_t orders = sp_bessel_orders(omega * sp_nodes_last(nodes)) + 2 * ORDER_MAX + 2;
    double *j = sp_alloc((size_t)orders, sizeof *j);
    sp_moment_weights w = {.terms = orders / 2 - ORDER_MAX};
    w.c = sp_alloc((size_t)orders, sizeof *w.c);
    if (!j || !w.c) {
        sp_free(j);
        sp_free(w.c);
        return sp_fail_memory(err, 2 * (size_t)orders * sizeof *j);
    }
    for (int64_t k = 0; k < nodes->n; k++) {
        const struct sp_node *at = &nodes->at[k];
        const double factor = power ? *power + 0.5 * at->order : 1;
        add_time(omega, velocity, at->t, at->order, factor * at->weight, orders, j, w.c);
        if (power && at->t > 0)
            add_time(omega, velocity, at->t, at->order + 1, 0.5 * at->t * at->weight, orders, j, w.c);
    }
    sp_free(j);
    cut(&w, velocity);
    *out = w;
    return SP_OK;
}
