/* Checks every file of a store, and renames those that are damaged. */
#include "base/base.h"
#include "store/failure.h"
#include "store/folder.h"

#include <math.h>
#include <stdio.h>
#include <unistd.h>

/* Checks the record of a failure. If it is sound, *err says why the sample failed. */
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

/* Renames a damaged file. With the claim, and only if the file is still damaged: another process may be replacing it.
 */
static bool put_aside(sp_store *store, const char *name, bool record) {
    sp_error again = {0};
    if (sp_claim_take(&store->claims, store->dir, name, false) == SP_CLAIM_OTHERS)
        return false;
    bool aside = check_file(store, name, record, INFINITY, &again) == SP_EFORMAT &&
                 sp_store_put_aside(store, name, record ? "failed" : "h5");
    sp_claim_release(&store->claims, name);
    return aside;
}

/* Checks one file and reports the finding. SP_EINTERRUPTED if the caller stops the check. */
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
