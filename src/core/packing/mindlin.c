/* Mindlin and Deresiewicz's law for one contact, and the forces of pairs whose tangential stiffness follows it. */
#include "packing/mindlin.h"

#include "packing/kernel.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

/* What a contact remembers, while it is worked on. */
typedef struct memory {
    double sense; /* of the slip, +-1; 0: none yet */
    int turns;
    double at[MINDLIN_TURNS];
} memory;

static memory read_memory(const double *past, int64_t stride) {
    memory m = {.sense = past[0] > 0 ? 1 : past[0] < 0 ? -1 : 0};
    const int turns = past[0] == 0 ? 0 : (int)fabs(past[0]) - 1;
    m.turns = turns < MINDLIN_TURNS ? turns : MINDLIN_TURNS;
    for (int k = 0; k < m.turns; k++)
        m.at[k] = past[(1 + k) * stride];
    return m;
}

static void write_memory(const memory *m, double *past, int64_t stride) {
    past[0] = m->sense * (1 + m->turns);
    for (int k = 0; k < MINDLIN_TURNS; k++)
        past[(1 + k) * stride] = k < m->turns ? m->at[k] : 0;
}

static void clear(double *past, int64_t stride) {
    for (int k = 0; k < MINDLIN_NUMBERS; k++)
        past[k * stride] = 0;
}

/* A new loop begins at q. */
static void turn(memory *m, double q) {
    if (m->turns == MINDLIN_TURNS)
        m->turns -= 2;
    m->at[m->turns++] = q;
}

/* Where the branch ends, and the one before it goes on. */
static double end_of(const memory *m) { return m->turns > 1 ? m->at[m->turns - 2] : -m->at[0]; }

static void close_loop(memory *m) { m->turns -= m->turns > 1 ? 2 : 1; }

/* Takes into account that q has changed without slip: loops may be closed, and the last reversal may lie ahead. */
static void settle(memory *m, double q) {
    while (m->turns > 0 && m->sense * (q - end_of(m)) >= 0)
        close_loop(m);
    if (m->turns > 0 && m->sense * (q - m->at[m->turns - 1]) < 0)
        m->at[m->turns - 1] = q;
}

/* (dF_t/ds / k)^3 */
static double cubed_factor(const memory *m, double q) {
    const double f = m->turns > 0 ? 1 - 0.5 * fabs(q - m->at[m->turns - 1]) : 1 - m->sense * q;
    return f < 0 ? 0 : f > 1 ? 1 : f;
}

static double two_thirds(double f) {
    const double root = cbrt(f);
    return root * root;
}

/* Along one branch f = cubed_factor falls by df = -w dq, w = 1 or 1/2, and dq = f^(1/3) dx with the slip x = k s/limit.
 * So f^(2/3) falls by 2/3 w dx. */
static double slide(memory *m, double q, double left) {
    for (;;) {
        settle(m, q);
        const bool first = m->turns == 0;
        const double w = first ? 1 : 0.5, f = cubed_factor(m, q), height = two_thirds(f);
        if (!first) {
            const double end = end_of(m), lower = f - w * fabs(end - q);
            const double need = (height - two_thirds(lower > 0 ? lower : 0)) * 1.5 / w;
            if (left >= need) {
                left -= need;
                q = end;
                close_loop(m);
                continue;
            }
        }
        const double rest = height - left * w / 1.5, after = rest > 0 ? rest * sqrt(rest) : 0;
        return q + m->sense * (f - after) / w;
    }
}

double sp_mindlin_slip(double *past, int64_t stride, double force, double limit, double stiffness, double slip) {
    if (!(limit > 0)) {
        clear(past, stride);
        return 0;
    }
    double q = force / limit;
    q = q > 1 ? 1 : q < -1 ? -1 : q;
    if (slip == 0)
        return q * limit;
    memory m = read_memory(past, stride);
    const double sense = slip > 0 ? 1 : -1;
    if (m.sense == 0) /* a force that comes without history is taken as that of first loading */
        m.sense = q == 0 ? sense : q > 0 ? 1 : -1;
    if (m.sense != sense)
        turn(&m, q);
    m.sense = sense;
    q = slide(&m, q, fabs(slip) * stiffness / limit);
    write_memory(&m, past, stride);
    return (q > 1 ? 1 : q < -1 ? -1 : q) * limit;
}

/* ---- pairs ------------------------------------------------------------------------------------------------------- */

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

/* What dashpots feel: the relative velocity along n and (-ny, nx), averaged (dynamics.lag). */
static void average(const dynamics *d, int32_t k, const relative *c, double r, bool closed, double slow[2]) {
    const double nx = c->x / r, ny = c->y / r;
    slow[0] = c->vx * nx + c->vy * ny;
    slow[1] = c->vy * nx - c->vx * ny - c->spin;
    for (int a = 0; a < d->at.averaged; a++) {
        double *u = d->inner.u + k + (int64_t)a * d->inner.capacity;
        slow[a] = *u = closed ? slow[a] + d->lag * (*u - slow[a]) : slow[a];
    }
}

static void open_pair(const dynamics *d, int32_t k, const relative *c, double r) {
    double slow[2];
    for (int a = 0; a < d->at.forces + d->at.past; a++)
        d->inner.ft[k + (int64_t)a * d->inner.capacity] = 0;
    average(d, k, c, r, false, slow);
}

/* The law of law2 in kernel.c, but for the tangential spring. row: force on i, torque/R, sqrt(m_eff k_n) */
static void closed_pair(const dynamics *d, double dt, int32_t k, const relative *c, double r, double row[4]) {
    const pair_list *p = &d->inner;
    const contact_law *law = &d->law;
    const double nx = c->x / r, ny = c->y / r, overlap = p->reach[k] - r, root = sqrt(overlap);
    const double kn = p->e2[k] * root, s = p->sm[k] * sqrt(root), elastic = 2.0 / 3.0 * kn * overlap;
    const double viscous = 2 * law->damping * s, vt = c->vy * nx - c->vx * ny - c->spin;
    double *ft = p->ft + k, slow[2];
    average(d, k, c, r, true, slow);
    const double normal = fmax(0, elastic - viscous * slow[0]);
    *ft = sp_mindlin_slip(ft + p->capacity, p->capacity, *ft, law->friction * elastic, law->eta * kn, vt * dt);
    const double limit = law->friction * law->viscous_limit * normal, whole = *ft + viscous * law->sqrt_eta * slow[1];
    const double total = fmin(limit, fmax(-limit, whole));
    row[0] = -normal * nx - total * ny;
    row[1] = -normal * ny + total * nx;
    row[2] = total;
    row[3] = s;
}

double sp_history_pairs(const dynamics *d, double dt_past, int32_t first, int32_t count) {
    double single = 0;
    for (int32_t k = first; k < first + count; k++) {
        const relative c = relative_of(d, k);
        const double r = sqrt(c.x * c.x + c.y * c.y);
        double row[4] = {0, 0, 0, 0};
        if (r < d->inner.reach[k])
            closed_pair(d, dt_past, k, &c, r, row);
        else
            open_pair(d, k, &c, r);
        memcpy(d->rows.row + 4 * (int64_t)k, row, sizeof row);
        single = fmax(single, d->inner.light[k] * (SINGLE_CONTACT * row[3]));
        if (!d->rows.both)
            continue;
        row[0] = -row[0];
        row[1] = -row[1];
        memcpy(d->rows.row + 4 * ((int64_t)d->rows.other + k), row, sizeof row);
    }
    return single;
}
