#ifndef SP_CLI_TABLE_SPECTRUM_H
#define SP_CLI_TABLE_SPECTRUM_H
/* Density of states of a store's samples. */

#include <sonopack/study/store.h>

enum { CLI_BINS_MAX = 10000 };

typedef struct cli_bins {
    int32_t bins; /* of equal width; 0: one for each 20 modes of all samples, 20 to 100 */
    double until; /* last frequency; 0: the largest of all samples, rounded up to two digits */
} cli_bins;

/* A row a bin low < omega <= high: the mean over the samples of the number of modes for each carrying grain and unit
 * of omega, its standard error and interval, and the integral from 0 with its standard error, of those of n samples
 * that have frequencies. Zero modes are left out, and said in a comment, as are the samples without. Frequencies are
 * read from one sample at a time. SP_EREFUSED for samples of unlike pressure, size, kind, ... */
sp_status cli_table_spectrum(sp_store *store, int64_t n, const sp_sample *samples, const sp_table_options *opt,
                             const cli_bins *bins, sp_table *out, sp_error *err);

#endif
