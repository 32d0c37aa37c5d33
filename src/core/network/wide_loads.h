/* Numbers and displacements of four springs in vectors of eight, two lanes each. Included after the pragmas that choose
 * the machine, and only where it has such vectors. */
#include "network/quads.h"

typedef double v4 __attribute__((vector_size(32), aligned(32), may_alias));
typedef long long i8 __attribute__((vector_size(64), aligned(64), may_alias));
typedef double vec __attribute__((vector_size(64), may_alias));
enum { AT_ONCE = 4, LINE = 8 };

static ALWAYS_INLINE vec number(const double *quad, int field, int s) {
    (void)s;
    const v4 x = *(const v4 *)(quad + 4 * field);
    return __builtin_shufflevector(x, x, 0, 0, 1, 1, 2, 2, 3, 3);
}

static ALWAYS_INLINE vec join(v4 low, v4 high) {
    const vec wide = (vec)__builtin_ia32_pd512_256pd(low);
    return (vec)__builtin_ia32_insertf64x4_mask(wide, high, 1, wide, 0xff);
}

/* Rows of two components. */
static ALWAYS_INLINE void gather_2(const double *u, const int32_t *i, const int32_t *j, vec *c) {
    v4 d[4];
    for (int s = 0; s < 4; s++)
        d[s] = *(const v4 *)(u + j[s]) - *(const v4 *)(u + i[s]);
    const vec low = join(d[0], d[1]), high = join(d[2], d[3]);
    c[0] = __builtin_shufflevector(low, high, 0, 1, 4, 5, 8, 9, 12, 13);
    c[1] = __builtin_shufflevector(low, high, 2, 3, 6, 7, 10, 11, 14, 15);
}

/* Changes the signs of the components that are rotations: all three of them, the last one, or none. */
static ALWAYS_INLINE vec turn_back(int rotations, vec x) {
    const i8 last = {0, 0, 0, 0, INT64_MIN, INT64_MIN, 0, 0};
    if (rotations == 0)
        return x;
    return rotations == 3 ? -x : (vec)((i8)x ^ last);
}

/* Cache lines of three components each, and a fourth one that stays 0. */
static ALWAYS_INLINE void transpose_lines(const vec d[4], vec *c) {
    const vec low01 = __builtin_shufflevector(d[0], d[1], 0, 1, 2, 3, 8, 9, 10, 11);
    const vec low23 = __builtin_shufflevector(d[2], d[3], 0, 1, 2, 3, 8, 9, 10, 11);
    const vec high01 = __builtin_shufflevector(d[0], d[1], 4, 5, 6, 7, 12, 13, 14, 15);
    const vec high23 = __builtin_shufflevector(d[2], d[3], 4, 5, 6, 7, 12, 13, 14, 15);
    c[0] = __builtin_shufflevector(low01, low23, 0, 1, 4, 5, 8, 9, 12, 13);
    c[1] = __builtin_shufflevector(low01, low23, 2, 3, 6, 7, 10, 11, 14, 15);
    c[2] = __builtin_shufflevector(high01, high23, 0, 1, 4, 5, 8, 9, 12, 13);
}

static ALWAYS_INLINE void gather_line(int rotations, const double *u, const int32_t *i, const int32_t *j, vec *c) {
    vec d[4];
    for (int s = 0; s < 4; s++)
        d[s] = *(const vec *)(u + j[s]) - turn_back(rotations, *(const vec *)(u + i[s]));
    transpose_lines(d, c);
}

static ALWAYS_INLINE void load(quad_kind s, const double *u, const int32_t *i, const int32_t *j, vec *c) {
    switch (s.dim + s.rotations) {
    case 2: gather_2(u, i, j, c); break;
    case 3: gather_line(s.rotations, u, i, j, c); break;
    default:
        gather_line(0, u, i, j, c);
        gather_line(3, u + LINE, i, j, c + 3);
        break;
    }
}
