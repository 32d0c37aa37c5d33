#ifndef SP_REVERSE_ROWS_H
#define SP_REVERSE_ROWS_H
/* Kernels of a reverse pass: rows of a chunk move by one step, and the products of the two lanes of a vector are summed
 * at springs. */

#include "network/quads.h"

#include <stddef.h>

typedef struct reverse_step {
    int pair;         /* which pair of vectors moves */
    double p, q;      /* what is added to its adjoint: p u - q v of the other pair */
    double d;         /* factor of the products of both fields for masses */
    double share;     /* 1, or one half in the first step of T */
    bool has_adjoint; /* the adjoint is not 0 */
} reverse_step;

/* What the rows of a chunk need, from the first one on. */
typedef struct reverse_rows {
    const double *u, *weight, *other_u, *other_v;
    double *v, *next, *force;
    double *density; /* sums for masses, one for two lanes; NULL: none */
    ptrdiff_t count;
    bool alone; /* the other pair is 0 here */
    int lane;   /* of the field; the adjoint has the other one */
    reverse_step step;
} reverse_rows;

/* Takes the forces and clears them. */
void sp_reverse_advance(int dim, int dof, const reverse_rows *of);

/* ---- products at springs, four at a time ------------------------------------------------------------------------ */

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
