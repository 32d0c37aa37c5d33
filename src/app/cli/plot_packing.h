#ifndef SP_CLI_PLOT_PACKING_H
#define SP_CLI_PLOT_PACKING_H
/* Draws packings: directions, forces and stiffnesses of their contacts, and the motion after a pulse. */

#include "cli/cli.h"

/* Draws a histogram over packings, which are read one at a time, or the table of a histogram: of forces and stiffnesses
 * with `values`, else of directions. */
sp_status plot_contacts(const cli_common *common, const sp_scene *scene, bool values, int files, char **file,
                        sp_error *err);
/* Draws displacements. time < 0: when the front has travelled about three quarters of the height. */
sp_status plot_snapshot_file(const cli_common *common, const sp_scene *scene, const char *path, double time,
                             sp_error *err);

#endif
