/* Fills the table of sonopack spectrum continuum: the lowest modes and those of a homogeneous elastic strip. */
#include "cli/spectrum.h"

static void add_columns(cli_writer *w) {
    cli_columns(w, SP_COLUMN_INTEGER, "n", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "omega", SPECTRUM_FREQUENCY, NULL);
    cli_columns(w, SP_COLUMN_INTEGER, "n1", "", "n2", "", NULL);
    cli_columns(w, SP_COLUMN_TEXT, "branch", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "omega_plane", SPECTRUM_FREQUENCY, "omega_continuum", SPECTRUM_FREQUENCY, "ratio",
                "", "overlap", "", NULL);
}

sp_status spectrum_continuum(const spectrum_arguments *a, cli_file *file, sp_table *t, sp_error *err) {
    const double threshold = 1e-4, margin = 3;
    sp_continuum c = sp_continuum_none();
    sp_statics s;
    cli_writer w = {.table = t, .err = err, .status = sp_statics_make(&file->packing, threshold, margin, &s, err)};
    double density;
    if (w.status == SP_OK)
        w.status = sp_packing_density(&file->packing, threshold, margin, &density, err);
    if (w.status == SP_OK)
        w.status = sp_continuum_make(&file->network, density, a->lowest < 0 ? 12 : (int32_t)a->lowest,
                                     (sp_modes_solver)a->solver, &c, err);
    if (w.status != SP_OK)
        return w.status;
    cli_value(&w, "Phi3s", s.phi3s);
    cli_value(&w, "C11", c.moduli.c11);
    cli_value(&w, "C12", c.moduli.c12);
    cli_value(&w, "C22", c.moduli.c22);
    cli_value(&w, "C33", c.moduli.c33);
    add_columns(&w);
    for (int32_t k = 0; k < c.n && w.status == SP_OK; k++) {
        const sp_continuum_row *row = &c.row[k];
        const int64_t n1 = row->n1, n2 = row->n2;
        w.status = sp_table_add_row(t, err, row->n, row->omega, n1, n2, row->fast ? "+" : "-", row->omega_plane,
                                    row->omega_continuum, row->omega / row->omega_continuum, row->overlap);
    }
    sp_continuum_free(&c);
    return w.status;
}
