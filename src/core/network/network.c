/* Access to a network, its cell with lattice vectors and images, and its release. */
#include "base/base.h"
#include "network/network_cell.h"
#include "packing/geometry.h"

#include <math.h>
#include <sonopack/network.h>

sp_network_options sp_network_options_default(void) { return (sp_network_options){.threshold = 1e-4}; }

sp_network sp_network_none(void) { return (sp_network){0}; }

int64_t sp_network_dofs(const sp_network *net) { return (int64_t)net->n * net->dof; }

double sp_network_omega_bound(const sp_network *net) { return net->omega_bound; }

double sp_network_skew(const sp_network *net) { return net->skew; }

double sp_network_soft(const sp_network *net) { return net->soft; }

sp_status sp_network_need_symmetry(const sp_network *net, const char *what, sp_error *err) {
    if (!net->carried)
        return SP_OK;
    return sp_fail(
        err, SP_EREFUSED,
        "%s needs a symmetric stiffness: with prestress and friction it has an antisymmetric part (up to %.3g "
        "in omega^2, of %.3g); leave out the prestress, or take what does without: signals by chebyshev, "
        "moduli, all modes, the verdict of stability",
        what, net->skew, net->omega_bound * net->omega_bound);
}

void sp_network_free(sp_network *net) {
    sp_free(net->grain);
    sp_free(net->mass);
    sp_free(net->x);
    sp_free(net->r);
    sp_free(net->springs);
    sp_free(net->length);
    sp_free(net->carried);
    *net = sp_network_none();
}

/* ---- the cell ---------------------------------------------------------------------------------------------------- */

bool sp_network_periodic(const sp_network *net, int axis) {
    return net->cell == SP_CELL_PERIODIC || (net->cell == SP_CELL_PISTON && axis < net->dim - 1);
}

double sp_network_volume(const sp_network *net) {
    double volume = 1;
    for (int a = 0; a < net->dim; a++)
        volume *= net->box[a];
    return net->cell == SP_CELL_RING ? M_PI * volume * (1 - net->box[1] / net->box[0]) : volume;
}

void sp_network_move(const sp_network *net, int axis, double periods, double x[3]) {
    x[axis] += periods * net->box[axis];
    if (axis >= 1 && net->cell == SP_CELL_PERIODIC)
        x[0] += periods * net->tilt[axis == 1 ? 0 : 1];
    if (axis == 2 && net->cell == SP_CELL_PERIODIC)
        x[1] += periods * net->tilt[2];
}

void sp_network_image(const sp_network *net, int32_t spring, int32_t periods[3]) {
    const sp_spring *s = &net->springs[spring];
    double d[3];
    for (int a = 0; a < 3; a++) {
        periods[a] = 0;
        d[a] = net->x[3 * (int64_t)s->i + a] + net->length[spring] * s->n[a] - net->x[3 * (int64_t)s->j + a];
    }
    for (int a = net->dim - 1; a >= 0; a--)
        if (sp_network_periodic(net, a)) {
            periods[a] = (int32_t)lround(d[a] / net->box[a]);
            sp_network_move(net, a, -periods[a], d);
        }
}

void sp_network_reciprocal(const sp_network *net, int axis, double b[3]) {
    const double *l = net->box, *t = net->tilt;
    b[0] = b[1] = b[2] = 0;
    b[axis] = 1 / l[axis];
    if (axis == 1)
        b[2] = -t[2] / (l[1] * l[2]);
    if (axis == 0) {
        b[1] = -t[0] / (l[0] * l[1]);
        b[2] = (t[0] * t[2] - t[1] * l[1]) / (l[0] * l[1] * l[2]);
    }
}

sp_status sp_network_need_walls(const sp_network *net, const char *what, sp_error *err) {
    if (net->cell != SP_CELL_PERIODIC)
        return sp_cell_need_flat(net->cell, what, err);
    return sp_fail(err, SP_EREFUSED, "the cell is periodic and has no walls, which %s needs", what);
}
