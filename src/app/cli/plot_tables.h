#ifndef SP_CLI_PLOT_TABLES_H
#define SP_CLI_PLOT_TABLES_H
/* Draws tables of speeds, fronts, ensembles, modes, waves and the tapped column. */

#include "cli/cli.h"
#include "cli/plot_look.h"

#include <sonopack/figure/plot.h>

typedef enum plot_tables_kind {
    PLOT_FRONTS = 0,
    PLOT_SCALING,
    PLOT_ENSEMBLE,
    PLOT_MODES,
    PLOT_WAVE,
    PLOT_AMPLITUDE,
    PLOT_TRANSPORT,
    PLOT_CTOF
} plot_tables_kind;

typedef struct plot_tables_want {
    plot_tables_kind kind;
    const plot_look *look;
    const char *sample; /* the file of a signal for the inset of fronts, or NULL */
} plot_tables_want;

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
/* Gives the tables the labels of the command line, if it has any. Call after plot_tables_alloc succeeded or failed. */
void plot_tables_name(plot_tables *t, const plot_look *look);

sp_status plot_tables_files(const cli_common *common, const sp_scene *scene, const plot_tables_want *want, int files,
                            char **file, sp_error *err);
/* Draws tables of `sonopack column'. */
sp_status plot_column_files(const cli_common *common, const sp_plot_column_options *options, const plot_look *look,
                            int files, char **file, sp_error *err);

#endif
