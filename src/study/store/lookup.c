/* Looks up samples: in the manifest where it is up to date, and in their files otherwise. */
#include "base/base.h"
#include "store/failure.h"
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

static void add_line(const sp_store *store, const place *file, uint64_t content, const sp_sample *sample) {
    const sp_manifest_line line = {
        .bytes = file->info.st_size, .modified = sp_manifest_time(&file->info), .content = content, .sample = *sample};
    sp_manifest_add(store->manifest, &line);
}

void sp_store_enter(const sp_store *store, const sp_sample *sample) {
    place file;
    uint64_t content;
    if (find_file(store, sample->name, sample->failed ? "failed" : "h5", &file) && S_ISREG(file.info.st_mode) &&
        sp_file_hash(file.path, &content, NULL) == SP_OK)
        add_line(store, &file, content, sample);
}

/* Finds the last line of a sample, if it describes the file: same size and time, or same size and bytes, as after the
 * file was copied. */
static bool recall(const sp_store *store, const char *name, bool failed, const place *file, sp_sample *out) {
    sp_manifest_line line;
    uint64_t content;
    if (!sp_manifest_find(store->manifest, name, failed, &file->info, &line) || line.bytes != file->info.st_size)
        return false;
    if (line.modified != sp_manifest_time(&file->info)) {
        if (!S_ISREG(file->info.st_mode) || sp_file_hash(file->path, &content, NULL) != SP_OK ||
            content != line.content)
            return false;
        add_line(store, file, content, &line.sample);
    }
    *out = line.sample;
    return true;
}

sp_status sp_store_sample(const sp_store *store, const char *name, sp_sample *out, sp_error *err) {
    place file;
    sp_record r;
    /* if the file system does not answer, reading the file will tell */
    const bool made = find_file(store, name, "h5", &file) || errno != ENOENT;
    if (!made && !find_file(store, name, "failed", &file))
        return sp_fail(err, SP_EIO, "no sample %s in the store %s", name, store->dir);
    if (recall(store, name, !made, &file, out) && sp_sample_possible(out, NULL) == SP_OK)
        return SP_OK;
    sp_status status =
        made ? sp_store_get(store, name, NULL, false, &r, err) : sp_failure_read(file.path, name, out, err);
    if (status == SP_OK && made) {
        *out = r.sample;
        sp_record_free(&r);
        status = sp_sample_possible(out, err);
    }
    if (status == SP_EFAILED)
        sp_fail_prefix(err, "%s", file.path);
    return status;
}

bool sp_store_recall(const sp_store *store, const char *name, bool failed, sp_sample *out) {
    place file;
    return find_file(store, name, failed ? "failed" : "h5", &file) && recall(store, name, failed, &file, out) &&
           sp_sample_possible(out, NULL) == SP_OK;
}

bool sp_store_has_failed(const sp_store *store, const char *name) {
    place file;
    sp_sample sample;
    if (!find_file(store, name, "failed", &file))
        return false;
    if (recall(store, name, true, &file, &sample))
        return true;
    if (sp_failure_read(file.path, name, &sample, NULL) != SP_OK)
        return false;
    sp_store_enter(store, &sample);
    return true;
}

sp_status sp_store_check_bytes(const sp_store *store, const char *name, sp_error *err) {
    place file;
    sp_manifest_line line;
    uint64_t content;
    if (!find_file(store, name, "h5", &file) || !S_ISREG(file.info.st_mode) ||
        !sp_manifest_find(store->manifest, name, false, &file.info, &line) || line.bytes != file.info.st_size ||
        line.modified != sp_manifest_time(&file.info))
        return SP_OK;
    sp_status status = sp_file_hash(file.path, &content, err);
    if (status == SP_OK && content != line.content)
        status =
            sp_fail(err, SP_EFORMAT, "%s: other bytes than were written there, with the same size and time", file.path);
    return status;
}

/* The name of the first column in which two lines of the manifest differ. */
static void name_column(const char *head, const char *a, const char *b, char *name, size_t size) {
    while (*a && *a == *b) {
        if (*a == '\t')
            head += strcspn(head, "\t") + 1;
        a++;
        b++;
    }
    snprintf(name, size, "%.*s", (int)strcspn(head, "\t\n"), head);
}

sp_status sp_store_check_line(const sp_store *store, const sp_sample *s, sp_error *err) {
    place file;
    sp_manifest_line line;
    sp_text stored = {0}, expected = {0}, head = {0};
    char column[80];
    if (!find_file(store, s->name, "h5", &file) ||
        !sp_manifest_find(store->manifest, s->name, false, &file.info, &line) || line.bytes != file.info.st_size ||
        line.modified != sp_manifest_time(&file.info))
        return SP_OK;
    sp_manifest_head(&head);
    sp_manifest_put(&stored, &line);
    line.sample = *s;
    sp_manifest_put(&expected, &line);
    const bool failed = stored.failed || expected.failed || head.failed;
    sp_status status = failed ? sp_fail_memory(err, stored.capacity + expected.capacity + head.capacity) : SP_OK;
    if (status == SP_OK && strcmp(stored.data, expected.data) != 0) {
        name_column(head.data, stored.data, expected.data, column, sizeof column);
        status = sp_fail_key(err, SP_EFAILED, "manifest.tsv", ": %s is not that of the file", column);
    }
    sp_text_free(&stored);
    sp_text_free(&expected);
    sp_text_free(&head);
    return status;
}
