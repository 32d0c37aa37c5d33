#include "cli/plot_spectrum.h"

#include "base/base.h"
#include "cli/plot_input.h"
#include "cli/plot_tables.h"
#include "cli/spectrum.h"

#include <math.h>
#include <string.h>

/* The table that `sonopack spectrum' would print. */
static sp_status packing_table(const char *path, const sp_scene *scene, bool waves, sp_table *t, sp_error *err) {
    const spectrum_arguments a = spectrum_arguments_default();
    sp_packing p = sp_packing_none();
    sp_network net = sp_network_none();
    sp_status status = cli_read_network(path, &scene->network, &p, &net, err);
    if (status == SP_EINVAL || status == SP_EREFUSED)
        status = err->status = SP_EFORMAT; /* the fault of the file, which is named */
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "spectrum = %s", waves ? "dispersion" : "dos");
    if (status == SP_OK)
        status = waves ? spectrum_dispersion(&a, &p, &net, t, err) : spectrum_dos(&a, &p, &net, t, err);
    sp_network_free(&net);
    sp_packing_free(&p);
    return status;
}

sp_status plot_spectrum_files(const cli_common *common, const sp_scene *scene, const plot_spectra *want,
                              sp_error *err) {
    const int files = want->files;
    char **file = want->file;
    sp_table *table = sp_alloc((size_t)files, sizeof *table);
    sp_plot_table *shown = sp_alloc((size_t)files, sizeof *shown);
    char(*name)[PLOT_NAME] = sp_alloc((size_t)files, sizeof *name);
    sp_status status = table && shown && name
                           ? SP_OK
                           : sp_fail_memory(err, (size_t)files * (sizeof *table + sizeof *shown + sizeof *name));
    for (int k = 0; k < files && status == SP_OK; k++) {
        bool packing = false;
        status = plot_is_packing(file[k], &packing, err);
        if (status == SP_OK)
            status = packing ? packing_table(file[k], scene, want->waves, &table[k], err)
                             : plot_read_table(file[k], &table[k], err);
        shown[k] = (sp_plot_table){plot_name(file[k], name[k]), &table[k]};
    }
    if (status == SP_OK)
        status = want->waves    ? sp_plot_dispersion(files, shown, common->output, err)
                 : want->column ? sp_plot_harmonic(files, shown, want->column, common->output, err)
                                : sp_plot_spectrum(files, shown, common->output, err);
    for (int k = 0; k < files && table; k++)
        sp_table_free(&table[k]);
    sp_free(name);
    sp_free(shown);
    sp_free(table);
    return status;
}

/* Mass-weighted to displacements. */
static sp_status mode_vector(const sp_network *net, const sp_modes *m, int64_t number, double *u, sp_error *err) {
    if (number >= m->n)
        return sp_fail(err, SP_EINVAL, "--mode %lld: must be one of the modes, 0 .. %lld", (long long)number,
                       (long long)m->n - 1);
    if (number < m->n_rattler)
        return sp_fail(err, SP_EREFUSED, "mode %lld is a rattler's: must be %lld or more", (long long)number,
                       (long long)m->n_rattler);
    const double *e = m->vectors + (number - m->n_rattler) * m->dofs;
    for (int64_t k = 0; k < m->dofs; k++)
        u[k] = e[k] / sqrt(net->mass[k]);
    return SP_OK;
}

/* The modes up to the wanted one, or up to the first that is no zero mode. */
static sp_status find_modes(const sp_network *net, int64_t number, sp_modes *m, sp_error *err) {
    enum { FEW = 8 };
    const sp_modes_options o = sp_modes_options_default();
    const int64_t rattlers = (int64_t)net->rattlers * net->dof, dofs = sp_network_dofs(net);
    int64_t count = number < 0 ? FEW : number - rattlers + 1;
    sp_status status = SP_OK;
    for (count = count < 1 ? 1 : count; status == SP_OK; count *= 2) {
        const bool every = count >= dofs;
        const sp_modes_range range = every ? sp_modes_range_all() : sp_modes_range_lowest(count);
        sp_modes_free(m);
        status = sp_modes_make(net, &o, &range, m, err);
        if (every || number >= 0 || (status == SP_OK && m->n > m->n_zero))
            break;
    }
    if (status == SP_OK && number < 0 && m->n == m->n_zero)
        status = sp_fail(err, SP_EREFUSED, "there is no mode but zero modes");
    return status;
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
        status = sp_fail(err, SP_EREFUSED, "a packing in 3 dimensions has no flat picture: must be in 1 or 2");
    if (status == SP_OK)
        status = find_modes(&net, number, &m, err);
    const int64_t mode = number >= 0 ? number : m.n_zero;
    if (status == SP_OK)
        status = mode_vector(&net, &m, mode, u, err);
    if (status == SP_OK)
        status = sp_plot_mode(&p, &net, u, mode, m.omega[mode], common->output, err);
    if (status != SP_OK)
        sp_fail_prefix(err, "%s", path);
out:
    sp_free(u);
    sp_modes_free(&m);
    sp_network_free(&net);
    sp_packing_free(&p);
    return status;
}
