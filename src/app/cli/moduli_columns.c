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
