/* Forces of pairs whose tangential stiffness depends on the loading history. */
#include "packing/history_pairs.h"

#include "packing/mindlin.h"

#include <math.h>
#include <string.h>

/* Relative position and velocity of a pair, with image and strain of the cell. */
typedef struct relative {
    double x, y, vx, vy, spin;
} relative;

static relative relative_of(const dynamics *d, int32_t k) {
    const pair_list *p = &d->inner;
    const double *g = d->g + p->at_i[k], *h = d->g + p->at_j[k];
    relative c = {h[0] - g[0] + p->image[k] * d->period[0], h[1] - g[1], 0, 0, g[4] + h[4]};
    const double above = d->affine ? p->image[k + p->capacity] : 0;
    c.x += above * d->tilt[0];
    c.y += above * d->piston_y;
    c.vx = h[2] - g[2] + d->strain_rate[0] * c.x;
    c.vy = h[3] - g[3];
    if (d->affine) {
        c.vx += d->shear_rate[0] * c.y;
        c.vy += d->strain_rate[1] * c.y;
    }
    return c;
}

static void open_pair(const dynamics *d, int32_t k) {
    for (int a = 0; a < dynamics_kept(d); a++)
        d->inner.ft[k + (int64_t)a * d->inner.capacity] = 0;
}

/* The law of law2 in kernel.c, but for the tangential spring. row: force on i, torque/R, sqrt(m_eff k_n) */
static void closed_pair(const dynamics *d, double dt, int32_t k, const relative *c, double r, double row[4]) {
    const pair_list *p = &d->inner;
    const contact_law *law = &d->law;
    const double nx = c->x / r, ny = c->y / r, overlap = p->reach[k] - r, root = sqrt(overlap);
    const double kn = p->e2[k] * root, s = p->sm[k] * sqrt(root), elastic = 2.0 / 3.0 * kn * overlap;
    const double viscous = 2 * law->damping * s, vt = c->vy * nx - c->vx * ny - c->spin;
    const double normal = fmax(0, elastic - viscous * (c->vx * nx + c->vy * ny));
    double *ft = p->ft + k;
    *ft = sp_mindlin_slip(ft + p->capacity, p->capacity, *ft, law->friction * elastic, law->eta * kn, vt * dt);
    const double limit = law->friction * law->viscous_limit * normal, whole = *ft + viscous * law->sqrt_eta * vt;
    const double total = fmin(limit, fmax(-limit, whole));
    row[0] = -normal * nx - total * ny;
    row[1] = -normal * ny + total * nx;
    row[2] = total;
    row[3] = s;
}

void sp_history_pairs(const dynamics *d, double dt_past, int32_t first, int32_t count) {
    for (int32_t k = first; k < first + count; k++) {
        const relative c = relative_of(d, k);
        const double r = sqrt(c.x * c.x + c.y * c.y);
        double row[4] = {0, 0, 0, 0};
        if (r < d->inner.reach[k])
            closed_pair(d, dt_past, k, &c, r, row);
        else
            open_pair(d, k);
        memcpy(d->rows.row + 4 * (int64_t)k, row, sizeof row);
        if (!d->rows.both)
            continue;
        row[0] = -row[0];
        row[1] = -row[1];
        memcpy(d->rows.row + 4 * ((int64_t)d->rows.other + k), row, sizeof row);
    }
}
