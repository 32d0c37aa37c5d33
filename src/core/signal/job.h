#ifndef SP_SIGNAL_JOB_H
#define SP_SIGNAL_JOB_H
/* Input and output of every method for signals. */

#include <sonopack/signal.h>

/* Sparse vectors over the degrees of freedom of the network. */
typedef struct signal_rows {
    int32_t n;
    int64_t *first; /* [n + 1] */
    int64_t *dof;   /* [first[n]] */
    double *value;
    size_t capacity; /* of dof and value */
} signal_rows;

typedef struct signal_job {
    const sp_network *net;
    const sp_packing *packing; /* packing from which the network was made; NULL: unknown */
    const sp_signal_options *options;
    int32_t sources, detectors;
    signal_rows from, to;                      /* sources (momenta or displacements at t = 0), and detectors */
    double *source_vectors, *detector_vectors; /* the same, dense: [sources][dofs] and [detectors][dofs]; NULL for
                                                  methods that use sparse rows */
} signal_job;

/* dense: also make the dense vectors. */
sp_status sp_job_make(const sp_network *net, const sp_signal_options *o, bool dense, signal_job *job, sp_error *err);
void sp_job_free(signal_job *job);

/* Allocates *s for all pairs and sets its times. After a failure the caller frees *s with sp_signal_free as well. */
sp_status sp_signal_allocate(const sp_signal_options *o, int32_t sources, int32_t detectors, sp_signal *s,
                             sp_error *err);

/* A method. It fills s->f, s->errors and s->products, and s->omega_max if it has a better bound than the network's. t,
 * n, sources and detectors are set on entry; f and errors are zero. */
typedef sp_status (*signal_function)(const signal_job *job, sp_signal *s, sp_error *err);

static inline const double *job_source(const signal_job *job, int32_t k) {
    return job->source_vectors + k * sp_network_dofs(job->net);
}
static inline const double *job_detector(const signal_job *job, int32_t k) {
    return job->detector_vectors + k * sp_network_dofs(job->net);
}
/* F of one source at one detector, [n]. */
static inline double *signal_pair(const sp_signal *s, int32_t source, int32_t detector) {
    return s->f + ((int64_t)source * s->detectors + detector) * s->n;
}
static inline bool job_has_momenta(const signal_job *job) { return job->options->source != SP_SOURCE_DISPLACEMENT; }

/* |a||b|/Omega, or |a||b| for displacements: the scale of a signal. */
double sp_job_scale(const signal_job *job, int32_t source, int32_t detector);

sp_status sp_signal_by_verlet(const signal_job *job, sp_signal *s, sp_error *err);
sp_status sp_signal_by_lax_wendroff(const signal_job *job, sp_signal *s, sp_error *err);
sp_status sp_signal_by_faber(const signal_job *job, sp_signal *s, sp_error *err);
sp_status sp_signal_by_dynamics(const signal_job *job, sp_signal *s, sp_error *err);
sp_status sp_signal_by_chebyshev(const signal_job *job, sp_signal *s, sp_error *err);
/* Sum over the lowest modes, with a bound of the contribution of the others. */
sp_status sp_signal_by_lowest_modes(const signal_job *job, sp_signal *s, sp_error *err);
/* Sum over all modes of the dense solver, Eq. (3). */
sp_status sp_signal_by_modes(const signal_job *job, sp_signal *s, sp_error *err);

#endif
