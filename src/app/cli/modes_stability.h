#ifndef SP_CLI_MODES_STABILITY_H
#define SP_CLI_MODES_STABILITY_H

#include "cli/cli.h"

/* The table of `modes --stability`. */
sp_status cli_stability(const sp_packing *p, const sp_network *net, sp_table *t, sp_error *err);

#endif
