#ifndef SP_STIFFNESS_H
#define SP_STIFFNESS_H

#include <sonopack/network.h>

/* Imposed strains, indices of C. In the plane: uniaxial along the periodic axis, uniaxial between the walls, simple
 * shear by the top wall; a chain has the second. */
enum { STRAIN_11 = 0, STRAIN_22, STRAIN_SHEAR, STRAINS };
/* In space Voigt's order: 11 and 22 along the walls, 33 between them, 23 and 13 by the top wall, 12 through the
 * periodic images. */
enum { STRAIN_33_3D = 2, STRAIN_23_3D, STRAIN_13_3D, STRAIN_12_3D, STRAINS_3D };

typedef struct sp_stiffness {
    double c[STRAINS_3D][STRAINS_3D]; /* stress a from strain b, each by itself; NAN where not defined */
    double wall[STRAINS_3D]; /* normal force on the top wall over its area, for strain b: the row of C of the uniaxial
                                strain between the walls again */
    double error[STRAINS_3D][STRAINS_3D]; /* bounds of the errors of c */
    double spins[STRAINS_3D]; /* change of a stress by turns of 1 of the spheres with two contacts; part of `error` */
    double residual;          /* largest |K u - f| / |f| */
} sp_stiffness;

sp_status sp_stiffness_make(const sp_network *net, sp_stiffness *out, sp_error *err);

#endif
