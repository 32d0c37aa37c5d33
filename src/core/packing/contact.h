#ifndef SP_CONTACT_H
#define SP_CONTACT_H
/* Contact law of Somfai et al. 2005, Appendix A, in units where E* = 1 for a grain. */

#include <math.h>
#include <sonopack/packing.h>
#include <stdbool.h>

/* E12 sqrt(R12) of two grains, with 1/E12 = 1/E* + 1/E* and 1/R12 = 1/R1 + 1/R2. */
static inline double contact_stiffness(double r1, double r2) { return 0.5 * sqrt(r1 * r2 / (r1 + r2)); }

/* The same at a wall: a rigid plane (R = inf, E12 = E* of one grain), a plane of the same material (E12 = half of E*),
 * or a fixed identical grain. */
static inline double contact_wall_stiffness(double r, sp_wall wall) {
    if (wall == SP_WALL_GRAIN)
        return contact_stiffness(r, r);
    return wall == SP_WALL_RIGID ? sqrt(r) : 0.5 * sqrt(r);
}

/* E12 sqrt(R12) of a contact of a packing. */
static inline double contact_stiffness_in(const sp_packing *p, int32_t i, int32_t j) {
    return j < 0 ? contact_wall_stiffness(p->r[i], p->wall) : contact_stiffness(p->r[i], p->r[j]);
}

/* Hertz's law (A1), F_n = 4/3 E12 sqrt(R12) n^(3/2), for e = E12 sqrt(R12) and overlap n >= 0. */
static inline double contact_force(double e, double overlap) { return 4.0 / 3.0 * e * overlap * sqrt(overlap); }

/* Normal stiffness k_n = dF_n/dn = 2 E12 sqrt(R12 n). */
static inline double contact_normal_stiffness(double e, double overlap) { return 2.0 * e * sqrt(overlap); }

/* n^a without pow where a is a multiple of 1/2, so that packings are the same on all machines. */
static inline double contact_power(double overlap, double a) {
    const int halves = (int)(2 * a);
    if (2 * a != halves)
        return pow(overlap, a);
    double product = halves % 2 == 0 ? 1 : sqrt(overlap);
    for (int k = 0; k < halves / 2; k++)
        product *= overlap;
    return product;
}

/* Of the law F = c n^a between two grains: c = 4/3 E12 R12^(2 - a), which is Hertz's for a = 3/2. */
static inline double contact_strength(double r1, double r2, double a) {
    const double r = r1 * r2 / (r1 + r2);
    return 2.0 / 3.0 * r * r / contact_power(r, a);
}

/* Overlap for a given force. */
static inline double contact_overlap(double e, double force) { return pow(0.75 * force / e, 2.0 / 3.0); }

/* Stiffness ratio eta = k_t/k_n = (1 - nu)/(1 - nu/2), (A4). */
static inline double contact_eta(double poisson) { return (1.0 - poisson) / (1.0 - 0.5 * poisson); }

/* k_n of a contact at rest: its own, or Hertz's at its overlap. */
static inline double contact_kn(const sp_packing *p, const sp_contact *c) {
    return c->kn > 0 ? c->kn : contact_normal_stiffness(contact_stiffness_in(p, c->i, c->j), fmax(c->overlap, 0.0));
}

/* Coulomb's coefficient of a contact: its own, or the packing's. */
static inline double contact_mu(const sp_packing *p, const sp_contact *c) { return c->mu > 0 ? c->mu : p->friction; }

/* Whether a contact of a packing with friction carries no tangential force, as between some materials. */
static inline bool contact_smooth(const sp_contact *c) { return c->kn > 0 && !(c->kt > 0); }

/* Mass m = pi d^3/6 at unit density. The moment of inertia is m d^2/10 = 0.4 m R^2. */
static inline double grain_mass(double r) { return 4.0 / 3.0 * 3.14159265358979323846 * r * r * r; }
static inline double grain_inertia(double r) { return grain_mass(r) * (0.4 * r * r); }

#endif
