#ifndef SP_INERTIA_H
#define SP_INERTIA_H
/* Steps longer than the stiffest grains allow. A step of length dt is stable for a grain if
 *
 *     z = (largest viscous rate) dt + (largest frequency dt)^2/2 < 2.
 *
 * With dynamics.long_steps the mass and the moment of inertia of a grain whose z is too large are multiplied by as much
 * as this takes. Each row of the equations of motion is divided by its own factor, so a bound of each row bounds the
 * whole (Gershgorin). Packings at rest do not depend on it. Both grow by the same factor: with a larger one for the
 * moment of inertia, which the bounds of a single contact would suggest, packings with friction were 0.4% looser.
 *
 * u = dt/m times the sum of s = sqrt(m_eff k_n) over the contacts, as dynamics.rate. share: the sum of s^2 over the
 * square of that sum, 1 over the number of contacts if they are equally stiff. */

#include <stdbool.h>

/* packing.time_step above which steps count as long: shorter ones are stable for every grain as it is. */
#define SP_LONG_STEP 0.8

/* Without friction: normal motion of a pair. 4 zeta u and 2 share u^2 are strict bounds. */
static inline double inertia_smooth(double zeta, double u, double share) {
    const double z = u * (4 * zeta + 2 * share * u) * (1 / 1.9);
    return z > 1 ? z : 1;
}

/* With friction the largest viscous rate in packings is 6.25 zeta u (measured, within 5%), but 14 zeta u where two
 * grains with one contact slip on each other, and 10 zeta u where all disks of a lattice turn in the same sense. */
static inline double inertia_rough(double zeta, double u, double share, int dim) {
    const double viscous = dim == 2 ? 10 + 4 * share : 6.25 + 8.5 * share;
    const double z = u * (viscous * zeta + (0.5 + 6.5 * share * share) * u) * (1 / 1.7);
    return z > 1 ? z : 1;
}

static inline double inertia_factor(double zeta, double u, double share, int dim, bool rough) {
    return rough ? inertia_rough(zeta, u, share, dim) : inertia_smooth(zeta, u, share);
}

#endif
