#ifndef SP_CLI_PLOT_SPECTRUM_H
#define SP_CLI_PLOT_SPECTRUM_H
/* Figures of spectra and modes. */

#include "cli/cli.h"

/* Tables of `sonopack spectrum', or packings: their density of states, or the dispersion of their waves. column: of a
 * harmonic response, or NULL. */
typedef struct plot_spectra {
    bool waves;
    const char *column;
    int files;
    char **file;
} plot_spectra;
sp_status plot_spectrum_files(const cli_common *common, const sp_scene *scene, const plot_spectra *want, sp_error *err);
/* A mode of a packing by its number among all modes; < 0: the first that is no zero mode. */
sp_status plot_mode_file(const cli_common *common, const sp_scene *scene, const char *path, int64_t number,
                         sp_error *err);

#endif
