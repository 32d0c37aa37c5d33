#ifndef TEST_SENSITIVITY_CHANGES_H
#define TEST_SENSITIVITY_CHANGES_H
/* Small changes of networks and packings, for differences of quantities. */
#include "making.h"
#include "packing/contact.h"
#include "packing/geometry.h"
#include "signals.h"

#include <sonopack/sensitivity.h>

/* A copy with arrays of its own for what changes. */
static inline sp_packing copy_packing(const sp_packing *p) {
    sp_packing q = *p;
    q.x = malloc(3 * (size_t)p->n * sizeof *q.x);
    q.r = malloc((size_t)p->n * sizeof *q.r);
    q.contacts = malloc((size_t)p->n_contacts * sizeof *q.contacts);
    assert_true(q.x && q.r && q.contacts);
    memcpy(q.x, p->x, 3 * (size_t)p->n * sizeof *q.x);
    memcpy(q.r, p->r, (size_t)p->n * sizeof *q.r);
    memcpy(q.contacts, p->contacts, (size_t)p->n_contacts * sizeof *q.contacts);
    return q;
}

static inline void drop_copy(sp_packing *p) {
    free(p->x);
    free(p->r);
    free(p->contacts);
}

/* Contacts as positions and radii have them, by Hertz's law. */
static inline void follow(sp_packing *p) {
    for (int k = 0; k < p->n_contacts; k++) {
        sp_contact *c = &p->contacts[k];
        double d[3] = {0, 0, 0}, length = 0;
        if (c->j < 0)
            length = sp_packing_wall_distance(p, c->i, c->j);
        else
            sp_packing_separation(p, c->i, c->j, d);
        if (c->j >= 0) {
            length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
            for (int a = 0; a < 3; a++)
                c->n[a] = d[a] / length;
        }
        c->overlap = p->r[c->i] + (c->j < 0 ? 0 : p->r[c->j]) - length;
        c->fn = c->overlap > 0 ? contact_force(contact_stiffness_in(p, c->i, c->j), c->overlap) : 0;
    }
}

/* A parameter of the network of a packing. */
typedef struct parameter {
    sp_parameter by;
    int index; /* spring, grain, or 3 grain + axis */
} parameter;

/* A change of the parameter of which a millionth part matters to nothing but the quantity. */
static inline double scale_of(const sp_network *net, const sp_packing *p, parameter at) {
    if (at.by == SP_BY_KN)
        return net->springs[at.index].kn;
    if (at.by == SP_BY_KT)
        return net->springs[at.index].kt;
    if (at.by == SP_BY_MASS)
        return net->mass[at.index * net->dof];
    double overlap = 0;
    for (int k = 0; k < net->n_springs; k++)
        overlap += p->contacts[net->springs[k].contact].overlap / net->n_springs;
    return overlap;
}

/* The network with the parameter changed by `change`. */
static inline sp_network changed(const sp_packing *p, bool prestress, parameter at, double change) {
    sp_packing q = copy_packing(p);
    sp_network net = network_of(&q, prestress);
    if (at.by == SP_BY_RADIUS || at.by == SP_BY_POSITION) {
        if (at.by == SP_BY_RADIUS)
            q.r[net.grain[at.index]] += change;
        else
            q.x[3 * net.grain[at.index / 3] + at.index % 3] += change;
        follow(&q);
        sp_network_free(&net);
        net = network_of(&q, prestress);
    }
    const double mass = at.by == SP_BY_MASS ? net.mass[at.index * net.dof] : 1;
    if (at.by == SP_BY_KN)
        net.springs[at.index].kn += change;
    if (at.by == SP_BY_KT)
        net.springs[at.index].kt += change;
    for (int a = 0; a < net.dof && at.by == SP_BY_MASS; a++)
        net.mass[at.index * net.dof + a] *= 1 + change / mass;
    drop_copy(&q);
    return net;
}

static inline const sp_partials *partials_of(const sp_gradient *g, sp_parameter by) {
    switch (by) {
    case SP_BY_KN: return &g->kn;
    case SP_BY_KT: return &g->kt;
    case SP_BY_MASS: return &g->mass;
    case SP_BY_RADIUS: return &g->radius;
    case SP_BY_POSITION: return &g->position;
    default: return &g->pressure;
    }
}

/* A quantity of a network. */
typedef double quantity(const sp_network *net, void *with);

/* The derivative of the quantity against central differences with steps of 2h and h: the error falls by 4, and what
 * both extrapolate to is the derivative. noise: relative error of the quantity. */
static inline void assert_derivative(const sp_packing *p, bool prestress, parameter at, double d, double h,
                                     quantity *of, void *with, double size) {
    FREED(sp_network) net = network_of(p, prestress);
    const double unit = scale_of(&net, p, at);
    double slope[2];
    for (int k = 0; k < 2; k++) {
        const double step = unit * h * (k == 0 ? 2 : 1);
        FREED(sp_network) up = changed(p, prestress, at, step), down = changed(p, prestress, at, -step);
        slope[k] = (of(&up, with) - of(&down, with)) / (2 * step);
    }
    const double limit = (4 * slope[1] - slope[0]) / 3, noise = 1e-13 * size / (unit * h);
    /* the extrapolation leaves an error of fourth order */
    const double room = 1e-6 * fabs(d) + 2e-3 * fabs(slope[1] - d) + 10 * noise;
    if (!(fabs(limit - d) <= room))
        print_message("parameter %d of %d: derivative %.12g, differences %.12g %.12g -> %.12g, noise %.3g\n", at.index,
                      (int)at.by, d, slope[0], slope[1], limit, noise);
    assert_true(fabs(limit - d) <= room);
    /* an error of second order, where it is above the noise */
    if (fabs(slope[0] - d) > 1000 * noise) {
        const double ratio = (slope[0] - d) / (slope[1] - d);
        if (!(ratio > 3 && ratio < 5))
            print_message("ratio %g at %d of %d\n", ratio, at.index, (int)at.by);
        assert_true(ratio > 3 && ratio < 5);
    }
}

#endif
