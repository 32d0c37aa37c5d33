/* One run of the nonlinear motion of a packing between its walls. */
#include "amplitude/motion.h"

#include "base/base.h"
#include "base/vector.h"
#include "network/place.h"

#include <math.h>
#include <string.h>

/* Largest gaps that are ever watched, in smallest radii: grains that fly so far are no packing any more. */
#define FARTHEST 4.0

void sp_motion_free(motion *s) {
    for (int32_t b = 0; b < s->n_sensors && s->sensors; b++) {
        sp_free(s->sensors[b].touch);
        sp_free(s->sensors[b].sign);
    }
    sp_free(s->sensors);
    sp_free(s->seen);
    sp_free(s->m.work);
    sp_vibration_free(&s->m);
    *s = (motion){0};
}

/* ---- sensors ---------------------------------------------------------------------------------------------------- */

/* Sign of a contact in the force on the top wall (height NULL), or on what lies above a plane. */
static double sign_of(const motion *s, const double *height, const touching *t) {
    const sp_packing *p = s->packing;
    const int up = p->dim - 1;
    int32_t low;
    if (!height)
        return t->j == SP_TOP ? -1 : 0;
    return -sp_place_crossing(s->net, *height, p->x[3 * (int64_t)t->i + up], t->length * t->n0[up], t->j,
                              t->j >= 0 ? p->x[3 * (int64_t)t->j + up] : 0, &low);
}

static sp_status make_sensor(const motion *s, const double *height, motion_sensor *out, sp_error *err) {
    for (int32_t k = 0; k < s->m.count; k++)
        out->n += sign_of(s, height, &s->m.touch[k]) != 0;
    out->touch = sp_alloc((size_t)out->n, sizeof *out->touch);
    out->sign = sp_alloc((size_t)out->n, sizeof *out->sign);
    if (!out->touch || !out->sign)
        return sp_fail_memory(err, (size_t)out->n * (sizeof *out->touch + sizeof *out->sign));
    int32_t at = 0;
    for (int32_t k = 0; k < s->m.count; k++) {
        const double sign = sign_of(s, height, &s->m.touch[k]);
        if (sign != 0) {
            out->touch[at] = k;
            out->sign[at++] = sign;
        }
    }
    return SP_OK;
}

static sp_status make_sensors(motion *s, int32_t planes, const double *height, sp_error *err) {
    const int32_t n = planes + 1;
    s->sensors = sp_alloc((size_t)n, sizeof *s->sensors);
    if (!s->sensors)
        return sp_fail_memory(err, (size_t)n * sizeof *s->sensors);
    s->n_sensors = n;
    sp_status status = SP_OK;
    for (int32_t b = 0; b < n && status == SP_OK; b++)
        status = make_sensor(s, b > 0 ? &height[b - 1] : NULL, &s->sensors[b], err);
    return status;
}

double sp_motion_force(const motion *s, int32_t sensor) {
    const motion_sensor *e = &s->sensors[sensor];
    const int up = s->m.dim - 1;
    double sum = 0;
    for (int32_t k = 0; k < e->n; k++)
        sum += e->sign[k] * s->m.touch[e->touch[k]].force[up];
    return sum;
}

/* ---- making ----------------------------------------------------------------------------------------------------- */

static sp_status need_walls(const sp_network *net, sp_error *err) {
    if (net->cell == SP_CELL_PERIODIC)
        return sp_fail(err, SP_EREFUSED, "the cell is periodic and has no walls, between which a loud pulse passes");
    if (!sp_network_touches(net, SP_BOTTOM) || !sp_network_touches(net, SP_TOP))
        return sp_fail(err, SP_EREFUSED, "the packing does not touch both the bottom and the top wall");
    return sp_network_need_level_walls(net, "a loud pulse", err);
}

/* The largest reach, in smallest radii, at which no pair meets itself around the cell. */
static double most_reach(const sp_packing *p) {
    double least = INFINITY, most = FARTHEST;
    for (int32_t i = 0; i < p->n; i++)
        least = fmin(least, p->r[i]);
    for (int a = 0; a < p->dim; a++)
        if (sp_packing_periodic(p, a))
            most = fmin(most, 0.2 * p->box[a] / least);
    return most;
}

bool sp_motion_can_widen(const motion *s) { return s->radii < most_reach(s->packing); }

sp_status sp_motion_make(const sp_packing *p, const sp_network *net, double radii, int32_t planes, const double *height,
                         motion *out, sp_error *err) {
    motion s = {.packing = p, .net = net, .radii = fmin(radii, fmax(SP_MOTION_NEAR, most_reach(p)))};
    sp_status status = need_walls(net, err);
    if (status == SP_OK)
        status = sp_vibration_make_wide(p, 0, s.radii, &s.m, err);
    if (status == SP_OK) {
        const size_t count = (size_t)s.m.count;
        s.seen = sp_alloc(count, sizeof *s.seen);
        s.m.work = sp_alloc(count, sizeof *s.m.work);
        if (!s.seen || !s.m.work)
            status = sp_fail_memory(err, count * (1 + sizeof *s.m.work));
    }
    if (status == SP_OK)
        status = make_sensors(&s, planes, height, err);
    for (int32_t q = 0; q < net->n_springs && status == SP_OK; q++)
        s.overlap += p->contacts[net->springs[q].contact].overlap / net->n_springs;
    if (status == SP_OK)
        *out = s;
    else
        sp_motion_free(&s);
    return status;
}

/* ---- sources ---------------------------------------------------------------------------------------------------- */

void sp_motion_rest(motion *s) {
    sp_vibration_rest(&s->m);
    for (int32_t k = 0; k < s->m.count; k++)
        memset(s->m.touch[k].shift, 0, sizeof s->m.touch[k].shift);
    memset(s->seen, 0, (size_t)s->m.count);
    s->input = s->time = 0;
}

/* Largest displacement, or velocity over omega_max, of a grain. */
static double largest_of(const sp_network *net, const double *source, bool momenta) {
    double largest = 0;
    for (int32_t i = 0; i < net->n; i++) {
        double square = 0;
        for (int a = 0; a < net->dim; a++) {
            const int64_t k = (int64_t)i * net->dof + a;
            const double x = momenta ? source[k] / net->mass[k] / sp_network_omega_bound(net) : source[k];
            square += x * x;
        }
        largest = fmax(largest, square);
    }
    return sqrt(largest);
}

double sp_motion_kick(motion *s, const double *source, bool momenta, double amplitude) {
    const sp_network *net = s->net;
    const double factor = amplitude * s->overlap / largest_of(net, source, momenta);
    double *to = momenta ? s->m.v : s->m.u;
    sp_motion_rest(s);
    for (int32_t i = 0; i < net->n; i++)
        for (int a = 0; a < net->dof; a++) {
            const int64_t k = (int64_t)i * net->dof + a;
            const int at = a < net->dim ? a : net->dim == 2 ? 5 : a;
            to[6 * (int64_t)net->grain[i] + at] = factor * (momenta ? source[k] / net->mass[k] : source[k]);
        }
    sp_vibration_begin(&s->m);
    const sp_amplitude_energy e = sp_motion_energy(s);
    s->input = e.kinetic + e.normal + e.tangential + e.slid - e.released;
    return factor;
}

/* ---- steps ------------------------------------------------------------------------------------------------------ */

static void mark_contacts(motion *s) {
    for (int32_t k = 0; k < s->m.count; k++) {
        const touching *t = &s->m.touch[k];
        const bool carried = t->fn0 > 0;
        s->seen[k] |=
            (uint8_t)((t->kn > 0 && t->held < 1 && carried ? CONTACT_SLID : 0) |
                      (carried && !(t->kn > 0) ? CONTACT_OPENED : 0) | (!carried && t->kn > 0 ? CONTACT_CLOSED : 0));
    }
}

/* Change of the force of the bottom wall on the grains. */
static double push_of_wall(const motion *s) {
    const int up = s->m.dim - 1;
    double sum = 0;
    for (int32_t k = 0; k < s->m.count; k++)
        if (s->m.touch[k].j == SP_BOTTOM)
            sum += s->m.touch[k].force[up];
    return sum;
}

static double move_wall(motion *s, double wall) {
    const int up = s->m.dim - 1;
    double moved = 0;
    for (int32_t k = 0; k < s->m.count; k++)
        if (s->m.touch[k].j == SP_BOTTOM) {
            moved = wall - s->m.touch[k].shift[up];
            s->m.touch[k].shift[up] = wall;
        }
    return moved;
}

void sp_motion_step(motion *s, double h, double wall) {
    const double moved = move_wall(s, wall), before = moved != 0 ? push_of_wall(s) : 0;
    sp_vibration_step(&s->m, h);
    if (moved != 0)
        s->input += 0.5 * moved * (before + push_of_wall(s));
    s->time += h;
    mark_contacts(s);
}

/* Two grains that are not watched are farther apart than `reach`. They do not meet as long as the two largest
 * displacements stay below it together: one rattler may fly far. */
static bool is_near(const vibration *m) {
    double first = 0, second = 0;
    for (int64_t i = 0; i < m->n; i++) {
        const double square = dot3(m->u + 6 * i, m->u + 6 * i);
        if (!isfinite(square))
            return false;
        second = fmax(second, fmin(first, square));
        first = fmax(first, square);
    }
    return sqrt(first) + sqrt(second) <= m->reach;
}

sp_status sp_motion_check(const motion *s, double amplitude, sp_error *err) {
    if (is_near(&s->m))
        return SP_OK;
    return sp_fail_key(err, SP_EFAILED, "amplitude",
                       " = %g: must be smaller: at t = %.6g two grains have moved by more than %.3g together, or "
                       "without bound",
                       amplitude, s->time, s->m.reach);
}

void sp_motion_count(const motion *s, sp_amplitude_pulse *out) {
    out->carrying = out->slid = out->opened = out->lost = out->closed = 0;
    for (int32_t k = 0; k < s->m.count; k++) {
        const touching *t = &s->m.touch[k];
        out->carrying += t->fn0 > 0;
        out->slid += (s->seen[k] & CONTACT_SLID) != 0;
        out->opened += (s->seen[k] & CONTACT_OPENED) != 0;
        out->closed += (s->seen[k] & CONTACT_CLOSED) != 0;
        out->lost += t->fn0 > 0 && !(t->kn > 0);
    }
}
