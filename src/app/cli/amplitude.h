#ifndef SP_CLI_AMPLITUDE_H
#define SP_CLI_AMPLITUDE_H
/* Tables of loud pulses: a row for each file and amplitude, or means over files. */

#include "cli/files.h"

#include <sonopack/amplitude.h>

enum { AMPLITUDES_MAX = 200, PLANES_MAX = 1000, AMPLITUDE_QUANTITIES = 17 };

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

void amplitude_add_columns(cli_writer *w);
void amplitude_add_row(const cli_file *file, const sp_amplitude_front *pulse, cli_writer *w);
sp_status amplitude_add_mean(amplitude_means *m, const sp_packing *p, const sp_amplitude_front *pulse, sp_error *err);
void amplitude_mean_rows(const amplitude_means *m, cli_writer *w);

/* Fronts at planes. */
void amplitude_plane_columns(cli_writer *w);
void amplitude_plane_rows(const cli_file *file, const sp_amplitude_options *o, double amplitude, int32_t planes,
                          cli_writer *w);

/* Harmonics of bursts: a row for each plane, or with 0 planes one for all. */
void amplitude_burst_columns(bool planes, cli_writer *w);
void amplitude_burst_rows(const cli_file *file, const sp_amplitude_options *o, const sp_amplitude_burst *burst,
                          int32_t planes, cli_writer *w);

#endif
