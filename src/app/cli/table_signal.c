/* Makes the table signal: mean and scatter of the signals of a store. */
#include "base/base.h"
#include "cli/averaged.h"

/* The last signal that was read. */
typedef struct reader {
    sp_store *store;
    sp_sample_arrays arrays;
    double level;
} reader;

static sp_status read_signal(void *user, const sp_sample *sample, cli_array *out, sp_error *err) {
    reader *r = user;
    sp_sample_arrays_free(&r->arrays);
    sp_status status = sp_store_read(r->store, sample->name, NULL, NULL, &r->arrays, err);
    if (status == SP_OK)
        *out = (cli_array){r->arrays.signal.n, r->arrays.signal.t, r->arrays.signal.f};
    return status;
}

/* Signals of linear and of nonlinear motion are not averaged. */
static sp_status check_methods(void *user, const cli_averaged *of, int32_t *intervals, sp_error *err) {
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

static void add_rows(void *user, const cli_sums *sums, cli_writer *w) {
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

static void explain(void *user, const cli_averaged *of, const char *interval, cli_writer *w) {
    const reader *r = user;
    if (of->n > 0)
        cli_comment(w,
                    "rms: root mean square deviation of the samples from their mean (over their number); mean_err: "
                    "standard error of the mean; low, high: its interval at level %.15g, %s",
                    r->level, interval);
}

sp_status cli_table_signal(sp_store *store, int64_t n, const sp_sample *samples, const sp_table_options *opt,
                           sp_table *out, sp_error *err) {
    static const cli_averaging how = {.part = SP_WANT_SIGNAL,
                                      .name = "signal",
                                      .plural = "signals",
                                      .begin = check_methods,
                                      .read = read_signal,
                                      .rows = add_rows,
                                      .explain = explain};
    reader r = {store, sp_sample_arrays_none(), opt->level};
    sp_status status = cli_average(&how, &r, n, samples, opt->level, out, err);
    sp_sample_arrays_free(&r.arrays);
    return status;
}
