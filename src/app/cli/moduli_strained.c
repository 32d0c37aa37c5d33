/* Fills the table of sonopack moduli --strain: moduli of a packing at a finite strain. */
#include "base/base.h"
#include "cli/moduli.h"

#include <math.h>

void moduli_strained_columns(cli_writer *w, int dim) {
    cli_columns(w, SP_CELL_NUMBER, "strain", "", NULL);
    moduli_columns(w, dim);
    cli_columns(w, SP_CELL_INTEGER, "sliding", "", "lost", "", "made", "", NULL);
    cli_columns(w, SP_CELL_NUMBER, "residual", "", NULL);
}

static sp_status add_row(const char *path, const sp_packing *p, double strain, const sp_finite_strain *s, sp_table *t,
                         sp_error *err) {
    const sp_moduli *m = &s->moduli;
    const int64_t sliding = s->sliding, lost = s->lost, made = s->made;
    if (p->dim == 3)
        return sp_table_add_row(t, err, path, p->pressure, strain, m->c11, m->c12, m->c13, m->c22, m->c23, m->c33,
                                m->c44, m->c55, m->c66, sliding, lost, made, s->residual);
    return sp_table_add_row(t, err, path, p->pressure, strain, m->c11, m->c12, m->c22, m->c33, sliding, lost, made,
                            s->residual);
}

sp_status moduli_strained_rows(const moduli_arguments *a, const cli_file *file, sp_table *t, sp_error *err) {
    const sp_packing *p = &file->packing;
    sp_status status = SP_OK;
    for (int k = 0; k < a->strains && status == SP_OK; k++) {
        sp_finite_strain_options o = sp_finite_strain_options_default();
        sp_finite_strain s;
        o.strain = a->strain[k];
        status = sp_moduli_finite_strain(p, &file->network, NAN, &o, &s, err);
        if (status == SP_OK)
            status = add_row(file->path, p, o.strain, &s, t, err);
        if (status != SP_OK)
            return status;
        if (k == 0 && p->dim == 1)
            cli_note(&a->common, "%s: a chain has only C22; the other moduli are nan", file->path);
        if (k == 0 && moduli_no_shear(p->dim, &s.moduli))
            cli_note(&a->common, "%s: shear moduli are nan: walls without friction cannot shear a packing", file->path);
        cli_debug(&a->common, "%s: strain %g: %d solves, %d factorisations", file->path, o.strain, s.solves, s.factors);
    }
    return status;
}
