#ifndef SP_KERNEL_H
#define SP_KERNEL_H
/* The two loops in which a packing's making spends its time, over a part of the pairs and over a part of the grains:
 * parts may run at once, and what they make does not depend on how many there are. */
#include "packing/dynamics.h"

enum { BLOCK = 128 }; /* pairs at a time; a multiple of the widest vector */

/* Forces of the pairs [first, first + count) of the inner list into their rows; first and count are multiples of 8,
 * count at most BLOCK. Open pairs come out with zero force and forget their tangential force. */
void sp_kernel_pairs_2d(const dynamics *d, double dt_past, int32_t first, int32_t count);
void sp_kernel_pairs_3d(const dynamics *d, double dt_past, int32_t first, int32_t count);

/* What a part of the grains has seen. */
typedef struct kernel_seen {
    double v2, rate;
} kernel_seen;

/* Adds up the rows of the grains [first, last) and moves these by dt. */
kernel_seen sp_kernel_move_2d(const dynamics *d, double dt, int32_t first, int32_t last);
kernel_seen sp_kernel_move_3d(const dynamics *d, double dt, int32_t first, int32_t last);

#endif
