/* sonopack table: a table of a store's samples. */
#include "base/base.h"
#include "cli/tables.h"

#include <string.h>

typedef struct arguments {
    cli_common common;
    const char *name, *scene, *store;
    cli_filter filter;
    double level;
    cli_bins bins;
    bool bins_given;
} arguments;

enum { KEY_STORE = 0x1000, KEY_WIDTH, KEY_GRAINS, KEY_PRESSURE, KEY_FRICTION, KEY_INTERVAL, KEY_BINS, KEY_UNTIL };

static const struct argp_option options[] = {
    {"store", KEY_STORE, "DIR", 0, "Folder of the samples", 0},
    {"width", KEY_WIDTH, "W", 0, "Only samples of boxes so wide [d]", 0},
    {"grains", KEY_GRAINS, "N", 0, "Only samples of so many grains", 0},
    {"pressure", KEY_PRESSURE, "P", 0, "Only samples at this pressure [E*]", 0},
    {"friction", KEY_FRICTION, "MU", 0, "Only samples with this friction", 0},
    {"interval", KEY_INTERVAL, "LEVEL", 0, "Confidence of the intervals, 0.5 to 0.999 (0.95)", 0},
    {"bins", KEY_BINS, "N", 0, "spectrum: bins of equal width (20 to 100, by the number of modes)", 0},
    {"until", KEY_UNTIL, "OMEGA", 0, "spectrum: last frequency (the largest there is, rounded up)", 0},
    {0}};
static const struct argp_child children[] = {{&cli_common_argp, 0, "Common options:", 90}, {0}};

#define TABLE_NAMES "ctof, scaling, planes, statics, moduli, probes, spectrum, ensemble or signal"

static const char *known_table(const char *name) {
    for (size_t k = 0; k < CLI_TABLES; k++)
        if (strcmp(name, cli_table_names[k]) == 0)
            return cli_table_names[k];
    return NULL;
}

static void parse_filter(cli_filter *f, int key, const char *arg, struct argp_state *state) {
    sp_error err = {0};
    sp_status status = SP_OK;
    switch (key) {
    case KEY_WIDTH: status = cli_number("--width", arg, 1e-6, 1e6, &f->width, &err); break;
    case KEY_GRAINS: status = cli_integer("--grains", arg, 1, INT32_MAX, &f->grains, &err); break;
    case KEY_PRESSURE: status = cli_number("--pressure", arg, 1e-10, 1e-2, &f->pressure, &err); break;
    default: status = cli_number("--friction", arg, 0, 1e6, &f->friction, &err); break;
    }
    if (status != SP_OK)
        argp_error(state, "%s", err.text);
}

static void parse_bins(arguments *a, int key, const char *arg, struct argp_state *state) {
    sp_error err = {0};
    int64_t bins = a->bins.bins;
    sp_status status = key == KEY_BINS ? cli_integer("--bins", arg, 1, CLI_BINS_MAX, &bins, &err)
                                       : cli_number("--until", arg, 1e-12, 1e9, &a->bins.until, &err);
    if (status != SP_OK)
        argp_error(state, "%s", err.text);
    a->bins.bins = (int32_t)bins;
    a->bins_given = true;
}

static error_t parse(int key, char *arg, struct argp_state *state) {
    arguments *a = state->input;
    switch (key) {
    case ARGP_KEY_INIT: state->child_inputs[0] = &a->common; return 0;
    case KEY_STORE: a->store = arg; return 0;
    case KEY_WIDTH:
    case KEY_GRAINS:
    case KEY_PRESSURE:
    case KEY_FRICTION: parse_filter(&a->filter, key, arg, state); return 0;
    case KEY_INTERVAL: cli_parse_interval(&a->level, arg, state); return 0;
    case KEY_BINS:
    case KEY_UNTIL: parse_bins(a, key, arg, state); return 0;
    case ARGP_KEY_ARG:
        if (a->scene)
            argp_error(state, "%s: one table and one scene only", arg);
        else if (a->name)
            a->scene = arg;
        else if (!(a->name = known_table(arg)))
            argp_error(state, "table %.60s: must be " TABLE_NAMES, arg);
        return 0;
    case ARGP_KEY_END:
        if (!a->name)
            argp_error(state, "no table: must be " TABLE_NAMES);
        if (!a->store)
            argp_error(state, "no store: must be --store DIR");
        if (a->bins_given && a->name && strcmp(a->name, "spectrum") != 0)
            argp_error(state, "--bins and --until: only the table spectrum has bins, not %s", a->name);
        if (a->common.sets > 0 && !a->scene)
            argp_error(state, "--set: needs the SCENE that made the store, whose samples it chooses");
        return 0;
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp argp = {
    options,
    parse,
    "NAME --store DIR [SCENE]",
    "Prints a table of the samples in a store.\v"
    "ctof: speed of the first front, a row a pressure. scaling: fronts over distance, with speeds and exponents, a row "
    "a height of each pressure, friction and width. planes: the same inside of packings, a row a plane, of each number "
    "of grains besides. statics, moduli, probes: means X with X_sd, one standard deviation, X_err, the standard error, "
    "and the interval X_low to X_high, a row a pressure and size. ensemble: a row a sample, with everything that is "
    "known of it. spectrum: density of states, modes for each carrying grain and unit of omega, a row a bin, with "
    "standard errors, intervals, and the integral from 0, of samples of one pressure and size (study.want with "
    "spectrum). signal: mean of the stored signals, their rms deviation from it, the standard error and the interval "
    "of the mean, a row a time, of samples of one pressure and size with signals at the same times (study.want with "
    "signal, and signal.until). With SCENE (and its --set) only the samples of that scene, at "
    "least one of which must be there (of keys that it sweeps signal and spectrum have a table a value): a store may "
    "hold several ensembles, and those that differ in more than pressure "
    "and size are not averaged. --width, --grains, --pressure and --friction choose among them.",
    children,
    NULL,
    NULL};

static sp_status work(const arguments *a, sp_scene *scene, sp_store **store, sp_error *err) {
    sp_status status = SP_OK;
    if (a->scene)
        status = sp_scene_read(a->scene, a->common.sets, a->common.set, scene, err);
    if (status == SP_OK)
        status = sp_scene_check_sweeps(scene, err);
    cli_tables tables = {.common = &a->common,
                         .scene = a->scene ? scene : NULL,
                         .needs_samples = true,
                         .count = 1,
                         .name = {a->name},
                         .filter = a->filter,
                         .level = a->level,
                         .bins = a->bins};
    if (status == SP_OK)
        status = cli_tables_may_write(&tables, err);
    if (status == SP_OK)
        status = sp_store_open(a->store, false, store, err);
    return status == SP_OK ? cli_tables_write(&tables, *store, err) : status;
}

int cmd_table(int argc, char **argv) {
    arguments a = {.filter = cli_filter_none(), .level = sp_table_options_default().level, .bins = cli_bins_default()};
    argp_parse(&argp, argc, argv, 0, NULL, &a);
    sp_error err = {0};
    sp_scene scene = sp_scene_default();
    sp_store *store = NULL;
    sp_status status = work(&a, &scene, &store, &err);
    if (store)
        sp_store_close(store);
    sp_scene_free(&scene);
    return status == SP_OK ? CLI_OK : cli_fail(&err);
}
