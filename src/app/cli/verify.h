#ifndef SP_CLI_VERIFY_H
#define SP_CLI_VERIFY_H
/* Checks the files of a store, for `study --verify'. */

#include "cli/cli.h"

/* Default tolerance of `sonopack check'. By the default rule grains and walls are balanced to about 1e-6 of p d^2;
 * packings that were compressed elsewhere to an acceleration of 1e-10, with a heavy piston, are off by 1e-5 at the
 * walls. */
#define CLI_AUDIT_TOLERANCE 2e-5

/* Prints a table of the files of a scene's samples, or of all files of the store if scene is NULL. jobs: how many
 * samples are computed again at a time. *good: all pass. */
sp_status cli_verify(const cli_common *common, const char *dir, const sp_scene *scene, double tolerance, int jobs,
                     bool *good, sp_error *err);

#endif
