#ifndef SP_STIFFNESS_H
#define SP_STIFFNESS_H

#include <sonopack/network.h>

/* Imposed strains, indices of C: uniaxial along the periodic axis, uniaxial between the walls, simple shear by the top
 * wall. */
enum { STRAIN_11 = 0, STRAIN_22, STRAIN_SHEAR, STRAINS };

typedef struct sp_stiffness {
    double c[STRAINS][STRAINS]; /* stress a from strain b, each by itself; NAN where not defined */
    double wall[STRAINS];       /* normal force on the top wall over its area, for strain b: c[STRAIN_22][b] again */
    double error[STRAINS][STRAINS]; /* bounds of the errors of c */
    double residual;                /* largest |K u - f| / |f| */
} sp_stiffness;

sp_status sp_stiffness_make(const sp_network *net, sp_stiffness *out, sp_error *err);

#endif
