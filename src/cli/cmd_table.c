/* sonopack table: a table of a store's samples. */
#include "base/base.h"
#include "cli/tables.h"

#include <string.h>

typedef struct arguments {
    cli_common common;
    const char *name, *scene, *store;
} arguments;

enum { KEY_STORE = 0x1000 };

static const struct argp_option options[] = {{"store", KEY_STORE, "DIR", 0, "Folder of the samples", 0}, {0}};
static const struct argp_child children[] = {{&cli_common_argp, 0, "Common options:", 90}, {0}};

static const char *known_table(const char *name) {
    static const char *const names[] = {"ctof", "statics", "moduli", "ensemble"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++)
        if (strcmp(name, names[k]) == 0)
            return names[k];
    return NULL;
}

static error_t parse(int key, char *arg, struct argp_state *state) {
    arguments *a = state->input;
    switch (key) {
    case ARGP_KEY_INIT: state->child_inputs[0] = &a->common; return 0;
    case KEY_STORE: a->store = arg; return 0;
    case ARGP_KEY_ARG:
        if (a->scene)
            argp_error(state, "%s: one table and one scene only", arg);
        else if (a->name)
            a->scene = arg;
        else if (!(a->name = known_table(arg)))
            argp_error(state, "table %.60s: must be ctof, statics, moduli or ensemble", arg);
        return 0;
    case ARGP_KEY_END:
        if (!a->name)
            argp_error(state, "no table: must be ctof, statics, moduli or ensemble");
        if (!a->store)
            argp_error(state, "no store: must be --store DIR");
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
    "ctof: speed of the first front, a row a pressure. statics, moduli: means and standard deviations, a row a "
    "pressure and size. ensemble: a row a sample, with everything that is known of it. With SCENE (and its --set) only "
    "the samples of that scene, at least one of which must be there: a store may hold several ensembles, and those "
    "that differ in more than pressure and size are not averaged.",
    children,
    NULL,
    NULL};

static sp_status work(const arguments *a, sp_scene *scene, sp_store **store, sp_error *err) {
    sp_status status = SP_OK;
    if (a->scene)
        status = sp_scene_read(a->scene, a->common.sets, a->common.set, scene, err);
    if (status == SP_OK)
        status = sp_scene_check_sweeps(scene, err);
    cli_tables tables = {
        .common = &a->common, .scene = a->scene ? scene : NULL, .needs_samples = true, .count = 1, .name = {a->name}};
    if (status == SP_OK)
        status = cli_tables_may_write(&tables, err);
    if (status == SP_OK)
        status = sp_store_open(a->store, false, store, err);
    return status == SP_OK ? cli_tables_write(&tables, *store, err) : status;
}

int cmd_table(int argc, char **argv) {
    arguments a = {0};
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
