/* Gradients of linear functionals of a signal. */
#include "base/base.h"
#include "modes/count.h"
#include "sensitivity/adjoint.h"
#include "sensitivity/functional.h"
#include "sensitivity/gradient.h"

#include <math.h>

enum { TERMS_MAX = 20000000 };

sp_sensitivity_options sp_sensitivity_options_default(void) {
    return (sp_sensitivity_options){.parameters = SP_BY_KN | SP_BY_KT,
                                    .source = SP_SOURCE_IMPULSE,
                                    .points = 2000,
                                    .front = sp_front_options_default(),
                                    .threads = 1};
}

sp_status sp_functional_check(const sp_network *net, const sp_sensitivity_options *opt, sp_error *err) {
    sp_status status = sp_gradient_check(net, opt->parameters, opt->packing, err);
    if (status == SP_OK)
        status = sp_nodes_check_pulse(opt->pulse, err);
    return status;
}

static sp_status check_times(const sp_functional *j, double omega, sp_error *err) {
    if (j->n < 1 || !j->t || !j->weight)
        return sp_fail(err, SP_EINVAL, "a functional of %lld times, must be of 1 or more", (long long)j->n);
    for (int64_t k = 0; k < j->n; k++) {
        if (!(j->t[k] >= 0 && isfinite(j->t[k]) && isfinite(j->weight[k])))
            return sp_fail(err, SP_EINVAL, "time %g with weight %g, must be 0 or above with a finite weight", j->t[k],
                           j->weight[k]);
        if (j->order && (j->order[k] < 0 || j->order[k] > 2))
            return sp_fail(err, SP_EINVAL, "derivative of order %d, must be 0 .. 2", j->order[k]);
        if (0.5 * omega * j->t[k] > TERMS_MAX)
            return sp_fail(err, SP_EREFUSED, "time %g needs %.3g matrix products, must be at most %d", j->t[k],
                           0.5 * omega * j->t[k], TERMS_MAX);
    }
    return SP_OK;
}

static sp_status make_nodes(const sp_network *net, const sp_sensitivity_options *opt, const sp_functional *j,
                            sp_nodes *out, sp_error *err) {
    const double omega = sp_network_omega_bound(net);
    sp_status status = check_times(j, omega, err);
    for (int64_t k = 0; k < j->n && status == SP_OK; k++)
        status = sp_nodes_add(out, opt->pulse, omega, j->t[k], j->order ? j->order[k] : 0, j->weight[k], err);
    return status;
}

sp_status sp_functional_gradient(forward *f, const sp_sensitivity_options *opt, const sp_nodes *nodes, sp_gradient *out,
                                 sp_error *err) {
    sp_moment_weights w = {0}, law = {0};
    sp_products p = {0};
    sp_gradient g = sp_gradient_none();
    double value = 0, error = 0, change = 0, off;
    sp_status status = sp_nodes_weights(nodes, f->omega, f->velocity, &w, err);
    if (status == SP_OK)
        status = sp_nodes_law(nodes, f->omega, f->velocity, f->power, &law, err);
    if (status == SP_OK)
        status = sp_forward_extend(f, sp_adjoint_terms(w.terms > law.terms ? &w : &law), err);
    if (status == SP_OK)
        status = sp_forward_check(f, err);
    const adjoint_plan plan = {f, &w, sp_gradient_whole(f->net, opt->parameters), sp_gradient_masses(opt->parameters),
                               opt->threads};
    if (status == SP_OK)
        status = sp_adjoint_make(&plan, &p, err);
    if (status == SP_OK) {
        value = sp_forward_sum(f, &w, sp_nodes_last(nodes), &error);
        change = sp_forward_sum(f, &law, sp_nodes_last(nodes), &off);
        status = sp_gradient_make(&p, opt->parameters, opt->packing, change, &g, err);
    }
    sp_products_free(&p);
    sp_moment_weights_free(&law);
    sp_moment_weights_free(&w);
    if (status != SP_OK) {
        sp_gradient_free(&g);
        return status;
    }
    g.value = value;
    g.error = error;
    *out = g;
    return SP_OK;
}

/* The terms that the last time of all functionals needs, with those of its derivatives. */
int64_t sp_functional_terms(double omega, double last) {
    return (int64_t)(0.5 * (omega * last + 30 + 15 * cbrt(omega * last))) + 32;
}

sp_status sp_sensitivity_signal(const sp_network *net, const sp_sensitivity_options *opt, int32_t count,
                                const sp_functional *functional, sp_gradient *out, sp_error *err) {
    sp_status status = sp_functional_check(net, opt, err);
    if (status != SP_OK)
        return status;
    if (count < 1)
        return sp_fail(err, SP_EINVAL, "%d functionals, must be 1 or more", count);
    sp_nodes *nodes = sp_alloc((size_t)count, sizeof *nodes);
    sp_gradient *g = sp_alloc((size_t)count, sizeof *g);
    forward f = {0};
    double last = 0;
    if (!nodes || !g)
        status = sp_fail_memory(err, (size_t)count * sizeof *g);
    for (int32_t k = 0; k < count && status == SP_OK; k++) {
        status = make_nodes(net, opt, &functional[k], &nodes[k], err);
        last = fmax(last, sp_nodes_last(&nodes[k]));
    }
    const int64_t terms = sp_functional_terms(sp_network_omega_bound(net), last);
    if (status == SP_OK && last > 0)
        status = sp_need_bounded(net, last, err);
    if (status == SP_OK)
        status = sp_forward_make(net, opt, terms, terms / 2 / FORWARD_SNAPSHOTS, &f, err);
    for (int32_t k = 0; k < count && status == SP_OK; k++)
        status = sp_functional_gradient(&f, opt, &nodes[k], &g[k], err);
    for (int32_t k = 0; k < count && g && nodes; k++) {
        if (status == SP_OK)
            out[k] = g[k];
        else
            sp_gradient_free(&g[k]);
        sp_nodes_free(&nodes[k]);
    }
    sp_forward_free(&f);
    sp_free(nodes);
    sp_free(g);
    return status;
}
