/* Reference code for forces and motion, slow and simple. */
#include "packing/plain.h"

#include "packing/contact.h"
#include "packing/mindlin.h"

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
    vector n, v;              /* normal from i to j; velocity of j relative to i */
    vector w, twist;          /* sum of the R omega; sum of the omega */
    double e, overlap, m_eff; /* e: E12 sqrt(R12) */
    const contact_rule *rule;
    vector along; /* history: direction of the scalar force */
    double *past; /* history, with its stride; NULL without */
    int64_t stride;
} touch;

/* The elastic tangential force after the slip of a step, with history. */
static vector remembered(const touch *c, vector ft, double limit, double stiffness, vector slip, double dt) {
    const double force =
        sp_mindlin_slip(c->past, c->stride, dot(ft, c->along), limit, stiffness, dot(slip, c->along) * dt);
    return add((vector){0, 0, 0}, force, c->along);
}

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
    if (c->past)
        t = remembered(c, *ft, c->rule->friction * elastic, c->rule->eta * kn, slip, dt);
    else
        t = limited(add(t, c->rule->eta * kn * dt, slip), c->rule->friction * elastic);
    *ft = t;
    t = add(t, viscous * c->rule->sqrt_eta, slip);
    t = limited(t, c->rule->friction * law->viscous_limit * normal);
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

/* The sum of the lattice vectors that lead to the image. */
static vector image_of(const dynamics *d, int32_t k) {
    const double *image = d->outer.image + k, *tilt = d->tilt;
    const int64_t plane = d->outer.capacity;
    vector x = {image[0] * d->period[0], 0, 0};
    x = add(x, image[plane], (vector){tilt[0], dynamics_edge(d, 1), 0});
    return d->dim == 3 ? add(x, image[2 * plane], (vector){tilt[1], tilt[2], d->piston_y}) : x;
}

/* Where the cell's deformation carries x within a time. */
static vector flow(const dynamics *d, vector x, double time) {
    const double *rate = d->strain_rate, *shear = d->shear_rate;
    return (vector){rate[0] * time * x.x + shear[0] * time * x.y + shear[1] * time * x.z,
                    rate[1] * time * x.y + shear[2] * time * x.z, rate[2] * time * x.z};
}

static void plain_pair(dynamics *d, int32_t k, double dt) {
    const pair_list *p = &d->outer;
    const int32_t i = p->i[k], j = p->j[k];
    const double *g = dynamics_grain(d, i), *h = dynamics_grain(d, j);
    const int64_t plane = p->capacity;
    vector x = add(read3(d, h), -1, read3(d, g));
    x = add(x, 1, image_of(d, k));
    const double r = sqrt(dot(x, x)), overlap = g[d->at.r] + h[d->at.r] - r;
    if (!(overlap > 0)) {
        for (int a = 0; a < dynamics_kept(d); a++)
            p->ft[k + a * plane] = 0;
        return;
    }
    touch c = {.n = add((vector){0, 0, 0}, 1 / r, x), .overlap = overlap, .stride = plane};
    c.past = d->at.past > 0 ? p->ft + k + d->at.forces * plane : NULL;
    c.along = (vector){-c.n.y, c.n.x, 0};
    c.v = add(read3(d, h + d->at.v), -1, read3(d, g + d->at.v));
    c.v = add(c.v, 1, flow(d, x, 1));
    c.w = add(spin_of(d, i), 1, spin_of(d, j));
    c.twist = add(add((vector){0, 0, 0}, 1 / g[d->at.r], spin_of(d, i)), 1 / h[d->at.r], spin_of(d, j));
    c.rule = dynamics_rule(d, i, j);
    c.e = c.rule->stiffness * contact_stiffness(g[d->at.r], h[d->at.r]);
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
    const int forces = d->dim - 1;
    const wall_frame frame = dynamics_wall(d, side);
    const double *g = dynamics_grain(d, i), distance = dynamics_wall_distance(d, side, g);
    double *ft = d->wall_ft[side] + (int64_t)forces * i, normal[3] = {0, 0, 0}, old[3] = {0, 0, 0};
    const double overlap = g[d->at.r] - distance;
    double *past = d->at.past > 0 ? d->wall_past[side] + (int64_t)d->at.past * i : NULL;
    if (!(overlap > 0)) {
        for (int a = 0; a < forces; a++)
            ft[a] = 0;
        for (int a = 0; a < d->at.past; a++)
            past[a] = 0;
        return;
    }
    normal[frame.axis] = frame.sign;
    for (int a = 0; a < forces; a++)
        old[frame.along[a]] = ft[a];
    touch c = {.n = {normal[0], normal[1], normal[2]}, .overlap = overlap, .past = past, .stride = 1};
    c.along = (vector){frame.along[0] == 0, frame.along[0] == 1, 0};
    c.v = add((vector){0, 0, 0}, -1, read3(d, g + d->at.v));
    c.v = add(c.v, side == 1 ? d->piston_v : 0, c.n);
    c.v = add(c.v, d->strain_rate[frame.axis] * distance, c.n);
    c.w = spin_of(d, i);
    c.twist = add((vector){0, 0, 0}, 1 / g[d->at.r], c.w);
    c.rule = dynamics_wall_rule(d, i);
    c.e = c.rule->stiffness * sqrt(g[d->at.r]);
    c.m_eff = 1 / g[d->at.inv_m];
    vector t = {old[0], old[1], old[2]}, force, turn;
    law(d, &c, dt, &t, &force, &turn);
    const double new[3] = {t.x, t.y, t.z};
    for (int a = 0; a < forces; a++)
        ft[a] = new[frame.along[a]];
    add_force(d, i, 1, force, turn);
    d->wall_force[side] += -dot(force, c.n);
    const double kn = contact_normal_stiffness(c.e, overlap);
    d->k_max = fmax(d->k_max, kn);
    d->piston_k += side == 1 ? kn : 0;
}

void sp_plain_forces(dynamics *d, double dt_past) {
    memset(d->plain_f, 0, (size_t)d->n * 6 * sizeof *d->plain_f);
    memset(d->wall_force, 0, sizeof d->wall_force);
    d->piston_k = d->k_max = 0;
    for (int32_t k = 0; k < d->outer.n; k++)
        plain_pair(d, k, dt_past);
    for (int side = 0; side < d->walls; side++)
        for (int32_t k = 0; k < d->wall[side].n; k++)
            plain_wall(d, side, d->wall[side].i[k], dt_past);
}

void sp_plain_advance(dynamics *d, double dt) {
    const double keep = 1 - d->drag * dt;
    double v2 = 0;
    for (int32_t i = 0; i < d->n; i++) {
        double *g = dynamics_grain(d, i);
        const double *f = d->plain_f + 6 * (int64_t)i, kick = dt * g[d->at.inv_m];
        const vector u = flow(d, read3(d, g), dt);
        const double carried[3] = {u.x, u.y, u.z};
        double square = 0;
        for (int a = 0; a < d->dim; a++) {
            double *v = g + d->at.v + a;
            *v = keep * *v + kick * f[a] - (a == d->dim - 1 ? d->gravity * dt : 0);
            g[a] += dt * *v + carried[a];
            square += *v * *v;
        }
        for (int a = 0; a < (d->dim == 3 ? 3 : 1); a++)
            g[d->at.w + a] = keep * g[d->at.w + a] + d->law.spin * kick * f[d->dim == 3 ? 3 + a : 5];
        v2 = fmax(v2, square);
    }
    d->v_max = sqrt(v2);
}
