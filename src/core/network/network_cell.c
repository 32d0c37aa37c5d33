/* The cell of a network: lattice vectors and images. */
#include "network/network_cell.h"

#include "base/base.h"

#include <math.h>

bool sp_network_periodic(const sp_network *net, int axis) {
    return net->cell == SP_CELL_PERIODIC || (net->cell == SP_CELL_PISTON && axis < net->dim - 1);
}

double sp_network_volume(const sp_network *net) {
    double volume = 1;
    for (int a = 0; a < net->dim; a++)
        volume *= net->box[a];
    return volume;
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
        return SP_OK;
    return sp_fail(err, SP_EREFUSED, "the cell is periodic and has no walls, which %s needs", what);
}
