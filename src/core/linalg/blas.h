#ifndef SP_BLAS_H
#define SP_BLAS_H
/* Include this instead of lapacke.h, which includes complex.h and with it the macro I. */

#include <lapacke.h>
#undef I

#endif
