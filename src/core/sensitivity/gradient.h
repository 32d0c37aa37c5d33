#ifndef SP_GRADIENT_H
#define SP_GRADIENT_H
/* From the products of fields at the springs to derivatives by what a packing is made of. */

#include "sensitivity/products.h"

#include <sonopack/sensitivity.h>

/* SP_EINVAL for unknown parameters and for RADIUS, POSITION and PRESSURE without a packing; SP_EREFUSED if K is not
 * symmetric. */
sp_status sp_gradient_check(const sp_network *net, unsigned parameters, const sp_packing *packing, sp_error *err);
/* Whether these parameters need all products, and those of masses. */
bool sp_gradient_whole(const sp_network *net, unsigned parameters);
bool sp_gradient_masses(unsigned parameters);

/* The gradient of a quantity from its products. law: the derivative of the quantity by a factor of all springs. */
sp_status sp_gradient_make(const sp_products *p, unsigned parameters, const sp_packing *packing, double law,
                           sp_gradient *out, sp_error *err);

sp_status sp_partials_make(int64_t n, sp_partials *out, sp_error *err);
void sp_partials_free(sp_partials *p);

/* Derivatives by the separation of the centres of each spring, [springs][3], and bounds of their errors, [springs]. */
sp_status sp_gradient_separations(const sp_products *p, const sp_packing *packing, double **separation, double **error,
                                  sp_error *err);
/* Derivatives by the radii at fixed centres. */
sp_status sp_gradient_radii(const sp_products *p, const sp_packing *packing, sp_partials *out, sp_error *err);
/* The linear response of the network to its pressure. */
typedef struct sp_compression_response {
    double *separation; /* [springs][3] change of the separations */
    double volume;      /* change of ln V */
    double error;       /* relative */
} sp_compression_response;
sp_status sp_gradient_compress(const sp_network *net, sp_compression_response *out, sp_error *err);

#endif
