/* A store: NAME.h5 for each sample, NAME.failed for each sample that could not be made, and NAME.bad for files that
 * were damaged; the index manifest.tsv, and .sonopack-lock. Other files in the folder are left alone. */
#include "base/base.h"
#include "base/file.h"
#include "store/folder.h"

#include <dirent.h>
#include <errno.h>
#include <sonopack/study/store.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

/* ---- opening --------------------------------------------------------------------------------------------------- */

/* A folder that cannot be written to may still have samples for tables. */
static sp_status prepare_writing(sp_store *store, sp_error *err) {
    sp_name_list list = {0};
    sp_error why = {0};
    if (sp_folder_probe(store->dir, &why) == SP_OK) {
        sp_folder_clean(store->dir);
        return SP_OK;
    }
    sp_status status = sp_store_names(store, &list, err);
    if (status == SP_OK && list.count == 0)
        status = sp_fail(err, SP_EIO, "%s", why.text);
    sp_free(list.name);
    store->read_only = true;
    store->why = why;
    return status;
}

sp_status sp_store_open(const char *dir, bool create, sp_store **out, sp_error *err) {
    if (!*dir || strlen(dir) >= SP_PATH_MAX - 64)
        return sp_fail(err, SP_EIO, "cannot open the store '%.100s': its path must have 1..%d characters", dir,
                       SP_PATH_MAX - 65);
    if (create && mkdir(dir, 0777) != 0 && errno != EEXIST)
        return sp_fail(err, SP_EIO, "cannot make the store %s: %s", dir, strerror(errno));
    DIR *folder = opendir(dir);
    if (!folder)
        return sp_fail(err, SP_EIO, "cannot open the store %s: %s", dir, strerror(errno));
    closedir(folder);
    sp_store *store = sp_alloc(1, sizeof *store);
    if (!store)
        return sp_fail_memory(err, sizeof *store);
    memcpy(store->dir, dir, strlen(dir));
    store->claims.fd = -1;
    sp_status status = create ? prepare_writing(store, err) : SP_OK;
    if (status == SP_OK)
        status = sp_manifest_open(dir, create && !store->read_only, &store->manifest, err);
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

/* ---- looking up ----------------------------------------------------------------------------------------------------
 */

bool sp_store_stat(const sp_store *store, const char *name, const char *ending, struct stat *info) {
    char path[SP_PATH_MAX];
    sp_store_path(store, name, ending, path);
    *info = (struct stat){0};
    return stat(path, info) == 0;
}

void sp_store_enter(const sp_store *store, const struct stat *info, const sp_sample *sample) {
    if (S_ISREG(info->st_mode))
        sp_manifest_add(store->manifest, info, sample);
}

static sp_status read_failure(const sp_store *store, const char *name, sp_sample *out, sp_error *err) {
    char path[SP_PATH_MAX];
    sp_store_path(store, name, "failed", path);
    return sp_failure_read(path, name, out, err);
}

/* The results of a sample, or else the record of its failure; from the manifest where that is up to date. */
static sp_status find_sample(const sp_store *store, const char *name, sp_sample *out, sp_error *err) {
    struct stat info;
    sp_record r;
    /* if the file system does not answer, reading the file will tell */
    const bool made = sp_store_stat(store, name, "h5", &info) || errno != ENOENT;
    if (!made && !sp_store_stat(store, name, "failed", &info))
        return sp_fail(err, SP_EIO, "no sample %s in the store %s", name, store->dir);
    if (sp_manifest_find(store->manifest, name, !made, &info, out))
        return SP_OK;
    sp_status status = made ? sp_store_get(store, name, NULL, false, &r, err) : read_failure(store, name, out, err);
    if (status == SP_OK && made) {
        *out = r.sample;
        sp_record_free(&r);
    }
    return status;
}

sp_status sp_store_finished(const sp_store *store, const char *name, sp_sample *out, sp_error *err) {
    struct stat info;
    sp_record r;
    sp_packing p;
    if (!sp_store_holds(store, name, "h5"))
        return sp_fail(err, SP_EIO, "no finished sample %s in the store %s", name, store->dir);
    if (sp_store_stat(store, name, "h5", &info) && sp_manifest_find(store->manifest, name, false, &info, out))
        return SP_OK;
    sp_status status = sp_store_get(store, name, &p, true, &r, err);
    if (status != SP_OK)
        return status;
    *out = r.sample;
    sp_store_enter(store, &info, out);
    sp_record_free(&r);
    sp_packing_free(&p);
    return SP_OK;
}

bool sp_store_has_failed(const sp_store *store, const char *name) {
    struct stat info;
    sp_sample sample;
    if (!sp_store_stat(store, name, "failed", &info))
        return false;
    if (sp_manifest_find(store->manifest, name, true, &info, &sample))
        return true;
    if (read_failure(store, name, &sample, NULL) != SP_OK)
        return false;
    sp_store_enter(store, &info, &sample);
    return true;
}

/* ---- reading --------------------------------------------------------------------------------------------------- */

sp_status sp_store_read(sp_store *store, const char *name, sp_packing *packing, sp_sample *sample,
                        sp_sample_arrays *arrays, sp_error *err) {
    if (!sp_store_is_name(name))
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
    sp_manifest_refresh(store->manifest);
    sp_status status = sp_store_names(store, &list, err);
    if (status == SP_OK && !(all = sp_alloc((size_t)list.count, sizeof *all)))
        status = sp_fail_memory(err, (size_t)list.count * sizeof *all);
    for (int64_t k = 0; status == SP_OK && k < list.count; k++) {
        sp_error reason = {0};
        sp_status one = find_sample(store, list.name[k], &all[good], &reason);
        if (one == SP_OK) {
            good++;
        } else if (one == SP_ENOMEM || (one == SP_EIO && sp_store_holds(store, list.name[k], "h5"))) {
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
        sp_fail(err, SP_OK, "%s", first.text); /* the reason of the first */
    *n = good;
    *samples = all;
    *bad = damaged;
    return SP_OK;
}
