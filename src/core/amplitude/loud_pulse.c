/* The front of a loud pulse beside that of the linear signal. */
#include "amplitude/loud_motion.h"
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
#define LONG    1.5

enum { ATTEMPTS = 9, PARTS = 48, POINTS_MAX = 10000000 };

typedef struct experiment {
    const sp_amplitude_options *options;
    double until;
    int32_t planes;
    const double *height; /* [planes] */
    sp_front *plane;      /* [2][planes][2] of two runs */
    motion motion;
    sp_network net;
    double *source;     /* [dofs] */
    double *t;          /* [n] */
    double *f;          /* [1 + planes][n] */
    double *coarse;     /* [2][n/2 + 1] every second time, and its force */
    int32_t n, used;    /* times in all; up to the end of the run */
    sp_front linear[2]; /* from all times, and from every second one */
} experiment;

/* What one run has found. */
typedef struct outcome {
    double factor;
    sp_front front[2];
    sp_front *plane;           /* [planes][2] */
    sp_amplitude_front counts; /* counts and energies */
} outcome;

sp_amplitude_options sp_amplitude_options_default(void) {
    return (sp_amplitude_options){.source = SP_SOURCE_IMPULSE, .tolerance = 1e-3};
}

static void free_records(experiment *e) {
    sp_free(e->t);
    sp_free(e->f);
    sp_free(e->coarse);
    e->t = e->f = e->coarse = NULL;
}

static void experiment_free(experiment *e) {
    free_records(e);
    sp_motion_free(&e->motion);
    sp_network_free(&e->net);
    sp_free(e->source);
    sp_free(e->plane);
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

static bool has_fallen(const sp_front front[2]) { return isfinite(front[0].t_zero) && isfinite(front[1].t_zero); }

/* Whether the front has passed in the first n times of a record. What arrives before it is many powers of ten weaker
 * (`least` tells them apart), and a fifth of its time more shows that no other peak was meant. Behind a loud front the
 * force may stay above that at rest: LONG times the time of the peak is then enough, and t_zero is NAN. */
static bool has_passed(experiment *e, int32_t n, const double *f, double least, sp_front out[2]) {
    sp_error none = {0};
    if (n <= 4 || find_fronts(e, n, f, out, &none) != SP_OK || out[0].amplitude < least)
        return false;
    const bool alike = isfinite(out[0].t_zero) == isfinite(out[1].t_zero); /* else the width would have no error */
    return n == e->n || n == e->used || (alike && e->t[n - 1] >= LONG * out[0].t_peak) ||
           (has_fallen(out) && e->t[n - 1] >= 1.2 * out[0].t_zero);
}

/* Times after which a record is looked at. */
static int32_t part_of(const experiment *e) { return (e->n - 1) / PARTS > 0 ? (e->n - 1) / PARTS : 1; }

static sp_status no_front(sp_error *err, double until) {
    return sp_fail_key(err, SP_EREFUSED, "until", " = %g: the front has not passed the top wall by then", until);
}

/* A quiet front falls back to 0, in low packings later than LONG times its peak: the widths are measured against this
 * time, so that the search goes on until it is there. */
static sp_status find_linear(experiment *e, sp_error *err) {
    const double until = e->until;
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
        found = has_passed(e, n, s.f, WEAKEST * largest, e->linear) && has_fallen(e->linear);
    if (status == SP_OK && !found)
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

static void record(experiment *e, int32_t l, double factor) {
    for (int32_t b = 0; b <= e->planes; b++)
        e->f[(int64_t)b * e->n + l] = sp_motion_force(&e->motion, b) / factor;
}

static sp_status find_at_planes(experiment *e, sp_front *out, sp_error *err) {
    sp_status status = SP_OK;
    for (int32_t b = 0; b < e->planes && status == SP_OK; b++) {
        status = find_fronts(e, e->used, e->f + (int64_t)(b + 1) * e->n, &out[2 * b], err);
        if (status != SP_OK)
            sp_fail_prefix(err, "plane at %g", e->height[b]);
    }
    return status;
}

/* Runs until the front has passed; the first run decides when that is, so that others count the same. */
static sp_status run(experiment *e, double amplitude, int64_t substeps, outcome *out, sp_error *err) {
    const int32_t part = part_of(e), last = e->used > 0 ? e->used : e->n;
    const double least = WEAKEST * e->linear[0].amplitude;
    sp_status status = SP_OK;
    double defect = 0;
    bool found = false;
    out->factor = sp_motion_kick(&e->motion, e->source, e->options->source != SP_SOURCE_DISPLACEMENT, amplitude);
    record(e, 0, out->factor);
    for (int32_t l = 1; l < last && status == SP_OK && !found; l++) {
        status = advance(e, l, substeps, amplitude, err);
        record(e, l, out->factor);
        defect = fmax(defect, sp_motion_energy(&e->motion).defect);
        if (status == SP_OK && (l + 1 == last || (e->used == 0 && l % part == 0))) {
            found = has_passed(e, l + 1, e->f, least, out->front);
            e->used = found ? l + 1 : e->used;
        }
    }
    if (status == SP_OK && !found)
        status = no_front(err, e->t[e->n - 1]);
    if (status == SP_OK)
        status = find_at_planes(e, out->plane, err);
    out->counts = (sp_amplitude_front){.until = e->motion.time, .energy = sp_motion_energy(&e->motion)};
    out->counts.energy.defect = defect;
    sp_motion_count(&e->motion, &out->counts);
    return status;
}

/* ---- results ---------------------------------------------------------------------------------------------------- */

typedef double (*measure_function)(const sp_front *front, const sp_front *linear);

static double speed_of(const sp_front *f, const sp_front *linear) { return linear->t10 / f->t10; }
static double peak_of(const sp_front *f, const sp_front *linear) { return f->amplitude / linear->amplitude; }
static double width_of(const sp_front *f, const sp_front *linear) { return f->width / linear->width; }

/* Of values from the finer and the coarser run, and from every second time. */
static sp_amplitude_number compare(double value, double step, double times) {
    return (sp_amplitude_number){value, fabs(value - step) + fabs(value - times) / 3};
}

/* Of a time at which the force passes a value, or of what follows from such times. It is interpolated by a straight
 * line, whose error depends on where between two times it lies: every second time changes it by that error at least (to
 * second order of the spacing), but not always by three times that. */
static sp_amplitude_number compare_passage(double value, double step, double times) {
    return (sp_amplitude_number){value, fabs(value - step) + fabs(value - times)};
}

/* The error of the steps is below the difference from steps twice as long, that of the times is of second order in
 * their spacing, so a third of the difference: of a ratio to the linear front, with passages at nearly the same place
 * between the times, this holds for passages, too. */
static sp_amplitude_number value_of(const experiment *e, const outcome *now, const outcome *before,
                                    measure_function of) {
    const double value = of(&now->front[0], &e->linear[0]), step = of(&before->front[0], &e->linear[0]),
                 times = of(&now->front[1], &e->linear[1]);
    return compare(value, step, times);
}

static void fill(const experiment *e, const outcome *now, const outcome *before, sp_amplitude_front *out) {
    const double load = e->net.pressure * sp_packing_wall_area(e->motion.packing);
    const sp_amplitude_front kept = *out;
    *out = now->counts;
    out->amplitude = kept.amplitude;
    out->step = kept.step;
    out->factor = now->factor;
    out->front = now->front[0];
    out->t10 = compare_passage(now->front[0].t10, before->front[0].t10, now->front[1].t10);
    out->speed = value_of(e, now, before, speed_of);
    out->peak = value_of(e, now, before, peak_of);
    out->width = value_of(e, now, before, width_of);
    out->overpressure = now->front[0].amplitude * now->factor / load;
}

typedef sp_amplitude_number (*compare_function)(double value, double step, double times);

static sp_amplitude_number speed_between(compare_function by, double rise, double a, double b, const double step[2],
                                         const double times[2]) {
    return by(rise / (b - a), rise / (step[1] - step[0]), rise / (times[1] - times[0]));
}

static void fill_planes(const experiment *e, const outcome *now, const outcome *before, sp_amplitude_plane *plane) {
    const double load = e->net.pressure * sp_packing_wall_area(e->motion.packing), unit = now->factor / load;
    for (int32_t b = 0; b < e->planes; b++) {
        const sp_front *f = &now->plane[2 * b], *step = &before->plane[2 * b], *times = f + 1;
        sp_amplitude_plane *o = &plane[b];
        o->t10 = compare_passage(f->t10, step->t10, times->t10);
        o->t_peak = compare(f->t_peak, step->t_peak, times->t_peak);
        o->overpressure = compare(unit * f->amplitude, unit * step->amplitude, unit * times->amplitude);
        o->speed = o->speed_peak = (sp_amplitude_number){NAN, NAN};
        if (b == 0)
            continue;
        const double rise = o->height - plane[b - 1].height;
        o->speed = speed_between(compare_passage, rise, f[-2].t10, f->t10, (double[]){step[-2].t10, step->t10},
                                 (double[]){times[-2].t10, times->t10});
        o->speed_peak = speed_between(compare, rise, f[-2].t_peak, f->t_peak, (double[]){step[-2].t_peak, step->t_peak},
                                      (double[]){times[-2].t_peak, times->t_peak});
    }
}

/* Error that finer steps can reduce. */
static double step_error(const experiment *e, const outcome *now, const outcome *before) {
    return fmax(fabs(speed_of(&now->front[0], e->linear) - speed_of(&before->front[0], e->linear)),
                now->counts.energy.defect);
}

static sp_status converge(experiment *e, sp_amplitude_front *out, sp_amplitude_plane *plane, sp_error *err) {
    outcome before = {.plane = e->plane}, now = {.plane = e->plane + 2 * e->planes};
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
            if (plane)
                fill_planes(e, &now, &before, plane);
            return SP_OK;
        }
        const outcome kept = before; /* its memory is used again */
        before = now;
        now.plane = kept.plane;
    }
    return status != SP_OK ? status
                           : sp_fail_key(err, SP_EREFUSED, "tolerance",
                                         " = %g: at the amplitude %g it takes more than %lld steps; with them the "
                                         "balance of energy is off by %.1g",
                                         e->options->tolerance, out->amplitude, (long long)substeps / 2 * e->used,
                                         before.counts.energy.defect);
}

/* The record has a time for every RECORD / omega_max, and more for loud pulses: a velocity A omega_max delta compresses
 * contacts to about A^(4/5) delta, and raises frequencies as the fourth root of it. */
static sp_status make_records(experiment *e, double amplitude, sp_error *err) {
    const double omega = sp_network_omega_bound(&e->net) * pow(1 + amplitude, 0.2);
    const double points = ceil(e->until * omega / RECORD) + 1;
    if (!(points * (e->planes + 1) <= POINTS_MAX))
        return sp_fail_key(err, SP_EREFUSED, "until", " = %g: takes more than %d numbers", e->until, POINTS_MAX);
    free_records(e);
    e->used = 0;
    e->n = points > PARTS ? (int32_t)points : PARTS;
    const size_t n = (size_t)e->n, all = n * ((size_t)e->planes + 1);
    e->t = sp_alloc(n, sizeof *e->t);
    e->f = sp_alloc(all, sizeof *e->f);
    e->coarse = sp_alloc(2 * (n / 2 + 1), sizeof *e->coarse);
    return e->t && e->f && e->coarse ? SP_OK : sp_fail_memory(err, (2 * n + all) * sizeof(double));
}

/* Where grains fly farther than gaps are watched, wider gaps are watched. */
static sp_status measure(experiment *e, sp_amplitude_front *out, sp_amplitude_plane *plane, sp_error *err) {
    sp_status status = make_records(e, out->amplitude, err);
    if (status == SP_OK)
        status = find_linear(e, err);
    if (status == SP_OK)
        status = converge(e, out, plane, err);
    while (status == SP_EFAILED && sp_motion_can_widen(&e->motion)) {
        motion wider;
        status = sp_motion_make(e->motion.packing, &e->net, 3 * e->motion.radii, e->planes, e->height, &wider, err);
        if (status != SP_OK)
            return status;
        sp_motion_free(&e->motion);
        e->motion = wider;
        status = converge(e, out, plane, err);
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

/* The linear limit of the motion: all contacts that carry any force, and the rotation of the forces at rest. */
static sp_status prepare(experiment *e, const sp_packing *p, sp_error *err) {
    const sp_network_options links = {.threshold = 0, .prestress = true};
    sp_status status = sp_network_make(p, &links, &e->net, err);
    if (status == SP_OK)
        status = sp_motion_make(p, &e->net, SP_MOTION_NEAR, e->planes, e->height, &e->motion, err);
    if (status != SP_OK)
        return status;
    const size_t dofs = (size_t)sp_network_dofs(&e->net), fronts = 4 * (size_t)e->planes;
    e->until = e->options->until > 0 ? e->options->until : sp_signal_window(sp_packing_height(p), p->pressure);
    e->source = sp_alloc(dofs, sizeof *e->source);
    e->plane = sp_alloc(fronts, sizeof *e->plane);
    if (!e->source || !e->plane)
        return sp_fail_memory(err, dofs * sizeof *e->source + fronts * sizeof *e->plane);
    return sp_network_source(&e->net, e->options->source, e->source, err);
}

sp_status sp_amplitude_pulses(const sp_packing *p, const sp_amplitude_options *opt, int32_t count,
                              const double *amplitude, sp_amplitude_front *out, sp_front *linear, sp_error *err) {
    experiment e = {.options = opt, .net = sp_network_none()};
    sp_status status = check(opt, count, amplitude, err);
    if (status == SP_OK)
        status = prepare(&e, p, err);
    for (int32_t k = 0; k < count && status == SP_OK; k++) {
        out[k] = (sp_amplitude_front){.amplitude = amplitude[k]};
        status = measure(&e, &out[k], NULL, err);
    }
    if (status == SP_OK && linear)
        *linear = e.linear[0];
    experiment_free(&e);
    return status;
}

/* The heights at which the flux through the planes is carried. */
static sp_status find_heights(const experiment *e, sp_amplitude_plane *out, sp_error *err) {
    for (int32_t b = 0; b < e->planes; b++) {
        const bool inside = e->height[b] > 0 && e->height[b] < sp_packing_height(e->motion.packing);
        out[b] = (sp_amplitude_plane){.height = inside ? sp_network_plane_height(&e->net, e->height[b]) : NAN};
        if (isnan(out[b].height))
            return sp_fail_key(err, SP_EINVAL, "height", " = %g: no contact crosses this plane", e->height[b]);
        if (b > 0 && !(out[b].height > out[b - 1].height))
            return sp_fail_key(err, SP_EINVAL, "height", " = %g: the same contacts as at %g, must ascend", e->height[b],
                               e->height[b - 1]);
    }
    return SP_OK;
}

sp_status sp_amplitude_planes(const sp_packing *p, const sp_amplitude_options *opt, double amplitude, int32_t n,
                              const double *height, sp_amplitude_plane *plane, sp_amplitude_front *pulse,
                              sp_error *err) {
    experiment e = {.options = opt, .net = sp_network_none(), .planes = n, .height = height};
    sp_amplitude_front top = {.amplitude = amplitude};
    sp_status status = check(opt, 1, &amplitude, err);
    if (status == SP_OK)
        status = prepare(&e, p, err);
    if (status == SP_OK)
        status = find_heights(&e, plane, err);
    if (status == SP_OK)
        status = measure(&e, &top, plane, err);
    if (status == SP_OK && pulse)
        *pulse = top;
    experiment_free(&e);
    return status;
}
