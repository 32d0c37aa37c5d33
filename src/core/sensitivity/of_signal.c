/* Gradients of linear functionals of a signal: its pass run backwards, and what source and detector add. */
#include "base/base.h"
#include "linalg/arrays.h"
#include "modes/count.h"
#include "sensitivity/forward.h"
#include "sensitivity/gradient.h"
#include "sensitivity/reverse.h"
#include "signal/recurrence.h"

#include <float.h>
#include <math.h>

/* ---- derivatives from the forward pass --------------------------------------------------------------------------- */

/* Rounding errors of derivatives, in units of DBL_EPSILON times the norms of fields and adjoints: 7 times the largest
 * one in tests/stress/test_stress_sensitivity.c, which is that of the phase Omega t at long times. Among few components
 * one may have all of it: chains of one to six grains took up to 760. */
static double rounding_of(const sp_network *net) {
    return (sp_network_dofs(net) <= SIGNAL_FEW_DOFS ? 1000 : 50) * DBL_EPSILON;
}

typedef struct adjoint_plan {
    const forward *f;
    const sp_moment_weights *weights;
    bool whole, masses;
    int threads;
} adjoint_plan;

/* Moments that the forward pass must have. */
static int64_t adjoint_terms(const sp_moment_weights *w) { return 2 * (w->terms / 2) + 3; }

/* D_k and E_k of the moments' weights: T_k W_k = (W_2k + W_0)/2 and T_k W_(k-1) = (W_(2k-1) - W_0)/2, but
 * T_k T_k = (T_2k + T_0)/2 and T_k T_(k-1) = (T_(2k-1) + T_1)/2. */
static void set_pairs(const sp_moment_weights *w, bool velocity, int64_t last, double *d, double *e) {
    d[0] = w->c[0];
    for (int64_t k = 1; k <= last; k++) {
        e[k] = 2 * w->c[2 * k - 1];
        d[k] = 2 * k < w->terms ? 2 * w->c[2 * k] : 0;
        d[0] += (velocity ? 0.5 * e[k] : 0) - 0.5 * d[k];
        if (!velocity && k == 1)
            e[1] = w->c[1];
        else if (!velocity)
            e[1] -= 0.5 * e[k];
    }
}

static sp_status work_make(const adjoint_plan *plan, reverse_work *w, sp_error *err) {
    const size_t n = (size_t)sp_network_dofs(plan->f->net);
    *w = (reverse_work){.last = plan->weights->terms / 2};
    const size_t terms = (size_t)w->last + 2;
    const sp_array arrays[] = {{&w->d, terms},
                               {&w->e, terms},
                               {&w->of[0], n},
                               {&w->of[1], n},
                               {&w->first[0], n},
                               {&w->first[1], n},
                               {&w->one[0], n},
                               {&w->one[1], n},
                               {&w->two[0], n},
                               {&w->two[1], n},
                               {&w->x, n},
                               {&w->added, n},
                               {0}};
    const sp_status status = sp_arrays_make(arrays, &w->memory, err);
    if (status == SP_OK)
        set_pairs(plan->weights, plan->f->velocity, w->last, w->d, w->e);
    return status;
}

/* Takes the sums of the reverse pass: factors, and bounds of the errors. */
static void take_springs(const adjoint_plan *plan, const reverse *r, sp_products *out) {
    const forward *f = plan->f;
    const double factor = 4 / (f->omega * f->omega), rounding = rounding_of(f->net) * r->rough;
    const double error = factor * (rounding + 0.5 * plan->weights->steep * f->norm_a * f->norm_b);
    const int64_t places = 4 * r->first[f->op.chunk[f->op.blocks]];
    for (int64_t place = 0; place < places; place++) {
        const int32_t k = r->index[place];
        if (k < 0)
            continue;
        double *at = out->at + (int64_t)k * out->width;
        sp_reverse_products(r, place, at);
        for (int a = 0; a < out->width; a++)
            at[a] *= -factor;
        for (int t = 0; t < 2; t++)
            out->error[2 * (int64_t)k + t] = error * sp_products_mobility(f->net, &f->net->springs[k], t == 1);
    }
}

/* What the source and the detector add: dJ = adjoint . d(place). A displacement or velocity that is given does not
 * depend on masses; then the adjoint is weighted with them. */
static void add_place(const adjoint_plan *plan, int which, double *adjoint, double norm, double rough,
                      sp_products *out) {
    const forward *f = plan->f;
    const bool weighted = which == 0 && f->source != SP_SOURCE_IMPULSE;
    const int64_t n = sp_network_dofs(f->net);
    for (int64_t k = 0; k < n && weighted; k++)
        adjoint[k] *= f->net->mass[k];
    for (int32_t k = 0; k < f->net->n_springs; k++) {
        const double *gap = f->gap[which] + 3 * (int64_t)k;
        const sp_spring *s = &f->net->springs[k];
        double x[SP_LOCAL_MAX] = {gap[0], gap[1], gap[2]}, y[SP_LOCAL_MAX];
        if (gap[0] == 0 && gap[1] == 0 && gap[2] == 0)
            continue;
        for (int a = f->net->dim; a < SP_LOCAL_MAX; a++)
            x[a] = 0;
        sp_products_local(f->net, s, adjoint, y);
        sp_products_add(out, k, -1, x, y);
        const double mass = weighted ? f->net->mass[(int64_t)s->i * f->net->dof] : 1;
        for (int t = 0; t < 2; t++)
            out->error[2 * (int64_t)k + t] +=
                rounding_of(f->net) * rough / norm * mass * sqrt(sp_products_mobility(f->net, s, t == 1));
    }
}

/* dJ/d ln m: the sums over the pass, and the first vectors, M^-1 times momenta. */
static void take_masses(const adjoint_plan *plan, const reverse *r, const reverse_work *w, sp_products *out) {
    const forward *f = plan->f;
    const sp_operator *op = &f->op;
    const int kinds = op->kind.rotations ? 2 : 1;
    const bool momenta = f->source == SP_SOURCE_IMPULSE;
    for (int64_t k = 0; k < op->n; k++) {
        const int64_t grain = op->grain[k];
        double sum = 0;
        for (int a = 0; a < op->dof; a++) {
            const double mass = r->weight[2 * kinds * k + (a >= op->kind.dim)];
            const int64_t at = grain * op->dof + a;
            sum += mass * r->density[(k * op->row + quad_component(a)) / 2];
            sum -= f->net->mass[at] * ((momenta ? w->of[0][at] * w->first[0][at] : 0) + w->of[1][at] * w->first[1][at]);
        }
        out->mass[grain] = sum;
        out->mass_error[grain] =
            4 * (rounding_of(f->net) * r->rough + 0.5 * plan->weights->steep * f->norm_a * f->norm_b);
    }
}

static sp_status adjoint_make(const adjoint_plan *plan, sp_products *out, sp_error *err) {
    const forward *f = plan->f;
    reverse r = {0};
    reverse_work w = {0};
    sp_products products = {0};
    struct snapshot from;
    sp_status status = sp_reverse_make(f, plan->whole, plan->masses, plan->threads, &r, err);
    if (status == SP_OK)
        status = work_make(plan, &w, err);
    if (status == SP_OK)
        status = sp_products_make(f->net, plan->whole, &products, err);
    if (status == SP_OK)
        status = sp_forward_state(f, w.last + 1, &from, err);
    if (status == SP_OK) {
        sp_reverse_run(&r, &from, &w);
        take_springs(plan, &r, &products);
        if (plan->masses)
            take_masses(plan, &r, &w, &products);
        for (int q = 0; q < 2; q++)
            add_place(plan, q, w.of[q], q == 0 ? f->norm_a : f->norm_b, r.rough, &products);
        *out = products;
    } else {
        sp_products_free(&products);
    }
    sp_free(w.memory);
    sp_reverse_free(&r);
    return status;
}

/* ---- functionals ------------------------------------------------------------------------------------------------- */

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
    sp_status status = sp_nodes_weights(nodes, f->omega, f->velocity, NULL, &w, err);
    if (status == SP_OK)
        status = sp_nodes_weights(nodes, f->omega, f->velocity, &f->power, &law, err);
    if (status == SP_OK)
        status = sp_forward_extend(f, adjoint_terms(w.terms > law.terms ? &w : &law), err);
    if (status == SP_OK)
        status = sp_forward_check(f, err);
    const adjoint_plan plan = {f, &w, sp_gradient_whole(f->net, opt->parameters), sp_gradient_masses(opt->parameters),
                               opt->threads};
    if (status == SP_OK)
        status = adjoint_make(&plan, &p, err);
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
