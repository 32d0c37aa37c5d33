#ifndef SP_NETWORK_CELL_H
#define SP_NETWORK_CELL_H
/* The cell of a network: its periods and its volume, as of the packing it was made from. */

#include <sonopack/network.h>

/* Whether the network repeats along an axis 0 .. dim-1. */
bool sp_network_periodic(const sp_network *net, int axis);
/* Volume of the cell [d^3]; in fewer dimensions the other edges count as 1. */
double sp_network_volume(const sp_network *net);
/* Adds `periods` lattice vectors of an axis to x. */
void sp_network_move(const sp_network *net, int axis, double periods, double x[3]);
/* How many lattice vectors lead from the centre of j to its image that touches i; 0 along axes with walls. */
void sp_network_image(const sp_network *net, int32_t spring, int32_t periods[3]);
/* Reciprocal lattice vector b of an axis: its product with that lattice vector is 1, with the others 0. A wave with the
 * wave vector 2 pi n b fits into the cell. */
void sp_network_reciprocal(const sp_network *net, int axis, double b[3]);
/* SP_EREFUSED in a cell without flat walls. `what` needs them. */
sp_status sp_network_need_walls(const sp_network *net, const char *what, sp_error *err);

#endif
