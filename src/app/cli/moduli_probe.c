/* Fills the table of sonopack moduli --probe: apparent moduli on smaller scales. */
#include "base/base.h"
#include "cli/moduli.h"

#include <math.h>

void moduli_probe_columns(cli_writer *w, const moduli_arguments *a, int dim) {
    if (a->probes > 1)
        cli_columns(w, SP_CELL_TEXT, "probe", "", NULL);
    if (dim == 3)
        cli_columns(w, SP_CELL_NUMBER, "C33", "E*", "C55", "E*", "C33_ratio", "", "C55_ratio", "", NULL);
    else
        cli_columns(w, SP_CELL_NUMBER, "C22", "E*", "C33", "E*", "C22_ratio", "", "C33_ratio", "", NULL);
}

/* Notes of one probe. */
static void explain_probe(const moduli_arguments *a, const cli_file *file, const char *probe,
                          const sp_probe_moduli *m) {
    if (file->packing.dim > 1 && isnan(m->shear))
        cli_note(&a->common, "%s: %s of %s is nan: grains slip along a wall without friction", file->path,
                 file->packing.dim == 3 ? "C55" : "C33", probe);
    if (m->concentrated > 0.25)
        cli_note(&a->common,
                 "%s: %s: grain %d, which is loosely held, has %.2g of the elastic energy: these are not moduli of the "
                 "packing",
                 file->path, probe, m->grain, m->concentrated);
    if (m->left_out > 0)
        cli_note(&a->common,
                 "%s: %s: %.2g of the squared body force is left out, because it acts on floppy parts, which no "
                 "contact holds",
                 file->path, probe, m->left_out);
}

/* Notes why values of the rows are nan, and which moduli are not to be trusted. */
static void explain(const moduli_arguments *a, const cli_file *file, const sp_moduli *global,
                    const sp_probe_moduli *each) {
    const int dim = file->packing.dim;
    if (dim == 1)
        cli_note(&a->common, "%s: a chain has only C22; C33 is nan", file->path);
    else if (moduli_no_shear(dim, global))
        cli_note(&a->common,
                 "%s: %s of the global strain and ratios to it are nan: walls without friction cannot shear a packing; "
                 "sine:N uses cosines for the shear instead, which exert no shear on the walls",
                 file->path, dim == 3 ? "C55" : "C33");
    for (int k = 0; k < a->probes; k++)
        if (!a->probe[k].global)
            explain_probe(a, file, a->probe[k].text, &each[k]);
}

sp_status moduli_probe_rows(const moduli_arguments *a, const cli_file *file, double density, sp_table *t,
                            sp_error *err) {
    sp_probe probe[MODULI_PROBES_MAX];
    sp_probe_moduli measured[MODULI_PROBES_MAX], each[MODULI_PROBES_MAX];
    sp_moduli m;
    int32_t count = 0, at = 0;
    for (int k = 0; k < a->probes; k++)
        if (!a->probe[k].global)
            probe[count++] = a->probe[k].probe;
    sp_status status = sp_moduli_probe(&file->network, density, count, probe, &m, measured, err);
    if (status != SP_OK)
        return status;
    const bool space = file->packing.dim == 3;
    const double along = space ? m.c33 : m.c22, shear = space ? m.c55 : m.c33, p = file->packing.pressure;
    for (int k = 0; k < a->probes; k++)
        each[k] = a->probe[k].global ? (sp_probe_moduli){.along = along, .shear = shear} : measured[at++];
    explain(a, file, &m, each);
    for (int k = 0; k < a->probes && status == SP_OK; k++) {
        const double l = each[k].along, s = each[k].shear, s_ratio = shear > 0 ? s / shear : NAN;
        status = a->probes > 1 ? sp_table_add_row(t, err, file->path, p, a->probe[k].text, l, s, l / along, s_ratio)
                               : sp_table_add_row(t, err, file->path, p, l, s, l / along, s_ratio);
    }
    return status;
}
