/* The front of a loud pulse beside that of the linear signal. */
#include "amplitude/motion.h"
#include "base/base.h"

#include <math.h>
#include <sonopack/signal.h>
#include <string.h>

/* Runs are repeated with half the step until the errors are within the tolerance; the record has a time for every
 * RECORD / omega_max, which is the longest step. */
#define RECORD         0.5
#define AMPLITUDE_LOW  1e-9
#define AMPLITUDE_HIGH 1e6
/* Limit of contacts times steps of one run: minutes. */
#define WORK_MAX 3e9
/* A front is higher than this fraction of the linear one, or of the largest force. */
#define WEAKEST 1e-3

enum { ATTEMPTS = 9, PARTS = 48, POINTS_MAX = 10000000 };

typedef struct experiment {
    const sp_amplitude_options *options;
    motion motion;
    sp_network net;
    double *source;     /* [dofs] */
    double *t, *f;      /* [n] */
    double *coarse;     /* [2][n/2 + 1] every second time, and its force */
    int32_t n, used;    /* times in all; up to the end of the run */
    sp_front linear[2]; /* from all times, and from every second one */
} experiment;

/* What one run has found. */
typedef struct outcome {
    double factor;
    sp_front front[2];
    sp_amplitude_pulse counts; /* counts and energies */
} outcome;

sp_amplitude_options sp_amplitude_options_default(void) {
    return (sp_amplitude_options){.source = SP_SOURCE_IMPULSE, .tolerance = 1e-3};
}

static void experiment_free(experiment *e) {
    sp_motion_free(&e->motion);
    sp_network_free(&e->net);
    sp_free(e->source);
    sp_free(e->t);
    sp_free(e->f);
    sp_free(e->coarse);
}

/* ---- fronts ----------------------------------------------------------------------------------------------------- */

/* The front of a record, from all times and from every second one, whose difference tells what the spacing of the times
 * does to it. */
static sp_status find_fronts(experiment *e, int32_t n, const double *f, sp_front out[2], sp_error *err) {
    const sp_front_options rule = sp_front_options_default();
    const int32_t half = (n + 1) / 2;
    double *t = e->coarse, *g = e->coarse + (e->n / 2 + 1);
    for (int32_t l = 0; l < half; l++) {
        t[l] = e->t[2 * l];
        g[l] = f[2 * l];
    }
    sp_status status = sp_front_find(n, e->t, f, &rule, &out[0], err);
    if (status == SP_OK)
        status = sp_front_find(half, t, g, &rule, &out[1], err);
    return status;
}

/* Whether the front has passed in the first n times of a record. What arrives before it is many powers of ten weaker
 * (`least` tells them apart), and a fifth of its time more shows that no other peak was meant. The force may stay above
 * that at rest to the end of the record: t_zero is NAN then. */
static bool has_passed(experiment *e, int32_t n, const double *f, double least, sp_front out[2]) {
    sp_error none = {0};
    if (n <= 4 || find_fronts(e, n, f, out, &none) != SP_OK || out[0].amplitude < least)
        return false;
    return n == e->n || n == e->used ||
           (isfinite(out[0].t_zero) && isfinite(out[1].t_zero) && e->t[n - 1] >= 1.2 * out[0].t_zero);
}

/* Times after which a record is looked at. */
static int32_t part_of(const experiment *e) { return (e->n - 1) / PARTS > 0 ? (e->n - 1) / PARTS : 1; }

static sp_status no_front(sp_error *err, double until) {
    return sp_fail_key(err, SP_EREFUSED, "until", " = %g: the front has not passed the top wall by then", until);
}

static sp_status find_linear(experiment *e, double until, sp_error *err) {
    sp_signal_options o = sp_signal_options_default();
    sp_signal s = sp_signal_none();
    o.method = SP_SIGNAL_CHEBYSHEV;
    o.source = e->options->source;
    o.until = until;
    o.points = e->n;
    sp_status status = sp_signal_make(&e->net, &o, &s, err);
    bool found = false;
    double largest = 0;
    if (status == SP_OK)
        memcpy(e->t, s.t, (size_t)e->n * sizeof *e->t);
    for (int32_t l = 0; l < e->n && status == SP_OK; l++)
        largest = fmax(largest, s.f[l]);
    for (int32_t n = part_of(e); n <= e->n && status == SP_OK && !found;
         n = n < e->n && n + part_of(e) > e->n ? e->n : n + part_of(e))
        found = has_passed(e, n, s.f, WEAKEST * largest, e->linear);
    if (status == SP_OK && !(found && isfinite(e->linear[0].t_zero)))
        status = no_front(err, until);
    sp_signal_free(&s);
    return status;
}

/* ---- runs ------------------------------------------------------------------------------------------------------- */

/* One step after another up to the time l. */
static sp_status advance(experiment *e, int32_t l, int64_t substeps, double amplitude, sp_error *err) {
    const double h = (e->t[l] - e->t[l - 1]) / (double)substeps;
    for (int64_t k = 0; k < substeps; k++)
        sp_motion_step(&e->motion, h, 0);
    return sp_motion_check(&e->motion, amplitude, err);
}

/* Runs until the front has passed; the first run decides when that is, so that others count the same. */
static sp_status run(experiment *e, double amplitude, int64_t substeps, outcome *out, sp_error *err) {
    const int32_t part = part_of(e), last = e->used > 0 ? e->used : e->n;
    const double least = WEAKEST * e->linear[0].amplitude;
    sp_status status = SP_OK;
    double defect = 0;
    bool found = false;
    out->factor = sp_motion_kick(&e->motion, e->source, e->options->source != SP_SOURCE_DISPLACEMENT, amplitude);
    e->f[0] = sp_motion_force(&e->motion, 0) / out->factor;
    for (int32_t l = 1; l < last && status == SP_OK && !found; l++) {
        status = advance(e, l, substeps, amplitude, err);
        e->f[l] = sp_motion_force(&e->motion, 0) / out->factor;
        defect = fmax(defect, sp_motion_energy(&e->motion).defect);
        if (status == SP_OK && (l + 1 == last || (e->used == 0 && l % part == 0))) {
            found = has_passed(e, l + 1, e->f, least, out->front);
            e->used = found ? l + 1 : e->used;
        }
    }
    if (status == SP_OK && !found)
        status = no_front(err, e->t[e->n - 1]);
    out->counts = (sp_amplitude_pulse){.until = e->motion.time, .energy = sp_motion_energy(&e->motion)};
    out->counts.energy.defect = defect;
    sp_motion_count(&e->motion, &out->counts);
    return status;
}

/* ---- results ---------------------------------------------------------------------------------------------------- */

typedef double (*measure_function)(const sp_front *front, const sp_front *linear);

static double speed_of(const sp_front *f, const sp_front *linear) { return linear->t10 / f->t10; }
static double peak_of(const sp_front *f, const sp_front *linear) { return f->amplitude / linear->amplitude; }
static double width_of(const sp_front *f, const sp_front *linear) { return f->width / linear->width; }
static double t10_of(const sp_front *f, const sp_front *linear) {
    (void)linear;
    return f->t10;
}

/* The error of the steps is below the difference from steps twice as long, that of the times is of second order in
 * their spacing, so a third of the difference. */
static sp_amplitude_value value_of(const experiment *e, const outcome *now, const outcome *before,
                                   measure_function of) {
    const double value = of(&now->front[0], &e->linear[0]), step = of(&before->front[0], &e->linear[0]),
                 times = of(&now->front[1], &e->linear[1]);
    return (sp_amplitude_value){value, fabs(value - step) + fabs(value - times) / 3};
}

static void fill(const experiment *e, const outcome *now, const outcome *before, sp_amplitude_pulse *out) {
    const double load = e->net.pressure * sp_packing_wall_area(e->motion.packing);
    const sp_amplitude_pulse kept = *out;
    *out = now->counts;
    out->amplitude = kept.amplitude;
    out->step = kept.step;
    out->factor = now->factor;
    out->front = now->front[0];
    out->t10 = value_of(e, now, before, t10_of);
    out->speed = value_of(e, now, before, speed_of);
    out->peak = value_of(e, now, before, peak_of);
    out->width = value_of(e, now, before, width_of);
    out->overpressure = now->front[0].amplitude * now->factor / load;
}

/* Error that finer steps can reduce. */
static double step_error(const experiment *e, const outcome *now, const outcome *before) {
    return fmax(fabs(speed_of(&now->front[0], e->linear) - speed_of(&before->front[0], e->linear)),
                now->counts.energy.defect);
}

static sp_status converge(experiment *e, sp_amplitude_pulse *out, sp_error *err) {
    outcome before = {0}, now = {0};
    int64_t substeps = 1;
    e->used = 0;
    sp_status status = run(e, out->amplitude, substeps, &before, err);
    for (int attempt = 0; attempt < ATTEMPTS && status == SP_OK; attempt++) {
        substeps *= 2;
        if (!((double)substeps * e->used * e->motion.m.count <= WORK_MAX))
            break;
        status = run(e, out->amplitude, substeps, &now, err);
        if (status != SP_OK)
            return status;
        if (step_error(e, &now, &before) <= e->options->tolerance) {
            out->step = (e->t[1] - e->t[0]) / (double)substeps;
            fill(e, &now, &before, out);
            return SP_OK;
        }
        before = now;
    }
    return status != SP_OK ? status
                           : sp_fail_key(err, SP_EREFUSED, "tolerance",
                                         " = %g: at the amplitude %g it takes more than %lld steps; with them the "
                                         "balance of energy is off by %.1g",
                                         e->options->tolerance, out->amplitude, (long long)substeps / 2 * e->used,
                                         before.counts.energy.defect);
}

/* Where grains fly farther than gaps are watched, wider gaps are watched. */
static sp_status measure(experiment *e, sp_amplitude_pulse *out, sp_error *err) {
    sp_status status = converge(e, out, err);
    while (status == SP_EFAILED && sp_motion_can_widen(&e->motion)) {
        motion wider;
        status = sp_motion_make(e->motion.packing, &e->net, 3 * e->motion.radii, 0, NULL, &wider, err);
        if (status != SP_OK)
            return status;
        sp_motion_free(&e->motion);
        e->motion = wider;
        status = converge(e, out, err);
    }
    return status;
}

/* ---- preparation ------------------------------------------------------------------------------------------------ */

static sp_status check(const sp_amplitude_options *o, int32_t count, const double *amplitude, sp_error *err) {
    if (!(o->until >= 0 && isfinite(o->until)))
        return sp_fail_key(err, SP_EINVAL, "until", " = %g: must be positive, or 0", o->until);
    if (!(o->tolerance >= 1e-8 && o->tolerance <= 0.1))
        return sp_fail_key(err, SP_EINVAL, "tolerance", " = %g: must be in 1e-8 .. 0.1", o->tolerance);
    for (int32_t k = 0; k < count; k++)
        if (!(amplitude[k] >= AMPLITUDE_LOW && amplitude[k] <= AMPLITUDE_HIGH))
            return sp_fail_key(err, SP_EINVAL, "amplitude",
                               " = %g: must be in 1e-9 .. 1e6; below, rounding errors count", amplitude[k]);
    return SP_OK;
}

static sp_status allocate(experiment *e, double until, sp_error *err) {
    const double points = ceil(until * sp_network_omega_bound(&e->net) / RECORD) + 1;
    if (!(points <= POINTS_MAX))
        return sp_fail_key(err, SP_EREFUSED, "until", " = %g: is more than %d times 1/omega_max", until, POINTS_MAX);
    e->n = points > PARTS ? (int32_t)points : PARTS;
    const size_t n = (size_t)e->n, dofs = (size_t)sp_network_dofs(&e->net);
    e->t = sp_alloc(n, sizeof *e->t);
    e->f = sp_alloc(n, sizeof *e->f);
    e->coarse = sp_alloc(2 * (n / 2 + 1), sizeof *e->coarse);
    e->source = sp_alloc(dofs, sizeof *e->source);
    return e->t && e->f && e->coarse && e->source ? SP_OK : sp_fail_memory(err, (4 * n + dofs) * sizeof(double));
}

/* The linear limit of the motion: all contacts that carry any force, and the rotation of the forces at rest. */
static sp_status prepare(experiment *e, const sp_packing *p, sp_error *err) {
    const sp_network_options links = {.threshold = 0, .prestress = true};
    const double until =
        e->options->until > 0 ? e->options->until : sp_signal_window(sp_packing_height(p), p->pressure);
    sp_status status = sp_network_make(p, &links, &e->net, err);
    if (status == SP_OK)
        status = sp_motion_make(p, &e->net, SP_MOTION_NEAR, 0, NULL, &e->motion, err);
    if (status == SP_OK)
        status = allocate(e, until, err);
    if (status == SP_OK)
        status = sp_network_source(&e->net, e->options->source, e->source, err);
    if (status == SP_OK)
        status = find_linear(e, until, err);
    return status;
}

sp_status sp_amplitude_pulses(const sp_packing *p, const sp_amplitude_options *opt, int32_t count,
                              const double *amplitude, sp_amplitude_pulse *out, sp_front *linear, sp_error *err) {
    experiment e = {.options = opt, .net = sp_network_none()};
    sp_status status = check(opt, count, amplitude, err);
    if (status == SP_OK)
        status = prepare(&e, p, err);
    for (int32_t k = 0; k < count && status == SP_OK; k++) {
        out[k] = (sp_amplitude_pulse){.amplitude = amplitude[k]};
        status = measure(&e, &out[k], err);
    }
    if (status == SP_OK && linear)
        *linear = e.linear[0];
    experiment_free(&e);
    return status;
}
