/* Draws what each contact does to a quantity. */
#include "cli/plot_sensitivity.h"

#include "cli/plot_input.h"
#include "cli/sensitivity.h"

#include <sonopack/figure/plot.h>

/* The table of t10 by the contacts. */
static sp_status compute(const cli_common *common, const cli_file *file, sp_table *t, sp_error *err) {
    const sensitivity_arguments a = {.common = *common,
                                     .of = {.word = "t10", .front = SP_FRONT_T10},
                                     .by = SP_BY_KN | SP_BY_KT,
                                     .sources = {.sources = true}};
    sp_gradient g = sp_gradient_none();
    cli_writer w = {.table = t, .err = err, .status = sensitivity_compute(&a, file, &g, err)};
    cli_comment(&w, "quantity = %s", a.of.word);
    if (w.status == SP_OK)
        w.status = sensitivity_table(&a, file, &g, &w);
    sp_gradient_free(&g);
    return w.status;
}

sp_status plot_sensitivity(const cli_common *common, const sp_scene *scene, int files, char **file, sp_error *err) {
    cli_file made = {.path = file[0], .scene = scene, .packing = sp_packing_none(), .network = sp_network_none()};
    sp_table t = sp_table_none();
    sp_status status = cli_read_network(file[0], &scene->network, &made.packing, &made.network, err);
    if (status == SP_OK)
        status = files > 1 ? plot_read_table(file[1], &t, err) : compute(common, &made, &t, err);
    if (status == SP_OK)
        status = sp_plot_sensitivity(&made.packing, &t, scene->network.threshold, common->output, err);
    sp_table_free(&t);
    sp_network_free(&made.network);
    sp_packing_free(&made.packing);
    return status;
}
