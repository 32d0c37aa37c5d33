/* Measures time and memory of a run, and compares `auto' with the fastest method. */
#include "base/base.h"
#include "cli/bench.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

enum { REPEATS_MAX = 401 };

/* The result of the runs, which a child process sends. */
typedef struct outcome {
    sp_status status;
    double seconds, error, megabytes;
    sp_error reason;
} outcome;

static double largest_resident(void) {
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)usage.ru_maxrss / 1024;
}

/* Measures the memory of the first run and the time of all: 15 runs, fewer if they take longer than is given, and more
 * if they are short, so that other work of the machine averages out. */
static void run_all(const bench_row *row, double seconds, outcome *o) {
    double each[REPEATS_MAX], total = 0;
    int count = 0;
    memset(o, 0, sizeof *o);
    const double before = largest_resident();
    while (o->status == SP_OK &&
           (count == 0 || (count < REPEATS_MAX && total < seconds && (count < 15 || total < 0.4 * seconds)))) {
        const double start = sp_clock_cpu();
        o->status = row->run(row->job, &o->error, &o->reason);
        each[count] = sp_clock_cpu() - start;
        total += each[count++];
        if (count == 1)
            o->megabytes = largest_resident() - before;
    }
    o->seconds = bench_median(count, each);
}

static bool read_all(int end, void *to, size_t size) {
    char *at = to;
    while (size > 0) {
        const ssize_t got = read(end, at, size);
        if (got <= 0)
            return false;
        at += got;
        size -= (size_t)got;
    }
    return true;
}

/* Runs in a child process, because memory that an earlier run has freed would hide the growth. If there can be no
 * child, it runs here, and the memory is NAN. */
static void run_apart(const bench_row *row, double seconds, outcome *o) {
    int ends[2];
    bool received = false;
    if (pipe(ends) == 0) {
        const pid_t child = fork();
        if (child == 0) {
            run_all(row, seconds, o);
            _exit(write(ends[1], o, sizeof *o) == (ssize_t)sizeof *o ? 0 : 1);
        }
        close(ends[1]);
        received = child > 0 && read_all(ends[0], o, sizeof *o);
        close(ends[0]);
        if (child > 0)
            waitpid(child, NULL, 0);
    }
    if (!received) {
        run_all(row, seconds, o);
        o->megabytes = NAN;
    }
}

sp_status bench_measure(const bench_subject *s, const bench_row *row, sp_error *err) {
    char name[256];
    outcome o;
    snprintf(name, sizeof name, "%s:%s", row->name, s->name);
    run_apart(row, s->seconds, &o);
    if (o.status == SP_EREFUSED) {
        cli_note(s->common, "%s, %s %g: %s", name, row->method, row->parameter, o.reason.text);
        return SP_OK;
    }
    if (o.status != SP_OK) {
        *err = o.reason;
        return o.status;
    }
    return sp_table_add_row(s->table, err, name, row->method, row->parameter, o.seconds, o.error, o.megabytes);
}

enum { CASE = 0, METHOD, PARAMETER, SECONDS, ERROR };

/* The shortest time among the rows of the same case whose error is at most the tolerance of row `of`; for modes, among
 * all of them. */
static double fastest(const sp_table *t, int64_t of) {
    const char *name = t->cells[of * t->columns + CASE].text;
    const double asked = sp_table_number(t, of, PARAMETER);
    double best = HUGE_VAL;
    for (int64_t row = 0; row < t->rows; row++)
        if (strcmp(t->cells[row * t->columns + CASE].text, name) == 0 &&
            strcmp(t->cells[row * t->columns + METHOD].text, "auto") != 0 && !(sp_table_number(t, row, ERROR) > asked))
            best = fmin(best, sp_table_number(t, row, SECONDS));
    return best;
}

sp_status bench_compare_auto(sp_table *t, sp_error *err) {
    int64_t worst = -1;
    double most = 0;
    for (int64_t row = 0; row < t->rows; row++) {
        if (strcmp(t->cells[row * t->columns + METHOD].text, "auto") != 0)
            continue;
        const double ratio = sp_table_number(t, row, SECONDS) / fastest(t, row);
        if (ratio > most) {
            most = ratio;
            worst = row;
        }
    }
    if (worst < 0)
        return SP_OK;
    return sp_table_add_comment(t, err, "auto = %.2f times the fastest at the most (%s, %g)", most,
                                t->cells[worst * t->columns + CASE].text, sp_table_number(t, worst, PARAMETER));
}
