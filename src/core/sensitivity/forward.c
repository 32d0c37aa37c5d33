/* The forward pass of sensitivities. */
#include "sensitivity/forward.h"

#include "base/base.h"
#include "network/place.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* A field counts as having reached a block when its norm there exceeds this fraction of the first one. */
#define REACHED 1e-19
/* Factors of the rounding errors of sums, as in signal/pass.c. */
#define MOMENT_ROUNDING 5.0
#define PHASE_ROUNDING  5.0

void sp_forward_free(forward *f) {
    sp_pass_free(&f->p);
    sp_operator_free(&f->op);
    for (int q = 0; q < 2; q++) {
        sp_free(f->gap[q]);
        sp_free(f->since[q]);
    }
    for (int q = 0; q < FORWARD_SNAPSHOTS; q++) {
        sp_free(f->kept[q].u);
        sp_free(f->kept[q].v);
    }
    sp_sparse_row_free(&f->from);
    sp_sparse_row_free(&f->to);
    *f = (forward){0};
}

static sp_status make_row(const forward *f, const double *vector, const double *mass, sparse_row *out, sp_error *err) {
    const sp_status status = sp_sparse_row_make(sp_network_dofs(f->net), vector, out, err);
    if (status == SP_OK)
        sp_sparse_row_turn(&f->op, mass, out);
    return status;
}

static bool any_gap(const sp_network *net, const double *gap) {
    for (int64_t k = 0; k < 3 * (int64_t)net->n_springs; k++)
        if (gap[k] != 0)
            return true;
    return false;
}

static sp_status make_places(forward *f, const sp_sensitivity_options *opt, sp_error *err) {
    const sp_place wall = sp_place_wall(), *at[2] = {opt->from ? opt->from : &wall, opt->to ? opt->to : &wall};
    double *vector = sp_alloc((size_t)sp_network_dofs(f->net), sizeof *vector);
    sp_status status = vector ? SP_OK : sp_fail_memory(err, (size_t)sp_network_dofs(f->net) * sizeof *vector);
    if (status == SP_OK)
        status = sp_network_source_at(f->net, opt->source, at[0], vector, err);
    if (status == SP_OK)
        status = make_row(f, vector, f->velocity ? NULL : f->net->mass, &f->from, err);
    if (status == SP_OK)
        status = sp_network_detector_at(f->net, at[1], vector, err);
    if (status == SP_OK)
        status = make_row(f, vector, NULL, &f->to, err);
    f->power = f->velocity ? -0.5 : 0;
    for (int q = 0; q < 2 && status == SP_OK; q++) {
        f->gap[q] = sp_alloc(3 * (size_t)f->net->n_springs, sizeof **f->gap);
        if (!f->gap[q]) {
            status = sp_fail_memory(err, 3 * (size_t)f->net->n_springs * sizeof **f->gap);
            break;
        }
        sp_place_gaps(f->net, at[q], q == 0, f->gap[q]);
        f->power += any_gap(f->net, f->gap[q]);
    }
    sp_free(vector);
    return status;
}

static sp_status make_memory(forward *f, sp_error *err) {
    const size_t blocks = (size_t)f->op.blocks, size = ((size_t)f->op.n + 1) * (size_t)f->op.row;
    bool fits = true;
    for (int q = 0; q < 2; q++) {
        f->since[q] = sp_alloc(blocks, sizeof **f->since);
        fits = fits && f->since[q];
        for (size_t b = 0; fits && b < blocks; b++)
            f->since[q][b] = f->op.blocks == 1 ? 0 : INT32_MAX;
    }
    for (int q = 0; q < FORWARD_SNAPSHOTS; q++) {
        f->kept[q] = (struct snapshot){-1, sp_alloc(size, sizeof(double)), sp_alloc(size, sizeof(double))};
        fits = fits && f->kept[q].u && f->kept[q].v;
    }
    return fits ? SP_OK : sp_fail_memory(err, 2 * FORWARD_SNAPSHOTS * size * sizeof(double));
}

/* Notes which blocks the fields have reached since the last look, FORWARD_STRIDE steps ago. */
static void look(forward *f) {
    const recurrence *r = &f->p.r;
    for (int32_t b = 0; b < f->op.blocks; b++) {
        if (!r->awake[b] || (f->since[0][b] < INT32_MAX && f->since[1][b] < INT32_MAX))
            continue;
        const pair squares = sp_recurrence_block_squares(r, b, r->u);
        for (int q = 0; q < 2; q++)
            if (f->since[q][b] == INT32_MAX && squares[q] > REACHED * REACHED * r->start[q])
                f->since[q][b] = r->step < FORWARD_STRIDE ? 0 : (int32_t)(r->step - FORWARD_STRIDE);
    }
}

static void keep(forward *f) {
    const size_t size = ((size_t)f->op.n + 1) * (size_t)f->op.row;
    f->newest = (f->newest + 1) % FORWARD_SNAPSHOTS;
    struct snapshot *to = &f->kept[f->newest];
    to->step = f->p.r.step;
    memcpy(to->u, f->p.r.u, size * sizeof *to->u);
    memcpy(to->v, f->p.r.v, size * sizeof *to->v);
}

/* As many matrix products as a signal may take; beyond, the moments alone would be gigabytes. */
static const int64_t terms_most = 40000000;

sp_status sp_forward_make(const sp_network *net, const sp_sensitivity_options *opt, int64_t terms, int64_t every,
                          forward *out, sp_error *err) {
    forward f = {.net = net,
                 .velocity = opt->source != SP_SOURCE_DISPLACEMENT,
                 .omega = sp_network_omega_bound(net),
                 .capacity = terms + 2 * FORWARD_STRIDE + 4,
                 .every = every < FORWARD_STRIDE ? FORWARD_STRIDE : every,
                 .source = opt->source};
    if (terms > terms_most)
        return sp_fail(err, SP_EREFUSED, "the last time needs %.3g matrix products, must be at most %.3g",
                       0.5 * (double)terms, 0.5 * (double)terms_most);
    sp_status status = sp_operator_make(net, &f.op, err);
    if (status == SP_OK)
        status = make_places(&f, opt, err);
    if (status == SP_OK)
        status = make_memory(&f, err);
    const pass_plan plan = {.op = &f.op,
                            .mass = net->mass,
                            .omega = f.omega,
                            .threads = opt->threads,
                            .velocity = f.velocity,
                            .doubled = true,
                            .terms = f.capacity,
                            .lanes = 1,
                            .observer_count = 1,
                            .propagated = &f.from,
                            .observers = &f.to};
    if (status == SP_OK)
        status = sp_pass_make(&plan, &f.p, err);
    if (status != SP_OK) {
        sp_forward_free(&f);
        return status;
    }
    /* the pass points to its operator and rows: they move with the struct */
    *out = f;
    out->p.r.op = &out->op;
    out->p.observers = &out->to;
    out->norm_a = sqrt(out->p.r.start[0]);
    out->norm_b = sqrt(out->p.r.start[1]);
    look(out);
    return SP_OK;
}

sp_status sp_forward_extend(forward *f, int64_t terms, sp_error *err) {
    if (terms > f->capacity - 2 * FORWARD_STRIDE)
        return sp_fail(err, SP_EREFUSED, "the series needs %lld terms, more than expected", (long long)terms);
    while (f->p.n < terms) {
        for (int q = 0; q < FORWARD_STRIDE; q++) {
            sp_pass_extend(&f->p, f->p.n + 2);
            if (f->p.r.step == 1)
                look(f); /* blocks next to source and detector */
        }
        look(f);
        const bool last = f->p.n >= terms;
        if (last || f->p.r.step >= f->kept[f->newest].step + f->every)
            keep(f);
    }
    return SP_OK;
}

sp_status sp_forward_state(const forward *f, int64_t least, struct snapshot *out, sp_error *err) {
    const struct snapshot *best = NULL;
    for (int q = 0; q < FORWARD_SNAPSHOTS; q++)
        if (f->kept[q].step >= least && (!best || f->kept[q].step < best->step))
            best = &f->kept[q];
    if (!best)
        return sp_fail(err, SP_EFAILED, "the pass has %lld steps, %lld are needed", (long long)f->p.r.step,
                       (long long)least);
    *out = *best;
    return SP_OK;
}

/* Moment k; the pass halves the first one of T. */
static double moment(const forward *f, int64_t k) { return k == 0 && !f->velocity ? 2 * f->p.mu[0] : f->p.mu[k]; }

double sp_forward_sum(const forward *f, const sp_moment_weights *w, double last, double *error) {
    double sum = 0, moments = 0, phases = 0;
    for (int64_t k = w->terms - 1; k >= 0; k--) {
        const double term = w->c[k] * moment(f, k), size = w->c[k] * f->p.size[k] * sqrt(1 + (double)k);
        sum += term;
        moments += size * size;
        phases += term * term;
    }
    *error = DBL_EPSILON * (MOMENT_ROUNDING * sqrt(moments) + PHASE_ROUNDING * (1 + f->omega * last) * sqrt(phases)) +
             w->tail * f->norm_a * f->norm_b;
    return sum;
}

sp_status sp_forward_check(const forward *f, sp_error *err) {
    if (!(f->norm_a > 0 && f->norm_b > 0)) /* shear at smooth contacts across the plane */
        return sp_fail(err, SP_EREFUSED, "the %s meets no spring that acts along it: its signal is 0 whatever changes",
                       f->norm_a > 0 ? "detector" : "source");
    if (!sp_pass_bounded(&f->p))
        return sp_fail(err, SP_EREFUSED, "the motion grows without bound: the network is unstable (prestress)");
    return SP_OK;
}
