/* Looks up samples: in the manifest where it is up to date, and in their files otherwise. */
#include "base/base.h"
#include "store/folder.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

/* A file of the store, and its status. */
typedef struct place {
    char path[SP_PATH_MAX];
    struct stat info;
} place;

static bool find_file(const sp_store *store, const char *name, const char *ending, place *out) {
    sp_store_path(store, name, ending, out->path);
    out->info = (struct stat){0};
    return stat(out->path, &out->info) == 0;
}

void sp_store_enter(const sp_store *store, const sp_sample *sample) {
    place file;
    if (find_file(store, sample->name, sample->failed ? "failed" : "h5", &file) && S_ISREG(file.info.st_mode))
        sp_manifest_add(store->manifest, &file.info, sample);
}

sp_status sp_store_sample(const sp_store *store, const char *name, sp_sample *out, sp_error *err) {
    place file;
    sp_record r;
    /* if the file system does not answer, reading the file will tell */
    const bool made = find_file(store, name, "h5", &file) || errno != ENOENT;
    if (!made && !find_file(store, name, "failed", &file))
        return sp_fail(err, SP_EIO, "no sample %s in the store %s", name, store->dir);
    if (sp_manifest_find(store->manifest, name, !made, &file.info, out))
        return SP_OK;
    sp_status status =
        made ? sp_store_get(store, name, NULL, false, &r, err) : sp_failure_read(file.path, name, out, err);
    if (status == SP_OK && made) {
        *out = r.sample;
        sp_record_free(&r);
    }
    return status;
}

sp_status sp_store_finished(const sp_store *store, const char *name, sp_sample *out, sp_error *err) {
    place file;
    sp_record r;
    sp_packing p;
    if (!sp_store_holds(store, name, "h5"))
        return sp_fail(err, SP_EIO, "no finished sample %s in the store %s", name, store->dir);
    if (find_file(store, name, "h5", &file) && sp_manifest_find(store->manifest, name, false, &file.info, out))
        return SP_OK;
    sp_status status = sp_store_get(store, name, &p, true, &r, err);
    if (status != SP_OK)
        return status;
    *out = r.sample;
    sp_store_enter(store, out);
    sp_record_free(&r);
    sp_packing_free(&p);
    return SP_OK;
}

bool sp_store_has_failed(const sp_store *store, const char *name) {
    place file;
    sp_sample sample;
    if (!find_file(store, name, "failed", &file))
        return false;
    if (sp_manifest_find(store->manifest, name, true, &file.info, &sample))
        return true;
    if (sp_failure_read(file.path, name, &sample, NULL) != SP_OK)
        return false;
    sp_store_enter(store, &sample);
    return true;
}
