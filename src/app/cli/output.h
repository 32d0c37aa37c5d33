#ifndef SP_CLI_OUTPUT_H
#define SP_CLI_OUTPUT_H
/* Output that main and single commands need beside cli.h. */

#include "cli/cli.h"

/* Whether the name ends so (".h5"), in small or capital letters. */
bool cli_has_ending(const char *path, const char *ending);
/* The packing that packing.file names; the scene takes over what follows from it. */
sp_status cli_load_start(sp_scene *scene, sp_packing *from, sp_error *err);
/* Text on stdout, all of it or SP_EIO. */
sp_status cli_print(const char *text, sp_error *err);
/* For atexit: a full disk or a closed pipe behind stdout makes the exit status CLI_FAILED, with a reason. */
void cli_close_stdout(void);

#endif
