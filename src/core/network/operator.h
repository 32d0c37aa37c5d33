#ifndef SP_OPERATOR_H
#define SP_OPERATOR_H
/* K optimized for repeated application to two vectors. Grains are renumbered so that neighbours are close in memory,
 * and divided into blocks. Each block computes all forces on its grains, so the order of summation does not depend on
 * the number of threads. Springs within a block act on both of their grains; springs between blocks are stored in both
 * blocks. sp_network_apply is the simple version of the same operator. */

#include "network/quads.h"

#include <sonopack/network.h>

/* Springs of all chunks (see sp_operator). */
typedef struct sp_spring_set {
    int64_t *first; /* [chunks + 1] first quad of each chunk */
    double *quads;  /* quad_size(kind) each */
} sp_spring_set;

/* A vector holds two vectors over the network (lanes), interleaved: [n + 1][row], with component a of a row at
 * quad_component(a) and after it. The last row belongs to the walls and is 0. Components are those of the network times
 * `scale`, and forces are divided by it: rotations are measured as displacements of the grain's surface, so that
 * springs need no lever arms. */
typedef struct sp_operator {
    quad_kind kind; /* kind.transposed: apply K^T; set by the caller, initially false */
    int dof;
    bool wide; /* use vectors of eight; the result has the same bits */
    int row;   /* doubles per row: quad_row(dof) */
    int32_t n;
    int32_t *row_of;         /* [n] row of each grain of the network */
    int32_t *grain;          /* [n] grain of each row */
    double *scale;           /* [n][dof] */
    int32_t blocks, largest; /* number of blocks; rows of the largest */
    int32_t *first;          /* [blocks + 1] first row of each block */
    /* Blocks are divided into chunks. Once the springs of a chunk are done, the forces on its rows are complete, and
     * the block no longer needs u there. */
    int32_t *chunk;     /* [blocks + 1] first chunk of each block */
    int32_t *chunk_row; /* [chunk[blocks] + 1] first row of each chunk */
    /* Springs with i in the chunk. inner: j in this or a later chunk of the block. border: j in another block or a
     * wall. */
    sp_spring_set inner, border;
    int32_t *adjacent_first, *adjacent; /* [blocks + 1] and list of the neighbouring blocks of each block */
} sp_operator;

/* SP_EINVAL unless lever arms are the radii and a grain has one mass and one moment of inertia; SP_EREFUSED for more
 * than some 1e8 grains, SP_ENOMEM. */
sp_status sp_operator_make(const sp_network *net, sp_operator *out, sp_error *err);
/* Where lane 0 has a degree of freedom of the network. */
int64_t sp_operator_at(const sp_operator *op, int64_t dof);
void sp_operator_free(sp_operator *op);

/* Adds the forces of a chunk's springs to force, [rows of the block][row]. u and force are aligned to 64 bytes. */
void sp_operator_force(const sp_operator *op, int32_t block, int32_t chunk, const double *restrict u,
                       double *restrict force);

/* The same with vectors of eight, on machines that have them. */
void sp_operator_force_wide(const sp_operator *op, int32_t block, int32_t chunk, const double *restrict u,
                            double *restrict force);

/* Whether the program was compiled for vectors of eight and this machine has them. */
bool sp_operator_wide(void);

#endif
