/* Kernels of grains, and the signals of a network with one grain changed. */
#include "base/base.h"

#include <math.h>
#include <sonopack/coda.h>
#include <sonopack/sensitivity.h>
#include <string.h>

enum { BLOCK_BYTES = 1 << 28 }; /* of the derivatives of contacts that are in memory together */

sp_coda sp_coda_none(void) { return (sp_coda){0}; }

void sp_coda_free(sp_coda *c) {
    sp_free(c->grain);
    sp_free(c->kernel);
    sp_free(c->square);
    *c = sp_coda_none();
}

static int32_t at_least_one(int32_t n) { return n > 0 ? n : 1; }

static sp_status check_times(const sp_coda_options *o, sp_error *err) {
    if (o->times < 2)
        return sp_fail(err, SP_EINVAL, "%d times: a window needs at least 2", o->times);
    for (int32_t l = 0; l < o->times; l++)
        if (!(o->t[l] >= 0 && isfinite(o->t[l]) && (l == 0 || o->t[l] > o->t[l - 1])))
            return sp_fail(err, SP_EINVAL, "time %d is %g: times must ascend from 0 or above", l, o->t[l]);
    return SP_OK;
}

/* ---- kernels ---------------------------------------------------------------------------------------------------- */

typedef struct block {
    int32_t from, count;
    int32_t *spring;
    double *kn, *kt; /* [count][times] */
} block;

/* Adds the kernels of springs to those of their grains. */
static void add_block(const sp_network *net, const block *b, int32_t times, double *kernel) {
    for (int32_t k = 0; k < b->count; k++) {
        const sp_spring *s = &net->springs[b->spring[k]];
        const double *kn = b->kn + (size_t)k * (size_t)times, *kt = b->kt + (size_t)k * (size_t)times;
        for (int32_t l = 0; l < times; l++) {
            const double d = s->kn * kn[l] + s->kt * kt[l];
            kernel[(size_t)s->i * (size_t)times + (size_t)l] += d;
            if (s->j >= 0)
                kernel[(size_t)s->j * (size_t)times + (size_t)l] += d;
        }
    }
}

static sp_status add_pair(const sp_network *net, const sp_coda_options *o, int32_t pair, block *b, double *kernel,
                          sp_error *err) {
    const int32_t detectors = at_least_one(o->detectors), most = b->count;
    sp_sensitivity_options s = sp_sensitivity_options_default();
    sp_status status = SP_OK;
    s.source = o->source;
    s.from = o->from ? &o->from[pair / detectors] : NULL;
    s.to = o->to ? &o->to[pair % detectors] : NULL;
    s.threads = o->threads;
    for (b->from = 0; b->from < net->n_springs && status == SP_OK; b->from += most) {
        b->count = net->n_springs - b->from < most ? net->n_springs - b->from : most;
        for (int32_t k = 0; k < b->count; k++)
            b->spring[k] = b->from + k;
        memset(b->kt, 0, (size_t)b->count * (size_t)o->times * sizeof *b->kt);
        status = sp_sensitivity_times(net, &s, b->count, b->spring, o->times, o->t, b->kn,
                                      net->dof > net->dim ? b->kt : NULL, NULL, err);
        if (status == SP_OK)
            add_block(net, b, o->times, kernel);
    }
    b->count = most;
    return status;
}

static void sum_squares(sp_coda *c) {
    const size_t n = (size_t)c->n, times = (size_t)c->times;
    for (size_t row = 0; row < (size_t)c->pairs * n; row++)
        for (size_t l = 0; l < times; l++)
            c->square[row % n] += c->kernel[row * times + l] * c->kernel[row * times + l];
}

static sp_status make_kernels(const sp_network *net, const sp_coda_options *opt, sp_coda *c, sp_error *err) {
    const size_t n = (size_t)c->n, times = (size_t)c->times;
    const double fit = BLOCK_BYTES / (2.0 * (double)times * sizeof(double));
    block b = {.count = fit < net->n_springs ? (int32_t)fmax(fit, 1) : net->n_springs};
    const size_t count = (size_t)b.count;
    sp_status status = SP_OK;
    b.spring = sp_alloc(count, sizeof *b.spring);
    b.kn = sp_alloc(2 * count * times, sizeof *b.kn);
    b.kt = b.kn ? b.kn + count * times : NULL;
    if (!b.spring || !b.kn)
        status = sp_fail_memory(err, 2 * count * times * sizeof *b.kn);
    for (int32_t pair = 0; pair < c->pairs && status == SP_OK; pair++)
        status = add_pair(net, opt, pair, &b, c->kernel + (size_t)pair * n * times, err);
    sp_free(b.spring);
    sp_free(b.kn);
    return status;
}

sp_status sp_coda_make(const sp_network *net, const sp_coda_options *opt, sp_coda *out, sp_error *err) {
    sp_coda c = {.n = net->n, .pairs = at_least_one(opt->sources) * at_least_one(opt->detectors), .times = opt->times};
    const size_t n = (size_t)net->n, rows = (size_t)c.pairs * n;
    sp_status status = check_times(opt, err);
    if (status != SP_OK)
        return status;
    c.grain = sp_alloc(n, sizeof *c.grain);
    c.square = sp_alloc(n, sizeof *c.square);
    c.kernel = sp_alloc(rows * (size_t)c.times, sizeof *c.kernel);
    if (!c.grain || !c.square || !c.kernel)
        status = sp_fail_memory(err, rows * (size_t)c.times * sizeof *c.kernel);
    if (status == SP_OK) {
        memcpy(c.grain, net->grain, n * sizeof *c.grain);
        status = make_kernels(net, opt, &c, err);
    }
    if (status == SP_OK) {
        sum_squares(&c);
        *out = c;
    } else {
        sp_coda_free(&c);
    }
    return status;
}

/* ---- signals of a changed network ------------------------------------------------------------------------------- */

/* The signals on equal spacings up to the last time are computed, and read between them by a polynomial of 8 points,
 * whose error is far below that of the noise of any measurement: 1e-9 of the peak at 12 points a shortest period. */
static double between_points(const sp_signal *s, const double *f, double t) {
    enum { POINTS = 8 };
    const double h = s->t[1] - s->t[0];
    int32_t first = (int32_t)floor(t / h) - POINTS / 2 + 1;
    double sum = 0;
    first = first < 0 ? 0 : first > s->n - POINTS ? s->n - POINTS : first;
    for (int32_t a = first; a < first + POINTS; a++) {
        double weight = 1;
        for (int32_t b = first; b < first + POINTS; b++)
            weight *= b == a ? 1 : (t / h - b) / (double)(a - b);
        sum += weight * f[a];
    }
    return sum;
}

/* A copy that shares all arrays but its springs. */
static sp_status change_springs(const sp_network *net, int32_t grain, double change, sp_network *out, sp_error *err) {
    const size_t bytes = (size_t)net->n_springs * sizeof *net->springs;
    *out = *net;
    out->springs = sp_alloc((size_t)net->n_springs, sizeof *net->springs);
    if (!out->springs)
        return sp_fail_memory(err, bytes);
    memcpy(out->springs, net->springs, bytes);
    for (int32_t k = 0; k < net->n_springs && grain >= 0; k++) {
        sp_spring *s = &out->springs[k];
        if (net->grain[s->i] != grain && (s->j < 0 || net->grain[s->j] != grain))
            continue;
        s->kn *= 1 + change;
        s->kt *= 1 + change;
    }
    out->omega_bound *= sqrt(1 + fmax(grain >= 0 ? change : 0, 0)); /* K grows by that factor at most */
    return SP_OK;
}

static sp_status check_grain(const sp_network *net, int32_t grain, double change, sp_error *err) {
    for (int32_t k = 0; k < net->n; k++)
        if (net->grain[k] == grain)
            return change > -1 && change <= 10
                       ? SP_OK
                       : sp_fail(err, SP_EINVAL, "a change of %g: must be above -1, and 10 at most", change);
    if (grain >= net->n_all)
        return sp_fail(err, SP_EINVAL, "grain %d: must be among 0 .. %d", grain, net->n_all - 1);
    return sp_fail(err, SP_EINVAL, "grain %d carries no force: nothing changes with its contacts", grain);
}

sp_status sp_coda_signal(const sp_network *net, const sp_coda_options *opt, int32_t grain, double change,
                         double *signal, sp_error *err) {
    sp_network changed = {0};
    sp_signal s = sp_signal_none();
    sp_signal_options o = sp_signal_options_default();
    sp_status status = check_times(opt, err);
    if (status == SP_OK && grain >= 0)
        status = check_grain(net, grain, change, err);
    if (status == SP_OK)
        status = change_springs(net, grain, change, &changed, err);
    o.method = SP_SIGNAL_CHEBYSHEV;
    o.source = opt->source;
    o.sources = opt->sources;
    o.detectors = opt->detectors;
    o.from = opt->from;
    o.to = opt->to;
    o.threads = opt->threads > 0 ? opt->threads : 1;
    if (status == SP_OK) {
        o.until = opt->t[opt->times - 1] * (1 + 1e-12);
        const double points = ceil(o.until * changed.omega_bound * 2) + 9; /* 12 a period of the highest frequency */
        o.points = (int32_t)fmin(points, 1e8);
        status = points > 1e8 ? sp_fail(err, SP_EINVAL, "a window up to %g is too long", o.until)
                              : sp_signal_make(&changed, &o, &s, err);
    }
    for (int64_t k = 0; status == SP_OK && k < (int64_t)s.sources * s.detectors * opt->times; k++)
        signal[k] = between_points(&s, s.f + k / opt->times * s.n, opt->t[k % opt->times]);
    sp_signal_free(&s);
    sp_free(changed.springs);
    return status;
}
