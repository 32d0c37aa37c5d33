/* Signals of the nonlinear motion at a finite amplitude, with contacts that open, close and slide (packing/vibrate.h).
 * F is the change of the force over the amplitude of the source; it tends to the linear signal as the amplitude tends
 * to 0. */
#include "base/base.h"
#include "network/place.h"
#include "packing/vibrate.h"
#include "signal/job.h"

#include <math.h>
#include <string.h>

enum { ATTEMPTS = 6 };
/* Limit of contacts times steps for a step chosen from the tolerance: minutes. */
#define WORK_MAX 3e9

/* A detector: a sum of changes of contact forces on their first grains, with signs. */
typedef struct sensor {
    int axis;
    int32_t n;
    int32_t *touch;
    double *sign;
} sensor;

typedef struct simulation {
    const signal_job *job;
    vibration m;
    sensor *sensors; /* [detectors] */
    double *before;  /* f of the previous run */
    double overlap;  /* mean over the carrying contacts */
    double spacing;
} simulation;

static void simulation_free(simulation *s) {
    for (int32_t b = 0; b < s->job->detectors && s->sensors; b++) {
        sp_free(s->sensors[b].touch);
        sp_free(s->sensors[b].sign);
    }
    sp_free(s->sensors);
    sp_free(s->before);
    sp_vibration_free(&s->m);
}

/* ---- detectors ----------------------------------------------------------------------------------------------- */

/* Whether a grain is detected by its contact with the top wall, as in sp_network_detector_at. */
static bool at_wall(const sp_network *net, const sp_place *at) {
    for (int32_t k = net->n_bulk; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        if (s->j == SP_TOP && net->grain[s->i] == at->grain && !(at->shear && s->kt == 0))
            return true;
    }
    return false;
}

/* Sign of a contact in a detector; 0: it does not count. */
static double sign_of(const simulation *s, const sp_place *at, bool wall, const touching *t) {
    const sp_packing *p = s->job->packing;
    const double x = p->x[3 * (int64_t)t->i];
    const double y = sp_packing_periodic(p, 0) ? x - p->box[0] * floor(x / p->box[0]) : x;
    switch (at->kind) {
    case SP_PLACE_WALL: return t->j == SP_TOP ? -1 : 0;
    case SP_PLACE_PART: return t->j == SP_TOP && y >= at->from && y < at->to ? -1 : 0;
    case SP_PLACE_GRAIN:
        if (wall)
            return t->j == SP_TOP && t->i == at->grain ? -1 : 0;
        return t->i == at->grain ? 1 : t->j == at->grain ? -1 : 0;
    case SP_PLACE_PLANE: break;
    }
    const int up = p->dim - 1;
    const double other = t->j >= 0 ? p->x[3 * (int64_t)t->j + up] : 0;
    int32_t low;
    return -sp_place_crossing(s->job->net, at->height, p->x[3 * (int64_t)t->i + up], t->length * t->n0[up], t->j, other,
                              &low);
}

static sp_status make_sensors(simulation *s, sp_error *err) {
    const sp_place top = sp_place_wall();
    const size_t count = (size_t)s->m.count;
    s->sensors = sp_alloc((size_t)s->job->detectors, sizeof *s->sensors);
    if (!s->sensors)
        return sp_fail_memory(err, (size_t)s->job->detectors * sizeof *s->sensors);
    for (int32_t b = 0; b < s->job->detectors; b++) {
        const sp_place *at = s->job->options->to ? &s->job->options->to[b] : &top;
        const bool wall = at->kind == SP_PLACE_GRAIN && at_wall(s->job->net, at);
        sensor *e = &s->sensors[b];
        e->axis = at->shear ? 0 : s->m.dim - 1;
        for (size_t k = 0; k < count; k++)
            e->n += sign_of(s, at, wall, &s->m.touch[k]) != 0;
        e->touch = sp_alloc((size_t)e->n, sizeof *e->touch);
        e->sign = sp_alloc((size_t)e->n, sizeof *e->sign);
        if (!e->touch || !e->sign)
            return sp_fail_memory(err, (size_t)e->n * (sizeof *e->touch + sizeof *e->sign));
        e->n = 0;
        for (size_t k = 0; k < count; k++) {
            const double sign = sign_of(s, at, wall, &s->m.touch[k]);
            if (sign != 0) {
                e->touch[e->n] = (int32_t)k;
                e->sign[e->n++] = sign;
            }
        }
    }
    return SP_OK;
}

static double read_sensor(const vibration *m, const sensor *e) {
    double sum = 0;
    for (int32_t k = 0; k < e->n; k++)
        sum += e->sign[k] * m->touch[e->touch[k]].force[e->axis];
    return sum;
}

/* ---- motion -------------------------------------------------------------------------------------------------- */

/* Velocity of the centre of mass that momenta give to a network without walls; 0 between walls. No force depends on it,
 * so it is left out: otherwise all grains would drift ever farther. */
static void find_drift(const sp_network *net, const double *momenta, double drift[3]) {
    double mass = 0;
    drift[0] = drift[1] = drift[2] = 0;
    if (net->cell != SP_CELL_PERIODIC)
        return;
    for (int32_t i = 0; i < net->n; i++) {
        mass += net->mass[(int64_t)i * net->dof];
        for (int a = 0; a < net->dim; a++)
            drift[a] += momenta[(int64_t)i * net->dof + a];
    }
    for (int a = 0; a < net->dim; a++)
        drift[a] /= mass;
}

/* Starts a source. Returns its factor, chosen so that the largest displacement, or velocity over Omega, of a grain is
 * `amplitude` times the mean overlap. */
static double start_source(simulation *s, int32_t source) {
    const sp_network *net = s->job->net;
    const double *vector = job_source(s->job, source);
    const bool momenta = job_has_momenta(s->job);
    double largest = 0;
    sp_vibration_rest(&s->m);
    for (int32_t i = 0; i < net->n; i++) {
        double square = 0;
        for (int a = 0; a < net->dim; a++) {
            const int64_t k = (int64_t)i * net->dof + a;
            const double x = momenta ? vector[k] / net->mass[k] / sp_network_omega_bound(net) : vector[k];
            square += x * x;
        }
        largest = fmax(largest, square);
    }
    const double factor = s->job->options->amplitude * s->overlap / sqrt(largest);
    double *to = momenta ? s->m.v : s->m.u, drift[3];
    find_drift(net, vector, drift);
    for (int32_t i = 0; i < net->n; i++)
        for (int a = 0; a < net->dof; a++) {
            const int64_t k = (int64_t)i * net->dof + a;
            const int at = a < net->dim ? a : net->dim == 2 ? 5 : a;
            to[6 * (int64_t)net->grain[i] + at] =
                factor * (momenta ? vector[k] / net->mass[k] - (a < net->dim ? drift[a] : 0) : vector[k]);
        }
    sp_vibration_begin(&s->m);
    return factor;
}

static sp_status run(simulation *s, sp_signal *out, int64_t substeps, sp_error *err) {
    const double h = s->spacing / (double)substeps;
    for (int32_t a = 0; a < out->sources; a++) {
        const double factor = start_source(s, a);
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
                signal_pair(out, a, b)[l] = read_sensor(&s->m, &s->sensors[b]) / factor;
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
    for (int32_t q = 0; q < net->n_springs && status == SP_OK; q++)
        k.overlap += job->packing->contacts[net->springs[q].contact].overlap / net->n_springs;
    if (status == SP_OK)
        status = converge(&k, s, longest, err);
    simulation_free(&k);
    return status;
}
