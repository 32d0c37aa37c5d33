/* A store: NAME.h5 for each sample, NAME.failed for each that could not be made, NAME.bad for damaged files that a new
 * one took the place of, or that a check put aside; the index manifest.tsv, and .sonopack-lock. Everything else in the
 * folder is left alone. */
#include "base/base.h"
#include "base/file.h"
#include "store/failure.h"
#include "store/folder.h"
#include "store/packing_h5.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <sonopack/study/store.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- names ----------------------------------------------------------------------------------------------------- */

static bool is_name(const char *name) { return strlen(name) == 32 && strspn(name, "0123456789abcdef") == 32; }

void sp_store_path(const sp_store *store, const char *name, const char *ending, char path[SP_PATH_MAX]) {
    if ((size_t)snprintf(path, SP_PATH_MAX, "%s/%.32s.%s", store->dir, name, ending) >= SP_PATH_MAX)
        *path = '\0';
}

bool sp_store_holds(const sp_store *store, const char *name, const char *ending) {
    char path[SP_PATH_MAX];
    sp_store_path(store, name, ending, path);
    return access(path, F_OK) == 0;
}

/* Whatever it is that has the name, a link that leads nowhere included. */
static bool is_taken(const char *path) {
    struct stat info;
    return lstat(path, &info) == 0;
}

bool sp_store_put_aside(const sp_store *store, const char *name, const char *ending) {
    char path[SP_PATH_MAX], bad[SP_PATH_MAX], last[16] = "bad";
    sp_store_path(store, name, ending, path);
    sp_store_path(store, name, last, bad);
    for (int k = 2; is_taken(bad) && k < 1000; k++) {
        snprintf(last, sizeof last, "bad%d", k);
        sp_store_path(store, name, last, bad);
    }
    return rename(path, bad) == 0;
}

/* Where a new file is to come. SP_EIO if what has the name is in the way. */
static sp_status make_room(const sp_store *store, const char *name, const char *ending, sp_error *err) {
    char path[SP_PATH_MAX];
    sp_store_path(store, name, ending, path);
    if (!is_taken(path) || sp_store_put_aside(store, name, ending))
        return SP_OK;
    return sp_fail(err, SP_EIO, "cannot rename %s, which is damaged, to .bad: %s", path, strerror(errno));
}

/* ---- opening --------------------------------------------------------------------------------------------------- */

static sp_status check_folder(const char *dir, sp_error *err) {
    DIR *folder = opendir(dir);
    if (!folder)
        return sp_fail(err, SP_EIO, "cannot open the store %s: %s", dir, strerror(errno));
    closedir(folder);
    return SP_OK;
}

/* Where nothing can be written there may still be samples to make tables of. */
static sp_status prepare_writing(sp_store *store, sp_error *err) {
    sp_name_list list = {0};
    sp_error why = {0};
    if (sp_folder_probe(store->dir, &why) == SP_OK) {
        sp_folder_clean(store->dir);
        sp_manifest_allow_adding(store->manifest);
        sp_manifest_tidy(store->manifest);
        return SP_OK;
    }
    sp_status status = sp_store_names(store, &list, err);
    if (status == SP_OK && list.count == 0)
        status = sp_fail(err, SP_EIO, "%s", why.text);
    sp_free(list.name);
    store->no_writing = true;
    store->why = why;
    return status;
}

sp_status sp_store_open(const char *dir, bool create, sp_store **out, sp_error *err) {
    if (!*dir || strlen(dir) >= SP_PATH_MAX - 64)
        return sp_fail(err, SP_EIO, "cannot open the store '%.100s': its path must have 1..%d characters", dir,
                       SP_PATH_MAX - 65);
    if (create && mkdir(dir, 0777) != 0 && errno != EEXIST)
        return sp_fail(err, SP_EIO, "cannot make the store %s: %s", dir, strerror(errno));
    sp_status status = check_folder(dir, err);
    if (status != SP_OK)
        return status;
    sp_store *store = sp_alloc(1, sizeof *store);
    if (!store)
        return sp_fail_memory(err, sizeof *store);
    memcpy(store->dir, dir, strlen(dir));
    store->claims.fd = -1;
    status = sp_manifest_open(dir, &store->manifest, err);
    if (status == SP_OK && create)
        status = prepare_writing(store, err);
    if (status != SP_OK) {
        sp_store_close(store);
        return status;
    }
    *out = store;
    return SP_OK;
}

void sp_store_close(sp_store *store) {
    sp_manifest_close(store->manifest);
    sp_claims_close(&store->claims);
    sp_free(store);
}

void sp_store_retry(sp_store *store, bool retry) { store->retry = retry; }

/* ---- one file -------------------------------------------------------------------------------------------------- */

sp_status sp_store_get(const sp_store *store, const char *name, sp_packing *packing, bool with_arrays, sp_record *out,
                       sp_error *err) {
    char path[SP_PATH_MAX];
    sp_store_path(store, name, "h5", path);
    sp_record r = {0};
    sp_packing p = sp_packing_none();
    sp_h5 h;
    sp_status status = sp_h5_open(&h, path, err);
    if (status == SP_OK)
        status = sp_record_get(&h, with_arrays, &r, err);
    if (status == SP_OK && strcmp(r.sample.name, name) != 0)
        status = sp_fail(err, SP_EFORMAT, "%s: holds the sample %s, which is not its name", path, r.sample.name);
    if (status == SP_OK && packing)
        status = sp_packing_get(&h, &p, err);
    sp_h5_close(&h);
    if (status != SP_OK) {
        sp_record_free(&r);
        return status;
    }
    *out = r;
    if (packing)
        *packing = p;
    return SP_OK;
}

static sp_status write_file(const sp_store *store, const sp_record *r, const sp_packing *packing, sp_error *err) {
    char path[SP_PATH_MAX];
    sp_store_path(store, r->sample.name, "h5", path);
    sp_h5 h;
    sp_status status = sp_h5_create(&h, path, err);
    if (status == SP_OK)
        status = sp_packing_put(&h, packing, err);
    if (status == SP_OK)
        status = sp_record_put(&h, r, err);
    return sp_h5_finish(&h, status, path, err);
}

/* ---- the sink -------------------------------------------------------------------------------------------------- */

static sp_stored sink_has(void *user, const sp_scene *scene, const char *name) {
    const sp_store *store = user;
    sp_sample sample;
    if (!is_name(name))
        return SP_STORED_NOT;
    if (sp_store_trusted(store, name, &sample, NULL) == SP_OK) {
        const sp_stored stored = sp_sample_stored(scene, &sample);
        return stored == SP_STORED_FAILED && store->retry ? SP_STORED_NOT : stored;
    }
    return !store->retry && sp_store_has_failed(store, name) ? SP_STORED_FAILED : SP_STORED_NOT;
}

static sp_status sink_claim(void *user, const char *name, bool *taken, sp_error *err) {
    sp_store *store = user;
    if (store->no_writing)
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
    if (!is_name(name) || !sp_store_holds(store, name, "h5"))
        return SP_OK;
    sp_record r;
    sp_status status = sp_store_trusted(store, name, sample, NULL);
    if (status == SP_EFORMAT || status == SP_EFAILED)
        return make_room(store, name, "h5", err); /* one to make anew */
    status = sp_store_get(store, name, packing, false, &r, err);
    if (status == SP_EFORMAT)
        return SP_OK; /* a damaged sample is one to make anew */
    if (status != SP_OK)
        return status;
    *sample = r.sample;
    *found = true;
    sp_record_free(&r);
    return SP_OK;
}

/* What could not be made then, and was neither tried nor made now. */
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

/* Adds to `fresh` what only the old record has. Arrays and the scene change hands. */
static void keep_old_parts(sp_record *fresh, sp_record *old) {
    const unsigned missing = old->sample.have & ~fresh->sample.have;
    if (missing & SP_WANT_CTOF)
        fresh->sample.front = old->sample.front;
    if (missing & SP_WANT_STATICS)
        fresh->sample.statics = old->sample.statics;
    if (missing & SP_WANT_MODULI)
        fresh->sample.moduli = old->sample.moduli;
    if (missing & SP_WANT_PROBES)
        memcpy(fresh->sample.probe, old->sample.probe, sizeof fresh->sample.probe);
    if (missing & SP_WANT_PLANES) {
        fresh->sample.planes = old->sample.planes;
        memcpy(fresh->sample.plane, old->sample.plane, sizeof fresh->sample.plane);
        memcpy(fresh->sample.plane_front, old->sample.plane_front, sizeof fresh->sample.plane_front);
    }
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

static sp_status copy_signal(const sp_signal *from, sp_signal *to, sp_error *err) {
    const size_t bytes = (size_t)from->n * sizeof(double);
    sp_signal s = *from;
    s.errors = NULL;
    s.t = sp_alloc((size_t)from->n, sizeof *s.t);
    s.f = sp_alloc((size_t)from->n, sizeof *s.f);
    if (!s.t || !s.f) {
        sp_free(s.t);
        sp_free(s.f);
        return sp_fail_memory(err, 2 * bytes);
    }
    memcpy(s.t, from->t, bytes);
    memcpy(s.f, from->f, bytes);
    *to = s;
    return SP_OK;
}

static sp_status copy_arrays(const sp_sample_arrays *from, sp_sample_arrays *to, sp_error *err) {
    sp_status status = from->signal.n > 0 ? copy_signal(&from->signal, &to->signal, err) : SP_OK;
    if (status != SP_OK || from->modes == 0)
        return status;
    const size_t bytes = (size_t)from->modes * sizeof *from->omega;
    to->omega = sp_alloc(bytes, 1);
    if (!to->omega)
        return sp_fail_memory(err, bytes);
    memcpy(to->omega, from->omega, bytes);
    to->modes = from->modes;
    return SP_OK;
}

/* What is in the store already goes into *fresh and, if the caller brings none, *packing. A damaged file makes room. */
static sp_status merge_old(const sp_store *store, sp_record *fresh, bool need_packing, sp_packing *packing,
                           sp_error *err) {
    const char *name = fresh->sample.name;
    sp_record old = {0};
    if (!sp_store_holds(store, name, "h5")) /* at the most a link that leads nowhere */
        return need_packing ? sp_fail(err, SP_EINVAL, "sample %s: no packing, neither given nor stored", name)
                            : make_room(store, name, "h5", err);
    sp_status status = sp_store_get(store, name, need_packing ? packing : NULL, true, &old, err);
    if (status == SP_OK)
        keep_old_parts(fresh, &old);
    else if (status == SP_EFORMAT && !need_packing)
        status = make_room(store, name, "h5", err);
    sp_record_free(&old);
    return status;
}

static sp_status save_made(const sp_store *store, const sp_scene *scene, const sp_sample *sample,
                           const sp_packing *given, const sp_sample_arrays *arrays, sp_error *err) {
    sp_record fresh = {.sample = *sample};
    sp_packing stored = sp_packing_none();
    sp_status status = SP_OK;
    if (arrays)
        status = copy_arrays(arrays, &fresh.arrays, err);
    if (status == SP_OK && scene && !(fresh.scene = sp_scene_text(scene, NULL)))
        status = sp_fail_memory(err, 1);
    if (status == SP_OK)
        status = merge_old(store, &fresh, given == NULL, &stored, err);
    if (fresh.arrays.modes == 0) /* they were in a file that has gone bad since */
        fresh.sample.have &= ~(unsigned)SP_WANT_SPECTRUM;
    if (fresh.arrays.signal.n == 0)
        fresh.sample.have &= ~(unsigned)SP_WANT_SIGNAL;
    if (status == SP_OK)
        status = write_file(store, &fresh, given ? given : &stored, err);
    if (status == SP_OK) {
        char path[SP_PATH_MAX];
        sp_store_path(store, sample->name, "failed", path);
        if (sp_failure_read(path, sample->name, &(sp_sample){0}, NULL) == SP_OK)
            unlink(path); /* it did not fail for good */
        else
            make_room(store, sample->name, "failed", NULL);
        sp_store_enter(store, &fresh.sample);
    }
    sp_packing_free(&stored);
    sp_record_free(&fresh);
    return status;
}

static sp_status save_failed(const sp_store *store, const sp_sample *sample, sp_error *err) {
    char path[SP_PATH_MAX];
    sp_sample again;
    sp_store_path(store, sample->name, "failed", path);
    sp_status status = SP_OK;
    if (sp_failure_read(path, sample->name, &again, NULL) != SP_OK)
        status = make_room(store, sample->name, "failed", err);
    if (status == SP_OK)
        status = sp_failure_save(path, sample, err);
    if (status == SP_OK && sp_failure_read(path, sample->name, &again, NULL) == SP_OK)
        sp_store_enter(store, &again);
    return status;
}

/* Between reading the old parts and writing the new file no other process may write. */
static sp_status sink_save(void *user, const sp_scene *scene, const sp_sample *sample, const sp_packing *packing,
                           const sp_sample_arrays *arrays, sp_error *err) {
    sp_store *store = user;
    if (!is_name(sample->name))
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

/* ---- all samples ----------------------------------------------------------------------------------------------- */

static sp_status add_name(sp_name_list *list, const char *name, sp_error *err) {
    if (list->count == list->capacity) {
        size_t capacity = list->capacity ? 2 * (size_t)list->capacity : 256;
        char(*larger)[SP_NAME_MAX] = sp_alloc(capacity, sizeof *larger);
        if (!larger)
            return sp_fail_memory(err, capacity * sizeof *larger);
        if (list->count > 0)
            memcpy(larger, list->name, (size_t)list->count * sizeof *larger);
        sp_free(list->name);
        list->name = larger;
        list->capacity = (int64_t)capacity;
    }
    memcpy(list->name[list->count++], name, SP_NAME_MAX);
    return SP_OK;
}

static int compare_names(const void *a, const void *b) { return strcmp(a, b); }

sp_status sp_store_names(const sp_store *store, sp_name_list *list, sp_error *err) {
    DIR *folder = opendir(store->dir);
    if (!folder)
        return sp_fail(err, SP_EIO, "cannot read the store %s: %s", store->dir, strerror(errno));
    sp_status status = SP_OK;
    for (struct dirent *entry; status == SP_OK && (entry = readdir(folder));) {
        char name[SP_NAME_MAX];
        snprintf(name, sizeof name, "%.32s", entry->d_name);
        if (!is_name(name))
            continue;
        const char *ending = entry->d_name + 32;
        if (strcmp(ending, ".h5") == 0 || strcmp(ending, ".failed") == 0)
            status = add_name(list, name, err);
    }
    closedir(folder);
    if (status != SP_OK || list->count == 0)
        return status;
    qsort(list->name, (size_t)list->count, sizeof *list->name, compare_names);
    int64_t kept = 1;
    for (int64_t k = 1; k < list->count; k++)
        if (strcmp(list->name[k], list->name[kept - 1]) != 0)
            memmove(list->name[kept++], list->name[k], SP_NAME_MAX);
    list->count = kept;
    return SP_OK;
}

sp_status sp_store_read(sp_store *store, const char *name, sp_packing *packing, sp_sample *sample,
                        sp_sample_arrays *arrays, sp_error *err) {
    if (!is_name(name))
        return sp_fail(err, SP_EINVAL, "sample name '%.40s': must be 32 hexadecimal digits", name);
    if (!sp_store_holds(store, name, "h5"))
        return sp_fail(err, SP_EIO, "no finished sample %s in the store %s%s", name, store->dir,
                       sp_store_holds(store, name, "failed") ? ": it failed" : "");
    sp_record r;
    sp_status status = sp_store_get(store, name, packing, arrays != NULL, &r, err);
    if (status != SP_OK)
        return status;
    if (sample)
        *sample = r.sample;
    if (arrays) {
        *arrays = r.arrays;
        r.arrays = sp_sample_arrays_none();
    }
    sp_record_free(&r);
    return SP_OK;
}

sp_status sp_store_samples(sp_store *store, int64_t *n, sp_sample **samples, int64_t *bad, sp_error *err) {
    sp_name_list list = {0};
    sp_sample *all = NULL;
    int64_t good = 0, damaged = 0;
    sp_error first = {0};
    sp_status status = sp_store_names(store, &list, err);
    if (status == SP_OK && !(all = sp_alloc((size_t)list.count, sizeof *all)))
        status = sp_fail_memory(err, (size_t)list.count * sizeof *all);
    for (int64_t k = 0; status == SP_OK && k < list.count; k++) {
        sp_error reason = {0};
        sp_status one = sp_store_sample(store, list.name[k], &all[good], &reason);
        if (one == SP_OK) {
            good++;
        } else if (one == SP_ENOMEM) {
            status = sp_fail(err, one, "%s", reason.text);
        } else if (damaged++ == 0) {
            first = reason;
        }
    }
    sp_free(list.name);
    if (status != SP_OK) {
        sp_free(all);
        return status;
    }
    if (damaged > 0)
        sp_fail(err, SP_OK, "%s", first.text); /* why the first of them is bad */
    *n = good;
    *samples = all;
    *bad = damaged;
    return SP_OK;
}
