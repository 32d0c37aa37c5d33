/* Tables of means over the samples of a store, of an array that each sample has: its signal, or its spectrum. */
#include "cli/averaged.h"
#include "base/base.h"
#include "ensemble/groups.h"
#include "numeric/resampled.h"

#include <math.h>
#include <stdio.h>

/* The samples of a table, those that have the array first. */
typedef struct averaged {
    const char *part, *plural; /* names of the array: signal, signals */
    int64_t n, count;          /* samples with the array; all samples */
    const sp_sample **sample;
    int64_t failed, without; /* the other samples: failed, or without the array */
    const char *reason;      /* the first known reason among them; NULL: none */
} averaged;

/* The array of one sample: numbers f at positions t. They must stay valid until the next one is read. */
typedef struct sample_array {
    int32_t points;
    const double *t, *f;
} sample_array;

typedef struct sums_of {
    sp_signal_average all;
    sp_interval *interval; /* of the means of the first numbers */
} sums_of;

/* How a table of means is made. `user` is passed to all functions. */
typedef struct averaging {
    unsigned part; /* SP_WANT_... */
    const char *name, *plural;
    /* Checks the samples; sets how many of the numbers get a confidence interval. */
    sp_status (*begin)(void *user, const averaged *of, int32_t *intervals, sp_error *err);
    sp_status (*read)(void *user, const sp_sample *sample, sample_array *out, sp_error *err);
    /* Adds columns and rows, then comments. */
    void (*rows)(void *user, const sums_of *sums, cli_writer *w);
    void (*explain)(void *user, const averaged *of, const char *interval, cli_writer *w);
} averaging;

/* ---- which samples ----------------------------------------------------------------------------------------------- */

/* Moves the samples that have the array to the front, in their order. */
static void put_in_front(unsigned part, averaged *a) {
    for (int64_t k = 0; k < a->count; k++) {
        const sp_sample *s = a->sample[k];
        if (s->have & part) {
            a->sample[a->n++] = s;
            continue;
        }
        a->failed += s->failed;
        a->without += !s->failed;
        if (!a->reason && s->reason[0])
            a->reason = s->reason;
    }
}

static sp_status check_alike(const averaged *of, sp_error *err) {
    for (int64_t k = 1; k < of->n; k++) {
        const sp_sample *a = of->sample[0], *b = of->sample[k];
        if (a->pressure < b->pressure || a->pressure > b->pressure)
            return sp_fail(
                err, SP_EREFUSED,
                "samples %s and %s have the pressures %g and %g: %s are averaged at one pressure only, choose it "
                "with --pressure",
                a->name, b->name, a->pressure, b->pressure, of->plural);
        if (a->grains != b->grains)
            return sp_fail(
                err, SP_EREFUSED,
                "samples %s and %s have %d and %d grains: %s are averaged at one size only, choose it with --grains",
                a->name, b->name, a->grains, b->grains, of->plural);
    }
    return sp_samples_alike(of->n, of->sample, err);
}

/* The samples stay the caller's. */
static sp_status choose_samples(const averaging *how, int64_t n, const sp_sample *samples, averaged *out,
                                sp_error *err) {
    *out = (averaged){.part = how->name, .plural = how->plural};
    sp_status status = sp_samples_sorted(n, samples, &out->sample, &out->count, err);
    if (status != SP_OK)
        return status;
    put_in_front(how->part, out);
    return check_alike(out, err);
}

/* Comments: how many samples there are, and of what. */
static void add_head(const averaged *a, cli_writer *w) {
    cli_comment(w, "samples = %lld", (long long)a->n);
    if (a->n > 0)
        cli_comment(w, "pressure = %.15g, grains = %d, width = %.15g, friction = %.15g", a->sample[0]->pressure,
                    a->sample[0]->grains, a->sample[0]->width, a->sample[0]->friction);
}

/* Comments: which samples were left out, and why. */
static void add_left_out(const averaged *a, cli_writer *w) {
    if (a->n == 0 && a->count > 0)
        cli_comment(w, "no row: none of %lld samples has a stored %s (study.want with %s keeps them)",
                    (long long)a->count, a->part, a->part);
    if (a->without > 0)
        cli_comment(w, "without_%s = %lld (left out: not wanted, or not made)", a->part, (long long)a->without);
    if (a->reason)
        cli_comment(w, "left out: the first reason is %s", a->reason);
    cli_comment(w, "failed = %lld", (long long)a->failed);
}

/* ---- sums -------------------------------------------------------------------------------------------------------- */

static const double memory_max = 48e6; /* of the resamples [bytes] */

/* How many numbers are resampled in one pass over the samples. */
static int32_t numbers_per_pass(double level) { return (int32_t)(memory_max / (16.0 * sp_interval_resamples(level))); }

/* One pass: sums, and resamples of the numbers begin .. begin + some.numbers - 1. */
typedef struct pass {
    sums_of *to;
    sp_resampled some;
    int32_t begin, intervals;
    double level;
} pass;

static sp_status resample(pass *p, const double *f, sp_error *err) {
    const int32_t together = numbers_per_pass(p->level), left = p->intervals - p->begin;
    sp_status status = SP_OK;
    if (p->some.numbers == 0)
        status = sp_resampled_make(left < together ? left : together, p->level, &p->some, err);
    if (status == SP_OK)
        sp_resampled_add(&p->some, f + p->begin);
    return status;
}

/* Sums are made in the first pass only. */
static sp_status add_array(const averaged *a, const sp_sample *s, const sample_array *x, pass *p, sp_error *err) {
    sp_signal_average *all = &p->to->all;
    sp_status status = SP_OK;
    if (p->begin > 0 && x->points != all->points)
        status = sp_fail(err, SP_EREFUSED, "the %s of sample %s has changed since it was first read", a->part, s->name);
    else if (p->begin == 0) {
        status = sp_signal_average_add(all, x->points, x->t, x->f, err);
        if (status == SP_EREFUSED)
            sp_fail_prefix(
                err,
                "the %s of sample %s has other times than those before it (make all with the same signal.until "
                "and signal.points)",
                a->part, s->name);
        else if (status != SP_OK)
            sp_fail_prefix(err, "the %s of sample %s", a->part, s->name);
        p->intervals = x->points < p->intervals ? x->points : p->intervals;
    }
    return status == SP_OK ? resample(p, x->f, err) : status;
}

static sp_status sum_arrays(const averaging *how, void *user, const averaged *a, double level, int32_t intervals,
                            sums_of *sums, sp_error *err) {
    pass p = {.to = sums, .some = sp_resampled_none(), .intervals = intervals, .level = level};
    sp_status status = SP_OK;
    while (a->n > 0 && status == SP_OK && (p.begin == 0 || p.begin < p.intervals)) {
        for (int64_t k = 0; k < a->n && status == SP_OK; k++) {
            sample_array array = {0};
            status = how->read(user, a->sample[k], &array, err);
            CLI_THEN(status, add_array(a, a->sample[k], &array, &p, err));
        }
        if (status == SP_OK && !sums->interval &&
            !(sums->interval = sp_alloc((size_t)p.intervals, sizeof *sums->interval)))
            status = sp_fail_memory(err, (size_t)p.intervals * sizeof *sums->interval);
        CLI_THEN(status, sp_resampled_intervals(&p.some, sums->interval + p.begin, err));
        p.begin += p.some.numbers;
        sp_resampled_free(&p.some);
    }
    return status;
}

/* How the intervals are made. */
static const char *interval_rule(const averaged *a, double level, char *out, size_t size) {
    if (a->n < sp_resampled_least(level))
        snprintf(out, size, "by Student's t (of fewer than %lld samples)", (long long)sp_resampled_least(level));
    else
        snprintf(out, size, "by studentised Poisson bootstrap (%d resamples)", sp_interval_resamples(level));
    return out;
}

/* Makes the table. Samples are read one at a time, and again for every 48 MB that the intervals take (3000 numbers at a
 * level of up to 0.99), so that memory does not grow with the number of samples. SP_EREFUSED for samples of different
 * pressure, size, width, friction, kind or dimension, and for arrays at different positions. */
static sp_status average(const averaging *how, void *user, int64_t n, const sp_sample *samples, double level,
                         sp_table *out, sp_error *err) {
    averaged of = {0};
    sums_of sums = {.all = sp_signal_average_none()};
    sp_table t = sp_table_none();
    int32_t intervals = INT32_MAX;
    char rule[80];
    cli_writer w = {.table = &t, .err = err, .status = choose_samples(how, n, samples, &of, err)};
    CLI_THEN(w.status, how->begin(user, &of, &intervals, err));
    CLI_THEN(w.status, sum_arrays(how, user, &of, level, intervals, &sums, err));
    if (w.status == SP_OK)
        how->rows(user, &sums, &w);
    add_head(&of, &w);
    if (w.status == SP_OK)
        how->explain(user, &of, interval_rule(&of, level, rule, sizeof rule), &w);
    add_left_out(&of, &w);
    if (w.status == SP_OK)
        *out = t;
    else
        sp_table_free(&t);
    sp_signal_average_free(&sums.all);
    sp_free(sums.interval);
    sp_free(of.sample);
    return w.status;
}

/* ---- the table signal -------------------------------------------------------------------------------------------- */

/* What the samples are read with. */
typedef struct reader {
    sp_store *store;
    double level;
    sp_sample_arrays arrays; /* with the last signal */
    const cli_bins *options; /* of histograms */
    int32_t bins;
    double *edge;    /* [bins + 1] */
    double *place;   /* [2 bins] positions of the numbers: middles of the bins, then their upper edges */
    double *numbers; /* [2 bins] of the last sample: densities, then integrals from 0 to the upper edges */
} reader;

static sp_status read_signal(void *user, const sp_sample *sample, sample_array *out, sp_error *err) {
    reader *r = user;
    sp_sample_arrays_free(&r->arrays);
    sp_status status = sp_store_read(r->store, sample->name, NULL, NULL, &r->arrays, err);
    if (status == SP_OK)
        *out = (sample_array){r->arrays.signal.n, r->arrays.signal.t, r->arrays.signal.f};
    return status;
}

/* Signals of linear and of nonlinear motion are not averaged. */
static sp_status check_methods(void *user, const averaged *of, int32_t *intervals, sp_error *err) {
    (void)user, (void)intervals;
    for (int64_t k = 1; k < of->n; k++) {
        const sp_sample *a = of->sample[0], *b = of->sample[k];
        if ((a->signal.method == SP_SIGNAL_DYNAMICS) != (b->signal.method == SP_SIGNAL_DYNAMICS))
            return sp_fail(err, SP_EREFUSED,
                           "one of the samples %s and %s has the signal of the nonlinear dynamics, the other does not: "
                           "they are not averaged, choose the samples of one scene",
                           a->name, b->name);
    }
    return SP_OK;
}

static void signal_rows(void *user, const sums_of *sums, cli_writer *w) {
    const char *const unit = "E* d^2";
    const sp_signal_average *s = &sums->all;
    (void)user;
    cli_columns(w, SP_COLUMN_NUMBER, "t", "d/sqrt(E* / rho)", "mean", unit, "rms", unit, "mean_err", unit, "low", unit,
                "high", unit, NULL);
    for (int32_t k = 0; k < s->points && w->status == SP_OK; k++) {
        const sp_interval *i = &sums->interval[k];
        const double row[] = {s->t[k], s->mean[k], sp_signal_average_rms(s, k), sp_signal_average_mean_err(s, k),
                              i->low,  i->high};
        w->status = sp_table_add_numbers(w->table, row, w->err);
    }
}

static void explain_signal(void *user, const averaged *of, const char *interval, cli_writer *w) {
    const reader *r = user;
    if (of->n > 0)
        cli_comment(w,
                    "rms: root mean square deviation of the samples from their mean (over their number); mean_err: "
                    "standard error of the mean; low, high: its interval at level %.15g, %s",
                    r->level, interval);
}

sp_status cli_table_signal(sp_store *store, int64_t n, const sp_sample *samples, const sp_table_options *opt,
                           sp_table *out, sp_error *err) {
    static const averaging how = {.part = SP_WANT_SIGNAL,
                                  .name = "signal",
                                  .plural = "signals",
                                  .begin = check_methods,
                                  .read = read_signal,
                                  .rows = signal_rows,
                                  .explain = explain_signal};
    reader r = {.store = store, .level = opt->level, .arrays = sp_sample_arrays_none()};
    sp_status status = average(&how, &r, n, samples, opt->level, out, err);
    sp_sample_arrays_free(&r.arrays);
    return status;
}

/* ---- the table spectrum ------------------------------------------------------------------------------------------ */

#define RATE "sqrt(E* / rho)/d"
#define TIME "d/sqrt(E* / rho)"

static sp_status read_histogram(void *user, const sp_sample *sample, sample_array *out, sp_error *err) {
    reader *r = user;
    sp_sample_arrays arrays = sp_sample_arrays_none();
    sp_status status = sp_store_read(r->store, sample->name, NULL, NULL, &arrays, err);
    if (status == SP_OK && arrays.modes == 0)
        status = sp_fail(err, SP_EREFUSED, "the frequencies of sample %s are no longer in the store", sample->name);
    const double grains = sample->spectrum.carrying;
    int64_t k = 0, before = 0;
    while (k < arrays.modes && !(arrays.omega[k] > 0))
        k++;
    const int64_t zero = k;
    for (int32_t b = 0; b < r->bins && status == SP_OK; b++) {
        while (k < arrays.modes && arrays.omega[k] <= r->edge[b + 1])
            k++;
        r->numbers[b] = (double)(k - zero - before) / (grains * (r->edge[b + 1] - r->edge[b]));
        r->numbers[r->bins + b] = (double)(k - zero) / grains;
        before = k - zero;
    }
    sp_sample_arrays_free(&arrays);
    *out = (sample_array){2 * r->bins, r->place, r->numbers};
    return status;
}

/* Rounds up to two digits. */
static double rounded_up(double x) {
    /* a positive power of 10 is exact: for large x, the unit divides instead of multiplying */
    const double unit = pow(10, fabs(floor(log10(x)) - 1));
    const double up = x < 10 ? ceil(x * unit) / unit : ceil(x / unit) * unit;
    return up >= x ? up : x;
}

static double largest(const averaged *of) {
    double most = 0;
    for (int64_t k = 0; k < of->n; k++)
        most = fmax(most, of->sample[k]->spectrum.omega_max);
    return most;
}

/* With 20 modes in a bin its noise is about a fifth of its height. */
static int32_t bins_for(const averaged *of) {
    enum { MODES = 20, LEAST = 20, MOST = 100 };
    double modes = 0;
    for (int64_t k = 0; k < of->n; k++) {
        const sp_spectrum_made *made = &of->sample[k]->spectrum;
        modes += (double)made->dof * made->carrying - made->zero_modes;
    }
    return (int32_t)fmax(LEAST, fmin(MOST, floor(modes / MODES)));
}

static sp_status make_bins(void *user, const averaged *of, int32_t *intervals, sp_error *err) {
    reader *r = user;
    const cli_bins *bins = r->options;
    const double most = largest(of), until = bins->omega_max > 0 ? bins->omega_max : most > 0 ? rounded_up(most) : 1;
    r->bins = bins->bins > 0 ? bins->bins : bins_for(of);
    *intervals = r->bins;
    const size_t n = (size_t)r->bins;
    r->edge = sp_alloc(5 * n + 1, sizeof *r->edge);
    if (!r->edge)
        return sp_fail_memory(err, (5 * n + 1) * sizeof *r->edge);
    r->place = r->edge + n + 1;
    r->numbers = r->place + 2 * n;
    for (int32_t b = 0; b <= r->bins; b++)
        r->edge[b] = b < r->bins ? until * b / r->bins : until;
    for (int32_t b = 0; b < r->bins; b++) {
        r->place[b] = 0.5 * (r->edge[b] + r->edge[b + 1]);
        r->place[r->bins + b] = r->edge[b + 1];
    }
    return SP_OK;
}

static void spectrum_rows(void *user, const sums_of *sums, cli_writer *w) {
    const reader *r = user;
    const sp_signal_average *s = &sums->all;
    cli_columns(w, SP_COLUMN_NUMBER, "omega", RATE, "low", RATE, "high", RATE, "density", TIME, "density_err", TIME,
                "density_low", TIME, "density_high", TIME, "cumulative", "modes/grain", "cumulative_err", "modes/grain",
                NULL);
    for (int32_t b = 0; 2 * b < s->points && w->status == SP_OK; b++) {
        const bool empty = !(s->mean[b] > 0); /* in all samples: its interval is not known */
        const double row[] = {r->place[b],
                              r->edge[b],
                              r->edge[b + 1],
                              s->mean[b],
                              sp_signal_average_mean_err(s, b),
                              empty ? NAN : sums->interval[b].low,
                              empty ? NAN : sums->interval[b].high,
                              s->mean[r->bins + b],
                              sp_signal_average_mean_err(s, r->bins + b)};
        w->status = sp_table_add_numbers(w->table, row, w->err);
    }
}

static void add_means(const averaged *of, cli_writer *w) {
    double carrying = 0, zeros = 0, zeros_per_grain = 0;
    for (int64_t k = 0; k < of->n; k++) {
        const sp_spectrum_made *made = &of->sample[k]->spectrum;
        carrying += made->carrying;
        zeros += made->zero_modes;
        zeros_per_grain += (double)made->zero_modes / made->carrying;
    }
    cli_value(w, "dof", of->sample[0]->spectrum.dof);
    cli_value(w, "omega_max", largest(of));
    cli_value(w, "mean_carrying", carrying / (double)of->n);
    cli_value(w, "mean_zero_modes", zeros / (double)of->n);
    cli_value(w, "mean_zero_modes_per_grain", zeros_per_grain / (double)of->n);
}

static void explain_spectrum(void *user, const averaged *of, const char *interval, cli_writer *w) {
    const reader *r = user;
    cli_comment(w, "spectrum = ensemble");
    cli_comment(w, "norm = grain");
    if (of->n == 0)
        return;
    add_means(of, w);
    cli_comment(w, "means over the samples of modes for each carrying grain, low < omega <= high: the last cumulative "
                   "and mean_zero_modes_per_grain make dof where no mode is above the last bin");
    cli_comment(w,
                "_err: standard error of the mean; density_low, density_high: its interval at level %.15g, %s; nan in "
                "bins without a mode in any sample",
                r->level, interval);
}

sp_status cli_table_spectrum(sp_store *store, int64_t n, const sp_sample *samples, const sp_table_options *opt,
                             const cli_bins *bins, sp_table *out, sp_error *err) {
    static const averaging how = {.part = SP_WANT_SPECTRUM,
                                  .name = "spectrum",
                                  .plural = "spectra",
                                  .begin = make_bins,
                                  .read = read_histogram,
                                  .rows = spectrum_rows,
                                  .explain = explain_spectrum};
    reader r = {.store = store, .options = bins, .level = opt->level};
    sp_status status = average(&how, &r, n, samples, opt->level, out, err);
    sp_free(r.edge);
    return status;
}
