#ifndef SP_UNITS_UNIT_H
#define SP_UNITS_UNIT_H
/* A unit as powers of its symbols. All powers are twice what they are, because of square roots. */

#include <sonopack/units.h>

typedef struct sp_unit {
    int length, mass, time;         /* of m, kg and s */
    int ten;                        /* of ten: the prefixes */
    int modulus, density, diameter; /* of E*, rho and d */
    bool modes;                     /* counts modes: "modes d/sqrt(E* / rho)" */
} sp_unit;

/* False if the text is no unit. */
bool sp_unit_read(const char *text, sp_unit *out);
/* Whether two units measure the same. */
bool sp_unit_same_dimension(const sp_unit *a, const sp_unit *b);
/* Whether the unit has a symbol of the material. */
bool sp_unit_needs_material(const sp_unit *u);
/* A value in the unit a in the unit b, which must have the same dimension. */
double sp_unit_convert(double value, const sp_unit *a, const sp_unit *b, const sp_material *m);

/* What a table has as SI unit of this dimension; NULL if there is none. */
const char *sp_unit_si(const sp_unit *u);

#endif
