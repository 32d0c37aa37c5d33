#ifndef SP_ZEROS_H
#define SP_ZEROS_H
/* Which eigenvalues are zero. By definition those below sp_zero_limit: springs between grains make no mode that is so
 * soft, and a motion that stretches no spring has an eigenvalue far below it in spite of rounding. */

#include "modes/refine.h"
#include "network/null_motions.h"

#include <sonopack/modes.h>

/* Largest eigenvalue omega^2 of M^-1/2 K M^-1/2 that counts as zero. */
double sp_zero_limit(const sp_network *net);

/* Finds how many of the eigenvalues are zero. ritz [count]: refined, in any order of those that are zero and of those
 * that are not, but zeros first; all eigenvalues that are not among them are above the limit. known: number of null
 * motions among them. SP_EREFUSED if it cannot be decided, and for an eigenvalue that is certainly negative. */
sp_status sp_zeros_count(const sp_network *net, int64_t count, const sp_ritz *ritz, int64_t known, int64_t *zeros,
                         sp_error *err);

/* Number of the softest modes that an eigensolver may have mixed with zero modes: up to the first wide gap between
 * eigenvalues, which ascend and have errors of `blur`. 0 if none can be a zero mode. above: the next eigenvalue. */
int64_t sp_zeros_near(int64_t count, const double *values, double blur, double above);

/* Turns the first `count` of the orthonormal vectors [count][dofs], which span the softest modes, so that zero modes
 * and soft modes part. An eigensolver mixes them if their eigenvalues differ by less than its error. Does nothing if
 * all of them are zero modes. */
sp_status sp_zeros_part(const sp_network *net, int64_t count, double *vectors, sp_error *err);

/* The numbers of zero modes, from the null motions and the number of other zero modes. */
sp_zero_modes sp_zeros_sum(const sp_network *net, const sp_null_motions *known, int64_t mechanisms);

#endif
