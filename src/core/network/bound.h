#ifndef SP_BOUND_H
#define SP_BOUND_H

#include <sonopack/network.h>

/* Sets omega_bound, skew and soft of a network (see sp_network_omega_bound). SP_ENOMEM. */
sp_status sp_network_find_bounds(sp_network *net, sp_error *err);

/* Largest eigenfrequency, approached from below by the Lanczos recursion. Exact in small networks, and accurate to
 * about 1e-4 in perfect lattices, whose frequencies are dense at the upper edge. If K is not symmetric: of its
 * symmetric part. SP_ENOMEM. */
sp_status sp_network_find_largest(const sp_network *net, double *omega, sp_error *err);

#endif
