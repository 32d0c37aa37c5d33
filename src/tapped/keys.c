/* The table of the keys of the tapped column. */
#include "tapped/keys.h"

#include <sonopack/tapped/tapped.h>

#define AT(member) offsetof(sp_tapped_spec, member)

const sp_key sp_tapped_keys[] = {
    {"column.particles", SP_KEY_INT, AT(particles), 0, "", 1, 1e6, false},
    {"column.frequency", SP_KEY_REAL, AT(frequency), 0, "Hz", 1e-6, 1e9, false},
    {"column.period", SP_KEY_REAL, AT(period), 0, "s", 1e-9, 1e9, false},
    {"column.taps", SP_KEY_INT, AT(taps), 0, "", 0, 1e8, false},
    {"column.amplitude", SP_KEY_REAL, AT(amplitude), 0, "cm", 0, 1e6, false},
    {"column.e", SP_KEY_REAL, AT(e), 0, "", 0, 1, false},
    {"column.stiffness", SP_KEY_REAL, AT(stiffness), 0, "g/s^2", 0, 1e30, false},
    {"column.gravity", SP_KEY_REAL, AT(gravity), 0, "cm/s^2", 1e-9, 1e9, false},
    {"column.drop", SP_KEY_REAL, AT(drop), 0, "cm", -1, 1e6, false},
    {"column.mass", SP_KEY_REALS, AT(mass), AT(masses), "g", 1e-12, 1e12, false},
    {"column.radius", SP_KEY_REALS, AT(radius), AT(radii), "cm", 1e-12, 1e12, false},
    {"column.model", SP_KEY_WORD, AT(model), 0, "", 0, SP_TAPPED_EQ37, false},
    {"column.method", SP_KEY_WORD, AT(method), 0, "", 0, SP_TAPPED_RK4, false},
    {"column.bsr", SP_KEY_WORD, AT(bsr), 0, "", 0, SP_TAPPED_BSR_SIGNED, false},
    {"column.output", SP_KEY_WORD, AT(output), 0, "", 0, SP_TAPPED_COMPARE, false},
    {"column.step", SP_KEY_REAL, AT(step), 0, "s", 0, 1e9, false},
    {"column.alpha_v", SP_KEY_REAL, AT(alpha_v), 0, "s/cm", 1e-9, 1e9, false},
    {"column.alpha_x", SP_KEY_REAL, AT(alpha_x), 0, "1/cm", 0, 1e12, false},
    {"column.time_step", SP_KEY_REAL, AT(time_step), 0, "s", 0, 1e9, false},
    {"column.tolerance", SP_KEY_REAL, AT(tolerance), 0, "", 1e-14, 0.1, false},
    {"column.cells", SP_KEY_INT, AT(cells), 0, "", 1, 1000, false},
    {"column.parameter", SP_KEY_WORD, AT(parameter), 0, "", 0, SP_TAPPED_BY_RESTITUTION, false},
    {"column.from", SP_KEY_REAL, AT(from), 0, "", 0, 1e9, false},
    {"column.to", SP_KEY_REAL, AT(to), 0, "", 0, 1e9, false},
    {"column.points", SP_KEY_INT, AT(points), 0, "", 1, 1e8, false},
    {"column.transient", SP_KEY_INT, AT(transient), 0, "", 0, 1e8, false},
    {NULL, SP_KEY_REAL, 0, 0, "", 0, 0, false}};
