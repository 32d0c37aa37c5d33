/* Turns packings into SI units. */
#include "foreign/units.h"

#include "base/base.h"
#include "foreign/derived.h"
#include "packing/contact.h"

#include <string.h>

sp_export_units sp_export_units_of(const sp_material *si) {
    static const sp_export_units own = {1, 1, 1, 1, 1, 1, "d", "rho d^3", "E* d^2", "E*", "E* d", "d, E*, rho"};
    if (!si)
        return own;
    const double d = si->diameter, modulus = sp_material_modulus(si);
    return (sp_export_units){.length = d,
                             .mass = si->density * d * d * d,
                             .density = si->density,
                             .force = modulus * d * d,
                             .stress = modulus,
                             .stiffness = modulus * d,
                             .length_name = "m",
                             .mass_name = "kg",
                             .force_name = "N",
                             .stress_name = "Pa",
                             .stiffness_name = "N/m",
                             .all = "SI"};
}

static sp_contact convert_contact(const sp_packing *p, const sp_contact *from, const sp_export_units *u) {
    sp_contact c = *from;
    c.overlap *= u->length;
    c.fn *= u->force;
    for (int a = 0; a < 3; a++)
        c.ft[a] *= u->force;
    c.kn = contact_kn(p, from) * u->stiffness;
    c.kt = sp_contact_kt(p, from) * u->stiffness;
    return c;
}

static sp_status convert_masses(const sp_packing *p, const sp_export_units *u, sp_packing *out, sp_error *err) {
    sp_status status = sp_packing_alloc_masses(out, err);
    for (int32_t i = 0; i < p->n && status == SP_OK; i++) {
        out->mass[i] = p->mass[i] * u->mass;
        out->inertia[i] = p->inertia[i] * u->mass * u->length * u->length;
    }
    return status;
}

sp_status sp_export_convert(const sp_packing *p, const sp_export_units *u, sp_packing *out, sp_error *err) {
    sp_packing q = sp_packing_none();
    sp_status status = sp_packing_alloc(&q, p->dim, p->n, p->n_contacts, err);
    if (status == SP_OK && p->mass)
        status = convert_masses(p, u, &q, err);
    if (status != SP_OK) {
        sp_packing_free(&q);
        return status;
    }
    for (size_t k = 0; k < 3 * (size_t)p->n; k++)
        q.x[k] = p->x[k] * u->length;
    for (int32_t i = 0; i < p->n; i++)
        q.r[i] = p->r[i] * u->length;
    for (int32_t c = 0; c < p->n_contacts; c++)
        q.contacts[c] = convert_contact(p, &p->contacts[c], u);
    for (int a = 0; a < 3; a++)
        q.box[a] = p->box[a] * u->length;
    for (int a = 0; a < 3; a++)
        q.tilt[a] = p->tilt[a] * u->length;
    q.cell = p->cell;
    q.gravity = p->gravity * u->stress / (u->density * u->length);
    q.pressure = p->pressure * u->stress;
    q.friction = p->friction;
    q.poisson = p->poisson;
    q.wall = p->wall;
    q.material = p->material;
    *out = q;
    return SP_OK;
}
