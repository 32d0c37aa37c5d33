/* Looks at every file of a store, and puts aside what is damaged. */
#include "base/base.h"
#include "store/failure.h"
#include "store/folder.h"

#include <errno.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

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

/* Averages over nothing, and places without a front, are not numbers by right; what a front or a solve gave is one. */
static sp_status check_results(const sp_record *r, sp_error *err) {
    const sp_sample *s = &r->sample;
    const sp_front *f = &s->front;
    if (s->have & SP_WANT_CTOF && !(isfinite(f->t10) && isfinite(f->t_peak) && isfinite(f->amplitude)))
        return sp_fail(err, SP_EFAILED, "/results/front: t10 = %g, t_peak = %g, amplitude = %g: must be finite", f->t10,
                       f->t_peak, f->amplitude);
    if (s->have & SP_WANT_STATICS && any_infinite(&s->statics.phi2, sizeof s->statics))
        return sp_fail(err, SP_EFAILED, "/results/statics: an infinite number");
    const double along = s->dim == 3 ? s->moduli.c33 : s->moduli.c22; /* from wall to wall */
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

/* The sample as its packing and its scene have it. A scene of a version with other keys says nothing. */
static sp_status check_origin(const sp_record *r, const sp_packing *p, sp_scene *scene, sp_error *err) {
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
    sp_status status = check_origin(r, p, &scene, err);
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
        status = SP_EFAILED; /* it was read: whatever is wrong with it, it stays */
    sp_packing_free(&p);
    sp_record_free(&r);
    return status;
}

/* Of a sound record *err gets why the sample failed. */
static sp_status check_record(const sp_store *store, const char *name, sp_error *err) {
    char path[SP_PATH_MAX];
    sp_sample s;
    sp_store_path(store, name, "failed", path);
    sp_status status = sp_failure_read(path, name, &s, err);
    if (status == SP_OK)
        sp_store_enter(store, &s);
    if (status == SP_OK)
        sp_fail(err, SP_OK, "%s", s.reason);
    return status;
}

static sp_status check_file(const sp_store *store, const char *name, bool record, double tolerance, sp_error *err) {
    return record ? check_record(store, name, err) : sp_store_check_sample(store, name, tolerance, err);
}

/* Under the lock, and only if it is still damaged: another process may have made it anew, or be about to. */
static bool put_aside(sp_store *store, const char *name, bool record) {
    sp_error again = {0};
    if (sp_claim_take(&store->claims, store->dir, name, false) == SP_CLAIM_OTHERS)
        return false;
    bool aside = check_file(store, name, record, INFINITY, &again) == SP_EFORMAT &&
                 sp_store_put_aside(store, name, record ? "failed" : "h5");
    sp_claim_release(&store->claims, name);
    return aside;
}

/* One file; SP_EINTERRUPTED when the caller has seen enough. */
static sp_status look(sp_store *store, const sp_store_check *check, sp_store_finding *f, const char *name,
                      sp_error *err) {
    char file[SP_NAME_MAX + 8];
    sp_error reason = {0};
    snprintf(file, sizeof file, "%s.%s", name, f->record ? "failed" : "h5");
    sp_status status = check_file(store, name, f->record, check->tolerance, &reason);
    if (status == SP_ENOMEM)
        return sp_fail(err, status, "%s", reason.text);
    f->file = file;
    f->reason = reason.text;
    f->verdict = status == SP_OK ? SP_SOUND : status == SP_EFORMAT ? SP_DAMAGED : SP_FAULTY;
    f->aside = f->verdict == SP_DAMAGED && put_aside(store, name, f->record);
    if (!check->found(f, check->user))
        return sp_fail(err, SP_EINTERRUPTED, "stopped with %lld of %lld samples looked at", (long long)f->done,
                       (long long)f->names);
    return SP_OK;
}

sp_status sp_store_verify(sp_store *store, const sp_store_check *check, sp_error *err) {
    sp_name_list all = {0};
    sp_status status = SP_OK;
    if (access(store->dir, W_OK) == 0)
        sp_manifest_allow_adding(store->manifest);
    if (check->names < 0)
        status = sp_store_names(store, &all, err);
    const int64_t names = check->names < 0 ? all.count : check->names;
    const char(*name)[SP_NAME_MAX] = check->names < 0 ? (const char(*)[SP_NAME_MAX])all.name : check->name;
    for (int64_t k = 0; k < names && status == SP_OK; k++)
        for (int record = 0; record < 2 && status == SP_OK; record++) {
            sp_store_finding f = {.record = record, .done = k + 1, .names = names};
            if (sp_store_holds(store, name[k], record ? "failed" : "h5"))
                status = look(store, check, &f, name[k], err);
        }
    sp_manifest_tidy(store->manifest);
    sp_free(all.name);
    return status;
}
