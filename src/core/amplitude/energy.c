/* The balance of energy. The motion feels the changes of the contact forces from rest, so the energies leave out the
 * work of the forces at rest, contact by contact. Forms without differences of large numbers keep small amplitudes
 * exact. */
#include "amplitude/motion.h"
#include "base/vector.h"

#include <math.h>

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
