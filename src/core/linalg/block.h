#ifndef SP_BLOCK_H
#define SP_BLOCK_H
/* Products of a tall matrix with a block of eight columns. Their bits depend neither on the machine nor on the threads
 * of `pool`. */

#include "base/pool.h"

enum { SP_BLOCK = 8 };

/* out = q^T w by columns, [SP_BLOCK][count], for q [count][n] and w [SP_BLOCK][n]. sums:
 * [sp_block_parts(n)][count][SP_BLOCK], aligned to 64 bytes; the first part has the same numbers afterwards, by rows.
 */
void sp_block_dots(sp_pool *pool, int64_t n, const double *q, int64_t count, const double *w, double *sums,
                   double *out);
int64_t sp_block_parts(int64_t n);
/* w -= q q^T w, with the sums of sp_block_dots. */
void sp_block_subtract(sp_pool *pool, int64_t n, const double *q, int64_t count, const double *sums, double *w);

#endif
