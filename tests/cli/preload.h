/* For libraries to preload: calls of the C library in front of the real ones. `fails' is an expression in a call's
 * arguments; if it is true the real call is not made. */
#include <dlfcn.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <sys/stat.h>

#define REAL(type, name, ...)                                                                                          \
    static type (*real)(__VA_ARGS__);                                                                                  \
    if (!real)                                                                                                         \
    *(void **)&real = dlsym(RTLD_NEXT, name)

#define OPEN_AS(name, fails)                                                                                           \
    int name(const char *path, int flags, ...) {                                                                       \
        REAL(int, #name, const char *, int, ...);                                                                      \
        va_list rest;                                                                                                  \
        va_start(rest, flags);                                                                                         \
        mode_t mode = va_arg(rest, mode_t);                                                                            \
        va_end(rest);                                                                                                  \
        return fails ? -1 : real(path, flags, mode);                                                                   \
    }
#define OPEN(fails) OPEN_AS(open, fails) OPEN_AS(open64, fails)

#define FOPEN_AS(name, fails)                                                                                          \
    FILE *name(const char *path, const char *mode) {                                                                   \
        REAL(FILE *, #name, const char *, const char *);                                                               \
        return fails ? NULL : real(path, mode);                                                                        \
    }
#define FOPEN(fails) FOPEN_AS(fopen, fails) FOPEN_AS(fopen64, fails)

/* Locks by fcntl. */
#define FCNTL_AS(name, fails)                                                                                          \
    int name(int fd, int command, ...) {                                                                               \
        REAL(int, #name, int, int, ...);                                                                               \
        va_list rest;                                                                                                  \
        va_start(rest, command);                                                                                       \
        void *argument = va_arg(rest, void *);                                                                         \
        va_end(rest);                                                                                                  \
        const bool lock =                                                                                              \
            command == F_SETLK || command == F_SETLKW || command == F_OFD_SETLK || command == F_OFD_SETLKW;            \
        return lock && (fails) ? -1 : real(fd, command, argument);                                                     \
    }
#define FCNTL(fails) FCNTL_AS(fcntl, fails) FCNTL_AS(fcntl64, fails)
