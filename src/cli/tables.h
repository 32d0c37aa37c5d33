#ifndef SP_CLI_TABLES_H
#define SP_CLI_TABLES_H
/* Writes tables of the samples in a store, for `study' and `table'. */

#include "cli/cli.h"
#include "numeric/interval.h"
#include <sonopack/study/store.h>

enum { CLI_TABLES = 9, CLI_BINS_MAX = 10000 };
extern const char *const cli_table_names[CLI_TABLES + 1]; /* ended by NULL */

typedef struct cli_bins {
    int32_t bins;     /* of equal width; 0: one for each 20 modes of all samples, 20 to 100 */
    double omega_max; /* last frequency; 0: the largest of all samples, rounded up to two digits */
} cli_bins;

/* The tables signal and spectrum: means over samples of one pressure, size, width, friction, kind and dimension. */
typedef struct cli_averaged {
    bool spectrum;
    sp_store *store;
    int64_t n;
    const sp_sample *sample; /* [n] */
    double level;            /* confidence level of the intervals */
    cli_bins bins;           /* of spectrum */
} cli_averaged;
/* signal: a row for each time with mean, rms, mean_err, and the interval of the mean. spectrum: a row for each bin low
 * < omega <= high: modes per grain (without rattlers) and unit of omega, their interval, and the integral from 0; zero
 * modes are left out. Comments count the samples without the array. SP_EREFUSED for samples that differ. */
sp_status cli_table_averaged(const cli_averaged *want, sp_table *out, sp_error *err);

/* Selects samples by their properties, to a relative precision of 1e-3. NAN and 0 select all. */
typedef struct cli_filter {
    double width, pressure, friction;
    int64_t grains;
} cli_filter;

/* `count` tables of the samples of a scene, or of all samples of the store if scene is NULL.
 *
 * The rows of a table are pressures and sizes; scaling and planes also have rows for widths and frictions, signal and
 * spectrum have none of these. Each combination of values of the other swept keys is a case. A case has tables of its
 * own, with its values in the comments; it is skipped if the filter leaves no sample of it.
 *
 * On stdout a blank line separates the tables. With -o results.tsv the first table goes to that file, and the others to
 * results-moduli.tsv, ..., and to results-ctof-2.tsv, ... for further cases. */
typedef struct cli_tables {
    const cli_common *common;
    const sp_scene *scene;
    bool needs_samples; /* SP_EREFUSED if the store has none of them */
    int count;
    const char *name[CLI_TABLES];
    cli_filter filter;
    double level;  /* confidence level of the intervals */
    cli_bins bins; /* of the table spectrum */
} cli_tables;

cli_filter cli_filter_none(void); /* selects all samples */
/* Checks that all files of -o may be written. Call before the computation. */
sp_status cli_tables_may_write(const cli_tables *tables, sp_error *err);
sp_status cli_tables_write(const cli_tables *tables, sp_store *store, sp_error *err);

#endif
