#include "base/base.h"
#include "packing/contact.h"
#include "packing/making.h"

#include <math.h>

static void set_globals(sp_packing *p, const sp_pack_spec *spec) {
    p->pressure = spec->pressure;
    p->friction = spec->friction;
    p->poisson = spec->poisson;
    p->seed = spec->seed;
    p->residual = 0;
}

/* N balls between two walls that answer like their neighbours, so that all springs of equal balls are equal
 * (Somfai et al. 2005, Appendix C); every contact carries p d^2. */
sp_status sp_chain_make(const sp_pack_spec *spec, sp_packing *out, sp_error *err) {
    sp_packing p = sp_packing_none();
    const int32_t n = spec->grains;
    sp_status status = sp_packing_alloc(&p, 1, n, n + 1, err);
    if (status != SP_OK)
        return status;
    set_globals(&p, spec);
    p.wall = SP_WALL_GRAIN;
    sp_radii_draw(spec, p.r);
    const double force = spec->pressure;
    double wall = 0; /* where the next surface is */
    for (int32_t i = 0; i <= n; i++) {
        sp_contact *c = &p.contacts[i < n ? (i > 0 ? i - 1 : n - 1) : n];
        double e;
        if (i == 0 || i == n) {
            c->i = i == 0 ? 0 : n - 1;
            c->j = i == 0 ? SP_BOTTOM : SP_TOP;
            c->n[0] = i == 0 ? -1 : 1;
            e = contact_wall_stiffness(p.r[c->i], p.wall);
        } else {
            c->i = i - 1;
            c->j = i;
            c->n[0] = 1;
            e = contact_stiffness(p.r[i - 1], p.r[i]);
        }
        c->fn = force;
        c->overlap = contact_overlap(e, force);
        wall -= c->overlap;
        if (i < n) {
            p.x[3 * (size_t)i] = wall + p.r[i];
            wall += 2 * p.r[i];
        }
    }
    p.box[0] = wall;
    sp_packing_sort(&p);
    *out = p;
    return SP_OK;
}

/* The overlap n of the oblique contacts and the spacing h of the rows: 2 F(n) h/(d - n) = p d^2 with
 * h^2 = (d - n)^2 - d^2/4; neighbours of a row just touch. Newton from F = p/sqrt(3). */
static double lattice_overlap(double d, double pressure, double *spacing) {
    const double e = contact_stiffness(0.5 * d, 0.5 * d), load = pressure * d * d;
    double overlap = contact_overlap(e, load / sqrt(3.0)), h = 0;
    for (int step = 0; step < 50; step++) {
        double r = d - overlap;
        h = sqrt(r * r - 0.25 * d * d);
        double f = contact_force(e, overlap);
        double slope = contact_normal_stiffness(e, overlap) * h / r - f * (0.25 * d * d) / (h * r * r);
        double change = (0.5 * load - f * h / r) / slope;
        overlap += change;
        if (fabs(change) < 1e-16 * overlap)
            break;
    }
    *spacing = h;
    return overlap;
}

static void add_contact(sp_packing *p, int32_t *count, int32_t i, int32_t j, const double n[2]) {
    bool flip = j >= 0 && j < i;
    sp_contact *c = &p->contacts[(*count)++];
    c->i = flip ? j : i;
    c->j = flip ? i : j;
    c->n[0] = flip ? -n[0] : n[0];
    c->n[1] = flip ? -n[1] : n[1];
}

/* Rows parallel to the walls, each shifted by half a diameter (section V B of the paper). */
sp_status sp_triangular_make(const sp_pack_spec *spec, sp_packing *out, sp_error *err) {
    const double d = spec->diameter_max;
    const int32_t row = (int32_t)floor(spec->width / d + 1e-9), rows = spec->grains / row;
    sp_packing p = sp_packing_none();
    sp_status status = sp_packing_alloc(&p, 2, spec->grains, 2 * row * rows, err);
    if (status != SP_OK)
        return status;
    set_globals(&p, spec);
    double h;
    const double overlap = lattice_overlap(d, spec->pressure, &h);
    const double e_wall = contact_wall_stiffness(0.5 * d, p.wall);
    const double wall_overlap = contact_overlap(e_wall, spec->pressure * d * d);
    p.box[0] = row * d;
    p.box[1] = 2 * (0.5 * d - wall_overlap) + (rows - 1) * h;
    int32_t count = 0;
    for (int32_t k = 0; k < rows; k++)
        for (int32_t m = 0; m < row; m++) {
            int32_t i = k * row + m;
            p.r[i] = 0.5 * d;
            p.x[3 * (size_t)i] = (m + (k % 2 ? 0.75 : 0.25)) * d;
            p.x[3 * (size_t)i + 1] = 0.5 * d - wall_overlap + k * h;
            if (k == 0)
                add_contact(&p, &count, i, SP_BOTTOM, (double[]){0, -1});
            if (k == rows - 1) {
                add_contact(&p, &count, i, SP_TOP, (double[]){0, 1});
                continue;
            }
            int32_t left = k % 2 ? m : (m + row - 1) % row, right = k % 2 ? (m + 1) % row : m;
            double c = 0.5 * d / (d - overlap), s = h / (d - overlap);
            add_contact(&p, &count, i, (k + 1) * row + left, (double[]){-c, s});
            add_contact(&p, &count, i, (k + 1) * row + right, (double[]){c, s});
        }
    for (int32_t c = 0; c < count; c++) {
        sp_contact *k = &p.contacts[c];
        k->overlap = k->j < 0 ? wall_overlap : overlap;
        k->fn = contact_force(k->j < 0 ? e_wall : contact_stiffness(0.5 * d, 0.5 * d), k->overlap);
    }
    sp_packing_sort(&p);
    *out = p;
    return SP_OK;
}
