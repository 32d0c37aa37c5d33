#ifndef SP_GEOMETRY_H
#define SP_GEOMETRY_H
/* Pairs of grains in a finished packing. */

#include <sonopack/packing.h>

/* Vector from grain i to the nearest image of grain j; 0 on unused axes. */
void sp_packing_separation(const sp_packing *p, int32_t i, int32_t j, double d[3]);
/* Whether i < j, or i and a wall, are listed as a contact. The contacts are sorted. */
bool sp_packing_has_contact(const sp_packing *p, int32_t i, int32_t j);

typedef sp_status sp_pair_visit(int32_t i, int32_t j, void *user, sp_error *err);
/* Visits all pairs i < j whose surfaces are closer than the gap, and some others, from the bottom upwards; and every
 * grain with j = SP_BOTTOM and SP_TOP. Returns the first error of a visit, or SP_ENOMEM. */
sp_status sp_packing_sweep(const sp_packing *p, double gap, sp_pair_visit *visit, void *user, sp_error *err);

/* Whether some contact has a stiffness of its own. */
SP_SHARED bool sp_packing_has_stiffnesses(const sp_packing *p);

/* Names of walls, by sp_wall; ended by NULL. */
SP_SHARED extern const char *const sp_wall_names[];
/* The wall of this name. False for any other word. */
SP_SHARED bool sp_wall_read(const char *word, sp_wall *out);

#endif
