#ifndef SP_LATE_H
#define SP_LATE_H
/* Loads a shared library at the first call of one of its functions.
 *
 * The command stands on HDF5, cairo, OpenBLAS and SuiteSparse, which bring 66 more libraries. The loader takes ten
 * times as long for them as a signal takes to compute, and most commands need none or one of them. The files of this
 * folder define the functions that sonopack uses of each library; every one of them passes its arguments on to the
 * library's own. They are linked to the command only: libsonopack itself is linked to its libraries in the usual way.
 */

#include <pthread.h>
#include <stdatomic.h>

typedef struct late_library {
    const char *file;     /* as the loader knows it: "libcholmod.so.3" */
    void (*loaded)(void); /* called once, with the library in place; NULL: nothing to do */
    pthread_mutex_t lock;
    void *handle;
} late_library;

/* The address of a function or variable. Without the library the process ends: exit status 1 and a line on stderr. */
void *late_find(late_library *library, const char *name);

/* The same, but NULL if the library has no such function. */
void *late_look(late_library *library, const char *name);

/* Of a thread that calls OpenBLAS: makes sure that it finds a buffer there. Ends the process as late_find does. */
int late_blas_enter(late_library *library);
void late_blas_leave(const int *entered);

/* A function of `library` under its own name. */
#define LATE_FUNCTION(library, type, name, parameters, arguments)                                                      \
    LATE_CALL(library, type, name, parameters, arguments, )
/* One that calls BLAS. */
#define LATE_BLAS_FUNCTION(library, type, name, parameters, arguments)                                                 \
    LATE_CALL(library, type, name, parameters, arguments,                                                              \
              __attribute__((cleanup(late_blas_leave), unused)) const int entered = late_blas_enter(library);)

#define LATE_CALL(library, type, name, parameters, arguments, before)                                                  \
    type name parameters {                                                                                             \
        static _Atomic(__typeof__(&name)) found;                                                                       \
        __typeof__(&name) call = atomic_load_explicit(&found, memory_order_acquire);                                   \
        if (!call) {                                                                                                   \
            call = (__typeof__(&name))late_find(library, #name);                                                       \
            atomic_store_explicit(&found, call, memory_order_release);                                                 \
        }                                                                                                              \
        before return call arguments;                                                                                  \
    }

#endif
