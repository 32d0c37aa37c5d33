#ifndef SP_CLI_TABLES_H
#define SP_CLI_TABLES_H
/* Tables of a store, for `study' and `table'. */

#include "cli/cli.h"
#include "cli/table_spectrum.h"

enum { CLI_TABLES = 9 };
extern const char *const cli_table_names[CLI_TABLES];

/* Which samples a table takes: those of this width, ...; NAN and 0: any. Pressures, widths and frictions to rounding.
 */
typedef struct cli_filter {
    double width, pressure, friction;
    int64_t grains;
} cli_filter;

/* What is printed: `count` tables of the samples of a scene, or of all samples of the store where scene is NULL.
 *
 * A table has rows for pressures and sizes only (those of fronts over distance for widths and frictions as well, those
 * of signals and spectra for none), so every combination of the values of other swept keys is a case with tables of its
 * own, its keys in the comments; cases that the filter leaves nothing of are passed over. On
 * stdout the tables follow each other with a blank line between; with -o the first goes to that file and the others
 * beside it: results.tsv, results-moduli.tsv, and of further cases results-ctof-2.tsv, ... */
typedef struct cli_tables {
    const cli_common *common;
    const sp_scene *scene;
    bool needs_samples; /* refuse where the store has none of them */
    int count;
    const char *name[CLI_TABLES];
    cli_filter filter;
    double level;  /* of intervals */
    cli_bins bins; /* of spectra */
} cli_tables;

/* --interval LEVEL; *level is written only if it is one. */
void cli_parse_interval(double *level, const char *arg, struct argp_state *state);

cli_filter cli_filter_none(void);
cli_bins cli_bins_default(void);
/* Whether all files of -o may be written. Call before the work. */
sp_status cli_tables_may_write(const cli_tables *tables, sp_error *err);
sp_status cli_tables_write(const cli_tables *tables, sp_store *store, sp_error *err);

#endif
