/* Forces of the springs of a chunk in vectors of eight: four springs, two lanes. */
#include "base/clones.h"
#include "network/operator.h"

#include <stddef.h>

#ifdef MACHINES
#pragma GCC push_options
#pragma GCC target("arch=x86-64-v4,prefer-vector-width=512")

#include "network/wide_loads.h"

static ALWAYS_INLINE void scatter_2(double *x, const int32_t *i, const int32_t *j, const vec *f) {
    const vec low = __builtin_shufflevector(f[0], f[1], 0, 1, 8, 9, 2, 3, 10, 11);
    const vec high = __builtin_shufflevector(f[0], f[1], 4, 5, 12, 13, 6, 7, 14, 15);
    const v4 of[4] = {__builtin_shufflevector(low, low, 0, 1, 2, 3), __builtin_shufflevector(low, low, 4, 5, 6, 7),
                      __builtin_shufflevector(high, high, 0, 1, 2, 3), __builtin_shufflevector(high, high, 4, 5, 6, 7)};
    for (int s = 0; s < 4; s++) {
        *(v4 *)(x + i[s]) -= of[s];
        if (j)
            *(v4 *)(x + j[s]) += of[s];
    }
}

/* Two components of xy and one of z, and 0. */
static ALWAYS_INLINE vec line_of(vec xy, i8 which, vec z) {
    return (vec)__builtin_ia32_vpermt2varpd512_maskz(which, xy, z, 0x3f);
}

static ALWAYS_INLINE void transpose_back(const vec *c, vec to[4]) {
    const vec low = __builtin_shufflevector(c[0], c[1], 0, 1, 2, 3, 8, 9, 10, 11);
    const vec high = __builtin_shufflevector(c[0], c[1], 4, 5, 6, 7, 12, 13, 14, 15);
    to[0] = line_of(low, (i8){0, 1, 4, 5, 8, 9}, c[2]);
    to[1] = line_of(low, (i8){2, 3, 6, 7, 10, 11}, c[2]);
    to[2] = line_of(high, (i8){0, 1, 4, 5, 12, 13}, c[2]);
    to[3] = line_of(high, (i8){2, 3, 6, 7, 14, 15}, c[2]);
}

static ALWAYS_INLINE void scatter_line(int rotations, double *x, const int32_t *i, const int32_t *j, const vec *on_i,
                                       const vec *on_j) {
    vec to_i[4], to_j[4];
    transpose_back(on_i, to_i);
    transpose_back(on_j, to_j);
    for (int s = 0; s < 4; s++) {
        *(vec *)(x + i[s]) -= to_i[s];
        if (j)
            *(vec *)(x + j[s]) += turn_back(rotations, to_j[s]);
    }
}

static ALWAYS_INLINE void load_apart(const double *u, const int32_t *i, const int32_t *j, vec *c, vec own[2][3]) {
    vec d[2][4];
    gather_line(0, u, i, j, c);
    for (int s = 0; s < 4; s++) {
        d[0][s] = *(const vec *)(u + i[s] + LINE);
        d[1][s] = *(const vec *)(u + j[s] + LINE);
    }
    for (int end = 0; end < 2; end++)
        transpose_lines(d[end], own[end]);
    for (int a = 0; a < 3; a++)
        c[3 + a] = own[1][a] + own[0][a];
}

static ALWAYS_INLINE void store(quad_kind s, double *x, const int32_t *i, const int32_t *j, const vec *on_i,
                                const vec *on_j) {
    switch (s.dim + s.rotations) {
    case 2: scatter_2(x, i, j, on_i); break;
    case 3: scatter_line(s.rotations, x, i, j, on_i, on_j); break;
    default:
        scatter_line(0, x, i, j, on_i, on_j);
        scatter_line(3, x + LINE, i, j, on_i + 3, on_j + 3);
        break;
    }
}

#include "network/quad_forces.h"

#pragma GCC pop_options

bool sp_operator_wide(void) {
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl");
}

void sp_operator_force_wide(const sp_operator *op, int32_t block, int32_t chunk, const double *restrict u,
                            double *restrict force) {
    add_chunk(op, chunk, op->first[block], u, force);
}
#else
bool sp_operator_wide(void) { return false; }

void sp_operator_force_wide(const sp_operator *op, int32_t block, int32_t chunk, const double *u, double *force) {
    (void)op, (void)block, (void)chunk, (void)u, (void)force;
}
#endif
