/* Grows arrays by doubling. */
#include "table/array.h"

#include "base/base.h"

#include <string.h>

void *sp_array_reserve(void *array, size_t count, size_t size) {
    if ((count & (count - 1)) != 0)
        return array;
    void *larger = sp_alloc(count > 0 ? 2 * count : 1, size);
    if (!larger || count == 0)
        return larger;
    memcpy(larger, array, count * size);
    sp_free(array);
    return larger;
}
