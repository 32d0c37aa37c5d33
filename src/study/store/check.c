/* Checks whether one sample of a store is what it should be. */
#include "base/base.h"
#include "store/folder.h"

#include <math.h>

/* The scene of a record. Not *known: there is none, or it has keys of another version. */
static sp_status get_scene(const sp_record *r, sp_scene *scene, bool *known, sp_error *err) {
    sp_status status = r->scene ? sp_scene_parse(r->scene, r->sample.name, 0, NULL, scene, err) : SP_EINVAL;
    *known = status == SP_OK;
    return status == SP_ENOMEM ? status : SP_OK;
}

/* The packing by itself, and what is stated of it. */
static sp_status check_packing(const char *path, const sp_packing *p, double threshold, double tolerance,
                               sp_error *err) {
    sp_audit audit;
    char reason[SP_ERROR_TEXT];
    sp_status status = sp_packing_audit(p, threshold, &audit, err);
    if (status != SP_OK)
        return status;
    sp_audit_worst(&audit, tolerance, reason, sizeof reason);
    if (*reason)
        return sp_fail(err, SP_EFAILED, "%s", reason);
    return isfinite(tolerance) ? sp_packing_check_stated(path, p, &audit, err) : SP_OK;
}

/* An infinite tolerance is that of a study, which makes again what it does not trust: it leaves alone what another
 * version may have defined or rounded otherwise. */
static sp_status check_content(const char *path, const sp_record *r, const sp_packing *p, double tolerance,
                               sp_error *err) {
    const sp_sample *s = &r->sample;
    sp_scene scene = sp_scene_default();
    bool known = false;
    if (s->dim != p->dim || s->grains != p->n)
        return sp_fail(err, SP_EFAILED, "results of %d grains in %d dimensions beside a packing of %d in %d", s->grains,
                       s->dim, p->n, p->dim);
    sp_status status = get_scene(r, &scene, &known, err);
    if (status == SP_OK && known)
        status = sp_record_scene(r, &scene, p, err);
    if (status == SP_OK)
        status = sp_sample_possible(s, err);
    if (status == SP_OK)
        status = sp_arrays_possible(s, &r->arrays, err);
    if (status == SP_OK)
        status = check_packing(path, p, scene.network.threshold, tolerance, err);
    if (status == SP_OK && known && isfinite(tolerance))
        status = sp_record_follows(r, &scene, p, err);
    sp_scene_free(&scene);
    return status;
}

sp_status sp_store_examine(const sp_store *store, const char *name, double tolerance, sp_record *r, sp_packing *p,
                           sp_error *err) {
    char path[SP_PATH_MAX];
    sp_store_path(store, name, "h5", path);
    sp_status status = sp_store_check_bytes(store, name, err);
    if (status == SP_OK)
        status = sp_store_get(store, name, p, true, r, err);
    if (status != SP_OK)
        return status;
    status = check_content(path, r, p, tolerance, err);
    if (status == SP_OK) {
        if (isfinite(tolerance))
            status = sp_store_check_line(store, &r->sample, err);
        sp_store_enter(store, &r->sample); /* which replaces a line that is wrong */
    }
    if (status != SP_OK && status != SP_ENOMEM)
        status = SP_EFAILED; /* the file can be read, so it is not damaged, and stays */
    return status;
}

sp_status sp_record_again(const sp_record *r, const sp_packing *p, sp_error *err) {
    sp_scene scene = sp_scene_default();
    bool known = false;
    sp_status status = get_scene(r, &scene, &known, err);
    if (status == SP_OK && known)
        status = sp_record_recompute(r, &scene, p, err);
    sp_scene_free(&scene);
    return status;
}

static sp_status check_sample(const sp_store *store, const char *name, sp_error *err) {
    sp_record r = {0};
    sp_packing p = sp_packing_none();
    sp_status status = sp_store_examine(store, name, INFINITY, &r, &p, err);
    sp_packing_free(&p);
    sp_record_free(&r);
    return status;
}

sp_status sp_store_trusted(const sp_store *store, const char *name, sp_sample *out, sp_error *err) {
    if (!sp_store_holds(store, name, "h5"))
        return sp_fail(err, SP_EIO, "no finished sample %s in the store %s", name, store->dir);
    if (sp_store_recall(store, name, false, out))
        return SP_OK;
    sp_status status = check_sample(store, name, err);
    return status == SP_OK ? sp_store_sample(store, name, out, err) : status;
}
