/* Checks every file of a store, and renames those that are damaged. */
#include "base/base.h"
#include "base/pool.h"
#include "store/folder.h"

#include <stdio.h>
#include <unistd.h>

/* Checks the record of a failure. If it is sound, *err says why the sample failed. */
static sp_status check_record(const sp_store *store, const char *name, const struct stat *info, sp_error *err) {
    char path[SP_PATH_MAX];
    sp_sample s;
    sp_store_path(store, name, "failed", path);
    sp_status status = sp_failure_read(path, name, &s, err);
    if (status == SP_OK) {
        sp_store_enter(store, info, &s);
        sp_fail(err, SP_OK, "%s", s.reason);
    }
    return status;
}

/* A file that is being checked. */
typedef struct task {
    const char *name;
    bool record;
    struct stat info; /* from before it was read */
    int64_t done;
    sp_record r;
    sp_packing p;
    sp_status status;
    sp_error reason;
} task;

static void free_task(task *t) {
    sp_record_free(&t->r);
    sp_packing_free(&t->p);
}

static void read_file(const sp_store *store, task *t) {
    sp_store_stat(store, t->name, t->record ? "failed" : "h5", &t->info);
    t->status = t->record ? check_record(store, t->name, &t->info, &t->reason)
                          : sp_store_get(store, t->name, &t->p, true, &t->r, &t->reason);
}

/* Renames a damaged file. With the claim, and only if the file is still damaged: another process may be replacing it.
 */
static bool put_aside(sp_store *store, const task *of) {
    task again = {.name = of->name, .record = of->record, .p = sp_packing_none()};
    if (sp_claim_take(&store->claims, store->dir, of->name, false) == SP_CLAIM_OTHERS)
        return false;
    read_file(store, &again);
    bool aside = again.status == SP_EFORMAT && sp_store_put_aside(store, of->name, of->record ? "failed" : "h5");
    sp_claim_release(&store->claims, of->name);
    free_task(&again);
    return aside;
}

/* Reports one file. SP_EINTERRUPTED if the caller stops the check. */
static sp_status report(sp_store *store, const sp_store_check *check, const task *t, int64_t names, sp_error *err) {
    char file[SP_NAME_MAX + 8];
    if (t->status == SP_ENOMEM)
        return sp_fail(err, t->status, "%s", t->reason.text);
    snprintf(file, sizeof file, "%s.%s", t->name, t->record ? "failed" : "h5");
    sp_store_finding f = {.record = t->record,
                          .done = t->done,
                          .names = names,
                          .file = file,
                          .reason = t->reason.text,
                          .field = t->reason.key};
    f.verdict = t->status == SP_OK ? SP_SOUND : t->status == SP_EFORMAT ? SP_DAMAGED : SP_FAULTY;
    f.aside = f.verdict == SP_DAMAGED && put_aside(store, t);
    if (!check->found(&f, check->user))
        return sp_fail(err, SP_EINTERRUPTED, "stopped with %lld of %lld samples looked at", (long long)f.done,
                       (long long)f.names);
    return SP_OK;
}

/* Files that are checked together: one thread reads them, and each computes its own again. */
typedef struct batch {
    sp_store *store;
    const sp_store_check *check;
    sp_pool *pool;
    int64_t names;
    int count, most;
    task *task;
} batch;

/* A file that can be read is not damaged, and stays. */
static void recompute(const batch *b, task *t) {
    char path[SP_PATH_MAX];
    sp_store_path(b->store, t->name, "h5", path);
    t->status = sp_record_recompute(path, &t->r, &t->p, b->check->tolerance, &t->reason);
    if (t->status != SP_OK && t->status != SP_ENOMEM)
        t->status = SP_EFAILED;
}

static void compute_part(void *data, int part, int parts) {
    batch *b = data;
    for (int k = part; k < b->count; k += parts)
        if (b->task[k].status == SP_OK && !b->task[k].record)
            recompute(b, &b->task[k]);
}

static sp_status finish_batch(batch *b, sp_error *err) {
    sp_status status = SP_OK;
    sp_pool_run(b->pool, compute_part, b);
    for (int k = 0; k < b->count; k++) {
        if (b->task[k].status == SP_OK && !b->task[k].record)
            sp_store_enter(b->store, &b->task[k].info, &b->task[k].r.sample);
        if (status == SP_OK)
            status = report(b->store, b->check, &b->task[k], b->names, err);
        free_task(&b->task[k]);
    }
    b->count = 0;
    return status;
}

static sp_status check_names(batch *b, const char (*name)[SP_NAME_MAX], sp_error *err) {
    sp_status status = SP_OK;
    for (int64_t k = 0; k < b->names && status == SP_OK; k++)
        for (int record = 0; record < 2 && status == SP_OK; record++) {
            if (!sp_store_holds(b->store, name[k], record ? "failed" : "h5"))
                continue;
            task *t = &b->task[b->count++];
            *t = (task){.name = name[k], .record = record, .done = k + 1, .p = sp_packing_none()};
            read_file(b->store, t);
            if (b->count == b->most)
                status = finish_batch(b, err);
        }
    return status == SP_OK ? finish_batch(b, err) : status;
}

sp_status sp_store_verify(sp_store *store, const sp_store_check *check, sp_error *err) {
    sp_name_list all = {0};
    batch b = {.store = store, .check = check, .most = check->jobs > 1 ? check->jobs : 1};
    sp_status status = sp_pool_make(b.most, &b.pool, err);
    if (status == SP_OK && !(b.task = sp_alloc((size_t)b.most, sizeof *b.task)))
        status = sp_fail_memory(err, (size_t)b.most * sizeof *b.task);
    sp_manifest *adding;
    if (access(store->dir, W_OK) == 0 && sp_manifest_open(store->dir, true, &adding, NULL) == SP_OK) {
        sp_manifest_close(store->manifest);
        store->manifest = adding;
    }
    if (status == SP_OK && check->names < 0)
        status = sp_store_names(store, &all, err);
    b.names = check->names < 0 ? all.count : check->names;
    if (status == SP_OK)
        status = check_names(&b, check->names < 0 ? (const char(*)[SP_NAME_MAX])all.name : check->name, err);
    sp_pool_free(b.pool);
    sp_free(b.task);
    sp_free(all.name);
    return status;
}
