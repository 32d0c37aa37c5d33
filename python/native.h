/* What the Python extension needs beside the library. Included once, by the source that cffi writes. */
#include <pthread.h>
#include <stdbool.h>
#include <string.h>

extern void openblas_set_num_threads(int threads) __attribute__((weak));
extern int openblas_get_num_threads(void) __attribute__((weak));

static pthread_mutex_t sonopack_blas_lock = PTHREAD_MUTEX_INITIALIZER;
static int sonopack_blas_calls, sonopack_blas_threads;

/* The command runs OpenBLAS on one thread, so that its sums do not depend on the number of cores. numpy shares this
 * OpenBLAS and keeps its threads: one thread is set only while a call of the library is running. */
static void sonopack_blas_begin(void) {
    pthread_mutex_lock(&sonopack_blas_lock);
    if (sonopack_blas_calls++ == 0 && openblas_set_num_threads && openblas_get_num_threads) {
        sonopack_blas_threads = openblas_get_num_threads();
        if (sonopack_blas_threads > 1)
            openblas_set_num_threads(1);
    }
    pthread_mutex_unlock(&sonopack_blas_lock);
}

static void sonopack_blas_end(void) {
    pthread_mutex_lock(&sonopack_blas_lock);
    if (--sonopack_blas_calls == 0 && sonopack_blas_threads > 1)
        openblas_set_num_threads(sonopack_blas_threads);
    pthread_mutex_unlock(&sonopack_blas_lock);
}
