/* Draws spectra, dispersion relations and modes. */
#include "cli/plot_spectrum.h"

#include "base/base.h"
#include "cli/plot_input.h"
#include "cli/plot_tables.h"
#include "cli/spectrum.h"

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
    sp_network_free(&file.network);
    sp_packing_free(&file.packing);
    return w.status;
}

sp_status plot_spectrum_files(const cli_common *common, const sp_scene *scene, const plot_spectra *spectra,
                              sp_error *err) {
    plot_tables t;
    bool packing = false;
    sp_status status = plot_tables_alloc(spectra->files, spectra->file, &t, err);
    for (int k = 0; k < t.files && status == SP_OK; k++) {
        status = plot_is_packing(t.file[k], &packing, err);
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

/* Converts a mass-weighted mode, row `number` of the whole table, to displacements. */
static sp_status mode_vector(const sp_network *net, const sp_modes *m, int64_t number, double *u, sp_error *err) {
    const int64_t row = number - m->first;
    if (row >= m->n)
        return sp_fail(err, SP_EINVAL, "--mode %lld: must be in 0 .. %lld", (long long)number,
                       (long long)(m->first + m->n - 1));
    if (row < m->n_rattler)
        return sp_fail(err, SP_EREFUSED, "mode %lld belongs to a rattler: must be %lld or more", (long long)number,
                       (long long)m->n_rattler);
    const double *e = m->vectors + (row - m->n_rattler) * m->dofs;
    for (int64_t k = 0; k < m->dofs; k++)
        u[k] = e[k] / sqrt(net->mass[k]);
    return SP_OK;
}

/* Finds the modes up to this number, or the first that is not a zero mode if it is negative. */
static sp_status find_modes(const sp_network *net, int64_t number, sp_modes *m, sp_error *err) {
    const sp_modes_options o = sp_modes_options_default();
    const sp_modes_range all = sp_modes_range_all();
    const int64_t rattlers = (int64_t)net->rattlers * net->dof, dofs = sp_network_dofs(net);
    sp_modes_range range = sp_modes_range_lowest(number < rattlers ? 1 : number - rattlers + 1);
    sp_error reason = {0};
    range.zero = number >= 0;
    sp_status status = range.lowest > dofs ? SP_EINVAL : sp_modes_make(net, &o, &range, m, &reason);
    if (status == SP_EINVAL && number >= 0) /* there are not so many besides zero modes */
        return sp_modes_make(net, &o, &all, m, err);
    if (status == SP_EINVAL)
        return sp_fail(err, SP_EREFUSED, "there are only zero modes");
    return status == SP_OK ? SP_OK : sp_fail(err, status, "%s", reason.text);
}

sp_status plot_mode_file(const cli_common *common, const sp_scene *scene, const char *path, int64_t number,
                         sp_error *err) {
    sp_packing p = sp_packing_none();
    sp_network net = sp_network_none();
    sp_modes m = sp_modes_none();
    double *u = NULL;
    sp_status status = cli_read_network(path, &scene->network, &p, &net, err);
    if (status != SP_OK)
        goto out;
    u = sp_alloc((size_t)sp_network_dofs(&net), sizeof *u);
    status = u ? SP_OK : sp_fail_memory(err, (size_t)sp_network_dofs(&net) * sizeof *u);
    if (status == SP_OK && p.dim == 3)
        status = sp_fail(err, SP_EREFUSED, "only packings in one or two dimensions can be drawn");
    if (status == SP_OK)
        status = find_modes(&net, number, &m, err);
    const int64_t mode = number >= 0 ? number : m.first;
    if (status == SP_OK)
        status = mode_vector(&net, &m, mode, u, err);
    if (status == SP_OK)
        status = sp_plot_mode(&p, &net, u, mode, m.omega[mode - m.first], common->output, err);
    if (status != SP_OK)
        sp_fail_prefix(err, "%s", path);
out:
    sp_free(u);
    sp_modes_free(&m);
    sp_network_free(&net);
    sp_packing_free(&p);
    return status;
}
