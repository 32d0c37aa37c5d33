/* sonopack spectrum continuum: the lowest modes beside those of a homogeneous elastic strip. */
#include "base/base.h"
#include "cli/spectrum.h"

#include <math.h>

static sp_status add_columns(sp_table *t, sp_error *err) {
    static const char *const last[] = {
        "omega_plane", SPECTRUM_FREQUENCY, "omega_continuum", SPECTRUM_FREQUENCY, "ratio", "", "overlap", "", NULL};
    sp_status status = sp_table_add_column(t, "n", "", SP_CELL_INTEGER, err);
    if (status == SP_OK)
        status = sp_table_add_column(t, "omega", SPECTRUM_FREQUENCY, SP_CELL_NUMBER, err);
    if (status == SP_OK)
        status = sp_table_add_column(t, "n1", "", SP_CELL_INTEGER, err);
    if (status == SP_OK)
        status = sp_table_add_column(t, "n2", "", SP_CELL_INTEGER, err);
    if (status == SP_OK)
        status = sp_table_add_column(t, "branch", "", SP_CELL_TEXT, err);
    return status == SP_OK ? cli_add_columns(t, last, err) : status;
}

sp_status spectrum_continuum(const spectrum_arguments *a, const sp_packing *p, const sp_network *net, sp_table *t,
                             sp_error *err) {
    const double margin = 3;
    sp_continuum c = sp_continuum_none();
    sp_statics s;
    sp_status status = sp_statics_make(p, 1e-4, margin, &s, err);
    if (status == SP_OK)
        status = sp_continuum_make(net, s.phi3s, a->lowest < 0 ? 12 : (int32_t)a->lowest, &c, err);
    if (status == SP_OK)
        status = cli_add_number(t, "Phi3s", s.phi3s, err);
    if (status == SP_OK)
        status = cli_add_number(t, "C11", c.moduli.c11, err);
    if (status == SP_OK)
        status = cli_add_number(t, "C12", c.moduli.c12, err);
    if (status == SP_OK)
        status = cli_add_number(t, "C22", c.moduli.c22, err);
    if (status == SP_OK)
        status = cli_add_number(t, "C33", c.moduli.c33, err);
    if (status == SP_OK)
        status = add_columns(t, err);
    for (int32_t k = 0; k < c.n && status == SP_OK; k++) {
        const sp_continuum_row *row = &c.row[k];
        const int64_t n1 = row->n1, n2 = row->n2;
        status = sp_table_add_row(t, err, row->n, row->omega, n1, n2, row->fast ? "+" : "-", row->omega_plane,
                                  row->omega_continuum, row->omega / row->omega_continuum, row->overlap);
    }
    sp_continuum_free(&c);
    return status;
}
