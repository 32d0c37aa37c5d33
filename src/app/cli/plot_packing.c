/* Draws histograms of contacts and snapshots of the motion in packings. */
#include "cli/plot_packing.h"

#include "base/base.h"
#include "cli/files.h"
#include "cli/plot_input.h"

#include <math.h>

#define MARGIN 3.0 /* distance of the bulk from both walls [d] */

/* ---- contacts --------------------------------------------------------------------------------------------------- */

static sp_status count_files(const cli_common *common, const sp_scene *scene, int files, char **file,
                             sp_contact_counts *counts, sp_error *err) {
    sp_status status = SP_OK;
    for (int k = 0; k < files && status == SP_OK; k++) {
        sp_packing p = sp_packing_none();
        status = sp_packing_read(file[k], &p, err);
        if (status == SP_OK) {
            status = sp_contact_counts_add(counts, &p, scene->network.threshold, MARGIN, err);
            if (status == SP_EINVAL || status == SP_EREFUSED) {
                err->status = SP_EFORMAT; /* this file's fault */
                status = sp_fail_prefix(err, "%s", file[k]);
            }
        }
        sp_packing_free(&p);
        if (files > 1)
            cli_progress(common, "packings", (k + 1.0) / files, NAN);
    }
    cli_progress_end();
    return status;
}

sp_status plot_contacts(const cli_common *common, const sp_scene *scene, bool values, int files, char **file,
                        sp_error *err) {
    sp_contact_counts *counts = sp_alloc(1, sizeof *counts);
    sp_table t = sp_table_none();
    bool packing = true;
    sp_status status = counts ? SP_OK : sp_fail_memory(err, sizeof *counts);
    if (status == SP_OK && files == 1)
        status = plot_is_packing(file[0], &packing, err);
    if (status == SP_OK && !packing)
        status = plot_read_table(file[0], &t, err);
    if (status == SP_OK && packing) {
        status = count_files(common, scene, files, file, counts, err);
        if (status == SP_OK)
            status = values ? sp_contact_values_table(counts, &t, err) : sp_contact_angles_table(counts, &t, err);
    }
    if (status == SP_OK)
        status = values ? sp_plot_contact_values(&t, common->output, err) : sp_plot_angles(&t, common->output, err);
    sp_table_free(&t);
    sp_free(counts);
    return status;
}

/* ---- motion ----------------------------------------------------------------------------------------------------- */

sp_status plot_snapshot_file(const cli_common *common, const sp_scene *scene, const char *path, double time,
                             sp_error *err) {
    sp_packing p = sp_packing_none();
    sp_network net = sp_network_none();
    double *u = NULL, error = 0;
    sp_status status = cli_read_network(path, &scene->network, &p, &net, err);
    if (status != SP_OK)
        goto out;
    /* 80 at a height of 25 and p = 1e-4, as in Fig. 3 of Somfai et al. 2005 */
    const double t = time >= 0 ? time : 3.2 * sp_packing_height(&p) * pow(p.pressure / 1e-4, -1.0 / 6);
    u = sp_alloc((size_t)sp_network_dofs(&net), sizeof *u);
    status = u ? SP_OK : sp_fail_memory(err, (size_t)sp_network_dofs(&net) * sizeof *u);
    if (status == SP_OK && p.dim == 3)
        status = sp_fail(err, SP_EREFUSED, "only packings in one or two dimensions can be drawn");
    const sp_field_options spec = {.source = scene->signal.source, .times = 1, .t = &t, .threads = common->threads};
    if (status == SP_OK)
        status = sp_signal_field(&net, &spec, u, &error, err);
    if (status == SP_OK)
        status = sp_plot_snapshot(&p, &net, u, t, common->output, err);
    if (status == SP_OK)
        cli_debug(common, "displacements at t = %.6g, with errors of at most %.2g", t, error);
    else
        sp_fail_prefix(err, "%s", path);
out:
    sp_free(u);
    sp_network_free(&net);
    sp_packing_free(&p);
    return status;
}
