#ifndef SP_CLI_OUTPUT_H
#define SP_CLI_OUTPUT_H
/* Output functions that only a few commands need. */

#include "cli/cli.h"

/* Whether a file name has this ending, as in ".h5". Upper case and lower case are the same. */
bool cli_has_ending(const char *path, const char *ending);
bool cli_is_hdf5(const char *path); /* .h5 or .hdf5 */
/* cli_may_write for a file of the kind of another ending than its own. */
sp_status cli_may_write_as(const cli_common *common, const char *path, const char *ending, sp_error *err);
/* Reads the packing that packing.file names, and sets what the scene takes from it. */
sp_status cli_load_start(sp_scene *scene, sp_packing *from, sp_error *err);
/* Prints text on stdout. */
sp_status cli_print(const char *text, sp_error *err);
/* Closes stdout, for atexit: after a write error it prints the reason and exits with CLI_FAILED. */
void cli_close_stdout(void);

#endif
