#ifndef SP_CLI_PLOT_PACKING_H
#define SP_CLI_PLOT_PACKING_H
/* Figures of packings: directions, forces and stiffnesses of their contacts, and the motion after a pulse. */

#include "cli/cli.h"

/* Of many packings, read one at a time, or of one table that holds the histogram. values: of forces and stiffnesses,
 * else of directions. */
sp_status plot_contacts(const cli_common *common, const sp_scene *scene, bool values, int files, char **file,
                        sp_error *err);
/* time < 0: when the front has gone about three quarters of the way. */
sp_status plot_snapshot_file(const cli_common *common, const sp_scene *scene, const char *path, double time,
                             sp_error *err);

#endif
