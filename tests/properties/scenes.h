#ifndef PROPERTIES_SCENES_H
#define PROPERTIES_SCENES_H
/* Random packings of few grains, in every kind of cell: grains around the points of a lattice, as a rule in no
 * equilibrium, with forces, laws and masses of any kind. What needs no equilibrium has to hold for them too. */
#include "cells.h"
#include "properties/claims.h"

typedef struct scene {
    sp_packing p;
    sp_network_options how;
    char words[200];
} scene;

static inline void scene_cell(sp_random *draw, sp_packing *p, const int per[3], double spacing) {
    p->cell = (sp_cell)whole(draw, 0, p->dim == 1 ? 1 : 2); /* a chain is no box */
    for (int a = 0; a < 3; a++)
        p->box[a] = a < p->dim ? per[a] * spacing : 1;
    if (p->cell != SP_CELL_PERIODIC || p->dim == 1 || chance(draw, 0.5))
        return;
    p->tilt[0] = between(draw, -0.5, 0.5) * p->box[0];
    for (int a = 1; a < 3 && p->dim == 3; a++)
        p->tilt[a] = between(draw, -0.5, 0.5) * p->box[a - 1];
}

static inline void scene_place(sp_random *draw, sp_packing *p, const int per[3], double spacing) {
    static const double jitters[] = {0, 0.01, 0.1, 0.1, 0.2}, spreads[] = {1, 1.01, 1.2, 1.5};
    const double jitter = one_of(draw, 5, jitters), spread = one_of(draw, 4, spreads);
    for (int i = 0; i < p->n; i++) {
        double s[3] = {0}, *x = p->x + 3 * (size_t)i;
        for (int a = 0, rest = i; a < p->dim; rest /= per[a++])
            s[a] = (rest % per[a] + 0.5 + between(draw, -jitter, jitter)) * spacing / p->box[a];
        x[0] = s[0] * p->box[0] + s[1] * p->tilt[0] + s[2] * p->tilt[1];
        x[1] = p->dim > 1 ? s[1] * p->box[1] + s[2] * p->tilt[2] : 0;
        x[2] = p->dim > 2 ? s[2] * p->box[2] : 0;
        sp_packing_wrap(p, x);
        p->r[i] = 0.5 * between(draw, 1, spread);
    }
}

/* Adds a grain of a hundredth of the size that touches both grains of a contact, beside their line. */
static inline void scene_crumb(sp_random *draw, sp_packing *p) {
    const sp_contact *c = &p->contacts[sp_random_below(draw, (uint64_t)p->n_contacts)];
    const double small = 0.005, sink = 1e-3 * small;
    if (c->j < 0 || p->n < 2)
        return;
    const double one = p->r[c->i] + small - sink, two = p->r[c->j] + small - sink,
                 apart = p->r[c->i] + p->r[c->j] - c->overlap;
    const double along = (apart * apart + one * one - two * two) / (2 * apart),
                 across = sqrt(one * one - along * along);
    const double angle = between(draw, 0, 2 * 3.14159265358979), *n = c->n;
    double e[3] = {-n[1], n[0], 0}, f[3], length = sqrt(n[0] * n[0] + n[1] * n[1]);
    if (!(across > 0) || length < 0.1)
        return;
    for (int a = 0; a < 3; a++)
        e[a] /= length;
    f[0] = n[1] * e[2] - n[2] * e[1], f[1] = n[2] * e[0] - n[0] * e[2], f[2] = n[0] * e[1] - n[1] * e[0];
    const double ce = p->dim == 3 ? cos(angle) : chance(draw, 0.5) ? 1 : -1, cf = p->dim == 3 ? sin(angle) : 0;
    sp_packing more = sp_packing_none();
    assert_ok(sp_packing_alloc(&more, p->dim, p->n + 1, 0, &err));
    memcpy(more.x, p->x, 3 * (size_t)p->n * sizeof *p->x);
    memcpy(more.r, p->r, (size_t)p->n * sizeof *p->r);
    more.r[p->n] = small;
    for (int a = 0; a < 3; a++)
        more.x[3 * p->n + a] = p->x[3 * c->i + a] + along * n[a] + across * (ce * e[a] + cf * f[a]);
    more.cell = p->cell;
    memcpy(more.box, p->box, sizeof p->box);
    memcpy(more.tilt, p->tilt, sizeof p->tilt);
    sp_packing_wrap(&more, more.x + 3 * (size_t)p->n);
    sp_packing_free(p);
    *p = more;
    add_contacts(p);
}

static inline void scene_across(int dim, const double *n, double *t) {
    double along = 0;
    for (int a = 0; a < dim; a++)
        along += t[a] * n[a];
    for (int a = 0; a < dim; a++)
        t[a] -= along * n[a];
}

/* Leaves out contacts, and gives the others tangential forces, laws of their own, or no force. */
static inline void scene_forces(sp_random *draw, sp_packing *p) {
    static const double keeps[] = {1, 1, 1, 0.8, 0.5}, shares[] = {0, 0.1, 0.9, 0.995};
    const double keep = one_of(draw, 5, keeps), share = one_of(draw, 4, shares);
    const bool own = chance(draw, 0.25), zero = chance(draw, 0.2);
    int kept = 0;
    for (int k = 0; k < p->n_contacts; k++) {
        sp_contact c = p->contacts[k];
        double t[3] = {0}, size = 0;
        for (int a = 0; a < p->dim; a++)
            t[a] = between(draw, -1, 1);
        scene_across(p->dim, c.n, t);
        scene_across(p->dim, c.n, t); /* twice is enough */
        for (int a = 0; a < p->dim; a++)
            size += t[a] * t[a];
        if (zero && chance(draw, 0.2))
            c.fn = c.overlap = 0;
        for (int a = 0; a < p->dim && size > 0; a++)
            c.ft[a] = share * fmin(p->friction, 1) * c.fn * t[a] / sqrt(size);
        if (own) {
            c.kn = contact_kn(p, &c) * pow(10, between(draw, -2, 2)) + 1e-6;
            c.kt = chance(draw, 0.3) ? 0 : c.kn * between(draw, 0, 1.5);
        }
        if (chance(draw, keep))
            p->contacts[kept++] = c;
    }
    p->n_contacts = kept;
}

static inline void scene_masses(sp_random *draw, sp_packing *p) {
    static const double decades[] = {0, 1, 3, 8};
    const double spread = one_of(draw, 4, decades);
    if (chance(draw, 0.7))
        return;
    assert_ok(sp_packing_alloc_masses(p, &err));
    for (int i = 0; i < p->n; i++) {
        const double factor = pow(10, spread * between(draw, -0.5, 0.5));
        p->mass[i] *= factor;
        p->inertia[i] *= factor * between(draw, 0.5, 1.6);
    }
}

/* most: grains, about; edge: of grains along an edge in 1, 2 and 3 dimensions at most, 0: none of this dimension. */
static inline scene scene_draw_of(sp_random *draw, int most, const int edge[4]) {
    static const double frictions[] = {0, 0, 0.1, 0.5, 0.5, 1e6}, ratios[] = {0, 0.2, 0.3, 0.5};
    scene s = {.p = sp_packing_none(), .how = sp_network_options_default()};
    sp_packing *p = &s.p;
    const int dim = whole(draw, edge[1] ? 1 : 2, 3);
    const double spacing = between(draw, 0.85, 0.99);
    int per[3] = {1, 1, 1}, n = 1;
    for (int a = 0; a < dim; a++) {
        per[a] = whole(draw, 1, edge[dim]);
        while (n * per[a] > most)
            per[a]--;
        n *= per[a];
    }
    assert_ok(sp_packing_alloc(p, dim, n, 0, &err));
    scene_cell(draw, p, per, spacing);
    p->friction = one_of(draw, 6, frictions);
    p->poisson = one_of(draw, 4, ratios);
    p->wall = (sp_wall)whole(draw, 0, 2);
    scene_place(draw, p, per, spacing);
    const sp_packing empty = *p;
    add_contacts(p);
    for (int k = 0; k < 2 && p->n_contacts > 0 && chance(draw, 0.3); k++) {
        scene_crumb(draw, p);
        p->friction = empty.friction;
        p->poisson = empty.poisson;
        p->wall = empty.wall;
        add_contacts(p);
    }
    scene_forces(draw, p);
    scene_masses(draw, p);
    s.how.threshold = chance(draw, 0.5) ? 0 : 1e-4;
    s.how.prestress = chance(draw, 0.4);
    s.how.sliding_free = chance(draw, 0.2);
    snprintf(s.words, sizeof s.words,
             "%dD, cell %d, %d grains (%dx%dx%d), %d contacts, friction %g, prestress %d, threshold %g%s", dim,
             (int)p->cell, p->n, per[0], per[1], per[2], p->n_contacts, p->friction, s.how.prestress, s.how.threshold,
             p->mass ? ", masses" : "");
    return s;
}

static inline scene scene_draw(sp_random *draw, int most) {
    static const int edge[4] = {0, 0, 5, 3};
    return scene_draw_of(draw, most, edge);
}

static inline sp_place scene_spot(const sp_network *net, sp_random *draw) {
    const int kind = whole(draw, 0, 5);
    sp_place p = sp_place_wall();
    p.shear = net->dim > 1 && chance(draw, 0.3);
    if (kind >= 4) {
        p.kind = SP_PLACE_PLANE;
        p.height = net->box[net->dim - 1] * between(draw, 0.1, 0.9);
    } else if (kind >= 2) {
        p.kind = SP_PLACE_GRAIN;
        p.grain = net->grain[whole(draw, 0, net->n - 1)];
    } else if (kind == 1 && net->dim > 1) {
        p.kind = SP_PLACE_PART;
        p.from = 0;
        p.to = net->box[0] * between(draw, 0.3, 1);
    }
    return p;
}

#endif
