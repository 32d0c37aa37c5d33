#include "base/base.h"
#include "signal/job.h"

#include <float.h>
#include <math.h>
#include <sonopack/modes.h>

/* Leaves room for 5 times what is seen. */
#define BACKWARD 1.0

/* a_n b_n of one source and one detector for every mode of the network. */
static void amplitudes(const signal_job *job, const sp_modes *m, const double *sent, const double *seen, double *ab) {
    const double *mass = job->net->mass;
    for (int64_t k = 0; k < m->n - m->n_rattler; k++) {
        const double *e = m->vectors + k * m->dofs, omega = m->omega[m->n_rattler + k];
        double a = 0, b = 0;
        for (int64_t q = 0; q < m->dofs; q++) {
            const double root = sqrt(mass[q]);
            a += e[q] * (job_moves(job) ? sent[q] / root : sent[q] * root);
            b += e[q] * (seen[q] / root);
        }
        if (job_moves(job))
            a = omega > 0 ? a / omega : 0;
        ab[k] = a * b;
    }
}

/* Error of the sum at the last time. Every frequency's own error turns its phase, independently of the others; the
 * solver's backward error, some DBL_EPSILON of A, acts like a shift at the top of the spectrum; sine and sum are
 * rounded. */
static double modal_error(const sp_modes *m, const double *ab, double omega, double last) {
    double phases = 0, squares = 0;
    for (int64_t k = 0; k < m->n - m->n_rattler; k++) {
        const double turn = fmin(2, m->error[m->n_rattler + k] * last);
        phases += ab[k] * ab[k] * turn * turn;
        squares += ab[k] * ab[k];
    }
    return 2 * sqrt(phases) + BACKWARD * DBL_EPSILON * (1 + omega * last) * sqrt(squares);
}

static void add_modes(const signal_job *job, const sp_modes *m, const double *ab, int32_t n, const double *t,
                      double *f) {
    for (int32_t l = 0; l < n; l++) {
        double sum = 0;
        for (int64_t k = 0; k < m->n - m->n_rattler; k++) {
            const double phase = m->omega[m->n_rattler + k] * t[l];
            sum += ab[k] * (job_moves(job) ? sin(phase) : cos(phase));
        }
        f[l] = sum;
    }
}

sp_status sp_signal_by_modes(const signal_job *job, sp_signal *s, sp_error *err) {
    sp_modes m = sp_modes_none();
    const sp_modes_options how = {.vectors = true, .source = job->options->source};
    sp_status status = sp_modes_dense(job->net, &how, &m, err);
    if (status != SP_OK)
        return status;
    double *ab = sp_alloc((size_t)m.dofs, sizeof *ab);
    if (!ab)
        status = sp_fail_memory(err, (size_t)m.dofs * sizeof *ab);
    for (int32_t a = 0; a < s->sources && ab; a++)
        for (int32_t b = 0; b < s->detectors; b++) {
            amplitudes(job, &m, job_source(job, a), job_detector(job, b), ab);
            add_modes(job, &m, ab, s->n, s->t, signal_pair(s, a, b));
            s->errors[a * s->detectors + b] = modal_error(&m, ab, sp_network_omega_bound(job->net), s->t[s->n - 1]);
        }
    sp_free(ab);
    sp_modes_free(&m);
    return status;
}
