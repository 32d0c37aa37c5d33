#ifndef SP_QUADRATURE_H
#define SP_QUADRATURE_H
/* Gauss's rule of n points on -1 .. 1: roots of Legendre's polynomial by Newton's method (Abramowitz and Stegun,
 * 25.4.29). */

void sp_gauss_rule(int n, double *node, double *weight);

#endif
