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
    bool crushed = false;
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
        crushed = crushed || !(c->overlap < p.r[c->i]);
        wall -= c->overlap;
        if (i < n) {
            p.x[3 * (size_t)i] = wall + p.r[i];
            wall += 2 * p.r[i];
        }
    }
    if (crushed) {
        sp_packing_free(&p);
        return sp_fail(
            err, SP_EFAILED,
            "packing.pressure = %g: is too much for the smallest grains of this chain: overlaps are not below "
            "their radii",
            spec->pressure);
    }
    p.box[0] = wall;
    sp_packing_sort(&p);
    *out = p;
    return SP_OK;
}

/* The overlap n of the lattice's contacts. Under an isotropic pressure all carry the same force F, and two of them hold
 * a piece of wall as long as their spacing d - n, and as thick as the unit of length: sqrt(3) F(n) = p (d - n) 1.
 * Newton. */
static double lattice_overlap(double d, double pressure) {
    const double e = contact_stiffness(0.5 * d, 0.5 * d), load = pressure;
    double overlap = contact_overlap(e, load * d / sqrt(3.0));
    for (int step = 0; step < 50; step++) {
        double excess = sqrt(3.0) * contact_force(e, overlap) - load * (d - overlap);
        double change = -excess / (sqrt(3.0) * contact_normal_stiffness(e, overlap) + load);
        overlap += change;
        if (fabs(change) < 1e-16 * overlap)
            break;
    }
    return overlap;
}

static void add_contact(sp_packing *p, int32_t *count, int32_t i, int32_t j, const double n[2]) {
    bool flip = j >= 0 && j < i;
    sp_contact *c = &p->contacts[(*count)++];
    c->i = flip ? j : i;
    c->j = flip ? i : j;
    c->n[0] = flip ? 0.0 - n[0] : n[0];
    c->n[1] = flip ? 0.0 - n[1] : n[1];
}

/* The contacts of grain m of row k with the walls, the next grain of its row, and the row above. */
static void add_lattice_contacts(sp_packing *p, int32_t *count, int32_t row, int32_t rows, int32_t k, int32_t m) {
    static const double down[] = {0, -1}, up[] = {0, 1}, right[] = {1, 0};
    const double left_up[] = {-0.5, sqrt(0.75)}, right_up[] = {0.5, sqrt(0.75)};
    const int32_t i = k * row + m, next = (m + 1) % row, last = (m + row - 1) % row, above = (k + 1) * row;
    if (k == 0)
        add_contact(p, count, i, SP_BOTTOM, down);
    if (k == rows - 1)
        add_contact(p, count, i, SP_TOP, up);
    add_contact(p, count, i, k * row + next, right);
    if (k == rows - 1)
        return;
    add_contact(p, count, i, above + (k % 2 ? m : last), left_up);
    add_contact(p, count, i, above + (k % 2 ? next : m), right_up);
}

/* Rows parallel to the walls, each shifted by half a spacing, six equal contacts a grain (section V B of the paper):
 * the box is as wide as a row that is compressed like the rest. */
sp_status sp_triangular_make(const sp_pack_spec *spec, sp_packing *out, sp_error *err) {
    const double d = spec->diameter_max;
    const int32_t row = (int32_t)floor(spec->width / d + 1e-9), rows = spec->grains / row;
    sp_packing p = sp_packing_none();
    sp_status status = sp_packing_alloc(&p, 2, spec->grains, 3 * row * rows, err);
    if (status != SP_OK)
        return status;
    set_globals(&p, spec);
    const double e = contact_stiffness(0.5 * d, 0.5 * d), e_wall = contact_wall_stiffness(0.5 * d, p.wall);
    const double overlap = lattice_overlap(d, spec->pressure), spacing = d - overlap, h = sqrt(0.75) * spacing;
    const double wall_overlap = contact_overlap(e_wall, spec->pressure * spacing);
    p.box[0] = row * spacing;
    p.box[1] = 2 * (0.5 * d - wall_overlap) + (rows - 1) * h;
    int32_t count = 0;
    for (int32_t k = 0; k < rows; k++)
        for (int32_t m = 0; m < row; m++) {
            const size_t i = (size_t)k * (size_t)row + (size_t)m;
            p.r[i] = 0.5 * d;
            p.x[3 * i] = (m + (k % 2 ? 0.75 : 0.25)) * spacing;
            p.x[3 * i + 1] = 0.5 * d - wall_overlap + k * h;
            add_lattice_contacts(&p, &count, row, rows, k, m);
        }
    for (int32_t c = 0; c < count; c++) {
        sp_contact *k = &p.contacts[c];
        k->overlap = k->j < 0 ? wall_overlap : overlap;
        k->fn = contact_force(k->j < 0 ? e_wall : e, k->overlap);
    }
    sp_packing_sort(&p);
    *out = p;
    return SP_OK;
}
