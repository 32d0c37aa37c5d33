/* Runs another program. */
#include "cli/child.h"
#include "base/base.h"
#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

/* mpirun needs some seconds to end its ranks. */
static const double GRACE = 20;

/* ---- finding ---------------------------------------------------------------------------------------------------- */

static bool can_run(const char *path) {
    struct stat info;
    return stat(path, &info) == 0 && S_ISREG(info.st_mode) && access(path, X_OK) == 0;
}

/* The absolute path, for the program starts in another folder. */
static sp_status resolve(const char *path, char *out, sp_error *err) {
    char *full = realpath(path, NULL);
    if (!full || strlen(full) >= SP_PATH_MAX) {
        free(full);
        return sp_fail(err, SP_EIO, "%s: %s", path, strerror(full ? ENAMETOOLONG : errno));
    }
    strcpy(out, full);
    free(full);
    return SP_OK;
}

sp_status sp_child_find(const char *name, char *out, sp_error *err) {
    char path[SP_PATH_MAX];
    if (strchr(name, '/'))
        return can_run(name) ? resolve(name, out, err) : sp_fail(err, SP_EIO, "%s: no program that can be run", name);
    const char *folders = getenv("PATH");
    for (const char *at = folders ? folders : "/usr/bin:/bin"; *at;) {
        const size_t length = strcspn(at, ":");
        const int size =
            snprintf(path, sizeof path, "%.*s/%s", length > 0 ? (int)length : 1, length > 0 ? at : ".", name);
        if (size > 0 && size < SP_PATH_MAX && can_run(path))
            return resolve(path, out, err);
        at += length + (at[length] == ':');
    }
    return sp_fail(err, SP_EIO, "%s: no such program in PATH", name);
}

/* ---- starting --------------------------------------------------------------------------------------------------- */

/* In the child: only calls that are safe after fork. Sends errno through `pipe' if the program does not start. */
static void become(const char *const *words, const char *folder, const char *printed, pid_t parent, int pipe_end) {
    setpgid(0, 0);
    signal(SIGXFSZ, SIG_DFL); /* what is ignored would stay so */
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    const bool there = getppid() == parent && chdir(folder) == 0;
    const int in = open("/dev/null", O_RDONLY), out = there ? open(printed, O_WRONLY | O_CREAT | O_TRUNC, 0666) : -1;
    if (in >= 0 && out >= 0 && dup2(in, 0) == 0 && dup2(out, 1) == 1 && dup2(out, 2) == 2)
        execv(words[0], (char *const *)(uintptr_t)words);
    const int reason = errno;
    _exit(write(pipe_end, &reason, sizeof reason) == (ssize_t)sizeof reason ? 127 : 126);
}

static sp_status start(const char *const *words, const char *folder, const char *printed, pid_t *out, sp_error *err) {
    int ends[2], reason = 0;
    if (pipe2(ends, O_CLOEXEC) != 0)
        return sp_fail(err, SP_EIO, "%s: %s", words[0], strerror(errno));
    const pid_t parent = getpid(), child = fork();
    if (child == 0)
        become(words, folder, printed, parent, ends[1]);
    if (child < 0)
        reason = errno;
    close(ends[1]);
    ssize_t got = 0;
    do
        got = child > 0 ? read(ends[0], &reason, sizeof reason) : 0;
    while (got < 0 && errno == EINTR);
    close(ends[0]);
    if (child > 0 && reason == 0) {
        *out = child;
        return SP_OK;
    }
    if (child > 0)
        waitpid(child, NULL, 0);
    return sp_fail(err, SP_EIO, "%s: cannot be started: %s", words[0], strerror(reason));
}

/* ---- waiting ---------------------------------------------------------------------------------------------------- */

static double seconds_of(const struct rusage *usage) {
    return (double)(usage->ru_utime.tv_sec + usage->ru_stime.tv_sec) +
           1e-6 * (double)(usage->ru_utime.tv_usec + usage->ru_stime.tv_usec);
}

static void pause_for(double seconds) {
    const struct timespec time = {.tv_nsec = (long)(1e9 * seconds)};
    nanosleep(&time, NULL);
}

/* Whether the program has ended. */
static bool has_ended(pid_t child, sp_child_end *end) {
    int status;
    struct rusage usage;
    if (wait4(child, &status, WNOHANG, &usage) != child)
        return false;
    end->status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    end->signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    end->seconds = seconds_of(&usage);
    return true;
}

static void wait_for(pid_t child, bool (*watch)(void *user), void *user, sp_child_end *end) {
    double wait = 0.002, asked = 0;
    while (!has_ended(child, end)) {
        if (!end->stopped && watch && !watch(user)) {
            end->stopped = true;
            asked = sp_clock_wall();
            kill(-child, SIGTERM);
        }
        if (end->stopped && sp_clock_wall() - asked > GRACE)
            kill(-child, SIGKILL);
        pause_for(wait);
        wait = wait < 0.2 ? 1.5 * wait : 0.2;
    }
    kill(-child, SIGKILL); /* what it may have left */
}

sp_status sp_child_run(const char *const *words, const char *folder, const char *printed, bool (*watch)(void *user),
                       void *user, sp_child_end *end, sp_error *err) {
    pid_t child = 0;
    *end = (sp_child_end){0};
    sp_status status = start(words, folder, printed, &child, err);
    if (status == SP_OK)
        wait_for(child, watch, user, end);
    return status;
}
