/* Forces of the springs of a chunk in vectors of two, one spring after the other, for any machine. */
#include "network/operator.h"

#include <stddef.h>

typedef pair vec;
enum { AT_ONCE = 1 };

static ALWAYS_INLINE pair number(const double *quad, int field, int s) {
    const double x = quad[4 * field + s];
    return (pair){x, x};
}

/* Translations as differences, rotations as sums. */
static ALWAYS_INLINE void load(quad_kind s, const double *u, const int32_t *i, const int32_t *j, pair *c) {
    const int dof = s.dim + s.rotations;
    const pair_memory *ui = (const pair_memory *)(u + *i);
    const pair_memory *uj = (const pair_memory *)(u + *j);
    for (int a = 0; a < dof; a++) {
        const int at = quad_component(a) / 2;
        c[a] = a < s.dim ? uj[at] - ui[at] : uj[at] + ui[at];
    }
}

static ALWAYS_INLINE void load_apart(const double *u, const int32_t *i, const int32_t *j, pair *c, pair own[2][3]) {
    load((quad_kind){.dim = 3, .rotations = 3}, u, i, j, c);
    for (int a = 0; a < 3; a++) {
        own[0][a] = *(const pair_memory *)(u + *i + quad_component(3 + a));
        own[1][a] = *(const pair_memory *)(u + *j + quad_component(3 + a));
    }
}

static ALWAYS_INLINE void store(quad_kind s, double *x, const int32_t *i, const int32_t *j, const pair *on_i,
                                const pair *on_j) {
    const int dof = s.dim + s.rotations;
    pair_memory *xi = (pair_memory *)(x + *i);
    for (int a = 0; a < dof; a++)
        xi[quad_component(a) / 2] -= on_i[a];
    if (!j)
        return;
    pair_memory *xj = (pair_memory *)(x + *j);
    for (int a = 0; a < dof; a++) {
        const int at = quad_component(a) / 2;
        xj[at] = a < s.dim ? xj[at] + on_j[a] : xj[at] - on_j[a];
    }
}

#include "network/quad_forces.h"

void sp_operator_force(const sp_operator *op, int32_t block, int32_t chunk, const double *restrict u,
                       double *restrict force) {
    if (op->wide)
        sp_operator_force_wide(op, block, chunk, u, force);
    else
        add_chunk(op, chunk, op->first[block], u, force);
}
