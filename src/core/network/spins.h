#ifndef SP_SPINS_H
#define SP_SPINS_H
/* Spheres with two contacts: they turn about the line through both, and no spring resists. */

#include <sonopack/network.h>

/* The springs of a grain, and the first two contact points from its centre. */
typedef struct sp_spin {
    int32_t springs;
    double at[2][3];
} sp_spin;

/* [n]; NULL where grains have no three rotations. */
sp_status sp_spins_make(const sp_network *net, sp_spin **out, sp_error *err);
/* Whether the grain spins, and the line about which. */
bool sp_spin_axis(const sp_spin *grain, double axis[3]);
/* Sum over the spins of |work| of the forces f, a vector over the network, on a turn of one. */
double sp_spin_work(const sp_network *net, const sp_spin *spin, const double *f);

#endif
