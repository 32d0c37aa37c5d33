#ifndef SP_MAKING_H
#define SP_MAKING_H
/* What the makers of packings share inside the room. */

#include <sonopack/packing.h>

/* The spec with its "default rule" zeros replaced: diameters of the kind, tolerance of the pressure. */
sp_pack_spec sp_pack_spec_resolve(const sp_pack_spec *given);

/* Ordered packings, exact in closed form. Specs below are checked and resolved. */
sp_status sp_chain_make(const sp_pack_spec *spec, sp_packing *out, sp_error *err);
sp_status sp_triangular_make(const sp_pack_spec *spec, sp_packing *out, sp_error *err);
/* Gas, piston, equilibrium (2D). */
sp_status sp_piston_make(const sp_pack_spec *spec, sp_pack_watch watch, void *user, sp_packing *out, sp_error *err);

/* Diameters of all grains: uniform in [diameter_min, diameter_max], drawn from the stream SP_STREAM_DIAMETERS. */
void sp_radii_draw(const sp_pack_spec *spec, double *r);
/* A random gas of non-overlapping grains in [0, width) x (0, *height), at the area fraction of the spec (2D);
 * x is [n][3]. SP_EFAILED if there is no room. */
sp_status sp_gas_make(const sp_pack_spec *spec, const double *r, double *x, double *height, sp_error *err);

#endif
