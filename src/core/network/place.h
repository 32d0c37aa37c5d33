#ifndef SP_NETWORK_PLACE_H
#define SP_NETWORK_PLACE_H
/* Walls that are inclined to the axes of the box. */

#include <sonopack/network.h>

/* SP_EREFUSED if the normal of a spring at a wall is not vertical. `what` needs level walls, because the axes of the
 * box describe it: turned as a whole, a packing would give something else. */
sp_status sp_network_need_level_walls(const sp_network *net, const char *what, sp_error *err);

#endif
