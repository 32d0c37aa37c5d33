#ifndef SP_PLOT_SETTINGS_H
#define SP_PLOT_SETTINGS_H
/* Legend texts from the metadata of tables. */

#include <sonopack/figure/plot.h>
#include <stddef.h>

enum { SETTINGS_LABEL = 160 };

/* Labels table j by its own label if the reader named it, otherwise by the settings that differ between the tables, as
 * markup. Settings are the keys of a scene
 * ("packing.friction = 0.5") and of the line "pressure = ..., friction = ..." that all tables have. If two tables have
 * the same settings, the label is that of the table, at most `most` characters long. */
void sp_settings_label(int tables, const sp_plot_table *table, int j, int most, char out[SETTINGS_LABEL]);

/* The dimension that all tables name in their metadata; 0 if one names none, or another. */
int sp_settings_dimension(int tables, const sp_plot_table *table);

/* Writes "95% interval" as markup if the metadata state the level, otherwise "interval". */
void sp_settings_interval(const sp_table *t, char *out, size_t size);

#endif
