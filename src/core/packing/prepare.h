#ifndef SP_PREPARE_H
#define SP_PREPARE_H
/* Internal interface of packing generation: resolved specs, size distributions, the initial gas, and the generators. */

#include "base/key.h"

#include <sonopack/packing.h>

/* All members of sp_pack_spec with their allowed ranges. Their order is that of the hash in a saved state. */
SP_SHARED extern const sp_key sp_pack_keys[];

/* Cells without a piston (cell_spec.c). The target stress, xx yy zz yz xz xy, which is p along the diagonal without
 * packing.stress; the rows of the resolve and the check; and the spec of the gas, with longer edges. */
void sp_stress_target(const sp_pack_spec *s, double target[6]);
/* Tensors as lists: SP_EINVAL unless a list has all components of the dimension; whether this one of xx yy zz yz xz xy
 * is among them; and the list written into these six. */
sp_status sp_tensor_check(const char *key, int dim, int32_t count, const double *list, sp_error *err);
bool sp_tensor_has(int dim, int component);
void sp_tensor_fill(int dim, int32_t count, const double *list, double tensor[6]);
void sp_cell_spec_resolve(sp_pack_spec *s);
/* s is `given`, resolved. For all cells: SP_EINVAL names what does not go with the cell. */
sp_status sp_cell_spec_check(const sp_pack_spec *given, const sp_pack_spec *s, sp_error *err);
/* About the edge along the up axis that belongs to the width and depth of a resolved spec. */
double sp_cell_spec_height(const sp_pack_spec *s);
sp_pack_spec sp_cell_spec_gas(const sp_pack_spec *s);

/* Paths of strain (stages.c): where a stage is, in multiples of the strain; this strain, xx yy zz yz xz xy; whether a
 * component is free to hold its stress; the rows of the check. */
double sp_path_place(const sp_pack_spec *s, int32_t stage);
void sp_path_strain(const sp_pack_spec *s, double strain[6]);
bool sp_path_frees(const sp_pack_spec *s, int component);
sp_status sp_path_check(const sp_pack_spec *s, sp_error *err);

/* Accelerations below this are rounding: positions are rounded, and contacts whose forces go as overlap^exponent have
 * stiffnesses of about p^(1 - 1/exponent). */
double sp_rounding_acceleration(double pressure, double exponent);

/* Peak memory of making the packing of a resolved spec, beside what the program has anyway [byte]. */
double sp_pack_memory(const sp_pack_spec *spec);

/* Ordered packings, exact in closed form. These and all functions below expect a checked and resolved spec. */
sp_status sp_chain_make(const sp_pack_spec *spec, sp_packing *out, sp_error *err);
/* For equal diameters only. */
sp_status sp_triangular_make(const sp_pack_spec *spec, sp_packing *out, sp_error *err);

/* Initial state of the compression of a triangular lattice of unequal grains: the perfect lattice, expanded until no
 * grain can touch another or a wall. Writes radii r [n] and positions x [n][3]. */
typedef struct sp_lattice_start {
    double width, height; /* of the expanded box; the walls are at 0 and height */
    double width_end;     /* of a perfect lattice of grains of the same mean diameter under the pressure */
    double height_end;
} sp_lattice_start;
sp_status sp_triangular_start(const sp_pack_spec *spec, double *r, double *x, sp_lattice_start *out, sp_error *err);

/* A minimum of the energy. Errors as in sp_packing_make. */
sp_status sp_minimum_make(const sp_pack_spec *spec, const sp_pack_hooks *hooks, sp_packing *out, sp_error *err);

/* Compresses a gas, lattice or packing to equilibrium. Errors as in sp_packing_make. */
sp_status sp_piston_make(const sp_pack_spec *spec, const sp_pack_hooks *hooks, sp_packing *out, sp_error *err);

/* ---- sizes ----------------------------------------------------------------------------------------------------- */

/* Smallest and largest diameter of the distribution; inf and 0 for an empty list. */
void sp_sizes_limits(const sp_pack_spec *spec, double *low, double *high);
/* Fraction of the unrestricted lognormal distribution within the limits. */
double sp_sizes_within(const sp_pack_spec *spec);
/* Quantities derived from the moments of the distribution. */
double sp_sizes_mean_area(const sp_pack_spec *spec);
double sp_sizes_mean_volume(const sp_pack_spec *spec);
/* Whether the grains are so similar that they may form a lattice. */
bool sp_sizes_alike(const sp_pack_spec *spec);

/* ---- gas ------------------------------------------------------------------------------------------------------- */

/* As sp_gas_make; the watch of the hooks may stop it (SP_EINTERRUPTED). */
sp_status sp_gas_make_watched(const sp_pack_spec *spec, const sp_pack_hooks *hooks, const double *r, double *x,
                              double *height, sp_error *err);

#endif
