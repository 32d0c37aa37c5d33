/* sonopack bench: run time against error of the methods. */
#include "base/base.h"
#include "cli/bench.h"
#include "cli/springs.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

enum { PACKINGS_MAX = 16, REPEATS_MAX = 15, DENSE_DOFS = 6000 };

typedef struct arguments {
    cli_common common;
    int packings;
    const char *packing[PACKINGS_MAX];
    double until;
    unsigned cases; /* bits of the cases that run on a network */
    bool pack;      /* time the making of packings */
} arguments;

/* What is timed, on one network. Returns the error of the result, relative. */
typedef struct job {
    const sp_network *net;
    sp_signal_options signal;
    const sp_signal *exact; /* signal to compare with, NULL: the result's own bound */
    double peak;
} job;
typedef sp_status (*job_run)(const job *j, double *error, sp_error *err);

static double peak_of(const sp_signal *s) {
    double peak = 0;
    for (int32_t l = 0; l < s->n; l++)
        peak = fmax(peak, fabs(s->f[l]));
    return peak;
}

static sp_status run_signal(const job *j, double *error, sp_error *err) {
    sp_signal s = sp_signal_none();
    sp_status status = sp_signal_make(j->net, &j->signal, &s, err);
    if (status == SP_OK) {
        double worst = j->exact ? 0 : s.error;
        for (int32_t l = 0; j->exact && l < s.n; l++)
            worst = fmax(worst, fabs(s.f[l] - j->exact->f[l]));
        *error = worst / (j->exact ? j->peak : peak_of(&s));
    }
    sp_signal_free(&s);
    return status;
}

static sp_status run_modes(const job *j, bool vectors, double *error, sp_error *err) {
    const sp_modes_options o = {.vectors = vectors, .source = SP_SOURCE_IMPULSE};
    sp_modes m = sp_modes_none();
    sp_status status = sp_modes_dense(j->net, &o, &m, err);
    *error = 0;
    for (int64_t k = 0; status == SP_OK && k < m.n; k++)
        if (m.omega[k] > 0)
            *error = fmax(*error, m.error[k] / m.omega[k]);
    sp_modes_free(&m);
    return status;
}

static sp_status run_vectors(const job *j, double *error, sp_error *err) { return run_modes(j, true, error, err); }
static sp_status run_frequencies(const job *j, double *error, sp_error *err) { return run_modes(j, false, error, err); }

static sp_status run_moduli(const job *j, double *error, sp_error *err) {
    sp_moduli m;
    sp_status status = sp_moduli_make(j->net, NAN, &m, err);
    if (status == SP_OK)
        *error = m.residual;
    return status;
}

/* Median CPU time of up to REPEATS_MAX runs, fewer of long ones. */
static sp_status measure_time(job_run run, const job *j, double *seconds, double *error, sp_error *err) {
    double each[REPEATS_MAX], total = 0;
    int count = 0;
    while (count < REPEATS_MAX && (count < 3 || total < 1)) {
        const double start = sp_clock_cpu();
        sp_status status = run(j, error, err);
        if (status != SP_OK)
            return status;
        each[count] = sp_clock_cpu() - start;
        total += each[count++];
    }
    *seconds = bench_median(count, each);
    return SP_OK;
}

/* Growth of the largest resident set in a process of its own, in MB; NAN where that cannot be had. */
static double measure_memory(job_run run, const job *j) {
    int ends[2];
    double megabytes = NAN;
    if (pipe(ends) != 0)
        return NAN;
    const pid_t child = fork();
    if (child == 0) {
        struct rusage before, after;
        double error;
        getrusage(RUSAGE_SELF, &before);
        const bool good = run(j, &error, NULL) == SP_OK;
        getrusage(RUSAGE_SELF, &after);
        megabytes = good ? (double)(after.ru_maxrss - before.ru_maxrss) / 1024 : NAN;
        _exit(write(ends[1], &megabytes, sizeof megabytes) == sizeof megabytes ? 0 : 1);
    }
    close(ends[1]);
    if (child < 0 || read(ends[0], &megabytes, sizeof megabytes) != sizeof megabytes)
        megabytes = NAN;
    close(ends[0]);
    if (child > 0)
        waitpid(child, NULL, 0);
    return megabytes;
}

typedef struct row {
    const char *name, *packing, *method;
    double parameter;
} row;

static sp_status add_row(const row *r, job_run run, const job *j, sp_table *t, sp_error *err) {
    char name[256];
    double seconds = NAN, error = NAN;
    const char *slash = strrchr(r->packing, '/');
    snprintf(name, sizeof name, "%s:%s", r->name, slash ? slash + 1 : r->packing);
    const double memory = measure_memory(run, j);
    sp_status status = measure_time(run, j, &seconds, &error, err);
    if (status == SP_OK)
        status = sp_table_add_row(t, err, name, r->method, r->parameter, seconds, error, memory);
    return status;
}

static sp_status bench_signal(const arguments *a, const char *packing, const sp_network *net, sp_table *t,
                              sp_error *err) {
    static const double tolerances[] = {1e-3, 1e-6, 1e-9, 1e-10, 1e-11};
    sp_signal exact = sp_signal_none();
    job j = {.net = net, .signal = sp_signal_options_default()};
    sp_status status = SP_OK;
    j.signal.until = a->until;
    if (sp_network_dofs(net) <= DENSE_DOFS) {
        j.signal.method = SP_SIGNAL_DENSE;
        j.signal.tolerance = 1e-6;
        status = sp_signal_make(net, &j.signal, &exact, err);
        if (status == SP_OK)
            status = add_row(&(row){"signal", packing, "dense", NAN}, run_signal, &j, t, err);
        j.exact = &exact;
        j.peak = peak_of(&exact);
    }
    j.signal.method = SP_SIGNAL_CHEBYSHEV;
    for (size_t k = 0; k < sizeof tolerances / sizeof *tolerances && status == SP_OK; k++) {
        j.signal.tolerance = tolerances[k];
        status = add_row(&(row){"signal", packing, "chebyshev", tolerances[k]}, run_signal, &j, t, err);
    }
    sp_signal_free(&exact);
    return status;
}

static sp_status bench_modes(const arguments *a, const char *packing, const sp_network *net, sp_table *t,
                             sp_error *err) {
    const job j = {.net = net};
    (void)a;
    sp_status status = add_row(&(row){"modes", packing, "vectors", NAN}, run_vectors, &j, t, err);
    return status == SP_OK ? add_row(&(row){"modes", packing, "frequencies", NAN}, run_frequencies, &j, t, err)
                           : status;
}

static sp_status bench_moduli(const arguments *a, const char *packing, const sp_network *net, sp_table *t,
                              sp_error *err) {
    const job j = {.net = net};
    (void)a;
    return add_row(&(row){"moduli", packing, "cholesky", NAN}, run_moduli, &j, t, err);
}

static const struct bench_case {
    const char *name;
    sp_status (*run)(const arguments *, const char *, const sp_network *, sp_table *, sp_error *);
} cases[] = {{"signal", bench_signal}, {"modes", bench_modes}, {"moduli", bench_moduli}};
enum { CASES = sizeof cases / sizeof *cases };

enum { KEY_PACKING = 0x1000, KEY_UNTIL };
static const struct argp_option options[] = {
    {"packing", KEY_PACKING, "FILE", 0, "Packing to run on (repeatable; those of packings/reference)", 0},
    {"until", KEY_UNTIL, "T", 0, "Last time of the signals (400)", 0},
    {0}};
static const struct argp_child children[] = {{&cli_common_argp, 0, "Common options:", 90}, {0}};

static error_t parse(int key, char *arg, struct argp_state *state) {
    arguments *a = state->input;
    sp_error err = {0};
    unsigned bit = 0;
    switch (key) {
    case ARGP_KEY_INIT: state->child_inputs[0] = &a->common; return 0;
    case KEY_PACKING:
        if (a->packings == PACKINGS_MAX)
            argp_error(state, "--packing: must be given %d times at the most", PACKINGS_MAX);
        a->packing[a->packings++] = arg;
        return 0;
    case KEY_UNTIL:
        if (cli_number("--until", arg, 1e-9, 1e9, &a->until, &err) != SP_OK)
            argp_error(state, "%s", err.text);
        return 0;
    case ARGP_KEY_ARG:
        for (unsigned k = 0; k < CASES; k++)
            if (strcmp(arg, cases[k].name) == 0)
                bit = 1u << k;
        if (strcmp(arg, "pack") == 0)
            a->pack = true;
        else if (!bit)
            argp_error(state, "no case %.60s: must be signal, modes, moduli or pack", arg);
        a->cases |= bit;
        return 0;
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp argp = {
    options,
    parse,
    "[CASE...]",
    "Run time against error. Cases: signal, modes, moduli (these if none is named), and pack: the making of packings "
    "at "
    "1e-4 .. 1e-7, of 600 grains or as --set says (a minute).\v"
    "seconds: median CPU time; error: of a signal its largest difference from the dense sum over the peak (of the "
    "dense sum itself its own bound), of modes the largest bound of a frequency's relative error, of moduli the "
    "relative residual, of packings the largest acceleration over p (five seeds); parameter: the tolerance, or p; "
    "memory_MB: growth of the resident set.",
    children,
    NULL,
    NULL};

static sp_status add_columns(sp_table *t, sp_error *err) {
    static const char *const names[] = {"case", "method", "parameter", "seconds", "error", "memory_MB"};
    sp_status status = SP_OK;
    for (int k = 0; k < 6 && status == SP_OK; k++)
        status = sp_table_add_column(t, names[k],
                                     k == 3   ? "s"
                                     : k == 5 ? "MB"
                                              : "",
                                     k < 2 ? SP_CELL_TEXT : SP_CELL_NUMBER, err);
    return status;
}

static sp_status bench_packing(const arguments *a, const char *path, sp_table *t, sp_error *err) {
    const sp_network_options o = sp_network_options_default();
    sp_packing p;
    sp_network net;
    sp_status status = cli_read_network(path, &o, &p, &net, err);
    for (unsigned k = 0; k < CASES && status == SP_OK; k++) {
        if (!(a->cases & 1u << k))
            continue;
        cli_note(&a->common, "%s of %s", cases[k].name, path);
        status = cases[k].run(a, path, &net, t, err);
    }
    sp_network_free(&net);
    sp_packing_free(&p);
    return status;
}

static sp_status work(const arguments *a, sp_error *err) {
    sp_table t = sp_table_none();
    sp_scene scene = sp_scene_default();
    sp_status status = cli_may_write_table(&a->common, err);
    if (status == SP_OK && a->common.sets > 0 && !a->pack)
        status = sp_fail(err, SP_EINVAL, "--set %.60s: of the cases only pack takes keys", a->common.set[0]);
    if (status == SP_OK)
        status = sp_scene_read(NULL, a->common.sets, a->common.set, &scene, err);
    if (status == SP_OK)
        status = add_columns(&t, err);
    for (int k = 0; k < a->packings && a->cases && status == SP_OK; k++)
        status = bench_packing(a, a->packing[k], &t, err);
    if (status == SP_OK && a->pack)
        status = bench_pack(&a->common, &scene, &t, err);
    if (status == SP_OK)
        status = cli_write_table(&a->common, &t, err);
    sp_scene_free(&scene);
    sp_table_free(&t);
    return status;
}

int cmd_bench(int argc, char **argv) {
    static const char *const reference[] = {"packings/reference/packing_N200_p1e-4.txt",
                                            "packings/reference/packing_N600_p1e-4.txt"};
    arguments a = {.until = 400};
    argp_parse(&argp, argc, argv, 0, NULL, &a);
    if (a.packings == 0)
        for (; a.packings < 2; a.packings++)
            a.packing[a.packings] = reference[a.packings];
    if (a.cases == 0 && !a.pack)
        a.cases = (1u << CASES) - 1;
    sp_error err = {0};
    return work(&a, &err) == SP_OK ? CLI_OK : cli_fail(&err);
}
