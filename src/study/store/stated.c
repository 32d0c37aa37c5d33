/* What a file says of its packing beside grains and contacts, compared with these. */
#include "base/base.h"
#include "packing/contact.h"
#include "store/folder.h"

#include <math.h>
#include <string.h>

sp_status sp_at_odds(sp_error *err, const char *field, double stored, double expected) {
    char one[SP_NUMBER_TEXT], other[SP_NUMBER_TEXT];
    return sp_fail_key(err, SP_EFAILED, field, " = %s: must be %s", sp_number_text(stored, one),
                       sp_number_text(expected, other));
}

/* ---- the scene ------------------------------------------------------------------------------------------------- */

/* Periods that nothing changes while the piston comes down. */
static bool keeps_width(const sp_pack_spec *s) {
    return s->kind == SP_PACK_PISTON && s->cell == SP_CELL_PISTON && s->compression == SP_COMPRESSION_PISTON;
}

static sp_status check_spec(const sp_packing *p, const sp_pack_spec *s, sp_error *err) {
    const double depth = s->depth > 0 ? s->depth : s->width;
    const struct {
        const char *field;
        double stored, expected;
        bool applies;
    } pair[] = {
        {"/sonopack/dimension", p->dim, s->dim, true},
        {"grains", p->n, s->grains, true},
        {"cell", p->cell, s->cell, true},
        {"/sonopack/friction", p->friction, s->friction, true},
        {"/sonopack/poisson", p->poisson, s->poisson, true},
        {"gravity", p->gravity, s->gravity, true},
        {"width", p->box[0], s->width, keeps_width(s)},
        {"depth", p->box[1], depth, keeps_width(s) && p->dim == 3},
    };
    if (p->seed != s->seed)
        return sp_fail_key(err, SP_EFAILED, "/sonopack/seed", " = %llu: must be %llu", (unsigned long long)p->seed,
                           (unsigned long long)s->seed);
    for (size_t k = 0; k < sizeof pair / sizeof *pair; k++)
        if (pair[k].applies && !(fabs(pair[k].stored - pair[k].expected) <= 1e-12 * fabs(pair[k].expected)))
            return sp_at_odds(err, pair[k].field, pair[k].stored, pair[k].expected);
    return SP_OK;
}

/* The pressure of the scene, or of a stage of its history; a mean of stresses reaches its aim to the tolerance of the
 * compression. */
static sp_status check_pressure(const sp_packing *p, const sp_pack_spec *s, sp_error *err) {
    const double exact = p->cell == SP_CELL_PISTON ? 1e-12 : 1e-3;
    bool found = fabs(p->pressure - s->pressure) <= exact * s->pressure;
    for (int32_t k = 0; k < s->history_count && !found; k++)
        found = fabs(p->pressure - s->history[k]) <= exact * s->history[k];
    return found || s->stress_count > 0 || s->strain_count > 0 || s->fraction > 0
               ? SP_OK
               : sp_at_odds(err, "/sonopack/pressure", p->pressure, s->pressure);
}

/* The keys of the packing's own scene. A scene that this version cannot read is left out. SP_ENOMEM. */
static sp_status stated_scene(const sp_packing *p, sp_error *err) {
    sp_scene scene = sp_scene_default();
    sp_status status = p->scene ? sp_scene_parse(p->scene, "scene", 0, NULL, &scene, err) : SP_EINVAL;
    if (status == SP_OK)
        status = sp_scene_resolve(&scene, err);
    if (status != SP_OK) /* none, or one with keys of another version */
        return status == SP_ENOMEM ? status : SP_OK;
    status = check_spec(p, &scene.pack, err);
    if (status == SP_OK)
        status = check_pressure(p, &scene.pack, err);
    sp_scene_free(&scene);
    return status;
}

/* The residual is the largest acceleration at the end, which a reader takes for the quality of the packing. Those of
 * lattices are 0, where rounding is not. Contacts that slide during the last step are put back on Coulomb's limit after
 * the residual was found: one packing in 150 of 40 grains has an acceleration up to 1.2 times as large. */
static sp_status stated_residual(const sp_packing *p, const sp_audit *audit, sp_error *err) {
    const double stated = p->residual, found = audit->acceleration;
    if (isnan(stated) || (isfinite(stated) && stated >= 0 && found <= 10 * stated + 1e-9 * p->pressure))
        return SP_OK;
    return sp_at_odds(err, "/sonopack/residual", stated, found);
}

/* ---- numbers that no reader of packings uses --------------------------------------------------------------------- */

static void check_masses(sp_h5 *h, const sp_packing *p) {
    static const char *const path = "/particles/grains/mass";
    if (p->mass || !sp_h5_has(h, path))
        return;
    double *stated = sp_h5_alloc(h, p->n, sizeof *stated);
    sp_h5_get(h, path, SP_H5_F64, &(sp_h5_shape){1, {p->n}}, stated);
    for (int32_t i = 0; h->status == SP_OK && i < p->n; i++)
        if (!(fabs(stated[i] - grain_mass(p->r[i])) <= 1e-9 * grain_mass(p->r[i])))
            h->status = sp_at_odds(h->err, path, stated[i], grain_mass(p->r[i]));
    sp_free(stated);
}

static void check_rattlers(sp_h5 *h, const sp_packing *p) {
    static const char *const path = "/sonopack/rattler";
    if (!sp_h5_has(h, path))
        return;
    uint8_t *stated = sp_h5_alloc(h, p->n, 1), *found = sp_h5_alloc(h, p->n, 1);
    if (sp_h5_get(h, path, SP_H5_U8, &(sp_h5_shape){1, {p->n}}, stated) == SP_OK)
        h->status = sp_packing_rattlers(p, 1e-4, found, NULL, NULL, h->err);
    for (int32_t i = 0; h->status == SP_OK && i < p->n; i++)
        if (stated[i] != found[i])
            h->status = sp_at_odds(h->err, path, stated[i], found[i]);
    sp_free(stated);
    sp_free(found);
}

static void check_steps(sp_h5 *h, const sp_packing *p) {
    static const char *const path = "/particles/grains/position/step";
    int64_t step = 0;
    if (sp_h5_has(h, path) && sp_h5_get(h, path, SP_H5_I64, &(sp_h5_shape){1, {1}}, &step) == SP_OK && step != p->steps)
        h->status = sp_at_odds(h->err, path, (double)step, (double)p->steps);
}

/* Masses, rattlers and steps in an HDF5 file, which are there for other programs. */
static sp_status stated_unread(const char *path, const sp_packing *p, sp_error *err) {
    sp_h5 h;
    sp_h5_open(&h, path, err);
    check_masses(&h, p);
    check_rattlers(&h, p);
    check_steps(&h, p);
    return sp_h5_close(&h);
}

sp_status sp_packing_check_stated(const char *path, const sp_packing *p, const sp_audit *audit, sp_error *err) {
    bool hdf5;
    sp_status status = sp_is_hdf5(path, &hdf5, err);
    if (status == SP_OK)
        status = stated_scene(p, err);
    if (status == SP_OK)
        status = stated_residual(p, audit, err);
    return status == SP_OK && hdf5 ? stated_unread(path, p, err) : status;
}
