#ifndef SP_GEOMETRY_H
#define SP_GEOMETRY_H
/* Pairs of grains in a finished packing. */

#include <sonopack/packing.h>

/* Vector from grain i to the nearest image of grain j; 0 on unused axes. */
void sp_packing_separation(const sp_packing *p, int32_t i, int32_t j, double d[3]);
/* Distance from the centre of grain i to a wall of the packing. */
double sp_packing_wall_distance(const sp_packing *p, int32_t i, int32_t wall);
/* Unit vector from the centre of grain i to the nearest point of a wall. */
void sp_packing_wall_normal(const sp_packing *p, int32_t i, int32_t wall, double n[3]);
/* Distance of a point from the inner wall of a ring. */
double sp_ring_level(const double box[3], const double x[3]);
/* SP_EREFUSED where the walls are rings. `what` needs flat ones, or none. */
SP_SHARED sp_status sp_cell_need_flat(sp_cell cell, const char *what, sp_error *err);
/* Coordinates of a point in multiples of the lattice vectors: 0 .. 1 within the cell. */
SP_SHARED void sp_packing_fractions(const sp_packing *p, const double x[3], double s[3]);
/* Replaces the lattice vectors of a periodic cell by shorter ones of the same lattice: tilts within half of the edges
 * along x and y. */
void sp_packing_untilt(int dim, const double edge[2], double tilt[3]);
/* Moves a point into the cell along the periodic axes: its fractions become 0 <= s < 1. */
SP_SHARED void sp_packing_wrap(const sp_packing *p, double x[3]);
/* Replaces a vector by its shortest image: adds lattice vectors along the periodic axes. Exact for vectors whose image
 * is shorter than half of the shortest edge. */
SP_SHARED void sp_packing_nearest(const sp_packing *p, double d[3]);
/* Whether i < j, or i and a wall, are listed as a contact. The contacts are sorted. */
bool sp_packing_has_contact(const sp_packing *p, int32_t i, int32_t j);

typedef sp_status sp_pair_visit(int32_t i, int32_t j, void *user, sp_error *err);
/* Visits all pairs i < j whose surfaces are closer than the gap, and some others, from the bottom upwards; and every
 * grain with all walls of the packing. Returns the first error of a visit, or SP_ENOMEM. */
sp_status sp_packing_sweep(const sp_packing *p, double gap, sp_pair_visit *visit, void *user, sp_error *err);

/* Whether some contact has a stiffness of its own. */
SP_SHARED bool sp_packing_has_stiffnesses(const sp_packing *p);

/* Names of the walls SP_BOTTOM, SP_TOP, ... in files, by -1 - wall; ended by NULL. */
SP_SHARED extern const char *const sp_side_names[];
/* Names of cells, by sp_cell; ended by NULL. */
SP_SHARED extern const char *const sp_cell_names[];
/* Names of contact laws at walls, by sp_wall; ended by NULL. */
SP_SHARED extern const char *const sp_wall_names[];
/* Names of sp_packing.strain in tables. */
SP_SHARED extern const char *const sp_strain_names[SP_SERIES_STRAINS];
/* The wall of this name. False for any other word. */
SP_SHARED bool sp_wall_read(const char *word, sp_wall *out);

#endif
