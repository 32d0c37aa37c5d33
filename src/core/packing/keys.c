/* The table of the keys of a packing. */
#include "packing/keys.h"

#include <sonopack/packing.h>

#define AT(member) offsetof(sp_pack_spec, member)

const sp_key sp_pack_keys[] = {
    {"packing.kind", SP_KEY_WORD, AT(kind), 0, "", 0, SP_PACK_FILE, false},
    {"packing.dimension", SP_KEY_INT, AT(dim), 0, "", 1, 3, false},
    {"packing.grains", SP_KEY_INT, AT(grains), 0, "", 1, 1e8, false},
    {"packing.width", SP_KEY_REAL, AT(width), 0, "d", 0.01, 1e6, false},
    {"packing.depth", SP_KEY_REAL, AT(depth), 0, "d", 0, 1e6, false},
    {"packing.pressure", SP_KEY_REAL, AT(pressure), 0, "E*", 1e-10, 1e-2, false},
    {"packing.friction", SP_KEY_REAL, AT(friction), 0, "", 0, 1e6, false},
    {"packing.poisson", SP_KEY_REAL, AT(poisson), 0, "", 0, 0.5, false},
    {"packing.sizes", SP_KEY_WORD, AT(sizes), 0, "", 0, SP_SIZES_LIST, false},
    {"packing.diameter_min", SP_KEY_REAL, AT(diameter_min), 0, "d", 0.01, 100, true},
    {"packing.diameter_max", SP_KEY_REAL, AT(diameter_max), 0, "d", 0.01, 100, true},
    {"packing.large_fraction", SP_KEY_REAL, AT(large_fraction), 0, "", 0, 1, false},
    {"packing.size_spread", SP_KEY_REAL, AT(size_spread), 0, "", 0, 2, false},
    {"packing.compression", SP_KEY_WORD, AT(compression), 0, "", 0, SP_COMPRESSION_ISOTROPIC, false},
    {"packing.protocol", SP_KEY_WORD, AT(protocol), 0, "", 0, SP_PROTOCOL_QUICK, false},
    {"packing.reference", SP_KEY_BOOL, AT(reference), 0, "", 0, 1, false},
    {"packing.seed", SP_KEY_INT64, AT(seed), 0, "", 0, 0x1p64, false},
    {"packing.tolerance", SP_KEY_REAL, AT(tolerance), 0, "E* / (rho d)", 0, 1, false},
    {"packing.damping", SP_KEY_REAL, AT(damping), 0, "critical", 1e-3, 2, true},
    /* a lighter piston is pushed about by single grains, a heavier one oscillates long after they have come to rest */
    {"packing.piston_mass", SP_KEY_REAL, AT(piston_mass), 0, "rho d", 0.1, 1e4, true},
    {"packing.gas_fraction", SP_KEY_REAL, AT(gas_fraction), 0, "", 0.01, 0.45, true},
    {"packing.time_step", SP_KEY_REAL, AT(time_step), 0, "of the largest stable one", 1e-3, 0.8, true},
    {"packing.calm", SP_KEY_REAL, AT(calm), 0, "p", -1, 100, false},
    {"packing.drag", SP_KEY_REAL, AT(drag), 0, "sqrt(E* / rho)/d", -1, 0.1, false},
    {"packing.viscous_limit", SP_KEY_REAL, AT(viscous_limit), 0, "", 1, 1e6, true},
    {"packing.calm_damping", SP_KEY_REAL, AT(calm_damping), 0, "critical", 1e-3, 2, true},
    {"packing.max_steps", SP_KEY_INT64, AT(max_steps), 0, "", 0, 1e15, false},
    {"packing.content", SP_KEY_INT64, AT(content), 0, "", 0, 0x1p64, false},
    {"packing.diameters", SP_KEY_REALS, AT(diameters), AT(diameter_count), "d", 0.01, 100, false},
    {"packing.history", SP_KEY_REALS, AT(history), AT(history_count), "E*", 1e-10, 1e-2, false},
    {NULL, SP_KEY_REAL, 0, 0, "", 0, 0, false}};
