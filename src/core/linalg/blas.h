#ifndef SP_BLAS_H
#define SP_BLAS_H
/* Include this instead of lapacke.h, which includes complex.h and with it the macro I. */

#include <lapacke.h>
#undef I

/* Sets OpenBLAS to one thread, so that results do not depend on the number of cores and no cores are taken from other
 * samples. Does nothing with other BLAS libraries. */
void sp_blas_one_thread(void);

#endif
