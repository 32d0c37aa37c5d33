#ifndef SP_SPRING_H
#define SP_SPRING_H
/* Stretch and force of one spring, in plain code. A pair is one component of two vectors; for one vector its second
 * entry is unused. The same code serves all dimensions, with and without rotations, for one vector or
 * two interleaved ones: its first argument is a compile-time constant at each call. */

#include "base/vector.h"
#include "network/quads.h"

#include <sonopack/network.h>

typedef struct shape {
    int dim, rotations, lanes;
    bool prestress;
    bool carried, transposed; /* forces at rest rotate with the contact; apply K^T */
} shape;

static ALWAYS_INLINE pair load(shape s, const double *p) {
    pair x = {p[0], 0};
    if (s.lanes == 2)
        x = *(const pair_memory *)p;
    return x;
}

static ALWAYS_INLINE void add(shape s, double *p, pair x) {
    if (s.lanes == 2)
        *(pair_memory *)p += x;
    else
        p[0] += x[0];
}

/* Relative displacement of a spring (Appendix A): along n; transverse, without rotations; tangential at the contact
 * point, including rotations. In 2D there is one tangential component, along (-ny, nx). */
typedef struct stretch {
    pair normal, transverse[3], tangential[3];
} stretch;

static ALWAYS_INLINE stretch stretch_of(shape s, const sp_spring *c, const double *ui, const double *uj) {
    const pair zero = {0, 0};
    stretch e = {zero, {zero, zero, zero}, {zero, zero, zero}};
    pair d[3] = {zero, zero, zero}, turn[3] = {zero, zero, zero};
    for (int a = 0; a < s.dim; a++)
        d[a] = (uj ? load(s, uj + a * s.lanes) : zero) - load(s, ui + a * s.lanes);
    for (int a = 0; a < s.rotations; a++) {
        const int at = (s.dim + a) * s.lanes;
        turn[a] = c->ri * load(s, ui + at) + (uj ? c->rj * load(s, uj + at) : zero);
    }
    e.normal = c->n[0] * d[0];
    for (int a = 1; a < s.dim; a++)
        e.normal += c->n[a] * d[a];
    if (s.dim == 2) {
        e.transverse[0] = c->n[0] * d[1] - c->n[1] * d[0];
        e.tangential[0] = e.transverse[0] - turn[0];
    } else if (s.dim == 3) {
        for (int a = 0; a < 3; a++) {
            const int b = (a + 1) % 3, g = (a + 2) % 3;
            e.transverse[a] = d[a] - e.normal * c->n[a];
            e.tangential[a] = e.transverse[a] - (turn[b] * c->n[g] - turn[g] * c->n[b]);
        }
    }
    return e;
}

static ALWAYS_INLINE void cross_pair(const double a[3], const pair b[3], pair out[3]) {
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static ALWAYS_INLINE pair dot_pair(const double a[3], const pair b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Contribution of the tangential force F t at rest in 2D: when the normal n turns towards t, F t turns towards -n. */
static ALWAYS_INLINE void add_carried_2d(shape s, const sp_spring *c, const sp_carried *held, const stretch *e,
                                         double *oi, double *oj) {
    const double tilt = held->turn * (held->ft[1] * c->n[0] - held->ft[0] * c->n[1]);
    const double x = s.transposed ? -c->n[1] : c->n[0], y = s.transposed ? c->n[0] : c->n[1];
    const pair force = -tilt * (s.transposed ? e->normal : e->transverse[0]);
    add(s, oi, -force * x);
    add(s, oi + s.lanes, -force * y);
    if (oj) {
        add(s, oj, force * x);
        add(s, oj + s.lanes, force * y);
    }
}

/* Contribution of the tangential force F at rest in 3D. With the pair's rotation w = (theta_i + theta_j) . n, the
 * transverse displacement e and the turn e/r of the normal,
 *
 *   dF = 1/2 w n x F - (F . e)/r n,    d(n x F) = -1/2 w F + (e x F)/r,
 *
 * and d(n x F) acts through the lever arms. The transpose exchanges displacements and forces. */
static ALWAYS_INLINE void add_carried_3d(shape s, const sp_spring *c, const sp_carried *held, const stretch *e,
                                         const double *ui, const double *uj, double *oi, double *oj) {
    const double *n = c->n, *f = held->ft;
    double side[3];
    cross3(n, f, side);
    pair spin[3], arm[3], force[3], turn[3];
    for (int a = 0; a < 3; a++) {
        const pair one = load(s, ui + (3 + a) * s.lanes);
        const pair two = uj ? load(s, uj + (3 + a) * s.lanes) : (pair){0, 0};
        spin[a] = one + two;
        arm[a] = c->ri * one + c->rj * two;
    }
    if (s.transposed) {
        pair tilted[3];
        cross_pair(f, arm, tilted);
        const pair off = dot_pair(n, tilted), back = 0.5 * (dot_pair(side, e->transverse) + dot_pair(f, arm));
        for (int a = 0; a < 3; a++) {
            force[a] = -held->turn * (f[a] * e->normal + tilted[a] - off * n[a]);
            turn[a] = back * n[a];
        }
    } else {
        const pair half = 0.5 * dot_pair(n, spin), tilt = held->turn * dot_pair(f, e->transverse);
        cross_pair(f, e->transverse, turn);
        for (int a = 0; a < 3; a++) {
            force[a] = half * side[a] - tilt * n[a];
            turn[a] = half * f[a] + held->turn * turn[a]; /* -d(n x F) */
        }
    }
    for (int a = 0; a < 3; a++) {
        add(s, oi + a * s.lanes, -force[a]);
        add(s, oi + (3 + a) * s.lanes, (s.transposed ? 1 : c->ri) * turn[a]);
        if (oj) {
            add(s, oj + a * s.lanes, force[a]);
            add(s, oj + (3 + a) * s.lanes, (s.transposed ? 1 : c->rj) * turn[a]);
        }
    }
}

/* Subtracts the forces on both grains, that is, adds the gradient of the spring's energy and the contribution of the
 * forces at rest. held is NULL unless s.carried. */
static ALWAYS_INLINE void add_spring(shape s, const sp_spring *c, const sp_carried *held, const double *ui,
                                     const double *uj, double *oi, double *oj) {
    const stretch e = stretch_of(s, c, ui, uj);
    const pair along = c->kn * e.normal;
    pair f[3], q[3] = {{0, 0}, {0, 0}, {0, 0}}, side[3];
    for (int a = 0; a < 3; a++) {
        if (s.rotations)
            q[a] = c->kt * e.tangential[a];
        side[a] = s.prestress ? q[a] + c->kp * e.transverse[a] : q[a];
    }
    for (int a = 0; a < s.dim; a++)
        f[a] = along * c->n[a];
    if (s.dim == 2 && (s.rotations || s.prestress)) {
        f[0] -= side[0] * c->n[1];
        f[1] += side[0] * c->n[0];
    } else if (s.dim == 3) {
        /* projects twice, as the energy does: n is a unit vector up to rounding only, which matters if k_t is large */
        const pair off = side[0] * c->n[0] + side[1] * c->n[1] + side[2] * c->n[2];
        for (int a = 0; a < 3; a++)
            f[a] += side[a] - off * c->n[a];
    }
    for (int a = 0; a < s.dim; a++) {
        add(s, oi + a * s.lanes, -f[a]);
        if (oj)
            add(s, oj + a * s.lanes, f[a]);
    }
    for (int a = 0; a < s.rotations; a++) {
        const int b = (a + 1) % 3, g = (a + 2) % 3, at = (s.dim + a) * s.lanes;
        const pair torque = s.dim == 2 ? -q[0] : c->n[g] * q[b] - c->n[b] * q[g]; /* -n x q */
        add(s, oi + at, c->ri * torque);
        if (oj)
            add(s, oj + at, c->rj * torque);
    }
    if (s.carried && s.dim == 2)
        add_carried_2d(s, c, held, &e, oi, oj);
    else if (s.carried && s.dim == 3)
        add_carried_3d(s, c, held, &e, ui, uj, oi, oj);
}

#endif
