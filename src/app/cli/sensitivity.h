#ifndef SP_CLI_SENSITIVITY_H
#define SP_CLI_SENSITIVITY_H
/* sonopack sensitivity: what is differentiated, and the tables. */

#include "cli/excitation.h"
#include "cli/files.h"

typedef enum sensitivity_kind {
    SENSITIVITY_FRONT = 0,
    SENSITIVITY_SIGNAL,
    SENSITIVITY_OMEGA,
    SENSITIVITY_MODULUS
} sensitivity_kind;

/* A quantity, as --of names it. */
typedef struct sensitivity_quantity {
    const char *word; /* as it was given */
    sensitivity_kind kind;
    sp_front_quantity front;
    sp_modulus modulus;
    int64_t first, last; /* modes, as in the column n of `modes` */
} sensitivity_quantity;

typedef struct sensitivity_arguments {
    cli_common common;
    sensitivity_quantity of;
    unsigned by; /* of sp_parameter */
    int source;
    double at, until, margin;
    cli_places sources, detectors;
    cli_pulse pulse;
} sensitivity_arguments;

sp_status sensitivity_read_quantity(const char *word, sensitivity_quantity *out, sp_error *err);
/* Reads --by: kn,kt or mass,radius,position or pressure. */
sp_status sensitivity_read_parameters(const char *word, unsigned *out, sp_error *err);
const char *sensitivity_unit(const sensitivity_quantity *of);

/* The gradient of the quantity for a file. */
sp_status sensitivity_compute(const sensitivity_arguments *a, const cli_file *file, sp_gradient *out, sp_error *err);
/* Columns and rows of springs, grains or the pressure, as `by` has it. */
sp_status sensitivity_table(const sensitivity_arguments *a, const cli_file *file, const sp_gradient *g, cli_writer *w);

#endif
