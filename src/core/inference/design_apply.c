/* Makes the packing of changed grains. */
#include "inference/design.h"

#include "base/base.h"
#include "packing/contact.h"

#include <math.h>
#include <string.h>

static sp_status copy_all(const sp_packing *p, sp_packing *out, sp_error *err) {
    const size_t n = (size_t)p->n;
    sp_packing q = sp_packing_none();
    sp_status status = sp_packing_alloc(&q, p->dim, p->n, p->n_contacts, err);
    if (status == SP_OK && p->mass)
        status = sp_packing_alloc_masses(&q, err);
    if (status != SP_OK) {
        sp_packing_free(&q);
        return status;
    }
    *out = *p;
    out->x = memcpy(q.x, p->x, 3 * n * sizeof *q.x);
    out->r = memcpy(q.r, p->r, n * sizeof *q.r);
    out->mass = p->mass ? memcpy(q.mass, p->mass, n * sizeof *q.mass) : NULL;
    out->inertia = p->mass ? memcpy(q.inertia, p->inertia, n * sizeof *q.inertia) : NULL;
    out->contacts = memcpy(q.contacts, p->contacts, (size_t)p->n_contacts * sizeof *q.contacts);
    out->scene = NULL;
    return SP_OK;
}

static sp_status apply_masses(const double *factor, sp_packing *q, sp_error *err) {
    if (!q->mass) {
        sp_status status = sp_packing_alloc_masses(q, err);
        if (status != SP_OK)
            return status;
    }
    for (int32_t i = 0; i < q->n; i++) {
        q->mass[i] *= factor[i];
        q->inertia[i] *= factor[i];
    }
    return SP_OK;
}

/* E12 of two grains over that without factors; a rigid wall adds nothing, and other walls are as their grain. */
static double softness(const double *factor, const sp_contact *c) {
    const double a = factor[c->i];
    return c->j < 0 ? a : 2 * a * factor[c->j] / (a + factor[c->j]);
}

static void apply_moduli(const double *factor, sp_packing *q) {
    for (int32_t k = 0; k < q->n_contacts; k++) {
        sp_contact *c = &q->contacts[k];
        const bool own = c->kn > 0;
        const double kn = contact_kn(q, c), times = pow(softness(factor, c), 2.0 / 3);
        c->kt = times * (own ? c->kt : contact_eta(q->poisson) * kn);
        c->kn = times * kn;
    }
}

/* Compresses the packing of larger and smaller grains again, from the places that they had in the best packing so far:
 * contacts then change as little as they can. */
static sp_status compress(const sp_design_problem *d, const double *factor, sp_packing *out, sp_error *err) {
    const sp_packing *p = d->p;
    sp_packing from;
    sp_pack_spec spec = sp_pack_spec_default();
    sp_status status = copy_all(d->from ? d->from : p, &from, err);
    if (status != SP_OK)
        return status;
    for (int32_t i = 0; i < p->n; i++)
        from.r[i] = p->r[i] * factor[i];
    spec.kind = SP_PACK_FILE;
    spec.pressure = p->pressure;
    spec.friction = p->friction;
    spec.poisson = p->poisson;
    status = sp_pack_spec_from(&spec, &from, err);
    const sp_pack_hooks hooks = {.threads = d->opt->threads, .from = &from};
    if (status == SP_OK)
        status = sp_packing_make_with(&spec, &hooks, out, err);
    sp_packing_free(&from);
    return status;
}

sp_status sp_design_apply(const sp_design_problem *d, const double *factor, sp_packing *out, sp_error *err) {
    if (d->opt->vary == SP_DESIGN_RADIUS)
        return compress(d, factor, out, err);
    sp_packing q;
    sp_status status = copy_all(d->p, &q, err);
    if (status != SP_OK)
        return status;
    if (d->opt->vary == SP_DESIGN_MASS)
        status = apply_masses(factor, &q, err);
    else
        apply_moduli(factor, &q);
    if (status == SP_OK)
        *out = q;
    else
        sp_packing_free(&q);
    return status;
}
