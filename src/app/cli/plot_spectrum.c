/* Draws spectra and dispersion relations. */
#include "cli/plot_spectrum.h"

#include "base/base.h"
#include "cli/plot_input.h"
#include "cli/plot_tables.h"
#include "cli/plot_units.h"
#include "cli/spectrum.h"
#include "cli/trace.h"

#include <math.h>
#include <string.h>

/* Makes the table that `sonopack spectrum' would print. */
static sp_status packing_table(const char *path, const sp_scene *scene, bool dispersion, sp_table *t, sp_error *err) {
    const spectrum_arguments a = spectrum_arguments_default();
    cli_file file = {.path = path, .scene = scene};
    cli_writer w = {.table = t, .err = err};
    w.status = cli_read_network(path, &scene->network, &file.packing, &file.network, err);
    if (w.status == SP_EINVAL || w.status == SP_EREFUSED)
        w.status = err->status = SP_EFORMAT; /* the fault of the file, which is named */
    cli_comment(&w, "spectrum = %s", dispersion ? "dispersion" : "dos");
    if (w.status == SP_OK)
        w.status = dispersion ? spectrum_dispersion(&a, &file, t, err) : spectrum_dos(&a, &file, t, err);
    if (w.status == SP_OK)
        w.status = plot_units_convert(t, err);
    sp_network_free(&file.network);
    sp_packing_free(&file.packing);
    return w.status;
}

sp_status plot_spectrum_files(const cli_common *common, const sp_scene *scene, const plot_spectra *spectra,
                              sp_error *err) {
    plot_tables t;
    bool packing = false;
    sp_status status = plot_tables_alloc(spectra->files, spectra->file, &t, err);
    plot_tables_name(&t, spectra->look);
    for (int k = 0; k < t.files && status == SP_OK; k++) {
        status = cli_is_packing(t.file[k], &packing, err);
        if (status == SP_OK)
            status = packing ? packing_table(t.file[k], scene, spectra->dispersion, &t.table[k], err)
                             : plot_read_table(t.file[k], &t.table[k], err);
    }
    if (status == SP_OK)
        status = spectra->dispersion ? sp_plot_dispersion(t.files, t.shown, common->output, err)
                 : spectra->column   ? sp_plot_harmonic(t.files, t.shown, spectra->column, common->output, err)
                                     : sp_plot_spectrum(t.files, t.shown, common->output, err);
    plot_tables_free(&t);
    return status;
}
