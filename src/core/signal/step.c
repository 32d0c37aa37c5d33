/* Signals by time stepping of M u'' = -K u with two explicit symplectic schemes: velocity Verlet, and the leapfrog
 * scheme of the potential u^T (A - h^2/12 A^2) u/2, A = M^-1 K, of fourth order with two products per step (Lax and
 * Wendroff 1960; Dablain, Geophysics 51, 54, 1986). Both act on a mode as rotations: u after n steps of h is gamma
 * sin(n theta)/omega or cos(n theta), and with x = (h omega)^2
 *   Verlet:  cos theta = 1 - x/2,           gamma = 1/sqrt(1 - x/4)
 *   fourth:  cos theta = 1 - x/2 + x^2/24,  gamma = sqrt(x) (1 - x/6)/sin theta
 * The errors are thus a shift of frequency, theta/h - omega, and of amplitude, gamma - 1. Powers of omega bound both
 * (docs/physics.md), so moments of source and detector bound the error of the signal. */
#include "base/base.h"
#include "base/vector.h"
#include "linalg/arrays.h"
#include "signal/job.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

enum { MOMENTS = 4, ATTEMPTS = 4 };
/* Limit of springs times products for a step chosen from the tolerance: about half a minute. */
#define WORK_MAX 5e9
#define ROUNDING 8.0

typedef struct scheme {
    bool fourth;
    int order, products; /* products per step */
    double reach;        /* largest h Omega for which the bounds hold; the schemes are stable up to 2 and sqrt(12) */
} scheme;

/* Norms |A^(j/2) x|, j = 0 .. 3, of a source or detector x in the metric of the masses. */
typedef struct moments {
    double m[MOMENTS];
} moments;

typedef struct stepping {
    const signal_job *job;
    scheme method;
    double omega, last, spacing;
    bool from_sources;                          /* start from each source; false: from each detector, by reciprocity */
    int32_t starts, ends;                       /* number of starts, and of places where each is recorded */
    moments *source_moments, *detector_moments; /* [sources], [detectors] */
    double *u, *v, *du, *dv;   /* [dofs] displacement, its change per step, and the compensation of both sums */
    double *force, *row, *aux; /* [dofs] */
    double *memory;            /* of these arrays */
} stepping;

static void stepping_free(stepping *s) {
    sp_free(s->memory);
    sp_free(s->source_moments);
    sp_free(s->detector_moments);
}

static double norm(const sp_network *net, const double *x) {
    double sum = 0;
    for (int64_t k = 0; k < sp_network_dofs(net); k++)
        sum += net->mass[k] * x[k] * x[k];
    return sqrt(sum);
}

/* out = A x */
static void accelerate(const sp_network *net, const double *x, double *out) {
    sp_network_apply(net, x, out);
    for (int64_t k = 0; k < sp_network_dofs(net); k++)
        out[k] /= net->mass[k];
}

/* Displacement for a source, or for a detector over the masses. */
static void as_displacement(const signal_job *job, bool source, const double *given, double *x) {
    const bool as_is = source && !job_has_momenta(job);
    for (int64_t k = 0; k < sp_network_dofs(job->net); k++)
        x[k] = as_is ? given[k] : given[k] / job->net->mass[k];
}

/* Row that reads the response at a place from a displacement. */
static void as_row(const signal_job *job, bool source, const double *given, double *row) {
    const bool weigh = source && !job_has_momenta(job);
    for (int64_t k = 0; k < sp_network_dofs(job->net); k++)
        row[k] = weigh ? given[k] * job->net->mass[k] : given[k];
}

static sp_status find_moments(stepping *s, bool source, const double *given, moments *out, sp_error *err) {
    const sp_network *net = s->job->net;
    as_displacement(s->job, source, given, s->u);
    accelerate(net, s->u, s->force);
    const double one = sp_network_energy2(net, s->u), three = sp_network_energy2(net, s->force);
    if (!(one >= 0 && three >= 0))
        return sp_fail(err, SP_EREFUSED, "u^T K u = %g, must not be negative: the network is unstable (prestress)",
                       fmin(one, three));
    *out = (moments){{norm(net, s->u), sqrt(one), norm(net, s->force), sqrt(three)}};
    return SP_OK;
}

static sp_status stepping_make(const signal_job *job, scheme method, const sp_signal *out, stepping *s, sp_error *err) {
    const size_t n = (size_t)sp_network_dofs(job->net);
    *s = (stepping){.job = job,
                    .method = method,
                    .omega = sp_network_omega_bound(job->net),
                    .last = job->options->until,
                    .spacing = job->options->until / (out->n - 1),
                    .from_sources = job->sources <= job->detectors};
    s->starts = s->from_sources ? job->sources : job->detectors;
    s->ends = s->from_sources ? job->detectors : job->sources;
    s->source_moments = sp_alloc((size_t)job->sources, sizeof *s->source_moments);
    s->detector_moments = sp_alloc((size_t)job->detectors, sizeof *s->detector_moments);
    if (!s->source_moments || !s->detector_moments)
        return sp_fail_memory(err, (size_t)(job->sources + job->detectors) * sizeof *s->source_moments);
    const sp_array arrays[] = {{&s->u, n},     {&s->v, n},   {&s->du, n},  {&s->dv, n},
                               {&s->force, n}, {&s->row, n}, {&s->aux, n}, {0}};
    sp_status status = sp_arrays_make(arrays, &s->memory, err);
    for (int32_t k = 0; k < job->sources && status == SP_OK; k++)
        status = find_moments(s, true, job_source(job, k), &s->source_moments[k], err);
    for (int32_t k = 0; k < job->detectors && status == SP_OK; k++)
        status = find_moments(s, false, job_detector(job, k), &s->detector_moments[k], err);
    return status;
}

/* The best bound of |b^T A^(power/2) a| by Cauchy-Schwarz. */
static double split(const moments *a, const moments *b, int power) {
    double least = INFINITY;
    for (int j = 0; j < MOMENTS; j++)
        if (power - j >= 0 && power - j < MOMENTS)
            least = fmin(least, a->m[j] * b->m[power - j]);
    return least;
}

/* Upper bound of the error of the scheme at the last time. */
static double scheme_error(const stepping *s, const moments *a, const moments *b, double h) {
    const double x = h * h * s->omega * s->omega;
    const bool moves = job_has_momenta(s->job);
    if (!s->method.fourth) { /* asin y - y <= y^3/6 (1 - y^2)^(-3/2), y = sqrt(x)/2 */
        const double w = 1 - 0.25 * x, steep = 1 / (w * sqrt(w));
        const double phase = s->last * h * h / 24 * steep;
        return moves ? phase / sqrt(w) * split(a, b, 2) + h * h / 8 * steep * split(a, b, 1) : phase * split(a, b, 3);
    }
    /* cos theta - cos sqrt(x) is at most x^3/720; the sine between the two angles is at least the smaller of theirs */
    const double sine2 = (1 - x / 12) * (1 - x / 4 + x * x / 48), root = sqrt(x);
    const double least = fmin(sqrt(sine2), root > 1e-3 ? sin(root) / root : 1 - x / 6), h4 = h * h * h * h;
    const double phase = s->last * h4 / (720 * least);
    return moves ? phase * split(a, b, 4) + h4 / (72 * sine2) * split(a, b, 3) : phase * split(a, b, 5);
}

/* Rounding. Sums of steps are compensated. Each force is rounded to some DBL_EPSILON of h^2 Omega^2 u, and this error
 * propagates with the following steps. */
static double rounding(const stepping *s, double steps, double h, double largest, double reach) {
    const double x = h * h * s->omega * s->omega;
    return ROUNDING * DBL_EPSILON * largest * reach * (1 + s->omega * s->last + x * steps * sqrt(steps));
}

/* Compensated summation (Kahan): sum += x. */
static inline void add(double *sum, double *lost, double x) {
    const double y = x - *lost, t = *sum + y;
    *lost = (t - *sum) - y;
    *sum = t;
}

/* dv += factor A' u, A' = A or A - h^2/12 A^2. */
static void kick(stepping *s, double h, double factor) {
    const sp_network *net = s->job->net;
    const double second = s->method.fourth ? h * h / 12 : 0;
    accelerate(net, s->u, s->force);
    if (s->method.fourth)
        accelerate(net, s->force, s->aux);
    for (int64_t k = 0; k < sp_network_dofs(net); k++)
        add(&s->v[k], &s->dv[k], factor * (s->force[k] - second * s->aux[k]));
}

static void drift(stepping *s) {
    for (int64_t k = 0; k < sp_network_dofs(s->job->net); k++)
        add(&s->u[k], &s->du[k], s->v[k] - s->dv[k]);
}

/* Initial u and its first change: h v, in fourth order minus h^3/6 A v; or cos(theta) u - u. */
static void start(stepping *s, int32_t which, double h) {
    const signal_job *job = s->job;
    const int64_t n = sp_network_dofs(job->net);
    as_displacement(job, s->from_sources, s->from_sources ? job_source(job, which) : job_detector(job, which), s->u);
    for (int64_t k = 0; k < n; k++)
        s->v[k] = s->du[k] = s->dv[k] = 0;
    if (!job_has_momenta(job)) {
        kick(s, h, -0.5 * h * h);
        return;
    }
    accelerate(job->net, s->u, s->force);
    for (int64_t k = 0; k < n; k++) {
        s->v[k] = h * s->u[k] - (s->method.fourth ? h * h * h / 6 * s->force[k] : 0);
        s->u[k] = 0;
    }
}

/* Follows one start, recording every `substeps` steps. Returns the largest |u|, infinite if it grows without bound. */
static double run_start(stepping *s, sp_signal *out, int32_t which, int64_t substeps, double h) {
    const sp_network *net = s->job->net;
    const int64_t n = sp_network_dofs(net);
    const moments *m = s->from_sources ? &s->source_moments[which] : &s->detector_moments[which];
    double largest = 0;
    start(s, which, h);
    for (int32_t l = 0; l < out->n; l++) {
        for (int64_t k = 0; k < (l > 0 ? substeps : 0); k++) {
            drift(s);
            kick(s, h, -h * h);
        }
        for (int32_t e = 0; e < s->ends; e++) {
            as_row(s->job, !s->from_sources, s->from_sources ? job_detector(s->job, e) : job_source(s->job, e), s->row);
            double sum = 0;
            for (int64_t k = 0; k < n; k++)
                sum += s->row[k] * s->u[k];
            signal_pair(out, s->from_sources ? which : e, s->from_sources ? e : which)[l] = sum;
        }
        const double size = norm(net, s->u), bound = m->m[0] * (job_has_momenta(s->job) ? out->t[l] : 1);
        largest = fmax(largest, size);
        if (!(size <= 2.0001 * bound)) /* gamma is below 2 in the allowed range */
            return INFINITY;
    }
    return largest;
}

static sp_status run(stepping *s, sp_signal *out, int64_t substeps, sp_error *err) {
    const double h = s->spacing / (double)substeps, steps = (double)substeps * (out->n - 1);
    for (int32_t k = 0; k < s->starts; k++) {
        const double largest = run_start(s, out, k, substeps, h);
        if (!isfinite(largest))
            return sp_fail(err, SP_EREFUSED, "the motion grows without bound: the network is unstable (prestress)");
        for (int32_t e = 0; e < s->ends; e++) {
            const int32_t a = s->from_sources ? k : e, b = s->from_sources ? e : k;
            const double reach = s->from_sources ? s->detector_moments[b].m[0] : s->source_moments[a].m[0];
            out->errors[a * out->detectors + b] = scheme_error(s, &s->source_moments[a], &s->detector_moments[b], h) +
                                                  rounding(s, steps, h, largest, reach);
        }
    }
    out->step = h;
    out->products = (int32_t)(steps * s->method.products) * s->starts;
    return SP_OK;
}

/* Smallest ratio of allowed error to that of the scheme. Rounding uses part of the allowed error, but at most 0.9 of
 * it, since shorter steps do not reduce it. */
static double allowed_ratio(const stepping *s, const sp_signal *out) {
    double least = INFINITY;
    for (int32_t a = 0; a < out->sources; a++)
        for (int32_t b = 0; b < out->detectors; b++) {
            const double *f = signal_pair(out, a, b),
                         error = scheme_error(s, &s->source_moments[a], &s->detector_moments[b], out->step);
            const double largest = fmax(1e-6 * sp_job_scale(s->job, a, b), sp_largest(out->n, f));
            const double allowed = s->job->options->tolerance * largest,
                         rounded = fmin(fmax(0, out->errors[a * out->detectors + b] - error), 0.9 * allowed);
            least = fmin(least, (allowed - rounded) / error);
        }
    return least;
}

static double work(const stepping *s, const sp_signal *out, double substeps) {
    return substeps * (out->n - 1) * s->starts * s->method.products * s->job->net->n_springs;
}

static sp_status refuse_work(const stepping *s, const sp_signal *out, double substeps, sp_error *err) {
    const double most = WORK_MAX / work(s, out, 1),
                 within = s->job->options->tolerance * pow(substeps / most, s->method.order);
    char reach[80] = "which are too few for any tolerance";
    if (within < 0.1)
        snprintf(reach, sizeof reach, "for a tolerance of about %.1g", within);
    return sp_fail(err, SP_EREFUSED,
                   "tolerance %.2g needs %.3g steps of %.3g, at most %.3g unless a step is given, %s; method chebyshev "
                   "needs no steps",
                   s->job->options->tolerance, substeps * (out->n - 1), s->spacing / substeps, most * (out->n - 1),
                   reach);
}

/* A coarse run gives the size of the signal, from which the step is chosen; repeated if that was misleading. */
static sp_status find_step(stepping *s, sp_signal *out, sp_error *err) {
    double substeps = fmax(1, ceil(s->spacing * s->omega / fmin(1, s->method.reach)));
    sp_status status = SP_OK;
    for (int attempt = 0; attempt < ATTEMPTS && status == SP_OK; attempt++) {
        if (!(work(s, out, substeps) <= WORK_MAX))
            return refuse_work(s, out, substeps, err);
        status = run(s, out, (int64_t)substeps, err);
        const double left = status == SP_OK ? allowed_ratio(s, out) : 1;
        if (left >= 1 || attempt == ATTEMPTS - 1)
            break;
        substeps = ceil(substeps * pow(0.9 * left, -1.0 / s->method.order));
    }
    return status;
}

/* The longest step up to the given one that divides the spacing of the points. */
static sp_status given_step(stepping *s, sp_signal *out, sp_error *err) {
    const double substeps = ceil(s->spacing / s->job->options->step * (1 - 1e-12));
    if (!(s->spacing / substeps * s->omega <= s->method.reach))
        return sp_fail(err, SP_EINVAL, "step = %g, must be at most %.6g: longer ones are unstable",
                       s->job->options->step, s->method.reach / s->omega);
    if (!(substeps * (out->n - 1) * s->method.products * s->starts <= 1e9))
        return sp_fail(err, SP_EINVAL, "step = %g takes %.3g products, must be at most 1e9", s->job->options->step,
                       substeps * (out->n - 1) * s->method.products * s->starts);
    return run(s, out, (int64_t)substeps, err);
}

static sp_status make(const signal_job *job, scheme method, sp_signal *out, sp_error *err) {
    stepping s;
    sp_status status = stepping_make(job, method, out, &s, err);
    if (status == SP_OK)
        status = job->options->step > 0 ? given_step(&s, out, err) : find_step(&s, out, err);
    stepping_free(&s);
    return status;
}

sp_status sp_signal_by_verlet(const signal_job *job, sp_signal *s, sp_error *err) {
    return make(job, (scheme){.fourth = false, .order = 2, .products = 1, .reach = 1.7}, s, err);
}

sp_status sp_signal_by_lax_wendroff(const signal_job *job, sp_signal *s, sp_error *err) {
    return make(job, (scheme){.fourth = true, .order = 4, .products = 2, .reach = 2.2}, s, err);
}
