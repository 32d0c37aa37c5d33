#ifndef SP_CLI_MODES_DAMPED_H
#define SP_CLI_MODES_DAMPED_H

#include "cli/cli.h"

/* The table of `modes --damping ZETA`. */
sp_status cli_damped_modes(const sp_packing *p, const sp_network *net, double zeta, sp_source source, sp_table *t,
                           sp_error *err);

#endif
