#ifndef SP_PLOT_SETTINGS_H
#define SP_PLOT_SETTINGS_H
/* What the comments of tables say that a legend repeats. */

#include <sonopack/figure/plot.h>
#include <stddef.h>

enum { SETTINGS_LABEL = 160 };

/* What tells table j from the others, as markup: the keys of a scene ("packing.friction = 0.5") and of the line
 * "pressure = ..., friction = ..." whose values differ, where every table has them and no two tables are alike in all;
 * else its own label, of at most so many characters. */
void sp_settings_label(int tables, const sp_plot_table *table, int j, int most, char out[SETTINGS_LABEL]);

/* "95% interval" from the comment that says "interval at level 0.95", as markup; "interval" without one. */
void sp_settings_interval(const sp_table *t, char *out, size_t size);

#endif
