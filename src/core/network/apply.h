#ifndef SP_NETWORK_APPLY_H
#define SP_NETWORK_APPLY_H
/* K applied to two vectors at once, and energies with an error bound. */

#include <sonopack/network.h>

/* out += K u for two interleaved vectors [n][dof][2], 16-byte aligned and not overlapping. */
void sp_network_add_pair(const sp_network *net, const double *restrict u, double *restrict out);

/* Returns u^T K u with a bound of its rounding error for the given u and spring data. */
double sp_network_energy2_bound(const sp_network *net, const double *u, double *rounding);

#endif
