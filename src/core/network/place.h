#ifndef SP_NETWORK_PLACE_H
#define SP_NETWORK_PLACE_H
/* Walls that are inclined to the axes of the box, and planes that contacts cross. */

#include <sonopack/network.h>

/* SP_EREFUSED if the walls are rings, or the normal of a spring at one is not vertical. `what` needs level walls,
 * because the axes of the box describe it: turned as a whole, a packing would give something else. */
sp_status sp_network_need_level_walls(const sp_network *net, const char *what, sp_error *err);

/* Whether a contact crosses the plane at a height: 1 upwards from i, -1 downwards, 0 not. The centre of i is at y, that
 * of j, or its image that touches i, is higher by `rise`; `other`: the height of j itself; j may be a wall. In a cell
 * without walls all images of the plane count. *low: how many of them the lower end is above, counted from the plane
 * itself. */
int sp_place_crossing(const sp_network *net, double height, double y, double rise, int32_t j, double other,
                      int32_t *low);

/* The springs through which a place acts: its row of sp_network_source_at (source) or sp_network_detector_at is minus
 * the sum over springs of E(gap, u), where E is the bilinear form of the spring's energy and gap [springs][3] a
 * displacement of its far end, 0 for springs that have no part in it. A source of velocities has this row times the
 * masses. A place that acts on grains, and not through springs, has none. The place must be one that these functions
 * accept. */
void sp_place_gaps(const sp_network *net, const sp_place *at, bool source, double *gap);

/* Whether a centre is in a disc (SP_PLACE_DISC). */
bool sp_place_in_disc(const sp_network *net, const sp_place *at, const double x[3]);

#endif
