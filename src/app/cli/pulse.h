#ifndef SP_CLI_PULSE_H
#define SP_CLI_PULSE_H
/* Pulses as words: delta, gauss:WIDTH, ricker:OMEGA, sine:OMEGA:CYCLES, square:WIDTH, file:PATH. */

#include "cli/cli.h"

#define CLI_PULSES "delta, gauss:WIDTH, ricker:OMEGA, sine:OMEGA:CYCLES, square:WIDTH or file:PATH"

typedef struct cli_pulse {
    const char *word; /* NULL: delta */
    sp_pulse pulse;
    double *points; /* of a file */
} cli_pulse;

/* SP_EINVAL for a word that is none; a file is read by cli_pulse_open only. */
sp_status cli_pulse_parse(const char *word, cli_pulse *out, sp_error *err);
sp_status cli_pulse_open(cli_pulse *p, sp_error *err);
void cli_pulse_free(cli_pulse *p);

#endif
