#ifndef SP_MODES_TABLE_H
#define SP_MODES_TABLE_H
/* From eigenpairs, however they were found, to the public table of modes. */

#include "modes/refine.h"

#include <sonopack/modes.h>

typedef struct sp_mode_pairs {
    int64_t count;
    const sp_ritz *ritz;   /* [count], in any order */
    const double *vectors; /* [count][dofs] in the same order; NULL: frequencies only */
    int64_t rattlers;      /* rows of rattlers in front: all of them, or 0 where the set begins above omega = 0 */
    int64_t first;         /* modes of the whole spectrum below the set's first row */
} sp_mode_pairs;

/* SP_EREFUSED for an eigenvalue that is negative beyond its error: such a mode has no frequency. */
sp_status sp_modes_tabulate(const sp_network *net, sp_source source, const sp_mode_pairs *set, sp_modes *out,
                            sp_error *err);

#endif
