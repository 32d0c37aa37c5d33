/* Draws histograms of contacts. */
#include "cli/plot_packing.h"

#include "base/base.h"
#include "cli/plot_input.h"
#include "cli/trace.h"

#include <math.h>

#define MARGIN 3.0 /* distance of the bulk from both walls [d] */

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
        status = cli_is_packing(file[0], &packing, err);
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
