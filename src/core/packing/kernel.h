#ifndef SP_KERNEL_H
#define SP_KERNEL_H
/* The two loops that take most of the time of a compression: over pairs and over grains. Each call handles a part of
 * them. Parts may run in parallel, and the result does not depend on their number. */
#include "packing/grains.h"

enum { BLOCK = 128 }; /* pairs per call; a multiple of the widest vector */

/* Writes the forces of the pairs [first, first + count) of the inner list to their rows. first and count are multiples
 * of 8, and count is at most BLOCK. Open pairs get zero force and lose their tangential force. */
void sp_kernel_pairs_2d(const dynamics *d, double dt_past, int32_t first, int32_t count);
void sp_kernel_pairs_3d(const dynamics *d, double dt_past, int32_t first, int32_t count);

/* Largest squared speed and largest rate (see dynamics) of a part of the grains. */
typedef struct kernel_maxima {
    double v2, rate;
} kernel_maxima;

/* Adds up the force rows of the grains [first, last) and moves these grains by dt. */
kernel_maxima sp_kernel_move_2d(const dynamics *d, double dt, int32_t first, int32_t last);
kernel_maxima sp_kernel_move_3d(const dynamics *d, double dt, int32_t first, int32_t last);

#endif
