#ifndef SP_MULTIPLY_H
#define SP_MULTIPLY_H
/* Sums of products of the two lanes of a vector at springs, four at a time. */

#include "network/quads.h"

/* Springs of one kind in fours: the components of n, [dim][4], then i[4] and j[4] as in quads.h. */
static ALWAYS_INLINE int multiply_quad(int dim) { return 4 * dim + 4; }

typedef struct multiply_job {
    int dim, rotations;
    bool whole;          /* all products of displacements, else those along n and across it */
    const double *quads; /* [count] */
    int64_t count;
    double share; /* factor */
    double *sums; /* [count][width][4][2], to which products of lane 0 and 1 and of lane 1 and 0 are added; whole ones
                     of displacements a <= b as x_a y_b and y_a x_b */
} multiply_job;

void sp_multiply(const multiply_job *job, const double *u);
/* The same bits with vectors of eight. Only for machines for which sp_operator_wide holds, and not in one dimension. */
void sp_multiply_wide(const multiply_job *job, const double *u);

#endif
