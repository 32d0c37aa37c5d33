/* Which method, with what parameters, and whether its result can be vouched for. */
#include "base/base.h"
#include "signal/chebyshev.h"
#include "signal/modal.h"

#include <math.h>
#include <sonopack/signal.h>

sp_signal_options sp_signal_options_default(void) {
    return (sp_signal_options){
        .method = SP_SIGNAL_AUTO, .source = SP_SOURCE_IMPULSE, .points = 801, .tolerance = 1e-10};
}

sp_signal sp_signal_none(void) { return (sp_signal){0}; }

void sp_signal_free(sp_signal *s) {
    sp_free(s->t);
    sp_free(s->f);
    *s = sp_signal_none();
}

double sp_signal_window(double height, double pressure) { return (8 * height + 40) * pow(pressure / 1e-4, -1.0 / 6); }

static sp_status check_options(const sp_signal_options *o, sp_error *err) {
    if (!(o->until > 0 && isfinite(o->until)))
        return sp_fail(err, SP_EINVAL, "until = %g, must be a time above 0", o->until);
    if (o->points < 2)
        return sp_fail(err, SP_EINVAL, "points = %d, must be 2 or more", o->points);
    if (!(o->tolerance > 0 && o->tolerance < 1))
        return sp_fail(err, SP_EINVAL, "tolerance = %g, must be above 0 and below 1", o->tolerance);
    if (o->method != SP_SIGNAL_AUTO && o->method != SP_SIGNAL_CHEBYSHEV && o->method != SP_SIGNAL_DENSE)
        return sp_fail(err, SP_EINVAL, "signal method %d, must be auto, chebyshev or dense", (int)o->method);
    return SP_OK;
}

/* Nanoseconds, roughly: a spring in a product of two vectors, a Bessel value, a mode's sine; and LAPACK's n^3. */
static sp_signal_method choose_method(const sp_network *net, const sp_signal_options *o, double omega) {
    const double n = (double)sp_network_dofs(net), terms = 0.5 * omega * o->until + 50;
    const double chebyshev = 0.5 * terms * (7.0 * net->n_springs + 2 * n) + 0.6 * terms * o->points;
    const double dense = 0.15 * n * n * n + n * (20.0 * net->n_springs + 15.0 * o->points);
    return dense < chebyshev && n <= SP_MODAL_DOFS ? SP_SIGNAL_DENSE : SP_SIGNAL_CHEBYSHEV;
}

/* Moments beyond what fits any machine's patience and memory. */
enum { TERMS_MAX = 20000000 };

static sp_status by_chebyshev(const sp_network *net, const sp_signal_options *o, sp_signal *s, sp_error *err) {
    sp_expansion e = {0};
    int64_t terms;
    if (0.5 * s->omega_max * o->until > TERMS_MAX)
        return sp_fail(err, SP_EREFUSED, "until = %g needs %.3g matrix products, %d at the most; take the dense method",
                       o->until, 0.5 * s->omega_max * o->until, TERMS_MAX);
    const bool velocity = o->source != SP_SOURCE_DISPLACEMENT;
    sp_status status = sp_expansion_terms(s->omega_max, o->until, velocity, 1e-8 * o->tolerance, &terms, err);
    if (status == SP_OK)
        status = sp_expansion_make(net, o->source, s->omega_max, terms, &e, err);
    if (status == SP_OK && !e.bounded)
        status = sp_fail(err, SP_EREFUSED, "the motion grows without bound: the network is unstable (prestress)");
    if (status == SP_OK)
        status = sp_expansion_sum(&e, s->n, s->t, s->f, &s->error, err);
    s->products = (int32_t)(terms - 1);
    sp_expansion_free(&e);
    return status;
}

/* |a||b|/Omega, or |a||b| for displacements: the scale of the signal of a single hop. */
static sp_status find_scale(const sp_network *net, sp_source source, double *scale, sp_error *err) {
    const int64_t n = sp_network_dofs(net);
    double *sent = sp_alloc((size_t)n, sizeof *sent), *seen = sp_alloc((size_t)n, sizeof *seen), a = 0, b = 0;
    sp_status status = sent && seen ? SP_OK : sp_fail_memory(err, 2 * (size_t)n * sizeof *sent);
    if (status == SP_OK)
        status = sp_network_source(net, source, sent, err);
    if (status == SP_OK)
        status = sp_network_detector(net, seen, err);
    const bool displacement = source == SP_SOURCE_DISPLACEMENT;
    for (int64_t k = 0; k < n && status == SP_OK; k++) {
        a += sent[k] * sent[k] * (displacement ? net->mass[k] : 1 / net->mass[k]);
        b += seen[k] * seen[k] / net->mass[k];
    }
    if (status == SP_OK)
        *scale = sqrt(a) * sqrt(b) / (displacement ? 1 : sp_network_omega_bound(net));
    sp_free(seen);
    sp_free(sent);
    return status;
}

/* Before anything arrives the signal is as small as one likes; there the error is held against a millionth of the scale
 * instead. */
static sp_status vouch(const sp_signal_options *o, const sp_signal *s, double scale, sp_error *err) {
    double largest = 0;
    for (int32_t l = 0; l < s->n; l++)
        largest = fmax(largest, fabs(s->f[l]));
    if (!(s->error <= o->tolerance * fmax(largest, 1e-6 * scale)))
        return sp_fail(err, SP_EREFUSED, "error bound %.3g is %.2g of the largest |F| = %.3g, must be at most %.2g",
                       s->error, s->error / largest, largest, o->tolerance);
    return SP_OK;
}

sp_status sp_signal_make(const sp_network *net, const sp_signal_options *opt, sp_signal *out, sp_error *err) {
    sp_signal s = sp_signal_none();
    double scale = 0;
    sp_status status = check_options(opt, err);
    if (status != SP_OK)
        return status;
    s.n = opt->points;
    s.omega_max = sp_network_omega_bound(net);
    s.method = opt->method == SP_SIGNAL_AUTO ? choose_method(net, opt, s.omega_max) : opt->method;
    s.t = sp_alloc((size_t)s.n, sizeof *s.t);
    s.f = sp_alloc((size_t)s.n, sizeof *s.f);
    if (!s.t || !s.f) {
        status = sp_fail_memory(err, 2 * (size_t)s.n * sizeof *s.t);
        goto out;
    }
    for (int32_t l = 0; l < s.n; l++)
        s.t[l] = l < s.n - 1 ? opt->until * l / (s.n - 1) : opt->until;
    status = s.method == SP_SIGNAL_DENSE ? sp_signal_by_modes(net, opt, &s, err) : by_chebyshev(net, opt, &s, err);
    if (status == SP_OK)
        status = find_scale(net, opt->source, &scale, err);
    if (status == SP_OK)
        status = vouch(opt, &s, scale, err);
out:
    if (status == SP_OK)
        *out = s;
    else
        sp_signal_free(&s);
    return status;
}
