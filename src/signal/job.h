#ifndef SP_SIGNAL_JOB_H
#define SP_SIGNAL_JOB_H
/* What every method of the signal is given, and what it fills in. */

#include <sonopack/signal.h>

typedef struct signal_job {
    const sp_network *net;
    const sp_signal_options *options;
    int32_t sources, detectors;
    double *sent; /* [sources][dofs] momenta, or displacements, at t = 0 */
    double *seen; /* [detectors][dofs] */
} signal_job;

/* The method fills s->f and s->errors, s->products, and s->omega_max if it knows better than the network's bound; t, n,
 * sources and detectors are given, f and errors are zero. */
typedef sp_status (*signal_way)(const signal_job *job, sp_signal *s, sp_error *err);

static inline const double *job_source(const signal_job *job, int32_t k) {
    return job->sent + k * sp_network_dofs(job->net);
}
static inline const double *job_detector(const signal_job *job, int32_t k) {
    return job->seen + k * sp_network_dofs(job->net);
}
/* F of one source at one detector, [n]. */
static inline double *signal_pair(const sp_signal *s, int32_t source, int32_t detector) {
    return s->f + ((int64_t)source * s->detectors + detector) * s->n;
}
static inline bool job_moves(const signal_job *job) { return job->options->source != SP_SOURCE_DISPLACEMENT; }

sp_status sp_signal_by_chebyshev(const signal_job *job, sp_signal *s, sp_error *err);
/* The sum over all modes of the dense solver, Eq. (3). */
sp_status sp_signal_by_modes(const signal_job *job, sp_signal *s, sp_error *err);

#endif
