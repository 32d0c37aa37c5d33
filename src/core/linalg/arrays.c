/* Allocates several arrays of doubles in one block of memory. */
#include "linalg/arrays.h"
#include "base/base.h"

/* Elements with padding to a multiple of 64 bytes. */
static size_t padded(size_t n) { return (n + 7) / 8 * 8; }

sp_status sp_arrays_make(const sp_array *list, double **memory, sp_error *err) {
    size_t total = 0;
    for (const sp_array *a = list; a->at; a++)
        total += padded(a->n);
    double *next = *memory = sp_alloc(total, sizeof *next);
    if (!next)
        return sp_fail_memory(err, total * sizeof *next);
    for (const sp_array *a = list; a->at; next += padded(a->n), a++)
        *a->at = next;
    return SP_OK;
}
