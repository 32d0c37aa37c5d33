/* A library to preload (LD_PRELOAD): the n-th call of one kind fails, once or from then on, wherever in the process it
 * is made. test_faulty*.py compile it. (faults.c is for calls inside of one folder.)
 *   FAULTY_CALL   own       allocations that the program itself asks for
 *                 foreign   those of the C library and all others
 *                 read write open close stat sync rename lock truncate unlink mkdir list thread clock locale load stdio
 *   FAULTY_AT     1, 2, ...: the call; 0: none, so that calls are only counted
 *   FAULTY_DO     ONCE, or ON: all later calls fail as well
 *   FAULTY_ERROR  a number of errno.h; else SHORT: a part of the bytes (read, write), DONE: done, but an error is
 *                 returned (rename, close, sync), BACK and AHEAD: an hour and a year off (clock)
 *   FAULTY_COUNT  a file that gets the number of calls of each kind at a usual end
 */
#define _GNU_SOURCE
#include "preload.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <link.h>
#include <locale.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t);
extern void *__libc_memalign(size_t, size_t);

enum { PART = -1, DONE = -2, BACK = -3, AHEAD = -4 }; /* beside numbers of errno.h */
static const char *call = "";                         /* the kind that fails */
static bool counting;                                 /* not before the program begins: the loader allocates too */
static long at;
static bool once;
static int what;
static const char *const kinds[] = {"own",    "foreign", "read",   "write",    "open",   "close", "stat",
                                    "sync",   "rename",  "lock",   "truncate", "unlink", "mkdir", "list",
                                    "thread", "clock",   "locale", "load",     "stdio"};
enum { KINDS = sizeof kinds / sizeof *kinds };
static atomic_long calls[KINDS];
static uintptr_t program, program_end; /* its code */

static int range_of(struct dl_phdr_info *info, size_t size, void *nothing) {
    (void)size, (void)nothing;
    for (int k = 0; k < info->dlpi_phnum; k++)
        if (info->dlpi_phdr[k].p_type == PT_LOAD && info->dlpi_phdr[k].p_flags & PF_X) {
            program = info->dlpi_addr + info->dlpi_phdr[k].p_vaddr;
            program_end = program + info->dlpi_phdr[k].p_memsz;
        }
    return 1; /* the program is the first */
}

__attribute__((constructor)) static void begin(void) {
    static const struct {
        const char *word;
        int what;
    } words[] = {{"SHORT", PART}, {"DONE", DONE}, {"BACK", BACK}, {"AHEAD", AHEAD}};
    const char *word = getenv("FAULTY_ERROR"), *number = getenv("FAULTY_AT"), *how = getenv("FAULTY_DO");
    what = word ? atoi(word) : 0;
    for (size_t k = 0; word && k < sizeof words / sizeof *words; k++)
        if (strcmp(word, words[k].word) == 0)
            what = words[k].what;
    at = number ? atol(number) : 0;
    once = how && strcmp(how, "ONCE") == 0;
    call = getenv("FAULTY_CALL") ? getenv("FAULTY_CALL") : "";
    dl_iterate_phdr(range_of, NULL);
    counting = true;
}

__attribute__((destructor)) static void end(void) {
    const char *path = getenv("FAULTY_COUNT");
    counting = false;
    FILE *file = path ? fopen(path, "w") : NULL;
    for (int k = 0; file && k < KINDS; k++)
        fprintf(file, "%s %ld\n", kinds[k], atomic_load(&calls[k]));
    if (file)
        fclose(file);
}

/* A call of a kind: true if it is to fail. */
static bool hit(const char *kind) {
    int k = 0;
    while (k < KINDS && strcmp(kind, kinds[k]) != 0)
        k++;
    if (!counting || k == KINDS)
        return false;
    const long number = atomic_fetch_add(&calls[k], 1) + 1;
    return at > 0 && strcmp(kind, call) == 0 && (once ? number == at : number >= at);
}

static bool fails(const char *kind) {
    const bool failed = hit(kind);
    if (failed)
        errno = what;
    return failed;
}

/* ---- memory ------------------------------------------------------------------------------------------------------ */

static bool from_program(const void *caller) { return (uintptr_t)caller >= program && (uintptr_t)caller < program_end; }

static bool short_of_memory(const void *caller) { return fails(from_program(caller) ? "own" : "foreign"); }
#define SHORT_OF_MEMORY short_of_memory(__builtin_return_address(0))

void *malloc(size_t size) { return SHORT_OF_MEMORY ? NULL : __libc_malloc(size); }
void *calloc(size_t count, size_t size) { return SHORT_OF_MEMORY ? NULL : __libc_calloc(count, size); }
void *realloc(void *old, size_t size) { return SHORT_OF_MEMORY ? NULL : __libc_realloc(old, size); }
void *aligned_alloc(size_t align, size_t size) { return SHORT_OF_MEMORY ? NULL : __libc_memalign(align, size); }
void *memalign(size_t align, size_t size) { return SHORT_OF_MEMORY ? NULL : __libc_memalign(align, size); }

int posix_memalign(void **out, size_t align, size_t size) {
    void *memory = SHORT_OF_MEMORY ? NULL : __libc_memalign(align, size);
    if (memory)
        *out = memory;
    return memory ? 0 : ENOMEM;
}

/* ---- bytes ------------------------------------------------------------------------------------------------------- */

/* As many bytes as a call is to read or write: a part of them, or -1 for an error. */
static ssize_t share(const char *kind, size_t size) {
    const bool failed = hit(kind);
    if (failed && what > 0)
        errno = what;
    return !failed || what == DONE ? (ssize_t)size : what == PART ? (ssize_t)(size + 1) / 2 : -1;
}

#define BYTES(kind, name, data_type)                                                                                   \
    ssize_t name(int fd, data_type data, size_t size) {                                                                \
        REAL(ssize_t, #name, int, data_type, size_t);                                                                  \
        const ssize_t some = share(kind, size);                                                                        \
        return some < 0 ? -1 : real(fd, data, (size_t)some);                                                           \
    }
#define BYTES_AT(kind, name, data_type, offset_type)                                                                   \
    ssize_t name(int fd, data_type data, size_t size, offset_type offset) {                                            \
        REAL(ssize_t, #name, int, data_type, size_t, offset_type);                                                     \
        const ssize_t some = share(kind, size);                                                                        \
        return some < 0 ? -1 : real(fd, data, (size_t)some, offset);                                                   \
    }
BYTES("read", read, void *)
BYTES_AT("read", pread, void *, off_t)
BYTES_AT("read", pread64, void *, off64_t)
BYTES("write", write, const void *)
BYTES_AT("write", pwrite, const void *, off_t)
BYTES_AT("write", pwrite64, const void *, off64_t)

size_t fread(void *data, size_t size, size_t count, FILE *file) {
    REAL(size_t, "fread", void *, size_t, size_t, FILE *);
    return fails("stdio") ? 0 : real(data, size, count, file);
}

size_t fwrite(const void *data, size_t size, size_t count, FILE *file) {
    REAL(size_t, "fwrite", const void *, size_t, size_t, FILE *);
    return file != stderr && fails("stdio") ? 0 : real(data, size, count, file);
}

int fflush(FILE *file) {
    REAL(int, "fflush", FILE *);
    return file != stderr && fails("stdio") ? EOF : real(file);
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

OPEN(fails("open"))

FOPEN(fails("open"))

/* A call after which the file is as it should be, where an error is returned all the same. */
#define ENDS(kind, name, parameters, arguments, ...)                                                                   \
    int name parameters {                                                                                              \
        REAL(int, #name, __VA_ARGS__);                                                                                 \
        const bool failed = hit(kind);                                                                                 \
        int result = 0;                                                                                                \
        if (!failed || what == DONE || strcmp(kind, "close") == 0)                                                     \
            result = real arguments;                                                                                   \
        if (failed)                                                                                                    \
            errno = what > 0 ? what : EIO;                                                                             \
        return failed ? -1 : result;                                                                                   \
    }
ENDS("close", close, (int fd), (fd), int)
ENDS("sync", fsync, (int fd), (fd), int)
ENDS("sync", fdatasync, (int fd), (fd), int)
ENDS("rename", rename, (const char *from, const char *to), (from, to), const char *, const char *)
ENDS("truncate", ftruncate, (int fd, off_t size), (fd, size), int, off_t)
ENDS("truncate", ftruncate64, (int fd, off64_t size), (fd, size), int, off64_t)
ENDS("truncate", fchmod, (int fd, mode_t mode), (fd, mode), int, mode_t)
ENDS("unlink", unlink, (const char *path), (path), const char *)
ENDS("unlink", rmdir, (const char *path), (path), const char *)
ENDS("mkdir", mkdir, (const char *path, mode_t mode), (path, mode), const char *, mode_t)
ENDS("lock", flock, (int fd, int operation), (fd, operation), int, int)
ENDS("stat", stat, (const char *path, struct stat *info), (path, info), const char *, struct stat *)
ENDS("stat", lstat, (const char *path, struct stat *info), (path, info), const char *, struct stat *)
ENDS("stat", fstat, (int fd, struct stat *info), (fd, info), int, struct stat *)
ENDS("stat", stat64, (const char *path, struct stat64 *info), (path, info), const char *, struct stat64 *)
ENDS("stat", fstat64, (int fd, struct stat64 *info), (fd, info), int, struct stat64 *)
ENDS("stat", access, (const char *path, int mode), (path, mode), const char *, int)

char *realpath(const char *restrict path, char *restrict out) {
    REAL(char *, "realpath", const char *, char *);
    return fails("stat") ? NULL : real(path, out);
}

FCNTL(fails("lock"))

DIR *opendir(const char *path) {
    REAL(DIR *, "opendir", const char *);
    return fails("list") ? NULL : real(path);
}

struct dirent *readdir(DIR *folder) {
    REAL(struct dirent *, "readdir", DIR *);
    return fails("list") ? NULL : real(folder);
}

/* ---- the rest ---------------------------------------------------------------------------------------------------- */

int pthread_create(pthread_t *out, const pthread_attr_t *attributes, void *(*begin)(void *), void *data) {
    REAL(int, "pthread_create", pthread_t *, const pthread_attr_t *, void *(*)(void *), void *);
    return fails("thread") ? EAGAIN : real(out, attributes, begin, data);
}

pid_t fork(void) {
    REAL(pid_t, "fork", void);
    return fails("thread") ? -1 : real();
}

locale_t newlocale(int mask, const char *name, locale_t base) {
    REAL(locale_t, "newlocale", int, const char *, locale_t);
    /* libconfig does not look whether it has got one */
    return from_program(__builtin_return_address(0)) && fails("locale") ? (locale_t)0 : real(mask, name, base);
}

void *dlopen(const char *file, int flags) {
    REAL(void *, "dlopen", const char *, int);
    return fails("load") ? NULL : real(file, flags);
}

static long clock_error(void) { return !hit("clock") ? 0 : what == BACK ? -3600 : what == AHEAD ? 31557600 : 0; }

int clock_gettime(clockid_t clock, struct timespec *now) {
    REAL(int, "clock_gettime", clockid_t, struct timespec *);
    const int result = real(clock, now);
    now->tv_sec += clock_error();
    return result;
}

time_t time(time_t *out) {
    REAL(time_t, "time", time_t *);
    const time_t now = real(NULL) + clock_error();
    if (out)
        *out = now;
    return now;
}
