#ifndef SP_OPERATOR_H
#define SP_OPERATOR_H
/* K for those who apply it many hundred times to two vectors: grains renumbered, so that neighbours are near in memory,
 * and cut into blocks. A block owns the forces on its grains: nothing is added up by two of them, so that sums have one
 * order for any number of threads. Springs within a block serve both their grains at once, those to other blocks are
 * in both. sp_network_apply is the same operator, plainly. */

#include <sonopack/network.h>

/* Four springs of a network in the plane with friction and without prestress. */
typedef struct sp_quad {
    _Alignas(32) double nx[4], ny[4], kn[4], kt[4];
    int32_t i[4], j[4]; /* rows */
} sp_quad;

/* A vector over the network is two vectors (lanes), interleaved: [n + 1][row], value a of a row at 2 a and 2 a + 1; the
 * last row stands for the walls and is 0. Values are those of the network times `scale`, forces over it: rotations are
 * measured along the grain's surface, where springs need no lever arms. */
typedef struct sp_operator {
    int dim, dof;
    bool prestress;
    bool quad; /* quads, else springs */
    bool wide; /* by vectors of eight; the bits are the same */
    int row;   /* doubles of a row, 2 dof or more */
    int32_t n;
    int32_t *row_of;         /* [n] row of a grain of the network */
    int32_t *grain;          /* [n] grain in a row */
    double *scale;           /* [n][dof] */
    int32_t blocks, largest; /* number, and rows of the largest */
    int32_t *first;          /* [blocks + 1] rows */
    /* Blocks are cut into chunks: once the springs of a chunk are done, the forces on its rows are complete, and U
     * there is not needed any more by the block. */
    int32_t *chunk;     /* [blocks + 1] first chunks */
    int32_t *chunk_row; /* [chunk[blocks] + 1] first rows */
    int64_t *two, *one; /* [chunk[blocks] + 1] quads or springs, i in the chunk: j in this or a later chunk of the
                           block; in another block or a wall */
    sp_quad *two_quads, *one_quads;
    sp_spring *two_springs, *one_springs;
    sp_carried *two_carried, *one_carried; /* of those springs, NULL where K is symmetric */
    bool transposed;                       /* forces are those of K^T; the caller's choice, false */
    int32_t *beside_first, *beside;        /* [blocks + 1], and of each block those that it has springs to */
} sp_operator;

sp_status sp_operator_make(const sp_network *net, sp_operator *out, sp_error *err);
void sp_operator_free(sp_operator *op);

/* Adds the forces of a chunk's springs to force, [rows of the block][row]; both aligned to 64 bytes. */
void sp_operator_force(const sp_operator *op, int32_t block, int32_t chunk, const double *restrict u,
                       double *restrict force);

/* Whether this machine has vectors of eight that the program was compiled for. */
bool sp_operator_wide(void);

#endif
