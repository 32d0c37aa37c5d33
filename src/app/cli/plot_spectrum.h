#ifndef SP_CLI_PLOT_SPECTRUM_H
#define SP_CLI_PLOT_SPECTRUM_H
/* Figures of spectra. */

#include "cli/cli.h"
#include "cli/plot_look.h"

/* Tables of `sonopack spectrum', or packings, of which the density of states or the dispersion is computed. */
typedef struct plot_spectra {
    bool dispersion;    /* else spectra */
    const char *column; /* of a harmonic response; NULL: the force */
    const plot_look *look;
    int files;
    char **file;
} plot_spectra;
sp_status plot_spectrum_files(const cli_common *common, const sp_scene *scene, const plot_spectra *spectra,
                              sp_error *err);

#endif
