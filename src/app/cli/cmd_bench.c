/* sonopack bench: run time against error of the methods. */
#include "base/base.h"
#include "cli/bench.h"
#include "cli/springs.h"

#include <math.h>
#include <string.h>

enum { PACKINGS_MAX = 16 };

typedef struct arguments {
    cli_common common;
    int packings;
    const char *packing[PACKINGS_MAX];
    double until;
    unsigned cases; /* bits of the cases that run on a network */
    bool pack;      /* time the making of packings */
} arguments;

static const struct bench_case {
    const char *name;
    sp_status (*run)(const bench_subject *, sp_error *);
} cases[] = {{"signal", bench_signal}, {"long", bench_long},   {"many", bench_many},
             {"damped", bench_damped}, {"modes", bench_modes}, {"moduli", bench_moduli}};
enum { CASES = sizeof cases / sizeof *cases };

/* The networks where none is named: two files, and two that are made on the spot. */
static const char *const reference[] = {"packings/reference/packing_N200_p1e-4.txt",
                                        "packings/reference/packing_N600_p1e-4.txt"};
static const struct made {
    const char *name;
    sp_pack_kind kind;
    int32_t grains;
    double width;
} made[] = {{"piston30", SP_PACK_PISTON, 30, 6}, {"lattice3600", SP_PACK_TRIANGULAR, 3600, 60}};
enum { REFERENCES = sizeof reference / sizeof *reference, MADE = sizeof made / sizeof *made };

enum { KEY_PACKING = 0x1000, KEY_UNTIL };
static const struct argp_option options[] = {
    {"packing", KEY_PACKING, "FILE", 0, "Packing to run on, instead of the four (repeatable)", 0},
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
            argp_error(state, "no case %.60s: must be signal, long, many, damped, modes, moduli or pack", arg);
        a->cases |= bit;
        return 0;
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp argp = {
    options,
    parse,
    "[CASE...]",
    "Run time against error, on two packings of packings/reference, one of 30 grains and a lattice of 3600. Cases: "
    "signal (every method and parameter), long (up to 10^6 over the largest frequency, small networks only), many "
    "(from 12 grains to 12 others), damped, modes (the 10 and 100 lowest, all, and all frequencies alone), moduli "
    "(these if "
    "none is named), and pack: the making of packings at 1e-4 "
    ".. 1e-7, of 600 grains or as --set says (a minute).\v"
    "seconds: median CPU time; error: of a signal its largest difference, over the peak, from the signal of another "
    "method, the one that vouches for the least error (damped: its own bound), of modes the largest bound of a "
    "frequency's "
    "relative error, of moduli that of C22, of packings the largest acceleration over p (five seeds); parameter: the "
    "tolerance, the time step of verlet and lax-wendroff, or p; memory_MB: growth of the resident set. "
    "`sonopack plot pareto' draws the table.",
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

static sp_status bench_network(const arguments *a, const char *name, const sp_network *net, sp_table *t,
                               sp_error *err) {
    const bench_subject s = {&a->common, name, net, a->until, t};
    sp_status status = SP_OK;
    for (unsigned k = 0; k < CASES && status == SP_OK; k++) {
        if (!(a->cases & 1u << k))
            continue;
        cli_note(&a->common, "%s of %s", cases[k].name, name);
        status = cases[k].run(&s, err);
    }
    return status;
}

static sp_status bench_file(const arguments *a, const char *path, sp_table *t, sp_error *err) {
    const sp_network_options o = sp_network_options_default();
    const char *slash = strrchr(path, '/');
    sp_packing p;
    sp_network net;
    sp_status status = cli_read_network(path, &o, &p, &net, err);
    if (status == SP_OK)
        status = bench_network(a, slash ? slash + 1 : path, &net, t, err);
    sp_network_free(&net);
    sp_packing_free(&p);
    return status;
}

static sp_status bench_made(const arguments *a, const struct made *m, sp_table *t, sp_error *err) {
    const sp_network_options o = sp_network_options_default();
    sp_pack_spec spec = sp_pack_spec_default();
    sp_packing p = sp_packing_none();
    sp_network net = sp_network_none();
    spec.kind = m->kind;
    spec.grains = m->grains;
    spec.width = m->width;
    sp_status status = sp_packing_make(&spec, NULL, NULL, &p, err);
    if (status == SP_OK)
        status = sp_network_make(&p, &o, &net, err);
    if (status == SP_OK)
        status = bench_network(a, m->name, &net, t, err);
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
        status = sp_fail(err, SP_EINVAL, "--set %.60s: of the cases only pack takes keys", a->common.set[0]);
    if (status == SP_OK)
        status = sp_scene_read(NULL, a->common.sets, a->common.set, &scene, err);
    if (status == SP_OK)
        status = add_columns(&t, err);
    for (int k = 0; k < files && a->cases && status == SP_OK; k++)
        status = bench_file(a, a->packings > 0 ? a->packing[k] : reference[k], &t, err);
    for (int k = 0; k < MADE && a->cases && a->packings == 0 && status == SP_OK; k++)
        status = bench_made(a, &made[k], &t, err);
    if (status == SP_OK && a->pack)
        status = bench_pack(&a->common, &scene, &t, err);
    if (status == SP_OK)
        status = bench_judge_auto(&t, err);
    if (status == SP_OK)
        status = cli_write_table(&a->common, &t, err);
    sp_scene_free(&scene);
    sp_table_free(&t);
    return status;
}

int cmd_bench(int argc, char **argv) {
    arguments a = {.until = 400};
    argp_parse(&argp, argc, argv, 0, NULL, &a);
    if (a.cases == 0 && !a.pack)
        a.cases = (1u << CASES) - 1;
    sp_error err = {0};
    return work(&a, &err) == SP_OK ? CLI_OK : cli_fail(&err);
}
