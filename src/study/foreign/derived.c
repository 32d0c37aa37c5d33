/* Derived numbers of grains and contacts. */
#include "foreign/derived.h"

#include "base/base.h"
#include "packing/contact.h"
#include "packing/geometry.h"

#include <math.h>

void sp_contact_force(const sp_contact *c, double force[3]) {
    for (int a = 0; a < 3; a++)
        force[a] = c->ft[a] - c->fn * c->n[a] + 0.0; /* no negative zero */
}

double sp_contact_kt(const sp_packing *p, const sp_contact *c) {
    if (c->kn > 0)
        return c->kt;
    return p->friction > 0 && p->dim > 1 ? contact_eta(p->poisson) * contact_kn(p, c) : 0;
}

/* The image of j that lies beside the point `there`, in a periodic cell. */
static bool nearest_image(const sp_packing *p, const double there[3], int32_t j, double end[3]) {
    const double *x = p->x + 3 * (size_t)j;
    double apart[3], rest[3];
    bool crosses = false;
    for (int a = 0; a < 3; a++)
        apart[a] = rest[a] = there[a] - x[a];
    sp_packing_nearest(p, rest);
    for (int a = 0; a < 3; a++) {
        crosses = crosses || rest[a] != apart[a];
        end[a] = x[a] + (apart[a] - rest[a]);
    }
    return crosses;
}

bool sp_contact_end(const sp_packing *p, const sp_contact *c, double end[3]) {
    const double *from = p->x + 3 * (size_t)c->i, reach = p->r[c->i] - c->overlap;
    bool crosses = false;
    if (c->j >= 0 && p->cell == SP_CELL_PERIODIC) {
        double there[3];
        for (int a = 0; a < 3; a++)
            there[a] = from[a] + (reach + p->r[c->j]) * c->n[a];
        return nearest_image(p, there, c->j, end);
    }
    for (int a = 0; a < 3; a++) {
        if (c->j < 0) {
            end[a] = from[a] + reach * c->n[a];
            continue;
        }
        const double to = p->x[3 * (size_t)c->j + (size_t)a], there = from[a] + (reach + p->r[c->j]) * c->n[a];
        const double images = a < p->dim && sp_packing_periodic(p, a) ? rint((there - to) / p->box[a]) : 0;
        end[a] = to + images * p->box[a];
        crosses = crosses || images != 0;
    }
    return crosses;
}

/* Adds the force on a grain at the point that is `branch` from its centre. */
static void add_force(const sp_packing *p, sp_derived *d, int32_t i, const double branch[3], const double force[3]) {
    const double volume = grain_mass(p->r[i]);
    for (int a = 0; a < 3; a++) {
        d->net[3 * (size_t)i + (size_t)a] += force[a];
        for (int b = 0; b < 3; b++)
            d->stress[9 * (size_t)i + 3 * (size_t)a + (size_t)b] -= branch[a] * force[b] / volume;
    }
}

static void add_contact(const sp_packing *p, const sp_contact *c, sp_derived *d) {
    double force[3], branch[3];
    sp_contact_force(c, force);
    for (int a = 0; a < 3; a++)
        branch[a] = p->r[c->i] * c->n[a];
    add_force(p, d, c->i, branch, force);
    if (c->j < 0)
        return;
    for (int a = 0; a < 3; a++) {
        branch[a] = -p->r[c->j] * c->n[a];
        force[a] = -force[a];
    }
    add_force(p, d, c->j, branch, force);
}

static sp_status allocate(const sp_packing *p, sp_derived *d, sp_error *err) {
    const size_t n = (size_t)p->n;
    d->contacts = sp_alloc(n, sizeof *d->contacts);
    d->rattler = sp_alloc(n, sizeof *d->rattler);
    d->carrying = sp_alloc((size_t)p->n_contacts, 1);
    d->mass = sp_alloc(n, sizeof *d->mass);
    d->net = sp_alloc(3 * n, sizeof *d->net);
    d->stress = sp_alloc(9 * n, sizeof *d->stress);
    d->pressure = sp_alloc(n, sizeof *d->pressure);
    const bool good = d->contacts && d->rattler && d->carrying && d->mass && d->net && d->stress && d->pressure;
    return good ? SP_OK : sp_fail_memory(err, n * 120 + (size_t)p->n_contacts);
}

static sp_status find_rattlers(const sp_packing *p, sp_derived *d, sp_error *err) {
    uint8_t *rattler = sp_alloc((size_t)p->n, 1);
    sp_status status = rattler ? SP_OK : sp_fail_memory(err, (size_t)p->n);
    if (status == SP_OK)
        status = sp_packing_rattlers(p, 1e-4, rattler, d->carrying, NULL, err);
    for (int32_t i = 0; i < p->n && status == SP_OK; i++)
        d->rattler[i] = rattler[i];
    sp_free(rattler);
    return status;
}

sp_status sp_derive(const sp_packing *p, sp_derived *out, sp_error *err) {
    *out = (sp_derived){0};
    sp_status status = allocate(p, out, err);
    if (status == SP_OK)
        status = find_rattlers(p, out, err);
    for (int32_t c = 0; c < p->n_contacts && status == SP_OK; c++) {
        const sp_contact *k = &p->contacts[c];
        add_contact(p, k, out);
        if (!out->carrying[c])
            continue;
        out->contacts[k->i]++;
        if (k->j >= 0)
            out->contacts[k->j]++;
    }
    for (size_t i = 0; i < (size_t)p->n && status == SP_OK; i++) {
        const double *s = out->stress + 9 * i;
        out->mass[i] = p->mass ? p->mass[i] : grain_mass(p->r[i]);
        out->pressure[i] = (s[0] + s[4] + s[8]) / p->dim;
    }
    return status;
}

void sp_derived_free(sp_derived *d) {
    sp_free(d->contacts);
    sp_free(d->rattler);
    sp_free(d->carrying);
    sp_free(d->mass);
    sp_free(d->net);
    sp_free(d->stress);
    sp_free(d->pressure);
    *d = (sp_derived){0};
}
