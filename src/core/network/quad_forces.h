/* Forces of the springs of a chunk. forces.c and forces_wide.c include this file after their definitions of
 *   vec                               one number of one or several springs, in both lanes,
 *   AT_ONCE                           how many springs that is,
 *   number(quad, field, s)            a field of the springs s, s + 1, ... of a quad,
 *   load(kind, u, i, j, c)            the stretches c of their components, from the rows i and j,
 *   load_apart(u, i, j, c, own)       the same in 3D, and the rotations in the rows i and j,
 *   store(kind, x, i, j, on_i, on_j)  subtracts on_i from the rows i; unless j is NULL, adds the translations of on_j
 *                                     to the rows j and subtracts its rotations.
 * Each lane has the same operations in the same order with every kind of vector. */
#include "network/operator.h"

#include <stddef.h>

static ALWAYS_INLINE vec dot_vec(const vec a[3], const vec b[3]) { return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]; }

static ALWAYS_INLINE void cross_vec(const vec a[3], const vec b[3], vec out[3]) {
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* Forces of springs: what is to be subtracted from the components of i, and those of j. Translations have opposite
 * signs in j. */
typedef struct push {
    vec i[6], j[6];
} push;

static ALWAYS_INLINE void set_both(push *out, int a, vec x) { out->i[a] = out->j[a] = x; }

/* Stretches in c: x, y, and the turn at the contact. A force at rest turns with the contact: it changes along n by the
 * transverse stretch times the tilt. */
static ALWAYS_INLINE void push_plane(quad_kind s, const double *q, int at, const vec *c, push *out) {
    const quad_fields f = quad_fields_of(s);
    const vec nx = number(q, f.n, at), ny = number(q, f.n + 1, at);
    const vec normal = nx * c[0] + ny * c[1], across = nx * c[1] - ny * c[0];
    vec along = number(q, f.kn, at) * normal, side = {0};
    if (s.rotations) {
        side = number(q, f.kt, at) * (across - c[2]);
        set_both(out, 2, side);
    }
    if (s.prestress)
        side = side + number(q, f.kp, at) * across;
    if (s.carried && s.transposed)
        side -= number(q, f.tilt, at) * normal;
    else if (s.carried)
        along -= number(q, f.tilt, at) * across;
    const bool sides = s.rotations || s.prestress;
    set_both(out, 0, sides ? along * nx - side * ny : along * nx);
    set_both(out, 1, sides ? along * ny + side * nx : along * ny);
}

/* Adds what a force at rest contributes (spring.h has the equations): to the forces along n and in the plane, and to
 * the torques in `out`. own: rotations of i and j. */
static ALWAYS_INLINE void add_rest(quad_kind s, const double *q, int at, const vec n[3], vec normal, const vec *c,
                                   const vec own[2][3], vec *along, vec side[3], push *out) {
    const quad_fields f = quad_fields_of(s);
    const vec over_r = number(q, f.over_r, at), inverse[2] = {number(q, f.inverse, at), number(q, f.inverse + 1, at)};
    const vec ft[3] = {number(q, f.ft, at), number(q, f.ft + 1, at), number(q, f.ft + 2, at)};
    vec across[3], turned[3], normal_by_ft[3];
    cross_vec(n, ft, normal_by_ft);
    for (int a = 0; a < 3; a++)
        across[a] = c[a] - normal * n[a];
    if (s.transposed) {
        cross_vec(ft, c + 3, turned);
        const vec back = dot_vec(normal_by_ft, across) + dot_vec(ft, c + 3), tilt = over_r * normal;
        *along += over_r * dot_vec(n, turned);
        for (int a = 0; a < 3; a++) {
            side[a] -= tilt * ft[a] + over_r * turned[a];
            out->i[3 + a] -= inverse[0] * (back * n[a]);
            out->j[3 + a] -= inverse[1] * (back * n[a]);
        }
        return;
    }
    const vec half = inverse[0] * dot_vec(n, own[0]) + inverse[1] * dot_vec(n, own[1]);
    cross_vec(ft, across, turned);
    *along -= over_r * dot_vec(ft, across);
    for (int a = 0; a < 3; a++) {
        side[a] += half * normal_by_ft[a];
        set_both(out, 3 + a, out->i[3 + a] - (half * ft[a] + over_r * turned[a]));
    }
}

/* Stretches in c: x, y, z, and the turns at the contact. */
static ALWAYS_INLINE void push_space(quad_kind s, const double *q, int at, const vec *c, const vec own[2][3],
                                     push *out) {
    const quad_fields f = quad_fields_of(s);
    const vec n[3] = {number(q, f.n, at), number(q, f.n + 1, at), number(q, f.n + 2, at)}, normal = dot_vec(n, c);
    vec along = number(q, f.kn, at) * normal, side[3] = {{0}};
    if (s.rotations) {
        const vec kt = number(q, f.kt, at);
        vec lever[3], torque[3];
        cross_vec(c + 3, n, lever);
        for (int a = 0; a < 3; a++)
            side[a] = kt * ((c[a] - normal * n[a]) - lever[a]);
        cross_vec(n, side, torque);
        for (int a = 0; a < 3; a++)
            set_both(out, 3 + a, torque[a]);
        /* projects once more, as the energy does: n is a unit vector up to rounding only */
        along -= dot_vec(side, n);
    }
    if (s.prestress) {
        const vec kp = number(q, f.kp, at);
        for (int a = 0; a < 3; a++)
            side[a] = s.rotations ? side[a] + kp * c[a] : kp * c[a];
        along -= kp * normal;
    }
    if (s.carried)
        add_rest(s, q, at, n, normal, c, own, &along, side, out);
    for (int a = 0; a < 3; a++)
        set_both(out, a, s.rotations || s.prestress ? side[a] + along * n[a] : along * n[a]);
}

static ALWAYS_INLINE void add_quads(quad_kind s, const sp_spring_set *set, int32_t chunk, bool both, int32_t first,
                                    const double *restrict u, double *restrict force) {
    const double *end = set->quads + set->first[chunk + 1] * quad_size(s);
    for (const double *q = set->quads + set->first[chunk] * quad_size(s); q < end; q += quad_size(s)) {
        const quad_rows *i = quad_rows_of(s, q), *j = i + 4;
        for (int at = 0; at < 4; at += AT_ONCE) {
            vec c[6], own[2][3];
            push out;
            if (s.carried && s.dim == 3 && !s.transposed)
                load_apart(u, i + at, j + at, c, own);
            else
                load(s, u, i + at, j + at, c);
            if (s.dim == 1)
                set_both(&out, 0, number(q, quad_fields_of(s).kn, at) * c[0]);
            else if (s.dim == 2)
                push_plane(s, q, at, c, &out);
            else
                push_space(s, q, at, c, own, &out);
            store(s, force - (ptrdiff_t)first * quad_row(s.dim + s.rotations), i + at, both ? j + at : NULL, out.i,
                  out.j);
        }
    }
}

static ALWAYS_INLINE void add_both(quad_kind s, const sp_operator *op, int32_t chunk, int32_t first,
                                   const double *restrict u, double *restrict force) {
    add_quads(s, &op->inner, chunk, true, first, u, force);
    add_quads(s, &op->border, chunk, false, first, u, force);
}

static void add_carried(const sp_operator *op, int32_t chunk, int32_t first, const double *restrict u,
                        double *restrict force) {
    if (op->kind.dim == 2)
        op->kind.transposed ? add_both((quad_kind){2, 1, true, true, true}, op, chunk, first, u, force)
                            : add_both((quad_kind){2, 1, true, true, false}, op, chunk, first, u, force);
    else
        op->kind.transposed ? add_both((quad_kind){3, 3, true, true, true}, op, chunk, first, u, force)
                            : add_both((quad_kind){3, 3, true, true, false}, op, chunk, first, u, force);
}

static ALWAYS_INLINE void add_kinds(bool prestress, const sp_operator *op, int32_t chunk, int32_t first,
                                    const double *restrict u, double *restrict force) {
    switch (op->dof) {
    case 1:
        if (AT_ONCE == 1) /* chains gain nothing by more */
            add_both((quad_kind){1, 0, false, false, false}, op, chunk, first, u, force);
        break;
    case 2: add_both((quad_kind){2, 0, prestress, false, false}, op, chunk, first, u, force); break;
    case 3:
        if (op->kind.dim == 2)
            add_both((quad_kind){2, 1, prestress, false, false}, op, chunk, first, u, force);
        else
            add_both((quad_kind){3, 0, prestress, false, false}, op, chunk, first, u, force);
        break;
    default: add_both((quad_kind){3, 3, prestress, false, false}, op, chunk, first, u, force); break;
    }
}

static void add_chunk(const sp_operator *op, int32_t chunk, int32_t first, const double *restrict u,
                      double *restrict force) {
    if (op->kind.carried)
        add_carried(op, chunk, first, u, force);
    else if (op->kind.prestress)
        add_kinds(true, op, chunk, first, u, force);
    else
        add_kinds(false, op, chunk, first, u, force);
}
