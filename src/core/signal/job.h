#ifndef SP_SIGNAL_JOB_H
#define SP_SIGNAL_JOB_H
/* Input and output of every method for signals. */

#include "signal/recurrence.h"

#include <sonopack/front.h>
#include <sonopack/pulse.h>

typedef struct signal_job {
    const sp_network *net;
    const sp_packing *packing; /* packing from which the network was made; NULL: unknown */
    const sp_signal_options *options;
    int32_t sources, detectors;
    /* Sources (momenta or displacements at t = 0) and detectors, [sources] and [detectors]: rows, which the method may
     * turn into its operator's order, or vectors [dofs] each; the other one is NULL. */
    sparse_row *from, *to;
    double *source_vectors, *detector_vectors;
    double *source_norms, *detector_norms; /* in the metric of the masses */
} signal_job;

/* dense: vectors, else rows. */
sp_status sp_job_make(const sp_network *net, const sp_signal_options *o, bool dense, signal_job *job, sp_error *err);
void sp_job_free(signal_job *job);

/* Allocates *s for all pairs and sets its times. After a failure the caller frees *s with sp_signal_free as well. */
sp_status sp_signal_allocate(const sp_signal_options *o, int32_t sources, int32_t detectors, sp_signal *s,
                             sp_error *err);

/* The first front of a signal, by the usual rule. */
sp_status sp_signal_front(const sp_network *net, const sp_signal_options *opt, sp_front *out, sp_error *err);

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

/* ---- costs ------------------------------------------------------------------------------------------------------ */

/* What of a network decides the cost. */
typedef struct sp_signal_problem {
    double dofs, springs, omega; /* omega: upper bound of the spectrum */
    int dim;
    bool carried; /* K is not symmetric */
} sp_signal_problem;
/* Estimated time in nanoseconds on one core of 2023; only ratios matter. HUGE_VAL: the method does not support these
 * options. */
double sp_signal_problem_cost(sp_signal_method method, const sp_signal_problem *problem, const sp_signal_options *o);

enum { SIGNAL_CHOICES = 4 };
/* The methods that support these options, cheapest first; returns their number, at least 1. The later ones are
 * alternatives if earlier ones miss the tolerance; they take at most ten seconds or ten times as long as the first. */
int sp_signal_choose(const sp_network *net, const sp_signal_options *o, sp_signal_method choice[SIGNAL_CHOICES]);

/* Length of a panel in which both the pulse and a response with frequencies up to omega are smooth for Gauss's rule. */
double sp_pulse_panel(const sp_pulse *p, double omega);

#endif
