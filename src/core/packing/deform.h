#ifndef SP_DEFORM_H
#define SP_DEFORM_H
/* The cell of moving grains and its deformation.
 *
 * A deforming cell carries its grains and walls along: x' = v + L x with the velocity gradient L of strain_rate and
 * shear_rate, which is upper triangular, so that lattice vectors keep their form (sp_packing.tilt). v is the velocity
 * beyond that. Contacts feel the difference of v + L x between the two grains. */
#include "packing/grains.h"

/* Moves the walls and lattice vectors by dt. Returns a bound of the speed at which the strain alone moves two grains
 * that may touch. */
double sp_deform_cell(dynamics *d, double dt);
/* Brings the tilts to at most half of the edges, by other lattice vectors of the same lattice. The images of listed
 * pairs are not valid after this. */
void sp_deform_reduce(dynamics *d);
/* Keeps the cell in which the outer list is made, and carries a point along from this cell to the present one. */
void sp_deform_keep(dynamics *d);
void sp_deform_carry(const dynamics *d, double x[3]);
/* The boxes that `cells` divides: distances of opposite faces of the cell, and where a grain lies in it. Returns x
 * itself unless the cell may be tilted. */
void sp_deform_box(const dynamics *d, double box[3]);
const double *sp_deform_place(const dynamics *d, const double *x, double place[3]);

#endif
