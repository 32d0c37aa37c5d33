#include "cli/modes_damped.h"

#include "base/base.h"
#include "cli/springs.h"

sp_status cli_damped_modes(const sp_packing *p, const sp_network *net, double zeta, sp_source source, sp_table *t,
                           sp_error *err) {
    static const char *const names[] = {"omega", "decay", "cosine", "sine", "error"};
    const int count = sizeof names / sizeof *names;
    char number[SP_NUMBER_TEXT];
    sp_damped_modes m = sp_damped_modes_none();
    sp_status status = sp_damped_modes_make(net, zeta, source, &m, err);
    if (status == SP_OK)
        status = sp_table_add_column(t, "n", "", SP_CELL_INTEGER, err);
    for (int k = 0; k < count && status == SP_OK; k++)
        status =
            sp_table_add_column(t, names[k], k == 2 || k == 3 ? "E* d^2" : "sqrt(E* / rho)/d", SP_CELL_NUMBER, err);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "pressure = %s", sp_number_text(p->pressure, number));
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "damping = %s", sp_number_text(zeta, number));
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "source = %s", cli_source_name(source));
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "residual = %.3g", m.residual);
    for (int64_t k = 0; k < m.n && status == SP_OK; k++)
        status = sp_table_add_row(t, err, k, m.omega[k], m.decay[k], m.cosine[k], m.sine[k], m.error[k]);
    sp_damped_modes_free(&m);
    return status;
}
