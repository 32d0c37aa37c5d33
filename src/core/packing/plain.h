#ifndef SP_PLAIN_H
#define SP_PLAIN_H
/* The reference path of `packing.reference = true`: the same model as the kernel, one pair after the other in plain
 * scalar code over all pairs that are near, square roots by the library, forces added where they fall. */
#include "packing/dynamics.h"

/* As sp_dynamics_forces and sp_dynamics_advance, which call these when d->plain is set. */
void sp_plain_forces(dynamics *d, double dt_past);
void sp_plain_advance(dynamics *d, double dt);

#endif
