#ifndef SP_PIECES_H
#define SP_PIECES_H
/* All frequencies of a large network, without vectors. */

#include <sonopack/modes.h>

/* Smallest network for which the sparse solver finds all frequencies faster than LAPACK, on one thread. */
bool sp_modes_is_large(const sp_network *net);

/* Finds all frequencies in pieces of the spectrum, which threads share. The pieces do not depend on the number of
 * threads, and neither does the result. SP_EREFUSED if the modes of a piece cannot be counted. */
sp_status sp_modes_in_pieces(const sp_network *net, const sp_modes_options *opt, sp_modes *out, sp_error *err);

#endif
