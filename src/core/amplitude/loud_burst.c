/* Harmonics of a loud burst. The bottom wall moves, which in the linear limit pushes its grains as the source of
 * sp_signal_pulse does. */
#include "amplitude/loud_motion.h"
#include "base/base.h"
#include "numeric/statistics.h"
#include "signal/job.h"

#include <complex.h>
#include <math.h>
#include <string.h>

/* Spacing of the record, and longest step, over 1/omega_max. */
#define RECORD   0.5
#define WORK_MAX 3e9
/* Part of the time of the front in which the slower burst is late. */
#define LATE 0.3
enum { ATTEMPTS = 8, CYCLES_MIN = 3, CYCLES_MAX = 10000, POINTS_MAX = 100000000 };

typedef struct experiment {
    const sp_amplitude_options *options;
    const sp_amplitude_burst *burst;
    sp_pulse pulse;
    motion motion;
    sp_network net;
    int32_t planes, n;      /* times */
    double spacing, load;   /* of the times; force at rest */
    double slowness;        /* of the linear front, t10/H: it tells phases apart that differ by full turns */
    double *f[2];           /* [planes][n] of both signs */
    double *until, *height; /* [planes] */
    sp_amplitude_energy energy;
} experiment;

/* Of one plane: sums of the even and odd parts with exp(-i n omega t). */
typedef struct spectrum {
    double complex of[4];
} spectrum;

static void experiment_free(experiment *e) {
    sp_motion_free(&e->motion);
    sp_network_free(&e->net);
    sp_free(e->f[0]);
    sp_free(e->f[1]);
    sp_free(e->until);
}

static double duration(const sp_amplitude_burst *b) { return 2 * M_PI * b->cycles / b->omega; }

/* ---- motion ----------------------------------------------------------------------------------------------------- */

static double wall_at(const experiment *e, double sign, double t) {
    return sign * e->burst->amplitude * e->motion.overlap * sp_pulse_strength(&e->pulse, t);
}

/* One burst, upwards first or downwards first. */
static sp_status run(experiment *e, int sign, int64_t substeps, sp_error *err) {
    const double h = e->spacing / (double)substeps;
    double *f = e->f[sign < 0], worst = 0, input = 0;
    sp_status status = SP_OK;
    sp_motion_rest(&e->motion);
    sp_vibration_begin(&e->motion.m);
    for (int32_t l = 0; l < e->n && status == SP_OK; l++) {
        for (int64_t k = 1; k <= (l > 0 ? substeps : 0); k++)
            sp_motion_step(&e->motion, h, wall_at(e, sign, (l - 1) * e->spacing + (double)k * h));
        for (int32_t b = 0; b < e->planes; b++)
            f[(int64_t)b * e->n + l] = sp_motion_force(&e->motion, b + 1) / e->load;
        const sp_amplitude_energy now = sp_motion_energy(&e->motion);
        worst = fmax(worst, fabs(now.defect * now.input));
        input = fmax(input, now.input);
        e->energy = now;
        status = sp_motion_check(&e->motion, e->burst->amplitude, err);
    }
    e->energy.defect = worst / input;
    return status;
}

static sp_status run_both(experiment *e, int64_t substeps, sp_error *err) {
    sp_status status = run(e, -1, substeps, err);
    return status == SP_OK ? run(e, 1, substeps, err) : status;
}

/* ---- harmonics -------------------------------------------------------------------------------------------------- */

/* Over `part` of the record of a plane. */
static spectrum spectrum_of(const experiment *e, int32_t plane, double part) {
    const double *up = e->f[0] + (int64_t)plane * e->n, *down = e->f[1] + (int64_t)plane * e->n;
    const double arrival = 0.5 * (e->until[plane] - duration(e->burst));
    const double end = fmin(e->until[plane], fmax(arrival, part * e->until[plane]));
    spectrum s = {{0}};
    for (int32_t l = 0; l < e->n && l * e->spacing <= end; l++) {
        const double t = l * e->spacing, even = 0.5 * (up[l] + down[l]), odd = 0.5 * (up[l] - down[l]);
        for (int k = 0; k < 4; k++)
            s.of[k] += (k % 2 ? odd : even) * cexp(-I * (k * e->burst->omega * t)) * e->spacing;
    }
    /* amplitude a below w^k: the integral is a times half (mean: all) the duration times the mean of w^k */
    static const double envelope[] = {8.0 / 3, 4, 16.0 / 3, 32.0 / 5};
    for (int k = 0; k < 4; k++)
        s.of[k] *= envelope[k] / duration(e->burst);
    return s;
}

static sp_amplitude_number value_of(double now, double before, double shorter) {
    return (sp_amplitude_number){now, fabs(now - before) + fabs(now - shorter)};
}

/* The phase that is nearest to the expected one. */
static double turned(double phase, double last) { return phase - 2 * M_PI * round((phase - last) / (2 * M_PI)); }

/* now: of the finer steps; before: of the coarser ones; shorter: of a shorter record. */
static void describe(const spectrum *now, const spectrum *before, const spectrum *shorter, double expected,
                     sp_amplitude_harmonics *out) {
    sp_amplitude_number *const to[] = {&out->mean, &out->first, &out->second, &out->third};
    for (int k = 0; k < 4; k++)
        *to[k] = value_of(cabs(now->of[k]), cabs(before->of[k]), cabs(shorter->of[k]));
    out->mean.value = creal(now->of[0]);
    const double phase = turned(carg(now->of[1]), expected);
    out->phase = value_of(phase, turned(carg(before->of[1]), phase), turned(carg(shorter->of[1]), phase));
    const double one = cabs(now->of[1]), old = cabs(before->of[1]), less = cabs(shorter->of[1]);
    out->ratio = value_of(cabs(now->of[2]) / (one * one), cabs(before->of[2]) / (old * old),
                          cabs(shorter->of[2]) / (less * less));
}

/* ---- convergence ------------------------------------------------------------------------------------------------ */

static double largest_change(const experiment *e, const spectrum *now, const spectrum *before) {
    double worst = e->energy.defect;
    for (int32_t b = 0; b < e->planes; b++)
        worst = fmax(worst, cabs(now[b].of[1] - before[b].of[1]) / cabs(now[b].of[1]));
    return worst;
}

static void take_spectra(const experiment *e, double part, spectrum *out) {
    for (int32_t b = 0; b < e->planes; b++)
        out[b] = spectrum_of(e, b, part);
}

/* s: [3][planes]: finer, coarser, shorter. */
static sp_status converge(experiment *e, spectrum *s, double *step, sp_error *err) {
    int64_t substeps = 1;
    spectrum *now = s, *before = s + e->planes;
    sp_status status = run_both(e, substeps, err);
    take_spectra(e, 1, now);
    for (int k = 0; k < ATTEMPTS && status == SP_OK; k++) {
        memcpy(before, now, (size_t)e->planes * sizeof *now);
        substeps *= 2;
        if (!((double)substeps * e->n * e->motion.m.count <= WORK_MAX))
            break;
        status = run_both(e, substeps, err);
        take_spectra(e, 1, now);
        if (status == SP_OK && largest_change(e, now, before) <= e->options->tolerance) {
            take_spectra(e, 0.9, s + 2 * e->planes);
            *step = e->spacing / (double)substeps;
            return SP_OK;
        }
    }
    return status != SP_OK
               ? status
               : sp_fail_key(err, SP_EREFUSED, "tolerance", " = %g: takes more than %lld steps at the amplitude %g",
                             e->options->tolerance, (long long)substeps / 2 * e->n, e->burst->amplitude);
}

/* ---- what the planes tell --------------------------------------------------------------------------------------- */

/* The slope against height, with the error of its scatter and the mean error of the values. */
static sp_status slope_of(const experiment *e, const double *y, const sp_amplitude_harmonics *plane,
                          sp_amplitude_number (*of)(const sp_amplitude_harmonics *), double *values,
                          sp_amplitude_number *out, sp_error *err) {
    sp_line line;
    double error = 0;
    for (int32_t b = 0; b < e->planes; b++) {
        values[b] = of(&plane[b]).value;
        error += of(&plane[b]).error / e->planes;
    }
    const sp_status status = sp_fit_line(e->planes, y, values, NULL, &line, err);
    if (status == SP_OK)
        *out = (sp_amplitude_number){line.slope, line.slope_err + error / (y[e->planes - 1] - y[0])};
    return status;
}

static sp_amplitude_number phase_of(const sp_amplitude_harmonics *h) { return h->phase; }
static sp_amplitude_number ratio_of(const sp_amplitude_harmonics *h) { return h->ratio; }

static sp_status summarise(const experiment *e, const sp_amplitude_harmonics *plane, sp_amplitude_second *out,
                           sp_error *err) {
    double *y = sp_alloc(2 * (size_t)e->planes, sizeof *y), mass = 0;
    if (!y)
        return sp_fail_memory(err, 2 * (size_t)e->planes * sizeof *y);
    for (int32_t b = 0; b < e->planes; b++)
        y[b] = plane[b].height;
    for (int32_t i = 0; i < e->motion.m.n; i++)
        mass += e->motion.m.mass[2 * i];
    sp_status status = slope_of(e, y, plane, phase_of, y + e->planes, &out->k, err);
    if (status == SP_OK)
        status = slope_of(e, y, plane, ratio_of, y + e->planes, &out->slope, err);
    sp_free(y);
    if (status != SP_OK)
        return status;
    const double omega = e->burst->omega, density = mass / sp_packing_volume(e->motion.packing);
    out->k.value = -out->k.value; /* the phase falls */
    const double relative = fabs(out->k.error / out->k.value), c = omega / out->k.value;
    const double factor = 4 * density * c * c * c / (omega * e->net.pressure);
    out->speed = (sp_amplitude_number){c, fabs(c) * relative};
    out->beta = (sp_amplitude_number){factor * out->slope.value,
                                      fabs(factor) * (out->slope.error + 3 * relative * fabs(out->slope.value))};
    out->energy = e->energy;
    return SP_OK;
}

/* ---- preparation ------------------------------------------------------------------------------------------------ */

static sp_status check(const sp_amplitude_options *o, const sp_amplitude_burst *b, int32_t n, bool fit, sp_error *err) {
    if (!(b->amplitude >= 1e-9 && b->amplitude <= 1e6))
        return sp_fail_key(err, SP_EINVAL, "amplitude", " = %g: must be in 1e-9 .. 1e6", b->amplitude);
    if (!(b->omega > 0 && isfinite(b->omega)))
        return sp_fail_key(err, SP_EINVAL, "omega", " = %g: must be positive", b->omega);
    if (b->cycles < CYCLES_MIN || b->cycles > CYCLES_MAX)
        return sp_fail_key(err, SP_EINVAL, "cycles", " = %d: must be in %d .. %d", b->cycles, CYCLES_MIN, CYCLES_MAX);
    if (!(o->tolerance >= 1e-8 && o->tolerance <= 0.1))
        return sp_fail_key(err, SP_EINVAL, "tolerance", " = %g: must be in 1e-8 .. 0.1", o->tolerance);
    return n < (fit ? 3 : 1)
               ? sp_fail_key(err, SP_EINVAL, "planes", " = %d: must be %s", n, fit ? "3 or more" : "1 or more")
               : SP_OK;
}

/* The linear front at the top wall. */
static sp_status find_front(const experiment *e, double height, sp_front *out, sp_error *err) {
    sp_signal_options o = sp_signal_options_default();
    o.method = SP_SIGNAL_CHEBYSHEV;
    o.until = sp_signal_window(height, e->net.pressure);
    o.points = (int32_t)ceil(20 * height) + 200;
    return sp_signal_front(&e->net, &o, out, err);
}

/* When the front comes back to each plane; the burst must have passed by then. */
static sp_status find_ends(experiment *e, double height, double t10, sp_amplitude_harmonics *plane, sp_error *err) {
    for (int32_t b = 0; b < e->planes; b++) {
        const double y = e->height[b], late = (1 + LATE) * t10 * y / height + duration(e->burst);
        e->until[b] = plane[b].until = t10 * (2 - y / height);
        if (!(e->until[b] >= late))
            return sp_fail_key(
                err, SP_EREFUSED, "cycles",
                " = %d: at the height %.4g the front comes back at t = %.4g, and the burst has passed at "
                "%.4g only: fewer cycles, a lower plane or a higher frequency",
                e->burst->cycles, plane[b].height, e->until[b], late);
    }
    return SP_OK;
}

static sp_status find_heights(const experiment *e, double top, sp_amplitude_harmonics *plane, sp_error *err) {
    for (int32_t b = 0; b < e->planes; b++) {
        const bool inside = e->height[b] > 0 && e->height[b] < top;
        plane[b] = (sp_amplitude_harmonics){.height = inside ? sp_network_plane_height(&e->net, e->height[b]) : NAN};
        if (isnan(plane[b].height) || (b > 0 && !(plane[b].height > plane[b - 1].height)))
            return sp_fail_key(err, SP_EINVAL, "height",
                               " = %g: must be inside the packing, above the plane before and its contacts",
                               e->height[b]);
    }
    return SP_OK;
}

static sp_status allocate(experiment *e, sp_error *err) {
    double until = 0;
    for (int32_t b = 0; b < e->planes; b++)
        until = fmax(until, e->until[b]);
    e->spacing = RECORD / (sp_network_omega_bound(&e->net) * pow(1 + e->burst->amplitude, 0.25));
    const double points = ceil(until / e->spacing) + 1;
    if (!(points * e->planes <= POINTS_MAX))
        return sp_fail_key(err, SP_EREFUSED, "planes", " = %d: records of %g times", e->planes, points);
    e->n = (int32_t)points;
    const size_t all = (size_t)e->n * (size_t)e->planes;
    e->f[0] = sp_alloc(all, sizeof(double));
    e->f[1] = sp_alloc(all, sizeof(double));
    return e->f[0] && e->f[1] ? SP_OK : sp_fail_memory(err, 2 * all * sizeof(double));
}

/* Equal distances up to the highest plane that the burst has passed before the front comes back. */
static sp_status place_planes(experiment *e, double height, double t10, sp_error *err) {
    const double top = height * (2 - duration(e->burst) / t10) / (2 + LATE) * (1 - 1e-9);
    if (!(top > 0))
        return sp_fail_key(err, SP_EREFUSED, "cycles",
                           " = %d: the burst takes %.4g, and the front comes back after %.4g: must be fewer, or of a "
                           "higher frequency",
                           e->burst->cycles, duration(e->burst), 2 * t10);
    for (int32_t b = 0; b < e->planes; b++)
        e->height[b] = top * (b + 1) / e->planes;
    return SP_OK;
}

static sp_status check_frequency(const experiment *e, sp_error *err) {
    const double highest = sp_network_omega_bound(&e->net);
    if (2 * e->burst->omega < highest)
        return SP_OK;
    return sp_fail_key(err, SP_EREFUSED, "omega",
                       " = %g: the second harmonic is above the largest frequency of the network, %.4g",
                       e->burst->omega, highest);
}

static sp_status prepare(experiment *e, const sp_packing *p, const double *height, sp_amplitude_harmonics *plane,
                         sp_error *err) {
    const sp_network_options links = {.threshold = 0, .prestress = true};
    const double top = sp_packing_height(p);
    sp_front front = {0};
    e->until = sp_alloc(2 * (size_t)e->planes, sizeof *e->until);
    if (!e->until)
        return sp_fail_memory(err, 2 * (size_t)e->planes * sizeof *e->until);
    e->height = e->until + e->planes;
    sp_status status = sp_network_make(p, &links, &e->net, err);
    if (status == SP_OK)
        status = sp_motion_need_walls(&e->net, err);
    if (status == SP_OK)
        status = check_frequency(e, err);
    if (status == SP_OK)
        status = find_front(e, top, &front, err);
    if (status == SP_OK && height)
        memcpy(e->height, height, (size_t)e->planes * sizeof *height);
    else if (status == SP_OK)
        status = place_planes(e, top, front.t10, err);
    if (status == SP_OK)
        status = find_heights(e, top, plane, err);
    if (status == SP_OK)
        status = find_ends(e, top, front.t10, plane, err);
    if (status == SP_OK)
        status = sp_motion_make(p, &e->net, SP_MOTION_NEAR, e->planes, e->height, &e->motion, err);
    e->load = e->net.pressure * sp_packing_wall_area(p);
    e->slowness = front.t10 / top;
    return status == SP_OK ? allocate(e, err) : status;
}

sp_status sp_amplitude_bursts(const sp_packing *p, const sp_amplitude_options *opt, const sp_amplitude_burst *burst,
                              int32_t n, const double *height, sp_amplitude_harmonics *plane,
                              sp_amplitude_second *second, sp_error *err) {
    experiment e = {.options = opt, .burst = burst, .net = sp_network_none(), .planes = n};
    spectrum *s = NULL;
    double step = 0;
    sp_status status = check(opt, burst, n, second != NULL, err);
    e.pulse = (sp_pulse){.kind = SP_PULSE_SINE, .omega = burst->omega, .cycles = burst->cycles};
    if (status == SP_OK)
        status = prepare(&e, p, height, plane, err);
    if (status == SP_OK) {
        s = sp_alloc(3 * (size_t)n, sizeof *s);
        status = s ? converge(&e, s, &step, err) : sp_fail_memory(err, 3 * (size_t)n * sizeof *s);
    }
    for (int32_t b = 0; b < n && status == SP_OK; b++) {
        const double late = b > 0 ? (plane[b].height - plane[b - 1].height) * e.slowness * burst->omega : 0;
        describe(&s[b], &s[n + b], &s[2 * n + b], b > 0 ? plane[b - 1].phase.value - late : 0, &plane[b]);
    }
    if (status == SP_OK && second) {
        status = summarise(&e, plane, second, err);
        second->step = step;
    }
    sp_free(s);
    experiment_free(&e);
    return status;
}
