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

#endif
