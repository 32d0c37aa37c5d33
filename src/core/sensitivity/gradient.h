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

bool sp_modulus_exists(int dim, sp_modulus which);
SP_SHARED const char *sp_modulus_name(sp_modulus which);
double sp_modulus_value(const sp_moduli *m, sp_modulus which); /* NAN: not computed */

#endif
