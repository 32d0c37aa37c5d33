/* Makes tables of means over the samples of a store, of an array that each has: its signal, or its spectrum. */
#include "base/base.h"
#include "cli/tables.h"
#include "ensemble/groups.h"
#include "numeric/interval.h"

#include <math.h>
#include <stdio.h>

#define FORCE "E* d^2"
#define RATE  "sqrt(E* / rho)/d"
#define TIME  "d/sqrt(E* / rho)"

/* A table in the making. */
typedef struct average {
    const cli_averaged *want;
    unsigned part;             /* SP_WANT_... */
    const char *name, *plural; /* of the array: signal, signals */
    /* the samples, those that have the array first */
    int64_t n, count; /* with the array; all */
    const sp_sample **sample;
    int64_t failed, without; /* the others: failed, or without the array */
    const char *reason;      /* the first known reason among them; NULL: none */
    /* the array of one sample: numbers f at positions t */
    int32_t points;
    const double *t, *f;
    sp_sample_arrays arrays; /* from which they come */
    int32_t bins;            /* of a histogram */
    double *edge;            /* [bins + 1] */
    double *place;           /* [2 bins] positions: middles of the bins, then their upper edges */
    double *numbers;         /* [2 bins] densities, then integrals from 0 to the upper edges */
    /* the sums, and one pass: resamples of the numbers begin .. begin + some.numbers - 1 */
    sp_signal_average all;
    sp_interval *interval; /* [intervals] of the means of the first numbers */
    int32_t begin, intervals;
    sp_resampled some;
} average;

/* ---- which samples ----------------------------------------------------------------------------------------------- */

static sp_status check_alike(const average *of, sp_error *err) {
    for (int64_t k = 1; k < of->n; k++) {
        const sp_sample *a = of->sample[0], *b = of->sample[k];
        if (a->fraction != b->fraction || a->stage != b->stage)
            return sp_fail(err, SP_EREFUSED,
                           "samples %s and %s have the fractions %g and %g, stages %d and %d: %s are averaged at one "
                           "only, choose it with the scene and --set",
                           a->name, b->name, a->fraction, b->fraction, a->stage, b->stage, of->plural);
        if (a->fraction == 0 && (a->pressure < b->pressure || a->pressure > b->pressure))
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

/* Puts the samples that have the array in front, in their order. They stay the caller's. */
static sp_status choose_samples(average *a, sp_error *err) {
    sp_status status = sp_samples_sorted(a->want->n, a->want->sample, &a->sample, &a->count, err);
    for (int64_t k = 0; k < a->count && status == SP_OK; k++) {
        const sp_sample *s = a->sample[k];
        if (s->have & a->part) {
            a->sample[a->n++] = s;
            continue;
        }
        a->failed += s->failed;
        a->without += !s->failed;
        if (!a->reason && s->reason[0])
            a->reason = s->reason;
    }
    CLI_THEN(status, check_alike(a, err));
    return status;
}

static void add_head(const average *a, cli_writer *w) {
    const sp_sample *first = a->n > 0 ? a->sample[0] : NULL;
    cli_comment(w, "samples = %lld", (long long)a->n);
    if (a->n > 0)
        cli_comment(w, "%s = %.15g, grains = %d, width = %.15g, friction = %.15g",
                    first->fraction > 0 ? "fraction" : "pressure",
                    first->fraction > 0 ? first->fraction : first->pressure, first->grains, first->width,
                    first->friction);
    if (a->n > 0 && first->stage > 0)
        cli_comment(w, "stage = %d, strain = %.15g", first->stage, first->strain);
}

static void add_left_out(const average *a, cli_writer *w) {
    if (a->n == 0 && a->count > 0)
        cli_comment(w, "no row: none of %lld samples has a stored %s (study.want with %s keeps them)",
                    (long long)a->count, a->name, a->name);
    if (a->without > 0)
        cli_comment(w, "without_%s = %lld (left out: not wanted, or not made)", a->name, (long long)a->without);
    if (a->reason)
        cli_comment(w, "left out: the first reason is %s", a->reason);
    cli_comment(w, "failed = %lld", (long long)a->failed);
}

/* ---- one sample -------------------------------------------------------------------------------------------------- */

/* Rounds up to two digits. */
static double rounded_up(double x) {
    /* a positive power of 10 is exact: for large x, the unit divides instead of multiplying */
    const double unit = pow(10, fabs(floor(log10(x)) - 1));
    const double up = x < 10 ? ceil(x * unit) / unit : ceil(x / unit) * unit;
    return up >= x ? up : x;
}

static double largest(const average *of) {
    double most = 0;
    for (int64_t k = 0; k < of->n; k++)
        most = fmax(most, of->sample[k]->spectrum.omega_max);
    return most;
}

/* With 20 modes in a bin its noise is about a fifth of its height. */
static int32_t bins_for(const average *of) {
    enum { MODES = 20, LEAST = 20, MOST = 100 };
    double modes = 0;
    for (int64_t k = 0; k < of->n; k++) {
        const sp_spectrum_made *made = &of->sample[k]->spectrum;
        modes += (double)made->dof * made->carrying - made->zero_modes;
    }
    return (int32_t)fmax(LEAST, fmin(MOST, floor(modes / MODES)));
}

static sp_status make_bins(average *a, sp_error *err) {
    const cli_bins *bins = &a->want->bins;
    const double most = largest(a), until = bins->omega_max > 0 ? bins->omega_max : most > 0 ? rounded_up(most) : 1;
    a->intervals = a->bins = bins->bins > 0 ? bins->bins : bins_for(a);
    const size_t n = (size_t)a->bins;
    a->edge = sp_alloc(5 * n + 1, sizeof *a->edge);
    if (!a->edge)
        return sp_fail_memory(err, (5 * n + 1) * sizeof *a->edge);
    a->place = a->edge + n + 1;
    a->numbers = a->place + 2 * n;
    for (int32_t b = 0; b <= a->bins; b++)
        a->edge[b] = b < a->bins ? until * b / a->bins : until;
    for (int32_t b = 0; b < a->bins; b++) {
        a->place[b] = 0.5 * (a->edge[b] + a->edge[b + 1]);
        a->place[a->bins + b] = a->edge[b + 1];
    }
    return SP_OK;
}

/* Signals of linear and of nonlinear motion are not averaged. */
static sp_status check_methods(const average *of, sp_error *err) {
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

static void make_histogram(average *a, double grains) {
    const sp_sample_arrays *from = &a->arrays;
    int64_t k = 0, before = 0;
    while (k < from->modes && !(from->omega[k] > 0))
        k++;
    const int64_t zero = k;
    for (int32_t b = 0; b < a->bins; b++) {
        while (k < from->modes && from->omega[k] <= a->edge[b + 1])
            k++;
        a->numbers[b] = (double)(k - zero - before) / (grains * (a->edge[b + 1] - a->edge[b]));
        a->numbers[a->bins + b] = (double)(k - zero) / grains;
        before = k - zero;
    }
}

static sp_status read_sample(average *a, const sp_sample *s, sp_error *err) {
    sp_sample_arrays_free(&a->arrays);
    const sp_status status = sp_store_read(a->want->store, s->name, NULL, NULL, &a->arrays, err);
    a->points = a->want->spectrum ? 2 * a->bins : a->arrays.signal.n;
    a->t = a->want->spectrum ? a->place : a->arrays.signal.t;
    a->f = a->want->spectrum ? a->numbers : a->arrays.signal.f;
    if (status != SP_OK || !a->want->spectrum)
        return status;
    if (a->arrays.modes == 0)
        return sp_fail(err, SP_EREFUSED, "the frequencies of sample %s are no longer in the store", s->name);
    make_histogram(a, s->spectrum.carrying);
    return SP_OK;
}

/* ---- sums -------------------------------------------------------------------------------------------------------- */

static const double memory_max = 48e6; /* of the resamples [bytes] */

static sp_status resample(average *a, sp_error *err) {
    const int32_t together = (int32_t)(memory_max / (16.0 * sp_interval_resamples(a->want->level))),
                  left = a->intervals - a->begin;
    sp_status status = SP_OK;
    if (a->some.numbers == 0)
        status = sp_resampled_make(left < together ? left : together, a->want->level, &a->some, err);
    if (status == SP_OK)
        sp_resampled_add(&a->some, a->f + a->begin);
    return status;
}

/* Sums are made in the first pass only. */
static sp_status add_sample(average *a, const sp_sample *s, sp_error *err) {
    sp_status status = SP_OK;
    if (a->begin > 0 && a->points != a->all.points)
        status = sp_fail(err, SP_EREFUSED, "the %s of sample %s has changed since it was first read", a->name, s->name);
    else if (a->begin == 0) {
        status = sp_signal_average_add(&a->all, a->points, a->t, a->f, err);
        if (status == SP_EREFUSED)
            sp_fail_prefix(
                err,
                "the %s of sample %s has other times than those before it (make all with the same signal.until "
                "and signal.points)",
                a->name, s->name);
        else if (status != SP_OK)
            sp_fail_prefix(err, "the %s of sample %s", a->name, s->name);
        a->intervals = a->points < a->intervals ? a->points : a->intervals;
    }
    CLI_THEN(status, resample(a, err));
    return status;
}

/* Samples are read one at a time, and again for every 48 MB that the intervals take (3000 numbers at a level of up to
 * 0.99), so that memory does not grow with the number of samples. */
static sp_status sum(average *a, sp_error *err) {
    sp_status status = SP_OK;
    while (a->n > 0 && status == SP_OK && (a->begin == 0 || a->begin < a->intervals)) {
        for (int64_t k = 0; k < a->n && status == SP_OK; k++) {
            status = read_sample(a, a->sample[k], err);
            CLI_THEN(status, add_sample(a, a->sample[k], err));
        }
        if (status == SP_OK && !a->interval && !(a->interval = sp_alloc((size_t)a->intervals, sizeof *a->interval)))
            status = sp_fail_memory(err, (size_t)a->intervals * sizeof *a->interval);
        CLI_THEN(status, sp_resampled_intervals(&a->some, a->interval + a->begin, err));
        a->begin += a->some.numbers;
        sp_resampled_free(&a->some);
    }
    return status;
}

/* ---- the tables -------------------------------------------------------------------------------------------------- */

static void signal_rows(const average *a, cli_writer *w) {
    const sp_signal_average *s = &a->all;
    cli_columns(w, SP_COLUMN_NUMBER, "t", TIME, "mean", FORCE, "rms", FORCE, "mean_err", FORCE, "low", FORCE, "high",
                FORCE, NULL);
    for (int32_t k = 0; k < s->points; k++)
        cli_row(w, s->t[k], s->mean[k], sp_signal_average_rms(s, k), sp_signal_average_mean_err(s, k),
                a->interval[k].low, a->interval[k].high);
}

static void spectrum_rows(const average *a, cli_writer *w) {
    const sp_signal_average *s = &a->all;
    cli_columns(w, SP_COLUMN_NUMBER, "omega", RATE, "low", RATE, "high", RATE, "density", TIME, "density_err", TIME,
                "density_low", TIME, "density_high", TIME, "cumulative", "modes/grain", "cumulative_err", "modes/grain",
                NULL);
    for (int32_t b = 0; 2 * b < s->points; b++) {
        const bool empty = !(s->mean[b] > 0); /* in all samples: its interval is not known */
        cli_row(w, a->place[b], a->edge[b], a->edge[b + 1], s->mean[b], sp_signal_average_mean_err(s, b),
                empty ? NAN : a->interval[b].low, empty ? NAN : a->interval[b].high, s->mean[a->bins + b],
                sp_signal_average_mean_err(s, a->bins + b));
    }
}

static void add_means(const average *of, cli_writer *w) {
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

static void explain(const average *a, cli_writer *w) {
    const double level = a->want->level;
    char rule[80];
    if (a->n < sp_resampled_least(level))
        snprintf(rule, sizeof rule, "by Student's t (of fewer than %lld samples)",
                 (long long)sp_resampled_least(level));
    else
        snprintf(rule, sizeof rule, "by studentised Poisson bootstrap (%d resamples)", sp_interval_resamples(level));
    if (a->want->spectrum) {
        cli_comment(w, "spectrum = ensemble");
        cli_comment(w, "norm = grain");
    }
    if (a->n == 0)
        return;
    if (!a->want->spectrum) {
        cli_comment(w,
                    "rms: root mean square deviation of the samples from their mean (over their number); mean_err: "
                    "standard error of the mean; low, high: its interval at level %.15g, %s",
                    level, rule);
        return;
    }
    add_means(a, w);
    cli_comment(w, "means over the samples of modes for each carrying grain, low < omega <= high: the last cumulative "
                   "and mean_zero_modes_per_grain make dof where no mode is above the last bin");
    cli_comment(w,
                "_err: standard error of the mean; density_low, density_high: its interval at level %.15g, %s; nan in "
                "bins without a mode in any sample",
                level, rule);
}

sp_status cli_table_averaged(const cli_averaged *want, sp_table *out, sp_error *err) {
    average a = {.want = want,
                 .part = want->spectrum ? SP_WANT_SPECTRUM : SP_WANT_SIGNAL,
                 .name = want->spectrum ? "spectrum" : "signal",
                 .plural = want->spectrum ? "spectra" : "signals",
                 .arrays = sp_sample_arrays_none(),
                 .all = sp_signal_average_none(),
                 .some = sp_resampled_none(),
                 .intervals = INT32_MAX};
    sp_table t = sp_table_none();
    cli_writer w = {.table = &t, .err = err, .status = choose_samples(&a, err)};
    CLI_THEN(w.status, want->spectrum ? make_bins(&a, err) : check_methods(&a, err));
    CLI_THEN(w.status, sum(&a, err));
    if (w.status == SP_OK)
        (want->spectrum ? spectrum_rows : signal_rows)(&a, &w);
    add_head(&a, &w);
    if (w.status == SP_OK)
        explain(&a, &w);
    add_left_out(&a, &w);
    if (w.status == SP_OK)
        *out = t;
    else
        sp_table_free(&t);
    sp_sample_arrays_free(&a.arrays);
    sp_signal_average_free(&a.all);
    sp_free(a.interval);
    sp_free(a.edge);
    sp_free(a.sample);
    return w.status;
}
