#ifndef SP_PLOT_UNITS_H
#define SP_PLOT_UNITS_H
/* Figures in SI. */

#include "cli/cli.h"

/* Reads --units of `plot': finds the material of the files, before any of them is drawn. SP_EINVAL for --units si if
 * the figure has units that are not those of a table. `arguments` begin with a cli_common. */
sp_status plot_units_choose(void *arguments, bool drawn_from_tables, const char *kind, sp_error *err);
/* Figures are in SI from now on, with this material, which must outlive them. */
void plot_units_show(const sp_material *m);
/* The material with which figures are in SI; NULL: they are in our own units. */
const sp_material *plot_units_material(void);
/* Converts a table that is to be drawn, if figures are in SI. */
sp_status plot_units_convert(sp_table *t, sp_error *err);

#endif
