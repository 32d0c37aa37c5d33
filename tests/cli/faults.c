/* A library to preload (LD_PRELOAD): calls that change files inside of one folder end the process, or fail, from the
 * FAULTS_AT-th on. The tests of stores compile it.
 *   FAULTS_DIR    the folder, as a real path
 *   FAULTS_AT     1, 2, ...: the call; 0: none
 *   FAULTS_DO     KILL: SIGKILL before the call, or after half of the bytes of a write
 *                 POWER: the same, and of every file with bytes that were not synced only the first half is left
 *                 ENOSPC, EDQUOT: what needs room fails; EIO, EROFS: whatever changes something fails
 *                 ENOLCK: locks fail, and only they count
 *   FAULTS_COUNT  a file that gets the number of calls at a usual end
 */
#define _GNU_SOURCE
#include "preload.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

enum { KILL = -1, POWER = -2, DIRTY = 256 };

static char folder[PATH_MAX];
static size_t length; /* of its path; 0: nothing is inside */
static long at;
static int what; /* KILL, POWER, or the error that calls get */
static atomic_long calls;

static struct {
    int fd; /* of our own */
    ino_t inode;
} dirty[DIRTY]; /* files with bytes that were not synced */
static int dirt;
static atomic_flag busy = ATOMIC_FLAG_INIT;

__attribute__((constructor)) static void begin(void) {
    static const struct {
        const char *name;
        int what;
    } all[] = {{"KILL", KILL}, {"POWER", POWER}, {"ENOSPC", ENOSPC}, {"EDQUOT", EDQUOT},
               {"EIO", EIO},   {"EROFS", EROFS}, {"ENOLCK", ENOLCK}};
    const char *dir = getenv("FAULTS_DIR"), *number = getenv("FAULTS_AT"), *word = getenv("FAULTS_DO");
    for (size_t k = 0; word && k < sizeof all / sizeof *all; k++)
        if (strcmp(word, all[k].name) == 0)
            what = all[k].what;
    at = number && what ? atol(number) : 0;
    if (dir && strlen(dir) < sizeof folder) {
        strcpy(folder, dir);
        length = strlen(dir);
    }
}

__attribute__((destructor)) static void end(void) {
    const char *path = getenv("FAULTS_COUNT");
    FILE *file = path ? fopen(path, "w") : NULL;
    if (!file)
        return;
    fprintf(file, "%ld\n", atomic_load(&calls));
    fclose(file);
}

/* ---- what is inside -------------------------------------------------------------------------------------------- */

static bool inside(const char *path) {
    return length > 0 && strncmp(path, folder, length) == 0 && (path[length] == '/' || path[length] == '\0');
}

static bool fd_inside(int fd) {
    char link[64], path[PATH_MAX];
    int kept = errno;
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t size = length > 0 ? readlink(link, path, sizeof path - 1) : -1;
    errno = kept;
    path[size > 0 ? size : 0] = '\0';
    return size > 0 && inside(path);
}

static bool at_inside(int dir, const char *path) {
    return path[0] == '/' || dir == AT_FDCWD ? inside(path) : fd_inside(dir);
}

/* ---- bytes that were not synced --------------------------------------------------------------------------------- */

static void enter(void) {
    while (atomic_flag_test_and_set(&busy))
        ;
}

static void leave(void) { atomic_flag_clear(&busy); }

static void note_write(int fd) {
    struct stat info;
    if (what != POWER || fstat(fd, &info) != 0 || !S_ISREG(info.st_mode))
        return;
    enter();
    int k = 0;
    while (k < dirt && dirty[k].inode != info.st_ino)
        k++;
    if (k == dirt && dirt < DIRTY && (dirty[k].fd = dup(fd)) >= 0)
        dirty[dirt++].inode = info.st_ino;
    leave();
}

static void note_sync(int fd) {
    struct stat info;
    if (what != POWER || fstat(fd, &info) != 0)
        return;
    enter();
    for (int k = 0; k < dirt; k++)
        if (dirty[k].inode == info.st_ino)
            dirty[k--] = dirty[--dirt]; /* its descriptor stays: closing it would let locks go */
    leave();
}

static void die(void) {
    if (what == POWER) {
        REAL(int, "ftruncate", int, off_t);
        for (int k = 0; k < dirt; k++) {
            struct stat info;
            if (fstat(dirty[k].fd, &info) == 0 && real(dirty[k].fd, info.st_size / 2) != 0)
                continue;
        }
    }
    kill(getpid(), SIGKILL);
    for (;;)
        pause();
}

/* ---- the calls --------------------------------------------------------------------------------------------------- */

/* A call inside of the folder: true if it fails. Those that free room go well on a full disk. */
static bool fails(bool frees_room) {
    if (what == ENOLCK)
        return false;
    long number = atomic_fetch_add(&calls, 1) + 1;
    if (at == 0 || number < at)
        return false;
    if (what < 0)
        die();
    if (frees_room && what != EIO && what != EROFS)
        return false;
    errno = what;
    return true;
}

static bool changes(int flags) { return (flags & O_ACCMODE) != O_RDONLY || flags & (O_CREAT | O_TRUNC); }

OPEN(changes(flags) && inside(path) && fails(false))

#define OPENAT(name)                                                                                                   \
    int name(int dir, const char *path, int flags, ...) {                                                              \
        REAL(int, #name, int, const char *, int, ...);                                                                 \
        va_list rest;                                                                                                  \
        va_start(rest, flags);                                                                                         \
        mode_t mode = va_arg(rest, mode_t);                                                                            \
        va_end(rest);                                                                                                  \
        return changes(flags) && at_inside(dir, path) && fails(false) ? -1 : real(dir, path, flags, mode);             \
    }
OPENAT(openat)
OPENAT(openat64)

FOPEN(strpbrk(mode, "wa+") && inside(path) && fails(false))

ssize_t write(int fd, const void *data, size_t size) {
    REAL(ssize_t, "write", int, const void *, size_t);
    if (!fd_inside(fd))
        return real(fd, data, size);
    note_write(fd);
    if (atomic_load(&calls) + 1 == at && what != ENOLCK && size > 1) { /* a part of it is written first */
        ssize_t half = real(fd, data, size / 2);
        return fails(false) ? half : -1;
    }
    return fails(false) ? -1 : real(fd, data, size);
}

#define PWRITE(name, offset_type)                                                                                      \
    ssize_t name(int fd, const void *data, size_t size, offset_type offset) {                                          \
        REAL(ssize_t, #name, int, const void *, size_t, offset_type);                                                  \
        if (!fd_inside(fd))                                                                                            \
            return real(fd, data, size, offset);                                                                       \
        note_write(fd);                                                                                                \
        if (atomic_load(&calls) + 1 == at && what != ENOLCK && size > 1) {                                             \
            ssize_t half = real(fd, data, size / 2, offset);                                                           \
            return fails(false) ? half : -1;                                                                           \
        }                                                                                                              \
        return fails(false) ? -1 : real(fd, data, size, offset);                                                       \
    }
PWRITE(pwrite, off_t)
PWRITE(pwrite64, off64_t)

#define SYNC(name)                                                                                                     \
    int name(int fd) {                                                                                                 \
        REAL(int, #name, int);                                                                                         \
        if (fd_inside(fd) && fails(false))                                                                             \
            return -1;                                                                                                 \
        note_sync(fd);                                                                                                 \
        return real(fd);                                                                                               \
    }
SYNC(fsync)
SYNC(fdatasync)

#define TRUNCATE(name, offset_type)                                                                                    \
    int name(int fd, offset_type size) {                                                                               \
        REAL(int, #name, int, offset_type);                                                                            \
        return fd_inside(fd) && fails(true) ? -1 : real(fd, size);                                                     \
    }
TRUNCATE(ftruncate, off_t)
TRUNCATE(ftruncate64, off64_t)

int rename(const char *from, const char *to) {
    REAL(int, "rename", const char *, const char *);
    return inside(to) && fails(false) ? -1 : real(from, to);
}

int renameat(int from_dir, const char *from, int to_dir, const char *to) {
    REAL(int, "renameat", int, const char *, int, const char *);
    return at_inside(to_dir, to) && fails(false) ? -1 : real(from_dir, from, to_dir, to);
}

int link(const char *from, const char *to) {
    REAL(int, "link", const char *, const char *);
    return inside(to) && fails(false) ? -1 : real(from, to);
}

int unlink(const char *path) {
    REAL(int, "unlink", const char *);
    return inside(path) && fails(true) ? -1 : real(path);
}

int unlinkat(int dir, const char *path, int flags) {
    REAL(int, "unlinkat", int, const char *, int);
    return at_inside(dir, path) && fails(true) ? -1 : real(dir, path, flags);
}

int mkdir(const char *path, mode_t mode) {
    REAL(int, "mkdir", const char *, mode_t);
    return inside(path) && fails(false) ? -1 : real(path, mode);
}

/* ---- locks ------------------------------------------------------------------------------------------------------- */

static bool lock_fails(int fd) {
    if (what != ENOLCK || !fd_inside(fd))
        return false;
    long number = atomic_fetch_add(&calls, 1) + 1;
    if (at == 0 || number < at)
        return false;
    errno = ENOLCK;
    return true;
}

int flock(int fd, int operation) {
    REAL(int, "flock", int, int);
    return lock_fails(fd) ? -1 : real(fd, operation);
}

FCNTL(lock_fails(fd))
