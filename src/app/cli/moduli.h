#ifndef SP_CLI_MODULI_H
#define SP_CLI_MODULI_H
/* What the files of sonopack moduli share. */

#include "cli/files.h"

enum { MODULI_PROBES_MAX = 64 };

typedef struct moduli_probe {
    const char *text; /* as it was given */
    bool global;      /* imposed strain; else `probe` */
    sp_probe probe;
} moduli_probe;

typedef struct moduli_arguments {
    cli_common common;
    double margin;
    int probes, strains;
    moduli_probe probe[MODULI_PROBES_MAX];
    double strain[MODULI_PROBES_MAX];
    int dim;    /* of the packings so far; 0: none */
    bool whole; /* the table has the whole tensor: of packings without a piston */
} moduli_arguments;

/* Whether the walls cannot shear the packing, so that its shear moduli are nan. */
bool moduli_no_shear(int dim, const sp_moduli *m);
/* The columns C11, C12, ... of a packing of this dimension. */
void moduli_columns(cli_writer *w, int dim);
/* What the table of the imposed strain has in addition for cells without a piston, and its whole row. */
void moduli_whole_columns(cli_writer *w, int dim);
sp_status moduli_whole_row(const char *path, double pressure, const sp_moduli *m, const sp_elasticity *e, sp_table *t,
                           sp_error *err);
/* The table of --strain. */
void moduli_strained_columns(cli_writer *w, int dim);
sp_status moduli_strained_rows(const moduli_arguments *a, const cli_file *file, sp_table *t, sp_error *err);
/* The table of --probe. */
void moduli_probe_columns(cli_writer *w, const moduli_arguments *a, int dim);
sp_status moduli_probe_rows(const moduli_arguments *a, const cli_file *file, double density, sp_table *t,
                            sp_error *err);

#endif
