/* Response to harmonic driving, one sparse solve per frequency, at a detector and through planes, with the fit of two
 * waves f(y) = A exp(-q y) + B exp(q y), q = alpha + i k, to the planes: least squares in A, B and q by variable
 * projection (Golub and Pereyra 1973). */
#include "base/base.h"
#include "linalg/arrays.h"
#include "network/network_cell.h"
#include "spectrum/driven.h"

#include <complex.h>
#include <math.h>
#include <sonopack/spectrum.h>
#include <stdio.h>

/* ---- waves ------------------------------------------------------------------------------------------------------- */

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

/* f [n][2] at heights y, ascending and equally spaced. */
static void fit_waves(int32_t n, const double *y, const double *f, sp_wave_fit *out) {
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

/* ---- driving ----------------------------------------------------------------------------------------------------- */

enum { FREQUENCIES_MAX = 1000000, PLANES_MAX = 100000 };

sp_harmonic_options sp_harmonic_options_default(void) {
    return (sp_harmonic_options){.source = SP_SOURCE_IMPULSE,
                                 .from = sp_place_wall(),
                                 .to = sp_place_wall(),
                                 .tolerance = 1e-8,
                                 .damping_ratio = 1};
}

sp_harmonic sp_harmonic_none(void) { return (sp_harmonic){0}; }

void sp_harmonic_free(sp_harmonic *h) {
    sp_free(h->omega); /* one block with the other arrays of doubles */
    sp_free(h->fit);
    *h = sp_harmonic_none();
}

static sp_status check(const sp_network *net, const sp_harmonic_options *o, sp_error *err) {
    const double height = net->box[net->dim - 1];
    if (!(o->damping >= 0 && isfinite(o->damping)))
        return sp_fail(err, SP_EINVAL, "damping = %g, must be %s, 0 or more", o->damping,
                       o->damping_kind == SP_DAMPING_ZETA ? "a fraction of critical damping" : "a coefficient");
    if (o->source != SP_SOURCE_IMPULSE && o->source != SP_SOURCE_VELOCITY)
        return sp_fail(err, SP_EINVAL, "harmonic driving by a source of displacements, must be impulse or velocity");
    if (o->n < 1 || o->n > FREQUENCIES_MAX || !o->omega)
        return sp_fail(err, SP_EINVAL, "%d frequencies, must be 1 .. %d", o->n, FREQUENCIES_MAX);
    for (int32_t l = 0; l < o->n; l++)
        if (!(o->omega[l] > 0 && isfinite(o->omega[l])))
            return sp_fail(err, SP_EINVAL, "omega = %g, must be above 0", o->omega[l]);
    if (o->planes < 0 || o->planes > PLANES_MAX)
        return sp_fail(err, SP_EINVAL, "planes = %d, must be 0 (one a diameter) .. %d", o->planes, PLANES_MAX);
    if (!(o->range[0] >= 0 && o->range[0] <= o->range[1] && o->range[1] <= height))
        return sp_fail(err, SP_EINVAL, "range = %g .. %g, must be heights in 0 .. %.6g", o->range[0], o->range[1],
                       height);
    if (!(o->tolerance > 0 && o->tolerance < 1))
        return sp_fail(err, SP_EINVAL, "tolerance = %g, must be above 0 and below 1", o->tolerance);
    return SP_OK;
}

/* Data for solving one frequency after another. */
typedef struct harmonic_solver {
    const sp_network *net;
    const sp_harmonic_options *options;
    driven d;
    double *source;                     /* [dofs][2], over sqrt(m) */
    double *spring_rows, *dashpot_rows; /* [1 + planes][dofs] forces on detector and planes, over sqrt(m) */
    double *detector;        /* [SP_DRIVEN_MOST][dofs][2] some at one frequency: springs + i omega dashpots */
    double *u, *y;           /* [dofs][2], [SP_DRIVEN_MOST][dofs][2] */
    double *u_rest, *y_rest; /* [dofs] each */
    double *memory;          /* of these arrays */
    double low, high;        /* heights of the planes in the fit */
} harmonic_solver;

static sp_status allocate(const sp_network *net, const sp_harmonic_options *o, harmonic_solver *b, sp_harmonic *h,
                          sp_error *err) {
    const double height = net->box[net->dim - 1];
    const size_t dofs = (size_t)sp_network_dofs(net), n = (size_t)o->n;
    h->n = o->n;
    h->planes = o->planes > 0 ? o->planes : (int32_t)fmin(PLANES_MAX, fmax(1, round(height) - 1));
    const size_t planes = (size_t)h->planes;
    h->fit = sp_alloc(n, sizeof *h->fit);
    if (!h->fit)
        return sp_fail_memory(err, n * sizeof *h->fit);
    const sp_array response[] = {{&h->omega, n},
                                 {&h->f, 2 * n},
                                 {&h->error, n},
                                 {&h->height, planes},
                                 {&h->flux, 2 * n * planes},
                                 {&h->flux_error, n * planes},
                                 {0}};
    const sp_array arrays[] = {{&b->source, 2 * dofs},
                               {&b->spring_rows, dofs * (1 + planes)},
                               {&b->dashpot_rows, dofs * (1 + planes)},
                               {&b->detector, 2 * dofs * SP_DRIVEN_MOST},
                               {&b->u, 2 * dofs},
                               {&b->y, 2 * dofs * SP_DRIVEN_MOST},
                               {&b->u_rest, dofs},
                               {&b->y_rest, dofs * SP_DRIVEN_MOST},
                               {0}};
    double *block;
    sp_status status = sp_arrays_make(response, &block, err);
    if (status == SP_OK)
        status = sp_arrays_make(arrays, &b->memory, err);
    if (status != SP_OK)
        return status;
    for (size_t l = 0; l < n; l++)
        h->omega[l] = o->omega[l];
    for (size_t k = 0; k < planes; k++)
        h->height[k] = height * (double)(k + 1) / (double)(planes + 1);
    const bool given = o->range[1] > 0;
    b->low = given ? o->range[0] : fmin(2, height);
    b->high = given ? o->range[1] : height - fmin(2, height);
    return SP_OK;
}

/* Detector and planes, of a network of springs or of dashpots. */
static sp_status make_detectors(const harmonic_solver *b, const sp_network *net, const sp_harmonic *h, double *out,
                                sp_error *err) {
    const int64_t dofs = sp_network_dofs(net);
    sp_status status = sp_network_detector_at(net, &b->options->to, out, err);
    for (int32_t k = 0; k < h->planes && status == SP_OK; k++) {
        const sp_place plane = {.kind = SP_PLACE_PLANE, .shear = b->options->to.shear, .height = h->height[k]};
        status = sp_network_detector_at(net, &plane, out + (1 + k) * dofs, err);
    }
    return status;
}

static sp_status make_solver(const sp_network *net, const sp_harmonic_options *o, harmonic_solver *b, sp_harmonic *h,
                             sp_error *err) {
    sp_network dashpots = sp_network_none();
    const sp_damping law = {.kind = o->damping_kind, .value = o->damping, .ratio = o->damping_ratio};
    const int64_t dofs = sp_network_dofs(net);
    b->net = net;
    b->options = o;
    sp_status status = allocate(net, o, b, h, err);
    if (status == SP_OK)
        status = sp_network_source_at(net, o->source, &o->from, b->detector, err);
    for (int64_t k = 0; k < dofs && status == SP_OK; k++)
        b->source[2 * k] = b->detector[k];
    if (status == SP_OK)
        status = make_detectors(b, net, h, b->spring_rows, err);
    if (status == SP_OK && o->damping > 0)
        status = sp_network_dashpots(net, &law, &dashpots, err);
    if (status == SP_OK && o->damping > 0)
        status = make_detectors(b, &dashpots, h, b->dashpot_rows, err);
    if (status == SP_OK)
        status = sp_driven_make(net, o->damping > 0 ? &dashpots : NULL, &b->d, err);
    for (int64_t k = 0; k < dofs && status == SP_OK; k++) {
        b->source[2 * k] /= b->d.root[k];
        for (int32_t q = 0; q <= h->planes; q++) {
            b->spring_rows[q * dofs + k] /= b->d.root[k];
            b->dashpot_rows[q * dofs + k] /= b->d.root[k];
        }
    }
    sp_network_free(&dashpots);
    return status;
}

/* Fits the planes in the range, which are contiguous. */
static void fit_wave(const harmonic_solver *b, int32_t l, sp_harmonic *h) {
    int32_t first = 0, last = h->planes;
    while (first < last && h->height[first] < b->low)
        first++;
    while (last > first && h->height[last - 1] > b->high)
        last--;
    fit_waves(last - first, h->height + first, h->flux + 2 * ((int64_t)l * h->planes + first), &h->fit[l]);
}

/* A decaying wave may be arbitrarily small at the detector. There the error is compared with 1e-6 of the largest force
 * at a plane. */
static sp_status check_errors(const harmonic_solver *b, int32_t l, const sp_harmonic *h, sp_error *err) {
    double most = 0, error = 0;
    for (int32_t k = 0; k < h->planes; k++) {
        const double *f = h->flux + 2 * ((int64_t)l * h->planes + k);
        most = fmax(most, hypot(f[0], f[1]));
        error = fmax(error, h->flux_error[(int64_t)l * h->planes + k]);
    }
    const double own = hypot(h->f[2 * l], h->f[2 * l + 1]), tolerance = b->options->tolerance;
    if (!(h->error[l] <= tolerance * fmax(own, 1e-6 * most)))
        return sp_fail(err, SP_EREFUSED,
                       "omega = %.10g: |F| = %.3g with an error of up to %.3g, must be at most %.2g of |F|%s",
                       h->omega[l], own, h->error[l], tolerance,
                       b->options->damping > 0 ? "" : " (a frequency of the undamped network is near)");
    if (!(error <= tolerance * most))
        return sp_fail(err, SP_EREFUSED, "omega = %.10g: error bound %.3g of forces up to %.3g, must be at most %.2g",
                       h->omega[l], error, most, tolerance);
    return SP_OK;
}

/* The forces at `many` places from number `first` on: the detector is number 0, then come the planes. */
static sp_status some_places(harmonic_solver *b, int32_t l, int32_t first, int many, sp_harmonic *h, sp_error *err) {
    const int64_t dofs = sp_network_dofs(b->net);
    const driven_solution source = {b->source, b->u, b->u_rest};
    for (int q = 0; q < many; q++)
        for (int64_t k = 0; k < dofs; k++) {
            b->detector[2 * (q * dofs + k)] = b->spring_rows[(first + q) * dofs + k];
            b->detector[2 * (q * dofs + k) + 1] = h->omega[l] * b->dashpot_rows[(first + q) * dofs + k];
        }
    const sp_status status = sp_driven_solve(&b->d, many, b->detector, b->y, b->y_rest, err);
    for (int q = 0; q < many && status == SP_OK; q++) {
        const int64_t at = (int64_t)l * h->planes + first + q - 1;
        const driven_solution detector = {b->detector + 2 * q * dofs, b->y + 2 * q * dofs, b->y_rest + q * dofs};
        sp_driven_response(&b->d, &source, &detector, first + q == 0 ? h->f + 2 * l : h->flux + 2 * at,
                           first + q == 0 ? h->error + l : h->flux_error + at);
    }
    return status;
}

static sp_status one_frequency(harmonic_solver *b, int32_t l, sp_harmonic *h, sp_error *err) {
    const int32_t places = 1 + h->planes;
    sp_status status = sp_driven_factor(&b->d, h->omega[l], err);
    if (status == SP_OK)
        status = sp_driven_solve(&b->d, 1, b->source, b->u, b->u_rest, err);
    for (int32_t q = 0; q < places && status == SP_OK; q += SP_DRIVEN_MOST)
        status = some_places(b, l, q, places - q < SP_DRIVEN_MOST ? places - q : SP_DRIVEN_MOST, h, err);
    if (status != SP_OK) {
        sp_fail_prefix(err, "omega = %.10g", h->omega[l]);
        return status;
    }
    fit_wave(b, l, h);
    return check_errors(b, l, h, err);
}

static void forget(int32_t l, const sp_error *why, sp_harmonic *h) {
    const sp_wave_fit none = {NAN, NAN, NAN, NAN, NAN};
    if (h->refused++ == 0)
        snprintf(h->reason, sizeof h->reason, "%.255s", why->text);
    h->f[2 * l] = h->f[2 * l + 1] = h->error[l] = NAN;
    h->fit[l] = none;
    for (int64_t k = (int64_t)l * h->planes; k < (int64_t)(l + 1) * h->planes; k++)
        h->flux[2 * k] = h->flux[2 * k + 1] = h->flux_error[k] = NAN;
}

/* One frequency; one that is refused may be kept without results. */
static sp_status try_frequency(harmonic_solver *b, int32_t l, sp_harmonic *h, sp_error *err) {
    sp_error why = {0};
    const sp_status status = one_frequency(b, l, h, &why);
    if (status == SP_EREFUSED && b->options->keep) {
        forget(l, &why, h);
        return SP_OK;
    }
    if (status != SP_OK && err)
        *err = why;
    return status;
}

sp_status sp_harmonic_make(const sp_network *net, const sp_harmonic_options *opt, sp_harmonic *out, sp_error *err) {
    sp_harmonic h = sp_harmonic_none();
    harmonic_solver b = {0};
    sp_status status = check(net, opt, err);
    if (status == SP_OK)
        status = sp_network_need_walls(net, "harmonic driving", err);
    if (status == SP_OK)
        status = sp_network_need_symmetry(net, "harmonic driving", err);
    if (status != SP_OK)
        return status;
    status = make_solver(net, opt, &b, &h, err);
    for (int32_t l = 0; l < opt->n && status == SP_OK; l++)
        status = try_frequency(&b, l, &h, err);
    if (status == SP_OK && h.refused == h.n)
        status = sp_fail(err, SP_EREFUSED, "%s", h.reason);
    sp_driven_free(&b.d);
    sp_free(b.memory);
    if (status == SP_OK)
        *out = h;
    else
        sp_harmonic_free(&h);
    return status;
}
