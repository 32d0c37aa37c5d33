/* Fits two waves to equally spaced planes, f(y) = A exp(-q y) + B exp(q y), q = alpha + i k: least squares in A, B and
 * q by variable projection (Golub and Pereyra 1973). */
#include "spectrum/driven.h"

#include <complex.h>
#include <math.h>
#include <sonopack/spectrum.h>
#undef I

typedef double complex value;

typedef struct sample {
    int32_t n;
    const double *y;
    const double *f; /* [n][2] */
} sample;

/* Best A and B for a given q, and the sum of squares left. Each wave is 1 where it is largest. */
typedef struct amplitudes {
    value a, b;
    double rest;
    double overlap; /* 1: both waves are equal */
} amplitudes;

/* C11's CMPLX, which not every compiler has. */
static value number(double re, double im) { return re + im * _Complex_I; }

static value at(const sample *s, int32_t j) { return number(s->f[2 * j], s->f[2 * j + 1]); }

static value wave_up(const sample *s, value q, int32_t j) { return cexp(-q * (s->y[j] - s->y[0])); }

static value wave_down(const sample *s, value q, int32_t j) { return cexp(q * (s->y[j] - s->y[s->n - 1])); }

static double square(value z) { return creal(z) * creal(z) + cimag(z) * cimag(z); }

/* Both waves, plane by plane. */
typedef struct pair_of_waves {
    value up, down, up_step, down_step;
} pair_of_waves;

static pair_of_waves first_plane(const sample *s, value q) {
    const double step = s->y[1] - s->y[0];
    return (pair_of_waves){1, cexp(-q * (s->y[s->n - 1] - s->y[0])), cexp(-q * step), cexp(q * step)};
}

static void next_plane(pair_of_waves *w) {
    w->up *= w->up_step;
    w->down *= w->down_step;
}

static amplitudes project(const sample *s, value q) {
    double uu = 0, dd = 0, all = 0;
    value ud = 0, uf = 0, df = 0;
    pair_of_waves w = first_plane(s, q);
    for (int32_t j = 0; j < s->n; j++, next_plane(&w)) {
        const value f = at(s, j);
        uu += square(w.up);
        dd += square(w.down);
        ud += conj(w.up) * w.down;
        uf += conj(w.up) * f;
        df += conj(w.down) * f;
        all += square(f);
    }
    amplitudes p = {.rest = all, .overlap = square(ud) / (uu * dd)};
    const double det = uu * dd * (1 - p.overlap);
    if (!(p.overlap < 1 - 1e-9))
        return p;
    p.a = (dd * uf - ud * df) / det;
    p.b = (uu * df - conj(ud) * uf) / det;
    p.rest = 0;
    w = first_plane(s, q);
    for (int32_t j = 0; j < s->n; j++, next_plane(&w))
        p.rest += square(at(s, j) - p.a * w.up - p.b * w.down);
    return p;
}

/* A Gauss-Newton step: the derivative by q, minus its projection on the two waves. *slope: its squared norm. */
static value newton(const sample *s, value q, const amplitudes *p, double *slope) {
    double uu = 0, dd = 0;
    value ud = 0, ug = 0, dg = 0, gr = 0;
    const double first = s->y[0], last = s->y[s->n - 1];
    for (int32_t j = 0; j < s->n; j++) {
        const value u = wave_up(s, q, j), d = wave_down(s, q, j);
        const value g = -(s->y[j] - first) * p->a * u + (s->y[j] - last) * p->b * d;
        uu += square(u);
        dd += square(d);
        ud += conj(u) * d;
        ug += conj(u) * g;
        dg += conj(d) * g;
    }
    const double det = uu * dd * (1 - p->overlap);
    const value a = (dd * ug - ud * dg) / det, b = (uu * dg - conj(ud) * ug) / det;
    *slope = 0;
    for (int32_t j = 0; j < s->n; j++) {
        const value u = wave_up(s, q, j), d = wave_down(s, q, j);
        const value g = -(s->y[j] - first) * p->a * u + (s->y[j] - last) * p->b * d - a * u - b * d;
        *slope += square(g);
        gr += conj(g) * (at(s, j) - p->a * u - p->b * d);
    }
    return *slope > 0 ? gr / *slope : 0;
}

/* The best point of a grid of wave numbers and attenuations. */
static value search(const sample *s) {
    enum { WAVES = 240, ATTENUATIONS = 9 };
    const double step = s->y[1] - s->y[0], length = s->y[s->n - 1] - s->y[0];
    double least = HUGE_VAL;
    value best = 0;
    for (int w = 0; w < WAVES; w++)
        for (int l = 0; l < ATTENUATIONS; l++) {
            const double alpha = l == 0 ? 0 : 0.25 * pow(2, l - 1) / length;
            const value q = number(alpha, M_PI * (w + 0.5) / (WAVES * step));
            const amplitudes p = project(s, q);
            if (p.rest < least) {
                least = p.rest;
                best = q;
            }
        }
    return best;
}

void sp_driven_fit(int32_t n, const double *y, const double *f, sp_wave_fit *out) {
    enum { STEPS = 60 };
    const sample s = {n, y, f};
    *out = (sp_wave_fit){NAN, NAN, NAN, NAN, NAN};
    double all = 0, slope = 0;
    for (int32_t j = 0; j < n; j++)
        all += square(at(&s, j));
    if (n < 5 || !(all > 0) || !isfinite(all))
        return;
    value q = search(&s);
    amplitudes p = project(&s, q);
    for (int k = 0; k < STEPS; k++) {
        value step = newton(&s, q, &p, &slope);
        amplitudes next = project(&s, q + step);
        for (int half = 0; half < 20 && !(next.rest <= p.rest); half++) {
            step *= 0.5;
            next = project(&s, q + step);
        }
        if (!(next.rest <= p.rest))
            break;
        q += step;
        p = next;
        if (cabs(step) < 1e-14 * cabs(q))
            break;
    }
    newton(&s, q, &p, &slope);
    const double error = slope > 0 && n > 3 ? sqrt(0.5 * p.rest / (n - 3) / slope) : NAN;
    const bool decays = fabs(creal(q)) > 3 * error;
    if (decays ? creal(q) < 0 : cimag(q) < 0) /* the same two waves with exchanged roles */
        q = -q;
    const double period = 2 * M_PI / (y[1] - y[0]); /* planes see k and k + period alike */
    *out = (sp_wave_fit){.k = cimag(q) > period ? fmod(cimag(q), period) : cimag(q),
                         .k_err = error,
                         .alpha = creal(q),
                         .alpha_err = error,
                         .misfit = p.rest / all};
}

void sp_wave_quality(double k, double k_err, double alpha, double alpha_err, double *q, double *q_err) {
    *q = *q_err = NAN;
    if (!(alpha > 0) || alpha <= 3 * alpha_err || !isfinite(k))
        return;
    *q = fabs(k) / (2 * alpha);
    *q_err = hypot(0.5 * k_err / alpha, *q * alpha_err / alpha);
}
