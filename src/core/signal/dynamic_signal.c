/* Signals of the nonlinear motion at a finite amplitude, with contacts that open, close and slide (packing/vibrate.h).
 * F is the change of the force over the amplitude of the source; it tends to the linear signal as the amplitude tends
 * to 0. */
#include "base/base.h"
#include "network/place.h"
#include "signal/job.h"
#include "signal/sensor.h"

#include <math.h>
#include <string.h>

enum { ATTEMPTS = 6 };
/* Limit of contacts times steps for a step chosen from the tolerance: minutes. */
#define WORK_MAX 3e9

typedef struct simulation {
    const signal_job *job;
    vibration m;
    motion_sensor *sensors; /* [detectors] */
    double *before;         /* f of the previous run */
    double overlap;         /* mean over the carrying contacts */
    double spacing;
} simulation;

static void simulation_free(simulation *s) {
    for (int32_t b = 0; b < s->job->detectors && s->sensors; b++)
        sp_sensor_free(&s->sensors[b]);
    sp_free(s->sensors);
    sp_free(s->before);
    sp_vibration_free(&s->m);
}

static sp_status make_sensors(simulation *s, sp_error *err) {
    const sp_place top = sp_place_wall(), *to = s->job->options->to;
    s->sensors = sp_alloc((size_t)s->job->detectors, sizeof *s->sensors);
    sp_status status = s->sensors ? SP_OK : sp_fail_memory(err, (size_t)s->job->detectors * sizeof *s->sensors);
    for (int32_t b = 0; b < s->job->detectors && status == SP_OK; b++)
        status = sp_sensor_make(s->job->packing, s->job->net, &s->m, to ? &to[b] : &top, &s->sensors[b], err);
    return status;
}

static sp_status run(simulation *s, sp_signal *out, int64_t substeps, sp_error *err) {
    const double h = s->spacing / (double)substeps;
    for (int32_t a = 0; a < out->sources; a++) {
        sp_vibration_rest(&s->m);
        const double factor = sp_vibration_kick(&s->m, s->job->net, job_source(s->job, a), job_has_momenta(s->job),
                                                s->job->options->amplitude * s->overlap);
        for (int32_t l = 0; l < out->n; l++) {
            for (int64_t k = 0; k < (l > 0 ? substeps : 0); k++)
                sp_vibration_step(&s->m, h);
            if (!sp_vibration_sane(&s->m))
                return sp_fail(
                    err, SP_EFAILED,
                    "at t = %.6g a grain has moved by more than %.3g, or without bound: amplitude = %g, must be "
                    "smaller",
                    out->t[l], 0.5 * s->m.reach, s->job->options->amplitude);
            for (int32_t b = 0; b < out->detectors; b++)
                signal_pair(out, a, b)[l] = sp_sensor_read(&s->m, &s->sensors[b]) / factor;
        }
        if (a == 0)
            out->amplitude = factor;
    }
    out->step = h;
    out->products += (int32_t)fmin(1e9, (double)substeps * (out->n - 1) * out->sources);
    return SP_OK;
}

/* Estimates the error from the difference to the previous run, whose steps were at least twice as long; the error of a
 * method of order 1 or more is smaller than that difference. Returns the smallest ratio of allowed to estimated
 * error. */
static double compare(const simulation *s, sp_signal *out) {
    double least = INFINITY;
    for (int32_t q = 0; q < out->sources * out->detectors; q++) {
        double largest = 0, differ = 0;
        for (int64_t l = (int64_t)q * out->n; l < (int64_t)(q + 1) * out->n; l++) {
            largest = fmax(largest, fabs(out->f[l]));
            differ = fmax(differ, fabs(out->f[l] - s->before[l]));
        }
        largest = fmax(largest, 1e-6 * sp_job_scale(s->job, q / out->detectors, q % out->detectors));
        out->errors[q] = differ;
        least = fmin(least, s->job->options->tolerance * largest / differ);
    }
    return least;
}

static void keep(simulation *s, const sp_signal *out) {
    memcpy(s->before, out->f, (size_t)out->sources * (size_t)out->detectors * (size_t)out->n * sizeof *out->f);
}

static double work(const simulation *s, const sp_signal *out, double substeps) {
    return substeps * (out->n - 1) * out->sources * s->m.count;
}

/* longest: the longest stable step, with a margin. */
static sp_status converge(simulation *s, sp_signal *out, double longest, sp_error *err) {
    const double given = s->job->options->step, tolerance = s->job->options->tolerance;
    double substeps = fmax(2, ceil(s->spacing / (given > 0 ? fmin(given, longest) : 0.5 * longest) * (1 - 1e-12)));
    if (given > longest)
        return sp_fail(err, SP_EINVAL, "step = %g, must be at most %.6g: longer ones are unstable", given, longest);
    if (!(1.5 * work(s, out, substeps) <= (given > 0 ? 10 : 1) * WORK_MAX))
        return sp_fail(err, SP_EREFUSED, "%.3g steps of %.3g for %d contacts are too many", substeps * (out->n - 1),
                       s->spacing / substeps, s->m.count);
    sp_status status = run(s, out, (int64_t)(substeps / 2), err);
    for (int attempt = 0; attempt < ATTEMPTS && status == SP_OK; attempt++) {
        keep(s, out);
        status = run(s, out, (int64_t)substeps, err);
        const double left = status == SP_OK ? compare(s, out) : 1;
        if (left >= 1 || given > 0)
            break;
        const double next = substeps * fmax(2, ceil(sqrt(1.5 / left)));
        if (!(work(s, out, next) <= WORK_MAX))
            return sp_fail(err, SP_EREFUSED,
                           "tolerance %.2g takes about %.3g steps; with %.3g of them the error is about %.1g of the "
                           "largest |F|",
                           tolerance, next * (out->n - 1), substeps * (out->n - 1), tolerance / left);
        substeps = next;
    }
    return status;
}

/* The decay rate of the stiffest dashpots limits the step too. */
static sp_status longest_step(const signal_job *job, double *longest, sp_error *err) {
    const double omega = sp_network_omega_bound(job->net);
    const sp_damping law = sp_signal_damping(job->options);
    double rate = 0;
    if (law.value > 0) {
        sp_network dashpots = sp_network_none();
        sp_status status = sp_network_dashpots(job->net, &law, &dashpots, err);
        if (status != SP_OK)
            return status;
        rate = sp_network_omega_bound(&dashpots) * sp_network_omega_bound(&dashpots);
        sp_network_free(&dashpots);
    }
    *longest = 1 / (omega + rate);
    return SP_OK;
}

sp_status sp_signal_by_dynamics(const signal_job *job, sp_signal *s, sp_error *err) {
    const sp_network *net = job->net;
    simulation k = {.job = job, .m = {0}, .spacing = job->options->until / (s->n - 1)};
    double longest = 0;
    if (!job->packing)
        return sp_fail(err, SP_EINVAL, "method dynamics needs the packing, must be called as sp_signal_compute");
    /* gaps that may close are found in the box, between its level walls */
    sp_status status = sp_network_need_level_walls(net, "method dynamics", err);
    if (status == SP_OK)
        status = longest_step(job, &longest, err);
    if (status == SP_OK)
        status = sp_vibration_make(job->packing, job->options->damping, &k.m, err);
    k.m.damping_kind = job->options->damping_kind;
    k.m.damping_ratio = job->options->damping_ratio;
    if (status == SP_OK)
        status = make_sensors(&k, err);
    if (status == SP_OK) {
        const size_t size = (size_t)s->sources * (size_t)s->detectors * (size_t)s->n;
        k.before = sp_alloc(size, sizeof *k.before);
        if (!k.before)
            status = sp_fail_memory(err, size * sizeof *k.before);
    }
    k.overlap = sp_mean_overlap(job->packing, net);
    if (status == SP_OK)
        status = converge(&k, s, longest, err);
    simulation_free(&k);
    return status;
}
