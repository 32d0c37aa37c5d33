#ifndef SP_NETWORK_PLACE_H
#define SP_NETWORK_PLACE_H
/* Walls that are inclined to the axes of the box, and planes that contacts cross. */

#include <sonopack/network.h>

/* SP_EREFUSED if the normal of a spring at a wall is not vertical. `what` needs level walls, because the axes of the
 * box describe it: turned as a whole, a packing would give something else. */
sp_status sp_network_need_level_walls(const sp_network *net, const char *what, sp_error *err);

/* Whether a contact crosses the plane at a height: 1 upwards from i, -1 downwards, 0 not. The centre of i is at y, that
 * of j, or its image that touches i, is higher by `rise`; `other`: the height of j itself; j may be a wall. In a cell
 * without walls all images of the plane count. *low: how many of them the lower end is above, counted from the plane
 * itself. */
int sp_place_crossing(const sp_network *net, double height, double y, double rise, int32_t j, double other,
                      int32_t *low);

#endif
