#ifndef SP_CLI_DASHPOTS_H
#define SP_CLI_DASHPOTS_H
/* The option --damping of several commands: the law of the dashpots. */

#include "cli/cli.h"

#include <sonopack/network.h>

#define CLI_DAMPING "ZETA|gamma:C[:CT]|mass:RATE[:RATET]"

/* Reads --damping. A fraction of critical damping must be low .. high; the coefficients of other kinds may be any
 * number of 0 or more, or above 0 if low is. */
sp_status cli_damping_read(const char *text, double low, double high, sp_damping *out, sp_error *err);
/* The comment "damping = ...": a number for ZETA, as "gamma:0.1:0.05" otherwise. */
void cli_damping_comment(cli_writer *w, const sp_damping *law);

#endif
