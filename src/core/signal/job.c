/* Sources and detectors of a signal, its memory, and the choice of its method. */
#include "signal/job.h"
#include "base/base.h"

#include <math.h>
#include <string.h>

sp_damping sp_signal_damping(const sp_signal_options *opt) {
    return (sp_damping){.kind = opt->damping_kind, .value = opt->damping, .ratio = opt->damping_ratio};
}

void sp_job_free(signal_job *job) {
    for (int32_t k = 0; job->from && k < job->sources; k++)
        sp_sparse_row_free(&job->from[k]);
    for (int32_t k = 0; job->to && k < job->detectors; k++)
        sp_sparse_row_free(&job->to[k]);
    sp_free(job->from);
    sp_free(job->to);
    sp_free(job->source_vectors);
    sp_free(job->detector_vectors);
    sp_free(job->source_norms);
    sp_free(job->detector_norms);
}

/* Norm of a source or detector; a displacement weighs with the masses, all else with their inverse. */
static double norm_of(const sp_network *net, const double *vector, bool displacement) {
    double squares = 0;
    for (int64_t k = 0; k < sp_network_dofs(net); k++)
        if (vector[k] != 0)
            squares += vector[k] * vector[k] * (displacement ? net->mass[k] : 1 / net->mass[k]);
    return sqrt(squares);
}

/* One kind of places: `vectors` [count][dofs] of the dense ones, else [dofs] scratch. */
static sp_status make_places(const signal_job *job, bool source, double *vectors, sparse_row *rows, double *norms,
                             sp_error *err) {
    const sp_place wall = sp_place_wall(), *places = source ? job->options->from : job->options->to;
    const int64_t n = sp_network_dofs(job->net);
    sp_status status = SP_OK;
    for (int32_t k = 0; k < (source ? job->sources : job->detectors) && status == SP_OK; k++) {
        const sp_place *at = places ? &places[k] : &wall;
        double *to = rows ? vectors : vectors + k * n;
        status = source ? sp_network_source_at(job->net, job->options->source, at, to, err)
                        : sp_network_detector_at(job->net, at, to, err);
        if (status == SP_OK && rows)
            status = sp_sparse_row_make(n, to, &rows[k], err);
        if (status == SP_OK)
            norms[k] = norm_of(job->net, to, source && !job_has_momenta(job));
    }
    return status;
}

sp_status sp_job_make(const sp_network *net, const sp_signal_options *o, bool dense, signal_job *job, sp_error *err) {
    const size_t bytes = (size_t)sp_network_dofs(net) * sizeof(double);
    *job = (signal_job){.net = net, .options = o};
    job->sources = o->from && o->sources > 0 ? o->sources : 1;
    job->detectors = o->to && o->detectors > 0 ? o->detectors : 1;
    const size_t sources = (size_t)job->sources, detectors = (size_t)job->detectors;
    double *scratch = dense ? NULL : sp_alloc(1, bytes);
    job->source_norms = sp_alloc(sources, sizeof *job->source_norms);
    job->detector_norms = sp_alloc(detectors, sizeof *job->detector_norms);
    if (dense) {
        job->source_vectors = sp_alloc(sources, bytes);
        job->detector_vectors = sp_alloc(detectors, bytes);
    } else {
        job->from = sp_alloc(sources, sizeof *job->from);
        job->to = sp_alloc(detectors, sizeof *job->to);
    }
    sp_status status = SP_OK;
    if (!job->source_norms || !job->detector_norms ||
        (dense ? !job->source_vectors || !job->detector_vectors : !job->from || !job->to || !scratch))
        status = sp_fail_memory(err, (dense ? sources + detectors : 1) * bytes);
    if (status == SP_OK)
        status = make_places(job, true, dense ? job->source_vectors : scratch, job->from, job->source_norms, err);
    if (status == SP_OK)
        status = make_places(job, false, dense ? job->detector_vectors : scratch, job->to, job->detector_norms, err);
    sp_free(scratch);
    return status;
}

double sp_job_scale(const signal_job *job, int32_t source, int32_t detector) {
    return job->source_norms[source] * job->detector_norms[detector] /
           (job_has_momenta(job) ? sp_network_omega_bound(job->net) : 1);
}

sp_status sp_signal_allocate(const sp_signal_options *o, int32_t sources, int32_t detectors, sp_signal *s,
                             sp_error *err) {
    const size_t pairs = (size_t)sources * (size_t)detectors;
    s->n = o->points;
    s->sources = sources;
    s->detectors = detectors;
    s->t = sp_alloc((size_t)s->n, sizeof *s->t);
    s->f = sp_alloc(pairs, (size_t)s->n * sizeof *s->f);
    s->errors = sp_alloc(pairs, sizeof *s->errors);
    if (!s->t || !s->f || !s->errors)
        return sp_fail_memory(err, (1 + pairs) * (size_t)s->n * sizeof *s->t);
    for (int32_t l = 0; l < s->n; l++)
        s->t[l] = l < s->n - 1 ? o->until * l / (s->n - 1) : o->until;
    return SP_OK;
}

/* ---- choice of the method ---------------------------------------------------------------------------------------- */

enum { SPARSE_DOFS = 4000, DENSE_DOFS = 20000 };

/* Size of the problem. */
typedef struct load {
    double n, springs, x, points, sources, detectors, pairs;
    bool spatial;
} load;

static load load_of(const sp_signal_problem *p, const sp_signal_options *o) {
    load l = {.n = p->dofs,
              .springs = p->springs,
              .x = p->omega * o->until,
              .points = o->points,
              .sources = o->from && o->sources > 0 ? o->sources : 1,
              .detectors = o->to && o->detectors > 0 ? o->detectors : 1,
              .spatial = p->dim == 3};
    l.pairs = l.sources * l.detectors;
    return l;
}

/* Each product carries two vectors: source and detector of a single pair, with half as many products, or two sources
 * (or detectors if these are fewer). Each pass needs Bessel functions of all orders at all times. */
static double chebyshev_cost(const load *l) {
    const double terms = l->x / 2 + 6 * cbrt(l->x) + 3,
                 passes = l->pairs > 1 ? ceil(fmin(l->sources, l->detectors) / 2) : 1;
    const double products = l->pairs > 1 ? terms * passes : terms / 2;
    const double product = (l->spatial ? 11.4 : 3.5) * l->springs + 0.42 * l->n + 114;
    return 1e4 + 37 * l->springs + products * product + passes * l->points * (38 + 0.18 * terms) +
           0.034 * l->pairs * l->points * terms;
}

/* All eigenvectors and their residuals, a sine for each mode and time, and for each pair the sum and the coupling of
 * modes. */
static double dense_cost(const load *l) {
    if (l->n > DENSE_DOFS)
        return HUGE_VAL;
    return 3.5e5 + l->n * (0.18 * l->n * l->n + 51 * l->n + 1.3 * l->springs + 10 * l->points +
                           l->pairs * (1.2 * l->points + 3.3 * l->n));
}

/* All modes in slices, since a tolerance below some percent needs nearly all. Small problems go to the dense solver. */
static double sparse_cost(const load *l) {
    if (l->n < SPARSE_DOFS)
        return HUGE_VAL;
    return l->n * (950 * l->n + l->pairs * (11.2 * l->points + 3.3 * l->n));
}

double sp_signal_problem_cost(sp_signal_method method, const sp_signal_problem *p, const sp_signal_options *o) {
    const load l = load_of(p, o);
    if (o->damping > 0 || o->front || p->carried)
        return method == (o->damping > 0 ? SP_SIGNAL_FABER : SP_SIGNAL_CHEBYSHEV) ? 1 : HUGE_VAL;
    switch (method) {
    case SP_SIGNAL_CHEBYSHEV: return chebyshev_cost(&l);
    case SP_SIGNAL_DENSE: return dense_cost(&l);
    case SP_SIGNAL_SPARSE: return sparse_cost(&l);
    default: return HUGE_VAL;
    }
}

static double cost_of(sp_signal_method method, const sp_network *net, const sp_signal_options *o) {
    const sp_signal_problem p = {.dofs = (double)sp_network_dofs(net),
                                 .springs = net->n_springs,
                                 .omega = sp_network_omega_bound(net),
                                 .dim = net->dim,
                                 .carried = net->carried != NULL};
    return sp_signal_problem_cost(method, &p, o);
}

int sp_signal_choose(const sp_network *net, const sp_signal_options *o, sp_signal_method choice[SIGNAL_CHOICES]) {
    static const sp_signal_method all[SIGNAL_CHOICES] = {SP_SIGNAL_CHEBYSHEV, SP_SIGNAL_FABER, SP_SIGNAL_DENSE,
                                                         SP_SIGNAL_SPARSE};
    double cost[SIGNAL_CHOICES];
    int count = 0;
    for (int k = 0; k < SIGNAL_CHOICES; k++) {
        const double here = cost_of(all[k], net, o);
        if (!isfinite(here))
            continue;
        int at = count++;
        for (; at > 0 && cost[at - 1] > here; at--) {
            cost[at] = cost[at - 1];
            choice[at] = choice[at - 1];
        }
        cost[at] = here;
        choice[at] = all[k];
    }
    while (count > 1 && cost[count - 1] > fmax(1e10, 10 * cost[0]))
        count--;
    return count;
}
