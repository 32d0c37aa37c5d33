/* Density and flux of energy in a network. */
#include "base/base.h"
#include "network/network_cell.h"
#include "packing/geometry.h"
#include "transport/across.h"

#include <math.h>
#include <sonopack/transport.h>
#include <string.h>

double sp_energy_sum(const sp_energy *e) { return e->along + e->across + e->rotation + e->normal + e->tangential; }

double sp_flux_sum(const sp_flux *j) { return j->normal + j->sideways + j->rotation; }

static const double nothing[6] = {0};

/* The motion of grain i of a network; that of a wall is NULL. */
static const double *motion_of(const sp_network *net, const double *u, int32_t i) {
    return i >= 0 ? u + (ptrdiff_t)i * net->dof : NULL;
}

static void add_kinetic(const sp_network *net, const double *v, sp_energy *out) {
    for (int32_t i = 0; i < net->n; i++)
        for (int a = 0; a < net->dof; a++) {
            const int64_t k = (int64_t)i * net->dof + a;
            const double energy = 0.5 * net->mass[k] * v[k] * v[k];
            if (a >= net->dim)
                out[i].rotation += energy;
            else if (a == net->dim - 1)
                out[i].along += energy;
            else
                out[i].across += energy;
        }
}

static void add_potential(const sp_network *net, const double *u, sp_energy *out) {
    const shape s = sp_shape_of(net);
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *c = &net->springs[k];
        const stretch e = stretch_of(s, c, motion_of(net, u, c->i), motion_of(net, u, c->j));
        const double part = c->j >= 0 ? 0.25 : 0.5; /* for each grain */
        const double normal = part * c->kn * e.normal[0] * e.normal[0], side = part * sp_across(&s, c, &e, &e);
        out[c->i].normal += normal;
        out[c->i].tangential += side;
        if (c->j >= 0) {
            out[c->j].normal += normal;
            out[c->j].tangential += side;
        }
    }
}

sp_status sp_transport_energy(const sp_network *net, const double *u, const double *v, sp_energy *out, sp_error *err) {
    const sp_status status = sp_network_need_symmetry(net, "an energy", err);
    if (status != SP_OK)
        return status;
    memset(out, 0, (size_t)net->n * sizeof *out);
    add_kinetic(net, v, out);
    add_potential(net, u, out);
    return SP_OK;
}

/* What spring k passes from grain i to grain j: half of k s (ds_i/dt - ds_j/dt), where s is a stretch and ds_i/dt its
 * rate due to the motion of i alone. The energy of i loses this and that of j gains it. A spring to a wall passes
 * nothing on, since its energy belongs to the grain. */
static sp_flux passed_on(const sp_network *net, int32_t k, const double *u, const double *v) {
    const sp_spring *c = &net->springs[k];
    const shape s = sp_shape_of(net);
    const double *vi = motion_of(net, v, c->i), *vj = motion_of(net, v, c->j);
    const stretch e = stretch_of(s, c, motion_of(net, u, c->i), motion_of(net, u, c->j));
    double shift_i[6] = {0}, shift_j[6] = {0}; /* the velocities without rotation */
    memcpy(shift_i, vi, (size_t)net->dim * sizeof *vi);
    memcpy(shift_j, vj, (size_t)net->dim * sizeof *vj);
    const stretch di = stretch_of(s, c, vi, NULL), dj = stretch_of(s, c, nothing, vj);
    const stretch ti = stretch_of(s, c, shift_i, NULL), tj = stretch_of(s, c, nothing, shift_j);
    const double all = sp_across(&s, c, &e, &di) - sp_across(&s, c, &e, &dj);
    const double shifts = sp_across(&s, c, &e, &ti) - sp_across(&s, c, &e, &tj);
    return (sp_flux){.normal = 0.5 * c->kn * e.normal[0] * (di.normal[0] - dj.normal[0]),
                     .sideways = 0.5 * shifts,
                     .rotation = 0.5 * (all - shifts)};
}

/* How often the line from the centre of i to that of j crosses a plane upwards, or -1 times how often downwards. */
static int crossings(const sp_network *net, int32_t k, double plane) {
    const int up = net->dim - 1;
    const sp_spring *c = &net->springs[k];
    const double from = net->x[3 * (int64_t)c->i + up] - plane;
    if (sp_network_periodic(net, up)) {
        int32_t periods[3];
        sp_network_image(net, k, periods);
        const double to = net->x[3 * (int64_t)c->j + up] + periods[up] * net->box[up] - plane;
        return (int)(floor(to / net->box[up]) - floor(from / net->box[up]));
    }
    return (net->x[3 * (int64_t)c->j + up] >= plane) - (from >= 0);
}

sp_status sp_transport_flux(const sp_network *net, const double *u, const double *v, int32_t planes,
                            const double *height, sp_flux *out, sp_error *err) {
    sp_status status = sp_network_need_symmetry(net, "a flux of energy", err);
    if (status == SP_OK)
        status = sp_cell_need_flat(net->cell, "a flux of energy", err);
    if (status != SP_OK)
        return status;
    memset(out, 0, (size_t)planes * sizeof *out);
    for (int32_t k = 0; k < net->n_bulk; k++) {
        const sp_flux j = passed_on(net, k, u, v);
        for (int32_t l = 0; l < planes; l++) {
            const int times = crossings(net, k, height[l]);
            out[l].normal += times * j.normal;
            out[l].sideways += times * j.sideways;
            out[l].rotation += times * j.rotation;
        }
    }
    return SP_OK;
}

sp_status sp_transport_current(const sp_network *net, const double *u, const double *v, int axis, double *out,
                               sp_error *err) {
    if (axis < 0 || axis >= net->dim)
        return sp_fail(err, SP_EINVAL, "axis %d of the current: must be 0 .. %d", axis, net->dim - 1);
    const sp_status status = sp_network_need_symmetry(net, "a current of energy", err);
    if (status != SP_OK)
        return status;
    double sum = 0;
    for (int32_t k = 0; k < net->n_bulk; k++) {
        const sp_flux j = passed_on(net, k, u, v);
        sum += sp_flux_sum(&j) * net->length[k] * net->springs[k].n[axis];
    }
    *out = sum;
    return SP_OK;
}
