#ifndef SP_CLI_CHAIN_LOCALISED_H
#define SP_CLI_CHAIN_LOCALISED_H
/* The table of `chain localisation'. */

#include "cli/cli.h"

typedef struct chain_localised {
    int64_t grains, seed;
    double disorder;
    const char *at; /* frequencies; NULL: the default */
} chain_localised;

sp_status chain_localised_table(const chain_localised *of, cli_writer *w);

#endif
