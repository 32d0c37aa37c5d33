/* Packings between two rings: parts of grains between circles, stresses on the axes of a ring, and what the grains do
 * to the rings. */
#include "base/base.h"
#include "base/vector.h"
#include "packing/bulk.h"
#include "packing/geometry.h"

#include <math.h>
#include <sonopack/packing.h>

static const double PI = 3.14159265358979323846;

/* ---- parts of grains --------------------------------------------------------------------------------------------- */

/* Area of a circular segment over r^2, whose chord has this half length, and is `distance` from the centre on the side
 * of the segment. */
static double segment(double distance, double half, double r) {
    return atan2(half, distance) - distance / r * (half / r);
}

double sp_disc_in_circle(double away, double r, double circle) {
    if (circle <= 0 || away >= circle + r)
        return 0;
    if (away <= fabs(circle - r))
        return circle < r ? circle * circle / (r * r) : 1;
    /* both arcs end on a chord at these distances from the two centres */
    const double shift = (circle - r) * (circle + r) / away, chord = 0.5 * (away + shift), near = 0.5 * (away - shift);
    const double half = sqrt(fmax(0, (r - near) * (r + near)));
    return (segment(near, half, r) + circle * circle / (r * r) * segment(chord, half, circle)) / PI;
}

/* A sum over slices along the axis of the cylinder, at r sin(angle). It is not smooth where a slice begins to reach the
 * circle: there two panels of the sum meet. u^2 (3 - 2 u) makes powers of 3/2 at the ends of a panel smooth. */
double sp_ball_in_circle(double away, double r, double circle, const double node[SP_BULK_NODES],
                         const double weight[SP_BULK_NODES]) {
    const double gap = fabs(away - circle) / r, end[3] = {0, gap < 1 ? acos(gap) : 0, 0.5 * PI};
    double sum = 0;
    for (int m = 0; m < 2; m++)
        for (int k = 0; k < SP_BULK_NODES; k++) {
            const double u = 0.5 + 0.5 * node[k], wide = end[m + 1] - end[m];
            const double c = cos(end[m] + wide * u * u * (3 - 2 * u));
            sum += weight[k] * 3 * u * (1 - u) * wide * 1.5 * c * c * c * sp_disc_in_circle(away, r * c, circle);
        }
    return sum;
}

/* ---- directions -------------------------------------------------------------------------------------------------- */

void sp_contact_point(const sp_packing *p, const sp_contact *c, double x[3]) {
    for (int a = 0; a < 3; a++)
        x[a] = p->x[3 * (size_t)c->i + (size_t)a] + c->n[a] * (p->r[c->i] - 0.5 * c->overlap);
}

void sp_packing_up(const sp_packing *p, const double x[3], double up[3]) {
    const double centre = 0.5 * p->box[0];
    const bool ring = p->cell == SP_CELL_RING;
    for (int a = 0; a < 3; a++)
        up[a] = ring && a < 2 ? (x[a] - centre) / hypot(x[0] - centre, x[1] - centre) : !ring && a == p->dim - 1;
}

void sp_ring_axes(const sp_packing *p, const sp_contact *c, double v[3]) {
    double x[3], up[3];
    sp_contact_point(p, c, x);
    sp_packing_up(p, x, up);
    const double across = v[0] * up[1] - v[1] * up[0];
    v[1] = v[0] * up[0] + v[1] * up[1];
    v[0] = across;
}

void sp_packing_moments(const sp_packing *p, const uint8_t *carrying, bool polar, double sum[3][3]) {
    for (int32_t c = 0; c < p->n_contacts; c++) {
        const sp_contact *k = &p->contacts[c];
        if (!carrying[c])
            continue;
        double branch = p->r[k->i] - k->overlap + (k->j >= 0 ? p->r[k->j] : 0), n[3], force[3];
        for (int a = 0; a < 3; a++) {
            n[a] = k->n[a];
            force[a] = k->fn * k->n[a] - k->ft[a];
        }
        if (polar) {
            sp_ring_axes(p, k, n);
            sp_ring_axes(p, k, force);
        }
        for (int a = 0; a < p->dim; a++)
            for (int b = 0; b < p->dim; b++)
                sum[a][b] += force[a] * branch * n[b];
    }
}

/* ---- the rings --------------------------------------------------------------------------------------------------- */

/* Mean stresses of the rings: the normal and the tangential force over the circumference. The latter is that of what is
 * inside on what is outside, counterclockwise. */
static void sum_walls(const sp_packing *p, const uint8_t *carrying, sp_ring_statics *s) {
    const double outer = 0.5 * p->box[0], circle[2] = {2 * PI * (outer - p->box[1]), 2 * PI * outer};
    double force[2][2] = {{0}};
    for (int32_t c = 0; c < p->n_contacts; c++) {
        const sp_contact *k = &p->contacts[c];
        if (!carrying[c] || k->j >= 0)
            continue;
        double ft[3] = {k->ft[0], k->ft[1], 0};
        sp_ring_axes(p, k, ft);
        force[k->j == SP_TOP][0] += k->fn;
        force[k->j == SP_TOP][1] += k->j == SP_TOP ? ft[0] : -ft[0]; /* ft acts on the grain, clockwise */
    }
    s->p_inner = force[0][0] / circle[0];
    s->p_outer = force[1][0] / circle[1];
    s->t_inner = force[0][1] / circle[0];
    s->t_outer = force[1][1] / circle[1];
}

sp_status sp_ring_statics_make(const sp_packing *p, double threshold, sp_ring_statics *out, sp_error *err) {
    sp_ring_statics s;
    double sum[3][3] = {{0}};
    if (p->cell != SP_CELL_RING)
        return sp_fail(err, SP_EREFUSED, "the cell is a %s, must be a ring", sp_cell_names[p->cell]);
    uint8_t *carrying = sp_alloc((size_t)p->n_contacts, 1);
    sp_status status = carrying ? sp_packing_rattlers(p, threshold, NULL, carrying, NULL, err)
                                : sp_fail_memory(err, (size_t)p->n_contacts);
    if (status == SP_OK) {
        const double volume = sp_packing_volume(p);
        sp_packing_moments(p, carrying, true, sum);
        s.s_rr = sum[1][1] / volume;
        s.s_tt = sum[0][0] / volume;
        s.s_rt = 0.0 - 0.5 * (sum[0][1] + sum[1][0]) / volume;
        sum_walls(p, carrying, &s);
        *out = s;
    }
    sp_free(carrying);
    return status;
}
