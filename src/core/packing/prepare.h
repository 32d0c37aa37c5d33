#ifndef SP_PREPARE_H
#define SP_PREPARE_H
/* What the makers of packings share inside the room. */

#include <sonopack/packing.h>

/* The spec with everything that it leaves open filled in: limits of the diameters (for a list its extremes), depth,
 * tolerance of the pressure, and what the protocol decides. Resolving twice changes nothing. */
sp_pack_spec sp_pack_spec_resolve(const sp_pack_spec *given);

/* Ordered packings, exact in closed form. Specs below are checked and resolved. */
sp_status sp_chain_make(const sp_pack_spec *spec, sp_packing *out, sp_error *err);
/* Equal diameters only. */
sp_status sp_triangular_make(const sp_pack_spec *spec, sp_packing *out, sp_error *err);

/* Where the compression of a triangular lattice of unequal grains starts: radii, and the places of the perfect lattice
 * blown up until no grain can touch another or a wall. x is [n][3]; written on success only. */
typedef struct sp_lattice_start {
    double width, height; /* of the box that is blown up; the walls are at 0 and height */
    double width_end;     /* of the perfect lattice of grains with the same mean diameter at the pressure */
    double height_end;
} sp_lattice_start;
sp_status sp_triangular_start(const sp_pack_spec *spec, double *r, double *x, sp_lattice_start *out, sp_error *err);

/* Gas, piston, equilibrium. */
sp_status sp_piston_make(const sp_pack_spec *spec, const sp_pack_hooks *hooks, sp_packing *out, sp_error *err);

/* ---- sizes ----------------------------------------------------------------------------------------------------- */

/* Smallest and largest diameter that the law gives; of an empty list inf and 0. */
void sp_sizes_limits(const sp_pack_spec *spec, double *low, double *high);
/* The part of the whole lognormal law that lies within its limits. */
double sp_sizes_within(const sp_pack_spec *spec);
/* <d^k> of the law, k >= 0 (of a list: of the grains' own diameters), and what follows from it. */
double sp_sizes_moment(const sp_pack_spec *spec, int k);
double sp_sizes_mean_area(const sp_pack_spec *spec);
double sp_sizes_mean_volume(const sp_pack_spec *spec);
/* Grains so alike that they may lie in a lattice. */
bool sp_sizes_alike(const sp_pack_spec *spec);
/* Radii of all grains, random ones from the stream SP_STREAM_DIAMETERS. */
void sp_radii_draw(const sp_pack_spec *spec, double *r);

/* ---- gas ------------------------------------------------------------------------------------------------------- */

/* A random gas of non-overlapping grains at the gas fraction of the spec, between walls at 0 and *height on the last
 * axis and periodic on the others (2D and 3D); x is [n][3], zero where it is not written. SP_EFAILED if there is no
 * room. */
sp_status sp_gas_make(const sp_pack_spec *spec, const double *r, double *x, double *height, sp_error *err);
/* Bytes that it takes beside r and x. */
double sp_gas_memory(const sp_pack_spec *spec);

#endif
