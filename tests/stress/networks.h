#ifndef STRESS_NETWORKS_H
#define STRESS_NETWORKS_H
/* Networks that are hard on a solver: small enough for quadruple precision, made of scattered grains whose stiffnesses
 * and masses are changed at will, and real packings of few grains. Random numbers by a generator of its own, so that
 * every machine has the same. */

#include "network/bound.h"
#include "reference.h"

#include <sonopack/network.h>

typedef struct stress_case {
    const char *name;
    sp_network (*make)(double value, uint64_t seed);
    double value;
    double
        served; /* the least tolerance at which some method has to serve it, up to 1e5 periods; INFINITY: none has to */
} stress_case;

/* Uniform in 0 .. 1 (xorshift64*). */
static inline double stress_random(uint64_t *state) {
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return (double)(*state * 2685821657736338717u >> 11) * 0x1p-53;
}
static inline uint64_t stress_seed(uint64_t seed) { return seed * 0x9e3779b97f4a7c15u + 0x2545f4914f6cdd1du; }

static inline sp_network stress_network(sp_packing *p, bool prestress) {
    sp_network_options o = sp_network_options_default();
    sp_network net = sp_network_none();
    o.prestress = prestress;
    assert_ok(sp_network_make(p, &o, &net, &err));
    sp_packing_free(p);
    return net;
}

/* After springs or masses were changed. */
static inline sp_network stress_changed(sp_network net) {
    assert_ok(sp_network_find_bounds(&net, &err));
    return net;
}

/* Grains along a side in two dimensions; 4 for quadruple precision. */
static int stress_cells = 4;

static inline sp_network stress_scattered(int dim, double friction, bool prestress, uint64_t seed) {
    const int cells = dim == 2 ? stress_cells : stress_cells > 4 ? 5 : friction > 0 ? 2 : 3;
    sp_packing p = scattered_packing(dim, cells, friction, (unsigned)seed);
    return stress_network(&p, prestress);
}

/* Leaves out the springs that keep() refuses. */
static inline void stress_cut(sp_network *net, bool (*keep)(const sp_network *, const sp_spring *, uint64_t *),
                              uint64_t seed) {
    int32_t kept = 0, bulk = 0;
    uint64_t state = stress_seed(seed);
    for (int32_t k = 0; k < net->n_springs; k++)
        if (keep(net, &net->springs[k], &state)) {
            bulk += k < net->n_bulk;
            net->length[kept] = net->length[k];
            net->springs[kept++] = net->springs[k];
        }
    net->n_springs = kept;
    net->n_bulk = bulk;
}

static inline void stress_set_mass(sp_network *net, int32_t grain, double factor) {
    for (int d = 0; d < net->dof; d++)
        net->mass[grain * net->dof + d] *= factor;
}

/* ---- real packings ---------------------------------------------------------------------------------------------- */

static inline sp_packing stress_piston(double pressure, double friction, uint64_t seed) {
    sp_pack_spec spec = sp_pack_spec_default();
    sp_packing p = sp_packing_none();
    spec.grains = 20;
    spec.width = 4.9;
    spec.pressure = pressure;
    spec.friction = friction;
    spec.seed = seed;
    assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
    return p;
}
static inline sp_network stress_pressure(double pressure, uint64_t seed) {
    sp_packing p = stress_piston(pressure, 0.5, seed);
    return stress_network(&p, false);
}
static inline sp_network stress_smooth(double pressure, uint64_t seed) {
    sp_packing p = stress_piston(pressure, 0, seed);
    return stress_network(&p, false);
}
static inline sp_network stress_prestressed(double pressure, uint64_t seed) {
    sp_packing p = without_tangential(stress_piston(pressure, 0.5, seed));
    return stress_network(&p, true);
}
static inline sp_network stress_lattice(double friction, uint64_t seed) {
    sp_pack_spec spec = sp_pack_spec_default();
    sp_packing p = sp_packing_none();
    spec.kind = SP_PACK_TRIANGULAR;
    spec.grains = 16;
    spec.width = 4;
    spec.friction = friction;
    spec.pressure = 1e-6;
    spec.seed = seed;
    assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
    return stress_network(&p, false);
}

/* ---- scattered grains ------------------------------------------------------------------------------------------- */

static inline sp_network stress_plain(double dim, uint64_t seed) {
    return stress_scattered((int)dim, 0.5, false, seed);
}
static inline sp_network stress_frictionless(double dim, uint64_t seed) {
    return stress_scattered((int)dim, 0, false, seed);
}

static inline sp_network stress_ratio(double ratio, uint64_t seed) {
    sp_network net = stress_scattered(2, 0.5, false, seed);
    for (int32_t k = 0; k < net.n_springs; k++)
        net.springs[k].kt = ratio * net.springs[k].kn;
    return stress_changed(net);
}
static inline sp_network stress_ratio_3d(double ratio, uint64_t seed) {
    sp_network net = stress_scattered(3, 0.5, false, seed);
    for (int32_t k = 0; k < net.n_springs; k++)
        net.springs[k].kt = ratio * net.springs[k].kn;
    return stress_changed(net);
}

/* Stiffnesses spread evenly over so many decades. */
static inline sp_network stress_spread(double decades, uint64_t seed) {
    sp_network net = stress_scattered(2, 0.5, false, seed);
    uint64_t state = stress_seed(seed);
    for (int32_t k = 0; k < net.n_springs; k++) {
        const double factor = pow(10, decades * (stress_random(&state) - 0.5));
        net.springs[k].kn *= factor;
        net.springs[k].kt *= factor;
    }
    return stress_changed(net);
}
static inline sp_network stress_masses(double decades, uint64_t seed) {
    sp_network net = stress_scattered(2, 0.5, false, seed);
    uint64_t state = stress_seed(seed);
    for (int32_t i = 0; i < net.n; i++)
        stress_set_mass(&net, i, pow(10, decades * (stress_random(&state) - 0.5)));
    return stress_changed(net);
}
/* Rotations of nearly no inertia, or of much. */
static inline sp_network stress_inertia(double factor, uint64_t seed) {
    sp_network net = stress_scattered(2, 0.5, false, seed);
    for (int32_t i = 0; i < net.n; i++)
        net.mass[i * net.dof + 2] *= factor;
    return stress_changed(net);
}
/* Stiffnesses and masses spread at once. */
static inline sp_network stress_both(double decades, uint64_t seed) {
    sp_network net = stress_spread(decades, seed);
    uint64_t state = stress_seed(seed + 1);
    for (int32_t i = 0; i < net.n; i++)
        stress_set_mass(&net, i, pow(10, 6 * (stress_random(&state) - 0.5)));
    return stress_changed(net);
}

static inline bool stress_keep_half(const sp_network *net, const sp_spring *s, uint64_t *state) {
    (void)net;
    return s->j < 0 || stress_random(state) < 0.4;
}
static inline sp_network stress_floppy(double friction, uint64_t seed) {
    sp_network net = stress_scattered(2, friction, false, seed);
    stress_cut(&net, stress_keep_half, seed);
    return stress_changed(net);
}
static inline bool stress_keep_one(const sp_network *net, const sp_spring *s, uint64_t *state) {
    const bool touches = s->i == net->n / 2 || s->j == net->n / 2;
    *state += touches;
    return !touches || *state % 2 == 0;
}
/* A grain in the middle that hangs on a few springs of this stiffness, the others being of order 1. */
static inline sp_network stress_nearly_floppy(double stiffness, uint64_t seed) {
    sp_network net = stress_scattered(2, 0.5, false, seed);
    stress_cut(&net, stress_keep_one, 2 * seed);
    for (int32_t k = 0; k < net.n_springs; k++)
        if (net.springs[k].i == net.n / 2 || net.springs[k].j == net.n / 2) {
            net.springs[k].kn = stiffness;
            net.springs[k].kt = stiffness;
        }
    return stress_changed(net);
}
/* Smooth grains, which slide along the walls freely but for one tangential spring. */
static inline sp_network stress_one_spring(double stiffness, uint64_t seed) {
    sp_network net = stress_scattered(2, 0.5, false, seed);
    for (int32_t k = 0; k < net.n_springs; k++)
        net.springs[k].kt = k == net.n_springs - 1 ? stiffness : 0;
    return stress_changed(net);
}

static inline sp_network stress_chain(double grains, uint64_t seed) {
    (void)seed;
    sp_packing p = chain_packing((int)grains, 1e-4);
    return stress_network(&p, false);
}
/* A chain whose middle link has this share of the others' stiffness; 0: it is not there. */
static inline sp_network stress_weak_link(double share, uint64_t seed) {
    sp_network net = stress_chain(24, seed);
    for (int32_t k = 0; k < net.n_bulk; k++)
        if (net.springs[k].i == 11) {
            net.springs[k].kn *= share;
            if (share == 0) {
                memmove(&net.springs[k], &net.springs[k + 1], (size_t)(net.n_springs - k - 1) * sizeof *net.springs);
                memmove(&net.length[k], &net.length[k + 1], (size_t)(net.n_springs - k - 1) * sizeof *net.length);
                net.n_springs--;
                net.n_bulk--;
            }
            break;
        }
    return stress_changed(net);
}
/* Chains side by side, all the same: every frequency many times. */
static inline sp_network stress_chains(double count, uint64_t seed) {
    enum { LONG = 8 };
    (void)seed;
    sp_packing p = chains_packing((int)count, LONG, 1e-4);
    return stress_network(&p, false);
}
static inline bool stress_keep_apart(const sp_network *net, const sp_spring *s, uint64_t *state) {
    (void)state;
    return s->j < 0 || (s->i < net->n / 2) == (s->j < net->n / 2);
}
/* The lower and the upper half of a scattered packing, with nothing between. */
static inline sp_network stress_apart(double dim, uint64_t seed) {
    sp_network net = stress_scattered((int)dim, 0.5, false, seed);
    stress_cut(&net, stress_keep_apart, seed);
    return stress_changed(net);
}
static inline sp_network stress_one_grain(double dim, uint64_t seed) {
    sp_packing p = sp_packing_none();
    if (dim < 2)
        return stress_chain(1, seed);
    p = scattered_packing((int)dim, 1, 0.5, 1); /* a size that touches both walls */
    return stress_network(&p, false);
}

static inline sp_network stress_scattered_prestress(double scale, uint64_t seed) {
    sp_network net = stress_scattered(2, 0.5, true, seed);
    for (int32_t k = 0; k < net.n_springs; k++)
        net.springs[k].kp *= scale;
    return stress_changed(net);
}
/* Nothing but prestress acts sideways: motion grows. */
static inline sp_network stress_unstable(double scale, uint64_t seed) {
    sp_network net = stress_scattered(2, 0, true, seed);
    for (int32_t k = 0; k < net.n_springs; k++)
        net.springs[k].kp *= scale;
    return stress_changed(net);
}

/* Mechanisms that prestress alone acts on: a slow growth. */
static inline sp_network stress_slowly_unstable(double scale, uint64_t seed) {
    sp_network net = stress_scattered(2, 0, true, seed);
    stress_cut(&net, stress_keep_half, seed);
    for (int32_t k = 0; k < net.n_springs; k++)
        net.springs[k].kp *= scale;
    return stress_changed(net);
}

static const stress_case stress_cases[] = {
    {"p = 1e-9", stress_pressure, 1e-9, true},
    {"p = 1e-8", stress_pressure, 1e-8, true},
    {"p = 1e-6", stress_pressure, 1e-6, true},
    {"p = 1e-4", stress_pressure, 1e-4, true},
    {"p = 1e-2", stress_pressure, 1e-2, true},
    {"p = 1e-9, frictionless", stress_smooth, 1e-9, true},
    {"p = 1e-2, frictionless", stress_smooth, 1e-2, true},
    {"p = 1e-9, prestress", stress_prestressed, 1e-9, true},
    {"p = 1e-4, prestress", stress_prestressed, 1e-4, true},
    {"p = 1e-2, prestress", stress_prestressed, 1e-2, true},
    {"2D", stress_plain, 2, 1e-10},
    {"3D", stress_plain, 3, 1e-10},
    {"3D, frictionless", stress_frictionless, 3, 1e-10},
    {"kt/kn = 1e3", stress_ratio, 1e3, 1e-10},
    {"kt/kn = 1e6", stress_ratio, 1e6, 1e-10},
    {"kt/kn = 1e-3", stress_ratio, 1e-3, 1e-10},
    {"kt/kn = 1e-6", stress_ratio, 1e-6, 1e-10},
    {"kt/kn = 1e6, 3D", stress_ratio_3d, 1e6, 1e-10},
    {"kt/kn = 1e-6, 3D", stress_ratio_3d, 1e-6, 1e-10},
    {"stiffness spread 1e3", stress_spread, 3, 1e-10},
    {"stiffness spread 1e6", stress_spread, 6, 1e-9},
    {"stiffness spread 1e12", stress_spread, 12, INFINITY},
    {"mass spread 1e3", stress_masses, 3, 1e-10},
    {"mass spread 1e6", stress_masses, 6, 1e-10},
    {"stiffness spread 1e6, mass spread 1e6", stress_both, 6, INFINITY},
    {"stiffness spread 1e12, mass spread 1e6", stress_both, 12, INFINITY},
    {"inertia x 1e-6", stress_inertia, 1e-6, 1e-9},
    {"inertia x 1e6", stress_inertia, 1e6, 1e-10},
    {"floppy", stress_floppy, 0.5, 1e-10},
    {"floppy, frictionless", stress_floppy, 0, 1e-10},
    {"nearly floppy 1e-6", stress_nearly_floppy, 1e-6, 1e-10},
    {"nearly floppy 1e-12", stress_nearly_floppy, 1e-12, 1e-10},
    {"one spring of 1e-12 sideways", stress_one_spring, 1e-12, 1e-10},
    {"chain", stress_chain, 40, 1e-10},
    {"six equal chains", stress_chains, 6, 1e-10},
    {"lattice", stress_lattice, 0.5, 1e-10},
    {"lattice, frictionless", stress_lattice, 0, 1e-10},
    {"weak link 1e-6", stress_weak_link, 1e-6, 1e-9},
    {"weak link 1e-12", stress_weak_link, 1e-12, INFINITY},
    {"chain in two parts", stress_weak_link, 0, 1e-10},
    {"two halves, 2D", stress_apart, 2, 1e-10},
    {"two halves, 3D", stress_apart, 3, 1e-10},
    {"one grain, 1D", stress_one_grain, 1, 1e-10},
    {"one grain, 2D", stress_one_grain, 2, 1e-10},
    {"one grain, 3D", stress_one_grain, 3, 1e-10},
    {"prestress, a tenth", stress_scattered_prestress, 0.1, 1e-10},
    {"unstable", stress_unstable, 1, INFINITY},
    {"unstable, rate 1e-4", stress_slowly_unstable, 1e-6, INFINITY},
    {"unstable, rate 1e-8", stress_slowly_unstable, 1e-14, INFINITY},
};
enum { STRESS_CASES = sizeof stress_cases / sizeof *stress_cases };

#endif
