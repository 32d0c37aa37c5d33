/* Sensors of the nonlinear motion, and the pulse that starts it. */
#include "signal/sensor.h"

#include "base/base.h"
#include "network/place.h"

#include <math.h>

/* Whether a grain is detected by its contact with the top wall, as in sp_network_detector_at. */
static bool at_wall(const sp_network *net, const sp_place *at) {
    for (int32_t k = net->n_bulk; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        if (s->j == SP_TOP && net->grain[s->i] == at->grain && !(at->shear && s->kt == 0))
            return true;
    }
    return false;
}

/* Sign of a contact in a detector; 0: it does not count. */
static double sign_of(const sp_packing *p, const sp_network *net, const sp_place *at, bool wall, const touching *t) {
    const double x = p->x[3 * (int64_t)t->i];
    const double y = sp_packing_periodic(p, 0) ? x - p->box[0] * floor(x / p->box[0]) : x;
    switch (at->kind) {
    case SP_PLACE_WALL: return t->j == SP_TOP ? -1 : 0;
    case SP_PLACE_PART: return t->j == SP_TOP && y >= at->from && y < at->to ? -1 : 0;
    case SP_PLACE_DISC: return t->j == SP_TOP && sp_place_in_disc(net, at, p->x + 3 * (int64_t)t->i) ? -1 : 0;
    case SP_PLACE_GRAIN:
        if (wall)
            return t->j == SP_TOP && t->i == at->grain ? -1 : 0;
        return t->i == at->grain ? 1 : t->j == at->grain ? -1 : 0;
    case SP_PLACE_PLANE: break;
    }
    const int up = p->dim - 1;
    const double other = t->j >= 0 ? p->x[3 * (int64_t)t->j + up] : 0;
    int32_t low;
    return -sp_place_crossing(net, at->height, p->x[3 * (int64_t)t->i + up], t->length * t->n0[up], t->j, other, &low);
}

sp_status sp_sensor_make(const sp_packing *p, const sp_network *net, const vibration *m, const sp_place *at,
                         motion_sensor *out, sp_error *err) {
    const bool wall = at->kind == SP_PLACE_GRAIN && at_wall(net, at);
    motion_sensor e = {.axis = at->shear ? 0 : m->dim - 1};
    for (int32_t k = 0; k < m->count; k++)
        e.n += sign_of(p, net, at, wall, &m->touch[k]) != 0;
    e.touch = sp_alloc((size_t)e.n, sizeof *e.touch);
    e.sign = sp_alloc((size_t)e.n, sizeof *e.sign);
    *out = e;
    if (!e.touch || !e.sign)
        return sp_fail_memory(err, (size_t)e.n * (sizeof *e.touch + sizeof *e.sign));
    int32_t at_end = 0;
    for (int32_t k = 0; k < m->count; k++) {
        const double sign = sign_of(p, net, at, wall, &m->touch[k]);
        if (sign != 0) {
            e.touch[at_end] = k;
            e.sign[at_end++] = sign;
        }
    }
    return SP_OK;
}

void sp_sensor_free(motion_sensor *e) {
    sp_free(e->touch);
    sp_free(e->sign);
}

double sp_sensor_read(const vibration *m, const motion_sensor *e) {
    double sum = 0;
    for (int32_t k = 0; k < e->n; k++)
        sum += e->sign[k] * m->touch[e->touch[k]].force[e->axis];
    return sum;
}

double sp_mean_overlap(const sp_packing *p, const sp_network *net) {
    double mean = 0;
    for (int32_t k = 0; k < net->n_springs; k++)
        mean += p->contacts[net->springs[k].contact].overlap / net->n_springs;
    return mean;
}

/* Velocity of the centre of mass that momenta give to a network without walls; 0 between walls. No force depends on it,
 * so it is left out: otherwise all grains would drift ever farther. */
static void find_drift(const sp_network *net, const double *momenta, double drift[3]) {
    double mass = 0;
    drift[0] = drift[1] = drift[2] = 0;
    if (net->cell != SP_CELL_PERIODIC)
        return;
    for (int32_t i = 0; i < net->n; i++) {
        mass += net->mass[(int64_t)i * net->dof];
        for (int a = 0; a < net->dim; a++)
            drift[a] += momenta[(int64_t)i * net->dof + a];
    }
    for (int a = 0; a < net->dim; a++)
        drift[a] /= mass;
}

double sp_vibration_kick(vibration *m, const sp_network *net, const double *source, bool momenta, double largest) {
    double most = 0, drift[3], *to = momenta ? m->v : m->u;
    for (int32_t i = 0; i < net->n; i++) {
        double square = 0;
        for (int a = 0; a < net->dim; a++) {
            const int64_t k = (int64_t)i * net->dof + a;
            const double x = momenta ? source[k] / net->mass[k] / sp_network_omega_bound(net) : source[k];
            square += x * x;
        }
        most = fmax(most, square);
    }
    const double factor = largest / sqrt(most);
    find_drift(net, source, drift);
    for (int32_t i = 0; i < net->n; i++)
        for (int a = 0; a < net->dof; a++) {
            const int64_t k = (int64_t)i * net->dof + a;
            const int at = a < net->dim ? a : net->dim == 2 ? 5 : a;
            to[6 * (int64_t)net->grain[i] + at] =
                factor * (momenta ? source[k] / net->mass[k] - (a < net->dim ? drift[a] : 0) : source[k]);
        }
    sp_vibration_begin(m);
    return factor;
}
