#ifndef SP_BLAS_H
#define SP_BLAS_H
/* The only door to LAPACKE: its header asks for complex.h, whose I is a poor neighbour. */

#include <lapacke.h>
#undef I

#endif
