#ifndef PROPERTIES_CHANGES_H
#define PROPERTIES_CHANGES_H
/* The same packing seen otherwise: in a mirror, along other axes, from another origin, with other numbers, in other
 * units. */
#include "packing/geometry.h"
#include "properties/claims.h"

#include <sonopack/packing.h>

static inline sp_packing copied(const sp_packing *p) {
    sp_packing q = sp_packing_none();
    assert_ok(sp_packing_alloc(&q, p->dim, p->n, p->n_contacts, &err));
    sp_packing all = *p;
    all.x = q.x;
    all.r = q.r;
    all.contacts = q.contacts;
    all.mass = all.inertia = NULL;
    all.scene = NULL;
    memcpy(q.x, p->x, 3 * (size_t)p->n * sizeof *p->x);
    memcpy(q.r, p->r, (size_t)p->n * sizeof *p->r);
    memcpy(q.contacts, p->contacts, (size_t)p->n_contacts * sizeof *p->contacts);
    if (p->mass) {
        assert_ok(sp_packing_alloc_masses(&all, &err));
        memcpy(all.mass, p->mass, (size_t)p->n * sizeof *p->mass);
        memcpy(all.inertia, p->inertia, (size_t)p->n * sizeof *p->inertia);
    }
    return all;
}

/* The wall across an axis on the side -1 or 1. */
static inline int32_t wall_of(const sp_packing *p, int axis, double side) {
    const int32_t first = axis == p->dim - 1 ? SP_BOTTOM : axis == 0 ? SP_LEFT : SP_FRONT;
    return side > 0 ? first - 1 : first;
}

static inline void swap_numbers(double *x, int a, int b) {
    const double kept = x[a];
    x[a] = x[b];
    x[b] = kept;
}

/* Upside down for the up axis: the bottom wall becomes the top. */
static inline sp_packing mirrored(const sp_packing *p, int axis) {
    sp_packing q = copied(p);
    for (int32_t i = 0; i < q.n; i++)
        q.x[3 * i + axis] = p->cell == SP_CELL_PERIODIC ? -p->x[3 * i + axis] : p->box[axis] - p->x[3 * i + axis];
    for (int k = 0; k < 3; k++) { /* xy, xz, yz */
        const int a = k == 2, b = k == 0 ? 1 : 2;
        q.tilt[k] *= (a == axis) != (b == axis) ? -1 : 1;
    }
    for (int32_t c = 0; c < q.n_contacts; c++) {
        sp_contact *k = &q.contacts[c];
        k->n[axis] *= -1;
        k->ft[axis] *= -1;
        if (k->j < 0 && sp_packing_wall_axis(p, k->j) == axis)
            k->j = wall_of(p, axis, -sp_packing_wall_side(k->j));
    }
    for (int32_t i = 0; i < q.n; i++)
        sp_packing_wrap(&q, q.x + 3 * (size_t)i);
    sp_packing_sort(&q);
    return q;
}

/* Two axes change their places: with a mirror this is a turn by a right angle. Cells without tilt. */
static inline sp_packing swapped(const sp_packing *p, int a, int b) {
    sp_packing q = copied(p);
    swap_numbers(q.box, a, b);
    for (int32_t i = 0; i < q.n; i++)
        swap_numbers(q.x + 3 * (size_t)i, a, b);
    for (int32_t c = 0; c < q.n_contacts; c++) {
        sp_contact *k = &q.contacts[c];
        swap_numbers(k->n, a, b);
        swap_numbers(k->ft, a, b);
        if (k->j < 0) {
            const int axis = sp_packing_wall_axis(p, k->j);
            k->j = wall_of(p, axis == a ? b : axis == b ? a : axis, sp_packing_wall_side(k->j));
        }
    }
    sp_packing_sort(&q);
    return q;
}

/* Shifted along its periodic axes. */
static inline sp_packing shifted(const sp_packing *p, sp_random *draw) {
    sp_packing q = copied(p);
    double by[3];
    for (int a = 0; a < 3; a++)
        by[a] = a < p->dim && sp_packing_periodic(p, a) ? between(draw, -1, 1) * p->box[a] : 0;
    for (int32_t i = 0; i < q.n; i++) {
        for (int a = 0; a < 3; a++)
            q.x[3 * i + a] += by[a];
        sp_packing_wrap(&q, q.x + 3 * (size_t)i);
    }
    return q;
}

/* to [n]: the new number of each grain. */
static inline sp_packing renumbered(const sp_packing *p, sp_random *draw, int32_t *to) {
    sp_packing q = copied(p);
    for (int32_t i = 0; i < p->n; i++)
        to[i] = i;
    for (int32_t i = p->n - 1; i > 0; i--) {
        const int32_t k = (int32_t)sp_random_below(draw, (uint64_t)i + 1), kept = to[i];
        to[i] = to[k];
        to[k] = kept;
    }
    for (int32_t i = 0; i < p->n; i++) {
        memcpy(q.x + 3 * (size_t)to[i], p->x + 3 * (size_t)i, 3 * sizeof *q.x);
        q.r[to[i]] = p->r[i];
        if (p->mass) {
            q.mass[to[i]] = p->mass[i];
            q.inertia[to[i]] = p->inertia[i];
        }
    }
    for (int32_t c = 0; c < q.n_contacts; c++) {
        sp_contact *k = &q.contacts[c];
        k->i = to[k->i];
        k->j = k->j < 0 ? k->j : to[k->j];
        if (k->j < 0 || k->i < k->j)
            continue;
        const int32_t i = k->i;
        k->i = k->j;
        k->j = i;
        for (int a = 0; a < 3; a++) {
            k->n[a] *= -1;
            k->ft[a] *= -1;
        }
    }
    sp_packing_sort(&q);
    return q;
}

/* Lengths times l (a power of 4, so that roots are exact), forces times l^2: the same packing of other units. */
static inline sp_packing scaled(const sp_packing *p, double l) {
    sp_packing q = copied(p);
    for (int32_t i = 0; i < q.n; i++) {
        for (int a = 0; a < p->dim; a++)
            q.x[3 * i + a] *= l;
        q.r[i] *= l;
        if (p->mass) {
            q.mass[i] *= l * l * l;
            q.inertia[i] *= l * l * l * l * l;
        }
    }
    for (int a = 0; a < p->dim; a++)
        q.box[a] *= l;
    for (int a = 0; a < 3; a++)
        q.tilt[a] *= l;
    for (int32_t c = 0; c < q.n_contacts; c++) {
        sp_contact *k = &q.contacts[c];
        k->overlap *= l;
        k->fn *= l * l;
        k->kn *= l;
        k->kt *= l;
        for (int a = 0; a < 3; a++)
            k->ft[a] *= l * l;
    }
    return q;
}

#endif
