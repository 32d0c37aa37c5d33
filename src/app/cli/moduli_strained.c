/* The table of moduli --strain: what a finite strain of the packing itself gives. */
#include "base/base.h"
#include "cli/moduli.h"

#include <math.h>

sp_status moduli_strained_columns(const sp_packing *p, sp_table *t, sp_error *err) {
    static const char *const plane[] = {"C11", "C12", "C22", "C33", NULL};
    static const char *const space[] = {"C11", "C12", "C13", "C22", "C23", "C33", "C44", "C55", "C66", NULL};
    static const char *const counts[] = {"sliding", "lost", "made"};
    sp_status status = sp_table_add_column(t, "file", "", SP_CELL_TEXT, err);
    if (status == SP_OK)
        status = sp_table_add_column(t, "p", "E*", SP_CELL_NUMBER, err);
    if (status == SP_OK)
        status = sp_table_add_column(t, "strain", "", SP_CELL_NUMBER, err);
    for (const char *const *name = p->dim == 3 ? space : plane; *name && status == SP_OK; name++)
        status = sp_table_add_column(t, *name, "E*", SP_CELL_NUMBER, err);
    for (int k = 0; k < 3 && status == SP_OK; k++)
        status = sp_table_add_column(t, counts[k], "", SP_CELL_INTEGER, err);
    if (status == SP_OK)
        status = sp_table_add_column(t, "residual", "", SP_CELL_NUMBER, err);
    return status;
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

sp_status moduli_strained_rows(const moduli_arguments *a, const char *path, const sp_packing *p, const sp_network *net,
                               sp_table *t, sp_error *err) {
    sp_status status = SP_OK;
    for (int k = 0; k < a->strains && status == SP_OK; k++) {
        sp_finite_strain_options o = sp_finite_strain_options_default();
        sp_finite_strain s;
        o.strain = a->strain[k];
        status = sp_moduli_finite_strain(p, net, NAN, &o, &s, err);
        if (status != SP_OK)
            sp_fail_prefix(err, "%s", path);
        else
            status = add_row(path, p, a->strain[k], &s, t, err);
        if (status == SP_OK && k == 0 && p->dim == 1)
            cli_note(&a->common, "%s: a chain has C22 alone, the others are nan", path);
        if (status == SP_OK && k == 0 && p->dim > 1 && isnan(p->dim == 3 ? s.moduli.c55 : s.moduli.c33))
            cli_note(&a->common, "%s: moduli of shear by the walls are nan: walls that do not grip cannot shear", path);
        if (status == SP_OK)
            cli_debug(&a->common, "%s: strain %g: %d solves, %d factors", path, a->strain[k], s.solves, s.factors);
    }
    return status;
}
