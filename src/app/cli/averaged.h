#ifndef SP_CLI_AVERAGED_H
#define SP_CLI_AVERAGED_H
/* Means over the samples of a store of what each has as an array: which samples have it, whether they may be averaged,
 * and the sums, from one array at a time. */

#include "numeric/interval.h"
#include <sonopack/study/store.h>

/* Samples in the order of all tables, those that have the part in front. */
typedef struct cli_averaged {
    const char *part, *plural; /* words for it: signal, signals */
    int64_t n, count;          /* with the part; in all */
    const sp_sample **sample;
    int64_t failed, without; /* of the others */
    const char *reason;      /* the first of theirs that is known; NULL: none is */
} cli_averaged;

/* part, plural: words; want: the part's bit. SP_EREFUSED for samples of unlike pressure, size, width, friction, kind
 * or dimension. The samples stay the caller's. */
sp_status cli_averaged_make(unsigned want, const char *part, const char *plural, int64_t n, const sp_sample *samples,
                            cli_averaged *out, sp_error *err);
void cli_averaged_free(cli_averaged *a);
/* Comments: how many there are and of what; and, at the end, what was left out and why. */
sp_status cli_averaged_head(const cli_averaged *a, sp_table *t, sp_error *err);
sp_status cli_averaged_left_out(const cli_averaged *a, sp_table *t, sp_error *err);

/* The array of one sample: numbers f at places t, which stay until the next call. */
typedef struct cli_array {
    int32_t points;
    const double *t, *f;
} cli_array;
typedef sp_status (*cli_array_read)(void *user, const sp_sample *sample, cli_array *out, sp_error *err);

typedef struct cli_sums {
    sp_signal_average all;
    sp_interval *interval; /* of the means of the first `intervals' numbers, or of all where there are fewer */
} cli_sums;

/* Every array is read, and again for each 48 MB that the intervals take (3000 numbers at a level up to 0.99): memory is
 * flat in samples and numbers. SP_EREFUSED for arrays at unlike places, and for one that changed meanwhile. */
sp_status cli_averaged_sum(const cli_averaged *a, double level, int32_t intervals, cli_array_read read, void *user,
                           cli_sums *out, sp_error *err);
/* How the intervals are made: "by studentised Poisson bootstrap (1000 resamples)", or by Student's t of few samples. */
const char *cli_interval_rule(const cli_averaged *a, double level, char *out, size_t size);
void cli_sums_free(cli_sums *s);

#endif
