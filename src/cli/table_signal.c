#include "cli/table_signal.h"

#include "base/base.h"
#include "numeric/resampled.h"
#include "study/groups.h"

/* What was left out, and the first reason why. */
typedef struct left_out {
    int64_t failed, without;
    const char *reason; /* the first that is known; NULL: none is */
} left_out;

/* Moves the samples with a signal to the front, in their order. */
static int64_t with_signal(int64_t n, const sp_sample **s, left_out *out) {
    int64_t kept = 0;
    for (int64_t k = 0; k < n; k++) {
        if (s[k]->have & SP_WANT_SIGNAL) {
            s[kept++] = s[k];
            continue;
        }
        out->failed += s[k]->failed;
        out->without += !s[k]->failed;
        if (!out->reason && s[k]->reason[0])
            out->reason = s[k]->reason;
    }
    return kept;
}

static sp_status check_alike(int64_t n, const sp_sample *const *s, sp_error *err) {
    for (int64_t k = 1; k < n; k++) {
        const sp_sample *a = s[0], *b = s[k];
        if (a->pressure < b->pressure || a->pressure > b->pressure)
            return sp_fail(err, SP_EREFUSED,
                           "samples %s and %s have pressures %g and %g, and their signals are not averaged: choose "
                           "those of one pressure (--pressure)",
                           a->name, b->name, a->pressure, b->pressure);
        if (a->grains != b->grains)
            return sp_fail(err, SP_EREFUSED,
                           "samples %s and %s have %d and %d grains, and their signals are not averaged: choose those "
                           "of one size (--grains)",
                           a->name, b->name, a->grains, b->grains);
        if ((a->signal.method == SP_SIGNAL_DYNAMICS) != (b->signal.method == SP_SIGNAL_DYNAMICS))
            return sp_fail(err, SP_EREFUSED,
                           "of samples %s and %s one has the signal of the nonlinear dynamics, and they are not "
                           "averaged: choose those of one scene",
                           a->name, b->name);
    }
    return sp_samples_alike(n, s, err);
}

/* Memory of the resamples. */
static const double most_bytes = 48e6;

/* Times that are resampled together. */
static int32_t times_together(double level) { return (int32_t)(most_bytes / (16.0 * sp_interval_resamples(level))); }

/* Signals summed up, and resampled at the times from `begin' on. */
typedef struct sums {
    sp_signals all;
    sp_resampled some;
    int32_t begin;
    double level;
} sums;

static sp_status resample(sums *to, int32_t points, const double *f, sp_error *err) {
    const int32_t together = times_together(to->level), left = points - to->begin;
    sp_status status = SP_OK;
    if (to->some.numbers == 0)
        status = sp_resampled_make(left < together ? left : together, to->level, &to->some, err);
    if (status == SP_OK)
        sp_resampled_add(&to->some, f + to->begin);
    return status;
}

/* `again': it is summed up already. */
static sp_status add_stored(sp_store *store, const sp_sample *sample, bool again, sums *to, sp_error *err) {
    sp_signal signal = sp_signal_none();
    sp_status status = sp_store_read(store, sample->name, NULL, NULL, &signal, err);
    if (status == SP_OK && again && signal.n != to->all.points)
        status = sp_fail(err, SP_EREFUSED, "the signal of sample %s changed meanwhile", sample->name);
    else if (status == SP_OK && !again) {
        status = sp_signals_add(&to->all, signal.n, signal.t, signal.f, err);
        if (status == SP_EREFUSED)
            sp_fail_prefix(err,
                           "the signal of sample %s is not at the times of the others (make them with the same "
                           "signal.until and signal.points)",
                           sample->name);
        else if (status != SP_OK)
            sp_fail_prefix(err, "the signal of sample %s", sample->name);
    }
    if (status == SP_OK)
        status = resample(to, signal.n, signal.f, err);
    sp_signal_free(&signal);
    return status;
}

/* Every signal, as often as the memory of the resamples needs; the intervals of all times. */
static sp_status sum_up(sp_store *store, int64_t n, const sp_sample *const *s, sums *to, sp_interval **intervals,
                        sp_error *err) {
    sp_status status = SP_OK;
    for (to->begin = 0; n > 0 && status == SP_OK && (to->begin == 0 || to->begin < to->all.points);) {
        for (int64_t k = 0; k < n && status == SP_OK; k++)
            status = add_stored(store, s[k], to->begin > 0, to, err);
        if (status == SP_OK && !*intervals && !(*intervals = sp_alloc((size_t)to->all.points, sizeof(sp_interval))))
            status = sp_fail_memory(err, (size_t)to->all.points * sizeof(sp_interval));
        if (status == SP_OK)
            status = sp_resampled_intervals(&to->some, *intervals + to->begin, err);
        to->begin += to->some.numbers;
        sp_resampled_free(&to->some);
    }
    return status;
}

static sp_status add_rows(const sp_signals *s, const sp_interval *interval, sp_table *t, sp_error *err) {
    static const char *const names[] = {"mean", "rms", "mean_err", "low", "high"};
    sp_status status = sp_table_add_column(t, "t", "d/sqrt(E* / rho)", SP_CELL_NUMBER, err);
    for (int k = 0; k < 5 && status == SP_OK; k++)
        status = sp_table_add_column(t, names[k], "E* d^2", SP_CELL_NUMBER, err);
    for (int32_t k = 0; k < s->points && status == SP_OK; k++) {
        const double row[] = {s->t[k],         s->mean[k],      sp_signals_rms(s, k), sp_signals_mean_err(s, k),
                              interval[k].low, interval[k].high};
        status = sp_table_add_numbers(t, row, err);
    }
    return status;
}

static sp_status explain(int64_t n, const sp_sample *const *s, int64_t count, const left_out *out, double level,
                         sp_table *t, sp_error *err) {
    sp_status status = sp_table_add_comment(t, err, "samples = %lld", (long long)n);
    if (status == SP_OK && n > 0)
        status = sp_table_add_comment(t, err, "pressure = %.15g, grains = %d, width = %.15g, friction = %.15g",
                                      s[0]->pressure, s[0]->grains, s[0]->width, s[0]->friction);
    if (status == SP_OK && n > 0)
        status = sp_table_add_comment(t, err,
                                      "rms: root mean square deviation of the samples from their mean (over their "
                                      "number); mean_err: standard error of the mean; low, high: its interval at "
                                      "level %.15g, by studentised Poisson bootstrap (%d resamples)",
                                      level, sp_interval_resamples(level));
    if (status == SP_OK && n == 0 && count > 0)
        status = sp_table_add_comment(
            t, err, "no row: none of %lld samples has a stored signal (study.want with signal keeps them)",
            (long long)count);
    if (status == SP_OK && out->without > 0)
        status = sp_table_add_comment(t, err, "without_signal = %lld (left out: not wanted, or not made)",
                                      (long long)out->without);
    if (status == SP_OK && out->reason)
        status = sp_table_add_comment(t, err, "left out: the first reason is %s", out->reason);
    return status == SP_OK ? sp_table_add_comment(t, err, "failed = %lld", (long long)out->failed) : status;
}

sp_status cli_table_signal(sp_store *store, int64_t n, const sp_sample *samples, const sp_table_options *opt,
                           sp_table *out, sp_error *err) {
    sums to = {.all = sp_signals_none(), .some = sp_resampled_none(), .level = opt->level};
    sp_interval *intervals = NULL;
    sp_table t = sp_table_none();
    const sp_sample **sorted = NULL;
    left_out left = {0};
    int64_t count = 0, used = 0;
    sp_status status = sp_samples_sorted(n, samples, &sorted, &count, err);
    if (status == SP_OK) {
        used = with_signal(count, sorted, &left);
        status = check_alike(used, sorted, err);
    }
    if (status == SP_OK)
        status = sum_up(store, used, sorted, &to, &intervals, err);
    if (status == SP_OK)
        status = add_rows(&to.all, intervals, &t, err);
    if (status == SP_OK)
        status = explain(used, sorted, count, &left, to.level, &t, err);
    if (status == SP_OK) {
        *out = t;
        t = sp_table_none();
    }
    sp_table_free(&t);
    sp_signals_free(&to.all);
    sp_free(intervals);
    sp_free(sorted);
    return status;
}
