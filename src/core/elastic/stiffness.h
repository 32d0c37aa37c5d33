#ifndef SP_STIFFNESS_H
#define SP_STIFFNESS_H

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
                                uniaxial strain from wall to wall; NAN without walls */
    double error[STRAINS_3D][STRAINS_3D]; /* bounds of the errors of c */
    double spins[STRAINS_3D]; /* change of each stress for rotations of 1 of all spheres with two contacts; included in
                                 `error` */
    double residual;          /* largest |K u - f|/|f| */
} sp_stiffness;

sp_status sp_stiffness_make(const sp_network *net, sp_stiffness *out, sp_error *err);

#endif
