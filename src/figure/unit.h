#ifndef SP_FIGURE_UNIT_H
#define SP_FIGURE_UNIT_H
/* Units of the columns of tables, as markup for axes. */

#include <sonopack/figure/plot.h>

enum { UNIT_MARKUP = 200 };

/* Units of sonopack's own, as its tables write them. */
#define UNIT_LENGTH    "d"
#define UNIT_PRESSURE  "E*"
#define UNIT_SPEED     "sqrt(E* / rho)"
#define UNIT_TIME      "d/sqrt(E* / rho)"
#define UNIT_FREQUENCY "sqrt(E* / rho)/d"
#define UNIT_FORCE     "E* d^2"
#define UNIT_WAVE      "1/d"

/* A unit as markup: "sqrt(E* / rho)" as (E asterisk/rho)^{1/2}; units of other tables with their exponents raised. */
void sp_unit_markup(const char *unit, char out[UNIT_MARKUP]);
/* "name  [unit]" as markup; without unit the name alone. unit: as in a table. */
const char *sp_unit_label(const char *name, const char *unit, char *out, size_t size);
/* The square or the reciprocal of a unit, as markup. */
void sp_unit_square(const char *unit, char out[UNIT_MARKUP]);
void sp_unit_inverse(const char *unit, char out[UNIT_MARKUP]);

/* The unit that a column has in all tables, as the tables write it; `own' if none of them names one. Tables without the
 * column do not count. SP_EINVAL if two of them differ. *out points to a table or to `own'. */
sp_status sp_unit_common(int tables, const sp_plot_table *table, const char *column, const char *own, const char **out,
                         sp_error *err);
/* Whether two units are written alike but for blanks. */
bool sp_unit_same(const char *a, const char *b);

#endif
