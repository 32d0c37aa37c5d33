/* Convolution F(t) = integral of s(t') G(t - t') dt': Gauss's rule on panels, with G from local polynomials. */
#include "signal/convolve.h"
#include "base/base.h"

#include <math.h>

#define PI 3.14159265358979323846

enum { NODES_MAX = 16, POINTS_MAX = 16 };
#define WORK_MAX 2e10 /* interpolated values times points of each */

/* Data of one convolution. */
typedef struct convolution {
    const sp_response *g;
    const sp_pulse *pulse;
    const sp_quadrature *rule;
    double node[NODES_MAX], weight[NODES_MAX]; /* on -1 .. 1 */
    double barycentric[POINTS_MAX];            /* weights of barycentric interpolation at equally spaced points */
    double step;                               /* spacing of the points */
    int64_t last;                              /* number of points - 1 */
} convolution;

/* Roots of Legendre's polynomial by Newton's method (Abramowitz and Stegun, 25.4.29). */
static void gauss_rule(int n, double *node, double *weight) {
    for (int k = 0; k < n; k++) {
        double x = cos(PI * (k + 0.75) / (n + 0.5)), slope = 1;
        for (int step = 0; step < 20; step++) {
            double p = 1, before = 0;
            for (int m = 1; m <= n; m++) {
                const double next = ((2 * m - 1) * x * p - (m - 1) * before) / m;
                before = p;
                p = next;
            }
            slope = n * (x * p - before) / (x * x - 1);
            x -= p / slope;
        }
        node[k] = x;
        weight[k] = 2 / ((1 - x * x) * slope * slope);
    }
}

/* The value at a point, also before t = 0. */
static double sample(const convolution *c, int64_t point) {
    return point < 0 ? c->g->mirror * c->g->g[-point * c->rule->stride] : c->g->g[point * c->rule->stride];
}

/* G at a time >= 0 from the nearest points, by the barycentric formula (Berrut and Trefethen 2004). */
static double response(const convolution *c, double time) {
    const int points = c->rule->points;
    const double place = time / c->step;
    int64_t first = (int64_t)place - points / 2 + 1;
    if (first > c->last + 1 - points)
        first = c->last + 1 - points;
    if (first < 0 && c->g->mirror == 0)
        first = 0;
    double above = 0, below = 0;
    for (int k = 0; k < points; k++) {
        const double distance = place - (double)(first + k), value = sample(c, first + k);
        if (distance == 0)
            return value;
        const double part = c->barycentric[k] / distance;
        above += part * value;
        below += part;
    }
    return above / below;
}

/* Gauss's rule on the panel a .. b. */
static double panel(const convolution *c, double t, double a, double b) {
    const double half = 0.5 * (b - a), middle = 0.5 * (a + b);
    double sum = 0;
    for (int k = 0; k < c->rule->nodes; k++) {
        const double at = middle + half * c->node[k], age = t - at;
        sum += c->weight[k] * sp_pulse_strength(c->pulse, at) * response(c, age > 0 ? age : 0);
    }
    return half * sum;
}

/* Integral over an interval in which the pulse is smooth, divided into equal panels. */
static double stretch(const convolution *c, double t, double a, double b) {
    if (b > t)
        b = t;
    if (!(b > a))
        return 0;
    const int64_t panels = (int64_t)ceil((b - a) / c->rule->panel);
    double sum = 0;
    for (int64_t k = 0; k < panels; k++)
        sum += panel(c, t, a + (b - a) * (double)k / (double)panels, a + (b - a) * (double)(k + 1) / (double)panels);
    return sum;
}

static double at_time(const convolution *c, double t) {
    double first, last, sum = 0;
    sp_pulse_span(c->pulse, &first, &last);
    if (c->pulse->kind != SP_PULSE_TABLE)
        return stretch(c, t, first, last);
    for (int64_t k = 1; k < c->pulse->n && c->pulse->t[k - 1] < t; k++)
        sum += stretch(c, t, c->pulse->t[k - 1], c->pulse->t[k]);
    return sum;
}

/* Number and total length of these intervals before `until`. */
static double stretches_of(const sp_pulse *p, double until, double *length) {
    double first, last, count = 1;
    sp_pulse_span(p, &first, &last);
    *length = fmax(0, fmin(last, until) - first);
    if (p->kind == SP_PULSE_TABLE)
        for (int64_t k = 1; k < p->n && p->t[k - 1] < until; k++)
            count++;
    return count;
}

sp_status sp_convolve(const sp_response *g, const sp_pulse *pulse, const sp_quadrature *rule, int32_t n,
                      const double *t, double *f, sp_error *err) {
    convolution c = {.g = g, .pulse = pulse, .rule = rule};
    double until = 0, length;
    for (int32_t l = 0; l < n; l++)
        until = fmax(until, t[l]);
    c.step = g->step * rule->stride;
    c.last = (g->n - 1) / rule->stride;
    if (c.last + 1 < rule->points || !(rule->panel > 0))
        return sp_fail(err, SP_EINVAL, "pulse: a response of %lld points, must be %d or more", (long long)g->n,
                       rule->points * rule->stride);
    const double stretches = stretches_of(pulse, until, &length);
    const double work = (length / rule->panel + stretches) * rule->nodes * rule->points * n;
    if (!(work < WORK_MAX))
        return sp_fail(err, SP_EREFUSED, "pulse of length %g at %d times: too long for its convolution (%.2g products)",
                       length, n, work);
    gauss_rule(rule->nodes, c.node, c.weight);
    c.barycentric[0] = 1;
    for (int k = 1; k < rule->points; k++)
        c.barycentric[k] = -c.barycentric[k - 1] * (rule->points - k) / k;
    for (int32_t l = 0; l < n; l++)
        f[l] = at_time(&c, t[l]);
    return SP_OK;
}

double sp_pulse_panel(const sp_pulse *p, double omega) {
    const double response = 4 / omega;
    switch (p->kind) {
    case SP_PULSE_GAUSS: return fmin(response, p->width);
    case SP_PULSE_RICKER: return fmin(response, 1.5 / p->omega);
    case SP_PULSE_SINE: return fmin(response, 3 / p->omega / fmax(1, 1 / p->cycles));
    default: return response; /* linear between the points, where panels end */
    }
}
