#ifndef SP_CLI_AVERAGED_H
#define SP_CLI_AVERAGED_H
/* Tables of means over the samples of a store, of an array that each sample has: its signal, or its spectrum. */

#include "cli/cli.h"
#include "numeric/interval.h"
#include <sonopack/study/store.h>

/* A row for each time: t, mean, rms, mean_err, and the confidence interval of the mean, low to high. Comments say which
 * samples were left out. SP_EREFUSED for samples of different pressure, size, kind, ..., and for signals at different
 * times. */
sp_status cli_table_signal(sp_store *store, int64_t n, const sp_sample *samples, const sp_table_options *opt,
                           sp_table *out, sp_error *err);

enum { CLI_BINS_MAX = 10000 };

typedef struct cli_bins {
    int32_t bins;     /* of equal width; 0: one for each 20 modes of all samples, 20 to 100 */
    double omega_max; /* last frequency; 0: the largest of all samples, rounded up to two digits */
} cli_bins;

/* A row for each bin low < omega <= high: the mean number of modes per grain (without rattlers) and unit of omega, its
 * standard error and confidence interval, and the integral from 0 with its standard error. Zero modes and samples
 * without frequencies are left out; comments count them. SP_EREFUSED for samples of different pressure, size, kind, ...
 */
sp_status cli_table_spectrum(sp_store *store, int64_t n, const sp_sample *samples, const sp_table_options *opt,
                             const cli_bins *bins, sp_table *out, sp_error *err);

/* ---- what both tables share ------------------------------------------------------------------------------------- */

/* The samples of a table, those that have the array first. */
typedef struct cli_averaged {
    const char *part, *plural; /* names of the array: signal, signals */
    int64_t n, count;          /* samples with the array; all samples */
    const sp_sample **sample;
    int64_t failed, without; /* the other samples: failed, or without the array */
    const char *reason;      /* the first known reason among them; NULL: none */
} cli_averaged;

/* The array of one sample: numbers f at positions t. They must stay valid until the next one is read. */
typedef struct cli_array {
    int32_t points;
    const double *t, *f;
} cli_array;

typedef struct cli_sums {
    sp_signal_average all;
    sp_interval *interval; /* of the means of the first numbers */
} cli_sums;

/* How a table of means is made. `user` is passed to all functions. */
typedef struct cli_averaging {
    unsigned part; /* SP_WANT_... */
    const char *name, *plural;
    /* Checks the samples; sets how many of the numbers get a confidence interval. */
    sp_status (*begin)(void *user, const cli_averaged *of, int32_t *intervals, sp_error *err);
    sp_status (*read)(void *user, const sp_sample *sample, cli_array *out, sp_error *err);
    /* Adds columns and rows, then comments. */
    void (*rows)(void *user, const cli_sums *sums, cli_writer *w);
    void (*explain)(void *user, const cli_averaged *of, const char *interval, cli_writer *w);
} cli_averaging;

/* Makes the table. Samples are read one at a time, and again for every 48 MB that the intervals take (3000 numbers at a
 * level of up to 0.99), so that memory does not grow with the number of samples. SP_EREFUSED for samples of different
 * pressure, size, width, friction, kind or dimension, and for arrays at different positions. */
sp_status cli_average(const cli_averaging *how, void *user, int64_t n, const sp_sample *samples, double level,
                      sp_table *out, sp_error *err);

#endif
