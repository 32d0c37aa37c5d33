/* Measures the run time of signals with every method. */
#include "base/base.h"
#include "cli/bench.h"

#include <math.h>

enum { DENSE_DOFS = 6000, LONG_DOFS = 700, PLACES = 12 };

typedef struct job {
    const sp_network *net;
    sp_signal_options options;
    const sp_signal *exact; /* to compare with; NULL: use the error bound of the result */
} job;

static double peak_of(const sp_signal *s, int64_t pair) {
    double peak = 0;
    for (int32_t l = 0; l < s->n; l++)
        peak = fmax(peak, fabs(s->f[pair * s->n + l]));
    return peak;
}

/* The largest deviation from `exact`, over the peak. */
static double deviation(const sp_signal *s, const sp_signal *exact) {
    double most = 0;
    for (int64_t pair = 0; pair < (int64_t)s->sources * s->detectors; pair++) {
        double worst = exact ? 0 : s->errors[pair];
        for (int32_t l = 0; exact && l < s->n; l++)
            worst = fmax(worst, fabs(s->f[pair * s->n + l] - exact->f[pair * s->n + l]));
        most = fmax(most, worst / peak_of(exact ? exact : s, pair));
    }
    return most;
}

static sp_status run(const void *data, double *error, sp_error *err) {
    const job *j = data;
    sp_signal s = sp_signal_none();
    sp_status status = sp_signal_make(j->net, &j->options, &s, err);
    if (status == SP_OK)
        *error = deviation(&s, j->exact);
    sp_signal_free(&s);
    return status;
}

/* Computes a signal with the smallest tolerance that the method can guarantee. */
static sp_status best_of(const sp_network *net, sp_signal_options o, sp_signal_method method, sp_signal *out,
                         sp_error *err) {
    sp_status status = SP_EREFUSED;
    o.method = method;
    for (o.tolerance = 1e-12; status == SP_EREFUSED && o.tolerance < 0.1; o.tolerance *= 100)
        status = sp_signal_make(net, &o, out, err);
    return status;
}

static bool steps_in_time(sp_signal_method method) {
    return method == SP_SIGNAL_VERLET || method == SP_SIGNAL_LAX_WENDROFF;
}

/* Methods that compute all modes run on small networks only; nonlinear motion is not comparable. */
static bool is_tried(sp_signal_method method, const sp_network *net) {
    if (method == SP_SIGNAL_DENSE || method == SP_SIGNAL_SPARSE)
        return sp_network_dofs(net) <= DENSE_DOFS;
    return method != SP_SIGNAL_DYNAMICS;
}

/* The signal of every method, as exact as it can be; empty if the method is not used. */
enum { METHODS_MAX = 16 };
typedef struct references {
    sp_signal by[METHODS_MAX];
} references;

static void free_references(references *r) {
    for (int m = 0; m < METHODS_MAX; m++)
        sp_signal_free(&r->by[m]);
}

/* all: with every method except time stepping; else with the expansion and the dense sum. */
static sp_status make_references(const sp_network *net, const sp_signal_options *o, bool all, references *r,
                                 sp_error *err) {
    sp_status status = SP_OK;
    for (int m = 0; m < METHODS_MAX; m++)
        r->by[m] = sp_signal_none();
    for (int m = SP_SIGNAL_CHEBYSHEV; m < METHODS_MAX && sp_signal_method_name((sp_signal_method)m) && status == SP_OK;
         m++) {
        if (!is_tried((sp_signal_method)m, net) || steps_in_time((sp_signal_method)m) || (!all && m > SP_SIGNAL_DENSE))
            continue;
        status = best_of(net, *o, (sp_signal_method)m, &r->by[m], err);
        status = status == SP_EREFUSED ? SP_OK : status;
    }
    return status;
}

/* The signal that a method is compared with: that of the other method with the smallest error bound. */
static const sp_signal *reference_for(const references *r, sp_signal_method used) {
    const sp_signal *best = NULL;
    for (int m = 0; m < METHODS_MAX; m++)
        if (m != (int)used && r->by[m].f && (!best || r->by[m].error < best->error))
            best = &r->by[m];
    return best;
}

/* The method that `auto` chooses. */
static sp_signal_method used_by(const job *j) {
    sp_signal s = sp_signal_none();
    sp_signal_method method = j->options.method;
    if (method == SP_SIGNAL_AUTO && sp_signal_make(j->net, &j->options, &s, NULL) == SP_OK)
        method = s.method;
    sp_signal_free(&s);
    return method;
}

static sp_status bench_one(const bench_subject *s, const char *name, const references *r, job *j, double parameter,
                           sp_error *err) {
    j->exact = reference_for(r, used_by(j));
    return bench_measure(s, &(bench_row){name, sp_signal_method_name(j->options.method), parameter, run, j}, err);
}

static sp_status bench_tolerances(const bench_subject *s, const char *name, const references *r, job *j, int count,
                                  const double *tolerance, sp_error *err) {
    sp_status status = SP_OK;
    for (int k = 0; k < count && status == SP_OK; k++) {
        j->options.tolerance = tolerance[k];
        status = bench_one(s, name, r, j, tolerance[k], err);
    }
    return status;
}

/* Time steps 1/Omega, 1/(4 Omega), ..., which are the parameters of the rows. */
static sp_status bench_steps(const bench_subject *s, const char *name, const references *r, job *j, sp_error *err) {
    sp_status status = SP_OK;
    for (int k = 0; k < 5 && status == SP_OK; k++) {
        j->options.step = ldexp(1, -2 * k) / sp_network_omega_bound(s->net);
        status = bench_one(s, name, r, j, j->options.step, err);
    }
    j->options.step = 0;
    return status;
}

/* Methods with a tolerance; time stepping only with `all`. */
static sp_status bench_methods(const bench_subject *s, const char *name, const sp_signal_options *o, bool all,
                               sp_error *err) {
    static const double tight[] = {1e-3, 1e-6, 1e-9, 1e-12}, chosen[] = {1e-3, 1e-9}, loose[] = {1e-6};
    job j = {.net = s->net, .options = *o};
    references r;
    sp_status status = make_references(s->net, o, all, &r, err);
    for (int m = SP_SIGNAL_AUTO; sp_signal_method_name((sp_signal_method)m) && status == SP_OK; m++) {
        j.options.method = (sp_signal_method)m;
        if (!is_tried(j.options.method, s->net))
            continue;
        if (m == SP_SIGNAL_AUTO)
            status = bench_tolerances(s, name, &r, &j, all ? 2 : 1, all ? chosen : loose, err);
        else if (m == SP_SIGNAL_DENSE) {
            j.options.tolerance = 1e-3;
            status = bench_one(s, name, &r, &j, NAN, err);
        } else if (!steps_in_time(j.options.method))
            status = bench_tolerances(s, name, &r, &j, all ? 4 : 1, all ? tight : loose, err);
        else if (all)
            status = bench_steps(s, name, &r, &j, err);
    }
    free_references(&r);
    return status;
}

sp_status bench_signal(const bench_subject *s, sp_error *err) {
    sp_signal_options o = sp_signal_options_default();
    o.until = s->until;
    return bench_methods(s, "signal", &o, true, err);
}

sp_status bench_long(const bench_subject *s, sp_error *err) {
    sp_signal_options o = sp_signal_options_default();
    o.until = 1e6 / sp_network_omega_bound(s->net);
    if (sp_network_dofs(s->net) > LONG_DOFS)
        return SP_OK;
    return bench_methods(s, "long", &o, false, err);
}

/* Sources and detectors are grains throughout the packing. */
sp_status bench_many(const bench_subject *s, sp_error *err) {
    sp_place from[PLACES], to[PLACES];
    sp_signal_options o = sp_signal_options_default();
    for (int k = 0; k < PLACES; k++) {
        const int64_t n = s->net->n;
        from[k] = (sp_place){.kind = SP_PLACE_GRAIN, .grain = s->net->grain[n * (2 * k) / (2 * PLACES)]};
        to[k] = (sp_place){.kind = SP_PLACE_GRAIN, .grain = s->net->grain[n * (2 * k + 1) / (2 * PLACES)]};
    }
    o.until = s->until;
    o.sources = o.detectors = PLACES;
    o.from = from;
    o.to = to;
    return bench_methods(s, "many", &o, false, err);
}

/* Dashpots with a tenth of critical damping. The error is the error bound of the method. */
sp_status bench_damped(const bench_subject *s, sp_error *err) {
    static const double tolerances[] = {1e-3, 1e-9};
    job j = {.net = s->net, .options = sp_signal_options_default()};
    sp_status status = SP_OK;
    j.options.until = s->until;
    j.options.damping = 0.1;
    j.options.method = SP_SIGNAL_FABER;
    for (int k = 0; k < 2 && status == SP_OK; k++) {
        j.options.tolerance = tolerances[k];
        status = bench_measure(
            s, &(bench_row){"damped", sp_signal_method_name(j.options.method), tolerances[k], run, &j}, err);
    }
    return status;
}
