/* One run of the nonlinear motion of a packing between its walls, and its balance of energy. */
#include "amplitude/loud_motion.h"
#include "base/base.h"
#include "base/vector.h"
#include "network/place.h"

#include <math.h>
#include <string.h>

/* ---- energy ------------------------------------------------------------------------------------------------------ */

/* Relative displacement at a contact: that of the centres, and of the points of contact without their motion along the
 * normal at rest. */
static void displacement(const vibration *m, const touching *t, double d[3], double side[3]) {
    const double *x = m->u + 6 * (int64_t)t->i, *y = t->j >= 0 ? m->u + 6 * (int64_t)t->j : NULL;
    double turn[3], arm[3];
    for (int a = 0; a < 3; a++) {
        d[a] = (y ? y[a] : 0) - x[a] + t->shift[a];
        turn[a] = t->arm_i * x[3 + a] + (y ? t->arm_j * y[3 + a] : 0);
    }
    cross3(turn, t->n0, arm);
    const double along = dot3(d, t->n0);
    for (int a = 0; a < 3; a++)
        side[a] = d[a] - along * t->n0[a] - arm[a];
}

/* E(overlap) - E(rest) + F(rest) . (displacement along the normal at rest), where E = 8/15 e overlap^(5/2). With the
 * roots a and b of both overlaps, E(a) - E(b) + F(b) (b^2 - a^2) = 4/15 e (a - b)^2 (2a^3 + 4a^2 b + 6ab^2 + 3b^3). */
static double normal_energy(const touching *t, const double d[3]) {
    const double along = dot3(d, t->n0), rest = fmax(0, t->overlap);
    double stretch = along, bend = 0; /* bend: stretch - along */
    if (t->j >= 0) {
        const double square = dot3(d, d), r = sqrt(t->length * t->length + 2 * t->length * along + square);
        stretch = (2 * t->length * along + square) / (r + t->length);
        bend = (square - along * stretch) / (r + t->length);
    }
    const double now = fmax(0, t->overlap - stretch), a = sqrt(now), b = sqrt(rest);
    if (!(rest > 0))
        return 8.0 / 15.0 * t->e * now * now * a;
    if (!(now > 0))
        return t->fn0 * (along - 0.4 * rest);
    const double change = stretch / (a + b);
    return 4.0 / 15.0 * t->e * change * change * (2 * a * a * a + 4 * a * a * b + 6 * a * b * b + 3 * b * b * b) -
           t->fn0 * bend;
}

static double kinetic_energy(const vibration *m) {
    double sum = 0;
    for (int64_t i = 0; i < m->n; i++)
        sum += 0.5 * (m->mass[2 * i] * dot3(m->v + 6 * i, m->v + 6 * i) +
                      m->mass[2 * i + 1] * dot3(m->v + 6 * i + 3, m->v + 6 * i + 3));
    return sum;
}

sp_amplitude_energy sp_motion_energy(const motion *s) {
    sp_amplitude_energy e = {.input = s->input, .kinetic = kinetic_energy(&s->m)};
    for (int32_t k = 0; k < s->m.count; k++) {
        const touching *t = &s->m.touch[k];
        const spring_work *w = &s->m.work[k];
        double d[3], side[3];
        displacement(&s->m, t, d, side);
        e.normal += normal_energy(t, d);
        if (!s->m.turns)
            continue;
        e.tangential += (w->whole - w->slid) - w->carried;
        e.slid += w->slid;
        e.released += dot3(t->ft0, side) - w->carried;
    }
    if (e.input > 0)
        e.defect = fabs(e.kinetic + e.normal + e.tangential + e.slid - e.released - e.input) / e.input;
    return e;
}

/* Largest gaps that are ever watched, in smallest radii: grains that fly so far are no packing any more. */
#define FARTHEST 4.0

void sp_motion_free(motion *s) {
    for (int32_t b = 0; b < s->n_sensors && s->sensors; b++)
        sp_sensor_free(&s->sensors[b]);
    sp_free(s->sensors);
    sp_free(s->seen);
    sp_free(s->m.work);
    sp_vibration_free(&s->m);
    *s = (motion){0};
}

/* The top wall, then the planes. */
static sp_status make_sensors(motion *s, int32_t planes, const double *height, sp_error *err) {
    sp_status status = SP_OK;
    s->n_sensors = planes + 1;
    s->sensors = sp_alloc((size_t)s->n_sensors, sizeof *s->sensors);
    if (!s->sensors)
        return sp_fail_memory(err, (size_t)s->n_sensors * sizeof *s->sensors);
    for (int32_t b = 0; b < s->n_sensors && status == SP_OK; b++) {
        const sp_place plane = {.kind = SP_PLACE_PLANE, .height = b > 0 ? height[b - 1] : 0}, top = sp_place_wall();
        status = sp_sensor_make(s->packing, s->net, &s->m, b > 0 ? &plane : &top, &s->sensors[b], err);
    }
    return status;
}

double sp_motion_force(const motion *s, int32_t sensor) { return sp_sensor_read(&s->m, &s->sensors[sensor]); }

/* ---- making ----------------------------------------------------------------------------------------------------- */

sp_status sp_motion_need_walls(const sp_network *net, sp_error *err) {
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
    sp_status status = sp_motion_need_walls(net, err);
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
    s.overlap = sp_mean_overlap(p, net);
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

double sp_motion_kick(motion *s, const double *source, bool momenta, double amplitude) {
    sp_motion_rest(s);
    const double factor = sp_vibration_kick(&s->m, s->net, source, momenta, amplitude * s->overlap);
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

void sp_motion_count(const motion *s, sp_amplitude_front *out) {
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
