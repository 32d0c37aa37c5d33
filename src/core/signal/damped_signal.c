/* Damped signals, M u'' + C u' + K u = 0, by a Faber expansion on an ellipse. The first-order form is y' = L y with y =
 * (u, v), L = (0, 1; -M^-1 K, -M^-1 C). With centre c and half axes A (real) and B (imaginary) of the ellipse, a = (A
 * + B)/2 and beta = (A - B)/(A + B),
 *   exp(t L) = sum_k S_k(t) Q_k,  Q_0 = 1, Q_1 = (L - c)/a, Q_2 = Q_1^2 - 2 beta, Q_(k+1) = Q_1 Q_k - beta Q_(k-1),
 *   S_k(t) = e^(c t) |beta|^(-k/2) times J_k or I_k of 2 a sqrt|beta| t (beta < 0 or > 0; Poisson if beta = 0).
 * The choice of the ellipse affects only the number of terms. The error is known at the end: the defect of the sum,
 *   y' - L y = a (beta S_(N+1) Q_N - S_N Q_(N+1)) y(0),
 * is computed, and since energy never grows, its integral bounds the error. */
#include "base/base.h"
#include "base/vector.h"
#include "linalg/arrays.h"
#include "numeric/random.h"
#include "signal/job.h"
#include "signal/recurrence.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* How far an ellipse may extend to the right of the imaginary axis, times the length of a substep. */
#define REACH_WIDE  3.0
#define REACH_TIGHT 6.0
/* Bound of the largest term for a random state, over e^(right h). An ellipse around the field of values of L has 1 +
 * sqrt 2 (Crouzeix and Palencia 2017). */
#define GROWTH          3.0
#define MOMENT_ROUNDING 5.0
#define PHASE_ROUNDING  5.0
#define START           1e-200 /* first value of the downward recurrence */
#define PRODUCTS_MAX    2e7

typedef struct ellipse {
    double centre, a, beta, right; /* right: real part of its rightmost point */
    double re, im;                 /* half axes */
    int64_t substeps;
} ellipse;

typedef struct damped {
    const signal_job *job;
    sp_network dashpots;
    bool has_dashpots;
    double omega, rate, until; /* rate: upper bound of the decay rates of the dashpots */
    ellipse e;
    double h;
    int64_t capacity;                      /* number of terms for which there is memory */
    double *memory;                        /* of all arrays */
    double *dashpot_rows;                  /* [detectors][dofs] contribution of the dashpots to each detector */
    double *u, *v, *u_old, *v_old;         /* [dofs] Q_k y, Q_(k-1) y */
    double *ku, *cv, *u_next, *v_next;     /* [dofs] products; y at the end of the substep */
    double *s, *power;                     /* [capacity] S_k, beta^k */
    double *moment, *size;                 /* [detectors][capacity] */
    double error_energy, error_u, *square; /* error bounds so far; [detectors] squared rounding errors */
    int64_t terms, random_terms;           /* terms so far; terms of the random state */
} damped;

/* ---- the ellipse --------------------------------------------------------------------------------------------- */

static double terms_of(const ellipse *e, double t) {
    return t * e->im + 9 * sqrt(t * e->re) + 16 * cbrt(t * e->a) + 30;
}

/* Slow modes lie near 0, overdamped modes on the negative axis, and fast modes left of +-i Omega: far left if the
 * dashpots of their contacts are not unusually weak. The tight ellipse has its top there. The wide one passes through
 * -rate, right and the corners +-i Omega, and contains all possible modes. */
static ellipse ellipse_of(const damped *d, bool tight, int64_t substeps) {
    const double h = d->until / (double)substeps, right = fmin(d->rate, (tight ? REACH_TIGHT : REACH_WIDE) / h);
    ellipse e = {.substeps = substeps, .right = right, .re = 0.5 * (d->rate + right), .im = d->omega};
    if (right > 0 && !tight)
        e.im = d->omega * (right + d->rate) / (2 * sqrt(right) * sqrt(d->rate));
    e.centre = right - e.re;
    e.a = 0.5 * (e.re + e.im);
    e.beta = (e.re - e.im) / (e.re + e.im);
    return e;
}

static double products_of(const damped *d, const ellipse *e) {
    const double n = (double)e->substeps, h = d->until / n;
    return n * (h * e->im + 6 * sqrt(h * e->re) + 6 * cbrt(h * e->a) + 15);
}

/* The ellipse with the number of substeps that needs the fewest products. */
static ellipse best_ellipse(const damped *d, bool tight) {
    ellipse best = ellipse_of(d, tight, 1);
    for (double n = 2; n < 10 + d->rate * d->until; n = ceil(1.25 * n)) {
        const ellipse e = ellipse_of(d, tight, (int64_t)n);
        if (products_of(d, &e) < products_of(d, &best))
            best = e;
    }
    return best;
}

/* S_k(t), k < capacity, by the downward recurrence S_(k-1) = k/(a t) S_k + beta S_(k+1) from negligible values;
 * normalized by sum_(k>=0) S_k + sum_(k>0) beta^k S_k = e^(right t). Returns the number of nonzero values. */
static int64_t weights(const damped *d, double t, double *s) {
    const ellipse *e = &d->e;
    const int64_t n = d->capacity;
    const double x = e->a * t;
    int64_t top = x < 0.5 ? 16 : (int64_t)terms_of(e, t);
    if (x < 1e-12)
        top = 2;
    double above = 0, here = START, sum = 0;
    memset(s, 0, (size_t)n * sizeof *s);
    if (x == 0) {
        s[0] = 1;
        return 1;
    }
    for (int64_t k = top; k > 0; k--) {
        if (k < n)
            s[k] = here;
        sum += here * (1 + d->power[k]);
        const double below = (double)k / x * here + e->beta * above;
        above = here;
        here = below;
    }
    s[0] = here;
    const double scale = exp(e->right * t) / (sum + here);
    const int64_t many = top + 1 < n ? top + 1 : n;
    for (int64_t k = 0; k < many; k++)
        s[k] *= scale;
    return many;
}

/* ---- one term ------------------------------------------------------------------------------------------------ */

/* K u and C v of Q_k y. */
static void apply(damped *d) {
    sp_network_apply(d->job->net, d->u, d->ku);
    if (d->has_dashpots)
        sp_network_apply(&d->dashpots, d->v, d->cv);
}

/* Norms of Q_k y: of u in the metric of the masses, and the root of the energy u^T K u + v^T M v. ku must be K u. */
static void norms(const damped *d, double *size, double *energy) {
    const double *mass = d->job->net->mass;
    double uu = 0, all = 0;
    for (int64_t k = 0; k < sp_network_dofs(d->job->net); k++) {
        uu += mass[k] * d->u[k] * d->u[k];
        all += d->u[k] * d->ku[k] + mass[k] * d->v[k] * d->v[k];
    }
    *size = sqrt(uu);
    *energy = all > 0 ? sqrt(all) : 0;
}

static void swap(double **a, double **b) {
    double *const old = *a;
    *a = *b;
    *b = old;
}

/* Q_(k+1) y from Q_k y and Q_(k-1) y. */
static void next_term(damped *d, int64_t k) {
    const ellipse *e = &d->e;
    const double *restrict mass = d->job->net->mass, *restrict u = d->u, *restrict v = d->v;
    double *restrict uo = d->u_old, *restrict vo = d->v_old;
    const double keep = k == 0 ? 0 : k == 1 ? 2 * e->beta : e->beta, scale = 1 / e->a;
    for (int64_t q = 0; q < sp_network_dofs(d->job->net); q++) {
        const double force = d->ku[q] + d->cv[q];
        uo[q] = scale * (v[q] - e->centre * u[q]) - keep * uo[q];
        vo[q] = scale * (-force / mass[q] - e->centre * v[q]) - keep * vo[q];
    }
    swap(&d->u, &d->u_old);
    swap(&d->v, &d->v_old);
}

static void read_moments(damped *d, int64_t k) {
    const int64_t n = sp_network_dofs(d->job->net);
    for (int32_t b = 0; b < d->job->detectors; b++) {
        const double *spring = job_detector(d->job, b), *dashpot_rows = d->dashpot_rows + b * n;
        pair_sum sum = {0};
        double size = 0;
        for (int64_t q = 0; q < n; q++) {
            const double one = spring[q] * d->u[q], two = dashpot_rows[q] * d->v[q];
            pair_add(&sum, (pair){one, two});
            size += fabs(one) + fabs(two);
        }
        d->moment[b * d->capacity + k] = pair_total(&sum)[0] + pair_total(&sum)[1];
        d->size[b * d->capacity + k] = size;
    }
}

static void add_to_end(damped *d, int64_t k) {
    for (int64_t q = 0; q < sp_network_dofs(d->job->net); q++) {
        d->u_next[q] += d->s[k] * d->u[q];
        d->v_next[q] += d->s[k] * d->v[q];
    }
}

/* Computes all terms of a substep from y = (u, v), until the integral of the defect is below `allowed`. */
static sp_status expand(damped *d, double allowed, int64_t *terms, sp_error *err) {
    const size_t bytes = (size_t)sp_network_dofs(d->job->net) * sizeof(double);
    const ellipse *e = &d->e;
    const int64_t from = (int64_t)(d->h * e->im);
    double size = 0, energy = 0, size_old, energy_old;
    memset(d->u_next, 0, bytes);
    memset(d->v_next, 0, bytes);
    for (int64_t k = 0; k + 1 < d->capacity; k++) {
        size_old = size;
        energy_old = energy;
        apply(d);
        if (k + 1 >= from || k == 0)
            norms(d, &size, &energy);
        if (k > from + 1) { /* here S_N and S_(N+1) increase with t; terms up to N = k - 1 are included */
            const double now = e->a * d->s[k - 1], then = e->a * fabs(e->beta) * d->s[k];
            const double defect = d->h * (then * energy_old + now * energy);
            if (defect <= allowed) {
                d->error_energy += defect;
                d->error_u += d->h * (then * size_old + now * size);
                *terms = k;
                return SP_OK;
            }
        }
        read_moments(d, k);
        if (e->substeps > 1)
            add_to_end(d, k);
        next_term(d, k);
    }
    return sp_fail(err, SP_EREFUSED,
                   "the expansion does not converge in %lld terms: the network is unstable (prestress)",
                   (long long)d->capacity);
}

/* ---- which ellipse ------------------------------------------------------------------------------------------- */

static void set_ellipse(damped *d, const ellipse *e) {
    d->e = *e;
    d->h = d->until / (double)e->substeps;
    d->power[0] = 1;
    for (int64_t k = 1; k < d->capacity; k++)
        d->power[k] = d->power[k - 1] * e->beta;
    weights(d, d->h, d->s);
}

/* Whether no term of the expansion of a random state exceeds its bound. Then rounding errors do not grow either, in any
 * direction. */
static bool random_state_bounded(damped *d) {
    const double *mass = d->job->net->mass;
    sp_random any = sp_random_make(1, SP_STREAM_PROBE);
    double size, energy, first = 0;
    for (int64_t q = 0; q < sp_network_dofs(d->job->net); q++) {
        d->u[q] = (2 * sp_random_uniform(&any) - 1) / (d->omega * sqrt(mass[q]));
        d->v[q] = (2 * sp_random_uniform(&any) - 1) / sqrt(mass[q]);
    }
    const int64_t terms = (int64_t)terms_of(&d->e, d->h);
    d->random_terms = terms;
    for (int64_t k = 0; k < terms; k++) {
        apply(d);
        norms(d, &size, &energy);
        first = k == 0 ? energy : first;
        if (!(d->s[k] * energy <= GROWTH * exp(d->e.right * d->h) * first))
            return false;
        next_term(d, k);
    }
    return true;
}

/* ---- one source ---------------------------------------------------------------------------------------------- */

/* F at the times within a substep. */
static void sum_points(damped *d, sp_signal *out, int32_t source, int64_t terms, double since, int32_t first,
                       int32_t last) {
    for (int32_t l = first; l < last; l++) {
        const int64_t many = weights(d, out->t[l] - since, d->s), n = many < terms ? many : terms;
        for (int32_t b = 0; b < out->detectors; b++) {
            const double *moment = d->moment + b * d->capacity, *size = d->size + b * d->capacity;
            double sum = 0, square = 0, own;
            for (int64_t k = 0; k < n; k++) {
                sum += d->s[k] * moment[k];
                own = d->s[k] * size[k];
                square += own * own * (1 + (double)(d->terms + k));
            }
            signal_pair(out, source, b)[l] = sum;
            d->square[b] = fmax(d->square[b], square);
        }
    }
}

static void start(damped *d, int32_t source) {
    const sp_network *net = d->job->net;
    const double *vector = job_source(d->job, source);
    for (int64_t k = 0; k < sp_network_dofs(net); k++) {
        d->u[k] = job_has_momenta(d->job) ? 0 : vector[k];
        d->v[k] = job_has_momenta(d->job) ? vector[k] / net->mass[k] : 0;
    }
    d->error_energy = d->error_u = 0;
    d->terms = 0;
    memset(d->square, 0, (size_t)d->job->detectors * sizeof *d->square);
}

/* Error bound of each detector: truncation, where the error of u grows with that of v, and rounding. */
static void find_errors(const damped *d, sp_signal *out, int32_t source) {
    const int64_t n = sp_network_dofs(d->job->net);
    const double *mass = d->job->net->mass, until = out->t[out->n - 1];
    for (int32_t b = 0; b < out->detectors; b++) {
        const double *spring = job_detector(d->job, b), *dashpot_rows = d->dashpot_rows + b * n,
                     *f = signal_pair(out, source, b);
        double one = 0, two = 0;
        for (int64_t k = 0; k < n; k++) {
            one += spring[k] * spring[k] / mass[k];
            two += dashpot_rows[k] * dashpot_rows[k] / mass[k];
        }
        const double largest = sp_largest(out->n, f);
        /* what a component takes from larger neighbours, with their phase; among many components this is rare */
        const bool few = n <= SIGNAL_FEW_DOFS;
        const double least = few ? (1 + 0.5 * d->omega * until) * DBL_EPSILON * sp_job_scale(d->job, source, b) : 0;
        out->errors[source * out->detectors + b] =
            least + sqrt(one) * (d->error_u + until * d->error_energy) + sqrt(two) * d->error_energy +
            DBL_EPSILON * (MOMENT_ROUNDING * sqrt(d->square[b]) +
                           (few ? 2 : 1) * PHASE_ROUNDING * (1 + d->omega * until + d->e.re * d->h) * largest);
    }
}

static sp_status follow(damped *d, sp_signal *out, int32_t source, sp_error *err) {
    const double until = out->t[out->n - 1];
    double size, energy = 0, before;
    int32_t first = 0;
    sp_status status = SP_OK;
    start(d, source);
    for (int64_t step = 0; step < d->e.substeps && status == SP_OK; step++) {
        const double since = until * (double)step / (double)d->e.substeps;
        const bool last = step == d->e.substeps - 1;
        int64_t terms = 0;
        before = energy;
        sp_network_apply(d->job->net, d->u, d->ku);
        norms(d, &size, &energy);
        if (step > 0 && !(energy <= before * (1 + 1e-9)))
            return sp_fail(err, SP_EREFUSED, "energy grows in time: the network is unstable (prestress)");
        if (step == 0)
            before = energy;
        weights(d, d->h, d->s);
        status =
            expand(d, 1e-9 * d->job->options->tolerance * before / ((1 + d->omega * until) * (double)d->e.substeps),
                   &terms, err);
        int32_t end = first;
        while (end < out->n && (last || out->t[end] < since + d->h))
            end++;
        if (status == SP_OK)
            sum_points(d, out, source, terms, since, first, end);
        first = end;
        d->terms += terms;
        swap(&d->u, &d->u_next);
        swap(&d->v, &d->v_next);
    }
    if (status == SP_OK)
        find_errors(d, out, source);
    return status;
}

/* ---- all ----------------------------------------------------------------------------------------------------- */

static sp_status allocate(damped *d, sp_error *err) {
    const size_t n = (size_t)sp_network_dofs(d->job->net), capacity = (size_t)d->capacity,
                 detectors = (size_t)d->job->detectors;
    const sp_array arrays[] = {{&d->u, n},
                               {&d->v, n},
                               {&d->u_old, n},
                               {&d->v_old, n},
                               {&d->ku, n},
                               {&d->cv, n},
                               {&d->u_next, n},
                               {&d->v_next, n},
                               {&d->dashpot_rows, detectors * n},
                               {&d->s, capacity},
                               {&d->power, capacity},
                               {&d->moment, detectors * capacity},
                               {&d->size, detectors * capacity},
                               {&d->square, detectors},
                               {0}};
    return sp_arrays_make(arrays, &d->memory, err);
}

/* Detector vectors of the dashpots: the rows of the springs with c in place of k. */
static sp_status find_dashpot_rows(damped *d, sp_error *err) {
    const sp_place wall = sp_place_wall(), *to = d->job->options->to;
    sp_status status = SP_OK;
    for (int32_t b = 0; b < d->job->detectors && status == SP_OK && d->has_dashpots; b++)
        status = sp_network_detector_at(&d->dashpots, to ? &to[b] : &wall,
                                        d->dashpot_rows + b * sp_network_dofs(d->job->net), err);
    return status;
}

/* Chooses the ellipse and allocates memory. */
static sp_status prepare(damped *d, sp_error *err) {
    const ellipse wide = best_ellipse(d, false), tight = best_ellipse(d, true);
    const double h_wide = d->until / (double)wide.substeps, h_tight = d->until / (double)tight.substeps;
    const double products = products_of(d, &wide) * d->job->sources * (1 + d->has_dashpots);
    if (!(products <= PRODUCTS_MAX))
        return sp_fail(err, SP_EREFUSED, "until = %g needs up to %.3g matrix products, must be at most %g", d->until,
                       products, PRODUCTS_MAX);
    d->capacity = (int64_t)fmax(terms_of(&wide, h_wide), terms_of(&tight, h_tight)) + 40;
    sp_status status = allocate(d, err);
    if (status == SP_OK)
        status = find_dashpot_rows(d, err);
    if (status != SP_OK)
        return status;
    set_ellipse(d, &tight);
    const double probe = 1.0 / ((double)tight.substeps * d->job->sources);
    if (!(products_of(d, &tight) * (1 + probe) < products_of(d, &wide)) || !random_state_bounded(d))
        set_ellipse(d, &wide);
    return SP_OK;
}

sp_status sp_signal_by_faber(const signal_job *job, sp_signal *s, sp_error *err) {
    const sp_damping law = sp_signal_damping(job->options);
    damped d = {.job = job,
                .dashpots = sp_network_none(),
                .has_dashpots = law.value > 0,
                .omega = sp_network_omega_bound(job->net),
                .until = job->options->until};
    sp_status status = d.has_dashpots ? sp_network_dashpots(job->net, &law, &d.dashpots, err) : SP_OK;
    if (status == SP_OK && d.has_dashpots)
        d.rate = sp_network_omega_bound(&d.dashpots) * sp_network_omega_bound(&d.dashpots);
    if (status == SP_OK)
        status = prepare(&d, err);
    int64_t terms = d.random_terms;
    for (int32_t a = 0; a < job->sources && status == SP_OK; a++) {
        status = follow(&d, s, a, err);
        terms += d.terms;
    }
    s->products = (int32_t)(terms * (1 + d.has_dashpots));
    sp_free(d.memory);
    sp_network_free(&d.dashpots);
    return status;
}
