#ifndef SP_CLI_MODULI_H
#define SP_CLI_MODULI_H
/* What the parts of sonopack moduli share. */

#include "cli/springs.h"

enum { MODULI_PROBES_MAX = 64 };

typedef struct moduli_probe {
    const char *text; /* as it was given */
    bool global;      /* or else: */
    sp_probe probe;
} moduli_probe;

typedef struct moduli_arguments {
    cli_common common;
    cli_springs springs;
    double margin;
    int probes, strains;
    moduli_probe probe[MODULI_PROBES_MAX];
    double strain[MODULI_PROBES_MAX];
    int files;
    char **file;
} moduli_arguments;

/* The table of --strain. */
sp_status moduli_strained_columns(const sp_packing *p, sp_table *t, sp_error *err);
sp_status moduli_strained_rows(const moduli_arguments *a, const char *path, const sp_packing *p, const sp_network *net,
                               sp_table *t, sp_error *err);

#endif
