/* A library to preload (LD_PRELOAD): the n-th call of one kind fails, once or from then on. Tests compile it.
 *   FAULTS_CALL   own       allocations that the program itself asks for
 *                 foreign   those of the C library and all others
 *                 read write open close stat sync rename lock truncate unlink mkdir list thread clock locale load stdio
 *                 change    whatever changes files
 *   FAULTS_DIR    a folder, as a real path: only calls on files inside count. "": all calls count
 *                 Of the write that fails first, half of the bytes are written.
 *   FAULTS_AT     1, 2, ...: the call; 0: none, so that calls are only counted
 *   FAULTS_WITHIN addresses of the first and the last function of HDF5 in the program: what it asks for is foreign
 *   FAULTS_DO     ONCE, or ON: all later calls fail as well
 *   FAULTS_ERROR  a number of errno.h; ENOSPC and EDQUOT in a folder spare what frees room. Else
 *                 SHORT   a part of the bytes (read, write)
 *                 DONE    done, but an error is returned (rename, close, sync)
 *                 BACK and AHEAD   an hour and a year off (clock)
 *                 SIGNAL9 and so on   the process gets the signal of this number (write)
 *                 KILL    the process is killed before the call
 *                 POWER   the same, and of every file with bytes that were not synced only the first half is left
 *   FAULTS_COUNT  a file that gets the number of calls of each kind at a usual end
 */
#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <link.h>
#include <locale.h>
#include <pthread.h>
#include <signal.h>
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

enum { PART = -1, DONE = -2, BACK = -3, AHEAD = -4, KILL = -5, POWER = -6, SIGNAL = -100, DIRTY = 256 };
static const char *call = "", *folder = "";
static bool counting; /* not before the program begins: the loader allocates too */
static bool once;
static long at;
static int what; /* one of the above, or a number of errno.h */
static const char *const kinds[] = {"own",    "foreign", "read",   "write",    "open",   "close", "stat",
                                    "sync",   "rename",  "lock",   "truncate", "unlink", "mkdir", "list",
                                    "thread", "clock",   "locale", "load",     "stdio",  "change"};
enum { KINDS = sizeof kinds / sizeof *kinds };
static atomic_long calls[KINDS];
static uintptr_t program, program_end; /* its code */
static uintptr_t within, within_end;   /* HDF5's, where the program holds it */

#define REAL(type, name, ...)                                                                                          \
    static type (*real)(__VA_ARGS__);                                                                                  \
    if (!real)                                                                                                         \
    *(void **)&real = dlsym(RTLD_NEXT, name)

static int range_of(struct dl_phdr_info *info, size_t size, void *nothing) {
    (void)size, (void)nothing;
    for (int k = 0; k < info->dlpi_phnum; k++)
        if (info->dlpi_phdr[k].p_type == PT_LOAD && info->dlpi_phdr[k].p_flags & PF_X) {
            program = info->dlpi_addr + info->dlpi_phdr[k].p_vaddr;
            program_end = program + info->dlpi_phdr[k].p_memsz;
            within += info->dlpi_addr;
            within_end += info->dlpi_addr;
        }
    return 1; /* the program is the first */
}

static const char *word_of(const char *name) { return getenv(name) ? getenv(name) : ""; }

__attribute__((constructor)) static void begin(void) {
    static const char *const words[] = {"SHORT", "DONE", "BACK", "AHEAD", "KILL", "POWER"};
    const char *word = word_of("FAULTS_ERROR");
    what = strncmp(word, "SIGNAL", 6) == 0 ? SIGNAL - atoi(word + 6) : atoi(word);
    for (int k = 0; k < 6; k++)
        if (strcmp(word, words[k]) == 0)
            what = -1 - k;
    at = atol(word_of("FAULTS_AT"));
    once = strcmp(word_of("FAULTS_DO"), "ONCE") == 0;
    call = word_of("FAULTS_CALL");
    folder = word_of("FAULTS_DIR");
    char *end = NULL;
    within = strtoul(word_of("FAULTS_WITHIN"), &end, 10);
    within_end = strtoul(end, NULL, 10);
    dl_iterate_phdr(range_of, NULL);
    counting = true;
}

__attribute__((destructor)) static void end(void) {
    const char *path = getenv("FAULTS_COUNT");
    counting = false;
    FILE *file = path ? fopen(path, "w") : NULL;
    for (int k = 0; file && k < KINDS; k++)
        fprintf(file, "%s %ld\n", kinds[k], atomic_load(&calls[k]));
    if (file)
        fclose(file);
}

/* ---- what is inside the folder --------------------------------------------------------------------------------- */

static bool inside(const char *path) {
    const size_t length = strlen(folder);
    return length == 0 || (strncmp(path, folder, length) == 0 && (path[length] == '/' || path[length] == '\0'));
}

static bool fd_inside(int fd) {
    char link[64], path[PATH_MAX];
    const int kept = errno;
    if (!*folder)
        return true;
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    const ssize_t size = readlink(link, path, sizeof path - 1);
    errno = kept;
    path[size > 0 ? size : 0] = '\0';
    return size > 0 && inside(path);
}

/* ---- bytes that were not synced --------------------------------------------------------------------------------- */

static struct {
    int fd; /* of our own */
    ino_t inode;
} dirty[DIRTY];
static int dirt;
static pthread_mutex_t busy = PTHREAD_MUTEX_INITIALIZER;

static void note(int fd, bool synced) {
    struct stat info;
    if (what != POWER || !fd_inside(fd) || fstat(fd, &info) != 0 || !S_ISREG(info.st_mode))
        return;
    pthread_mutex_lock(&busy);
    int k = 0;
    while (k < dirt && dirty[k].inode != info.st_ino)
        k++;
    if (synced && k < dirt)
        dirty[k] = dirty[--dirt]; /* its descriptor stays: closing it would let locks go */
    else if (!synced && k == dirt && dirt < DIRTY && (dirty[k].fd = dup(fd)) >= 0)
        dirty[dirt++].inode = info.st_ino;
    pthread_mutex_unlock(&busy);
}

static void die(void) {
    REAL(int, "ftruncate", int, off_t);
    struct stat info;
    for (int k = 0; what == POWER && k < dirt; k++)
        if (fstat(dirty[k].fd, &info) == 0 && real(dirty[k].fd, info.st_size / 2) != 0)
            continue;
    kill(getpid(), SIGKILL);
    for (;;)
        pause();
}

/* ---- whether a call fails --------------------------------------------------------------------------------------- */

static bool is_called(const char *kind, bool changes) {
    return strcmp(kind, call) == 0 || (changes && strcmp(call, "change") == 0);
}

static atomic_long *calls_of(const char *kind) {
    int k = 0;
    while (k < KINDS - 1 && strcmp(kind, kinds[k]) != 0)
        k++;
    return &calls[k];
}

/* A call of a kind: true if it is to fail. */
static bool hit(const char *kind, bool counts, bool changes) {
    if (!counting || !counts)
        return false;
    const long number = atomic_fetch_add(calls_of(kind), 1) + 1;
    const long change = changes ? atomic_fetch_add(&calls[KINDS - 1], 1) + 1 : 0;
    const long mine = strcmp(call, "change") == 0 ? change : number;
    if (at == 0 || !is_called(kind, changes) || (once ? mine != at : mine < at))
        return false;
    if (what == KILL || what == POWER)
        die();
    errno = what > 0 ? what : EIO;
    return true;
}

/* Whether the next call of this kind is the first that fails. */
static bool is_next(const char *kind) {
    return is_called(kind, true) && atomic_load(calls_of(strcmp(call, "change") == 0 ? "change" : kind)) + 1 == at;
}

static bool frees(const char *kind, bool counts) {
    return (!*folder || (what != ENOSPC && what != EDQUOT)) && hit(kind, counts, true);
}

/* ---- memory ------------------------------------------------------------------------------------------------------ */

static bool from_program(const void *caller) {
    const uintptr_t code = (uintptr_t)caller;
    return code >= program && code < program_end && !(code >= within && code < within_end);
}

#define SHORT_OF_MEMORY hit(from_program(__builtin_return_address(0)) ? "own" : "foreign", true, false)

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
static ssize_t share(const char *kind, int fd, size_t size) {
    const bool failed = hit(kind, fd_inside(fd), strcmp(kind, "write") == 0);
    return !failed || what == DONE ? (ssize_t)size : what == PART ? (ssize_t)(size + 1) / 2 : -1;
}

/* The end of a write of which only half was done. */
static ssize_t torn(int fd, ssize_t half) {
    hit("write", fd_inside(fd), true);
    if (what > SIGNAL)
        return -1;
    kill(getpid(), SIGNAL - what);
    return half;
}

#define READ(name, parameters, arguments, ...)                                                                         \
    ssize_t name parameters {                                                                                          \
        REAL(ssize_t, #name, __VA_ARGS__);                                                                             \
        const ssize_t some = share("read", fd, size);                                                                  \
        size = (size_t)some;                                                                                           \
        return some < 0 ? -1 : real arguments;                                                                         \
    }
#define WRITE(name, parameters, arguments, ...)                                                                        \
    ssize_t name parameters {                                                                                          \
        REAL(ssize_t, #name, __VA_ARGS__);                                                                             \
        note(fd, false);                                                                                               \
        if (*folder && size > 1 && fd_inside(fd) && is_next("write")) {                                                \
            size /= 2;                                                                                                 \
            return torn(fd, real arguments);                                                                           \
        }                                                                                                              \
        const ssize_t some = share("write", fd, size);                                                                 \
        size = (size_t)some;                                                                                           \
        return some < 0 ? -1 : real arguments;                                                                         \
    }
READ(read, (int fd, void *data, size_t size), (fd, data, size), int, void *, size_t)
READ(pread, (int fd, void *data, size_t size, off_t to), (fd, data, size, to), int, void *, size_t, off_t)
READ(pread64, (int fd, void *data, size_t size, off64_t to), (fd, data, size, to), int, void *, size_t, off64_t)
WRITE(write, (int fd, const void *data, size_t size), (fd, data, size), int, const void *, size_t)
WRITE(pwrite, (int fd, const void *data, size_t size, off_t to), (fd, data, size, to), int, const void *, size_t, off_t)
WRITE(pwrite64, (int fd, const void *data, size_t size, off64_t to), (fd, data, size, to), int, const void *, size_t,
      off64_t)

size_t fread(void *data, size_t size, size_t count, FILE *file) {
    REAL(size_t, "fread", void *, size_t, size_t, FILE *);
    return hit("stdio", true, false) ? 0 : real(data, size, count, file);
}

size_t fwrite(const void *data, size_t size, size_t count, FILE *file) {
    REAL(size_t, "fwrite", const void *, size_t, size_t, FILE *);
    return hit("stdio", file != stderr, false) ? 0 : real(data, size, count, file);
}

int fflush(FILE *file) {
    REAL(int, "fflush", FILE *);
    return hit("stdio", file != stderr, false) ? EOF : real(file);
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static bool is_to_write(int flags) { return (flags & O_ACCMODE) != O_RDONLY || flags & (O_CREAT | O_TRUNC); }

#define OPEN(name)                                                                                                     \
    int name(const char *path, int flags, ...) {                                                                       \
        REAL(int, #name, const char *, int, ...);                                                                      \
        va_list rest;                                                                                                  \
        va_start(rest, flags);                                                                                         \
        mode_t mode = va_arg(rest, mode_t);                                                                            \
        va_end(rest);                                                                                                  \
        return hit("open", inside(path), is_to_write(flags)) ? -1 : real(path, flags, mode);                           \
    }
OPEN(open)
OPEN(open64)

#define FOPEN(name)                                                                                                    \
    FILE *name(const char *path, const char *mode) {                                                                   \
        REAL(FILE *, #name, const char *, const char *);                                                               \
        return hit("open", inside(path), strpbrk(mode, "wa+")) ? NULL : real(path, mode);                              \
    }
FOPEN(fopen)
FOPEN(fopen64)

/* A call after which the file may be as it should be, where an error is returned all the same. A closed file is closed
 * anyway. */
#define CALL(name, failing, parameters, arguments, ...)                                                                \
    int name parameters {                                                                                              \
        REAL(int, #name, __VA_ARGS__);                                                                                 \
        const bool failed = failing;                                                                                   \
        const int code = errno, result = !failed || what == DONE || strcmp(#name, "close") == 0 ? real arguments : -1; \
        errno = failed ? code : errno;                                                                                 \
        return failed ? -1 : result;                                                                                   \
    }
CALL(close, hit("close", fd_inside(fd), false), (int fd), (fd), int)
CALL(rename, hit("rename", inside(to), true), (const char *from, const char *to), (from, to), const char *,
     const char *)
CALL(link, hit("rename", inside(to), true), (const char *from, const char *to), (from, to), const char *, const char *)
CALL(ftruncate, frees("truncate", fd_inside(fd)), (int fd, off_t size), (fd, size), int, off_t)
CALL(ftruncate64, frees("truncate", fd_inside(fd)), (int fd, off64_t size), (fd, size), int, off64_t)
CALL(fchmod, hit("truncate", fd_inside(fd), false), (int fd, mode_t mode), (fd, mode), int, mode_t)
CALL(unlink, frees("unlink", inside(path)), (const char *path), (path), const char *)
CALL(rmdir, frees("unlink", inside(path)), (const char *path), (path), const char *)
CALL(mkdir, hit("mkdir", inside(path), true), (const char *path, mode_t mode), (path, mode), const char *, mode_t)
CALL(flock, hit("lock", fd_inside(fd), false), (int fd, int operation), (fd, operation), int, int)
#define STAT(name, inside, of, type)                                                                                   \
    CALL(name, hit("stat", inside(at_), false), (of at_, struct type * info), (at_, info), of, struct type *)
STAT(stat, inside, const char *, stat)
STAT(lstat, inside, const char *, stat)
STAT(fstat, fd_inside, int, stat)
STAT(stat64, inside, const char *, stat64)
STAT(fstat64, fd_inside, int, stat64)
CALL(access, hit("stat", inside(path), false), (const char *path, int mode), (path, mode), const char *, int)

static bool sync_fails(int fd) {
    const bool failed = hit("sync", fd_inside(fd), true);
    note(fd, !failed);
    return failed;
}
CALL(fsync, sync_fails(fd), (int fd), (fd), int)
CALL(fdatasync, sync_fails(fd), (int fd), (fd), int)

char *realpath(const char *restrict path, char *restrict out) {
    REAL(char *, "realpath", const char *, char *);
    return hit("stat", inside(path), false) ? NULL : real(path, out);
}

static bool is_lock(int command) {
    return command == F_SETLK || command == F_SETLKW || command == F_OFD_SETLK || command == F_OFD_SETLKW;
}

#define FCNTL(name)                                                                                                    \
    int name(int fd, int command, ...) {                                                                               \
        REAL(int, #name, int, int, ...);                                                                               \
        va_list rest;                                                                                                  \
        va_start(rest, command);                                                                                       \
        void *argument = va_arg(rest, void *);                                                                         \
        va_end(rest);                                                                                                  \
        return is_lock(command) && hit("lock", fd_inside(fd), false) ? -1 : real(fd, command, argument);               \
    }
FCNTL(fcntl)
FCNTL(fcntl64)

DIR *opendir(const char *path) {
    REAL(DIR *, "opendir", const char *);
    return hit("list", inside(path), false) ? NULL : real(path);
}

struct dirent *readdir(DIR *of) {
    REAL(struct dirent *, "readdir", DIR *);
    return hit("list", true, false) ? NULL : real(of);
}

/* ---- the rest ---------------------------------------------------------------------------------------------------- */

int pthread_create(pthread_t *out, const pthread_attr_t *attributes, void *(*first)(void *), void *data) {
    REAL(int, "pthread_create", pthread_t *, const pthread_attr_t *, void *(*)(void *), void *);
    return hit("thread", true, false) ? EAGAIN : real(out, attributes, first, data);
}

pid_t fork(void) {
    REAL(pid_t, "fork", void);
    return hit("thread", true, false) ? -1 : real();
}

locale_t newlocale(int mask, const char *name, locale_t base) {
    REAL(locale_t, "newlocale", int, const char *, locale_t);
    /* libconfig does not look whether it has got one */
    const bool ours = from_program(__builtin_return_address(0));
    return ours && hit("locale", true, false) ? (locale_t)0 : real(mask, name, base);
}

void *dlopen(const char *file, int flags) {
    REAL(void *, "dlopen", const char *, int);
    return hit("load", true, false) ? NULL : real(file, flags);
}

static long clock_error(void) {
    return !hit("clock", true, false) ? 0 : what == BACK ? -3600 : what == AHEAD ? 31557600 : 0;
}

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
