/* The buffers of OpenBLAS. It maps one for each thread that is inside it, at the first call that needs it, and where
 * there is no room (ulimit -v) it tries again for ever. They are therefore asked for before such calls. */
#include "late/late.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>

/* The largest buffer that OpenBLAS takes, that of x86-64, and what its alignment may add. */
static const size_t BUFFER = (size_t)130 << 20;

enum { BUFFERS_MAX = 256 }; /* from here on OpenBLAS itself refuses */

static atomic_int inside, reserved;
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

static void refuse(int wanted) {
    fprintf(stderr, "sonopack: not enough memory: OpenBLAS needs %d x %d MB of address space (see ulimit -v)\n", wanted,
            (int)(BUFFER >> 20));
    exit(EXIT_FAILURE);
}

static void need_room(int wanted) {
    void *room = mmap(NULL, BUFFER, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (room == MAP_FAILED)
        refuse(wanted);
    munmap(room, BUFFER);
}

/* Has OpenBLAS map buffers, which it keeps, until there are `wanted`. */
static void reserve(late_library *library, int wanted) {
    static void *known[BUFFERS_MAX]; /* by all calls so far: their number is `reserved` */
    void *(*take)(int) = (void *(*)(int))late_look(library, "blas_memory_alloc");
    void (*give)(void *) = (void (*)(void *))late_look(library, "blas_memory_free");
    if (!take || !give || wanted > BUFFERS_MAX) { /* another BLAS */
        atomic_store(&reserved, INT_MAX);
        return;
    }
    void *held[BUFFERS_MAX];
    int count = atomic_load(&reserved), holding = 0;
    while (count < wanted && holding < BUFFERS_MAX) {
        need_room(wanted);
        void *buffer = held[holding++] = take(0);
        int k = 0;
        while (k < count && known[k] != buffer)
            k++;
        if (k == count)
            known[count++] = buffer;
    }
    while (holding > 0)
        give(held[--holding]);
    atomic_store(&reserved, count);
}

int late_blas_enter(late_library *library) {
    const int now = atomic_fetch_add(&inside, 1) + 1;
    if (now > atomic_load(&reserved)) {
        pthread_mutex_lock(&lock);
        if (now > atomic_load(&reserved))
            reserve(library, now);
        pthread_mutex_unlock(&lock);
    }
    return now;
}

void late_blas_leave(const int *entered) {
    (void)entered;
    atomic_fetch_sub(&inside, 1);
}
