/* Paths of a store, reading and writing one sample, and the names of all samples. */
#include "base/base.h"
#include "store/folder.h"
#include "store/packing_h5.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- names ----------------------------------------------------------------------------------------------------- */

bool sp_store_is_name(const char *name) { return strlen(name) == 32 && strspn(name, "0123456789abcdef") == 32; }

void sp_store_path(const sp_store *store, const char *name, const char *ending, char path[SP_PATH_MAX]) {
    if ((size_t)snprintf(path, SP_PATH_MAX, "%s/%.32s.%s", store->dir, name, ending) >= SP_PATH_MAX)
        *path = '\0';
}

bool sp_store_holds(const sp_store *store, const char *name, const char *ending) {
    char path[SP_PATH_MAX];
    sp_store_path(store, name, ending, path);
    if (access(path, F_OK) == 0)
        return true;
    /* if the file system does not answer, reading the file will tell */
    return errno != ENOENT && errno != ENOTDIR && errno != ELOOP && errno != EACCES && errno != ENAMETOOLONG;
}

/* Whether anything has this path, even a link that leads nowhere. */
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

sp_status sp_store_make_way(const sp_store *store, const char *name, const char *ending, sp_error *err) {
    char path[SP_PATH_MAX];
    sp_store_path(store, name, ending, path);
    if (!is_taken(path) || sp_store_put_aside(store, name, ending))
        return SP_OK;
    return sp_fail(err, SP_EIO, "cannot rename %s, which is damaged, to .bad: %s", path, strerror(errno));
}

/* ---- one file -------------------------------------------------------------------------------------------------- */

sp_status sp_store_get(const sp_store *store, const char *name, sp_packing *packing, bool with_arrays, sp_record *out,
                       sp_error *err) {
    char path[SP_PATH_MAX];
    sp_store_path(store, name, "h5", path);
    sp_record r = {0};
    sp_packing p = sp_packing_none();
    sp_h5 h;
    int64_t format;
    if (sp_h5_open(&h, path, err) == SP_OK && sp_packing_get_format(&h, &format) == SP_OK &&
        sp_record_get(&h, with_arrays, &r) == SP_OK && strcmp(r.sample.name, name) != 0)
        sp_h5_fail(&h, SP_EFORMAT, "holds the sample %s, which is not its name", r.sample.name);
    if (h.status == SP_OK && packing)
        sp_packing_get(&h, &p);
    const sp_status status = sp_h5_close(&h);
    if (status != SP_OK) {
        sp_record_free(&r);
        return status;
    }
    *out = r;
    if (packing)
        *packing = p;
    return SP_OK;
}

sp_status sp_store_put(const sp_store *store, const sp_record *r, const sp_packing *packing, sp_error *err) {
    char path[SP_PATH_MAX];
    sp_store_path(store, r->sample.name, "h5", path);
    sp_h5 h;
    sp_h5_create(&h, path, err);
    sp_packing_put(&h, packing);
    sp_record_put(&h, r);
    return sp_h5_close(&h);
}

/* ---- all names ------------------------------------------------------------------------------------------------- */

static sp_status add_name(sp_name_list *list, const char *name, sp_error *err) {
    char(*grown)[SP_NAME_MAX] = sp_grow(list->name, (size_t)list->count + 1, &list->capacity, sizeof *grown);
    if (!grown)
        return sp_fail_memory(err, (size_t)list->count * sizeof *grown);
    list->name = grown;
    memcpy(list->name[list->count++], name, SP_NAME_MAX);
    return SP_OK;
}

static int compare_names(const void *a, const void *b) { return strcmp(a, b); }

sp_status sp_store_names(const sp_store *store, sp_name_list *list, sp_error *err) {
    DIR *folder = opendir(store->dir);
    if (!folder)
        return sp_fail(err, SP_EIO, "cannot read the store %s: %s", store->dir, strerror(errno));
    sp_status status = SP_OK;
    for (;;) {
        char name[SP_NAME_MAX];
        errno = 0;
        const struct dirent *entry = status == SP_OK ? readdir(folder) : NULL;
        if (!entry)
            break;
        snprintf(name, sizeof name, "%.32s", entry->d_name);
        if (!sp_store_is_name(name))
            continue;
        const char *ending = entry->d_name + 32;
        if (strcmp(ending, ".h5") == 0 || strcmp(ending, ".failed") == 0)
            status = add_name(list, name, err);
    }
    if (status == SP_OK && errno != 0) /* the list would be shorter than the folder */
        status = sp_fail(err, SP_EIO, "cannot read the store %s: %s", store->dir, strerror(errno));
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
