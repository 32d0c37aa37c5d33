/* Kernels of a reverse pass for any machine. Rows move by one step: v -= step x force, u += v, and the adjoint gets
 * p u - q v of the other pair of vectors. */
#include "sensitivity/reverse_rows.h"

#include "base/clones.h"

enum { LINE = 8 };
typedef double line __attribute__((vector_size(64), aligned(64), may_alias));
typedef double half_line __attribute__((vector_size(32), aligned(32), may_alias));

/* One pair of numbers after the other, with the sums for masses. */
static ALWAYS_INLINE void advance_pairs(int dim, int dof, int lane, const reverse_rows *of) {
    const int kinds = dof > dim ? 2 : 1, row = quad_row(dof);
    const pair adjoint = {lane == 1, lane == 0}, p = of->step.p * adjoint, q = of->step.q * adjoint;
    const double *weight = of->weight;
    for (ptrdiff_t k = 0; k < of->count; k++, weight += 2 * kinds)
        for (int a = 0; a < dof; a++) {
            const ptrdiff_t at = k * row + quad_component(a);
            const pair old = *(const pair_memory *)(of->u + at), other = *(const pair_memory *)(of->other_u + at);
            const pair pull = weight[kinds + (a >= dim)] * *(const pair_memory *)(of->force + at);
            const pair push =
                *(const pair_memory *)(of->v + at) - pull + (p * other - q * *(const pair_memory *)(of->other_v + at));
            *(pair_memory *)(of->force + at) = (pair){0, 0};
            *(pair_memory *)(of->v + at) = push;
            *(pair_memory *)(of->next + at) = old + push;
            if (of->density)
                of->density[at / 2] +=
                    of->step.share * old[1 - lane] * pull[lane] + of->step.d * old[lane] * other[1 - lane];
        }
}

/* The same without masses, by lines of three components. Padding is 0 and stays so. */
static ALWAYS_INLINE void advance_lines(int dim, int dof, int lane, bool alone, const reverse_rows *of) {
    const int kinds = dof > dim ? 2 : 1, lines = dof / 3;
    const double even = lane == 1, odd = lane == 0;
    const line adjoint = {even, odd, even, odd, even, odd, even, odd};
    const line p = of->step.p * adjoint, q = of->step.q * adjoint;
    const double *weight = of->weight + kinds;
    for (ptrdiff_t k = 0; k < of->count; k++, weight += 2 * kinds)
        for (int b = 0; b < lines; b++) {
            const ptrdiff_t at = (k * lines + b) * LINE;
            const double one = weight[b], two = dof == 3 && dim == 2 ? weight[1] : one;
            const line step = {one, one, one, one, two, two, two, two};
            line push = *(const line *)(of->v + at) - step * *(const line *)(of->force + at);
            if (!alone)
                push += p * *(const line *)(of->other_u + at) - q * *(const line *)(of->other_v + at);
            *(line *)(of->force + at) = (line){0};
            *(line *)(of->v + at) = push;
            *(line *)(of->next + at) = *(const line *)(of->u + at) + push;
        }
}

/* Rows of two components. */
static ALWAYS_INLINE void advance_halves(int lane, const reverse_rows *of) {
    const double even = lane == 1, odd = lane == 0;
    const half_line adjoint = {even, odd, even, odd}, p = of->step.p * adjoint, q = of->step.q * adjoint;
    for (ptrdiff_t k = 0; k < of->count; k++) {
        const ptrdiff_t at = k * (LINE / 2);
        const half_line push =
            *(const half_line *)(of->v + at) - of->weight[2 * k + 1] * *(const half_line *)(of->force + at) +
            (p * *(const half_line *)(of->other_u + at) - q * *(const half_line *)(of->other_v + at));
        *(half_line *)(of->force + at) = (half_line){0};
        *(half_line *)(of->v + at) = push;
        *(half_line *)(of->next + at) = *(const half_line *)(of->u + at) + push;
    }
}

static ALWAYS_INLINE void advance_lane(int dim, int dof, int lane, const reverse_rows *of) {
    if (of->density || dof == 1)
        advance_pairs(dim, dof, lane, of);
    else if (dof == 2)
        advance_halves(lane, of);
    else if (of->alone)
        advance_lines(dim, dof, lane, true, of);
    else
        advance_lines(dim, dof, lane, false, of);
}

static ALWAYS_INLINE void advance_kind(int dim, int dof, const reverse_rows *of) {
    if (of->lane == 0)
        advance_lane(dim, dof, 0, of);
    else
        advance_lane(dim, dof, 1, of);
}

CLONES void sp_reverse_advance(int dim, int dof, const reverse_rows *of) {
    switch (10 * dim + dof) {
    case 11: advance_kind(1, 1, of); break;
    case 22: advance_kind(2, 2, of); break;
    case 23: advance_kind(2, 3, of); break;
    case 33: advance_kind(3, 3, of); break;
    default: advance_kind(3, 6, of); break;
    }
}

/* ---- products at springs, in vectors of two for any machine ---------------------------------------------------- */

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
