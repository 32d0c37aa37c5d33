/* The hot loops, in plain C over flat arrays that compilers can vectorize for any width. */
#include "packing/kernel.h"
#include "base/clones.h"
#include "packing/contact.h"

#include <math.h>

typedef double v4 __attribute__((vector_size(32), aligned(32), may_alias));
typedef int64_t mask4 __attribute__((vector_size(32)));

/* Overlap used for open pairs. It is tiny, but powers of its fourth root are still normal numbers; denormal ones would
 * be a hundred times slower. It is added rather than selected, because for a selection a compiler may compute the roots
 * of both. */
static const double NO_OVERLAP = 1e-40;

/* Of the largest rate: grains of a smaller one carry little. */
static const double WEAK = 0.15;

static ALWAYS_INLINE double larger(double a, double b) { return b > a ? b : a; }

static ALWAYS_INLINE void keep_larger(v4 *most, const v4 *one) {
    const mask4 less = *most < *one;
    *most = (v4)(((mask4)*one & less) | ((mask4)*most & ~less));
}

static ALWAYS_INLINE double largest(const v4 *a) { return larger(larger((*a)[0], (*a)[1]), larger((*a)[2], (*a)[3])); }

/* Position and sign of a row in the linked list, as in a slot. size: of a row */
static ALWAYS_INLINE int32_t row_position(int32_t size, int32_t c) { return size * (c >> 1) + (c & 1); }

/* Hertz's law for the gaps of a block: k_n = 2 E12 sqrt(R12 n), s = sqrt(m_eff k_n) and the elastic force (A1); all are
 * 0 for open pairs. It is a loop of its own, as others are below, because the chain of a root is long: in a short loop
 * a processor works on many pairs at a time. e2, sm: see pair_list */
static ALWAYS_INLINE void hertz(int32_t count, const double *restrict gap, const double *restrict e2,
                                const double *restrict sm, double *restrict kn, double *restrict s,
                                double *restrict elastic) {
#pragma GCC ivdep
    for (int32_t k = 0; k < (count & -8); k++) {
        const double overlap = 0.5 * (gap[k] + fabs(gap[k])) + NO_OVERLAP;
        const double u = inverse_fourth_root(overlap), root = overlap * u * u;
        const double kn_closed = e2[k] * root, s_closed = sm[k] * (overlap * u * u * u);
        const double kn_now = gap[k] > 0 ? kn_closed : 0;
        kn[k] = kn_now;
        s[k] = gap[k] > 0 ? s_closed : 0;
        elastic[k] = (2.0 / 3.0) * kn_now * overlap;
    }
}

/* The same for forces as n^a with another exponent: k_n = e2 n^(a - 1), s = sm n^((a - 1)/2). */
static void power_law(int32_t count, double exponent, const double *gap, const double *e2, const double *sm, double *kn,
                      double *s, double *elastic) {
    for (int32_t k = 0; k < (count & -8); k++) {
        const double overlap = gap[k] > 0 ? gap[k] : 0;
        const double slope = overlap > 0 ? contact_power(overlap, exponent - 1) : 0;
        kn[k] = e2[k] * slope;
        s[k] = sm[k] * sqrt(slope);
        elastic[k] = kn[k] * overlap / exponent;
    }
}

static ALWAYS_INLINE void normal_forces(const dynamics *d, int32_t first, int32_t count, const double *gap, double *kn,
                                        double *s, double *elastic) {
    const double *e2 = d->inner.e2 + first, *sm = d->inner.sm + first;
    if (d->law.exponent == 1.5)
        hertz(count, gap, e2, sm, kn, s, elastic);
    else
        power_law(count, d->law.exponent, gap, e2, sm, kn, s, elastic);
}

/* ---- 2D ------------------------------------------------------------------------------------------------------ */

typedef struct block2 {
    _Alignas(64) double d[4 * BLOCK]; /* x, y, vx, vy of j minus i */
    double spin[BLOCK];               /* w_i + w_j */
    double nx[BLOCK], ny[BLOCK], gap[BLOCK], vx[BLOCK], vy[BLOCK];
    double kn[BLOCK], elastic[BLOCK];
    double fx[BLOCK], fy[BLOCK], t[BLOCK], s[BLOCK];
} block2;

static inline void gather2(const dynamics *d, int32_t first, int32_t count, block2 *b) {
    const int32_t *restrict i = d->inner.at_i + first, *restrict j = d->inner.at_j + first;
    const double *restrict g = d->g;
    for (int32_t k = 0; k < (count & -8); k++) {
        const double *one = g + i[k], *two = g + j[k];
        *(v4 *)&b->d[4 * k] = *(const v4 *)two - *(const v4 *)one;
        b->spin[k] = one[4] + two[4];
    }
}

/* Normals, gaps and relative velocities. `affine`: images and strains along all axes. */
static ALWAYS_INLINE void distances2(const dynamics *d, int32_t first, int32_t count, block2 *b, const bool affine) {
    const pair_list *p = &d->inner;
    const double *restrict image = p->image + first, *restrict above = image + p->capacity, *restrict diff = b->d;
    const double *restrict reach = p->reach + first;
    double *restrict nx_out = b->nx, *restrict ny_out = b->ny, *restrict gap_out = b->gap;
    double *restrict vx_out = b->vx, *restrict vy_out = b->vy;
    const double side = d->period[0], height = d->piston_y, tilt = d->tilt[0];
    const double strain_rate = d->strain_rate[0], rise = d->strain_rate[1], shear = d->shear_rate[0];
#pragma GCC ivdep
    for (int32_t k = 0; k < (count & -8); k++) {
        double x = diff[4 * k + 0] + image[k] * side, y = diff[4 * k + 1];
        if (affine) {
            x += above[k] * tilt;
            y += above[k] * height;
        }
        const double r = sqrt(x * x + y * y), inverse = 1.0 / r;
        nx_out[k] = x * inverse;
        ny_out[k] = y * inverse;
        gap_out[k] = reach[k] - r;
        vx_out[k] = diff[4 * k + 2] + strain_rate * x;
        vy_out[k] = diff[4 * k + 3];
        if (affine) {
            vx_out[k] += shear * y;
            vy_out[k] += rise * y;
        }
    }
}

/* What a block is compiled for. rough: with friction; smooth grains have no rotations and no tangential forces.
 * lagging: dashpots feel averaged velocities. mixed: friction and k_t/k_n differ from pair to pair. affine: the cell
 * deforms along all axes. */
typedef struct variant {
    bool rough, lagging, mixed, affine;
} variant;

/* Appendix A of the paper for a block of pairs. Tangential springs stretch by the relative velocity times dt. */
static ALWAYS_INLINE void law2(const dynamics *d, double dt, int32_t first, int32_t count, block2 *b,
                               const variant is) {
    const pair_list *p = &d->inner;
    const double *restrict gaps = b->gap, *restrict stiff = b->kn, *restrict springs = b->elastic;
    const double *restrict nxs = b->nx, *restrict nys = b->ny, *restrict ss = b->s;
    const double *restrict dvx = b->vx, *restrict dvy = b->vy, *restrict spin = b->spin;
    double *restrict ft = p->ft + first, *restrict un = p->u + first, *restrict ut = un + p->capacity;
    double *restrict fx = b->fx, *restrict fy = b->fy, *restrict turn = b->t;
    const double *restrict mus = p->mu + first, *restrict etas = p->eta + first;
    const double mu_all = d->law.friction, eta_dt_all = d->law.eta * dt, sqrt_eta_all = d->law.sqrt_eta;
    const double two_zeta = 2.0 * d->law.damping, limit_all = d->law.viscous_limit, lag = d->lag;
#pragma GCC ivdep
    for (int32_t k = 0; k < (count & -8); k++) {
        double gap = gaps[k], nx = nxs[k], ny = nys[k], vx = dvx[k], vy = dvy[k], elastic = springs[k];
        double vn = vx * nx + vy * ny;
        double vt = vy * nx - vx * ny - spin[k]; /* relative velocity along (-ny, nx), rotations included */
        double slow_n = vn, slow_t = vt;         /* what dashpots feel */
        if (is.lagging) {
            slow_n = gap > 0 ? vn + lag * (un[k] - vn) : vn;
            un[k] = slow_n;
            slow_t = gap > 0 ? vt + lag * (ut[k] - vt) : vt;
            ut[k] = slow_t;
        }
        double viscous = two_zeta * ss[k];
        double normal = elastic - viscous * slow_n;
        normal = normal > 0 ? normal : 0; /* no attraction */
        if (!is.rough) {                  /* a packing that was made with friction may still bring tangential forces */
            ft[k] = 0;
            fx[k] = -normal * nx;
            fy[k] = -normal * ny;
            turn[k] = 0;
            continue;
        }
        const double mu = is.mixed ? mus[k] : mu_all, eta_dt = is.mixed ? etas[k] * dt : eta_dt_all;
        const double sqrt_eta = is.mixed ? sqrt(etas[k]) : sqrt_eta_all, mu_viscous = mu * limit_all;
        double cap = mu * elastic;                 /* (A3), for the elastic spring */
        double t = ft[k] + eta_dt * stiff[k] * vt; /* (A2): k_t = eta k_n */
        t = t > cap ? cap : t;
        t = t < -cap ? -cap : t;
        ft[k] = t;
        double total = t + viscous * sqrt_eta * slow_t, limit = mu_viscous * normal;
        total = total > limit ? limit : total;
        total = total < -limit ? -limit : total;
        fx[k] = -normal * nx - total * ny;
        fy[k] = -normal * ny + total * nx;
        turn[k] = total;
    }
}

static ALWAYS_INLINE void law2_any(const dynamics *d, double dt, int32_t first, int32_t count, block2 *b, variant is) {
    if (d->lag > 0)
        law2(d, dt, first, count, b, (variant){.rough = is.rough, .mixed = is.mixed, .lagging = true});
    else
        law2(d, dt, first, count, b, (variant){.rough = is.rough, .mixed = is.mixed});
}

/* Writes the forces of a block to its rows; `both`: also the opposite forces with the same torque to those of j.
 * Returns the largest rate of a single contact. */
static ALWAYS_INLINE double rows2(const dynamics *d, int32_t first, int32_t count, const block2 *b, const bool both) {
    const v4 other = {-1.0, -1.0, 1.0, 1.0};
    const double *light = d->inner.light + first;
    double *on_i = d->rows.row + 4 * (int64_t)first, *on_j = d->rows.row + 4 * ((int64_t)d->rows.other + first);
    v4 single = {0};
    for (int32_t k = 0; k < count; k += 4) {
        const v4 x = *(const v4 *)&b->fx[k], y = *(const v4 *)&b->fy[k];
        const v4 t = *(const v4 *)&b->t[k], s = *(const v4 *)&b->s[k];
        const v4 xy0 = __builtin_shufflevector(x, y, 0, 4, 2, 6), xy1 = __builtin_shufflevector(x, y, 1, 5, 3, 7);
        const v4 ts0 = __builtin_shufflevector(t, s, 0, 4, 2, 6), ts1 = __builtin_shufflevector(t, s, 1, 5, 3, 7);
        const v4 row[4] = {__builtin_shufflevector(xy0, ts0, 0, 1, 4, 5), __builtin_shufflevector(xy1, ts1, 0, 1, 4, 5),
                           __builtin_shufflevector(xy0, ts0, 2, 3, 6, 7),
                           __builtin_shufflevector(xy1, ts1, 2, 3, 6, 7)};
        for (int l = 0; l < 4; l++) {
            *(v4 *)&on_i[4 * (k + l)] = row[l];
            if (both)
                *(v4 *)&on_j[4 * (k + l)] = other * row[l];
        }
        const v4 rate = *(const v4 *)&light[k] * (SINGLE_CONTACT * s);
        keep_larger(&single, &rate);
    }
    return largest(&single);
}

/* What the row of a pair is multiplied with, for its i and its j: the force on j is opposite, the torque/R the same. */
static const double SIGN2[2][4] __attribute__((aligned(32))) = {{1, 1, 1, 1}, {-1, -1, 1, 1}};

static ALWAYS_INLINE void read2(const double *row, int32_t slot, const bool both, v4 *f) {
    if (both)
        *f = *(const v4 *)(row + slot);
    else
        *f = *(const v4 *)SIGN2[slot & 1] * *(const v4 *)(row + (slot & ~1));
}

CLONES double sp_kernel_pairs_2d(const dynamics *d, double dt_past, int32_t first, int32_t count) {
    block2 b;
    gather2(d, first, count, &b);
    if (d->affine)
        distances2(d, first, count, &b, true);
    else
        distances2(d, first, count, &b, false);
    normal_forces(d, first, count, b.gap, b.kn, b.s, b.elastic);
    if (d->law.friction > 0 && d->law.mixed)
        law2_any(d, dt_past, first, count, &b, (variant){.rough = true, .mixed = true});
    else if (d->law.friction > 0)
        law2_any(d, dt_past, first, count, &b, (variant){.rough = true});
    else
        law2_any(d, dt_past, first, count, &b, (variant){.rough = false});
    return d->rows.both ? rows2(d, first, count, &b, true) : rows2(d, first, count, &b, false);
}

/* sparing: see dynamics.sparing; loose are grains whose contacts are weak, or so few that they hardly hold them. */
static ALWAYS_INLINE kernel_maxima move2(const dynamics *d, double dt, int32_t first, int32_t last, const bool affine,
                                         const bool both, const bool sparing) {
    const double spare = d->drag * dt, full = 1.0 - spare, weak = WEAK * d->rate;
    const double strain = d->strain_rate[0] * dt, fall = d->gravity * dt;
    const double rise = d->strain_rate[1] * dt, shear = d->shear_rate[0] * dt;
    const double spin = d->law.spin, *restrict row = d->rows.row;
    const int32_t *restrict slot = d->rows.slot, *restrict count = d->rows.count;
    double v2 = 0, rate = 0;
    for (int32_t i = first; i < last; i++) {
        const int32_t *s = slot + SLOTS * (int64_t)i;
        double most = 0;
        v4 one[SLOTS];
        for (int k = 0; k < SLOTS; k++) { /* unused slots lead to a row of zeros */
            read2(row, s[k], both, &one[k]);
            if (sparing)
                most = larger(most, row[(s[k] & ~1) + 3]);
        }
        v4 f = ((one[0] + one[1]) + (one[2] + one[3])) + (one[4] + one[5]);
        if (count[i] > SLOTS)
            for (int32_t c = d->rows.further[i]; c >= 0; c = d->rows.chain[c]) {
                read2(row, row_position(4, c), both, &one[0]);
                f += one[0];
                most = larger(most, one[0][3]);
            }
        double *g = d->g + 8 * (int64_t)i, kick = dt * g[6], keep = full;
        if (sparing) {
            const double power = f[0] * g[2] + (f[1] - d->gravity / g[6]) * g[3] + f[2] * g[4];
            keep = full + (power > 0) * (g[6] * f[3] < weak || f[3] < 2 * most) * spare;
        }
        double vx = keep * g[2] + kick * f[0], vy = keep * g[3] + kick * f[1] - fall;
        g[0] += dt * vx + (affine ? strain * g[0] + shear * g[1] : strain * g[0]);
        g[1] += affine ? dt * vy + rise * g[1] : dt * vy;
        g[2] = vx;
        g[3] = vy;
        g[4] = keep * g[4] + spin * kick * f[2];
        v2 = larger(v2, vx * vx + vy * vy);
        rate = larger(rate, g[6] * f[3]);
    }
    return (kernel_maxima){v2, rate};
}

static ALWAYS_INLINE kernel_maxima move2_any(const dynamics *d, double dt, int32_t first, int32_t last,
                                             const bool affine, const bool both) {
    return d->sparing ? move2(d, dt, first, last, affine, both, true) : move2(d, dt, first, last, affine, both, false);
}

CLONES kernel_maxima sp_kernel_move_2d(const dynamics *d, double dt, int32_t first, int32_t last) {
    if (d->affine)
        return d->rows.both ? move2_any(d, dt, first, last, true, true) : move2_any(d, dt, first, last, true, false);
    return d->rows.both ? move2_any(d, dt, first, last, false, true) : move2_any(d, dt, first, last, false, false);
}

/* ---- 3D ------------------------------------------------------------------------------------------------------ */

/* A block is passed in pieces whose numbers fit in the nearest cache beside those of the pairs. Planes of PLANE numbers
 * do not begin at the same place of the cache. */
enum { PIECE = 32, PLANE = PIECE + 8 };

typedef struct block3 {
    _Alignas(64) double x[3][PLANE], v[3][PLANE]; /* of j minus i; later the normal and the slip velocity */
    double w[3][PLANE];                           /* w_i + w_j; later the torque/R */
    double turn[3][PLANE];                        /* sum of the angular velocities; later the tangential force */
    double u[3][PLANE];                           /* averaged slip velocity */
    double gap[PLANE], kn[PLANE], s[PLANE], elastic[PLANE]; /* of hertz */
    double along[PLANE], normal[PLANE];
} block3;

/* Transposes four vectors of four numbers. */
static ALWAYS_INLINE void transpose(v4 *a, v4 *b, v4 *c, v4 *d) {
    const v4 ab0 = __builtin_shufflevector(*a, *b, 0, 4, 2, 6), ab1 = __builtin_shufflevector(*a, *b, 1, 5, 3, 7);
    const v4 cd0 = __builtin_shufflevector(*c, *d, 0, 4, 2, 6), cd1 = __builtin_shufflevector(*c, *d, 1, 5, 3, 7);
    *a = __builtin_shufflevector(ab0, cd0, 0, 1, 4, 5);
    *b = __builtin_shufflevector(ab1, cd1, 0, 1, 4, 5);
    *c = __builtin_shufflevector(ab0, cd0, 2, 3, 6, 7);
    *d = __builtin_shufflevector(ab1, cd1, 2, 3, 6, 7);
}

/* Writes the first three numbers of four vectors to three planes. */
static ALWAYS_INLINE void spread(double plane[3][PLANE], int32_t k, v4 row[4]) {
    transpose(&row[0], &row[1], &row[2], &row[3]);
    for (int a = 0; a < 3; a++)
        *(v4 *)&plane[a][k] = row[a];
}

static ALWAYS_INLINE void gather3(const dynamics *d, int32_t first, int32_t count, block3 *b, const bool rough) {
    const int32_t *restrict i = d->inner.at_i + first, *restrict j = d->inner.at_j + first;
    const double *restrict g = d->g;
    for (int32_t k = 0; k < (count & -8); k += 4) {
        v4 x[4], v[4], w[4], turn[4];
        for (int l = 0; l < 4; l++) {
            const v4 *one = (const v4 *)(g + i[k + l]), *two = (const v4 *)(g + j[k + l]);
            x[l] = two[0] - one[0];
            v[l] = two[1] - one[1];
            if (rough) {
                w[l] = one[2] + two[2];
                turn[l] = one[2] * one[3][2] + two[2] * two[3][2];
            }
        }
        spread(b->x, k, x);
        spread(b->v, k, v);
        if (rough) {
            spread(b->w, k, w);
            spread(b->turn, k, turn);
        }
    }
}

/* Normals, which overwrite x, gaps, and relative velocities. */
static ALWAYS_INLINE void distances3(const dynamics *d, int32_t first, int32_t count, block3 *b, const bool affine) {
    const pair_list *p = &d->inner;
    const double *restrict ix = p->image + first, *restrict iy = ix + p->capacity, *restrict iz = iy + p->capacity;
    const double *restrict reach = p->reach + first;
    const double sx = d->period[0], sy = d->period[1], sz = d->piston_y, xy = d->tilt[0], xz = d->tilt[1];
    const double yz = d->tilt[2], rx = d->strain_rate[0], ry = d->strain_rate[1], rz = d->strain_rate[2];
    const double gxy = d->shear_rate[0], gxz = d->shear_rate[1], gyz = d->shear_rate[2];
#pragma GCC ivdep
    for (int32_t k = 0; k < (count & -8); k++) {
        double x = b->x[0][k] + ix[k] * sx, y = b->x[1][k] + iy[k] * sy, z = b->x[2][k];
        if (affine) {
            x += iy[k] * xy + iz[k] * xz;
            y += iz[k] * yz;
            z += iz[k] * sz;
        }
        double vx = b->v[0][k] + rx * x, vy = b->v[1][k] + ry * y;
        if (affine) {
            vx += gxy * y + gxz * z;
            vy += gyz * z;
            b->v[2][k] += rz * z;
        }
        b->v[0][k] = vx;
        b->v[1][k] = vy;
        const double r = sqrt(x * x + y * y + z * z), inverse = 1.0 / r;
        b->x[0][k] = x * inverse;
        b->x[1][k] = y * inverse;
        b->x[2][k] = z * inverse;
        b->gap[k] = reach[k] - r;
    }
}

/* Averaged velocities and normal forces. Smooth grains are done then: their forces overwrite x, and tangential forces
 * that a packing brings are dropped. */
static ALWAYS_INLINE void normals3(const dynamics *d, int32_t first, int32_t count, block3 *b, const bool rough,
                                   const bool lagging) {
    const pair_list *p = &d->inner;
    double *restrict ux = p->u + first, *restrict uy = ux + p->capacity, *restrict uz = uy + p->capacity;
    double *restrict tx = p->ft + first, *restrict ty = tx + p->capacity, *restrict tz = ty + p->capacity;
    const double two_zeta = 2.0 * d->law.damping, lag = d->lag;
#pragma GCC ivdep
    for (int32_t k = 0; k < (count & -8); k++) {
        const double nx = b->x[0][k], ny = b->x[1][k], nz = b->x[2][k], gap = b->gap[k];
        const double vx = b->v[0][k], vy = b->v[1][k], vz = b->v[2][k];
        double vn = vx * nx + vy * ny + vz * nz, slow = vn; /* slow: what dashpots feel */
        if (lagging) {
            const double wx = rough ? b->w[0][k] : 0, wy = rough ? b->w[1][k] : 0, wz = rough ? b->w[2][k] : 0;
            const double px = vx - (wy * nz - wz * ny), py = vy - (wz * nx - wx * nz), pz = vz - (wx * ny - wy * nx);
            const double qx = gap > 0 ? px + lag * (ux[k] - px) : px, qy = gap > 0 ? py + lag * (uy[k] - py) : py;
            const double qz = gap > 0 ? pz + lag * (uz[k] - pz) : pz;
            slow = qx * nx + qy * ny + qz * nz;
            ux[k] = qx;
            uy[k] = qy;
            uz[k] = qz;
            b->u[0][k] = qx - slow * nx;
            b->u[1][k] = qy - slow * ny;
            b->u[2][k] = qz - slow * nz;
        }
        double normal = b->elastic[k] - two_zeta * b->s[k] * slow;
        normal = normal > 0 ? normal : 0;
        b->along[k] = vn;
        b->normal[k] = normal;
        if (!rough) {
            tx[k] = ty[k] = tz[k] = 0;
            b->x[0][k] = -normal * nx;
            b->x[1][k] = -normal * ny;
            b->x[2][k] = -normal * nz;
        }
    }
}

/* Tangential springs: each turns about the normal with the pair's mean rotation, follows the direction of the normal,
 * keeps its length in both, and stretches by the slip. This and what follows have loops of their own because the chain
 * of all roots and quotients is so long that a processor would begin few pairs before others are done. */
static ALWAYS_INLINE void springs3(const dynamics *d, double dt, int32_t first, int32_t count, block3 *b,
                                   const bool mixed) {
    const pair_list *p = &d->inner;
    const double *restrict tx = p->ft + first, *restrict ty = tx + p->capacity, *restrict tz = ty + p->capacity;
    const double half_dt = 0.5 * dt, eta_dt = d->law.eta * dt, *restrict etas = p->eta + first;
#pragma GCC ivdep
    for (int32_t k = 0; k < (count & -8); k++) {
        const double nx = b->x[0][k], ny = b->x[1][k], nz = b->x[2][k], vn = b->along[k];
        const double wx = b->w[0][k], wy = b->w[1][k], wz = b->w[2][k];
        const double gx = b->v[0][k] - vn * nx - (wy * nz - wz * ny); /* slip velocity */
        const double gy = b->v[1][k] - vn * ny - (wz * nx - wx * nz);
        const double gz = b->v[2][k] - vn * nz - (wx * ny - wy * nx);
        const double twist = half_dt * (b->turn[0][k] * nx + b->turn[1][k] * ny + b->turn[2][k] * nz);
        const double ox = tx[k], oy = ty[k], oz = tz[k], old2 = ox * ox + oy * oy + oz * oz;
        double fx = ox + twist * (ny * oz - nz * oy), fy = oy + twist * (nz * ox - nx * oz);
        double fz = oz + twist * (nx * oy - ny * ox), fn = fx * nx + fy * ny + fz * nz;
        fx -= fn * nx;
        fy -= fn * ny;
        fz -= fn * nz;
        const double new2 = fx * fx + fy * fy + fz * fz, same = sqrt(old2 / (new2 + 1e-300));
        const double stretch = (mixed ? etas[k] * dt : eta_dt) * b->kn[k];
        b->v[0][k] = gx;
        b->v[1][k] = gy;
        b->v[2][k] = gz;
        b->turn[0][k] = same * fx + stretch * gx;
        b->turn[1][k] = same * fy + stretch * gy;
        b->turn[2][k] = same * fz + stretch * gz;
    }
}

/* Limits the springs by sliding, stores them, and adds the dashpots. */
static ALWAYS_INLINE void limits3(const dynamics *d, int32_t first, int32_t count, block3 *b, const bool lagging,
                                  const bool mixed) {
    const pair_list *p = &d->inner;
    const double *restrict mus = p->mu + first, *restrict etas = p->eta + first;
    double *restrict tx = p->ft + first, *restrict ty = tx + p->capacity, *restrict tz = ty + p->capacity;
    const double mu_all = d->law.friction, two_zeta = 2.0 * d->law.damping, sqrt_eta_all = d->law.sqrt_eta;
#pragma GCC ivdep
    for (int32_t k = 0; k < (count & -8); k++) {
        const double mu = mixed ? mus[k] : mu_all, sqrt_eta = mixed ? sqrt(etas[k]) : sqrt_eta_all;
        double fx = b->turn[0][k], fy = b->turn[1][k], fz = b->turn[2][k];
        const double cap = mu * b->elastic[k], size = sqrt(fx * fx + fy * fy + fz * fz);
        const double keep = cap / ((size > cap ? size : cap) + 1e-300), c = two_zeta * b->s[k] * sqrt_eta;
        fx *= keep;
        fy *= keep;
        fz *= keep;
        tx[k] = fx;
        ty[k] = fy;
        tz[k] = fz;
        b->turn[0][k] = fx + c * (lagging ? b->u : b->v)[0][k];
        b->turn[1][k] = fy + c * (lagging ? b->u : b->v)[1][k];
        b->turn[2][k] = fz + c * (lagging ? b->u : b->v)[2][k];
    }
}

/* Limits the whole tangential forces. Forces overwrite x. */
static ALWAYS_INLINE void forces3(const dynamics *d, int32_t first, int32_t count, block3 *b, const bool mixed) {
    const double mu_viscous_all = d->law.friction * d->law.viscous_limit, viscous_limit = d->law.viscous_limit;
    const double *restrict mus = d->inner.mu + first;
#pragma GCC ivdep
    for (int32_t k = 0; k < (count & -8); k++) {
        const double nx = b->x[0][k], ny = b->x[1][k], nz = b->x[2][k], normal = b->normal[k];
        double fx = b->turn[0][k], fy = b->turn[1][k], fz = b->turn[2][k];
        const double mu_viscous = mixed ? mus[k] * viscous_limit : mu_viscous_all;
        const double limit = mu_viscous * normal, total = sqrt(fx * fx + fy * fy + fz * fz);
        const double cut = limit / ((total > limit ? total : limit) + 1e-300);
        fx *= cut;
        fy *= cut;
        fz *= cut;
        b->w[0][k] = ny * fz - nz * fy;
        b->w[1][k] = nz * fx - nx * fz;
        b->w[2][k] = nx * fy - ny * fx;
        b->x[0][k] = fx - normal * nx;
        b->x[1][k] = fy - normal * ny;
        b->x[2][k] = fz - normal * nz;
    }
}

/* Smooth grains have rows without torques. single: as rows2 returns, one for each place in a vector. */
static ALWAYS_INLINE void rows3(const dynamics *d, int32_t first, int32_t count, const block3 *b, const bool rough,
                                v4 *single) {
    const int32_t size = rough ? 8 : 4;
    const double *light = d->inner.light + first;
    double *to = d->rows.row + size * (int64_t)first;
    for (int32_t k = 0; k < (count & -8); k += 4) {
        v4 force[4] = {*(const v4 *)&b->x[0][k], *(const v4 *)&b->x[1][k], *(const v4 *)&b->x[2][k],
                       *(const v4 *)&b->s[k]};
        const v4 rate = *(const v4 *)&light[k] * (SINGLE_CONTACT * force[3]);
        keep_larger(single, &rate);
        transpose(&force[0], &force[1], &force[2], &force[3]);
        for (int l = 0; l < 4; l++)
            *(v4 *)&to[size * (k + l)] = force[l];
        if (!rough)
            continue;
        v4 turn[4] = {*(const v4 *)&b->w[0][k], *(const v4 *)&b->w[1][k], *(const v4 *)&b->w[2][k], {0}};
        transpose(&turn[0], &turn[1], &turn[2], &turn[3]);
        for (int l = 0; l < 4; l++)
            *(v4 *)&to[size * (k + l) + 4] = turn[l];
    }
}

/* Appendix A of the paper for a block of pairs, as law2, with a vector for the tangential force. */
static ALWAYS_INLINE double pairs3(const dynamics *d, double dt, int32_t start, int32_t all, const variant is) {
    block3 b;
    v4 single = {0};
    for (int32_t first = start; first < start + all; first += PIECE) {
        const int32_t left = start + all - first, count = left < PIECE ? left : PIECE;
        gather3(d, first, count, &b, is.rough);
        distances3(d, first, count, &b, is.affine);
        normal_forces(d, first, count, b.gap, b.kn, b.s, b.elastic);
        normals3(d, first, count, &b, is.rough, is.lagging);
        if (is.rough) {
            springs3(d, dt, first, count, &b, is.mixed);
            limits3(d, first, count, &b, is.lagging, is.mixed);
            forces3(d, first, count, &b, is.mixed);
        }
        rows3(d, first, count, &b, is.rough, &single);
    }
    return largest(&single);
}

static ALWAYS_INLINE double pairs3_any(const dynamics *d, double dt, int32_t first, int32_t count, const variant is) {
    variant with = is;
    with.lagging = true;
    return d->lag > 0 ? pairs3(d, dt, first, count, with) : pairs3(d, dt, first, count, is);
}

/* Whether the grains have rotations, and rows with torques. */
static ALWAYS_INLINE bool turning(const dynamics *d) { return d->at.row > d->at.turn; }

static ALWAYS_INLINE double rough3(const dynamics *d, double dt, int32_t first, int32_t count, const bool affine) {
    return d->law.mixed ? pairs3_any(d, dt, first, count, (variant){.rough = true, .affine = affine, .mixed = true})
                        : pairs3_any(d, dt, first, count, (variant){.rough = true, .affine = affine});
}

CLONES double sp_kernel_pairs_3d(const dynamics *d, double dt_past, int32_t first, int32_t count) {
    if (turning(d))
        return d->affine ? rough3(d, dt_past, first, count, true) : rough3(d, dt_past, first, count, false);
    return d->affine ? pairs3_any(d, dt_past, first, count, (variant){.affine = true})
                     : pairs3_any(d, dt_past, first, count, (variant){.affine = false});
}

static const double SIGN3[2][4] __attribute__((aligned(32))) = {{1, 1, 1, 1}, {-1, -1, -1, 1}};

/* most: the largest rate of a row, if drag spares loose grains. */
static ALWAYS_INLINE void add3(const double *row, int32_t slot, const bool rough, const bool sparing, v4 *f, v4 *q,
                               double *most) {
    const v4 one = *(const v4 *)(row + (slot & ~1));
    *f += *(const v4 *)SIGN3[slot & 1] * one;
    if (sparing)
        *most = larger(*most, row[(slot & ~1) + 3]);
    if (rough)
        *q += *(const v4 *)(row + (slot & ~1) + 4);
}

static ALWAYS_INLINE kernel_maxima move3(const dynamics *d, double dt, int32_t first, int32_t last, const bool rough,
                                         const bool affine, const bool sparing) {
    const double spare = d->drag * dt, full = 1.0 - spare, weak = WEAK * d->rate, weight = d->gravity;
    const double strain[3] = {d->strain_rate[0] * dt, d->strain_rate[1] * dt, 0}, rise = d->strain_rate[2] * dt;
    const double shear[3] = {d->shear_rate[0] * dt, d->shear_rate[1] * dt, d->shear_rate[2] * dt};
    const double *restrict row = d->rows.row;
    double v2 = 0, rate = 0;
    for (int32_t i = first; i < last; i++) {
        const int32_t *s = d->rows.slot + SLOTS * (int64_t)i;
        v4 f = {0, 0, 0, 0}, q = f;
        double most = 0;
        for (int32_t k = 0; k < SLOTS; k++) /* unused slots lead to a row of zeros */
            add3(row, s[k], rough, sparing, &f, &q, &most);
        for (int32_t c = d->rows.further[i]; c >= 0; c = d->rows.chain[c])
            add3(row, row_position(rough ? 8 : 4, c), rough, sparing, &f, &q, &most);
        double *g = d->g + 16 * (int64_t)i, kick = dt * g[13], square = 0, keep = full;
        if (sparing) {
            const double spin = rough ? q[0] * g[8] + q[1] * g[9] + q[2] * g[10] : 0;
            const double power = f[0] * g[4] + f[1] * g[5] + (f[2] - weight / g[13]) * g[6] + spin;
            keep = full + (power > 0) * (g[13] * f[3] < weak || f[3] < 3 * most) * spare;
        }
        const double fall[3] = {0, 0, weight * dt};
        const double carried[3] = {strain[0] * g[0] + shear[0] * g[1] + shear[1] * g[2],
                                   strain[1] * g[1] + shear[2] * g[2], rise * g[2]};
        for (int a = 0; a < 3; a++) {
            double v = keep * g[4 + a] + kick * f[a] - fall[a];
            g[a] += dt * v + (affine ? carried[a] : strain[a] * g[a]);
            g[4 + a] = v;
            if (rough)
                g[8 + a] = keep * g[8 + a] + d->law.spin * kick * q[a];
            square += v * v;
        }
        v2 = larger(v2, square);
        rate = larger(rate, g[13] * f[3]);
    }
    return (kernel_maxima){v2, rate};
}

static ALWAYS_INLINE kernel_maxima move3_any(const dynamics *d, double dt, int32_t first, int32_t last,
                                             const bool rough, const bool affine) {
    return d->sparing ? move3(d, dt, first, last, rough, affine, true)
                      : move3(d, dt, first, last, rough, affine, false);
}

CLONES kernel_maxima sp_kernel_move_3d(const dynamics *d, double dt, int32_t first, int32_t last) {
    if (d->affine)
        return turning(d) ? move3_any(d, dt, first, last, true, true) : move3_any(d, dt, first, last, false, true);
    return turning(d) ? move3_any(d, dt, first, last, true, false) : move3_any(d, dt, first, last, false, false);
}
