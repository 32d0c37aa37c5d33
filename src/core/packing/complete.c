/* Fills in what is not known of contacts: overlap, force or tangential stiffness. */
#include "base/base.h"
#include "packing/contact.h"

static sp_status complete(const sp_packing *p, int32_t index, sp_contact *c, sp_error *err) {
    if (c->i < 0 || c->i >= p->n || c->j < SP_BACK || c->j >= p->n)
        return sp_fail(err, SP_EINVAL, "contact %d joins %d and %d: must be grains 0 .. %d, or a grain and a wall",
                       index, c->i, c->j, p->n - 1);
    if (c->overlap < 0 || c->fn < 0 || (isnan(c->overlap) && isnan(c->fn)))
        return sp_fail(err, SP_EINVAL, "contact %d has overlap %g, fn %g: must be >= 0, and one of them known", index,
                       c->overlap, c->fn);
    const double e = contact_stiffness_in(p, c->i, c->j);
    const bool spring = c->kn > 0;
    if (isnan(c->overlap))
        c->overlap = spring ? c->fn / c->kn : contact_overlap(e, c->fn);
    else if (isnan(c->fn))
        c->fn = spring ? c->kn * c->overlap : contact_force(e, c->overlap);
    if (isnan(c->kt))
        c->kt = spring ? contact_eta(p->poisson) * c->kn : 0;
    return SP_OK;
}

sp_status sp_packing_complete(sp_packing *p, sp_error *err) {
    sp_status status = SP_OK;
    for (int32_t k = 0; k < p->n_contacts && status == SP_OK; k++)
        status = complete(p, k, &p->contacts[k], err);
    return status;
}
