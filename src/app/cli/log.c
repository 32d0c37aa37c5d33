/* Prints messages and progress on stderr. */
#include "cli/cli.h"

#include "base/base.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const double log_interval = 60; /* seconds between progress lines when stderr is no terminal */

static bool progress_shown; /* a progress line is on the terminal */

static void clear_progress(void) {
    if (progress_shown)
        fputs("\r\033[K", stderr);
    progress_shown = false;
}

static void say(const char *format, va_list args) {
    clear_progress();
    fputs("sonopack: ", stderr);
    vfprintf(stderr, format, args);
    fputc('\n', stderr);
}

int cli_fail(const sp_error *err) {
    clear_progress();
    fprintf(stderr, "sonopack: %s\n", err->text[0] ? err->text : sp_status_name(err->status));
    return err->status == SP_EINVAL ? CLI_USAGE : CLI_FAILED;
}

int cli_usage(const char *format, ...) {
    va_list args;
    va_start(args, format);
    say(format, args);
    va_end(args);
    return CLI_USAGE;
}

void cli_note(const cli_common *common, const char *format, ...) {
    if (common->quiet)
        return;
    va_list args;
    va_start(args, format);
    say(format, args);
    va_end(args);
}

void cli_debug(const cli_common *common, const char *format, ...) {
    if (!common->verbose)
        return;
    va_list args;
    va_start(args, format);
    say(format, args);
    va_end(args);
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

void cli_progress(const cli_common *common, const char *text, double fraction, double seconds_left) {
    cli_progress_between(common, text, fraction, seconds_left, seconds_left);
}

void cli_progress_between(const cli_common *common, const char *text, double fraction, double low, double high) {
    enum { LINE = 79 };
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
    if (!terminal) {
        fprintf(stderr, "sonopack: %s\n", line);
        logged_at = now;
        return;
    }
    fprintf(stderr, "\r\033[K%.*s", LINE, line);
    fflush(stderr);
    progress_shown = true;
    shown_at = now;
}

void cli_progress_end(void) { clear_progress(); }
