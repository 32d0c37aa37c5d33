/* Fills the table of sonopack modes --damping: decaying modes of a network with dashpots. */
#include "cli/excitation.h"
#include "cli/modes.h"

sp_status modes_damped(const sp_packing *p, const sp_network *net, const sp_damping *law, sp_source source, sp_table *t,
                       sp_error *err) {
    sp_damped_modes m = sp_damped_modes_none();
    cli_writer w = {.table = t, .err = err, .status = sp_damped_modes_with(net, law, source, &m, err)};
    cli_columns(&w, SP_COLUMN_INTEGER, "n", "", NULL);
    cli_columns(&w, SP_COLUMN_NUMBER, "omega", MODES_FREQUENCY, "decay", MODES_FREQUENCY, "cosine", "E* d^2", "sine",
                "E* d^2", "error", MODES_FREQUENCY, "Q", "", "Q_err", "", NULL);
    cli_value(&w, "pressure", p->pressure);
    cli_damping_comment(&w, law);
    cli_comment(&w, "source = %s", cli_source_names[source]);
    cli_comment(&w, "residual = %.3g", m.residual);
    for (int64_t k = 0; k < m.n && w.status == SP_OK; k++) {
        double q, q_error;
        sp_damped_modes_quality(&m, k, &q, &q_error);
        w.status = sp_table_add_row(t, err, k, m.omega[k], m.decay[k], m.cosine[k], m.sine[k], m.error[k], q, q_error);
    }
    sp_damped_modes_free(&m);
    return w.status;
}
