/* Vectors of the sources and detectors of a signal. */
#include "signal/job.h"
#include "base/base.h"

#include <math.h>
#include <string.h>

sp_damping sp_signal_damping(const sp_signal_options *opt) {
    return (sp_damping){.kind = opt->damping_kind, .value = opt->damping, .ratio = opt->damping_ratio};
}

void sp_job_free(signal_job *job) {
    signal_rows *all[] = {&job->from, &job->to};
    for (int k = 0; k < 2; k++) {
        sp_free(all[k]->first);
        sp_free(all[k]->dof);
        sp_free(all[k]->value);
    }
    sp_free(job->source_vectors);
    sp_free(job->detector_vectors);
}

static sp_status append_row(signal_rows *rows, int64_t n, const double *vector, sp_error *err) {
    int64_t at = rows->first[rows->n], count = 0;
    for (int64_t k = 0; k < n; k++)
        count += vector[k] != 0;
    const size_t need = (size_t)(at + count);
    size_t capacity = rows->capacity;
    int64_t *dof = sp_grow(rows->dof, need, &capacity, sizeof *dof);
    rows->dof = dof ? dof : rows->dof;
    double *value = dof ? sp_grow(rows->value, need, &rows->capacity, sizeof *value) : NULL;
    if (!value)
        return sp_fail_memory(err, need * (sizeof *dof + sizeof *value));
    rows->value = value;
    for (int64_t k = 0; k < n; k++)
        if (vector[k] != 0) {
            rows->dof[at] = k;
            rows->value[at++] = vector[k];
        }
    rows->first[++rows->n] = at;
    return SP_OK;
}

/* Sources, or detectors. dense: vector is [places][dofs], else [dofs] scratch. */
static sp_status make_rows(signal_job *job, bool source, bool dense, double *vector, sp_error *err) {
    const sp_place wall = sp_place_wall();
    const sp_signal_options *o = job->options;
    const sp_place *places = source ? o->from : o->to;
    const int32_t count = source ? job->sources : job->detectors;
    const int64_t n = sp_network_dofs(job->net);
    signal_rows *rows = source ? &job->from : &job->to;
    sp_status status = SP_OK;
    rows->first = sp_alloc((size_t)count + 1, sizeof *rows->first);
    if (!rows->first)
        return sp_fail_memory(err, ((size_t)count + 1) * sizeof *rows->first);
    for (int32_t k = 0; k < count && status == SP_OK; k++) {
        double *to = dense ? vector + k * n : vector;
        const sp_place *at = places ? &places[k] : &wall;
        status = source ? sp_network_source_at(job->net, o->source, at, to, err)
                        : sp_network_detector_at(job->net, at, to, err);
        if (status == SP_OK)
            status = append_row(rows, n, to, err);
    }
    return status;
}

sp_status sp_job_make(const sp_network *net, const sp_signal_options *o, bool dense, signal_job *job, sp_error *err) {
    const size_t n = (size_t)sp_network_dofs(net);
    *job = (signal_job){.net = net, .options = o};
    job->sources = o->from && o->sources > 0 ? o->sources : 1;
    job->detectors = o->to && o->detectors > 0 ? o->detectors : 1;
    double *vector = dense ? NULL : sp_alloc(n, sizeof *vector);
    if (dense) {
        job->source_vectors = sp_alloc((size_t)job->sources, n * sizeof *job->source_vectors);
        job->detector_vectors = sp_alloc((size_t)job->detectors, n * sizeof *job->detector_vectors);
    }
    sp_status status = SP_OK;
    if (dense ? !job->source_vectors || !job->detector_vectors : !vector)
        status = sp_fail_memory(err, (dense ? (size_t)job->sources + (size_t)job->detectors : 1) * n * sizeof(double));
    if (status == SP_OK)
        status = make_rows(job, true, dense, dense ? job->source_vectors : vector, err);
    if (status == SP_OK)
        status = make_rows(job, false, dense, dense ? job->detector_vectors : vector, err);
    sp_free(vector);
    return status;
}

double sp_job_scale(const signal_job *job, int32_t source, int32_t detector) {
    const signal_rows *from = &job->from, *to = &job->to;
    const double *mass = job->net->mass;
    double a = 0, b = 0;
    for (int64_t k = from->first[source]; k < from->first[source + 1]; k++)
        a += from->value[k] * from->value[k] * (job_has_momenta(job) ? 1 / mass[from->dof[k]] : mass[from->dof[k]]);
    for (int64_t k = to->first[detector]; k < to->first[detector + 1]; k++)
        b += to->value[k] * to->value[k] / mass[to->dof[k]];
    return sqrt(a) * sqrt(b) / (job_has_momenta(job) ? sp_network_omega_bound(job->net) : 1);
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
