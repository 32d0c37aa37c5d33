/* What --units si means for figures: tables are converted as they are read, and signals as they are computed. */
#include "cli/plot_units.h"

static const sp_material *shown; /* NULL: figures are in our own units */

void plot_units_show(const sp_material *m) { shown = m; }

const sp_material *plot_units_material(void) { return shown; }

sp_status plot_units_convert(sp_table *t, sp_error *err) { return shown ? sp_table_to_si(t, shown, err) : SP_OK; }
