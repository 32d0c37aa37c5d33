#ifndef SP_BOUND_H
#define SP_BOUND_H

#include <sonopack/network.h>

/* Sets omega_bound, skew and soft of a network (see sp_network_omega_bound). SP_ENOMEM. */
sp_status sp_network_find_bounds(sp_network *net, sp_error *err);

#endif
