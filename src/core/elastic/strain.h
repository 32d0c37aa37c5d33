#ifndef SP_STRAIN_H
#define SP_STRAIN_H
/* Imposed affine strains: their names, the loads on the grains, and the stresses. */

#include <sonopack/network.h>

/* Imposed strains, which are the indices of C. In 2D: uniaxial along the walls, uniaxial from wall to wall, and simple
 * shear by the top wall. A chain has only the second. Without walls the cell itself is strained. */
enum { STRAIN_11 = 0, STRAIN_22, STRAIN_SHEAR, STRAINS };
/* In 3D, in Voigt's order: 11 and 22 along the walls, 33 from wall to wall, 23 and 13 by the top wall, 12 through the
 * periodic images. */
enum { STRAIN_33_3D = 2, STRAIN_23_3D, STRAIN_13_3D, STRAIN_12_3D, STRAINS_3D };

typedef struct sp_stiffness {
    double c[STRAINS_3D][STRAINS_3D]; /* stress a due to strain b; NAN where undefined */
    double wall[STRAINS_3D]; /* normal force on the top wall over its area for strain b; equals the row of C of the
                                uniaxial strain from wall to wall; NAN without flat walls */
    double error[STRAINS_3D][STRAINS_3D]; /* bounds of the errors of c */
    double residual;                      /* largest |K u - f|/|f| */
} sp_stiffness;

sp_status sp_stiffness_make(const sp_network *net, sp_stiffness *out, sp_error *err);

/* Number of strains in this dimension, and whether a strain exists and is possible; grips: the packing can be sheared
 * across the up axis. */
int sp_strain_count(const sp_network *net);
bool sp_strain_allowed(const sp_network *net, int strain, bool grips);
/* SP_EREFUSED between rings under prestress: a strain makes ellipses of them, whose normals and curvatures change. */
sp_status sp_strain_check(const sp_network *net, sp_error *err);
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
/* What one spring adds to the sum of F d of each stress, and for bounds of errors: to the sums of absolute values, of
 * which rounding is a part, and of k d^2, which bounds what forces do to the sum. */
typedef struct sp_strain_part {
    double stress[STRAINS_3D], size[STRAINS_3D], affine[STRAINS_3D];
} sp_strain_part;
void sp_strain_part_of(const sp_network *net, int32_t spring, int strain, const double *u, sp_strain_part *out);
/* Sums of absolute values, for bounds of rounding errors. size[i]: of the terms of (K u - f)_i; sum[a]: of the terms of
 * the stress, sum of k d_a (d + B u); may be NULL. strain < 0: without the affine field. */
void sp_strain_rounding(const sp_network *net, int strain, const double *u, double *size, double *sum);
/* Relative rounding error of a sum over springs. */
double sp_strain_noise(const sp_network *net);

#endif
