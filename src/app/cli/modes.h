#ifndef SP_CLI_MODES_H
#define SP_CLI_MODES_H
/* What the files of sonopack modes share, and the comments of all tables that count zero modes. */

#include "cli/cli.h"
#include "cli/files.h"

#include <sonopack/modes.h>

/* The table of --damping. */
sp_status modes_damped(const sp_packing *p, const sp_network *net, const sp_damping *law, sp_source source, sp_table *t,
                       sp_error *err);
/* The table of --stability. */
sp_status modes_stability(const sp_packing *p, const sp_network *net, sp_table *t, sp_error *err);

/* What is wrong with --vectors PATH and --mode (path NULL, mode < 0: not given). */
sp_status modes_vectors_check(const char *path, int64_t mode, sp_error *err);
/* Writes the vectors of all modes to an HDF5 file, or the displacements of one mode to a table. */
sp_status modes_vectors(const cli_common *common, const cli_file *file, const sp_modes *m, sp_source source,
                        int64_t mode, const char *path, sp_error *err);
/* Adds the numbers of zero modes as comments. */
void cli_zero_modes(cli_writer *w, const sp_zero_modes *z);

#define MODES_FREQUENCY "sqrt(E* / rho)/d"

#endif
