/* Products at springs in vectors of two, for any machine. */
#include "network/quads.h"

typedef pair_memory vec;
enum { AT_ONCE = 1 };

static ALWAYS_INLINE pair number(const double *quad, int field, int s) {
    const double x = quad[4 * field + s];
    return (pair){x, x};
}

static ALWAYS_INLINE pair swap(pair x) { return (pair){x[1], x[0]}; }

/* Translations as differences, rotations as sums. */
static ALWAYS_INLINE void load(quad_kind s, const double *u, const int32_t *i, const int32_t *j, vec *c) {
    const pair_memory *ui = (const pair_memory *)(u + *i), *uj = (const pair_memory *)(u + *j);
    for (int a = 0; a < s.dim + s.rotations; a++) {
        const int at = quad_component(a) / 2;
        c[a] = a < s.dim ? uj[at] - ui[at] : uj[at] + ui[at];
    }
}

#include "sensitivity/multiply_quads.h"

void sp_multiply(const multiply_job *job, const double *u) {
    if (job->whole)
        multiply_all(true, job, u);
    else
        multiply_all(false, job, u);
}
