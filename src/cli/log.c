/* Prints messages and progress on stderr. */
#include "cli/cli.h"

#include "base/base.h"

#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

static const double log_interval = 60; /* seconds between progress lines when stderr is no terminal */
enum { LINE = 79 };                    /* columns of a progress line on a terminal */

/* Of the thread that says what a command does which tells nothing itself, and of all others. */
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static bool progress_shown; /* a progress line is on the terminal */
static double told_at;      /* when it was written, or a message */

static void clear_progress(void) {
    if (progress_shown)
        fputs("\r\033[K", stderr);
    progress_shown = false;
}

/* One line, without the control characters of names and of texts from files: a terminal would obey them. */
static void print_line(char *line) {
    sp_text_tame(line, "");
    pthread_mutex_lock(&lock);
    clear_progress();
    fprintf(stderr, "sonopack: %s\n", line);
    told_at = sp_clock_wall();
    pthread_mutex_unlock(&lock);
}

int cli_fail(const sp_error *err) {
    char line[sizeof err->text];
    snprintf(line, sizeof line, "%s", err->text[0] ? err->text : sp_status_name(err->status));
    print_line(line);
    return err->status == SP_EINVAL ? CLI_USAGE : CLI_FAILED;
}

int cli_usage(const char *format, ...) {
    char line[8192]; /* room for two names of files */
    va_list args;
    va_start(args, format);
    vsnprintf(line, sizeof line, format, args);
    va_end(args);
    print_line(line);
    return CLI_USAGE;
}

static void duration_text(double seconds, char *buf, size_t size) {
    const long s = lround(seconds);
    if (s >= 3600)
        snprintf(buf, size, "%ld h %02ld min", s / 3600, s / 60 % 60);
    else if (s >= 60)
        snprintf(buf, size, "%ld min %02ld s", s / 60, s % 60);
    else
        snprintf(buf, size, "%ld s", s);
}

/* "1 to 3 s": a unit that both ends have alone is written once. */
static void range_text(double low, double high, char *buf, size_t size) {
    char least[32], most[32];
    duration_text(low, least, sizeof least);
    duration_text(high, most, sizeof most);
    if (strcmp(least, most) == 0)
        snprintf(buf, size, ", %s left", most);
    else if (high < 60)
        snprintf(buf, size, ", %ld to %s left", lround(low), most);
    else
        snprintf(buf, size, ", %s to %s left", least, most);
}

/* The fraction done, as a bar in what a text leaves of the line of a terminal, and the remaining time if it is known.
 */
static void progress_text(double fraction, double low, double high, int room, char *buf, size_t size) {
    enum { WIDEST = 20 };
    char bar[64] = "", left[80] = "";
    const double done = fmin(fmax(fraction, 0), 1);
    if (low >= 0 && high < 1e8)
        range_text(low, high, left, sizeof left);
    const int width = (int)fmin(WIDEST, fmax(0, room - (int)strlen(left) - 8)), full = (int)(done * width);
    if (fraction >= 0 && width >= 4)
        snprintf(bar, sizeof bar, " [%.*s%.*s] %3d%%", full, "====================", width - full,
                 "                    ", (int)(100 * done));
    else if (fraction >= 0)
        snprintf(bar, sizeof bar, ", %d%%", (int)(100 * done));
    snprintf(buf, size, "%s%s", bar, left);
}

/* A line in place of the one before on a terminal; elsewhere a line. The lock is held. */
static void show(const char *line, bool terminal) {
    told_at = sp_clock_wall();
    progress_shown = terminal;
    fprintf(stderr, terminal ? "\r\033[K%.*s" : "sonopack: %.*s\n", terminal ? LINE : 240, line);
    fflush(stderr);
}

void cli_progress_between(const cli_common *common, const char *text, double fraction, double low, double high) {
    static double shown_at, logged_at = -INFINITY;
    const double now = sp_clock_wall();
    char line[240], state[140];
    if (common->quiet)
        return;
    const bool terminal = isatty(STDERR_FILENO);
    if (terminal ? progress_shown && now - shown_at < 0.1 : !common->verbose || now - logged_at < log_interval)
        return;
    progress_text(fraction, low, high, terminal ? LINE - (int)strlen(text) : 0, state, sizeof state);
    snprintf(line, sizeof line, "%.90s%s", text, state);
    sp_text_tame(line, "");
    pthread_mutex_lock(&lock);
    show(line, terminal);
    pthread_mutex_unlock(&lock);
    shown_at = logged_at = now;
}

void cli_progress_end(void) {
    pthread_mutex_lock(&lock);
    clear_progress();
    pthread_mutex_unlock(&lock);
}

/* ---- commands that tell nothing themselves ----------------------------------------------------------------------- */

static bool watching; /* under the lock */

static void tell_time(const char *command, double begun) {
    char line[120], time[32];
    struct rusage used = {0};
    duration_text(sp_clock_wall() - begun, time, sizeof time);
    getrusage(RUSAGE_SELF, &used);
    snprintf(line, sizeof line, "%s: %s so far, %.2g GB of memory", command, time, (double)used.ru_maxrss * 1.024e-6);
    show(line, isatty(STDERR_FILENO));
}

/* A second after the other, until the command prints what it has computed. A line is written where nothing else was
 * for so long that one may ask whether the program still works. */
static void *watch(void *command) {
    const double begun = sp_clock_wall(), silence = isatty(STDERR_FILENO) ? 2 : log_interval / 2;
    const struct timespec second = {.tv_sec = 1};
    double next = begun + silence;
    for (bool on = true; on; nanosleep(&second, NULL)) {
        pthread_mutex_lock(&lock);
        on = watching;
        const double now = sp_clock_wall();
        if (on && now >= fmax(next, told_at + silence)) {
            tell_time(command, begun);
            next = now + (isatty(STDERR_FILENO) ? 1 : log_interval);
            told_at = now - silence; /* what comes from here is no reason to wait */
        }
        pthread_mutex_unlock(&lock);
    }
    return NULL;
}

void cli_watch(const cli_common *common, const char *command) {
    static char name[64];
    pthread_t thread;
    pthread_attr_t small;
    sigset_t all, before;
    if (common->quiet || (!isatty(STDERR_FILENO) && !common->verbose) || pthread_attr_init(&small) != 0)
        return;
    snprintf(name, sizeof name, "%s", command);
    sigfillset(&all); /* signals are for the thread that works */
    pthread_sigmask(SIG_SETMASK, &all, &before);
    pthread_attr_setdetachstate(&small, PTHREAD_CREATE_DETACHED);
    pthread_attr_setstacksize(&small, 1 << 17);
    pthread_mutex_lock(&lock);
    watching = pthread_create(&thread, &small, watch, name) == 0;
    pthread_mutex_unlock(&lock);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    pthread_attr_destroy(&small);
}

void cli_watch_end(void) {
    pthread_mutex_lock(&lock);
    watching = false;
    clear_progress();
    pthread_mutex_unlock(&lock);
}
