#ifndef SP_DYNAMICS_H
#define SP_DYNAMICS_H
/* Motion of grains in a cell in 2D and 3D: forces, one time step, and measures of equilibrium. The compression
 * protocol is in piston.c. */

#include "packing/grains.h"

/* Creates grains at rest at x [n][3] with radii r, in the spec's cell with this edge along the up axis. Its lattice
 * vectors have no tilt. SP_ENOMEM. */
sp_status sp_dynamics_make(const sp_pack_spec *spec, const double *r, const double *x, double height, dynamics *out,
                           sp_error *err);
void sp_dynamics_free(dynamics *d);

/* Computes the forces at the current positions and velocities. Tangential springs stretch by the relative velocity
 * times dt_past, the length of the last step. The lists must be up to date. */
void sp_dynamics_forces(dynamics *d, double dt_past);
/* Advances velocities and positions by dt (leapfrog: velocities lag half a step behind positions). */
void sp_dynamics_advance(dynamics *d, double dt);

/* Last force on a grain, and torque/R (2D: turn[0]). */
void sp_dynamics_force_on(const dynamics *d, int32_t i, double force[3], double turn[3]);
/* Mean elastic pressure along the horizontal axis a (0 or 1): sum of F_a r_a over the pairs, divided by the volume. */
double sp_dynamics_lateral_pressure(const dynamics *d, int a);
/* Mean elastic stress: sum of F_a r_b over the contacts, walls included, divided by the volume; compression is
 * positive. Order: xx yy zz yz xz xy; 0 on unused axes, and xy in [5] also in 2D. The lists must be up to date. */
void sp_dynamics_stress(const dynamics *d, double stress[6]);
/* Largest acceleration of a grain (angular: times R) or the piston at the last forces, including viscous ones. Infinite
 * while the grains carry less than half of the piston's load; without a piston, of the pressure. */
double sp_dynamics_acceleration(const dynamics *d);
/* Distance from equilibrium: the largest acceleration by elastic forces and weight alone, and the difference between
 * the elastic pressure on the piston and p (0 without a piston). The lists must be up to date. SP_ENOMEM. */
sp_status sp_dynamics_residual(const dynamics *d, double *residual, double *wall_imbalance, sp_error *err);
/* Whether all numbers are finite, no grain has passed a wall, and no overlap exceeds 0.8 radii. */
bool sp_dynamics_sane(const dynamics *d);

#endif
