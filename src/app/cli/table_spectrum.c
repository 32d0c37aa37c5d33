#include "cli/table_spectrum.h"

#include "base/base.h"
#include "cli/averaged.h"
#include "cli/spectrum.h"

#include <math.h>

/* The histogram of one sample after the other. */
typedef struct reader {
    sp_store *store;
    int32_t bins;
    double *edge;    /* [bins + 1] */
    double *place;   /* [2 bins] what a number belongs to: middles of bins, then their upper edges */
    double *numbers; /* [2 bins] densities, then integrals from 0 to the upper edges */
} reader;

static sp_status read_histogram(void *user, const sp_sample *sample, cli_array *out, sp_error *err) {
    reader *r = user;
    sp_sample_arrays arrays = sp_sample_arrays_none();
    sp_status status = sp_store_read(r->store, sample->name, NULL, NULL, &arrays, err);
    if (status == SP_OK && arrays.modes == 0)
        status = sp_fail(err, SP_EREFUSED, "the frequencies of sample %s are there no more", sample->name);
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
    *out = (cli_array){2 * r->bins, r->place, r->numbers};
    return status;
}

/* To two digits, so that rows have round numbers. */
static double rounded_up(double x) {
    const double unit = pow(10, fabs(floor(log10(x)) - 1)); /* or its inverse: powers above 1 have no rounding */
    const double up = x < 10 ? ceil(x * unit) / unit : ceil(x / unit) * unit;
    return up >= x ? up : x; /* whatever rounding did */
}

static double largest(const cli_averaged *of) {
    double most = 0;
    for (int64_t k = 0; k < of->n; k++)
        most = fmax(most, of->sample[k]->spectrum.omega_max);
    return most;
}

/* So few that steps stand out of their noise: that of 20 modes is a fourth or a fifth. */
static int32_t bins_for(const cli_averaged *of) {
    enum { MODES = 20, LEAST = 20, MOST = 100 };
    double modes = 0;
    for (int64_t k = 0; k < of->n; k++) {
        const sp_spectrum_made *made = &of->sample[k]->spectrum;
        modes += (double)made->dof * made->carrying - made->zero_modes;
    }
    return (int32_t)fmax(LEAST, fmin(MOST, floor(modes / MODES)));
}

static sp_status make_bins(const cli_averaged *of, const cli_bins *bins, reader *r, sp_error *err) {
    const double most = largest(of), until = bins->until > 0 ? bins->until : most > 0 ? rounded_up(most) : 1;
    r->bins = bins->bins > 0 ? bins->bins : bins_for(of);
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

static sp_status add_rows(const reader *r, const cli_sums *sums, sp_table *t, sp_error *err) {
    static const char *const columns[] = {"omega",          SPECTRUM_FREQUENCY, "low",         SPECTRUM_FREQUENCY,
                                          "high",           SPECTRUM_FREQUENCY, "density",     SPECTRUM_TIME,
                                          "density_err",    SPECTRUM_TIME,      "density_low", SPECTRUM_TIME,
                                          "density_high",   SPECTRUM_TIME,      "cumulative",  "modes/grain",
                                          "cumulative_err", "modes/grain",      NULL};
    const sp_signal_average *s = &sums->all;
    sp_status status = cli_add_columns(t, columns, err);
    for (int32_t b = 0; 2 * b < s->points && status == SP_OK; b++) {
        const bool empty = !(s->mean[b] > 0); /* in all samples: nothing tells how rare its modes are */
        const double row[] = {r->place[b],
                              r->edge[b],
                              r->edge[b + 1],
                              s->mean[b],
                              sp_signal_average_mean_err(s, b),
                              empty ? NAN : sums->interval[b].low,
                              empty ? NAN : sums->interval[b].high,
                              s->mean[r->bins + b],
                              sp_signal_average_mean_err(s, r->bins + b)};
        status = sp_table_add_numbers(t, row, err);
    }
    return status;
}

/* What the samples have that is no row. */
static sp_status add_means(const cli_averaged *of, sp_table *t, sp_error *err) {
    double carrying = 0, zeros = 0, of_a_grain = 0;
    for (int64_t k = 0; k < of->n; k++) {
        const sp_spectrum_made *made = &of->sample[k]->spectrum;
        carrying += made->carrying;
        zeros += made->zero_modes;
        of_a_grain += (double)made->zero_modes / made->carrying;
    }
    sp_status status = cli_add_number(t, "dof", of->sample[0]->spectrum.dof, err);
    if (status == SP_OK)
        status = cli_add_number(t, "omega_max", largest(of), err);
    if (status == SP_OK)
        status = cli_add_number(t, "mean_carrying", carrying / (double)of->n, err);
    if (status == SP_OK)
        status = cli_add_number(t, "mean_zero_modes", zeros / (double)of->n, err);
    if (status == SP_OK)
        status = cli_add_number(t, "mean_zero_modes_per_grain", of_a_grain / (double)of->n, err);
    return status;
}

static sp_status explain(const cli_averaged *of, double level, sp_table *t, sp_error *err) {
    char rule[80];
    sp_status status = cli_averaged_head(of, t, err);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "spectrum = ensemble");
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "norm = grain");
    if (status == SP_OK && of->n > 0)
        status = add_means(of, t, err);
    if (status == SP_OK && of->n > 0)
        status = sp_table_add_comment(t, err,
                                      "means over the samples of modes for each carrying grain, low < omega <= high: "
                                      "the last cumulative and mean_zero_modes_per_grain make dof where no mode is "
                                      "above the last bin");
    if (status == SP_OK && of->n > 0)
        status = sp_table_add_comment(t, err,
                                      "_err: standard error of the mean; density_low, density_high: its interval at "
                                      "level %.15g, %s; nan in bins without a mode in any sample",
                                      level, cli_interval_rule(of, level, rule, sizeof rule));
    return status == SP_OK ? cli_averaged_left_out(of, t, err) : status;
}

sp_status cli_table_spectrum(sp_store *store, int64_t n, const sp_sample *samples, const sp_table_options *opt,
                             const cli_bins *bins, sp_table *out, sp_error *err) {
    reader from = {.store = store};
    cli_averaged of = {0};
    cli_sums sums = {.all = sp_signal_average_none()};
    sp_table t = sp_table_none();
    sp_status status = cli_averaged_make(SP_WANT_SPECTRUM, "spectrum", "spectra", n, samples, &of, err);
    if (status == SP_OK)
        status = make_bins(&of, bins, &from, err);
    if (status == SP_OK)
        status = cli_averaged_sum(&of, opt->level, from.bins, read_histogram, &from, &sums, err);
    if (status == SP_OK)
        status = add_rows(&from, &sums, &t, err);
    if (status == SP_OK)
        status = explain(&of, opt->level, &t, err);
    if (status == SP_OK) {
        *out = t;
        t = sp_table_none();
    }
    sp_table_free(&t);
    cli_sums_free(&sums);
    sp_free(from.edge);
    cli_averaged_free(&of);
    return status;
}
