#ifndef SP_CLI_AMPLITUDE_H
#define SP_CLI_AMPLITUDE_H
/* Tables of loud pulses: a row for each file and amplitude, or means over files. */

#include "cli/files.h"

#include <sonopack/amplitude.h>

enum { AMPLITUDES_MAX = 200, PLANES_MAX = 1000 };

/* A number that is averaged; error: its column of errors, "" for none. */
typedef struct amplitude_quantity {
    const char *name, *unit, *error;
    sp_amplitude_value (*of)(const sp_amplitude_pulse *pulse);
} amplitude_quantity;
extern const amplitude_quantity amplitude_quantities[]; /* ended by name = NULL */
enum { AMPLITUDE_QUANTITIES = 17 };

/* Sums over packings of one pressure, friction and dimension at one amplitude. */
typedef struct amplitude_group {
    double pressure, friction, amplitude;
    int dim;
    int64_t n;
    double sum[AMPLITUDE_QUANTITIES], squares[AMPLITUDE_QUANTITIES], errors[AMPLITUDE_QUANTITIES];
} amplitude_group;
typedef struct amplitude_means {
    int32_t n;
    size_t capacity;
    amplitude_group *group;
} amplitude_means;

sp_status amplitude_add_columns(sp_table *t, sp_error *err);
sp_status amplitude_add_row(const char *path, double pressure, const sp_amplitude_pulse *pulse, sp_table *t,
                            sp_error *err);
sp_status amplitude_add_mean(amplitude_means *m, const sp_packing *p, const sp_amplitude_pulse *pulse, sp_error *err);
sp_status amplitude_mean_rows(const amplitude_means *m, sp_table *t, sp_error *err);

/* Fronts at planes. */
sp_status amplitude_plane_columns(sp_table *t, sp_error *err);
sp_status amplitude_plane_rows(const cli_file *file, const sp_amplitude_options *o, double amplitude, int32_t planes,
                               sp_table *t, sp_error *err);

#endif
