/* What signals do to the command: most commands end at once; those that have something to keep stop in their own time,
 * but not in much more than a second. */
#include "cli/cli.h"

#include "base/file.h"

#include <errno.h>
#include <signal.h>
#include <stdatomic.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* Seconds of CPU time in which a command that is to stop looks at cli_stopped, or is ended. (On a busy machine this
 * takes longer.) */
static const double PATIENCE = 0.9;
/* A process that has worked for less than this in a second waits, for a pipe that nobody opens or for a disk. */
static const double ASLEEP = 1e-3;

static atomic_int stop_signal; /* the first one; 0: none */
static atomic_bool catching, quiet, terminal, patient;
static double begun, looked; /* CPU times of the stop and of the last look at it; of the handlers alone */

/* ---- handlers: only calls that are safe there -------------------------------------------------------------------- */

static double cpu_time(void) {
    struct timespec t = {0};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void say(const char *line) {
    static const char clear[] = "\r\033[K"; /* the line of progress */
    ssize_t put = 0;
    if (!atomic_load(&quiet) && atomic_load(&terminal))
        put = write(STDERR_FILENO, clear, strlen(clear));
    if (!atomic_load(&quiet))
        put = write(STDERR_FILENO, line, strlen(line));
    (void)put; /* nothing is left to do if nobody reads it */
}

/* Ends the process as the signal does by default, so that a shell sees it and ends its loops. */
static void end_by(int number) {
    sigset_t set;
    sp_drafts_abandon();
    signal(number, SIG_DFL);
    sigemptyset(&set);
    sigaddset(&set, number);
    pthread_sigmask(SIG_UNBLOCK, &set, NULL);
    raise(number);
    _exit(128 + number); /* the first process of a container has no defaults */
}

static void stop(int number) {
    const int kept = errno;
    int none = 0;
    if (!atomic_load(&catching) || number == SIGPIPE)
        end_by(number);
    if (atomic_compare_exchange_strong(&stop_signal, &none, number)) {
        say("sonopack: stopping; a second signal ends the command at once\n");
        begun = looked = cpu_time();
        if (!atomic_load(&patient))
            alarm(1);
    } else if (number != SIGXCPU) /* which comes every second */
        end_by(number);
    errno = kept;
}

/* A second after the stop, and after each look at it. */
static void look(int number) {
    const double now = cpu_time();
    if (!cli_stopped())
        end_by(number);
    if (atomic_load(&patient))
        return;
    if (now - begun >= PATIENCE || now - looked < ASLEEP) {
        say("sonopack: ended in the midst of its work; finished files are kept\n");
        sp_drafts_abandon();
        _exit(CLI_FAILED);
    }
    looked = now;
    alarm(1);
}

/* ---- for the commands -------------------------------------------------------------------------------------------- */

/* A signal that the caller has us ignore (nohup, a background job) stays ignored. */
static void catch (int number, void (*handler)(int)) {
    struct sigaction before, action = {.sa_handler = handler, .sa_flags = SA_RESTART};
    sigfillset(&action.sa_mask);
    if (sigaction(number, NULL, &before) == 0 && before.sa_handler != SIG_IGN)
        sigaction(number, &action, NULL);
}

void cli_signals_begin(void) {
    static const int signals[] = {SIGINT, SIGTERM, SIGHUP, SIGXCPU, SIGPIPE};
    for (size_t k = 0; k < sizeof signals / sizeof *signals; k++)
        catch (signals[k], stop);
    signal(SIGXFSZ, SIG_IGN); /* a file that grows too large is an error like others */
}

void cli_catch_signals(const cli_common *common) {
    atomic_store(&quiet, common->quiet);
    atomic_store(&terminal, isatty(STDERR_FILENO) != 0);
    catch (SIGALRM, look);
    atomic_store(&catching, true);
}

bool cli_stopped(void) { return atomic_load(&stop_signal) != 0; }

void cli_stop_patiently(void) {
    atomic_store(&patient, true);
    alarm(0);
}
