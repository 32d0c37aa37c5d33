/* The cell of moving grains and its deformation. */
#include "packing/dynamics.h"

#include "packing/geometry.h"

#include <math.h>
#include <string.h>

sp_packing sp_dynamics_cell(const dynamics *d) {
    sp_packing p = {.dim = d->dim, .cell = d->cell, .box = {1, 1, 1}};
    for (int a = 0; a < d->dim; a++)
        p.box[a] = dynamics_edge(d, a);
    memcpy(p.tilt, d->tilt, sizeof p.tilt);
    return p;
}

/* What strains the edges of walls and periods that have no shear. */
static double stretch_sides(dynamics *d, double dt) {
    double strain = 0;
    for (int a = 0; a < d->dim - 1; a++) {
        d->period[a] *= 1 + d->strain_rate[a] * dt;
        strain += fabs(d->strain_rate[a]) * d->period[a];
    }
    if (strain > 0)
        d->area = d->period[0] * d->period[1];
    return strain;
}

/* A pair that may touch is not further apart than the largest grain and the gap, and what strains brings nearer has
 * come from there. */
static double stretch_all(dynamics *d, double dt) {
    const double *rate = d->strain_rate, *shear = d->shear_rate, y = dynamics_edge(d, 1);
    double *tilt = d->tilt, strain = 0;
    for (int a = 0; a < 3; a++)
        strain += fabs(rate[a]) + fabs(shear[a]);
    tilt[0] += dt * (rate[0] * tilt[0] + shear[0] * y);
    if (d->dim == 3) {
        tilt[1] += dt * (rate[0] * tilt[1] + shear[0] * tilt[2] + shear[1] * d->piston_y);
        tilt[2] += dt * (rate[1] * tilt[2] + shear[2] * d->piston_y);
    }
    for (int a = 0; a < d->dim - 1; a++)
        d->period[a] *= 1 + rate[a] * dt;
    d->piston_y *= 1 + rate[d->dim - 1] * dt;
    d->area = d->period[0] * d->period[1];
    return strain * (2 * d->r_max + d->outer_gap);
}

double sp_deform_cell(dynamics *d, double dt) { return d->affine ? stretch_all(d, dt) : stretch_sides(d, dt); }

void sp_deform_reduce(dynamics *d) {
    if (d->cell == SP_CELL_PERIODIC)
        sp_packing_untilt(d->dim, d->period, d->tilt);
}

void sp_deform_keep(dynamics *d) {
    for (int a = 0; a < 3; a++)
        d->listed_edge[a] = a < d->dim ? dynamics_edge(d, a) : 1;
    memcpy(d->listed_tilt, d->tilt, sizeof d->tilt);
}

void sp_deform_carry(const dynamics *d, double x[3]) {
    const double *edge = d->listed_edge, *tilt = d->listed_tilt;
    const bool solid = d->dim == 3;
    const double s2 = solid ? x[2] / edge[2] : 0, s1 = (x[1] - tilt[2] * s2) / edge[1],
                 s0 = (x[0] - tilt[0] * s1 - tilt[1] * s2) / edge[0];
    x[0] = d->period[0] * s0 + d->tilt[0] * s1 + d->tilt[1] * s2;
    x[1] = dynamics_edge(d, 1) * s1 + d->tilt[2] * s2;
    x[2] = solid ? d->piston_y * s2 : 0;
}

void sp_deform_box(const dynamics *d, double box[3]) {
    for (int a = 0; a < d->dim; a++)
        box[a] = dynamics_edge(d, a);
    if (d->cell != SP_CELL_PERIODIC)
        return;
    const double x = box[0], y = box[1], z = d->dim == 3 ? box[2] : 1, *tilt = d->tilt;
    /* volume over the area of the face, which the two other lattice vectors span */
    const double face[3] = {y * z, tilt[0] * z, tilt[0] * tilt[2] - y * tilt[1]};
    box[0] = x * (y * z) / sqrt(face[0] * face[0] + face[1] * face[1] + face[2] * face[2]);
    box[1] = d->dim == 3 ? y * z / hypot(tilt[2], z) : y;
}

const double *sp_deform_place(const dynamics *d, const double *x, double place[3]) {
    if (d->cell != SP_CELL_PERIODIC)
        return x;
    const sp_packing cell = sp_dynamics_cell(d);
    const double at[3] = {x[0], x[1], d->dim == 3 ? x[2] : 0};
    sp_packing_fractions(&cell, at, place);
    for (int a = 0; a < d->dim; a++)
        place[a] *= d->cells.box[a];
    return place;
}
