#ifndef SP_STRAIN_H
#define SP_STRAIN_H
/* Imposed affine strains: the loads on the grains, and the stresses. */

#include "elastic/stiffness.h"

/* Number of strains in this dimension, and whether a strain exists and is possible; grips: the packing can be sheared
 * across the up axis. */
int sp_strain_count(const sp_network *net);
bool sp_strain_allowed(const sp_network *net, int strain, bool grips);
/* Area across the up axis and volume of the cell [d]. */
double sp_strain_area(const sp_network *net);
double sp_strain_volume(const sp_network *net);

/* Index in a vector of the network of entry `entry` of a row of B (network/rows.h). */
static inline int64_t sp_strain_index(const sp_network *net, const sp_spring *s, int entry) {
    return (int64_t)(entry < net->dof ? s->i : s->j) * net->dof + entry % net->dof;
}

/* Affine displacement of j's side of a contact relative to i's. */
void sp_strain_displacement(const sp_network *net, int strain, const double n[3], double length, double out[3]);

/* f = -B^T k d with the affine relative displacements d at the contacts. Returns |k d|, the scale of its terms. */
double sp_strain_load(const sp_network *net, int strain, double *f);
/* The same for K^T: stress times volume is that of the affine field minus f . u. */
double sp_strain_load_transposed(const sp_network *net, int strain, double *f);
/* Stresses, sum of F d/V over all springs, at the displacement u in addition to the affine one: column `strain` of
 * out->c, and out->wall. */
void sp_strain_stresses(const sp_network *net, int strain, const double *u, sp_stiffness *out);
/* Sums of absolute values, for bounds of rounding errors. size[i]: of the terms of (K u - f)_i; sum[a]: of the terms of
 * the stress, sum of k d_a (d + B u); may be NULL. strain < 0: without the affine field. */
void sp_strain_rounding(const sp_network *net, int strain, const double *u, double *size, double *sum);
/* Relative rounding error of a sum over springs. */
double sp_strain_noise(const sp_network *net);

#endif
