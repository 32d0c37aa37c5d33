/* Pulses of any shape: strength and extent, and signals as the convolution with the response to a short pulse. */
#include "base/base.h"
#include "base/vector.h"
#include "numeric/quadrature.h"
#include "signal/job.h"

#include <float.h>
#include <math.h>
#include <sonopack/pulse.h>

/* Where exp(-x^2/2) and exp(-x^2) are below 1e-16. */
#define GAUSS_REACH  8.6
#define RICKER_REACH 6.6

static sp_status positive(const char *name, double value, sp_error *err) {
    if (value > 0 && isfinite(value))
        return SP_OK;
    return sp_fail(err, SP_EINVAL, "pulse: %s = %g, must be above 0", name, value);
}

static sp_status check_points(const sp_pulse *p, sp_error *err) {
    if (p->n < 2 || !p->t || !p->s)
        return sp_fail(err, SP_EINVAL, "pulse: a table of %lld points, must be 2 or more", (long long)p->n);
    for (int64_t k = 0; k < p->n; k++) {
        if (!isfinite(p->t[k]) || !isfinite(p->s[k]))
            return sp_fail(err, SP_EINVAL, "pulse: point %lld is not finite", (long long)k + 1);
        if (k > 0 && p->t[k] < p->t[k - 1])
            return sp_fail(err, SP_EINVAL, "pulse: t = %g of point %lld is below that of the point before it, %g",
                           p->t[k], (long long)k + 1, p->t[k - 1]);
    }
    if (!(p->t[p->n - 1] > p->t[0]))
        return sp_fail(err, SP_EINVAL, "pulse: all points are at t = %g, must be at different times", p->t[0]);
    return SP_OK;
}

sp_status sp_pulse_check(const sp_pulse *p, sp_error *err) {
    sp_status status = SP_OK;
    switch (p->kind) {
    case SP_PULSE_DELTA: return SP_OK;
    case SP_PULSE_GAUSS:
    case SP_PULSE_SQUARE: return positive("width", p->width, err);
    case SP_PULSE_RICKER: return positive("omega", p->omega, err);
    case SP_PULSE_SINE:
        status = positive("omega", p->omega, err);
        return status == SP_OK ? positive("cycles", p->cycles, err) : status;
    case SP_PULSE_TABLE: return check_points(p, err);
    }
    return sp_fail(err, SP_EINVAL, "pulse of kind %d, must be one of sp_pulse_kind", (int)p->kind);
}

void sp_pulse_span(const sp_pulse *p, double *first, double *last) {
    double reach = 0;
    *first = *last = 0;
    switch (p->kind) {
    case SP_PULSE_GAUSS: reach = GAUSS_REACH * p->width; break;
    case SP_PULSE_RICKER: reach = 2 * RICKER_REACH / p->omega; break;
    case SP_PULSE_SINE: *last = 2 * M_PI * p->cycles / p->omega; break;
    case SP_PULSE_SQUARE: *last = p->width; break;
    case SP_PULSE_TABLE:
        *first = p->t[0];
        *last = p->t[p->n - 1];
        break;
    default: break;
    }
    if (reach > 0) {
        *first = -reach;
        *last = reach;
    }
}

/* Uses the last point at or before t, so that a jump gives its later value. */
static double interpolate(const sp_pulse *p, double t) {
    if (t < p->t[0] || t > p->t[p->n - 1])
        return 0;
    int64_t low = 0, high = p->n - 1;
    while (high - low > 1) {
        const int64_t middle = (low + high) / 2;
        if (p->t[middle] <= t)
            low = middle;
        else
            high = middle;
    }
    const double step = p->t[high] - p->t[low];
    if (!(step > 0))
        return p->s[high];
    const double part = (t - p->t[low]) / step;
    return p->s[low] * (1 - part) + p->s[high] * part;
}

double sp_pulse_strength(const sp_pulse *p, double t) {
    double q;
    switch (p->kind) {
    case SP_PULSE_GAUSS: q = t / p->width; return exp(-0.5 * q * q) / (p->width * sqrt(2 * M_PI));
    case SP_PULSE_RICKER: q = 0.5 * p->omega * t; return (1 - 2 * q * q) * exp(-q * q);
    case SP_PULSE_SINE:
        q = p->omega * t;
        return q <= 0 || q >= 2 * M_PI * p->cycles ? 0 : 0.5 * sin(q) * (1 - cos(q / p->cycles));
    case SP_PULSE_SQUARE: return t < 0 || t > p->width ? 0 : 1 / p->width;
    case SP_PULSE_TABLE: return interpolate(p, t);
    default: return 0;
    }
}

/* ---- convolution ------------------------------------------------------------------------------------------------- */

typedef struct response_points {
    int64_t n;
    double step;     /* times 0, step, ... */
    const double *g; /* [n] */
    int mirror; /* G(-t) = mirror G(t): 1 or -1 for the undamped response to displacements or momenta. 0: unknown before
                   t = 0, so interpolation near 0 is one-sided */
} response_points;

/* Accuracy of a convolution: every `stride`-th value of the response, interpolated by polynomials through `points`
 * values, and Gauss's rule with `nodes` nodes on panels no longer than `panel`. */
typedef struct quadrature {
    int stride, points, nodes;
    double panel;
} quadrature;

enum { NODES_MAX = 16, POINTS_MAX = 16 };
#define WORK_MAX 2e10 /* interpolated values times points of each */

/* Data of one convolution. */
typedef struct convolution {
    const response_points *g;
    const sp_pulse *pulse;
    const quadrature *rule;
    double node[NODES_MAX], weight[NODES_MAX]; /* on -1 .. 1 */
    double barycentric[POINTS_MAX];            /* weights of barycentric interpolation at equally spaced points */
    double step;                               /* spacing of the points */
    int64_t last;                              /* number of points - 1 */
} convolution;

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

static sp_status convolve(const response_points *g, const sp_pulse *pulse, const quadrature *rule, int32_t n,
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
    sp_gauss_rule(rule->nodes, c.node, c.weight);
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

/* ---- signals ----------------------------------------------------------------------------------------------------- */

enum { FINE_POINTS = 16, COARSE_POINTS = 14, TIMES_MAX = 50000000 };
/* Time step of the response over 1/Omega: 50 steps in the shortest period. */
#define FINE_STEP 0.125

/* Largest |s| and integral of |s| before `until`. */
static void pulse_bounds(const sp_pulse *p, double until, double *most, double *integral) {
    enum { STEPS = 20000 };
    double first, last;
    sp_pulse_span(p, &first, &last);
    last = fmax(first, fmin(last, until));
    *most = *integral = 0;
    if (p->kind == SP_PULSE_TABLE) {
        for (int64_t k = 0; k < p->n && (k == 0 ? p->t[0] : p->t[k - 1]) < until; k++) {
            *most = fmax(*most, fabs(p->s[k]));
            if (k > 0)
                *integral += (p->t[k] - p->t[k - 1]) * fmax(fabs(p->s[k]), fabs(p->s[k - 1]));
        }
        return;
    }
    for (int k = 0; k < STEPS; k++) {
        const double s = fabs(sp_pulse_strength(p, first + (last - first) * (k + 0.5) / STEPS));
        *most = fmax(*most, s);
        *integral += s * (last - first) / STEPS;
    }
    *most *= 1.01;
    *integral *= 1.01;
}

/* Error of F due to that of the response and to rounding. Interpolation between 16 equally spaced points multiplies it
 * by at most 2 in the middle. Where it is one-sided, near t = 0 without a mirror, it does so by 513, 56, 13, 5, 3 in
 * successive intervals. */
static double response_error(const sp_pulse *p, const response_points *g, double until, double error, double largest) {
    const double middle = 2, end = g->mirror == 0 ? 513 : 0, intervals = 1.2;
    double most, integral;
    pulse_bounds(p, until, &most, &integral);
    return (error + 8 * DBL_EPSILON * largest) * (middle * integral + end * fmin(integral, most * intervals * g->step));
}

/* One signal, with a fine and a coarse rule. The coarse rule is worse by orders of magnitude, so the difference exceeds
 * the error of the fine one. */
static sp_status convolve_pair(const response_points *g, const sp_pulse *pulse, double omega, double response_bound,
                               const sp_signal *s, double *f, double *error, sp_error *err) {
    const double panel = sp_pulse_panel(pulse, omega);
    const quadrature fine = {1, FINE_POINTS, 16, panel}, coarse = {2, COARSE_POINTS, 12, panel};
    double *check = sp_alloc((size_t)s->n, sizeof *check), worst = 0;
    sp_status status = check ? SP_OK : sp_fail_memory(err, (size_t)s->n * sizeof *check);
    if (status == SP_OK)
        status = convolve(g, pulse, &fine, s->n, s->t, f, err);
    if (status == SP_OK)
        status = convolve(g, pulse, &coarse, s->n, s->t, check, err);
    for (int32_t l = 0; l < s->n && status == SP_OK; l++)
        worst = fmax(worst, fabs(f[l] - check[l]));
    if (status == SP_OK)
        *error = worst + response_error(pulse, g, s->t[s->n - 1], response_bound, sp_largest(g->n, g->g));
    sp_free(check);
    return status;
}

/* Times of the response: from 0 to the last one needed, and some beyond for interpolation. */
static sp_status response_options(const sp_network *net, const sp_signal_options *opt, const sp_pulse *pulse,
                                  sp_signal_options *o, sp_error *err) {
    double first, last;
    const double step = FINE_STEP / sp_network_omega_bound(net);
    sp_pulse_span(pulse, &first, &last);
    const double until = opt->until - fmin(first, 0), steps = ceil(until / step) + 2 * FINE_POINTS;
    if (!(steps < TIMES_MAX))
        return sp_fail(err, SP_EREFUSED, "pulse: the response up to t = %g needs %.3g times, must be at most %d", until,
                       steps, TIMES_MAX);
    *o = *opt;
    o->points = (int32_t)steps + 1;
    o->until = step * steps;
    o->tolerance = 0.25 * opt->tolerance; /* with a pulse of both signs F may shrink more than its error */
    return SP_OK;
}

static sp_status check_errors(const sp_signal *s, double tolerance, sp_error *err) {
    for (int32_t q = 0; q < s->sources * s->detectors; q++) {
        const double largest = sp_largest(s->n, s->f + (int64_t)q * s->n);
        if (!(s->errors[q] <= tolerance * largest))
            return sp_fail(err, SP_EREFUSED,
                           "pulse: error bound %.3g is %.2g of the largest |F| = %.3g, must be at most %.2g",
                           s->errors[q], s->errors[q] / largest, largest, tolerance);
    }
    return SP_OK;
}

sp_status sp_signal_pulse(const sp_network *net, const sp_signal_options *opt, const sp_pulse *pulse, sp_signal *out,
                          sp_error *err) {
    sp_signal g = sp_signal_none(), s = sp_signal_none();
    sp_signal_options o;
    sp_status status = sp_pulse_check(pulse, err);
    if (status != SP_OK)
        return status;
    if (pulse->kind == SP_PULSE_DELTA)
        return sp_signal_make(net, opt, out, err);
    if (opt->method == SP_SIGNAL_DYNAMICS)
        return sp_fail(err, SP_EINVAL,
                       "pulse: method dynamics is nonlinear and allows no convolution, must be another method");
    if (opt->front)
        return sp_fail(err, SP_EINVAL, "pulse: only signals of a short pulse can end after the front");
    if (opt->points < 2 || !(opt->until > 0 && isfinite(opt->until)))
        return sp_fail(err, SP_EINVAL, "%d points until t = %g, must be 2 or more until a time above 0", opt->points,
                       opt->until);
    status = response_options(net, opt, pulse, &o, err);
    if (status == SP_OK)
        status = sp_signal_make(net, &o, &g, err);
    if (status == SP_OK)
        status = sp_signal_allocate(opt, g.sources, g.detectors, &s, err);
    s.omega_max = g.omega_max;
    s.products = g.products;
    s.method = g.method;
    s.step = g.step;
    s.modes = g.modes;
    for (int32_t q = 0; q < g.sources * g.detectors && status == SP_OK; q++) {
        const int mirror = o.damping > 0 ? 0 : o.source == SP_SOURCE_DISPLACEMENT ? 1 : -1;
        const response_points r = {g.n, o.until / (g.n - 1), g.f + (int64_t)q * g.n, mirror};
        status = convolve_pair(&r, pulse, g.omega_max, g.errors[q], &s, s.f + (int64_t)q * s.n, &s.errors[q], err);
        if (status == SP_OK)
            s.error = fmax(s.error, s.errors[q]);
    }
    if (status == SP_OK)
        status = check_errors(&s, opt->tolerance, err);
    sp_signal_free(&g);
    if (status == SP_OK)
        *out = s;
    else
        sp_signal_free(&s);
    return status;
}
