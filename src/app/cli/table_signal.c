#include "cli/table_signal.h"

#include "base/base.h"
#include "cli/averaged.h"

/* The signal of one sample after the other. */
typedef struct reader {
    sp_store *store;
    sp_sample_arrays arrays;
} reader;

static sp_status read_signal(void *user, const sp_sample *sample, cli_array *out, sp_error *err) {
    reader *r = user;
    sp_sample_arrays_free(&r->arrays);
    sp_status status = sp_store_read(r->store, sample->name, NULL, NULL, &r->arrays, err);
    if (status == SP_OK)
        *out = (cli_array){r->arrays.signal.n, r->arrays.signal.t, r->arrays.signal.f};
    return status;
}

/* Of the nonlinear motion there is another signal. */
static sp_status check_methods(const cli_averaged *of, sp_error *err) {
    for (int64_t k = 1; k < of->n; k++) {
        const sp_sample *a = of->sample[0], *b = of->sample[k];
        if ((a->signal.method == SP_SIGNAL_DYNAMICS) != (b->signal.method == SP_SIGNAL_DYNAMICS))
            return sp_fail(err, SP_EREFUSED,
                           "of samples %s and %s one has the signal of the nonlinear dynamics, and they are not "
                           "averaged: choose those of one scene",
                           a->name, b->name);
    }
    return SP_OK;
}

static sp_status add_rows(const cli_sums *sums, sp_table *t, sp_error *err) {
    static const char *const names[] = {"mean", "rms", "mean_err", "low", "high"};
    const sp_signal_average *s = &sums->all;
    sp_status status = sp_table_add_column(t, "t", "d/sqrt(E* / rho)", SP_CELL_NUMBER, err);
    for (int k = 0; k < 5 && status == SP_OK; k++)
        status = sp_table_add_column(t, names[k], "E* d^2", SP_CELL_NUMBER, err);
    for (int32_t k = 0; k < s->points && status == SP_OK; k++) {
        const sp_interval *i = &sums->interval[k];
        const double row[] = {s->t[k], s->mean[k], sp_signal_average_rms(s, k), sp_signal_average_mean_err(s, k),
                              i->low,  i->high};
        status = sp_table_add_numbers(t, row, err);
    }
    return status;
}

static sp_status explain(const cli_averaged *of, double level, sp_table *t, sp_error *err) {
    char rule[80];
    sp_status status = cli_averaged_head(of, t, err);
    if (status == SP_OK && of->n > 0)
        status = sp_table_add_comment(t, err,
                                      "rms: root mean square deviation of the samples from their mean (over their "
                                      "number); mean_err: standard error of the mean; low, high: its interval at "
                                      "level %.15g, %s",
                                      level, cli_interval_rule(of, level, rule, sizeof rule));
    return status == SP_OK ? cli_averaged_left_out(of, t, err) : status;
}

sp_status cli_table_signal(sp_store *store, int64_t n, const sp_sample *samples, const sp_table_options *opt,
                           sp_table *out, sp_error *err) {
    reader from = {store, sp_sample_arrays_none()};
    cli_averaged of = {0};
    cli_sums sums = {.all = sp_signal_average_none()};
    sp_table t = sp_table_none();
    sp_status status = cli_averaged_make(SP_WANT_SIGNAL, "signal", "signals", n, samples, &of, err);
    if (status == SP_OK)
        status = check_methods(&of, err);
    if (status == SP_OK)
        status = cli_averaged_sum(&of, opt->level, INT32_MAX, read_signal, &from, &sums, err);
    if (status == SP_OK)
        status = add_rows(&sums, &t, err);
    if (status == SP_OK)
        status = explain(&of, opt->level, &t, err);
    if (status == SP_OK) {
        *out = t;
        t = sp_table_none();
    }
    sp_table_free(&t);
    cli_sums_free(&sums);
    sp_sample_arrays_free(&from.arrays);
    cli_averaged_free(&of);
    return status;
}
