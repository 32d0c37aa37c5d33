/* Derivatives of functionals of a signal from its forward pass. */
#include "sensitivity/adjoint.h"

#include "base/base.h"
#include "sensitivity/reverse.h"

#include <float.h>
#include <math.h>

/* Rounding errors of derivatives, in units of DBL_EPSILON times the norms of fields and adjoints: 7 times the largest
 * one in tests/stress/test_stress_sensitivity.c, which is that of the phase Omega t at long times. */
#define ROUNDING 50.0

int64_t sp_adjoint_terms(const sp_moment_weights *w) { return 2 * (w->terms / 2) + 3; }

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

typedef struct work {
    double *memory, *d, *e, *alpha, *beta, *a0, *b0;
    int64_t last;
} work;

static sp_status work_make(const adjoint_plan *plan, work *w, sp_error *err) {
    const size_t n = (size_t)sp_network_dofs(plan->f->net);
    *w = (work){.last = plan->weights->terms / 2};
    const size_t terms = (size_t)w->last + 2;
    w->memory = sp_alloc(2 * terms + 4 * n, sizeof *w->memory);
    if (!w->memory)
        return sp_fail_memory(err, (2 * terms + 4 * n) * sizeof *w->memory);
    w->d = w->memory;
    w->e = w->d + terms;
    w->alpha = w->e + terms;
    w->beta = w->alpha + n;
    w->a0 = w->beta + n;
    w->b0 = w->a0 + n;
    set_pairs(plan->weights, plan->f->velocity, w->last, w->d, w->e);
    return SP_OK;
}

/* Takes the sums of the reverse pass: factors, and bounds of the errors. */
static void take_springs(const adjoint_plan *plan, const reverse *r, sp_products *out) {
    const forward *f = plan->f;
    const double factor = 4 / (f->omega * f->omega), rounding = ROUNDING * DBL_EPSILON * r->rough;
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
                ROUNDING * DBL_EPSILON * rough / norm * mass * sqrt(sp_products_mobility(f->net, s, t == 1));
    }
}

/* dJ/d ln m: the sums over the pass, and the first vectors, M^-1 times momenta. */
static void take_masses(const adjoint_plan *plan, const reverse *r, const work *w, sp_products *out) {
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
            sum -= f->net->mass[at] * ((momenta ? w->alpha[at] * w->a0[at] : 0) + w->beta[at] * w->b0[at]);
        }
        out->mass[grain] = sum;
        out->mass_error[grain] =
            4 * (ROUNDING * DBL_EPSILON * r->rough + 0.5 * plan->weights->steep * f->norm_a * f->norm_b);
    }
}

static sp_status run(const adjoint_plan *plan, reverse *r, work *w, sp_products *out, sp_error *err) {
    const forward *f = plan->f;
    struct snapshot from;
    sp_status status = sp_forward_state(f, w->last + 1, &from, err);
    if (status != SP_OK)
        return status;
    sp_reverse_start(r, from.u, from.v);
    status = sp_reverse_run(r, from.step, w->last, w->d, w->e, w->alpha, w->beta, w->a0, w->b0, err);
    if (status != SP_OK)
        return status;
    take_springs(plan, r, out);
    if (plan->masses)
        take_masses(plan, r, w, out);
    add_place(plan, 0, w->alpha, f->norm_a, r->rough, out);
    add_place(plan, 1, w->beta, f->norm_b, r->rough, out);
    return SP_OK;
}

sp_status sp_adjoint_make(const adjoint_plan *plan, sp_products *out, sp_error *err) {
    const forward *f = plan->f;
    const reverse_plan spec = {.net = f->net,
                               .op = &f->op,
                               .omega = f->omega,
                               .velocity = f->velocity,
                               .whole = plan->whole,
                               .masses = plan->masses,
                               .threads = plan->threads,
                               .since = {f->since[0], f->since[1]}};
    reverse r = {0};
    work w = {0};
    sp_products products = {0};
    sp_status status = sp_reverse_make(&spec, &r, err);
    if (status == SP_OK)
        status = work_make(plan, &w, err);
    if (status == SP_OK)
        status = sp_products_make(f->net, plan->whole, &products, err);
    if (status == SP_OK)
        status = run(plan, &r, &w, &products, err);
    sp_free(w.memory);
    sp_reverse_free(&r);
    if (status == SP_OK)
        *out = products;
    else
        sp_products_free(&products);
    return status;
}
