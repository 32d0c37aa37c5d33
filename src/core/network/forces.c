/* Forces of the springs of a block. Quads have two versions: vectors of eight (four springs times two lanes), and
 * vectors of two. In both, each lane has the same operations in the same order. */
#include "network/operator.h"
#include "network/spring.h"

#include <stddef.h>

#if defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) &&     \
    defined(__x86_64__)
#define WIDE __attribute__((target("arch=x86-64-v4,prefer-vector-width=512")))
bool sp_operator_wide(void) { return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq"); }
#else
bool sp_operator_wide(void) { return false; }
#endif

enum { ROW = 8 };

/* ---- by two: any machine ------------------------------------------------------------------------------------ */

static ALWAYS_INLINE pair pair_at(const double *row, int a) { return ((const pair_memory *)row)[a]; }

static ALWAYS_INLINE void quad_springs(const sp_spring_set *set, int32_t chunk, bool both, int32_t first,
                                       const double *restrict u, double *restrict force) {
    for (int64_t k = 4 * set->first[chunk]; k < 4 * set->first[chunk + 1]; k++) {
        const sp_quad *q = &set->quads[k / 4];
        const int s = (int)(k % 4);
        const double nx = q->nx[s], ny = q->ny[s];
        const double *ui = u + (ptrdiff_t)q->i[s] * ROW, *uj = u + (ptrdiff_t)q->j[s] * ROW;
        const pair dx = pair_at(uj, 0) - pair_at(ui, 0), dy = pair_at(uj, 1) - pair_at(ui, 1),
                   turn = pair_at(uj, 2) + pair_at(ui, 2);
        const pair along = q->kn[s] * (nx * dx + ny * dy), side = q->kt[s] * ((nx * dy - ny * dx) - turn);
        const pair fx = along * nx - side * ny, fy = along * ny + side * nx;
        pair_memory *oi = (pair_memory *)(force + (ptrdiff_t)(q->i[s] - first) * ROW);
        oi[0] -= fx;
        oi[1] -= fy;
        oi[2] -= side;
        if (both) {
            pair_memory *oj = (pair_memory *)(force + (ptrdiff_t)(q->j[s] - first) * ROW);
            oj[0] += fx;
            oj[1] += fy;
            oj[2] -= side;
        }
    }
}

/* ---- by eight ----------------------------------------------------------------------------------------------- */

#ifdef WIDE
typedef double v4 __attribute__((vector_size(32), aligned(32), may_alias));
typedef double v8 __attribute__((vector_size(64), aligned(64), may_alias));
typedef int64_t i8 __attribute__((vector_size(64), aligned(64), may_alias));

#define EACH_TWICE(x)       __builtin_shufflevector(*(const v4 *)(x), *(const v4 *)(x), 0, 0, 1, 1, 2, 2, 3, 3)
#define LOW_HALVES(a, b)    __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11)
#define HIGH_HALVES(a, b)   __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15)
#define EVEN_QUARTERS(a, b) __builtin_shufflevector(a, b, 0, 1, 4, 5, 8, 9, 12, 13)
#define ODD_QUARTERS(a, b)  __builtin_shufflevector(a, b, 2, 3, 6, 7, 10, 11, 14, 15)
#define TURN_BACK(x)        ((v8)((i8)(x) ^ back)) /* changes the sign of the rotation */

/* A row is x, y, rotation, unused, each in two lanes. Four rows are transposed to the x of four springs, the y of four
 * springs, and so on, and the forces are transposed back. */
WIDE static ALWAYS_INLINE void wide_quads(const sp_spring_set *set, int32_t chunk, bool both, int32_t first,
                                          const double *restrict u, double *restrict force) {
    const i8 back = {0, 0, 0, 0, INT64_MIN, INT64_MIN, 0, 0};
    const v8 zero = {0};
    const sp_quad *end = set->quads + set->first[chunk + 1];
    for (const sp_quad *q = set->quads + set->first[chunk]; q < end; q++) {
        v8 d[4], f[4];
        for (int s = 0; s < 4; s++) {
            const v8 ui = *(const v8 *)(u + (ptrdiff_t)q->i[s] * ROW), uj = *(const v8 *)(u + (ptrdiff_t)q->j[s] * ROW);
            d[s] = uj - TURN_BACK(ui);
        }
        const v8 low01 = LOW_HALVES(d[0], d[1]), low23 = LOW_HALVES(d[2], d[3]);
        const v8 high01 = HIGH_HALVES(d[0], d[1]), high23 = HIGH_HALVES(d[2], d[3]);
        const v8 dx = EVEN_QUARTERS(low01, low23), dy = ODD_QUARTERS(low01, low23);
        const v8 turn = EVEN_QUARTERS(high01, high23);
        const v8 nx = EACH_TWICE(q->nx), ny = EACH_TWICE(q->ny);
        const v8 along = EACH_TWICE(q->kn) * (nx * dx + ny * dy);
        const v8 side = EACH_TWICE(q->kt) * ((nx * dy - ny * dx) - turn);
        const v8 fx = along * nx - side * ny, fy = along * ny + side * nx;
        const v8 xy01 = LOW_HALVES(fx, fy), xy23 = HIGH_HALVES(fx, fy);
        const v8 side01 = LOW_HALVES(side, zero), side23 = HIGH_HALVES(side, zero);
        f[0] = EVEN_QUARTERS(xy01, side01);
        f[1] = ODD_QUARTERS(xy01, side01);
        f[2] = EVEN_QUARTERS(xy23, side23);
        f[3] = ODD_QUARTERS(xy23, side23);
        for (int s = 0; s < 4; s++) {
            *(v8 *)(force + (ptrdiff_t)(q->i[s] - first) * ROW) -= f[s];
            if (both)
                *(v8 *)(force + (ptrdiff_t)(q->j[s] - first) * ROW) += TURN_BACK(f[s]);
        }
    }
}

WIDE static void wide_chunk(const sp_operator *op, int32_t c, int32_t first, const double *restrict u,
                            double *restrict force) {
    wide_quads(&op->inner, c, true, first, u, force);
    wide_quads(&op->border, c, false, first, u, force);
}
#else
static void wide_chunk(const sp_operator *op, int32_t c, int32_t first, const double *u, double *force) {
    (void)op, (void)c, (void)first, (void)u, (void)force;
}
#endif

/* ---- spring by spring: all other networks ------------------------------------------------------------------- */

static ALWAYS_INLINE void add_springs(shape s, const sp_spring_set *set, int32_t chunk, bool both, ptrdiff_t first,
                                      ptrdiff_t stride, const double *restrict u, double *restrict force) {
    const sp_carried *held = s.carried ? set->carried + set->first[chunk] : NULL;
    for (const sp_spring *c = set->springs + set->first[chunk]; c < set->springs + set->first[chunk + 1]; c++)
        add_spring(s, c, s.carried ? held++ : NULL, u + c->i * stride, u + c->j * stride,
                   force + (c->i - first) * stride, both ? force + (c->j - first) * stride : NULL);
}

static ALWAYS_INLINE void springs_body(shape s, const sp_operator *op, int32_t chunk, ptrdiff_t first,
                                       const double *restrict u, double *restrict force) {
    add_springs(s, &op->inner, chunk, true, first, op->row, u, force);
    add_springs(s, &op->border, chunk, false, first, op->row, u, force);
}

static void carried_chunk(const sp_operator *op, int32_t chunk, ptrdiff_t first, const double *restrict u,
                          double *restrict force) {
    if (op->dim == 2)
        op->transposed ? springs_body((shape){2, 1, 2, true, true, true}, op, chunk, first, u, force)
                       : springs_body((shape){2, 1, 2, true, true, false}, op, chunk, first, u, force);
    else
        op->transposed ? springs_body((shape){3, 3, 2, true, true, true}, op, chunk, first, u, force)
                       : springs_body((shape){3, 3, 2, true, true, false}, op, chunk, first, u, force);
}

static ALWAYS_INLINE void springs_chunk(bool prestress, const sp_operator *op, int32_t chunk, ptrdiff_t first,
                                        const double *restrict u, double *restrict force) {
    switch (10 * op->dim + op->dof) {
    case 11: springs_body((shape){1, 0, 2, false, false, false}, op, chunk, first, u, force); break;
    case 22: springs_body((shape){2, 0, 2, prestress, false, false}, op, chunk, first, u, force); break;
    case 23: springs_body((shape){2, 1, 2, prestress, false, false}, op, chunk, first, u, force); break;
    case 33: springs_body((shape){3, 0, 2, prestress, false, false}, op, chunk, first, u, force); break;
    case 36: springs_body((shape){3, 3, 2, prestress, false, false}, op, chunk, first, u, force); break;
    default: break;
    }
}

void sp_operator_force(const sp_operator *op, int32_t block, int32_t chunk, const double *restrict u,
                       double *restrict force) {
    const int32_t first = op->first[block];
    if (op->quad && op->wide) {
        wide_chunk(op, chunk, first, u, force);
    } else if (op->quad) {
        quad_springs(&op->inner, chunk, true, first, u, force);
        quad_springs(&op->border, chunk, false, first, u, force);
    } else if (op->inner.carried) {
        carried_chunk(op, chunk, first, u, force);
    } else if (op->prestress) {
        springs_chunk(true, op, chunk, first, u, force);
    } else {
        springs_chunk(false, op, chunk, first, u, force);
    }
}
