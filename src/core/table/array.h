#ifndef SP_TABLE_ARRAY_H
#define SP_TABLE_ARRAY_H
/* Arrays that grow by one element at a time and do not store their capacity. */

#include "base/base.h"

/* Makes sure that an array of `count` elements can hold one more. Returns the array, or a larger copy if `count` is 0 or
 * a power of two; the old array is then freed. Returns NULL if memory is short: the old array stays. The array must have
 * grown by this function only. */
static inline void *sp_array_reserve(void *array, size_t count, size_t size) {
    size_t capacity = count;
    return (count & (count - 1)) != 0 ? array : sp_grow(array, count + 1, &capacity, size);
}

#endif
