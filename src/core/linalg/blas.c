/* Sets the number of BLAS threads. */
#include "linalg/blas.h"

extern void openblas_set_num_threads(int threads) __attribute__((weak));

void sp_blas_one_thread(void) {
    if (openblas_set_num_threads)
        openblas_set_num_threads(1);
}
