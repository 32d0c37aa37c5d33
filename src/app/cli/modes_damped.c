/* Fills the table of sonopack modes --damping: decaying modes of a network with dashpots. */
#include "cli/modes.h"

sp_status modes_damped(const sp_packing *p, const sp_network *net, double zeta, sp_source source, sp_table *t,
                       sp_error *err) {
    sp_damped_modes m = sp_damped_modes_none();
    cli_writer w = {.table = t, .err = err, .status = sp_damped_modes_make(net, zeta, source, &m, err)};
    cli_columns(&w, SP_CELL_INTEGER, "n", "", NULL);
    cli_columns(&w, SP_CELL_NUMBER, "omega", MODES_FREQUENCY, "decay", MODES_FREQUENCY, "cosine", "E* d^2", "sine",
                "E* d^2", "error", MODES_FREQUENCY, NULL);
    cli_value(&w, "pressure", p->pressure);
    cli_value(&w, "damping", zeta);
    cli_comment(&w, "source = %s", cli_source_names[source]);
    cli_comment(&w, "residual = %.3g", m.residual);
    for (int64_t k = 0; k < m.n && w.status == SP_OK; k++)
        w.status = sp_table_add_row(t, err, k, m.omega[k], m.decay[k], m.cosine[k], m.sine[k], m.error[k]);
    sp_damped_modes_free(&m);
    return w.status;
}
