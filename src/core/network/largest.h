#ifndef SP_LARGEST_H
#define SP_LARGEST_H

#include <sonopack/network.h>

/* The largest eigenfrequency, from below, by Lanczos's recursion: exact in small networks, to some 1e-4 in perfect
 * lattices, whose frequencies crowd at the edge. Where K is not symmetric: of its symmetric part. */
sp_status sp_network_find_largest(const sp_network *net, double *omega, sp_error *err);

#endif
