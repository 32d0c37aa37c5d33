#ifndef SP_CLI_TRANSPORT_H
#define SP_CLI_TRANSPORT_H
/* What `transport` adds up over packings, for each frequency. */

#include "cli/files.h"

#include <sonopack/coherent.h>
#include <sonopack/transport.h>

typedef enum transport_quantity { TRANSPORT_DIFFUSIVITY = 0, TRANSPORT_KUBO, TRANSPORT_COHERENT } transport_quantity;

enum { TRANSPORT_FREQUENCIES_MAX = 1000, TRANSPORT_FREQUENCIES = 10, TRANSPORT_VALUES = 6 };

/* A mean over packings. The error is the standard error of the mean; with one packing it is what that packing gave. */
typedef struct transport_mean {
    int64_t n;
    double sum, squares, own;
} transport_mean;
/* Adds the value of one packing with its own error; nothing if the value is nan. */
void transport_add(transport_mean *m, double value, double error);
double transport_value(const transport_mean *m); /* nan without any */
double transport_error(const transport_mean *m); /* nan without any */

typedef struct transport_arguments {
    cli_common common;
    int quantity, axis;
    const char *at;
    double width, smear, until;
    int64_t waves, sources, seed;
    sp_coherent_section_options section;
    int dim; /* of the packings so far; 0: none */
    int32_t n;
    double *omega;        /* [n] */
    transport_mean *mean; /* [n][TRANSPORT_VALUES] */
} transport_arguments;

/* Adds one packing to the means of all frequencies. */
sp_status transport_measure(transport_arguments *a, const sp_network *net, sp_error *err);
/* Columns and rows. */
void transport_print(transport_arguments *a, cli_writer *w);

#endif
