/* Adds the columns of elastic moduli to a table. */
#include "cli/moduli.h"

#include <math.h>

bool moduli_no_shear(int dim, const sp_moduli *m) { return dim > 1 && isnan(dim == 3 ? m->c55 : m->c33); }

void moduli_columns(cli_writer *w, int dim) {
    if (dim == 3)
        cli_columns(w, SP_CELL_NUMBER, "C11", "E*", "C12", "E*", "C13", "E*", "C22", "E*", "C23", "E*", "C33", "E*",
                    "C44", "E*", "C55", "E*", "C66", "E*", NULL);
    else
        cli_columns(w, SP_CELL_NUMBER, "C11", "E*", "C12", "E*", "C22", "E*", "C33", "E*", NULL);
}

void moduli_whole_columns(cli_writer *w, int dim) {
    if (dim == 3)
        cli_columns(w, SP_CELL_NUMBER, "C14", "E*", "C15", "E*", "C16", "E*", "C24", "E*", "C25", "E*", "C26", "E*",
                    "C34", "E*", "C35", "E*", "C36", "E*", "C45", "E*", "C46", "E*", "C56", "E*", NULL);
    else
        cli_columns(w, SP_CELL_NUMBER, "C13", "E*", "C23", "E*", NULL);
    cli_columns(w, SP_CELL_NUMBER, "K", "E*", "K_err", "E*", "G", "E*", "G_err", "E*", "anisotropy", "",
                "anisotropy_err", "", "C_err", "E*", NULL);
}

static double largest_error(const sp_elasticity *e) {
    double largest = 0;
    for (int a = 0; a < e->strains; a++)
        for (int b = 0; b < e->strains; b++)
            largest = fmax(largest, e->error[a][b]);
    return largest;
}

sp_status moduli_whole_row(const char *path, double pressure, const sp_moduli *m, const sp_elasticity *e, sp_table *t,
                           sp_error *err) {
    const double most = largest_error(e);
    if (e->strains == SP_STRAINS_MAX)
        return sp_table_add_row(t, err, path, pressure, m->c11, m->c12, m->c13, m->c22, m->c23, m->c33, m->c44, m->c55,
                                m->c66, m->c_l, m->c_t, e->c[0][3], e->c[0][4], e->c[0][5], e->c[1][3], e->c[1][4],
                                e->c[1][5], e->c[2][3], e->c[2][4], e->c[2][5], e->c[3][4], e->c[3][5], e->c[4][5],
                                e->bulk, e->bulk_error, e->shear, e->shear_error, e->anisotropy, e->anisotropy_error,
                                most);
    return sp_table_add_row(t, err, path, pressure, m->c11, m->c12, m->c22, m->c33, m->c_l, m->c_t, e->c[0][2],
                            e->c[1][2], e->bulk, e->bulk_error, e->shear, e->shear_error, e->anisotropy,
                            e->anisotropy_error, most);
}
