/* Runs a method for signals and checks its error bound. */
#include "base/base.h"
#include "base/vector.h"
#include "modes/count.h"
#include "signal/job.h"

#include <math.h>
#include <stdio.h>

static const struct {
    const char *name;
    signal_function function;
    bool sparse;  /* uses only sparse rows for places */
    bool bounded; /* its error bound holds for motions that do not grow, and a small one that does is not noticed */
} methods[] = {[SP_SIGNAL_AUTO] = {"auto", NULL, false, false},
               [SP_SIGNAL_CHEBYSHEV] = {"chebyshev", sp_signal_by_chebyshev, true, true},
               [SP_SIGNAL_DENSE] = {"dense", sp_signal_by_modes, false, false},
               [SP_SIGNAL_VERLET] = {"verlet", sp_signal_by_verlet, false, true},
               [SP_SIGNAL_LAX_WENDROFF] = {"lax-wendroff", sp_signal_by_lax_wendroff, false, true},
               [SP_SIGNAL_FABER] = {"faber", sp_signal_by_faber, false, true},
               [SP_SIGNAL_DYNAMICS] = {"dynamics", sp_signal_by_dynamics, false, false},
               [SP_SIGNAL_SPARSE] = {"sparse", sp_signal_by_lowest_modes, false, false}};
enum { METHODS = sizeof methods / sizeof *methods, PLACES_MAX = 100000 };

const char *sp_signal_method_name(sp_signal_method method) {
    return (int)method >= 0 && (int)method < METHODS ? methods[method].name : NULL;
}

sp_signal_options sp_signal_options_default(void) {
    return (sp_signal_options){.method = SP_SIGNAL_AUTO,
                               .source = SP_SOURCE_IMPULSE,
                               .points = 801,
                               .tolerance = 1e-10,
                               .amplitude = 1e-3,
                               .damping_ratio = 1,
                               .threads = 1};
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
    if (!(o->step >= 0 && isfinite(o->step)))
        return sp_fail(err, SP_EINVAL, "step = %g, must be a time, or 0 for one found from the tolerance", o->step);
    if (!sp_signal_method_name(o->method))
        return sp_fail(err, SP_EINVAL, "signal method %d, must be one of sp_signal_method", (int)o->method);
    if (!(o->damping >= 0 && (o->damping <= 100 || (o->damping_kind != SP_DAMPING_ZETA && isfinite(o->damping)))))
        return sp_fail(err, SP_EINVAL, "damping = %g, must be %s", o->damping,
                       o->damping_kind == SP_DAMPING_ZETA ? "a fraction of critical damping, 0 .. 100" : "0 or more");
    if (!(o->amplitude > 0 && isfinite(o->amplitude)))
        return sp_fail(err, SP_EINVAL, "amplitude = %g, must be above 0", o->amplitude);
    if (o->damping > 0 && o->method != SP_SIGNAL_AUTO && o->method != SP_SIGNAL_FABER &&
        o->method != SP_SIGNAL_DYNAMICS)
        return sp_fail(err, SP_EINVAL,
                       "damping = %g with method %s, must be faber, dynamics or auto for damped signals", o->damping,
                       sp_signal_method_name(o->method));
    if (o->front && ((o->method != SP_SIGNAL_AUTO && o->method != SP_SIGNAL_CHEBYSHEV) || o->damping > 0))
        return sp_fail(err, SP_EINVAL, "a signal that ends after its front by method %s%s, must be chebyshev or auto",
                       sp_signal_method_name(o->method), o->damping > 0 ? " and damping" : "");
    if (o->step > 0 && o->method != SP_SIGNAL_VERLET && o->method != SP_SIGNAL_LAX_WENDROFF &&
        o->method != SP_SIGNAL_DYNAMICS)
        return sp_fail(err, SP_EINVAL, "step = %g with method %s, which makes no time steps", o->step,
                       sp_signal_method_name(o->method));
    if (o->modes < 0 || (o->modes > 0 && o->method != SP_SIGNAL_SPARSE))
        return sp_fail(err, SP_EINVAL, "modes = %lld with method %s, must be 0, or a number for method sparse",
                       (long long)o->modes, sp_signal_method_name(o->method));
    sp_status status = check_places("sources", o->sources, o->from, err);
    return status == SP_OK ? check_places("detectors", o->detectors, o->to, err) : status;
}

/* Before the front the signal is arbitrarily small. There the error is compared with 1e-6 of the signal's scale. */
static sp_status check_errors(const signal_job *job, sp_signal *s, sp_error *err) {
    for (int32_t a = 0; a < s->sources; a++)
        for (int32_t b = 0; b < s->detectors; b++) {
            const double *f = signal_pair(s, a, b), error = s->errors[a * s->detectors + b];
            const double largest = sp_largest(s->n, f);
            if (!(job->options->step > 0) && job->options->modes == 0 &&
                !(error <= job->options->tolerance * fmax(largest, 1e-6 * sp_job_scale(job, a, b))))
                return sp_fail(err, SP_EREFUSED,
                               "error bound %.3g is %.2g of the largest |F| = %.3g, must be at most %.2g", error,
                               error / largest, largest, job->options->tolerance);
            s->error = fmax(s->error, error);
        }
    return SP_OK;
}

sp_status sp_signal_make(const sp_network *net, const sp_signal_options *opt, sp_signal *out, sp_error *err) {
    return sp_signal_compute(NULL, net, opt, out, err);
}

sp_status sp_signal_front(const sp_network *net, const sp_signal_options *opt, sp_front *out, sp_error *err) {
    const sp_front_options rule = sp_front_options_default();
    sp_signal s = sp_signal_none();
    sp_status status = sp_signal_make(net, opt, &s, err);
    if (status == SP_OK)
        status = sp_front_find(s.n, s.t, s.f, &rule, out, err);
    sp_signal_free(&s);
    return status;
}

/* *unsure: the method succeeded but its error bound exceeds the tolerance. */
static sp_status run_method(sp_signal_method method, const sp_packing *p, const sp_network *net,
                            const sp_signal_options *opt, sp_signal *out, bool *unsure, sp_error *err) {
    sp_signal s = sp_signal_none();
    signal_job job = {0};
    s.omega_max = sp_network_omega_bound(net);
    s.method = method;
    *unsure = false;
    sp_status status = SP_OK;
    if (method != SP_SIGNAL_CHEBYSHEV && method != SP_SIGNAL_DYNAMICS) {
        char what[40];
        snprintf(what, sizeof what, "method %s", methods[method].name);
        status = sp_network_need_symmetry(net, what, err);
    }
    if (status == SP_OK && methods[method].bounded && !net->carried)
        status = sp_need_bounded(net, opt->until, err);
    if (status == SP_OK)
        status = sp_job_make(net, opt, !methods[method].sparse, &job, err);
    job.packing = p;
    if (status == SP_OK)
        status = sp_signal_allocate(opt, job.sources, job.detectors, &s, err);
    if (status == SP_OK)
        status = methods[method].function(&job, &s, err);
    if (status == SP_OK) {
        status = check_errors(&job, &s, err);
        *unsure = status != SP_OK;
    }
    sp_job_free(&job);
    if (status == SP_OK)
        *out = s;
    else
        sp_signal_free(&s);
    return status;
}

sp_status sp_signal_compute(const sp_packing *p, const sp_network *net, const sp_signal_options *opt, sp_signal *out,
                            sp_error *err) {
    sp_signal_method choice[SIGNAL_CHOICES] = {opt->method};
    bool unsure = true;
    sp_status status = check_options(opt, err);
    if (status != SP_OK)
        return status;
    if (p && (p->n != net->n_all || p->dim != net->dim))
        return sp_fail(err, SP_EINVAL, "a packing of %d grains and a network of %d, must be of the same packing", p->n,
                       net->n_all);
    const int choices = opt->method == SP_SIGNAL_AUTO ? sp_signal_choose(net, opt, choice) : 1;
    status = run_method(choice[0], p, net, opt, out, &unsure, err);
    for (int k = 1; k < choices && unsure; k++) /* report the failure of the first choice */
        if (run_method(choice[k], p, net, opt, out, &unsure, NULL) == SP_OK)
            status = SP_OK;
    return status;
}
