#ifndef SP_PRODUCTS_H
#define SP_PRODUCTS_H
/* Products of the relative displacements of two fields at each spring. With E_c(x, y) the bilinear form of spring c, a
 * derivative of many quantities is the sum over fields of weight x dE_c(x, y): it is linear in the products of x and y,
 * so that these are summed first, and any parameter of the springs takes its own part of them. */

#include "network/operator.h"

#include <sonopack/network.h>

/* Displacements of a spring: translations of j relative to i, then the sum of the rotations times the lever arms. */
enum { SP_LOCAL_MAX = 6, SP_PRODUCTS_MAX = 21 };

typedef struct sp_products {
    const sp_network *net;
    bool whole;    /* all products of displacements; false: those of the stretches along n and of the tangential ones */
    int size;      /* displacements of a spring */
    int width;     /* products of a spring: size (size + 1)/2, or 2 */
    double *at;    /* [springs][width] of whole products, those of two displacements once, as halves of both orders */
    double *error; /* [springs][2] bounds of the errors of dQ/dk_n and dQ/dk_t */
    double *mass;  /* [n] dQ/d ln m, the moment of inertia in proportion */
    double *mass_error; /* [n] */
    double by_volume;   /* dQ/d ln V, beside what the separations do */
    double *pull;       /* [springs][3] further derivatives by the separation of the centres; whole only */
} sp_products;

sp_status sp_products_make(const sp_network *net, bool whole, sp_products *out, sp_error *err);
void sp_products_free(sp_products *p);

/* Displacements of a spring in a field over the network. */
void sp_products_local(const sp_network *net, const sp_spring *s, const double *u, double out[SP_LOCAL_MAX]);
/* The stretch along n, and the tangential one; in 2D it has one component. */
double sp_products_along(const sp_network *net, const double n[3], const double x[SP_LOCAL_MAX]);
void sp_products_across(const sp_network *net, const double n[3], const double x[SP_LOCAL_MAX], double out[3]);
/* Adds weight times the products of two sets of displacements of spring k. */
void sp_products_add(sp_products *p, int32_t k, double weight, const double x[SP_LOCAL_MAX],
                     const double y[SP_LOCAL_MAX]);

/* dQ/dk of one spring: k_n, k_t and k_p. k_p only of whole products, else 0. */
typedef struct sp_stiffness_partials {
    double kn, kt, kp;
} sp_stiffness_partials;
sp_stiffness_partials sp_products_stiffness(const sp_products *p, int32_t k);
/* dQ/dn of one spring, of whole products: the change of Q when the normal turns by a small vector across it. */
void sp_products_turn(const sp_products *p, int32_t k, double out[3]);
/* Sum of 1/m that a unit stretch of a spring moves: the square of its norm in the metric of the masses, along the
 * normal and (tangential) at the contact. */
double sp_products_mobility(const sp_network *net, const sp_spring *s, bool tangential);

#endif
