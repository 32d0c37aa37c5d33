#ifndef SP_CLI_LOW_BOX_H
#define SP_CLI_LOW_BOX_H
/* Warnings of packings whose results nobody should trust: one line on stderr each, unless --quiet is given. */

#include "cli/cli.h"

/* Before a packing is made: a box that will be lower than 6 diameters. */
void cli_warn_low_box(const cli_common *common, const sp_pack_spec *spec);
/* Of a packing that is read: such a box, or more rattlers than carrying grains. */
void cli_warn_packing(const cli_common *common, const char *path, const sp_packing *p, const sp_network *net);

#endif
