#ifndef SP_BOUND_H
#define SP_BOUND_H

#include <sonopack/network.h>

/* An upper bound of the largest eigenfrequency. */
sp_status sp_network_find_bound(const sp_network *net, double *omega, sp_error *err);

#endif
