#ifndef SP_CLI_PLOT_PACKING_H
#define SP_CLI_PLOT_PACKING_H
/* Draws packings: directions, forces and stiffnesses of their contacts. */

#include "cli/cli.h"

/* Draws a histogram over packings, which are read one at a time, or the table of a histogram: of forces and stiffnesses
 * with `values`, else of directions. */
sp_status plot_contacts(const cli_common *common, const sp_scene *scene, bool values, int files, char **file,
                        sp_error *err);

#endif
