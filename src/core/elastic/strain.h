#ifndef SP_STRAIN_H
#define SP_STRAIN_H
/* Imposed affine strains: what they load the grains with, and the stresses that answer. */

#include "elastic/stiffness.h"

/* How many strains there are in this dimension, and whether walls that grip or not (and the dimension) allow one. */
int sp_strain_count(const sp_network *net);
bool sp_strain_allowed(const sp_network *net, int strain, bool grips);
/* Area of a wall and volume between the walls [d]. */
double sp_strain_area(const sp_network *net);
double sp_strain_volume(const sp_network *net);

/* Where entry `entry` of a row of B (network/rows.h) belongs in a vector. */
static inline int64_t sp_strain_place(const sp_network *net, const sp_spring *s, int entry) {
    return (int64_t)(entry < net->dof ? s->i : s->j) * net->dof + entry % net->dof;
}

/* Displacement of j's side of a contact against i's in the affine field. */
void sp_strain_gap(const sp_network *net, int strain, const double n[3], double length, double out[3]);

/* f = -B^T k d, d the affine field's relative displacements at the contacts; returns |k d|, the scale of its terms. */
double sp_strain_load(const sp_network *net, int strain, double *f);
/* The same for K^T: a stress is that of the affine field alone minus f . u, V times. */
void sp_strain_load_transposed(const sp_network *net, int strain, double *f);
/* Stresses sum F d/V over all springs for the displacement u beside the affine one: column `strain` of out->c, and
 * out->wall. */
void sp_strain_stresses(const sp_network *net, int strain, const double *u, sp_stiffness *out);
/* The sums of absolute values that stand behind a residual and a stress, against which they are rounded. size[i]: of
 * the terms of (K u - f)_i; sum[a]: of the terms of the stress sum k d_a (d + B u); NULL where not wanted. strain < 0:
 * u alone. */
void sp_strain_rounding(const sp_network *net, int strain, const double *u, double *size, double *sum);
/* Relative rounding of a sum over springs. */
double sp_strain_noise(const sp_network *net);

#endif
