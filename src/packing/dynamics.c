#include "packing/dynamics.h"

#include "base/base.h"
#include "packing/contact.h"
#include "packing/pairs.h"

#include <math.h>
#include <string.h>

/* One binary that uses the vector units of the machine it runs on; the bits do not depend on it, as nothing is
 * contracted or reassociated. Sanitizers and clang cannot resolve the clones. */
#if defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) &&     \
    defined(__x86_64__)
#define CLONES __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
#else
#define CLONES
#endif

typedef double v4 __attribute__((vector_size(32), aligned(32), may_alias));

sp_status dynamics_make(const sp_pack_spec *spec, const double *r, const double *x, double height, dynamics *out,
                        sp_error *err) {
    dynamics d = {.n = spec->grains,
                  .width = spec->width,
                  .area = spec->width,
                  .pressure = spec->pressure,
                  .piston_y = height,
                  .piston_mass = spec->piston_mass * spec->width,
                  .m_min = INFINITY,
                  .outer_travel = INFINITY};
    const size_t n = (size_t)d.n;
    d.law.friction = spec->friction;
    d.law.eta = spec->friction > 0 ? contact_eta(spec->poisson) : 0;
    d.law.sqrt_eta = sqrt(d.law.eta);
    d.law.damping = spec->damping;
    d.g = sp_alloc(n, sizeof *d.g);
    d.f = sp_alloc(n, sizeof *d.f);
    d.cell_next = sp_alloc(n, sizeof *d.cell_next);
    for (int side = 0; side < 2; side++) {
        d.wall_ft[side] = sp_alloc(n, sizeof(double));
        d.wall[side].i = sp_alloc(n, sizeof(int32_t));
    }
    if (!d.g || !d.f || !d.cell_next || !d.wall_ft[0] || !d.wall_ft[1] || !d.wall[0].i || !d.wall[1].i) {
        dynamics_free(&d);
        return sp_fail_memory(err, n * (sizeof *d.g + sizeof *d.f + 28));
    }
    for (size_t i = 0; i < n; i++) {
        double m = grain_mass(r[i]);
        d.g[i] = (grain){.x = x[3 * i], .y = x[3 * i + 1], .r = r[i], .inv_m = 1.0 / m};
        d.m_min = fmin(d.m_min, m);
    }
    *out = d;
    return SP_OK;
}

void dynamics_free(dynamics *d) {
    pair_list_free(&d->outer);
    pair_list_free(&d->inner);
    for (int side = 0; side < 2; side++) {
        sp_free(d->wall_ft[side]);
        sp_free(d->wall[side].i);
    }
    sp_free(d->cell_head);
    sp_free(d->cell_next);
    sp_free(d->f);
    sp_free(d->g);
    *d = (dynamics){0};
}

/* Differences of all pairs, so that the law below runs over plain arrays. */
CLONES static void gather(const pair_list *p, const grain *restrict g) {
    for (int32_t k = 0; k < p->n; k++) {
        const grain *a = &g[p->i[k]], *b = &g[p->j[k]];
        *(v4 *)&p->d[4 * k] = *(const v4 *)&b->x - *(const v4 *)&a->x;
        p->spin[k] = a->w + b->w;
    }
}

/* Appendix A of the paper for all listed pairs. Open pairs come out with zero force and forget their tangential force.
 * dt: time over which the tangential spring stretches with the present relative velocity. */
CLONES static void pair_law(int32_t n, const pair_list *p, const contact_law *law, double dt) {
    const double *restrict d = p->d;
    const double *restrict shift = p->shift, *restrict reach = p->reach, *restrict e = p->e, *restrict c = p->c;
    const double *restrict spin = p->spin;
    double *restrict ft = p->ft, *restrict stiffness = p->kn;
    double *restrict fx = p->f, *restrict fy = p->f + p->capacity, *restrict turn = p->f + 2 * p->capacity;
    const double mu = law->friction, eta_dt = law->eta * dt, sqrt_eta = law->sqrt_eta;
    const double mu_viscous = law->limit_viscous ? mu : 1e300;
#pragma GCC ivdep
    for (int32_t k = 0; k < n; k++) {
        double x = d[4 * k + 0] + shift[k], y = d[4 * k + 1], vx = d[4 * k + 2], vy = d[4 * k + 3];
        double r = sqrt(x * x + y * y), inverse = 1.0 / r;
        double nx = x * inverse, ny = y * inverse, gap = reach[k] - r;
        double overlap = gap > 0 ? gap : 0;
        double kn = 2.0 * e[k] * sqrt(overlap);      /* k_n = 2 E12 sqrt(R12 n) */
        double elastic = (2.0 / 3.0) * kn * overlap; /* (A1) */
        double viscous = c[k] * sqrt(kn);            /* 2 zeta sqrt(m_eff k_n) */
        double vt = vy * nx - vx * ny - spin[k];     /* relative velocity along (-ny, nx), rotations included */
        double normal = elastic - viscous * (vx * nx + vy * ny);
        normal = normal > 0 ? normal : 0;    /* never attracts */
        double cap = mu * elastic;           /* (A3), on the elastic spring */
        double t = ft[k] + eta_dt * kn * vt; /* (A2): k_t = eta k_n */
        t = t > cap ? cap : t;
        t = t < -cap ? -cap : t;
        ft[k] = t;
        double total = t + viscous * sqrt_eta * vt, limit = mu_viscous * normal;
        total = total > limit ? limit : total;
        total = total < -limit ? -limit : total;
        fx[k] = -normal * nx - total * ny;
        fy[k] = -normal * ny + total * nx;
        turn[k] = total;
        stiffness[k] = kn;
    }
}

/* Adds pair forces to both grains: opposite forces, and the same turning force. */
CLONES static void scatter(const pair_list *p, grain_force *restrict f) {
    const v4 other = {-1.0, -1.0, 1.0, 1.0};
    const double *fx = p->f, *fy = p->f + p->capacity, *turn = p->f + 2 * p->capacity;
    for (int32_t k = 0; k < p->n;) {
        const int32_t i = p->i[k]; /* a row of pairs with the same i: its sum stays in a register */
        v4 sum = *(v4 *)&f[i];
        for (; k < p->n && p->i[k] == i; k++) {
            v4 force = {fx[k], fy[k], turn[k], 0};
            sum += force;
            *(v4 *)&f[p->j[k]] += other * force;
        }
        *(v4 *)&f[i] = sum;
    }
}

static double largest(int32_t n, const double *restrict x) {
    double m[4] = {0, 0, 0, 0};
    int32_t k = 0;
    for (; k + 4 <= n; k += 4)
        for (int l = 0; l < 4; l++)
            m[l] = x[k + l] > m[l] ? x[k + l] : m[l];
    for (; k < n; k++)
        m[0] = x[k] > m[0] ? x[k] : m[0];
    return fmax(fmax(m[0], m[1]), fmax(m[2], m[3]));
}

/* A wall is a grain of infinite radius, E12 = E*, which does not turn: normal n = (0, sign), t = (-sign, 0). */
static void wall_law(dynamics *d, int side, double dt) {
    const double sign = side == 0 ? -1 : 1, wall_v = side == 0 ? 0 : d->piston_v;
    const contact_law *law = &d->law;
    double sum = 0, stiffness = 0;
    for (int32_t k = 0; k < d->wall[side].n; k++) {
        const int32_t i = d->wall[side].i[k];
        const grain *g = &d->g[i];
        double distance = side == 0 ? g->y : d->piston_y - g->y, overlap = g->r - distance;
        double *ft = &d->wall_ft[side][i];
        if (!(overlap > 0)) {
            *ft = 0;
            continue;
        }
        double kn = contact_normal_stiffness(sqrt(g->r), overlap), elastic = 2.0 / 3.0 * kn * overlap;
        double viscous = 2.0 * law->damping * sqrt(kn / g->inv_m);
        double vt = sign * g->vx - g->w; /* (0 - v).t - R omega */
        double normal = fmax(0, elastic - viscous * sign * (wall_v - g->vy));
        double cap = law->friction * elastic;
        *ft = fmax(-cap, fmin(cap, *ft + law->eta * dt * kn * vt));
        double total = *ft + viscous * law->sqrt_eta * vt;
        if (law->limit_viscous)
            total = fmax(-law->friction * normal, fmin(law->friction * normal, total));
        d->f[i].x -= sign * total;
        d->f[i].y -= sign * normal;
        d->f[i].t += total;
        sum += normal;
        stiffness += kn;
        d->k_max = fmax(d->k_max, kn);
    }
    d->wall_force[side] = sum;
    if (side == 1)
        d->piston_k = stiffness;
}

void dynamics_forces(dynamics *d, double dt_past) {
    memset(d->f, 0, (size_t)d->n * sizeof *d->f);
    gather(&d->inner, d->g);
    pair_law(d->inner.n, &d->inner, &d->law, dt_past);
    scatter(&d->inner, d->f);
    d->k_max = largest(d->inner.n, d->inner.kn);
    wall_law(d, 0, dt_past);
    wall_law(d, 1, dt_past);
}

void dynamics_advance(dynamics *d, double dt) {
    const double keep = 1.0 - d->drag * dt;
    double v2 = 0;
    for (int32_t i = 0; i < d->n; i++) {
        grain *g = &d->g[i];
        const grain_force *f = &d->f[i];
        double kick = dt * g->inv_m;
        g->vx = keep * g->vx + kick * f->x;
        g->vy = keep * g->vy + kick * f->y;
        g->w = keep * g->w + 2.5 * kick * f->t; /* I = 0.4 m R^2 */
        g->x += dt * g->vx;
        g->y += dt * g->vy;
        double s = g->vx * g->vx + g->vy * g->vy;
        v2 = s > v2 ? s : v2;
    }
    d->piston_v = keep * d->piston_v + dt * (d->wall_force[1] - d->pressure * d->area) / d->piston_mass;
    d->piston_y += dt * d->piston_v;
    d->v_max = fmax(sqrt(v2), fabs(d->piston_v));
    d->inner_travel += 2 * d->v_max * dt;
    d->outer_travel += 2 * d->v_max * dt;
    d->dt = dt;
}

static double largest_acceleration(const dynamics *d) {
    double worst = 0;
    for (int32_t i = 0; i < d->n; i++) {
        const grain_force *f = &d->f[i];
        worst = fmax(worst, d->g[i].inv_m * fmax(sqrt(f->x * f->x + f->y * f->y), 2.5 * fabs(f->t)));
    }
    return worst;
}

double dynamics_acceleration(const dynamics *d) {
    const double load = d->pressure * d->area, imbalance = fabs(d->wall_force[1] - load);
    if (imbalance > 0.5 * load) /* a heavy piston in free fall accelerates little, but is not carried */
        return INFINITY;
    return fmax(largest_acceleration(d), imbalance / d->piston_mass);
}

/* ---- how far from rest --------------------------------------------------------------------------------------- */

static void elastic_pair_forces(dynamics *d) {
    const pair_list *p = &d->inner;
    for (int32_t k = 0; k < p->n; k++) {
        const grain *a = &d->g[p->i[k]], *b = &d->g[p->j[k]];
        double x = b->x - a->x + p->shift[k], y = b->y - a->y, r = sqrt(x * x + y * y), overlap = p->reach[k] - r;
        if (!(overlap > 0))
            continue;
        double normal = contact_force(p->e[k], overlap), nx = x / r, ny = y / r, t = p->ft[k];
        double fx = -normal * nx - t * ny, fy = -normal * ny + t * nx;
        grain_force *fa = &d->f[p->i[k]], *fb = &d->f[p->j[k]];
        *fa = (grain_force){fa->x + fx, fa->y + fy, fa->t + t, 0};
        *fb = (grain_force){fb->x - fx, fb->y - fy, fb->t + t, 0};
    }
}

static double elastic_wall_forces(dynamics *d, int side) {
    const double sign = side == 0 ? -1 : 1;
    double sum = 0;
    for (int32_t k = 0; k < d->wall[side].n; k++) {
        const int32_t i = d->wall[side].i[k];
        double overlap = d->g[i].r - (side == 0 ? d->g[i].y : d->piston_y - d->g[i].y);
        if (!(overlap > 0))
            continue;
        double normal = contact_force(sqrt(d->g[i].r), overlap), t = d->wall_ft[side][i];
        grain_force *f = &d->f[i];
        *f = (grain_force){f->x - sign * t, f->y - sign * normal, f->t + t, 0};
        sum += normal;
    }
    return sum;
}

double dynamics_residual(dynamics *d, double *wall_imbalance) {
    memset(d->f, 0, (size_t)d->n * sizeof *d->f);
    elastic_pair_forces(d);
    elastic_wall_forces(d, 0);
    double top = elastic_wall_forces(d, 1);
    *wall_imbalance = fabs(top / d->area - d->pressure);
    return fmax(largest_acceleration(d), fabs(top - d->pressure * d->area) / d->piston_mass);
}

bool dynamics_sane(const dynamics *d) {
    if (!isfinite(d->piston_y) || !isfinite(d->v_max))
        return false;
    for (int32_t i = 0; i < d->n; i++) {
        const grain *g = &d->g[i];
        if (!(g->y > 0.2 * g->r) || !(d->piston_y - g->y > 0.2 * g->r) || !isfinite(g->x) || !isfinite(g->w))
            return false;
    }
    for (int32_t k = 0; k < d->inner.n; k++) {
        const grain *a = &d->g[d->inner.i[k]], *b = &d->g[d->inner.j[k]];
        double x = b->x - a->x + d->inner.shift[k], y = b->y - a->y;
        if (sqrt(x * x + y * y) < d->inner.reach[k] - 0.8 * fmin(a->r, b->r))
            return false;
    }
    return true;
}
