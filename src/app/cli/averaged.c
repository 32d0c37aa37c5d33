#include "cli/averaged.h"

#include "base/base.h"
#include "ensemble/groups.h"
#include "numeric/resampled.h"

#include <stdio.h>

/* ---- which samples --------------------------------------------------------------------------------------------- */

/* Moves the samples with the part to the front, in their order. */
static void put_in_front(unsigned want, cli_averaged *a) {
    for (int64_t k = 0; k < a->count; k++) {
        const sp_sample *s = a->sample[k];
        if (s->have & want) {
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
            return sp_fail(err, SP_EREFUSED,
                           "samples %s and %s have pressures %g and %g, and their %s are not averaged: choose those of "
                           "one pressure (--pressure)",
                           a->name, b->name, a->pressure, b->pressure, of->plural);
        if (a->grains != b->grains)
            return sp_fail(
                err, SP_EREFUSED,
                "samples %s and %s have %d and %d grains, and their %s are not averaged: choose those of one "
                "size (--grains)",
                a->name, b->name, a->grains, b->grains, of->plural);
    }
    return sp_samples_alike(of->n, of->sample, err);
}

sp_status cli_averaged_make(unsigned want, const char *part, const char *plural, int64_t n, const sp_sample *samples,
                            cli_averaged *out, sp_error *err) {
    cli_averaged a = {.part = part, .plural = plural};
    sp_status status = sp_samples_sorted(n, samples, &a.sample, &a.count, err);
    if (status == SP_OK) {
        put_in_front(want, &a);
        status = check_alike(&a, err);
    }
    if (status == SP_OK)
        *out = a;
    else
        cli_averaged_free(&a);
    return status;
}

void cli_averaged_free(cli_averaged *a) {
    sp_free(a->sample);
    *a = (cli_averaged){0};
}

sp_status cli_averaged_head(const cli_averaged *a, sp_table *t, sp_error *err) {
    sp_status status = sp_table_add_comment(t, err, "samples = %lld", (long long)a->n);
    if (status == SP_OK && a->n > 0)
        status = sp_table_add_comment(t, err, "pressure = %.15g, grains = %d, width = %.15g, friction = %.15g",
                                      a->sample[0]->pressure, a->sample[0]->grains, a->sample[0]->width,
                                      a->sample[0]->friction);
    return status;
}

sp_status cli_averaged_left_out(const cli_averaged *a, sp_table *t, sp_error *err) {
    sp_status status = SP_OK;
    if (a->n == 0 && a->count > 0)
        status =
            sp_table_add_comment(t, err, "no row: none of %lld samples has a stored %s (study.want with %s keeps them)",
                                 (long long)a->count, a->part, a->part);
    if (status == SP_OK && a->without > 0)
        status = sp_table_add_comment(t, err, "without_%s = %lld (left out: not wanted, or not made)", a->part,
                                      (long long)a->without);
    if (status == SP_OK && a->reason)
        status = sp_table_add_comment(t, err, "left out: the first reason is %s", a->reason);
    return status == SP_OK ? sp_table_add_comment(t, err, "failed = %lld", (long long)a->failed) : status;
}

/* ---- sums ------------------------------------------------------------------------------------------------------- */

/* Memory of the resamples. */
static const double most_bytes = 48e6;

/* Numbers that are resampled together. */
static int32_t numbers_together(double level) { return (int32_t)(most_bytes / (16.0 * sp_interval_resamples(level))); }

/* Arrays on their way: summed up, and resampled in the numbers begin .. begin + some.numbers - 1. */
typedef struct passing {
    cli_sums *to;
    sp_resampled some;
    int32_t begin, intervals;
    double level;
} passing;

static sp_status resample(passing *p, const double *f, sp_error *err) {
    const int32_t together = numbers_together(p->level), left = p->intervals - p->begin;
    sp_status status = SP_OK;
    if (p->some.numbers == 0)
        status = sp_resampled_make(left < together ? left : together, p->level, &p->some, err);
    if (status == SP_OK)
        sp_resampled_add(&p->some, f + p->begin);
    return status;
}

/* The first pass sums up, too. */
static sp_status add_array(const cli_averaged *a, const sp_sample *s, const cli_array *x, passing *p, sp_error *err) {
    sp_signal_average *all = &p->to->all;
    sp_status status = SP_OK;
    if (p->begin > 0 && x->points != all->points)
        status = sp_fail(err, SP_EREFUSED, "the %s of sample %s changed meanwhile", a->part, s->name);
    else if (p->begin == 0) {
        status = sp_signal_average_add(all, x->points, x->t, x->f, err);
        if (status == SP_EREFUSED)
            sp_fail_prefix(err,
                           "the %s of sample %s is not at the times of the others (make them with the same "
                           "signal.until and signal.points)",
                           a->part, s->name);
        else if (status != SP_OK)
            sp_fail_prefix(err, "the %s of sample %s", a->part, s->name);
        p->intervals = x->points < p->intervals ? x->points : p->intervals;
    }
    return status == SP_OK ? resample(p, x->f, err) : status;
}

sp_status cli_averaged_sum(const cli_averaged *a, double level, int32_t intervals, cli_array_read read, void *user,
                           cli_sums *out, sp_error *err) {
    cli_sums sums = {.all = sp_signal_average_none()};
    passing p = {.to = &sums, .some = sp_resampled_none(), .intervals = intervals, .level = level};
    sp_status status = SP_OK;
    while (a->n > 0 && status == SP_OK && (p.begin == 0 || p.begin < p.intervals)) {
        for (int64_t k = 0; k < a->n && status == SP_OK; k++) {
            cli_array array = {0};
            status = read(user, a->sample[k], &array, err);
            if (status == SP_OK)
                status = add_array(a, a->sample[k], &array, &p, err);
        }
        if (status == SP_OK && !sums.interval &&
            !(sums.interval = sp_alloc((size_t)p.intervals, sizeof *sums.interval)))
            status = sp_fail_memory(err, (size_t)p.intervals * sizeof *sums.interval);
        if (status == SP_OK)
            status = sp_resampled_intervals(&p.some, sums.interval + p.begin, err);
        p.begin += p.some.numbers;
        sp_resampled_free(&p.some);
    }
    if (status == SP_OK)
        *out = sums;
    else
        cli_sums_free(&sums);
    return status;
}

const char *cli_interval_rule(const cli_averaged *a, double level, char *out, size_t size) {
    if (a->n < sp_resampled_least(level))
        snprintf(out, size, "by Student's t (of fewer than %lld samples)", (long long)sp_resampled_least(level));
    else
        snprintf(out, size, "by studentised Poisson bootstrap (%d resamples)", sp_interval_resamples(level));
    return out;
}

void cli_sums_free(cli_sums *s) {
    sp_signal_average_free(&s->all);
    sp_free(s->interval);
    *s = (cli_sums){.all = sp_signal_average_none()};
}
