#ifndef SP_PLAIN_H
#define SP_PLAIN_H
/* Reference code for `packing.reference = true`. It has the same model as the kernel, but handles all listed pairs one
 * by one in plain scalar code, with library square roots, and adds forces directly. */
#include "packing/dynamics.h"

/* Reference versions of sp_dynamics_forces and sp_dynamics_advance. */
void sp_plain_forces(dynamics *d, double dt_past);
void sp_plain_advance(dynamics *d, double dt);

#endif
