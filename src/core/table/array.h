#ifndef SP_TABLE_ARRAY_H
#define SP_TABLE_ARRAY_H
/* Arrays that grow by one element at a time. */

#include <sonopack/status.h>
#include <stddef.h>

/* Makes sure that an array of `count` elements of `size` bytes can hold one more. Gives the array, or a larger copy of
 * it if `count` is 0 or a power of two: then the old array is freed. NULL means that memory ran out: the old array
 * stays. Use it for arrays that grow by this function only. */
SP_SHARED void *sp_array_reserve(void *array, size_t count, size_t size);

#endif
