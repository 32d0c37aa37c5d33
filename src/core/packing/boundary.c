/* What bounds a packing: its edges, lattice vectors and walls. */
#include "packing/geometry.h"

#include <math.h>

double sp_packing_height(const sp_packing *p) { return p->box[p->dim - 1]; }

double sp_packing_wall_area(const sp_packing *p) {
    double area = 1.0;
    for (int k = 0; k < p->dim - 1; k++)
        area *= p->box[k];
    return area;
}

double sp_packing_volume(const sp_packing *p) { return sp_packing_wall_area(p) * sp_packing_height(p); }

bool sp_packing_periodic(const sp_packing *p, int axis) {
    return p->cell == SP_CELL_PERIODIC || (p->cell == SP_CELL_PISTON && axis < p->dim - 1);
}

int sp_packing_wall_axis(const sp_packing *p, int32_t wall) {
    return wall >= SP_TOP ? p->dim - 1 : wall >= SP_RIGHT ? 0 : 1;
}

double sp_packing_wall_side(int32_t wall) { return wall % 2 == 0 ? 1 : -1; }

bool sp_packing_has_wall(const sp_packing *p, int32_t wall) {
    if (wall >= SP_TOP)
        return p->cell != SP_CELL_PERIODIC;
    return p->cell == SP_CELL_BOX && sp_packing_wall_axis(p, wall) < p->dim - 1;
}

/* Subtracts a multiple of the lattice vector of an axis. */
static void shift(const sp_packing *p, int axis, double periods, double d[3]) {
    d[axis] -= p->box[axis] * periods;
    if (axis >= 1)
        d[0] -= p->tilt[axis == 1 ? 0 : 1] * periods;
    if (axis == 2)
        d[1] -= p->tilt[2] * periods;
}

void sp_packing_nearest(const sp_packing *p, double d[3]) {
    for (int a = p->dim - 1; a >= 0; a--) {
        const double periods = sp_packing_periodic(p, a) ? nearbyint(d[a] / p->box[a]) : 0;
        if (periods != 0)
            shift(p, a, periods, d);
    }
}

void sp_packing_fractions(const sp_packing *p, const double x[3], double s[3]) {
    s[2] = x[2] / p->box[2];
    s[1] = (x[1] - p->tilt[2] * s[2]) / p->box[1];
    s[0] = (x[0] - p->tilt[0] * s[1] - p->tilt[1] * s[2]) / p->box[0];
}

void sp_packing_wrap(const sp_packing *p, double x[3]) {
    for (int a = p->dim - 1; a >= 0; a--) {
        double s[3];
        sp_packing_fractions(p, x, s);
        const double periods = sp_packing_periodic(p, a) ? floor(s[a]) : 0;
        if (periods != 0)
            shift(p, a, periods, x);
        sp_packing_fractions(p, x, s);
        if (sp_packing_periodic(p, a) && s[a] >= 1) /* a tiny negative coordinate rounds to the far end */
            shift(p, a, 1, x);
    }
}

double sp_packing_wall_distance(const sp_packing *p, int32_t i, int32_t wall) {
    const int axis = sp_packing_wall_axis(p, wall);
    const double x = p->x[3 * (size_t)i + (size_t)axis];
    return sp_packing_wall_side(wall) < 0 ? x : p->box[axis] - x;
}
