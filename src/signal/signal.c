/* Which method, with what parameters, and whether its result can be vouched for. */
#include "base/base.h"
#include "signal/job.h"

#include <math.h>

static const struct {
    const char *name;
    signal_way way;
} methods[] = {[SP_SIGNAL_AUTO] = {"auto", NULL},
               [SP_SIGNAL_CHEBYSHEV] = {"chebyshev", sp_signal_by_chebyshev},
               [SP_SIGNAL_DENSE] = {"dense", sp_signal_by_modes}};
enum { METHODS = sizeof methods / sizeof *methods, PLACES_MAX = 100000, DENSE_DOFS = 20000 };

const char *sp_signal_method_name(sp_signal_method method) {
    return (int)method >= 0 && (int)method < METHODS ? methods[method].name : NULL;
}

sp_signal_options sp_signal_options_default(void) {
    return (sp_signal_options){
        .method = SP_SIGNAL_AUTO, .source = SP_SOURCE_IMPULSE, .points = 801, .tolerance = 1e-10, .threads = 1};
}

sp_signal sp_signal_none(void) { return (sp_signal){0}; }

void sp_signal_free(sp_signal *s) {
    sp_free(s->t);
    sp_free(s->f);
    sp_free(s->errors);
    *s = sp_signal_none();
}

double sp_signal_window(double height, double pressure) { return (8 * height + 40) * pow(pressure / 1e-4, -1.0 / 6); }

static sp_status check_places(const char *what, int32_t count, const sp_place *places, sp_error *err) {
    if (count < 0 || count > PLACES_MAX || (count > 1 && !places))
        return sp_fail(err, SP_EINVAL, "%d %s, must be 1 .. %d", count, what, PLACES_MAX);
    return SP_OK;
}

static sp_status check_options(const sp_signal_options *o, sp_error *err) {
    if (!(o->until > 0 && isfinite(o->until)))
        return sp_fail(err, SP_EINVAL, "until = %g, must be a time above 0", o->until);
    if (o->points < 2)
        return sp_fail(err, SP_EINVAL, "points = %d, must be 2 or more", o->points);
    if (!(o->tolerance > 0 && o->tolerance < 1))
        return sp_fail(err, SP_EINVAL, "tolerance = %g, must be above 0 and below 1", o->tolerance);
    if (!sp_signal_method_name(o->method))
        return sp_fail(err, SP_EINVAL, "signal method %d, must be one of sp_signal_method", (int)o->method);
    sp_status status = check_places("sources", o->sources, o->from, err);
    return status == SP_OK ? check_places("detectors", o->detectors, o->to, err) : status;
}

/* Nanoseconds, roughly: a spring in a product of two vectors, a Bessel value, a mode's sine; and LAPACK's n^3. */
static sp_signal_method choose_method(const sp_network *net, const sp_signal_options *o, double omega) {
    const double n = (double)sp_network_dofs(net), terms = 0.5 * omega * o->until + 50;
    const double chebyshev = 0.5 * terms * (7.0 * net->n_springs + 2 * n) + 0.6 * terms * o->points;
    const double dense = 0.15 * n * n * n + n * (20.0 * net->n_springs + 15.0 * o->points);
    return dense < chebyshev && n <= DENSE_DOFS ? SP_SIGNAL_DENSE : SP_SIGNAL_CHEBYSHEV;
}

static void job_free(signal_job *job) {
    sp_free(job->sent);
    sp_free(job->seen);
}

static sp_status make_job(const sp_network *net, const sp_signal_options *o, signal_job *job, sp_error *err) {
    const sp_place wall = sp_place_wall();
    const int64_t n = sp_network_dofs(net);
    const int32_t sources = o->from && o->sources > 0 ? o->sources : 1,
                  detectors = o->to && o->detectors > 0 ? o->detectors : 1;
    *job = (signal_job){.net = net, .options = o, .sources = sources, .detectors = detectors};
    job->sent = sp_alloc((size_t)sources, (size_t)n * sizeof *job->sent);
    job->seen = sp_alloc((size_t)detectors, (size_t)n * sizeof *job->seen);
    if (!job->sent || !job->seen)
        return sp_fail_memory(err, (size_t)(sources + detectors) * (size_t)n * sizeof(double));
    sp_status status = SP_OK;
    for (int32_t k = 0; k < sources && status == SP_OK; k++)
        status = sp_network_source_at(net, o->source, o->from ? &o->from[k] : &wall, job->sent + k * n, err);
    for (int32_t k = 0; k < detectors && status == SP_OK; k++)
        status = sp_network_detector_at(net, o->to ? &o->to[k] : &wall, job->seen + k * n, err);
    return status;
}

/* |a||b|/Omega, or |a||b| for displacements: the scale of the signal of a single hop. */
static double hop(const signal_job *job, int32_t source, int32_t detector) {
    const int64_t n = sp_network_dofs(job->net);
    const double *sent = job_source(job, source), *seen = job_detector(job, detector), *mass = job->net->mass;
    double a = 0, b = 0;
    for (int64_t k = 0; k < n; k++) {
        a += sent[k] * sent[k] * (job_moves(job) ? 1 / mass[k] : mass[k]);
        b += seen[k] * seen[k] / mass[k];
    }
    return sqrt(a) * sqrt(b) / (job_moves(job) ? sp_network_omega_bound(job->net) : 1);
}

/* Before anything arrives the signal is as small as one likes; there the error is held against a millionth of the scale
 * instead. */
static sp_status vouch(const signal_job *job, sp_signal *s, sp_error *err) {
    for (int32_t a = 0; a < s->sources; a++)
        for (int32_t b = 0; b < s->detectors; b++) {
            const double *f = signal_pair(s, a, b), error = s->errors[a * s->detectors + b];
            double largest = 0;
            for (int32_t l = 0; l < s->n; l++)
                largest = fmax(largest, fabs(f[l]));
            if (!(error <= job->options->tolerance * fmax(largest, 1e-6 * hop(job, a, b))))
                return sp_fail(err, SP_EREFUSED,
                               "error bound %.3g is %.2g of the largest |F| = %.3g, must be at most %.2g", error,
                               error / largest, largest, job->options->tolerance);
            s->error = fmax(s->error, error);
        }
    return SP_OK;
}

static sp_status allocate(const signal_job *job, sp_signal *s, sp_error *err) {
    const size_t pairs = (size_t)job->sources * (size_t)job->detectors;
    s->n = job->options->points;
    s->sources = job->sources;
    s->detectors = job->detectors;
    s->t = sp_alloc((size_t)s->n, sizeof *s->t);
    s->f = sp_alloc(pairs, (size_t)s->n * sizeof *s->f);
    s->errors = sp_alloc(pairs, sizeof *s->errors);
    if (!s->t || !s->f || !s->errors)
        return sp_fail_memory(err, (1 + pairs) * (size_t)s->n * sizeof *s->t);
    for (int32_t l = 0; l < s->n; l++)
        s->t[l] = l < s->n - 1 ? job->options->until * l / (s->n - 1) : job->options->until;
    return SP_OK;
}

sp_status sp_signal_make(const sp_network *net, const sp_signal_options *opt, sp_signal *out, sp_error *err) {
    sp_signal s = sp_signal_none();
    signal_job job = {0};
    sp_status status = check_options(opt, err);
    if (status != SP_OK)
        return status;
    s.omega_max = sp_network_omega_bound(net);
    s.method = opt->method == SP_SIGNAL_AUTO ? choose_method(net, opt, s.omega_max) : opt->method;
    status = make_job(net, opt, &job, err);
    if (status == SP_OK)
        status = allocate(&job, &s, err);
    if (status == SP_OK)
        status = methods[s.method].way(&job, &s, err);
    if (status == SP_OK)
        status = vouch(&job, &s, err);
    job_free(&job);
    if (status == SP_OK)
        *out = s;
    else
        sp_signal_free(&s);
    return status;
}
