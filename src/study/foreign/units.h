#ifndef SP_FOREIGN_UNITS_H
#define SP_FOREIGN_UNITS_H
/* Packings in SI units, for files of other programs. */

#include <sonopack/packing.h>

/* What a number of a packing is multiplied by, and the names of the units. */
typedef struct sp_export_units {
    double length, mass, density, force, stress, stiffness;
    const char *length_name, *mass_name, *force_name, *stress_name, *stiffness_name;
    const char *all; /* "d, E*, rho" or "SI" */
} sp_export_units;

/* Of a material, or with NULL the packing's own. */
sp_export_units sp_export_units_of(const sp_material *si);
/* Makes a copy in other units, in which all contacts have stiffnesses of their own. SP_ENOMEM. */
sp_status sp_export_convert(const sp_packing *p, const sp_export_units *u, sp_packing *out, sp_error *err);

#endif
