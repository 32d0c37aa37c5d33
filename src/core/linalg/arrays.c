/* Several arrays of doubles: in one block of memory, or as the columns of a table. */
#include "linalg/arrays.h"
#include "base/base.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

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

typedef struct ranked {
    double first, second;
    int64_t at;
} ranked;

static int by_keys(const void *a, const void *b) {
    const ranked *x = a, *y = b;
    if (x->first != y->first)
        return x->first < y->first ? -1 : 1;
    if (x->second != y->second)
        return x->second < y->second ? -1 : 1;
    return x->at < y->at ? -1 : x->at > y->at;
}

sp_status sp_arrays_sort(int64_t n, double *const columns[], sp_error *err) {
    ranked *rank = sp_alloc((size_t)n, sizeof *rank);
    double *copy = sp_alloc((size_t)n, sizeof *copy);
    const bool ok = rank && copy;
    for (int64_t k = 0; k < n && ok; k++)
        rank[k] = (ranked){columns[0][k], columns[1][k], k};
    if (ok)
        qsort(rank, (size_t)n, sizeof *rank, by_keys);
    for (double *const *c = columns; *c && ok; c++) {
        for (int64_t k = 0; k < n; k++)
            copy[k] = (*c)[rank[k].at];
        memcpy(*c, copy, (size_t)n * sizeof *copy);
    }
    sp_free(copy);
    sp_free(rank);
    return ok ? SP_OK : sp_fail_memory(err, (size_t)n * (sizeof *rank + sizeof *copy));
}
