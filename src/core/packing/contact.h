#ifndef SP_CONTACT_H
#define SP_CONTACT_H
/* Contact law of Somfai et al. 2005, Appendix A, in units where E* = 1 for a grain. */

#include <math.h>
#include <sonopack/packing.h>

/* E12 sqrt(R12) of two grains, with 1/E12 = 1/E* + 1/E* and 1/R12 = 1/R1 + 1/R2. */
static inline double contact_stiffness(double r1, double r2) { return 0.5 * sqrt(r1 * r2 / (r1 + r2)); }

/* The same at a wall: a rigid plane (R = inf, E12 = E* of one grain), or a fixed identical grain. */
static inline double contact_wall_stiffness(double r, sp_wall wall) {
    return wall == SP_WALL_RIGID ? sqrt(r) : contact_stiffness(r, r);
}

/* Hertz's law (A1), F_n = 4/3 E12 sqrt(R12) n^(3/2), for e = E12 sqrt(R12) and overlap n >= 0. */
static inline double contact_force(double e, double overlap) { return 4.0 / 3.0 * e * overlap * sqrt(overlap); }

/* Normal stiffness k_n = dF_n/dn = 2 E12 sqrt(R12 n). */
static inline double contact_normal_stiffness(double e, double overlap) { return 2.0 * e * sqrt(overlap); }

/* Overlap for a given force. */
static inline double contact_overlap(double e, double force) { return pow(0.75 * force / e, 2.0 / 3.0); }

/* Stiffness ratio eta = k_t/k_n = (1 - nu)/(1 - nu/2), (A4). */
static inline double contact_eta(double poisson) { return (1.0 - poisson) / (1.0 - 0.5 * poisson); }

/* Mass m = pi d^3/6 at unit density. The moment of inertia is m d^2/10 = 0.4 m R^2. */
static inline double grain_mass(double r) { return 4.0 / 3.0 * 3.14159265358979323846 * r * r * r; }

#endif
