/* Fits one damped wave to the Fourier integrals of a record section. */
#include "base/base.h"

#include <complex.h>
#include <math.h>
#include <sonopack/coherent.h>

enum { PLANES_LEAST = 4 }; /* a wave has four parameters, a plane gives two numbers */

sp_coherent_section sp_coherent_section_none(void) { return (sp_coherent_section){0}; }

void sp_coherent_section_free(sp_coherent_section *s) {
    sp_free(s->y);
    sp_free(s->arrival);
    sp_free(s->until);
    sp_free(s->f);
    *s = sp_coherent_section_none();
}

/* End of the integrals. The wave arrives at a plane at `at` + `slowness` y, but not before the front. */
typedef struct gate {
    double at, slowness;
    double length; /* duration used after that, if the record is long enough */
    double part;   /* fraction of that duration */
} gate;

static const double PERIODS = 4; /* periods used after the front; later most is scattered */
static const double LEAST = 0.5; /* periods that a plane's record must contain after the wave's arrival */

/* Integrals at the planes that are used: of F e^(i omega t), and of t F e^(i omega t). */
typedef struct integrals {
    int32_t n;
    double *y;                /* [n] */
    double complex *z, *late; /* [n] */
    double complex *phase;    /* [times] e^(i omega t) */
} integrals;

/* Trapezoidal rule, exact up to rounding for a signal without frequencies beyond pi/spacing. A half cosine tapers the
 * record from halfway between the wave's arrival and the end, so that the end causes no artefacts. */
static void integrate_plane(const sp_coherent_section *s, int32_t plane, double fade, double until, integrals *in) {
    const double *f = s->f + (int64_t)plane * s->n;
    double complex z = 0.5 * f[0], late = 0;
    for (int32_t l = 1; l < s->n && l * s->spacing < until; l++) {
        const double t = l * s->spacing;
        const double taper = t <= fade ? 1 : 0.5 + 0.5 * cos(M_PI * (t - fade) / (until - fade));
        const double complex term = taper * f[l] * in->phase[l];
        z += term;
        late += t * term;
    }
    in->y[in->n] = s->y[plane];
    in->z[in->n] = s->spacing * z;
    in->late[in->n++] = s->spacing * late;
}

static void integrate(const sp_coherent_section *s, double omega, const gate *g, integrals *in) {
    const double period = 2 * M_PI / omega;
    in->n = 0;
    for (int32_t j = 0; j < s->planes; j++) {
        const double come = fmax(s->arrival[j], g->at + g->slowness * s->y[j]);
        const double until = fmin(s->until[j], come + g->length);
        const double end = come + g->part * (until - come);
        if (until >= come + LEAST * period)
            integrate_plane(s, j, 0.5 * (come + end), end, in);
    }
}

/* Arrival of waves of this frequency. The real part of -i dS/domega over S is their mean time at a plane. Fits a line
 * to these times, weighted by the planes' squared spectra. False if the line falls. */
static bool follow_group(const integrals *in, gate *g) {
    double weight = 0, y = 0, t = 0, yy = 0, yt = 0;
    for (int32_t j = 0; j < in->n; j++) {
        const double w = creal(in->z[j] * conj(in->z[j])), time = creal(in->late[j] * conj(in->z[j]));
        weight += w;
        y += w * in->y[j];
        t += time;
        yy += w * in->y[j] * in->y[j];
        yt += time * in->y[j];
    }
    g->slowness = (yt - y * t / weight) / (yy - y * y / weight);
    g->at = (t - g->slowness * y) / weight;
    return g->slowness > 0;
}

/* Fraction of the squares left by the best amplitude for (k, alpha). */
static double misfit(int32_t n, const double *y, const double complex *z, double k, double alpha) {
    double complex along = 0;
    double wave = 0, all = 0;
    for (int32_t j = 0; j < n; j++) {
        const double complex e = cexp((I * k - alpha) * (y[j] - y[0]));
        along += z[j] * conj(e);
        wave += creal(e * conj(e));
        all += creal(z[j] * conj(z[j]));
    }
    return all > 0 ? 1 - creal(along * conj(along)) / (wave * all) : NAN;
}

/* Minimum of the parabola through three equidistant values, in steps from the middle one; 0 if there is none. */
static double lowest(double left, double middle, double right) {
    const double curve = left - 2 * middle + right;
    return curve > 0 ? fmax(-1, fmin(1, 0.5 * (left - right) / curve)) : 0;
}

/* Steps of the search, and the smallest alpha. Noise may make a small alpha negative. */
typedef struct search {
    double k, alpha, least;
} search;

/* Refines a point of the grid, alternately in k and alpha, with ever smaller steps. The minimum is isotropic to second
 * order (k affects phases, alpha magnitudes), so this converges fast. */
static void polish(int32_t n, const double *y, const double complex *z, search step, double *k, double *alpha) {
    for (int pass = 0; pass < 60; pass++) {
        const double here = misfit(n, y, z, *k, *alpha), dk = step.k, da = step.alpha;
        const double move = lowest(misfit(n, y, z, *k - dk, *alpha), here, misfit(n, y, z, *k + dk, *alpha));
        if (misfit(n, y, z, *k + move * dk, *alpha) <= here)
            *k += move * dk;
        const double middle = fmax(step.least, *alpha - da) + da;
        const double rest[3] = {misfit(n, y, z, *k, middle - da), misfit(n, y, z, *k, middle),
                                misfit(n, y, z, *k, middle + da)};
        const double next = middle + da * lowest(rest[0], rest[1], rest[2]);
        if (misfit(n, y, z, *k, next) <= misfit(n, y, z, *k, *alpha))
            *alpha = next;
        step.k *= 0.7;
        step.alpha *= 0.7;
    }
}

/* Newton's steps to where the derivatives of log |S|^2/W by k and alpha vanish, with S = sum z conj(e) and W = sum
 * |e|^2: a search that compares misfits stops at the root of their rounding. A step beyond `reach` is not taken: there
 * is no minimum so near, as at a limit of alpha. */
static void sharpen(int32_t n, const double *y, const double complex *z, double reach, double *k, double *alpha) {
    for (int turn = 0; turn < 3; turn++) {
        double complex s[3] = {0};
        double w[3] = {0};
        for (int32_t j = 0; j < n; j++) {
            const double x = y[j] - y[0];
            const double complex e = cexp((I * *k - *alpha) * x), part = z[j] * conj(e);
            for (int m = 0; m < 3; m++) {
                s[m] += pow(x, m) * part;
                w[m] += pow(x, m) * creal(e * conj(e));
            }
        }
        const double complex mean = s[1] / s[0], curve = s[2] / s[0] - mean * mean;
        const double middle = w[1] / w[0], spread = w[2] / w[0] - middle * middle;
        /* Im mean = re dk + im da, Re mean - middle = -im dk + (re - 2 spread) da */
        const double re = creal(curve), im = cimag(curve), low = re - 2 * spread, by_k = cimag(mean);
        const double by_alpha = creal(mean) - middle, det = re * low + im * im;
        const double dk = (by_k * low - im * by_alpha) / det, da = (re * by_alpha + im * by_k) / det;
        if (!(hypot(dk, da) <= reach))
            return;
        *k += dk;
        *alpha += da;
    }
}

/* A fitted wave; `part` is NAN if there is none. */
typedef struct wave {
    double k, alpha, part;
} wave;

/* Steps and limits of the search. */
typedef struct bounds {
    double k_most, dk, a_first, a_least, a_most;
} bounds;

static bounds bounds_of(const sp_coherent_section *s) {
    const double range = s->y[s->planes - 1] - s->y[0], gap = range / (s->planes - 1);
    return (bounds){
        .k_most = M_PI / gap, .dk = 0.5 / range, .a_first = 0.1 / range, .a_least = -1 / range, .a_most = 1 / gap};
}

static wave polish_from(const integrals *in, const bounds *b, wave start) {
    wave w = start;
    polish(in->n, in->y, in->z, (search){fmax(b->dk, 0.5 * w.alpha), fmax(b->a_first, 0.5 * w.alpha), b->a_least}, &w.k,
           &w.alpha);
    sharpen(in->n, in->y, in->z, 1e-5 * b->dk, &w.k, &w.alpha);
    w.part = 1 - misfit(in->n, in->y, in->z, w.k, w.alpha);
    return w;
}

/* The best point of a grid, refined. */
static wave find_wave(const integrals *in, const bounds *b) {
    wave w = {NAN, NAN, NAN};
    double least = INFINITY;
    if (in->n < PLANES_LEAST)
        return w;
    for (double a = b->a_first; a < b->a_most; a *= 2)
        for (double k = 0; k <= b->k_most; k += fmax(b->dk, 0.5 * a)) {
            const double left = misfit(in->n, in->y, in->z, k, a);
            if (left < least) {
                least = left;
                w = (wave){k, a, 0};
            }
        }
    return isfinite(least) ? polish_from(in, b, w) : w;
}

/* Integrals to the end of the records, after the arrival of the group is known. Each guess lengthens the integrals,
 * which includes later waves. */
static wave find_late_wave(const sp_coherent_section *s, double omega, const bounds *b, gate *g, integrals *in) {
    enum { TURNS_MAX = 8 };
    wave none = {NAN, NAN, NAN};
    *g = (gate){.length = INFINITY, .part = 1};
    integrate(s, omega, g, in);
    for (int turn = 0; turn < TURNS_MAX; turn++) {
        const double before = g->slowness;
        if (in->n < PLANES_LEAST || !follow_group(in, g))
            return none;
        integrate(s, omega, g, in);
        if (fabs(g->slowness - before) < 0.01 * g->slowness)
            break;
    }
    return find_wave(in, b);
}

/* Most of what arrives late is scattered and belongs to no wave along y. In an ordered system nothing is scattered, and
 * slow waves arrive late. So the later end is used only if it leaves less than half as much unexplained. */
static wave choose_wave(const sp_coherent_section *s, double omega, const bounds *b, gate *g, integrals *in) {
    gate whole;
    *g = (gate){.length = PERIODS * 2 * M_PI / omega, .part = 1};
    integrate(s, omega, g, in);
    const wave early = find_wave(in, b), late = find_late_wave(s, omega, b, &whole, in);
    if (!(1 - late.part < 0.5 * (1 - early.part)))
        return early;
    *g = whole;
    return late;
}

static bool is_wave(const wave *w, const bounds *b) {
    return w->k > w->alpha && w->k > 0 && w->k < b->k_most && w->alpha > b->a_least && w->alpha < b->a_most;
}

static sp_status check(const sp_coherent_section *s, double omega, sp_error *err) {
    if (s->planes < PLANES_LEAST || s->n < 3 || !(s->spacing > 0))
        return sp_fail(err, SP_EINVAL, "coherent wave: %d planes of %d times, at least %d and 3 are needed", s->planes,
                       s->n, PLANES_LEAST);
    for (int32_t j = 1; j < s->planes; j++)
        if (!(s->y[j] > s->y[j - 1]))
            return sp_fail(err, SP_EINVAL, "coherent wave: height %g of plane %d is not above the one before, %g",
                           s->y[j], j, s->y[j - 1]);
    if (!(omega > 0) || !(omega * s->spacing < M_PI / 2))
        return sp_fail(err, SP_EINVAL, "coherent wave: omega = %g: must be above 0 and below %g for times at %g", omega,
                       M_PI / 2 / s->spacing, s->spacing);
    return SP_OK;
}

/* Whether some record contains a period. In shorter ones the integrals reflect only the end of the front, at any
 * frequency. */
static bool holds_period(const sp_coherent_section *s, double omega) {
    double longest = 0;
    for (int32_t j = 0; j < s->planes; j++)
        longest = fmax(longest, s->until[j]);
    return omega * longest >= 2 * M_PI;
}

static sp_status open_integrals(const sp_coherent_section *s, double omega, integrals *in, sp_error *err) {
    const size_t planes = (size_t)s->planes, size = 2 * planes + (size_t)s->n;
    *in = (integrals){.y = sp_alloc(planes, sizeof *in->y), .z = sp_alloc(size, sizeof *in->z)};
    if (!in->y || !in->z) {
        sp_free(in->y);
        sp_free(in->z);
        return sp_fail_memory(err, size * sizeof *in->z);
    }
    in->late = in->z + planes;
    in->phase = in->z + 2 * planes;
    for (int32_t l = 0; l < s->n; l++)
        in->phase[l] = cexp(I * fmod(omega * (l * s->spacing), 2 * M_PI));
    return SP_OK;
}

sp_status sp_coherent_fit(const sp_coherent_section *s, double omega, sp_coherent_wave *out, sp_error *err) {
    sp_status status = check(s, omega, err);
    if (status != SP_OK)
        return status;
    if (!holds_period(s, omega) || (s->highest > 0 && omega > s->highest)) {
        *out = (sp_coherent_wave){omega, NAN, NAN, NAN, NAN, NAN};
        return SP_OK;
    }
    const bounds b = bounds_of(s);
    integrals in;
    gate g;
    status = open_integrals(s, omega, &in, err);
    if (status != SP_OK)
        return status;
    const wave w = choose_wave(s, omega, &b, &g, &in);
    sp_coherent_wave fit = {omega, NAN, NAN, w.part, NAN, NAN};
    if (is_wave(&w, &b)) {
        fit.k = w.k;
        fit.alpha = w.alpha;
        g.part = 0.5;
        integrate(s, omega, &g, &in);
        const wave half = polish_from(&in, &b, w);
        fit.k_shift = half.k - w.k;
        fit.alpha_shift = half.alpha - w.alpha;
    }
    sp_free(in.y);
    sp_free(in.z);
    *out = fit;
    return SP_OK;
}

/* ---- mean free paths, and where waves cease to be waves (Ioffe and Regel) ---------------------------------------- */

/* Of k and of alpha, from what the wave does not explain: that of a least-squares fit to fluxes that are independent at
 * planes a diameter apart. The weight of a plane in it is the square of the wave. */
static double fit_error(const sp_coherent_section *s, const sp_coherent_wave *c) {
    const double low = s->y[0], span = s->y[s->planes - 1] - low;
    double sum = 0, first = 0, second = 0;
    for (int32_t b = 0; b < s->planes; b++) {
        const double y = s->y[b] - low, weight = exp(-2 * c->alpha * y);
        sum += weight;
        first += weight * y;
        second += weight * y * y;
    }
    const double variance = second / sum - first * first / (sum * sum), count = fmin(s->planes, 1 + span);
    return sqrt((1 - c->part) / (2 * c->part * count * variance));
}

void sp_coherent_errors(const sp_coherent_section *s, const sp_coherent_wave *fit, double *k_err, double *alpha_err) {
    const double error = fit_error(s, fit);
    *k_err = hypot(fit->k_shift, error);
    *alpha_err = hypot(fit->alpha_shift, error);
}

sp_free_path sp_free_path_of(double k, double k_err, double alpha, double alpha_err) {
    sp_free_path p = {NAN, NAN, 0.5 / (fmax(0, alpha) + 2 * alpha_err), NAN, NAN};
    if (alpha > 2 * alpha_err) {
        p.path = 0.5 / alpha;
        p.path_err = p.path * alpha_err / alpha;
        p.k_path = k * p.path;
        p.k_path_err = p.k_path * hypot(k_err / k, alpha_err / alpha);
    }
    return p;
}

bool sp_ioffe_regel(int32_t n, const double *omega, const sp_free_path *path, double *out, double *error) {
    for (int32_t l = 1; l < n; l++) {
        const sp_free_path one = path[l - 1], two = path[l];
        if (!(one.k_path > M_PI && two.k_path <= M_PI))
            continue;
        const double part = (one.k_path - M_PI) / (one.k_path - two.k_path), step = omega[l] - omega[l - 1];
        *out = omega[l - 1] + part * step;
        *error = hypot((1 - part) * one.k_path_err, part * two.k_path_err) * step / (one.k_path - two.k_path);
        return true;
    }
    return false;
}
