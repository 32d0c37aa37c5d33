#ifndef SP_BOUND_H
#define SP_BOUND_H

#include <sonopack/network.h>

/* Puts in the bounds: of the largest eigenfrequency, of the antisymmetric part, of how far prestress softens. */
sp_status sp_network_find_bounds(sp_network *net, sp_error *err);

#endif
