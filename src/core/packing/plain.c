/* Reference code for forces and motion, slow and simple. */
#include "packing/plain.h"

#include "packing/contact.h"

#include <math.h>
#include <string.h>

typedef struct vector {
    double x, y, z;
} vector;

static double dot(vector a, vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static vector add(vector a, double s, vector b) { return (vector){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z}; }
static vector cross(vector a, vector b) {
    return (vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static vector limited(vector a, double limit) {
    const double size = sqrt(dot(a, a));
    return size > limit ? add((vector){0, 0, 0}, limit / size, a) : a;
}

/* Position or velocity of a grain. */
static vector read3(const dynamics *d, const double *at) { return (vector){at[0], at[1], d->dim == 3 ? at[2] : 0}; }

/* R times the angular velocity; in 2D the grain turns about z. */
static vector spin_of(const dynamics *d, int32_t i) {
    const double *w = dynamics_grain(d, i) + d->at.w;
    return d->dim == 3 ? (vector){w[0], w[1], w[2]} : (vector){0, 0, w[0]};
}

typedef struct touch {
    vector n, v;     /* normal from i to j; velocity of j relative to i */
    vector w, twist; /* sum of the R omega; sum of the omega */
    double e, overlap, m_eff;
} touch;

/* Appendix A of the paper for one closed contact: force on i and torque/R, n x f_t. Advances *ft by dt. */
static void law(const dynamics *d, const touch *c, double dt, vector *ft, vector *force, vector *turn) {
    const contact_law *law = &d->law;
    const double kn = contact_normal_stiffness(c->e, c->overlap), elastic = contact_force(c->e, c->overlap);
    const double viscous = 2 * law->damping * sqrt(c->m_eff * kn), vn = dot(c->v, c->n);
    const double normal = fmax(0, elastic - viscous * vn);
    const vector slip = add(add(c->v, -vn, c->n), -1, cross(c->w, c->n));
    const double before = sqrt(dot(*ft, *ft));
    vector t = add(*ft, 0.5 * dt * dot(c->twist, c->n), cross(c->n, *ft));
    t = add(t, -dot(t, c->n), c->n);
    const double after = sqrt(dot(t, t));
    if (d->dim == 3 && after > 0)
        t = add((vector){0, 0, 0}, before / after, t);
    t = limited(add(t, law->eta * kn * dt, slip), law->friction * elastic);
    *ft = t;
    t = add(t, viscous * law->sqrt_eta, slip);
    t = limited(t, law->friction * law->viscous_limit * normal);
    *turn = cross(c->n, t);
    *force = add(t, -normal, c->n);
}

static void add_force(dynamics *d, int32_t i, double sign, vector force, vector turn) {
    double *f = d->plain_f + 6 * (int64_t)i;
    f[0] += sign * force.x;
    f[1] += sign * force.y;
    f[2] += sign * force.z;
    f[3] += turn.x;
    f[4] += turn.y;
    f[5] += turn.z;
}

static void plain_pair(dynamics *d, int32_t k, double dt) {
    const pair_list *p = &d->outer;
    const int32_t i = p->i[k], j = p->j[k];
    const double *g = dynamics_grain(d, i), *h = dynamics_grain(d, j);
    const int64_t plane = p->capacity;
    vector x = add(read3(d, h), -1, read3(d, g));
    x.x += p->image[k] * d->period[0];
    x.y += d->dim == 3 ? p->image[k + plane] * d->period[1] : 0;
    const double r = sqrt(dot(x, x)), overlap = g[d->at.r] + h[d->at.r] - r;
    if (!(overlap > 0)) {
        for (int a = 0; a < (d->dim == 3 ? 3 : 1); a++)
            p->ft[k + a * plane] = 0;
        return;
    }
    touch c = {.n = add((vector){0, 0, 0}, 1 / r, x), .overlap = overlap};
    c.v = add(read3(d, h + d->at.v), -1, read3(d, g + d->at.v));
    c.v.x += d->strain_rate[0] * x.x;
    c.v.y += d->strain_rate[1] * x.y;
    c.w = add(spin_of(d, i), 1, spin_of(d, j));
    c.twist = add(add((vector){0, 0, 0}, 1 / g[d->at.r], spin_of(d, i)), 1 / h[d->at.r], spin_of(d, j));
    c.e = contact_stiffness(g[d->at.r], h[d->at.r]);
    c.m_eff = 1 / (g[d->at.inv_m] + h[d->at.inv_m]);
    double *ft = p->ft + k;
    vector t = d->dim == 3 ? (vector){ft[0], ft[plane], ft[2 * plane]} : (vector){-ft[0] * c.n.y, ft[0] * c.n.x, 0};
    vector force, turn;
    law(d, &c, dt, &t, &force, &turn);
    if (d->dim == 3)
        ft[0] = t.x, ft[plane] = t.y, ft[2 * plane] = t.z;
    else
        ft[0] = t.y * c.n.x - t.x * c.n.y;
    add_force(d, i, 1, force, turn);
    add_force(d, j, -1, force, turn);
    d->k_max = fmax(d->k_max, contact_normal_stiffness(c.e, overlap));
}

static void plain_wall(dynamics *d, int side, int32_t i, double dt) {
    const int up = d->dim - 1;
    const double *g = dynamics_grain(d, i), sign = side == 0 ? -1 : 1;
    double *ft = d->wall_ft[side] + (int64_t)up * i;
    const double overlap = g[d->at.r] - (side == 0 ? g[up] : d->piston_y - g[up]);
    if (!(overlap > 0)) {
        for (int a = 0; a < up; a++)
            ft[a] = 0;
        return;
    }
    touch c = {.n = d->dim == 3 ? (vector){0, 0, sign} : (vector){0, sign, 0}, .overlap = overlap};
    c.v = add((vector){0, 0, 0}, -1, read3(d, g + d->at.v));
    c.v = add(c.v, side == 0 ? 0 : sign * d->piston_v, c.n);
    c.w = spin_of(d, i);
    c.twist = add((vector){0, 0, 0}, 1 / g[d->at.r], c.w);
    c.e = sqrt(g[d->at.r]);
    c.m_eff = 1 / g[d->at.inv_m];
    vector t = {ft[0], d->dim == 3 ? ft[1] : 0, 0}, force, turn;
    law(d, &c, dt, &t, &force, &turn);
    ft[0] = t.x;
    if (d->dim == 3)
        ft[1] = t.y;
    add_force(d, i, 1, force, turn);
    d->wall_force[side] += -dot(force, c.n);
    const double kn = contact_normal_stiffness(c.e, overlap);
    d->k_max = fmax(d->k_max, kn);
    d->piston_k += side == 1 ? kn : 0;
}

void sp_plain_forces(dynamics *d, double dt_past) {
    memset(d->plain_f, 0, (size_t)d->n * 6 * sizeof *d->plain_f);
    d->wall_force[0] = d->wall_force[1] = d->piston_k = d->k_max = 0;
    for (int32_t k = 0; k < d->outer.n; k++)
        plain_pair(d, k, dt_past);
    for (int side = 0; side < 2; side++)
        for (int32_t k = 0; k < d->wall[side].n; k++)
            plain_wall(d, side, d->wall[side].i[k], dt_past);
}

void sp_plain_advance(dynamics *d, double dt) {
    const double keep = 1 - d->drag * dt;
    double v2 = 0;
    for (int32_t i = 0; i < d->n; i++) {
        double *g = dynamics_grain(d, i);
        const double *f = d->plain_f + 6 * (int64_t)i, kick = dt * g[d->at.inv_m];
        double square = 0;
        for (int a = 0; a < d->dim; a++) {
            double *v = g + d->at.v + a;
            *v = keep * *v + kick * f[a];
            g[a] += dt * *v + (a < d->dim - 1 ? d->strain_rate[a] * dt * g[a] : 0);
            square += *v * *v;
        }
        for (int a = 0; a < (d->dim == 3 ? 3 : 1); a++) /* I = 0.4 m R^2 */
            g[d->at.w + a] = keep * g[d->at.w + a] + 2.5 * kick * f[d->dim == 3 ? 3 + a : 5];
        v2 = fmax(v2, square);
    }
    d->v_max = sqrt(v2);
}
