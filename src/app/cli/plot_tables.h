#ifndef SP_CLI_PLOT_TABLES_H
#define SP_CLI_PLOT_TABLES_H
/* Draws tables of fronts, ensembles, modes, waves and the tapped column. */

#include "cli/cli.h"

#include <sonopack/figure/plot.h>

typedef enum plot_tables_kind { PLOT_FRONTS = 0, PLOT_SCALING, PLOT_ENSEMBLE, PLOT_MODES, PLOT_WAVE } plot_tables_kind;

/* Tables and their names in a legend. */
enum { PLOT_NAME = 96 };
typedef struct plot_tables {
    int files;
    char **file;
    sp_table *table;      /* [files] */
    sp_plot_table *shown; /* [files] each points to a table and to its name */
    char (*name)[PLOT_NAME];
} plot_tables;

/* Empty tables, named after files without folder and ending. Free them, even after a failure. */
sp_status plot_tables_alloc(int files, char **file, plot_tables *out, sp_error *err);
void plot_tables_free(plot_tables *t);

/* sample: the file of a signal for the inset of fronts, or NULL. */
sp_status plot_tables_files(const cli_common *common, const sp_scene *scene, plot_tables_kind kind, const char *sample,
                            int files, char **file, sp_error *err);
/* Draws tables of `sonopack column'. */
sp_status plot_column_files(const cli_common *common, const sp_plot_column_options *options, int files, char **file,
                            sp_error *err);

#endif
