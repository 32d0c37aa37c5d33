/* Brings an imported packing to rest under its pressure. */
#include "base/base.h"
#include "foreign/work.h"
#include "packing/contact.h"

#include <math.h>

/* Contacts per grain that carries force. */
static sp_status coordination(const sp_packing *p, double *z, sp_error *err) {
    sp_audit a;
    sp_status status = sp_packing_audit(p, 1e-4, &a, err);
    *z = 2.0 * a.carrying / fmax(1, p->n - a.rattlers);
    return status;
}

/* Grains come to rest between rigid walls. Contacts with other walls keep their forces; their overlaps follow. */
static void make_rigid(sp_work *w, sp_packing *p) {
    if (p->wall != SP_WALL_RIGID)
        sp_work_note(w, "the walls become rigid, since grains come to rest between such walls only");
    for (int32_t k = 0; k < p->n_contacts; k++) {
        sp_contact *c = &p->contacts[k];
        if (c->j >= 0 || (p->wall == SP_WALL_RIGID && c->kn == 0))
            continue;
        c->overlap = contact_overlap(contact_wall_stiffness(p->r[c->i], SP_WALL_RIGID), c->fn);
        c->kn = c->kt = 0;
    }
    p->wall = SP_WALL_RIGID;
}

sp_status sp_bring_to_rest(sp_work *w, sp_packing *p, sp_error *err) {
    double before, after;
    char pressure[SP_WORK_TEXT], height[2][SP_WORK_TEXT];
    sp_packing rested = sp_packing_none();
    sp_pack_spec spec = sp_pack_spec_default();
    const sp_pack_hooks hooks = {.threads = w->o->threads, .from = p};
    if (p->cell != SP_CELL_PISTON || p->gravity != 0)
        return sp_fail(err, SP_EREFUSED,
                       "%s, --rest: grains come to rest under a piston without gravity only; read this cell "
                       "without --rest, and pack it with packing.kind = \"file\"",
                       w->path);
    spec.kind = SP_PACK_FILE;
    spec.pressure = p->pressure;
    spec.friction = p->friction;
    spec.poisson = p->poisson;
    make_rigid(w, p);
    sp_status status = sp_packing_need_law(p, "coming to rest", err);
    if (status == SP_OK)
        status = coordination(p, &before, err);
    if (status == SP_OK)
        status = sp_pack_spec_from(&spec, p, err);
    if (status == SP_OK)
        status = sp_packing_make_with(&spec, &hooks, &rested, err);
    if (status == SP_OK)
        status = coordination(&rested, &after, err);
    if (status != SP_OK) {
        sp_packing_free(&rested);
        return sp_fail_prefix(err, "%s, coming to rest", w->path);
    }
    sp_work_note(w,
                 "at rest under p = %s between rigid walls: height %s -> %s, contacts per carrying grain %.3g -> %.3g",
                 sp_work_pressure(w, p->pressure, pressure), sp_work_length(w, sp_packing_height(p), height[0]),
                 sp_work_length(w, sp_packing_height(&rested), height[1]), before, after);
    rested.material = p->material;
    sp_packing_free(p);
    *p = rested;
    w->report.contacts = p->n_contacts;
    w->report.wall_contacts = 0;
    for (int32_t k = 0; k < p->n_contacts; k++)
        w->report.wall_contacts += p->contacts[k].j < 0;
    return SP_OK;
}
