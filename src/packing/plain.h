#ifndef SP_PLAIN_H
#define SP_PLAIN_H
/* The reference path of `packing.reference = true`: the same model as the kernel, one pair after the other in plain
 * scalar code over all pairs that are near, square roots by the library, forces added where they fall. */
#include "packing/dynamics.h"

/* As dynamics_forces and dynamics_advance, which call these when d->plain is set. */
void plain_forces(dynamics *d, double dt_past);
void plain_advance(dynamics *d, double dt);

#endif
