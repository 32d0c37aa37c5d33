#ifndef SP_CLI_EXCITATION_H
#define SP_CLI_EXCITATION_H
/* What several commands take of sources, detectors, pulses and dashpots on the command line. */

#include "cli/cli.h"

/* ---- places ------------------------------------------------------------------------------------------------------ */

enum { CLI_PLACES_MAX = 1000 };
extern const char *const cli_component_names[]; /* "normal", "shear" */

/* Places as sp_place_read has them, of sources or of detectors. */
typedef struct cli_places {
    bool sources;
    int32_t n;
    sp_place at[CLI_PLACES_MAX];
    bool named[CLI_PLACES_MAX]; /* the component */
} cli_places;

/* Adds a place, of --from or --detector: parse() of these options. */
sp_status cli_places_add(void *places, const char *word, sp_error *err);
/* Adds `count` planes that divide the height into equal layers. */
sp_status cli_places_add_planes(cli_places *p, int64_t count, double height, sp_error *err);
/* Sets the component of all places that do not name one. An empty list becomes the whole wall. */
void cli_places_set_component(cli_places *p, bool shear);

/* ---- pulses ------------------------------------------------------------------------------------------------------ */

typedef struct cli_pulse {
    const char *word; /* NULL: delta */
    sp_pulse pulse;
    double *points; /* times and strengths of a file */
} cli_pulse;

/* Reads a word into a cli_pulse: parse() of --pulse. A file is only named here: cli_pulse_open reads it. */
sp_status cli_pulse_parse(void *pulse, const char *word, sp_error *err);
sp_status cli_pulse_open(cli_pulse *p, sp_error *err);
void cli_pulse_free(cli_pulse *p);

/* ---- dashpots ---------------------------------------------------------------------------------------------------- */

#define CLI_DAMPING "ZETA|gamma:C[:CT]|mass:RATE[:RATET]"

/* Reads --damping. A fraction of critical damping must be low .. high; the coefficients of other kinds may be any
 * number of 0 or more, or above 0 if low is. */
sp_status cli_damping_read(const char *text, double low, double high, sp_damping *out, sp_error *err);
/* The comment "damping = ...": a number for ZETA, as "gamma:0.1:0.05" otherwise. */
void cli_damping_comment(cli_writer *w, const sp_damping *law);

#endif
