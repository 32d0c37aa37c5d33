#ifndef SP_CLI_PLOT_SENSITIVITY_H
#define SP_CLI_PLOT_SENSITIVITY_H
/* Draws what each contact does to a quantity. */

#include "cli/cli.h"

/* file[0]: a packing; file[1], if there is one: a table of `sonopack sensitivity', else t10 is differentiated. */
sp_status plot_sensitivity(const cli_common *common, const sp_scene *scene, int files, char **file, sp_error *err);

#endif
