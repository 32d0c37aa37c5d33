/* Averages an array over the samples of a store, with confidence intervals. */
#include "cli/averaged.h"

#include "base/base.h"
#include "ensemble/groups.h"
#include "numeric/interval.h"

#include <stdio.h>

/* ---- which samples --------------------------------------------------------------------------------------------- */

/* Moves the samples that have the array to the front, in their order. */
static void put_in_front(unsigned part, cli_averaged *a) {
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

static sp_status check_alike(const cli_averaged *of, sp_error *err) {
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
static sp_status choose_samples(const cli_averaging *how, int64_t n, const sp_sample *samples, cli_averaged *out,
                                sp_error *err) {
    *out = (cli_averaged){.part = how->name, .plural = how->plural};
    sp_status status = sp_samples_sorted(n, samples, &out->sample, &out->count, err);
    if (status != SP_OK)
        return status;
    put_in_front(how->part, out);
    return check_alike(out, err);
}

/* Comments: how many samples there are, and of what. */
static void add_head(const cli_averaged *a, cli_writer *w) {
    cli_comment(w, "samples = %lld", (long long)a->n);
    if (a->n > 0)
        cli_comment(w, "pressure = %.15g, grains = %d, width = %.15g, friction = %.15g", a->sample[0]->pressure,
                    a->sample[0]->grains, a->sample[0]->width, a->sample[0]->friction);
}

/* Comments: which samples were left out, and why. */
static void add_left_out(const cli_averaged *a, cli_writer *w) {
    if (a->n == 0 && a->count > 0)
        cli_comment(w, "no row: none of %lld samples has a stored %s (study.want with %s keeps them)",
                    (long long)a->count, a->part, a->part);
    if (a->without > 0)
        cli_comment(w, "without_%s = %lld (left out: not wanted, or not made)", a->part, (long long)a->without);
    if (a->reason)
        cli_comment(w, "left out: the first reason is %s", a->reason);
    cli_comment(w, "failed = %lld", (long long)a->failed);
}

/* ---- sums ------------------------------------------------------------------------------------------------------- */

static const double memory_max = 48e6; /* of the resamples [bytes] */

/* How many numbers are resampled in one pass over the samples. */
static int32_t numbers_per_pass(double level) { return (int32_t)(memory_max / (16.0 * sp_interval_resamples(level))); }

/* One pass: sums, and resamples of the numbers begin .. begin + some.numbers - 1. */
typedef struct pass {
    cli_sums *to;
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
static sp_status add_array(const cli_averaged *a, const sp_sample *s, const cli_array *x, pass *p, sp_error *err) {
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

static sp_status sum_arrays(const cli_averaging *how, void *user, const cli_averaged *a, double level,
                            int32_t intervals, cli_sums *sums, sp_error *err) {
    pass p = {.to = sums, .some = sp_resampled_none(), .intervals = intervals, .level = level};
    sp_status status = SP_OK;
    while (a->n > 0 && status == SP_OK && (p.begin == 0 || p.begin < p.intervals)) {
        for (int64_t k = 0; k < a->n && status == SP_OK; k++) {
            cli_array array = {0};
            status = how->read(user, a->sample[k], &array, err);
            if (status == SP_OK)
                status = add_array(a, a->sample[k], &array, &p, err);
        }
        if (status == SP_OK && !sums->interval &&
            !(sums->interval = sp_alloc((size_t)p.intervals, sizeof *sums->interval)))
            status = sp_fail_memory(err, (size_t)p.intervals * sizeof *sums->interval);
        if (status == SP_OK)
            status = sp_resampled_intervals(&p.some, sums->interval + p.begin, err);
        p.begin += p.some.numbers;
        sp_resampled_free(&p.some);
    }
    return status;
}

/* How the intervals are made. */
static const char *interval_rule(const cli_averaged *a, double level, char *out, size_t size) {
    if (a->n < sp_resampled_least(level))
        snprintf(out, size, "by Student's t (of fewer than %lld samples)", (long long)sp_resampled_least(level));
    else
        snprintf(out, size, "by studentised Poisson bootstrap (%d resamples)", sp_interval_resamples(level));
    return out;
}

sp_status cli_average(const cli_averaging *how, void *user, int64_t n, const sp_sample *samples, double level,
                      sp_table *out, sp_error *err) {
    cli_averaged of = {0};
    cli_sums sums = {.all = sp_signal_average_none()};
    sp_table t = sp_table_none();
    int32_t intervals = INT32_MAX;
    char rule[80];
    cli_writer w = {.table = &t, .err = err, .status = choose_samples(how, n, samples, &of, err)};
    if (w.status == SP_OK)
        w.status = how->begin(user, &of, &intervals, err);
    if (w.status == SP_OK)
        w.status = sum_arrays(how, user, &of, level, intervals, &sums, err);
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
