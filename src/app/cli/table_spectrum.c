/* Makes the table spectrum: the density of states of the samples of a store. */
#include "base/base.h"
#include "cli/averaged.h"
#include "cli/spectrum.h"

#include <math.h>

/* The histogram of the last sample that was read. */
typedef struct reader {
    sp_store *store;
    const cli_bins *options;
    double level;
    int32_t bins;
    double *edge;    /* [bins + 1] */
    double *place;   /* [2 bins] positions of the numbers: middles of the bins, then their upper edges */
    double *numbers; /* [2 bins] densities, then integrals from 0 to the upper edges */
} reader;

static sp_status read_histogram(void *user, const sp_sample *sample, cli_array *out, sp_error *err) {
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
    *out = (cli_array){2 * r->bins, r->place, r->numbers};
    return status;
}

/* Rounds up to two digits. */
static double rounded_up(double x) {
    /* a positive power of 10 is exact: for large x, the unit divides instead of multiplying */
    const double unit = pow(10, fabs(floor(log10(x)) - 1));
    const double up = x < 10 ? ceil(x * unit) / unit : ceil(x / unit) * unit;
    return up >= x ? up : x;
}

static double largest(const cli_averaged *of) {
    double most = 0;
    for (int64_t k = 0; k < of->n; k++)
        most = fmax(most, of->sample[k]->spectrum.omega_max);
    return most;
}

/* With 20 modes in a bin its noise is about a fifth of its height. */
static int32_t bins_for(const cli_averaged *of) {
    enum { MODES = 20, LEAST = 20, MOST = 100 };
    double modes = 0;
    for (int64_t k = 0; k < of->n; k++) {
        const sp_spectrum_made *made = &of->sample[k]->spectrum;
        modes += (double)made->dof * made->carrying - made->zero_modes;
    }
    return (int32_t)fmax(LEAST, fmin(MOST, floor(modes / MODES)));
}

static sp_status make_bins(void *user, const cli_averaged *of, int32_t *intervals, sp_error *err) {
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

static void add_rows(void *user, const cli_sums *sums, cli_writer *w) {
    const reader *r = user;
    const sp_signal_average *s = &sums->all;
    cli_columns(w, SP_COLUMN_NUMBER, "omega", SPECTRUM_FREQUENCY, "low", SPECTRUM_FREQUENCY, "high", SPECTRUM_FREQUENCY,
                "density", SPECTRUM_TIME, "density_err", SPECTRUM_TIME, "density_low", SPECTRUM_TIME, "density_high",
                SPECTRUM_TIME, "cumulative", "modes/grain", "cumulative_err", "modes/grain", NULL);
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

static void add_means(const cli_averaged *of, cli_writer *w) {
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

static void explain(void *user, const cli_averaged *of, const char *interval, cli_writer *w) {
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
    static const cli_averaging how = {.part = SP_WANT_SPECTRUM,
                                      .name = "spectrum",
                                      .plural = "spectra",
                                      .begin = make_bins,
                                      .read = read_histogram,
                                      .rows = add_rows,
                                      .explain = explain};
    reader r = {.store = store, .options = bins, .level = opt->level};
    sp_status status = cli_average(&how, &r, n, samples, opt->level, out, err);
    sp_free(r.edge);
    return status;
}
