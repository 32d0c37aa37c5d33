#ifndef SP_SPINS_H
#define SP_SPINS_H
/* Spheres with exactly two contacts can rotate freely about the line through both contact points. */

#include <sonopack/network.h>

/* Number of springs of a grain, and its first two contact points relative to the centre. */
typedef struct sp_spin {
    int32_t springs;
    double at[2][3];
} sp_spin;

/* Collects the springs of all grains: *out is [n], or NULL if grains do not have three rotations. SP_ENOMEM. */
sp_status sp_spins_make(const sp_network *net, sp_spin **out, sp_error *err);
/* Whether the grain can rotate freely, and its axis (a unit vector). */
bool sp_spin_axis(const sp_spin *grain, double axis[3]);

#endif
