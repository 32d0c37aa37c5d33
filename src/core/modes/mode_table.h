#ifndef SP_MODES_TABLE_H
#define SP_MODES_TABLE_H
/* Makes the public table of modes from eigenpairs of any solver. */

#include "modes/refine.h"

#include <sonopack/modes.h>

typedef struct sp_mode_pairs {
    int64_t count;
    const sp_ritz *ritz; /* [count], in any order */
    int64_t zeros;       /* number of the lowest of them that are zero modes */
    sp_zero_modes zero;  /* of the whole spectrum */
    double **vectors;    /* a block with the [count][dofs] vectors in the same order, which the table takes; NULL:
                            frequencies only */
    int64_t row;         /* the first of them in the block */
    int64_t rattlers;    /* number of rattlers' rows in front: all, or 0 if the set begins above omega = 0 */
    int64_t first;       /* number of modes of the whole spectrum below the first row */
} sp_mode_pairs;

/* SP_EREFUSED for an eigenvalue that is negative beyond its error. */
sp_status sp_modes_tabulate(const sp_network *net, sp_source source, const sp_mode_pairs *set, sp_modes *out,
                            sp_error *err);

/* SP_EINVAL for a number of modes or a band that cannot be. */
sp_status sp_modes_check_range(const sp_network *net, const sp_modes_range *r, sp_error *err);
bool sp_modes_range_is_whole(const sp_modes_range *r);

/* The mass-weighted source and detector, [dofs] each: NAN where the network does not touch the wall. */
sp_status sp_modes_walls(const sp_network *net, sp_source source, double *from, double *to, sp_error *err);

/* Distance in omega^2 between the rows first .. last and all other eigenvalues: those listed beside them, and those
 * that may lie beyond the certified ends of the list. Negative or 0 if they may coincide. */
double sp_modes_gap(const sp_modes *m, int64_t first, int64_t last);

#endif
