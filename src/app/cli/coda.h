#ifndef SP_CLI_CODA_H
#define SP_CLI_CODA_H
/* What the parts of the command coda share. */

#include "cli/files.h"
#include "cli/excitation.h"

typedef struct coda_arguments {
    cli_common common;
    const char *before, *after; /* tables of measured signals; NULL: computed ones */
    double change, noise, low, high;
    int64_t grain, trials, seed, points, rows;
    cli_places sources, detectors;
    int component, source;
} coda_arguments;

/* Adds the rows of one packing. */
sp_status coda_rows(void *arguments, cli_file *file, sp_table *t, sp_error *err);

#endif
