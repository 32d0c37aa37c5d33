/* Whole files: reading, hashing, atomic writing, and cleaning up temporary files. */
#include "base/file.h"

#include "base/base.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <sonopack/table.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* Limit for text files, so that an endless device cannot fill the memory. */
static const size_t text_limit = (size_t)1 << 31;

static sp_status fail_errno(sp_error *err, const char *what, const char *path, int code) {
    return sp_fail(err, SP_EIO, "cannot %s %s: %s", what, path, strerror(code));
}

/* ---- reading --------------------------------------------------------------------------------------------------- */

static sp_status read_all(int fd, const char *path, bool any, char **text, size_t *size, sp_error *err) {
    struct stat info;
    if (fstat(fd, &info) != 0)
        return fail_errno(err, "read", path, errno);
    if (S_ISDIR(info.st_mode))
        return fail_errno(err, "read", path, EISDIR);
    if (S_ISREG(info.st_mode) && (uint64_t)info.st_size > text_limit)
        return sp_fail(err, SP_EFORMAT, "%s: %.3g GB is too large", path, (double)info.st_size * 1e-9);
    /* two bytes more than a regular file's size: the final zero, and one for read() to find the end of the file */
    size_t capacity = S_ISREG(info.st_mode) ? (size_t)info.st_size + 2 : 65536, used = 0;
    char *buffer = sp_alloc(capacity, 1);
    sp_status status = buffer ? SP_OK : sp_fail_memory(err, capacity);
    while (status == SP_OK) {
        char *larger = sp_grow(buffer, used + 2, &capacity, 1);
        if (!larger) {
            status = sp_fail_memory(err, 2 * capacity);
            break;
        }
        buffer = larger;
        ssize_t got = read(fd, buffer + used, capacity - 1 - used);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            status = fail_errno(err, "read", path, errno);
        if (got <= 0)
            break;
        if (!any && memchr(buffer + used, 0, (size_t)got))
            status = sp_fail(err, SP_EFORMAT, "%s: not a text file (a zero byte within the first %zu bytes)", path,
                             used + (size_t)got);
        used += (size_t)got;
        if (used > text_limit)
            status = sp_fail(err, SP_EFORMAT, "%s: more than %zu bytes is too large", path, text_limit);
    }
    if (status != SP_OK) {
        sp_free(buffer);
        return status;
    }
    buffer[used] = '\0';
    *text = buffer;
    *size = used;
    return SP_OK;
}

static sp_status read_file(const char *path, bool any, char **data, size_t *size, sp_error *err) {
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        return fail_errno(err, "open", path, errno);
    sp_status status = read_all(fd, path, any, data, size, err);
    close(fd);
    return status;
}

sp_status sp_file_read_text(const char *path, char **text, size_t *size, sp_error *err) {
    return read_file(path, false, text, size, err);
}

sp_status sp_file_read(const char *path, char **data, size_t *size, sp_error *err) {
    return read_file(path, true, data, size, err);
}

int64_t sp_file_read_at(int fd, void *data, size_t size, int64_t at) {
    size_t used = 0;
    while (used < size) {
        const ssize_t got = pread(fd, (char *)data + used, size - used, (off_t)at + (off_t)used);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return -1;
        if (got == 0)
            break;
        used += (size_t)got;
    }
    return (int64_t)used;
}

/* ---- writing --------------------------------------------------------------------------------------------------- */

static int write_all(int fd, const char *data, size_t size) {
    while (size > 0) {
        ssize_t put = write(fd, data, size < ((size_t)1 << 30) ? size : (size_t)1 << 30);
        if (put < 0 && errno == EINTR)
            continue;
        if (put < 0)
            return errno;
        data += put;
        size -= (size_t)put;
    }
    return 0;
}

/* Folder part of a path, "." for a bare name. */
static void folder_of(const char *path, char folder[SP_PATH_MAX]) {
    const char *slash = strrchr(path, '/');
    if (!slash)
        snprintf(folder, SP_PATH_MAX, ".");
    else
        snprintf(folder, SP_PATH_MAX, "%.*s", slash == path ? 1 : (int)(slash - path), path);
}

/* Locks a new file. EWOULDBLOCK if another process has locked it, or has already removed it as a leftover; another code
 * if that cannot be told. Where the file system has no locks, this returns 0 and nothing is removed. */
static int own(int fd) {
    struct stat info;
    if (flock(fd, LOCK_EX | LOCK_NB) != 0)
        return errno == EWOULDBLOCK ? errno : 0;
    if (fstat(fd, &info) != 0)
        return errno;
    return info.st_nlink > 0 ? 0 : EWOULDBLOCK;
}

/* ---- temporary files -------------------------------------------------------------------------------------------- */

/* Names of temporary files that are being written, for sp_drafts_abandon. */
enum { REMEMBERED = 64 };
static _Atomic(const char *) temporaries[REMEMBERED];
static atomic_bool abandoned; /* no more of them */

static void remember(const char *name) {
    for (int k = 0; k < REMEMBERED; k++) {
        const char *none = NULL;
        if (atomic_compare_exchange_strong(&temporaries[k], &none, name))
            return;
    }
}

/* Call before the name changes or goes. */
static void forget(const char *name) {
    for (int k = 0; k < REMEMBERED; k++) {
        const char *same = name;
        if (atomic_compare_exchange_strong(&temporaries[k], &same, NULL))
            return;
    }
}

/* Removes what can be removed now. Returns whether a file is still being written. */
static bool remove_temporaries(void) {
    bool any = false;
    for (int k = 0; k < REMEMBERED; k++) {
        char name[SP_PATH_MAX];
        const char *seen = atomic_load(&temporaries[k]);
        if (!seen)
            continue;
        any = true;
        strncpy(name, seen, sizeof name - 1);
        name[sizeof name - 1] = '\0';
        if (atomic_load(&temporaries[k]) == seen) /* else the copy may be of something else */
            unlink(name);
    }
    return any;
}

void sp_drafts_abandon(void) {
    const struct timespec moment = {.tv_nsec = 2000000};
    atomic_store(&abandoned, true);
    if (remove_temporaries()) { /* another thread may be just creating one */
        nanosleep(&moment, NULL);
        remove_temporaries();
    }
}

/* Prefix of this machine's temporary files. It contains the host because some file systems only lock within a
 * machine. */
static void own_prefix(char prefix[32]) {
    char host[256] = "";
    gethostname(host, sizeof host - 1);
    snprintf(prefix, 32, ".sonopack-%08x-", (unsigned)sp_hash64(SP_HASH64_BEGIN, host, strlen(host)));
}

/* -1 with errno if there is such a file, or if none may be made any more. */
static int create(const char *name) {
    if (!atomic_load(&abandoned))
        return open(name, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    errno = EINTR;
    return -1;
}

/* Opens a new temporary file in the folder. The name is unique (machine, process, counter), and short enough to fit
 * wherever the final name fits. A leftover of a dead process with the same number is skipped. */
static int open_temporary(const char *folder, char name[SP_PATH_MAX]) {
    static atomic_uint counter;
    char prefix[32];
    own_prefix(prefix);
    for (int attempt = 0; attempt < 10000; attempt++) {
        int length = snprintf(name, SP_PATH_MAX, "%s/%s%ld-%u.tmp", folder, prefix, (long)getpid(),
                              atomic_fetch_add(&counter, 1));
        if (length >= SP_PATH_MAX) {
            errno = ENAMETOOLONG;
            return -1;
        }
        remember(name); /* before it is there: a signal may come in between */
        const int fd = create(name), code = fd < 0 ? errno : own(fd);
        if (code == 0)
            return fd;
        forget(name);
        if (fd >= 0)
            close(fd);
        if (code != EEXIST && code != EWOULDBLOCK) {
            if (fd >= 0)
                unlink(name);
            errno = code;
            return -1;
        }
    }
    return -1;
}

/* Makes the rename durable. Some file systems cannot sync a folder; the file's data are safe even then. */
static void sync_folder(const char *folder) {
    int fd = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd >= 0) {
        fsync(fd);
        close(fd);
    }
}

/* Starts a draft of the file `path`, which is no link. old: the file that it replaces, or NULL. */
static sp_status begin_draft(const char *path, const struct stat *old, sp_draft *d, sp_error *err) {
    char folder[SP_PATH_MAX];
    *d = (sp_draft){.mode = old ? (int)(old->st_mode & 07777) : -1};
    snprintf(d->path, sizeof d->path, "%s", path);
    folder_of(path, folder);
    d->fd = open_temporary(folder, d->temporary);
    return d->fd < 0 ? fail_errno(err, "write", path, errno) : SP_OK;
}

void sp_draft_drop(sp_draft *d) {
    if (d->fd < 0)
        return;
    unlink(d->temporary);
    forget(d->temporary);
    close(d->fd);
    d->fd = -1;
}

sp_status sp_draft_commit(sp_draft *d, sp_error *err) {
    char folder[SP_PATH_MAX];
    int code = 0;
    if (d->mode >= 0 && fchmod(d->fd, (mode_t)d->mode) != 0)
        code = errno;
    if (code == 0 && fsync(d->fd) != 0)
        code = errno;
    if (code == 0 && rename(d->temporary, d->path) != 0) /* still open, so still locked */
        code = errno;
    if (code != 0) {
        sp_draft_drop(d);
        return fail_errno(err, "write", d->path, code);
    }
    forget(d->temporary);
    close(d->fd); /* fsync has succeeded, so close cannot lose data */
    d->fd = -1;
    folder_of(d->path, folder);
    sync_folder(folder);
    return SP_OK;
}

static sp_status write_renamed(const char *path, const void *data, size_t size, const struct stat *old, sp_error *err) {
    sp_draft d;
    sp_status status = begin_draft(path, old, &d, err);
    if (status != SP_OK)
        return status;
    const int code = write_all(d.fd, data, size);
    if (code == 0)
        return sp_draft_commit(&d, err);
    sp_draft_drop(&d);
    return fail_errno(err, "write", path, code);
}

/* Devices and pipes are written in place: a rename would replace /dev/null for everybody. */
static sp_status write_direct(const char *path, const void *data, size_t size, sp_error *err) {
    int fd = open(path, O_WRONLY | O_CLOEXEC);
    if (fd < 0)
        return fail_errno(err, "write", path, errno);
    int code = write_all(fd, data, size);
    if (close(fd) != 0 && code == 0)
        code = errno;
    return code ? fail_errno(err, "write", path, code) : SP_OK;
}

/* Finds what a path names. *kind: 0 where nothing is there yet, else S_IFREG or another kind, with `target` and `info`
 * of a regular file. */
static sp_status find_target(const char *path, char target[PATH_MAX], struct stat *info, mode_t *kind, sp_error *err) {
    *kind = 0;
    if (!path || !*path)
        return sp_fail(err, SP_EINVAL, "the name of the file to write is empty");
    if (strlen(path) >= SP_PATH_MAX)
        return fail_errno(err, "write", "a file", ENAMETOOLONG);
    if (stat(path, info) != 0) { /* a dangling link is an error */
        const int code = errno;
        return code == ENOENT && lstat(path, info) != 0 ? SP_OK : fail_errno(err, "write", path, code);
    }
    if (S_ISDIR(info->st_mode))
        return fail_errno(err, "write", path, EISDIR);
    *kind = info->st_mode & S_IFMT;
    if (S_ISREG(info->st_mode) && (!realpath(path, target) || access(target, W_OK) != 0))
        return fail_errno(err, "write", path, errno);
    return SP_OK;
}

sp_status sp_file_write(const char *path, const void *data, size_t size, sp_error *err) {
    struct stat info;
    char target[PATH_MAX];
    mode_t kind;
    sp_status status = find_target(path, target, &info, &kind, err);
    if (status != SP_OK)
        return status;
    if (kind == 0)
        return write_renamed(path, data, size, NULL, err);
    return kind == S_IFREG ? write_renamed(target, data, size, &info, err) : write_direct(path, data, size, err);
}

sp_status sp_draft_begin(const char *path, sp_draft *d, sp_error *err) {
    struct stat info;
    char target[PATH_MAX];
    mode_t kind;
    d->fd = -1;
    sp_status status = find_target(path, target, &info, &kind, err);
    if (status != SP_OK)
        return status;
    if (kind != 0 && kind != S_IFREG)
        return sp_fail(err, SP_EIO, "cannot write %s: a device or a pipe, must be a regular file", path);
    return begin_draft(kind ? target : path, kind ? &info : NULL, d, err);
}

sp_status sp_file_probe(const char *path, sp_error *err) {
    struct stat info;
    char target[PATH_MAX], folder[SP_PATH_MAX];
    mode_t kind;
    sp_status status = find_target(path, target, &info, &kind, err);
    if (status != SP_OK || (kind != 0 && kind != S_IFREG))
        return status;
    folder_of(kind ? target : path, folder);
    return sp_folder_probe(folder, err);
}

sp_status sp_text_save(const char *path, const char *text, size_t size, sp_error *err) {
    return sp_file_write(path, text, size, err);
}

/* Whether nobody writes the file any more. For this machine's files a free lock is enough. Locks of other machines may
 * be invisible here, so their files must also be a day older than the last change of the folder: the clock of the file
 * system wrote both times, and that of this machine may be wrong. */
static bool is_left_behind(int fd, bool own_machine, int folder) {
    struct stat info, around;
    return flock(fd, LOCK_EX | LOCK_NB) == 0 && (own_machine || (fstat(fd, &info) == 0 && fstat(folder, &around) == 0 &&
                                                                 around.st_mtime - info.st_mtime > 86400));
}

void sp_folder_clean(const char *folder) {
    char prefix[32];
    own_prefix(prefix);
    DIR *all = opendir(folder);
    for (struct dirent *entry; all && (entry = readdir(all));) {
        char path[SP_PATH_MAX];
        const char *name = entry->d_name, *ending = strrchr(name, '.');
        if (strncmp(name, ".sonopack-", 10) != 0 || strcmp(ending, ".tmp") != 0 ||
            (size_t)snprintf(path, sizeof path, "%s/%s", folder, name) >= sizeof path)
            continue;
        const int fd = open(path, O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
        if (fd >= 0 && is_left_behind(fd, strncmp(name, prefix, strlen(prefix)) == 0, dirfd(all)))
            unlink(path);
        if (fd >= 0)
            close(fd);
    }
    if (all)
        closedir(all);
}

void sp_folder_clean_beside(const char *path) {
    char folder[SP_PATH_MAX];
    folder_of(path, folder);
    sp_folder_clean(folder);
}

sp_status sp_folder_probe(const char *folder, sp_error *err) {
    char temporary[SP_PATH_MAX];
    int fd = open_temporary(folder, temporary);
    if (fd < 0)
        return fail_errno(err, "write in", folder, errno);
    close(fd);
    unlink(temporary);
    forget(temporary);
    return SP_OK;
}
