#ifndef SP_REVERSE_ROWS_H
#define SP_REVERSE_ROWS_H
/* Moves the rows of a chunk by one step of a reverse pass. */

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

#endif
