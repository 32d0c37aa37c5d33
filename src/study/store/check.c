/* Checks whether one sample of a store is what it should be. */
#include "base/base.h"
#include "store/folder.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

static bool any_infinite(const double *x, size_t bytes) {
    for (size_t k = 0; k < bytes / sizeof *x; k++)
        if (isinf(x[k]))
            return true;
    return false;
}

static sp_status check_signal(const sp_signal *s, sp_error *err) {
    for (int32_t k = 0; k < s->n; k++)
        if (!isfinite(s->t[k]) || !isfinite(s->f[k]) || (k > 0 && !(s->t[k] > s->t[k - 1])))
            return sp_fail(err, SP_EFAILED, "/signal: t = %g, F = %g at point %d: must be finite, at rising times",
                           s->t[k], s->f[k], k);
    return SP_OK;
}

static sp_status check_spectrum(const sp_spectrum_made *made, const sp_sample_arrays *a, sp_error *err) {
    int64_t zeros = 0;
    for (int64_t k = 0; k < a->modes; k++) {
        if (!isfinite(a->omega[k]) || a->omega[k] < (k > 0 ? a->omega[k - 1] : 0))
            return sp_fail(err, SP_EFAILED,
                           "/results/spectrum/omega: %g of mode %lld: must be finite, not below 0, and not below the "
                           "one before",
                           a->omega[k], (long long)k);
        zeros += !(a->omega[k] > 0);
    }
    if (a->modes > 0 && (zeros != made->zero_modes || a->omega[a->modes - 1] != made->omega_max))
        return sp_fail(err, SP_EFAILED,
                       "/results/spectrum: zero_modes = %d, omega_max = %g beside frequencies of which %lld are 0 and "
                       "%g is the largest",
                       made->zero_modes, made->omega_max, (long long)zeros, a->omega[a->modes - 1]);
    return SP_OK;
}

/* Averages over nothing are NAN, and so are planes without a front. The results of a front or a solve must be finite.
 */
static sp_status check_results(const sp_record *r, sp_error *err) {
    const sp_sample *s = &r->sample;
    const sp_front *f = &s->front;
    if (s->have & SP_WANT_CTOF && !(isfinite(f->t10) && isfinite(f->t_peak) && isfinite(f->amplitude)))
        return sp_fail(err, SP_EFAILED, "/results/front: t10 = %g, t_peak = %g, amplitude = %g: must be finite", f->t10,
                       f->t_peak, f->amplitude);
    if (s->have & SP_WANT_STATICS && any_infinite(&s->statics.phi2, sizeof s->statics))
        return sp_fail(err, SP_EFAILED, "/results/statics: an infinite number");
    const double along = s->dim == 3 ? s->moduli.c33 : s->moduli.c22; /* in the direction from wall to wall */
    if (s->have & SP_WANT_MODULI && !isfinite(along))
        return sp_fail(err, SP_EFAILED, "/results/moduli: %s = %g: must be finite", s->dim == 3 ? "c33" : "c22", along);
    for (int k = 0; s->have & SP_WANT_PROBES && k < SP_PROBES; k++)
        if (isinf(s->probe[k].along) || isinf(s->probe[k].shear))
            return sp_fail(err, SP_EFAILED, "/results/probes: an infinite modulus");
    for (int32_t k = 0; s->have & SP_WANT_PLANES && k < s->planes; k++)
        if (any_infinite(&s->plane_front[k].t10, offsetof(sp_front, crossings)))
            return sp_fail(err, SP_EFAILED, "/results/planes: an infinite number at plane %d", k);
    sp_status status = check_signal(&r->arrays.signal, err);
    return status == SP_OK ? check_spectrum(&s->spectrum, &r->arrays, err) : status;
}

/* Compares the sample with its packing and its scene. A scene with keys of another version is ignored. */
static sp_status check_scene(const sp_record *r, const sp_packing *p, sp_scene *scene, sp_error *err) {
    const sp_sample *s = &r->sample;
    if (s->dim != p->dim || s->grains != p->n)
        return sp_fail(err, SP_EFAILED, "results of %d grains in %d dimensions beside a packing of %d in %d", s->grains,
                       s->dim, p->n, p->dim);
    sp_status status = r->scene ? sp_scene_parse(r->scene, s->name, 0, NULL, scene, err) : SP_EINVAL;
    if (status != SP_OK)
        return status == SP_ENOMEM ? status : SP_OK;
    char name[SP_NAME_MAX];
    sp_sample_name(scene, name);
    if (name[0] == '\0')
        return sp_fail_memory(err, 4096);
    if (strcmp(name, s->name) != 0)
        return sp_fail(err, SP_EFAILED, "its scene makes the sample %s: another, or one of other algorithms", name);
    return SP_OK;
}

static sp_status check_content(const sp_record *r, const sp_packing *p, double tolerance, sp_error *err) {
    sp_scene scene = sp_scene_default();
    sp_audit audit;
    char reason[SP_ERROR_TEXT];
    sp_status status = check_scene(r, p, &scene, err);
    if (status == SP_OK)
        status = check_results(r, err);
    if (status == SP_OK)
        status = sp_packing_audit(p, scene.network.threshold, &audit, err);
    if (status == SP_OK) {
        sp_audit_worst(&audit, tolerance, reason, sizeof reason);
        if (*reason)
            status = sp_fail(err, SP_EFAILED, "%s", reason);
    }
    sp_scene_free(&scene);
    return status;
}

sp_status sp_store_check_sample(const sp_store *store, const char *name, double tolerance, sp_error *err) {
    sp_record r = {0};
    sp_packing p = sp_packing_none();
    sp_status status = sp_store_check_bytes(store, name, err);
    if (status == SP_OK)
        status = sp_store_get(store, name, &p, true, &r, err);
    if (status != SP_OK)
        return status;
    status = check_content(&r, &p, tolerance, err);
    if (status == SP_OK)
        sp_store_enter(store, &r.sample);
    if (status != SP_OK && status != SP_ENOMEM)
        status = SP_EFAILED; /* the file can be read, so it is not damaged, and stays */
    sp_packing_free(&p);
    sp_record_free(&r);
    return status;
}

sp_status sp_store_trusted(const sp_store *store, const char *name, sp_sample *out, sp_error *err) {
    if (!sp_store_holds(store, name, "h5"))
        return sp_fail(err, SP_EIO, "no finished sample %s in the store %s", name, store->dir);
    if (sp_store_recall(store, name, false, out))
        return SP_OK;
    sp_status status = sp_store_check_sample(store, name, INFINITY, err);
    return status == SP_OK ? sp_store_sample(store, name, out, err) : status;
}
