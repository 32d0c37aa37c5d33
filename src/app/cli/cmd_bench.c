/* sonopack bench: measures run time against error of the methods. */
#include "base/base.h"
#include "cli/bench.h"
#include "cli/files.h"

#include <math.h>
#include <string.h>

enum { PACKINGS_MAX = 16 };

typedef struct arguments {
    cli_common common;
    int packings;
    const char *packing[PACKINGS_MAX];
    double until, seconds;
    unsigned cases; /* bits of the cases that run on a network */
    bool pack;      /* measure the compression of packings */
} arguments;

static const struct bench_case {
    const char *name;
    sp_status (*run)(const bench_subject *, sp_error *);
} cases[] = {{"signal", bench_signal}, {"long", bench_long},   {"many", bench_many},
             {"damped", bench_damped}, {"modes", bench_modes}, {"moduli", bench_moduli}};
enum { CASES = sizeof cases / sizeof *cases };

/* The default networks: two files, and two packings that are made here. */
static const char *const reference[] = {"packings/reference/packing_N200_p1e-4.txt",
                                        "packings/reference/packing_N600_p1e-4.txt"};
static const struct made {
    const char *name;
    sp_pack_kind kind;
    int32_t grains;
    double width;
} made[] = {{"piston30", SP_PACK_PISTON, 30, 6}, {"lattice3600", SP_PACK_TRIANGULAR, 3600, 60}};
enum { REFERENCES = sizeof reference / sizeof *reference, MADE = sizeof made / sizeof *made };

static sp_status add_packing(void *user, const char *text, sp_error *err) {
    arguments *a = user;
    if (a->packings == PACKINGS_MAX)
        return sp_fail(err, SP_EINVAL, "--packing: may be given at most %d times", PACKINGS_MAX);
    a->packing[a->packings++] = text;
    return SP_OK;
}

static sp_status read_cases(void *user, sp_error *err) {
    arguments *a = user;
    for (int k = 0; k < a->common.files; k++) {
        const char *word = a->common.file[k];
        unsigned bit = 0;
        for (unsigned c = 0; c < CASES; c++)
            if (strcmp(word, cases[c].name) == 0)
                bit = 1u << c;
        a->cases |= bit;
        a->pack = a->pack || strcmp(word, "pack") == 0;
        if (!bit && strcmp(word, "pack") != 0)
            return sp_fail(err, SP_EINVAL, "no case %.60s: must be signal, long, many, damped, modes, moduli or pack",
                           word);
    }
    if (a->common.files == 0)
        a->cases = (1u << CASES) - 1;
    return SP_OK;
}

static const char *case_word(int k) { return k < CASES ? cases[k].name : k == CASES ? "pack" : NULL; }

static const cli_option options[] = {
    {"packing", "FILE", "Packing to measure, instead of the four (repeatable)", .parse = add_packing},
    {"until", "T", "Last time of the signals (400)", CLI_NUMBER, .field = offsetof(arguments, until), .low = 1e-9,
     .high = 1e9},
    {"seconds", "S", "CPU time that is spent on a row; less is less exact (1)", CLI_NUMBER,
     .field = offsetof(arguments, seconds), .low = 0.01, .high = 1e4},
    {0}};

static const cli_syntax syntax = {
    .usage = "[CASE...]",
    .help =
        "Measures run time against error, on two packings of packings/reference, one of 30 grains and a lattice of "
        "3600. Cases: signal (all methods and parameters), long (up to 10^6 over the largest frequency, small "
        "networks only), many (from 12 grains to 12 others), damped, modes (the 10 and the 100 lowest, all, and all "
        "frequencies without vectors), moduli (all of these are the default), and pack: the compression of packings "
        "at 1e-4 .. 1e-7, of 600 grains or as --set says (one minute).\v"
        "seconds: median CPU time. error: for a signal, the largest difference, over the peak, from the signal of "
        "another method, the one with the smallest error bound (damped: its own bound); for modes, the largest bound "
        "for the relative error of a frequency; for moduli, the bound for C22; for packings, the largest "
        "acceleration over p (five seeds). parameter: the tolerance, the time step of verlet and lax-wendroff, or p. "
        "memory_MB: growth of the resident memory. `sonopack plot pareto' draws the table.",
    .not_si = "it measures run times and errors, which have no units of a packing",
    .options = options,
    .file_name = "case",
    .files_max = CLI_ANY_NUMBER,
    .file_word = case_word,
    .check = read_cases};

static sp_status add_columns(sp_table *t, sp_error *err) {
    cli_writer w = {.table = t, .err = err};
    cli_columns(&w, SP_COLUMN_TEXT, "case", "", "method", "", NULL);
    cli_columns(&w, SP_COLUMN_NUMBER, "parameter", "", "seconds", "s", "error", "", "memory_MB", "MB", NULL);
    return w.status;
}

static sp_status bench_network(const arguments *a, const char *name, const sp_network *net, sp_table *t,
                               sp_error *err) {
    const bench_subject s = {&a->common, name, net, a->until, a->seconds, t};
    sp_status status = SP_OK;
    for (unsigned k = 0; k < CASES && status == SP_OK; k++) {
        if (!(a->cases & 1u << k))
            continue;
        cli_note(&a->common, "%s of %s", cases[k].name, name);
        status = cases[k].run(&s, err);
    }
    return status;
}

/* Makes a packing, or reads the file if `m` is NULL, and runs the cases on its network. */
static sp_status bench_packing(const arguments *a, const struct made *m, const char *path, sp_table *t, sp_error *err) {
    const sp_network_options o = sp_network_options_default();
    const char *slash = m ? NULL : strrchr(path, '/');
    sp_pack_spec spec = sp_pack_spec_default();
    sp_packing p = sp_packing_none();
    sp_network net = sp_network_none();
    sp_status status;
    if (m) {
        spec.kind = m->kind;
        spec.grains = m->grains;
        spec.width = m->width;
        status = sp_packing_make(&spec, NULL, NULL, &p, err);
        if (status == SP_OK)
            status = sp_network_make(&p, &o, &net, err);
    } else {
        status = cli_read_network(path, &o, &p, &net, err);
    }
    if (status == SP_OK)
        status = bench_network(a, m ? m->name : slash ? slash + 1 : path, &net, t, err);
    sp_network_free(&net);
    sp_packing_free(&p);
    return status;
}

static sp_status work(const arguments *a, sp_error *err) {
    sp_table t = sp_table_none();
    sp_scene scene = sp_scene_default();
    const int files = a->packings > 0 ? a->packings : REFERENCES;
    sp_status status = cli_may_write_table(&a->common, err);
    if (status == SP_OK && a->common.sets > 0 && !a->pack)
        status = sp_fail(err, SP_EINVAL, "--set %.60s: only the case pack takes keys", a->common.set[0]);
    if (status == SP_OK)
        status = sp_scene_read(NULL, a->common.sets, a->common.set, &scene, err);
    if (status == SP_OK)
        status = add_columns(&t, err);
    for (int k = 0; k < files && a->cases && status == SP_OK; k++)
        status = bench_packing(a, NULL, a->packings > 0 ? a->packing[k] : reference[k], &t, err);
    for (int k = 0; k < MADE && a->cases && a->packings == 0 && status == SP_OK; k++)
        status = bench_packing(a, &made[k], NULL, &t, err);
    if (status == SP_OK && a->pack)
        status = bench_pack(&a->common, &scene, &t, err);
    if (status == SP_OK)
        status = bench_compare_auto(&t, err);
    if (status == SP_OK)
        status = cli_write_table(&a->common, &t, err);
    sp_scene_free(&scene);
    sp_table_free(&t);
    return status;
}

int cmd_bench(int argc, char **argv) {
    arguments a = {.until = 400, .seconds = 1};
    cli_parse(&syntax, argc, argv, &a);
    sp_error err = {0};
    return work(&a, &err) == SP_OK ? CLI_OK : cli_fail(&err);
}
