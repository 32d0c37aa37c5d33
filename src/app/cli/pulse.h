#ifndef SP_CLI_PULSE_H
#define SP_CLI_PULSE_H
/* Pulses, as written on the command line. */

#include "cli/cli.h"

#define CLI_PULSES "delta, gauss:WIDTH, ricker:OMEGA, sine:OMEGA:CYCLES, square:WIDTH or file:PATH"

typedef struct cli_pulse {
    const char *word; /* NULL: delta */
    sp_pulse pulse;
    double *points; /* times and strengths of a file */
} cli_pulse;

/* Reads a word. A file is only named here: cli_pulse_open reads it. */
sp_status cli_pulse_parse(const char *word, cli_pulse *out, sp_error *err);
sp_status cli_pulse_open(cli_pulse *p, sp_error *err);
void cli_pulse_free(cli_pulse *p);

#endif
