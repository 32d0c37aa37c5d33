#ifndef SP_FORCE_ROWS_H
#define SP_FORCE_ROWS_H
/* Layout of the rows of forces: which rows each grain adds up. */
#include "packing/grains.h"

/* Lays out the rows for the inner list and the walls' lists. SP_ENOMEM. */
sp_status sp_rows_assign(dynamics *d, sp_error *err);
/* Whether a pair of block b of a list may belong to one of the grains [first, last). Only with a pool. */
static inline bool sp_rows_may_touch(const pair_list *p, int32_t b, int32_t first, int32_t last) {
    return !p->span || (p->span[2 * (int64_t)b] < last && p->span[2 * (int64_t)b + 1] >= first);
}

#endif
