/* Gradients of the first front, on the continuous signal. */
#include "base/base.h"
#include "modes/count.h"
#include "sensitivity/forward.h"

#include <float.h>
#include <math.h>

/* snapshots of the forward pass in a window: the reverse pass begins at the one behind the front; steps of a search for
 * a root */
enum { PARTS = 48, STEPS_MAX = 200 };

void sp_front_gradient_free(sp_front_gradient *g) {
    sp_gradient *all[] = {&g->t10, &g->t_peak, &g->peak, &g->t_zero, &g->width};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        sp_gradient_free(all[k]);
}

typedef struct search {
    const sp_sensitivity_options *opt;
    forward f;
    double until, spacing; /* of the points */
} search;

/* The derivative of the signal at a time, and a bound of its error. */
static sp_status evaluate(search *s, double t, int order, double *value, double *error, sp_error *err) {
    sp_nodes nodes = {0};
    sp_moment_weights w = {0};
    sp_status status = sp_nodes_add(&nodes, s->opt->pulse, s->f.omega, t, order, 1, err);
    if (status == SP_OK)
        status = sp_nodes_weights(&nodes, s->f.omega, s->f.velocity, NULL, &w, err);
    if (status == SP_OK)
        status = sp_forward_extend(&s->f, w.terms, err);
    if (status == SP_OK)
        *value = sp_forward_sum(&s->f, &w, sp_nodes_last(&nodes), error);
    sp_moment_weights_free(&w);
    sp_nodes_free(&nodes);
    return status;
}

/* ---- the points ----------------------------------------------------------------------------------------------- */

/* All of the window, though the gradient ends at the front: which peak counts depends on the largest value, and a
 * precursor with a zero crossing of its own looks like a front until that has come. */
static sp_status sample(const search *s, sp_front *out, sp_error *err) {
    const sp_pulse *pulse = s->opt->pulse;
    sp_signal signal = sp_signal_none();
    sp_signal_options o = sp_signal_options_default();
    o.method = SP_SIGNAL_CHEBYSHEV;
    o.source = s->opt->source;
    o.from = s->opt->from;
    o.to = s->opt->to;
    o.until = s->until;
    o.points = s->opt->points;
    o.threads = s->opt->threads > 0 ? s->opt->threads : 1;
    sp_status status = pulse && pulse->kind != SP_PULSE_DELTA ? sp_signal_pulse(s->f.net, &o, pulse, &signal, err)
                                                              : sp_signal_make(s->f.net, &o, &signal, err);
    if (status == SP_OK)
        status = sp_front_find(signal.n, signal.t, signal.f, &s->opt->front, out, err);
    sp_signal_free(&signal);
    return status;
}

/* ---- roots on the continuous signal --------------------------------------------------------------------------- */

/* A time near `guess` at which the derivative of this order is `level`: Newton's steps within a bracket. *slope: the
 * next derivative there. *error: of the time. */
static sp_status find_root(search *s, const char *what, double guess, int order, double level, double level_error,
                           double *at, double *slope, double *error, sp_error *err) {
    double low = fmax(guess - 2 * s->spacing, 0), high = guess + 2 * s->spacing, value, off, t = guess, low_value;
    sp_status status = evaluate(s, low, order, &low_value, &off, err);
    if (status == SP_OK)
        status = evaluate(s, high, order, &value, &off, err);
    if (status != SP_OK)
        return status;
    if (!((low_value - level) * (value - level) < 0))
        return sp_fail(err, SP_EREFUSED,
                       "front: no single %s near t = %g on the continuous signal; more points are needed", what, guess);
    for (int step = 0; step < STEPS_MAX && status == SP_OK; step++) {
        double slope_error;
        status = evaluate(s, t, order, &value, &off, err);
        if (status == SP_OK)
            status = evaluate(s, t, order + 1, slope, &slope_error, err);
        if (status != SP_OK)
            return status;
        if ((value - level) * (low_value - level) > 0)
            low = t;
        else
            high = t;
        const double next = t - (value - level) / *slope, before = t;
        t = next > low && next < high ? next : 0.5 * (low + high);
        if (!(fabs(t - before) > 4 * DBL_EPSILON * t)) {
            if (!(fabs(*slope) > 100 * slope_error))
                break;
            *at = t;
            *error = (off + level_error) / fabs(*slope) * 1.01 + 4 * DBL_EPSILON * t;
            return SP_OK;
        }
    }
    return sp_fail(err, SP_EREFUSED, "front: the signal is flat at the %s near t = %g: it has no derivative there",
                   what, guess);
}

/* Slopes at the three times. */
typedef struct slopes {
    double rise, curvature, fall;
} slopes;

static sp_status refine(search *s, sp_front_gradient *g, slopes *slope, sp_error *err) {
    double error;
    sp_front *to = &g->found;
    *to = g->sampled;
    sp_status status =
        find_root(s, "maximum", g->sampled.t_peak, 1, 0, 0, &to->t_peak, &slope->curvature, &g->t_peak_error, err);
    if (status == SP_OK)
        status = evaluate(s, to->t_peak, 0, &to->amplitude, &error, err);
    if (status != SP_OK)
        return status;
    g->peak_error = error + fabs(slope->curvature) * g->t_peak_error * g->t_peak_error;
    const double rise = s->opt->front.rise;
    status = find_root(s, "arrival", g->sampled.t10, 0, rise * to->amplitude, rise * g->peak_error, &to->t10,
                       &slope->rise, &g->t10_error, err);
    g->t_zero_error = NAN;
    if (status == SP_OK && isfinite(g->sampled.t_zero))
        status =
            find_root(s, "zero crossing", g->sampled.t_zero, 0, 0, 0, &to->t_zero, &slope->fall, &g->t_zero_error, err);
    to->width = to->t_zero - to->t10;
    g->width_error = g->t10_error + g->t_zero_error;
    return status;
}

/* ---- gradients ------------------------------------------------------------------------------------------------ */

/* Adds factor x the functional whose differential is that of the arrival: F(t_10) = rise x peak gives
 * dt_10 = (rise dF(t_peak) - dF(t_10))/F'(t_10). */
static sp_status add_arrival(const search *s, const sp_front *at, const slopes *slope, double factor, sp_nodes *nodes,
                             sp_error *err) {
    const double scale = factor / slope->rise;
    sp_status status = sp_nodes_add(nodes, s->opt->pulse, s->f.omega, at->t10, 0, -scale, err);
    if (status == SP_OK)
        status = sp_nodes_add(nodes, s->opt->pulse, s->f.omega, at->t_peak, 0, scale * s->opt->front.rise, err);
    return status;
}

static sp_status make_nodes(const search *s, const sp_front *at, const slopes *slope, sp_front_quantity which,
                            sp_nodes *nodes, sp_error *err) {
    const sp_pulse *pulse = s->opt->pulse;
    sp_status status = SP_OK;
    if (which == SP_FRONT_T10)
        return add_arrival(s, at, slope, 1, nodes, err);
    if (which == SP_FRONT_PEAK)
        return sp_nodes_add(nodes, pulse, s->f.omega, at->t_peak, 0, 1, err);
    if (which == SP_FRONT_T_PEAK)
        return sp_nodes_add(nodes, pulse, s->f.omega, at->t_peak, 1, -1 / slope->curvature, err);
    if (which == SP_FRONT_WIDTH)
        status = add_arrival(s, at, slope, -1, nodes, err);
    if (status == SP_OK)
        status = sp_nodes_add(nodes, pulse, s->f.omega, at->t_zero, 0, -1 / slope->fall, err);
    return status;
}

/* The times at which the functional is taken are known to `off` only: the derivatives change by at most the largest
 * frequency times that. */
static void add_errors(sp_gradient *g, double relative) {
    sp_partials *all[] = {&g->kn, &g->kt, &g->mass, &g->radius, &g->position, &g->pressure};
    for (size_t q = 0; q < sizeof all / sizeof *all; q++) {
        double largest = 0;
        for (int64_t k = 0; k < all[q]->n; k++)
            largest = fmax(largest, fabs(all[q]->d[k]));
        for (int64_t k = 0; k < all[q]->n; k++)
            all[q]->error[k] += relative * largest;
    }
}

static sp_status differentiate(search *s, unsigned quantities, const slopes *slope, sp_front_gradient *g,
                               sp_error *err) {
    const struct {
        sp_front_quantity which;
        sp_gradient *to;
        double value, error;
    } all[] = {{SP_FRONT_T10, &g->t10, g->found.t10, g->t10_error},
               {SP_FRONT_T_PEAK, &g->t_peak, g->found.t_peak, g->t_peak_error},
               {SP_FRONT_PEAK, &g->peak, g->found.amplitude, g->peak_error},
               {SP_FRONT_T_ZERO, &g->t_zero, g->found.t_zero, g->t_zero_error},
               {SP_FRONT_WIDTH, &g->width, g->found.width, g->width_error}};
    sp_status status = SP_OK;
    for (size_t q = 0; q < sizeof all / sizeof *all && status == SP_OK; q++) {
        sp_nodes nodes = {0};
        if (!(quantities & all[q].which))
            continue;
        status = make_nodes(s, &g->found, slope, all[q].which, &nodes, err);
        if (status == SP_OK)
            status = sp_functional_gradient(&s->f, s->opt, &nodes, all[q].to, err);
        sp_nodes_free(&nodes);
        if (status != SP_OK)
            return status;
        all[q].to->value = all[q].value;
        all[q].to->error = all[q].error;
        add_errors(all[q].to,
                   s->f.omega * (g->t_peak_error + g->t10_error + (isfinite(g->t_zero_error) ? g->t_zero_error : 0)));
    }
    return status;
}

static sp_status check(const sp_sensitivity_options *opt, unsigned quantities, sp_error *err) {
    if (quantities == 0 || quantities >= 2 * SP_FRONT_WIDTH)
        return sp_fail(err, SP_EINVAL, "quantities %u, must be a sum of 1 .. %u", quantities, (unsigned)SP_FRONT_WIDTH);
    if (opt->points < 100)
        return sp_fail(err, SP_EINVAL, "points = %d, must be 100 or more", opt->points);
    if (!(opt->until >= 0 && isfinite(opt->until)))
        return sp_fail(err, SP_EINVAL, "until = %g, must be a time above 0, or 0", opt->until);
    return SP_OK;
}

sp_status sp_sensitivity_front(const sp_network *net, const sp_sensitivity_options *opt, unsigned quantities,
                               sp_front_gradient *out, sp_error *err) {
    search s = {.opt = opt, .until = opt->until};
    sp_front_gradient g = {.t10 = sp_gradient_none(),
                           .t_peak = sp_gradient_none(),
                           .peak = sp_gradient_none(),
                           .t_zero = sp_gradient_none(),
                           .width = sp_gradient_none()};
    slopes slope = {0};
    sp_status status = sp_functional_check(net, opt, err);
    if (status == SP_OK)
        status = check(opt, quantities, err);
    if (status != SP_OK)
        return status;
    if (s.until == 0)
        s.until = sp_signal_window(net->box[net->dim - 1], net->pressure);
    s.spacing = s.until / (opt->points - 1);
    double first = 0, last = 0;
    if (opt->pulse)
        sp_pulse_span(opt->pulse, &first, &last);
    const int64_t terms = sp_functional_terms(sp_network_omega_bound(net), s.until + 4 * s.spacing - fmin(first, 0));
    status = sp_need_bounded(net, s.until, err);
    if (status == SP_OK)
        status = sp_forward_make(net, opt, terms, terms / PARTS, &s.f, err);
    if (status == SP_OK)
        status = sample(&s, &g.sampled, err);
    if (status == SP_OK)
        status = refine(&s, &g, &slope, err);
    if (status == SP_OK && (quantities & (SP_FRONT_T_ZERO | SP_FRONT_WIDTH)) && !isfinite(g.found.t_zero))
        status = sp_fail(err, SP_EREFUSED, "no zero crossing after the first peak up to t = %g", s.until);
    if (status == SP_OK)
        status = differentiate(&s, quantities, &slope, &g, err);
    sp_forward_free(&s.f);
    if (status == SP_OK)
        *out = g;
    else
        sp_front_gradient_free(&g);
    return status;
}
