#ifndef SP_NETWORK_APPLY_H
#define SP_NETWORK_APPLY_H
/* K applied to two vectors at once, and energies with what is needed to bound their rounding. */

#include <sonopack/network.h>

/* out += K u for two interleaved vectors, [n][dof][2] each, 16-byte aligned, not overlapping. */
void sp_network_add_pair(const sp_network *net, const double *restrict u, double *restrict out);

/* u^T K u and its rounding: |computed - exact| <= rounding for the given u and spring data. */
double sp_network_energy2_bound(const sp_network *net, const double *u, double *rounding);

#endif
