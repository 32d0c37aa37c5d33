#ifndef SP_CLI_PLOT_SIGNALS_H
#define SP_CLI_PLOT_SIGNALS_H
/* Figures of signals: of tables, or computed of packings. */

#include "cli/cli.h"
#include "cli/plot_look.h"

sp_status plot_signal_files(const cli_common *common, const sp_scene *scene, const plot_look *look, int files,
                            char **file, sp_error *err);

#endif
