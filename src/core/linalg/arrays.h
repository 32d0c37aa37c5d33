#ifndef SP_ARRAYS_H
#define SP_ARRAYS_H
/* Several arrays of doubles in one block of memory. */

#include <sonopack/status.h>
#include <stddef.h>
#include <stdint.h>

/* Where to put the pointer, and the number of elements. */
typedef struct sp_array {
    double **at;
    size_t n;
} sp_array;

/* Allocates arrays of zeros, each aligned to 64 bytes. The list ends with {0}. *memory: the block, to be freed with
 * sp_free; NULL after a failure. */
sp_status sp_arrays_make(const sp_array *list, double **memory, sp_error *err);

/* Sorts rows by the first of the columns [n], and those that are equal in it by the second. The list ends with NULL.
 * SP_ENOMEM: nothing is changed. */
sp_status sp_arrays_sort(int64_t n, double *const columns[], sp_error *err);

#endif
