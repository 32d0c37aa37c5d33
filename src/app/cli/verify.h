#ifndef SP_CLI_VERIFY_H
#define SP_CLI_VERIFY_H
/* The check of a store, for `study --verify'. */

#include "cli/cli.h"

/* As `sonopack check' has it: by the default rule grains and walls balance to about 1e-6 of p d^2. Packings from
 * elsewhere that stop at the paper's acceleration of 1e-10, a heavy piston included, have walls that are off by 1e-5.
 */
#define CLI_AUDIT_TOLERANCE 2e-5

/* The table of the files of a scene's samples in the store DIR, or of all where scene is NULL; *good says whether all
 * are sound. */
sp_status cli_verify(const cli_common *common, const char *dir, const sp_scene *scene, double tolerance, bool *good,
                     sp_error *err);

#endif
