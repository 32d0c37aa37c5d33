#ifndef SP_BLAS_H
#define SP_BLAS_H
/* The only door to LAPACKE: its header asks for complex.h, whose I is a poor neighbour. */

#include <lapacke.h>
#undef I

/* OpenBLAS on one thread: sums that do not depend on the number of cores, and no cores taken from other samples. Other
 * BLAS libraries are left as they are. */
void sp_blas_one_thread(void);

#endif
