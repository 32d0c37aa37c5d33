#ifndef SP_CLI_PLOT_TABLES_H
#define SP_CLI_PLOT_TABLES_H
/* Figures of tables of fronts, of ensembles, of modes, of waves and of the tapped column. */

#include "cli/cli.h"

#include <sonopack/figure/plot.h>

typedef enum plot_tables_kind { PLOT_FRONTS = 0, PLOT_SCALING, PLOT_ENSEMBLE, PLOT_MODES, PLOT_WAVE } plot_tables_kind;
enum { PLOT_NAME = 96 };
/* File name without folders and ending: how a file is called in a legend. */
const char *plot_name(const char *path, char out[PLOT_NAME]);

/* sample: a signal for the inset of fronts, or NULL. */
sp_status plot_tables_files(const cli_common *common, const sp_scene *scene, plot_tables_kind kind, const char *sample,
                            int files, char **file, sp_error *err);
/* Tables of `sonopack column'. */
sp_status plot_column_files(const cli_common *common, const sp_plot_column_options *options, int files, char **file,
                            sp_error *err);

#endif
