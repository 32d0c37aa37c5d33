/* Signals by the Chebyshev expansion, for all sources and detectors. */
#include "base/base.h"
#include "signal/job.h"
#include "signal/pass.h"

#include <math.h>
#include <sonopack/front.h>
#include <string.h>

/* limit of the number of moments; times per sum; parts of the time in which a front is sought */
enum { TERMS_MAX = 20000000, TIMES = 4096, PARTS = 48 };

/* All passes of a signal. Each pass propagates two sources, or two detectors if these are fewer. */
typedef struct passes {
    const signal_job *job;
    sp_operator op;
    bool doubled, reversed; /* reversed: detectors are propagated */
    int32_t n;
    int64_t terms;
    double omega;
    pass *pass;         /* [n] */
    double *f, *errors; /* results of one pass, [columns][TIMES] and [columns] */
} passes;

static void passes_free(passes *a) {
    for (int32_t q = 0; a->pass && q < a->n; q++)
        sp_pass_free(&a->pass[q]);
    sp_free(a->pass);
    sp_free(a->f);
    sp_free(a->errors);
    sp_operator_free(&a->op);
}

/* Whether a source may push motions that nothing resists, such as a free grain. Their displacements grow with time, and
 * their rounding errors with these; a detector, which is a force, has no part of them. The normals of wall contacts
 * have none either. */
static bool may_drift(const signal_job *job) {
    bool drifts = false;
    for (int32_t k = 0; k < job->sources && job->options->from; k++) {
        const sp_place *p = &job->options->from[k];
        drifts = drifts || p->shear || p->kind == SP_PLACE_GRAIN || p->kind == SP_PLACE_PLANE;
    }
    return drifts && job_has_momenta(job);
}

static sp_status passes_make(const signal_job *job, double omega, int64_t terms, passes *a, sp_error *err) {
    *a = (passes){.job = job, .omega = omega, .terms = terms};
    a->doubled = job->sources == 1 && job->detectors == 1 && !job->net->carried;
    a->reversed = job->detectors < job->sources || (job->detectors <= 2 && may_drift(job));
    const int32_t propagated = a->reversed ? job->detectors : job->sources,
                  observers = a->reversed ? job->sources : job->detectors;
    a->n = (propagated + 1) / 2;
    sp_status status = sp_operator_make(job->net, &a->op, err);
    a->op.kind.transposed = a->reversed && job->net->carried;
    if (status != SP_OK)
        return status;
    for (int32_t k = 0; k < job->sources; k++)
        sp_sparse_row_turn(&a->op, job_has_momenta(job) ? NULL : job->net->mass, &job->from[k]);
    for (int32_t k = 0; k < job->detectors; k++)
        sp_sparse_row_turn(&a->op, NULL, &job->to[k]);
    const size_t columns = (propagated > 1 ? 2 : 1) * (size_t)observers;
    a->pass = sp_alloc((size_t)a->n, sizeof *a->pass);
    a->f = sp_alloc(columns, TIMES * sizeof *a->f);
    a->errors = sp_alloc(columns, sizeof *a->errors);
    return a->pass && a->f && a->errors ? SP_OK : sp_fail_memory(err, columns * TIMES * sizeof *a->f);
}

static sp_status begin_pass(passes *a, int32_t q, sp_error *err) {
    const signal_job *job = a->job;
    const int32_t propagated = a->reversed ? job->detectors : job->sources;
    const pass_plan plan = {.op = &a->op,
                            .mass = job->net->mass,
                            .omega = a->omega,
                            .threads = job->options->threads,
                            .velocity = job_has_momenta(job),
                            .doubled = a->doubled,
                            .spread = sp_expansion_spread(job->net),
                            .terms = a->terms,
                            .lanes = propagated - 2 * q < 2 ? 1 : 2,
                            .observer_count = a->reversed ? job->sources : job->detectors,
                            .propagated = (a->reversed ? job->to : job->from) + 2 * q,
                            .observers = a->reversed ? job->from : job->to};
    return sp_pass_make(&plan, &a->pass[q], err);
}

/* Index of the pair (source, detector) of column c of pass q. */
static int64_t pair_of(const passes *a, int32_t q, int64_t c) {
    const int32_t observer_count = a->pass[q].observer_count;
    const int64_t propagated = 2 * (int64_t)q + c / observer_count, other = c % observer_count;
    return a->reversed ? other * a->job->detectors + propagated : propagated * a->job->detectors + other;
}

/* Sums pass q at times first .. end-1, for which its moments suffice. */
static sp_status sum_pass(const passes *a, int32_t q, int32_t first, int32_t end, sp_signal *s, sp_error *err) {
    const pass *p = &a->pass[q];
    sp_status status = SP_OK;
    for (int32_t at = first; at < end && status == SP_OK; at += TIMES) {
        const int32_t count = end - at < TIMES ? end - at : TIMES;
        status = sp_pass_sum(p, a->omega, count, s->t + at, TIMES, a->f, a->errors, err);
        for (int64_t c = 0; c < p->columns && status == SP_OK; c++) {
            const int64_t to = pair_of(a, q, c);
            memcpy(s->f + to * s->n + at, a->f + c * TIMES, (size_t)count * sizeof *s->f);
            s->errors[to] = fmax(s->errors[to], a->errors[c]);
        }
    }
    return status;
}

/* Counts products and checks stability at the end of a pass. */
static sp_status end_pass(const passes *a, const pass *p, sp_signal *s, sp_error *err) {
    s->products += (int32_t)(a->doubled ? p->n - 1 : p->lanes * (p->n - 1));
    if (!sp_pass_bounded(p))
        return sp_fail(err, SP_EREFUSED, "the motion grows without bound: the network is unstable (prestress)");
    return SP_OK;
}

static sp_status run_all(passes *a, sp_signal *s, sp_error *err) {
    sp_status status = SP_OK;
    for (int32_t q = 0; q < a->n && status == SP_OK; q++) {
        status = begin_pass(a, q, err);
        if (status != SP_OK)
            break;
        sp_pass_extend(&a->pass[q], a->terms);
        status = end_pass(a, &a->pass[q], s, err);
        if (status == SP_OK)
            status = sum_pass(a, q, 0, s->n, s, err);
        sp_pass_free(&a->pass[q]);
    }
    return status;
}

/* ---- until the first front ------------------------------------------------------------------------------------ */

/* Whether every signal has its front and zero crossing in the first n points. Ripples before the front are ignored:
 * they are too small. */
static bool fronts_known(const passes *a, const sp_signal *s, int32_t n) {
    const sp_front_options options = sp_front_options_default();
    for (int64_t k = 0; k < (int64_t)s->sources * s->detectors; k++) {
        sp_front front;
        if (n < 3 || sp_front_find(n, s->t, s->f + k * s->n, &options, &front, NULL) != SP_OK)
            return false;
        const double scale = sp_job_scale(a->job, (int32_t)(k / s->detectors), (int32_t)(k % s->detectors));
        if (!(isfinite(front.t_zero) && front.amplitude > 1e-6 * scale))
            return false;
    }
    return true;
}

static void shorten(sp_signal *s, int32_t n) {
    for (int64_t k = 1; k < (int64_t)s->sources * s->detectors; k++)
        memmove(s->f + k * n, s->f + k * s->n, (size_t)n * sizeof *s->f);
    s->n = n;
}

static sp_status run_to_front(passes *a, sp_signal *s, sp_error *err) {
    const double tail = 1e-8 * a->job->options->tolerance;
    sp_status status = SP_OK;
    int32_t known = 0;
    for (int32_t q = 0; q < a->n && status == SP_OK; q++)
        status = begin_pass(a, q, err);
    while (status == SP_OK && known < s->n && !fronts_known(a, s, known)) {
        const int32_t more = s->n / PARTS > 8 ? s->n / PARTS : 8, end = s->n - known < more ? s->n : known + more;
        int64_t terms;
        status = sp_expansion_terms(a->job->net, s->t[end - 1], job_has_momenta(a->job), tail, &terms, err);
        for (int32_t q = 0; q < a->n && status == SP_OK; q++) {
            sp_pass_extend(&a->pass[q], terms);
            status = sum_pass(a, q, known, end, s, err);
        }
        known = end;
    }
    for (int32_t q = 0; q < a->n && status == SP_OK; q++)
        status = end_pass(a, &a->pass[q], s, err);
    if (status == SP_OK && known < s->n)
        shorten(s, known);
    return status;
}

sp_status sp_signal_by_chebyshev(const signal_job *job, sp_signal *s, sp_error *err) {
    const sp_signal_options *o = job->options;
    int64_t terms;
    passes all;
    if (0.5 * s->omega_max * o->until > TERMS_MAX)
        return sp_fail(err, SP_EREFUSED, "until = %g needs %.3g matrix products, must be at most %d; use method dense",
                       o->until, 0.5 * s->omega_max * o->until, TERMS_MAX);
    sp_status status = sp_expansion_terms(job->net, o->until, job_has_momenta(job), 1e-8 * o->tolerance, &terms, err);
    if (status != SP_OK)
        return status;
    status = passes_make(job, s->omega_max, terms, &all, err);
    if (status == SP_OK)
        status = o->front ? run_to_front(&all, s, err) : run_all(&all, s, err);
    passes_free(&all);
    return status;
}
