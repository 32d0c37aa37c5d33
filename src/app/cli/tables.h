#ifndef SP_CLI_TABLES_H
#define SP_CLI_TABLES_H
/* Writes tables of the samples in a store, for `study' and `table'. */

#include "cli/averaged.h"
#include "cli/cli.h"

enum { CLI_TABLES = 9 };
extern const char *const cli_table_names[CLI_TABLES + 1]; /* ended by NULL */

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

/* study --verify: prints a table of the files of a scene's samples, or of all files of the store if scene is NULL.
 * jobs: how many samples are computed again at a time. *good: all pass. */
sp_status cli_verify(const cli_common *common, const char *dir, const sp_scene *scene, double tolerance, int jobs,
                     bool *good, sp_error *err);

#endif
