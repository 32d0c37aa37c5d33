#ifndef SP_HISTORY_PAIRS_H
#define SP_HISTORY_PAIRS_H
/* The loop over pairs of sp_kernel_pairs_2d for contacts with a loading history (mindlin.h), one by one. */
#include "packing/grains.h"

/* Like sp_kernel_pairs_2d. Open pairs forget their history. */
void sp_history_pairs(const dynamics *d, double dt_past, int32_t first, int32_t count);

#endif
