#ifndef SP_FILL_H
#define SP_FILL_H
/* From eigenpairs, however they were found, to the public table of modes. */

#include "modes/refine.h"

#include <sonopack/modes.h>

typedef struct sp_mode_set {
    int64_t count;
    const sp_ritz *ritz;   /* [count], in any order */
    const double *vectors; /* [count][dofs] in the same order; NULL: frequencies only */
    int64_t rattlers;      /* rows of rattlers in front: all of them, or 0 where the set begins above omega = 0 */
    int64_t first;         /* modes of the whole spectrum below the set's first row */
} sp_mode_set;

/* SP_EREFUSED for an eigenvalue that is negative beyond its error: such a mode has no frequency. */
sp_status sp_modes_fill(const sp_network *net, sp_source source, const sp_mode_set *set, sp_modes *out, sp_error *err);

#endif
