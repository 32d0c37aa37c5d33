/* Finds the material of the files that a figure shows. */
#include "base/base.h"
#include "cli/plot_input.h"
#include "cli/plot_units.h"
#include "cli/trace.h"

sp_status plot_units_choose(void *arguments, bool drawn_from_tables, const char *kind, sp_error *err) {
    cli_common *common = arguments;
    if (common->units != CLI_UNITS_SI && common->quantities == 0)
        return SP_OK;
    if (common->units == CLI_UNITS_SI && !drawn_from_tables)
        return sp_fail(err, SP_EINVAL, "--units si: a figure of %s is drawn in d, E* and rho", kind);
    sp_status status = SP_OK;
    for (int k = 0; k < common->files && status == SP_OK; k++) {
        bool packing = false;
        sp_packing p = sp_packing_none();
        sp_table t = sp_table_none();
        status = cli_is_packing(common->file[k], &packing, err);
        if (status == SP_OK)
            status = packing ? sp_packing_read(common->file[k], &p, err) : plot_read_table(common->file[k], &t, err);
        if (status == SP_OK)
            status = packing ? cli_take_material(arguments, &p.material, common->file[k], err)
                             : cli_take_table_material(arguments, &t, common->file[k], err);
        sp_packing_free(&p);
        sp_table_free(&t);
    }
    if (status == SP_OK && common->files == 0)
        status = cli_take_material(arguments, &(sp_material){0}, "the store", err);
    if (status != SP_OK || common->units != CLI_UNITS_SI)
        return status;
    plot_units_show(cli_material(common));
    return SP_OK;
}
