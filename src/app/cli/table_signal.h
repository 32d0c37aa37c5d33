#ifndef SP_CLI_TABLE_SIGNAL_H
#define SP_CLI_TABLE_SIGNAL_H
/* Mean and scatter of a store's signals. */

#include <sonopack/study/store.h>

/* A row a time: t, mean, rms, mean_err and the interval of the mean, low to high, of those of n samples that have a
 * signal; comments say which were left out. Signals are read one by one, and again for every 48 MB that the intervals
 * take (3000 times at a level up to 0.99): memory is flat in samples and times but for the table. SP_EREFUSED for
 * samples of unlike pressure, size, kind, ... and for signals at unlike times. */
sp_status cli_table_signal(sp_store *store, int64_t n, const sp_sample *samples, const sp_table_options *opt,
                           sp_table *out, sp_error *err);

#endif
