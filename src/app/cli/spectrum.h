#ifndef SP_CLI_SPECTRUM_H
#define SP_CLI_SPECTRUM_H
/* The kinds of `sonopack spectrum'. Each makes a table of one packing. */

#include "cli/files.h"

typedef struct spectrum_arguments {
    cli_common common;
    int method, norm, direction;                        /* index of the word; -1: not given */
    int source, solver;                                 /* sp_source, sp_modes_solver */
    int64_t bins, vectors, seed, waves, layers, lowest; /* -1: not given */
    double until, resolution, node, tolerance;          /* < 0: not given */
    sp_damping damping;                                 /* value < 0: not given */
    double range[2];                                    /* heights of the fit; NAN: not given */
    const char *at;                                     /* frequencies; NULL: not given */
    bool lines, profile;
} spectrum_arguments;

spectrum_arguments spectrum_arguments_default(void); /* nothing given */

enum { SPECTRUM_FREQUENCIES_MAX = 100000, SPECTRUM_FREQUENCIES = 20 }; /* of --at; the latter by default */

extern const char *const spectrum_dos_methods[], *const spectrum_dos_norms[], *const spectrum_directions[];

/* Adds the columns, comments and rows of one kind. */
typedef sp_status (*spectrum_table)(const spectrum_arguments *a, cli_file *file, sp_table *t, sp_error *err);
sp_status spectrum_dos(const spectrum_arguments *a, cli_file *file, sp_table *t, sp_error *err);
sp_status spectrum_transmission(const spectrum_arguments *a, cli_file *file, sp_table *t, sp_error *err);
sp_status spectrum_dispersion(const spectrum_arguments *a, cli_file *file, sp_table *t, sp_error *err);
sp_status spectrum_participation(const spectrum_arguments *a, cli_file *file, sp_table *t, sp_error *err);
sp_status spectrum_harmonic(const spectrum_arguments *a, cli_file *file, sp_table *t, sp_error *err);
sp_status spectrum_continuum(const spectrum_arguments *a, cli_file *file, sp_table *t, sp_error *err);

#define SPECTRUM_FREQUENCY "sqrt(E* / rho)/d"
#define SPECTRUM_TIME      "d/sqrt(E* / rho)"
#define SPECTRUM_RESPONSE  "E* d^3/sqrt(E* / rho)"

#endif
