#ifndef SP_QUADS_H
#define SP_QUADS_H
/* Springs in fours. A quad has the numbers of four springs, [fields][4], and then where their rows begin in a
 * vector, i[4] and j[4], as integers. Its fields depend on the kind of network, which is a compile-time constant where
 * they are used. */

#include "base/clones.h"

#include <stdbool.h>
#include <stdint.h>

/* One component of two vectors (lanes). */
typedef double pair __attribute__((vector_size(16)));
typedef pair pair_memory __attribute__((may_alias));
typedef int32_t quad_rows __attribute__((may_alias));

/* A sum of any number of terms with the error of one rounding (Knuth's exact sum of two numbers). Equal terms, as of a
 * regular wall, would otherwise be rounded alike, and errors grow with their number. */
typedef struct pair_sum {
    pair high, low;
} pair_sum;
static ALWAYS_INLINE void pair_add(pair_sum *s, pair x) {
    const pair sum = s->high + x, part = sum - s->high;
    s->low += (s->high - (sum - part)) + (x - part);
    s->high = sum;
}
static ALWAYS_INLINE pair pair_total(const pair_sum *s) { return s->high + s->low; }

typedef struct quad_kind {
    int dim, rotations; /* rotations of a grain: 0, 1 or 3 */
    bool prestress;
    bool carried, transposed; /* forces at rest rotate with the contact; apply K^T */
} quad_kind;

/* Indices of the fields. Only those exist that the kind needs. */
typedef struct quad_fields {
    int n, kn, kt, kp; /* n: 2D and 3D. In a chain, where it is +-1, it would cancel. */
    int tilt;          /* carried, 2D: force at rest over distance */
    int ft, over_r;    /* carried, 3D: force at rest, and one over the distance */
    int inverse;       /* carried, 3D: one half over the radii of i and j; 0 for a wall */
    int count;
} quad_fields;

static ALWAYS_INLINE quad_fields quad_fields_of(quad_kind s) {
    quad_fields f = {0};
    const bool plane = s.carried && s.dim == 2, space = s.carried && s.dim == 3;
    f.kn = s.dim > 1 ? s.dim : 0;
    f.kt = f.kn + 1;
    f.kp = f.kt + (s.rotations > 0);
    f.tilt = f.ft = f.kp + s.prestress;
    f.over_r = f.ft + 3;
    f.inverse = f.over_r + 1;
    f.count = f.tilt + (plane ? 1 : space ? 6 : 0);
    return f;
}

/* Doubles per row of a vector. Three components in two lanes are filled up to a cache line. */
static ALWAYS_INLINE int quad_row(int dof) { return dof < 3 ? 2 * dof : 8 * (dof / 3); }

/* Where component a begins in its row. */
static ALWAYS_INLINE int quad_component(int a) { return a < 3 ? 2 * a : 2 * (a + 1); }

/* Doubles per quad: four numbers a field, and eight integers. */
static ALWAYS_INLINE int quad_size(quad_kind s) { return 4 * quad_fields_of(s).count + 4; }

/* The rows of a quad, i[4] and j[4], behind its fields of four. */
static ALWAYS_INLINE const quad_rows *quad_rows_behind(int fields, const double *quad) {
    return (const quad_rows *)(quad + 4 * fields);
}

static ALWAYS_INLINE const quad_rows *quad_rows_of(quad_kind s, const double *quad) {
    return quad_rows_behind(quad_fields_of(s).count, quad);
}

#endif
