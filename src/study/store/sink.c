/* Makes a store the sink of a study: loads and saves its samples. */
#include "base/base.h"
#include "store/folder.h"

#include <sonopack/study/store.h>
#include <stddef.h>
#include <string.h>
#include <unistd.h>

/* ---- reading ------------------------------------------------------------------------------------------------- */

static sp_stored sink_has(void *user, const sp_scene *scene, const char *name) {
    const sp_store *store = user;
    sp_sample sample;
    if (!sp_store_is_name(name))
        return SP_STORED_NOT;
    if (sp_store_finished(store, name, &sample, NULL) == SP_OK) {
        const sp_stored stored = sp_sample_stored(scene, &sample);
        return stored == SP_STORED_FAILED && store->retry ? SP_STORED_NOT : stored;
    }
    return !store->retry && sp_store_has_failed(store, name) ? SP_STORED_FAILED : SP_STORED_NOT;
}

static sp_status sink_claim(void *user, const char *name, bool *taken, sp_error *err) {
    sp_store *store = user;
    if (store->read_only)
        return sp_fail(err, SP_EIO, "%s", store->why.text);
    *taken = sp_claim_take(&store->claims, store->dir, name, false) != SP_CLAIM_OTHERS;
    return SP_OK;
}

static void sink_release(void *user, const char *name) {
    sp_store *store = user;
    sp_claim_release(&store->claims, name);
}

static sp_status sink_load(void *user, const char *name, sp_packing *packing, sp_sample *sample, bool *found,
                           sp_error *err) {
    const sp_store *store = user;
    *found = false;
    if (!sp_store_is_name(name) || !sp_store_holds(store, name, "h5"))
        return SP_OK;
    struct stat info;
    sp_record r;
    sp_store_stat(store, name, "h5", &info);
    sp_status status = sp_store_get(store, name, packing, true, &r, err);
    if (status == SP_EFORMAT)
        return sp_store_make_way(store, name, "h5", err); /* it is to be made again */
    if (status != SP_OK)
        return status;
    *sample = r.sample;
    *found = true;
    sp_store_enter(store, &info, sample); /* the manifest may have told something else */
    sp_record_free(&r);
    return SP_OK;
}

/* Keeps the failures of parts that were neither made nor tried again. */
static void keep_lacks(sp_sample *fresh, const sp_sample *old) {
    const unsigned described = SP_WANT_SIGNAL | SP_WANT_PLANES, kept = old->lacks & ~fresh->have & ~fresh->lacks;
    if (kept == 0)
        return;
    if (fresh->lacks == 0)
        memcpy(fresh->reason, old->reason, sizeof fresh->reason);
    if (!(fresh->lacks & described))
        fresh->lacks_signal = old->lacks_signal;
    fresh->lacks |= kept;
}

/* Adds the parts that only the old record has to `fresh`, which becomes the owner of arrays and scene. */
static void keep_old_parts(sp_record *fresh, sp_record *old) {
    static const struct {
        unsigned want;
        size_t offset, size; /* in sp_sample */
    } parts[] = {
        {SP_WANT_CTOF, offsetof(sp_sample, front), sizeof(sp_front)},
        {SP_WANT_STATICS, offsetof(sp_sample, statics), sizeof(sp_statics)},
        {SP_WANT_MODULI, offsetof(sp_sample, moduli), sizeof(sp_moduli)},
        {SP_WANT_PROBES, offsetof(sp_sample, probe), sizeof fresh->sample.probe},
        {SP_WANT_PLANES, offsetof(sp_sample, planes), offsetof(sp_sample, signal) - offsetof(sp_sample, planes)}};
    const unsigned missing = old->sample.have & ~fresh->sample.have;
    for (size_t k = 0; k < sizeof parts / sizeof *parts; k++)
        if (missing & parts[k].want)
            memcpy((char *)&fresh->sample + parts[k].offset, (const char *)&old->sample + parts[k].offset,
                   parts[k].size);
    fresh->sample.have |= missing;
    keep_lacks(&fresh->sample, &old->sample);
    if (fresh->arrays.signal.n == 0) {
        sp_signal none = fresh->arrays.signal;
        fresh->arrays.signal = old->arrays.signal;
        fresh->sample.signal = old->sample.signal;
        old->arrays.signal = none;
    }
    if (fresh->arrays.modes == 0) {
        fresh->arrays.modes = old->arrays.modes;
        fresh->arrays.omega = old->arrays.omega;
        fresh->sample.spectrum = old->sample.spectrum;
        old->arrays.modes = 0;
        old->arrays.omega = NULL;
    }
    if (!fresh->scene) {
        fresh->scene = old->scene;
        old->scene = NULL;
    }
}

/* Lets the record have the arrays of the caller, as far as there are any, or gives them back. */
static void lend_arrays(sp_record *r, const sp_sample_arrays *arrays, bool lend) {
    if (arrays && arrays->signal.n > 0)
        r->arrays.signal = lend ? arrays->signal : sp_signal_none();
    if (arrays && arrays->modes > 0) {
        r->arrays.modes = lend ? arrays->modes : 0;
        r->arrays.omega = lend ? arrays->omega : NULL;
    }
}

/* Adds what is stored already to *fresh; also the packing, if needed. A damaged file is renamed. */
static sp_status merge_old(const sp_store *store, sp_record *fresh, bool need_packing, sp_packing *packing,
                           sp_error *err) {
    const char *name = fresh->sample.name;
    sp_record old = {0};
    if (!sp_store_holds(store, name, "h5")) /* or a link that leads nowhere */
        return need_packing ? sp_fail(err, SP_EINVAL, "sample %s: no packing, neither given nor stored", name)
                            : sp_store_make_way(store, name, "h5", err);
    sp_status status = sp_store_get(store, name, need_packing ? packing : NULL, true, &old, err);
    if (status == SP_OK)
        keep_old_parts(fresh, &old);
    else if (status == SP_EFORMAT && !need_packing)
        status = sp_store_make_way(store, name, "h5", err);
    sp_record_free(&old);
    return status;
}

static sp_status save_made(const sp_store *store, const sp_scene *scene, const sp_sample *sample,
                           const sp_packing *given, const sp_sample_arrays *arrays, sp_error *err) {
    sp_record fresh = {.sample = *sample};
    sp_packing stored = sp_packing_none();
    sp_status status = SP_OK;
    lend_arrays(&fresh, arrays, true);
    if (scene && !(fresh.scene = sp_scene_text(scene, NULL)))
        status = sp_fail_memory(err, 1);
    if (status == SP_OK)
        status = merge_old(store, &fresh, given == NULL, &stored, err);
    if (fresh.arrays.modes == 0) /* they were in a file that is damaged now */
        fresh.sample.have &= ~(unsigned)SP_WANT_SPECTRUM;
    if (fresh.arrays.signal.n == 0)
        fresh.sample.have &= ~(unsigned)SP_WANT_SIGNAL;
    if (status == SP_OK)
        status = sp_store_put(store, &fresh, given ? given : &stored, err);
    if (status == SP_OK) {
        struct stat info;
        char path[SP_PATH_MAX];
        sp_store_path(store, sample->name, "failed", path);
        if (sp_failure_read(path, sample->name, &(sp_sample){0}, NULL) == SP_OK)
            unlink(path); /* this time it did not fail */
        else
            sp_store_make_way(store, sample->name, "failed", NULL);
        if (sp_store_stat(store, sample->name, "h5", &info))
            sp_store_enter(store, &info, &fresh.sample);
    }
    sp_packing_free(&stored);
    lend_arrays(&fresh, arrays, false);
    sp_record_free(&fresh);
    return status;
}

static sp_status save_failed(const sp_store *store, const sp_sample *sample, sp_error *err) {
    struct stat info;
    char path[SP_PATH_MAX];
    sp_sample again;
    sp_store_path(store, sample->name, "failed", path);
    sp_status status = SP_OK;
    if (sp_failure_read(path, sample->name, &again, NULL) != SP_OK)
        status = sp_store_make_way(store, sample->name, "failed", err);
    if (status == SP_OK)
        status = sp_failure_save(path, sample, err);
    if (status == SP_OK && sp_store_stat(store, sample->name, "failed", &info) &&
        sp_failure_read(path, sample->name, &again, NULL) == SP_OK)
        sp_store_enter(store, &info, &again);
    return status;
}

/* Holds the claim from reading the old parts to writing the new file, so that no other process writes in between. */
static sp_status sink_save(void *user, const sp_scene *scene, const sp_sample *sample, const sp_packing *packing,
                           const sp_sample_arrays *arrays, sp_error *err) {
    sp_store *store = user;
    if (!sp_store_is_name(sample->name))
        return sp_fail(err, SP_EINVAL, "sample name '%.40s': must be 32 hexadecimal digits", sample->name);
    if (sample->failed)
        return save_failed(store, sample, err);
    sp_status status = packing ? sp_packing_check(packing, err) : SP_OK;
    if (status != SP_OK)
        return status;
    const bool ours = sp_claim_holds(&store->claims, sample->name);
    if (!ours)
        sp_claim_take(&store->claims, store->dir, sample->name, true);
    status = save_made(store, scene, sample, packing, arrays, err);
    if (!ours)
        sp_claim_release(&store->claims, sample->name);
    return status;
}

sp_study_sink sp_store_sink(sp_store *store) {
    return (sp_study_sink){.user = store,
                           .has = sink_has,
                           .claim = sink_claim,
                           .release = sink_release,
                           .load = sink_load,
                           .save = sink_save};
}
