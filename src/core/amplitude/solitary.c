/* Solitary waves of a chain of Hertzian balls. With overlaps in units of that at rest, r beyond it, and times in those
 * of sound from ball to ball, r(x - s t) obeys s^2 r'' = g(x+1) - 2 g(x) + g(x-1), g = 2/3 ((1 + r)^(3/2) - 1).
 * Integrated twice, s^2 r = tent * g, where the tent 1 - |x| has the transform (sin(k/2)/(k/2))^2.
 *
 * The even function r is a cosine series on a length at whose end it is below 1e-15 of its peak. Petviashvili's
 * iteration finds it for a given speed: with the linear part of g on the left side, L r = N(r), the next r is S^2 L^-1
 * N(r), where S = <r, L r>/<r, N(r)> takes the growth of the amplitude out; what is left shrinks by half in every
 * iteration. */
#include "base/base.h"

#include <math.h>
#include <sonopack/amplitude.h>
#include <string.h>

enum { ITERATIONS = 400, SPEEDS = 60 };
#define PEAK_LOW  1e-4
#define PEAK_HIGH 1e9
#define DECAY     36.0 /* -log of r at the end of the length */

typedef struct wave {
    bool bare;      /* no force at rest: g = 2/3 r^(3/2), and s = 1 sets the unit of r */
    double s;       /* speed over c */
    double length;  /* half of the period */
    int n;          /* intervals in it */
    double *r, *rk; /* [n + 1] values, and coefficients of the cosine series */
    double *g, *gk; /* of the right side */
    double *cosine; /* [2 n] */
} wave;

static void wave_free(wave *w) { sp_free(w->r); }

static sp_status wave_alloc(wave *w, int n, sp_error *err) {
    const size_t size = 4 * ((size_t)n + 1) + 2 * (size_t)n;
    w->n = n;
    w->r = sp_alloc(size, sizeof *w->r);
    if (!w->r)
        return sp_fail_memory(err, size * sizeof *w->r);
    w->rk = w->r + (n + 1);
    w->g = w->rk + (n + 1);
    w->gk = w->g + (n + 1);
    w->cosine = w->gk + (n + 1);
    for (int k = 0; k < 2 * n; k++)
        w->cosine[k] = cos(M_PI * k / n);
    return SP_OK;
}

/* sum'' over k of a[k] cos(pi k j/n), the first and last halved: both ways of the transform but for the factor 2/n. */
static void transform(const wave *w, const double *a, double factor, double *out) {
    for (int j = 0; j <= w->n; j++) {
        double sum = 0.5 * (a[0] + (j % 2 ? -a[w->n] : a[w->n]));
        for (int k = 1, at = j; k < w->n; k++, at += j) {
            at -= at >= 2 * w->n ? 2 * w->n : 0;
            sum += a[k] * w->cosine[at];
        }
        out[j] = factor * sum;
    }
}

static double wave_number(const wave *w, int k) { return M_PI * k / w->length; }

static double sinc(double x) { return fabs(x) < 1e-8 ? 1 : sin(x) / x; }

/* g(r), without what the left side takes of it. */
static double beyond(const wave *w, double r) {
    if (w->bare)
        return 2.0 / 3.0 * fmax(0, r) * sqrt(fmax(0, r));
    if (fabs(r) < 1e-2) /* the binomial series of 2/3 (1 + r)^(3/2), where the difference would lose digits */
        return r * r * (0.25 - r * (1.0 / 24 - r * (1.0 / 64 - r * (1.0 / 128 - r * (7.0 / 1536 - r * (3.0 / 1024))))));
    const double whole = fmax(0, 1 + r);
    return 2.0 / 3.0 * (whole * sqrt(whole) - 1) - r;
}

/* Left side in the series: s^2 less the linear part of the right side. */
static double left(const wave *w, int k) {
    const double tent = sinc(0.5 * wave_number(w, k)) * sinc(0.5 * wave_number(w, k));
    return w->s * w->s - (w->bare ? 0 : tent);
}

/* One iteration. Returns the change relative to the peak. */
static double iterate(wave *w, double power) {
    double has = 0, gets = 0, change = 0;
    for (int j = 0; j <= w->n; j++)
        w->g[j] = beyond(w, w->r[j]);
    transform(w, w->g, 2.0 / w->n, w->gk);
    for (int k = 0; k <= w->n; k++) {
        const double weight = k > 0 && k < w->n ? 1 : 0.25, tent = sinc(0.5 * wave_number(w, k));
        w->gk[k] *= tent * tent;
        has += weight * left(w, k) * w->rk[k] * w->rk[k];
        gets += weight * w->gk[k] * w->rk[k];
    }
    const double factor = pow(has / gets, power);
    for (int k = 0; k <= w->n; k++)
        w->rk[k] = factor * w->gk[k] / left(w, k);
    transform(w, w->rk, 1, w->g);
    for (int j = 0; j <= w->n; j++) {
        change = fmax(change, fabs(w->g[j] - w->r[j]));
        w->r[j] = w->g[j];
    }
    return change / w->r[0];
}

/* Rate mu of the tails exp(-mu x): s = sinh(mu/2)/(mu/2). */
static double tail_of(double s) {
    double low = 0, high = 1;
    while (sinh(0.5 * high) < 0.5 * high * s)
        high *= 2;
    for (int k = 0; k < 100; k++) {
        const double mid = 0.5 * (low + high);
        *(sinh(0.5 * mid) < 0.5 * mid * s ? &low : &high) = mid;
    }
    return 0.5 * (low + high);
}

/* Solves for one speed, with `fine` times the usual points. Free afterwards, after a failure too. */
static sp_status solve(bool bare, double s, double fine, wave *w, sp_error *err) {
    const double mu = bare ? 8 : tail_of(s), power = bare ? 3 : 2;
    *w = (wave){.bare = bare, .s = s, .length = bare ? 8 : DECAY / mu + 3};
    sp_status status = wave_alloc(w, (int)ceil(fine * w->length * fmax(mu / 0.15, bare || mu > 1 ? 12 : 0)), err);
    if (status != SP_OK)
        return status;
    const double guess = bare ? 2.25 : 6 * (s * s - 1);
    for (int j = 0; j <= w->n; j++) {
        const double x = w->length * j / w->n, c = cosh(x * fmin(2, sqrt(0.5 * guess)));
        w->r[j] = guess / (c * c);
    }
    transform(w, w->r, 2.0 / w->n, w->rk);
    double before = INFINITY;
    for (int k = 0; k < ITERATIONS; k++) {
        const double change = iterate(w, power);
        if (change < 1e-14 || (change < 1e-9 && change > 0.9 * before))
            break; /* rounding errors are left */
        before = change;
    }
    return SP_OK;
}

/* ---- what is told of a wave ------------------------------------------------------------------------------------- */

static double overlap_at(const wave *w, double x) {
    double sum = 0.5 * w->rk[0];
    for (int k = 1; k <= w->n; k++)
        sum += (k < w->n ? 1 : 0.5) * w->rk[k] * cos(wave_number(w, k) * x);
    return fabs(x) <= w->length ? sum : 0;
}

/* v' = g(x + 1/2) - g(x - 1/2) over s, so that its transform is that of r times s k/2/sin(k/2). With s^2 r = tent g
 * this is sinc g/s, without a quotient of small numbers; g is that of w->gk, which has the tent. */
static double velocity_at(const wave *w, double x) {
    double sum = 0;
    for (int k = 0; k <= w->n; k++) {
        const double q = wave_number(w, k), half = sinc(0.5 * q), weight = k % w->n ? 1 : 0.5;
        const double whole = fabs(half) > 1e-5 ? w->s * w->rk[k] / half : 0;
        sum += weight * whole * cos(q * x);
    }
    return fabs(x) <= w->length ? sum : 0;
}

static double half_width(const wave *w) {
    double low = 0, high = w->length;
    for (int k = 0; k < 60; k++) {
        const double mid = 0.5 * (low + high);
        *(overlap_at(w, mid) > 0.5 * w->r[0] ? &low : &high) = mid;
    }
    return 2 * low;
}

/* Speed of long waves over c: sqrt(4/15 (3 + 2 y^(5/2) - 5 y))/(y - 1) with y = 1 + peak. */
static double nesterenko(double peak) {
    const double y = 1 + peak, a = sqrt(y);
    /* 2 a^5 - 5 a^2 + 3 = (a - 1)^2 (2 a^3 + 4 a^2 + 6 a + 3) and y - 1 = (a - 1)(a + 1) */
    return sqrt(4.0 / 15.0 * (2 * a * a * a + 4 * a * a + 6 * a + 3)) / (a + 1);
}

static void describe(const wave *w, double peak, sp_solitary *out) {
    const double y = w->bare ? w->r[0] : 1 + peak, sound = sqrt(sqrt(y));
    *out = (sp_solitary){.peak = peak,
                         .force = pow(1 + peak, 1.5),
                         .speed = w->bare ? INFINITY : w->s,
                         .velocity = w->bare ? INFINITY : velocity_at(w, 0),
                         .width = half_width(w),
                         .kdv = sqrt(1 + peak / 6),
                         .kdv_width = w->bare ? 0 : 2 * acosh(sqrt(2)) * sqrt(2 / peak),
                         .nesterenko = w->bare ? INFINITY : nesterenko(peak),
                         .speed_at_peak = w->s / sound,
                         .velocity_at_peak = velocity_at(w, 0) / (sound * y),
                         .nesterenko_at_peak = w->bare ? sqrt(8.0 / 15.0) : nesterenko(peak) / sound};
}

/* The wave of a peak: its speed by the secant method from that of long waves, which is within 2% of it. */
static sp_status solve_peak(double peak, double fine, wave *w, sp_error *err) {
    if (isinf(peak))
        return solve(true, 1, fine, w, err);
    double s[2] = {nesterenko(peak), 0}, off[2];
    sp_status status = solve(false, s[0], fine, w, err);
    off[0] = status == SP_OK ? log(w->r[0] / peak) : 0;
    s[1] = 1 + (s[0] - 1) * (off[0] > 0 ? 0.99 : 1.01);
    for (int k = 0; k < SPEEDS && status == SP_OK; k++) {
        wave_free(w);
        status = solve(false, s[1], fine, w, err);
        off[1] = status == SP_OK ? log(w->r[0] / peak) : 0;
        if (fabs(off[1]) < 1e-13 || fabs(s[1] - s[0]) <= 2e-16 * s[1] || off[1] == off[0])
            break;
        const double next = s[1] - off[1] * (s[1] - s[0]) / (off[1] - off[0]);
        s[0] = s[1];
        off[0] = off[1];
        s[1] = next > 1 ? next : 0.5 * (1 + s[1]);
    }
    return status;
}

static sp_status check(double peak, sp_error *err) {
    if (peak == INFINITY || (peak >= PEAK_LOW && peak <= PEAK_HIGH))
        return SP_OK;
    return sp_fail_key(err, SP_EINVAL, "peak", " = %g: must be in 1e-4 .. 1e9, or inf", peak);
}

sp_status sp_solitary_make(double peak, sp_solitary *out, sp_error *err) {
    wave w = {0}, coarse = {0};
    sp_solitary rough = {0};
    sp_status status = check(peak, err);
    if (status == SP_OK)
        status = solve_peak(peak, 1, &w, err);
    if (status == SP_OK)
        status = solve_peak(peak, 0.5, &coarse, err);
    if (status == SP_OK) {
        describe(&w, peak, out);
        describe(&coarse, peak, &rough);
        out->error = 1e-14 + fabs(rough.speed_at_peak / out->speed_at_peak - 1) +
                     fabs(rough.velocity_at_peak / out->velocity_at_peak - 1) + fabs(rough.width / out->width - 1);
    }
    wave_free(&w);
    wave_free(&coarse);
    return status;
}

sp_status sp_solitary_form(double peak, int64_t n, const double *x, double *overlap, double *velocity, sp_error *err) {
    wave w = {0};
    sp_status status = check(peak, err);
    if (status == SP_OK)
        status = solve_peak(peak, 1, &w, err);
    const double largest = status == SP_OK ? velocity_at(&w, 0) : 1;
    for (int64_t k = 0; k < n && status == SP_OK; k++) {
        overlap[k] = overlap_at(&w, x[k]) / w.r[0];
        velocity[k] = velocity_at(&w, x[k]) / largest;
    }
    wave_free(&w);
    return status;
}
