#ifndef SONOPACK_UNITS_H
#define SONOPACK_UNITS_H
/* Units: from the program's own, which are d, E* and rho, to SI and back.
 *
 * A unit is a text. It has the symbols E*, rho and d of our own units, and m, g, s, N, Pa, bar and rad with the
 * prefixes n, u, m, c, k, M and G; powers (m^2), sqrt(...), products (blanks) and quotients (/), as in "E* / (rho d^2)"
 * or "kg/m^3". A table in SI has one unit for each dimension: mm, us, m/s, rad/s, N, kPa, mg, ... (docs/units.md). */

#include <sonopack/packing.h>
#include <sonopack/table.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { SP_UNIT_TEXT = 40 }; /* as sp_column has */

/* Whether a text is a unit with one of the symbols E*, rho and d. */
SP_API bool sp_unit_is_ours(const char *unit);

/* The SI unit that tables have for one of our units, and the factor: a number in our unit times the factor is the
 * number in SI. SP_EINVAL if the text is none of our units. */
SP_API sp_status sp_unit_to_si(const char *unit, const sp_material *m, double *factor, char si[SP_UNIT_TEXT],
                               sp_error *err);

/* Reads a number with a unit, such as "100 kPa" or "20mm", and gives it in another unit. SP_EINVAL if the unit is
 * missing, unknown or of another dimension, or if it needs a material and the material is not known (NULL, or E = 0).
 */
SP_API sp_status sp_quantity_read(const char *text, const char *unit, const sp_material *m, double *out, sp_error *err);

/* Converts a table to SI: its columns, and the numbers in those comments that the program itself writes. A number in a
 * comment is followed by its unit then, as in "height = 24.7 mm". Columns in other units, and without any, stay as they
 * are. Adds the comment "material = ..." if there is none. SP_EINVAL if the material is not known; the table is
 * unchanged after a failure, unless it is SP_ENOMEM. */
SP_API sp_status sp_table_to_si(sp_table *t, const sp_material *m, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
