/* sonopack pack: one packing of a scene. */
#include "base/base.h"
#include "cli/output.h"

#include <math.h>
#include <stdio.h>

typedef struct arguments {
    cli_common common;
    const char *scene;
    int64_t seed;
    bool seed_given;
} arguments;

enum { KEY_SEED = 0x1000 };

static const struct argp_option options[] = {{"seed", KEY_SEED, "S", 0, "Seed of the random streams", 0}, {0}};
static const struct argp_child children[] = {{&cli_common_argp, 0, "Common options:", 90}, {0}};

static error_t parse(int key, char *arg, struct argp_state *state) {
    arguments *a = state->input;
    sp_error err;
    switch (key) {
    case ARGP_KEY_INIT: state->child_inputs[0] = &a->common; return 0;
    case KEY_SEED:
        if (cli_integer("--seed", arg, 0, INT64_MAX, &a->seed, &err) != SP_OK)
            argp_error(state, "%s", err.text);
        a->seed_given = true;
        return 0;
    case ARGP_KEY_ARG:
        if (a->scene)
            argp_error(state, "%s: one scene only", arg);
        a->scene = arg;
        return 0;
    case ARGP_KEY_END:
        if (!a->scene && a->common.sets == 0)
            argp_error(state, "no scene: must be a scene file, or --set KEY=VALUE");
        if (!a->common.output)
            argp_error(state, "no output: must be -o FILE.h5 or -o FILE.txt");
        return 0;
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp argp = {
    options,
    parse,
    "[SCENE] -o FILE",
    "Makes one packing of a scene, and prints what it is.\v"
    "FILE ends in .h5 (HDF5) or .txt (text). Without SCENE all keys have their defaults but those of --set.\n\n"
    "  sonopack pack packings/single.cfg --seed 7 -o P.h5\n"
    "  sonopack pack --set packing.grains=200 --set packing.pressure=1e-5 -o P.txt",
    children,
    NULL,
    NULL};

static bool watch(const sp_pack_progress *progress, void *user) {
    char text[120];
    snprintf(text, sizeof text, "%s: %lld steps, height %.4g, residual %.2g", progress->phase,
             (long long)progress->steps, progress->height, progress->residual);
    cli_progress(user, text, -1, NAN);
    return !cli_stopped();
}

/* The summary on stdout; --format holds for it, -o is the packing's. */
static sp_status summarise(const arguments *a, const sp_scene *scene, const sp_packing *p, sp_error *err) {
    cli_common print = a->common;
    print.output = NULL;
    sp_table t = sp_table_none();
    sp_statics statics;
    int32_t rattlers = 0;
    const double threshold = scene->network.threshold;
    sp_status status = sp_packing_rattlers(p, threshold, NULL, NULL, &rattlers, err);
    if (status == SP_OK)
        status = sp_statics_make(p, threshold, 3, &statics, err);
    if (status != SP_OK)
        return status;
    const struct {
        const char *name, *unit;
        sp_cell_kind kind;
    } columns[] = {{"grains", "", SP_CELL_INTEGER},   {"height", "d", SP_CELL_NUMBER},
                   {"p", "E*", SP_CELL_NUMBER},       {"z_star", "", SP_CELL_NUMBER},
                   {"rattlers", "", SP_CELL_INTEGER}, {"residual", "E* / (rho d)", SP_CELL_NUMBER},
                   {"steps", "", SP_CELL_INTEGER},    {"seconds", "s", SP_CELL_NUMBER}};
    for (size_t c = 0; c < sizeof columns / sizeof *columns && status == SP_OK; c++)
        status = sp_table_add_column(&t, columns[c].name, columns[c].unit, columns[c].kind, err);
    if (status == SP_OK)
        status = sp_table_add_row(&t, err, (int64_t)p->n, sp_packing_height(p), p->pressure, statics.zs,
                                  (int64_t)rattlers, p->residual, p->steps, p->seconds);
    if (status == SP_OK)
        status = cli_write_table(&print, &t, err);
    sp_table_free(&t);
    return status;
}

static sp_status make(const arguments *a, sp_scene *scene, sp_packing *p, sp_error *err) {
    cli_catch_signals();
    sp_status status = sp_packing_make(&scene->pack, watch, (void *)(uintptr_t)&a->common, p, err);
    cli_progress_end(&a->common);
    if (status == SP_EINTERRUPTED)
        return sp_fail(err, status, "stopped before the packing was at rest: nothing is written, start it again");
    if (status != SP_OK || p->scene)
        return status;
    p->scene = sp_scene_text(scene, "packing");
    return p->scene ? SP_OK : sp_fail_memory(err, 1024);
}

static sp_status work(const arguments *a, sp_scene *scene, sp_packing *p, sp_error *err) {
    const char *path = a->common.output;
    const bool text = cli_has_ending(path, ".txt");
    if (!text && !cli_has_ending(path, ".h5") && !cli_has_ending(path, ".hdf5"))
        return sp_fail(err, SP_EINVAL, "-o %s: a packing's ending must be .h5 or .txt", path);
    sp_status status = cli_may_write(&a->common, path, err);
    if (status == SP_OK)
        status = sp_scene_read(a->scene, a->common.sets, a->common.set, scene, err);
    if (status != SP_OK)
        return status;
    if (a->seed_given)
        scene->pack.seed = (uint64_t)a->seed;
    if (scene->sweeps > 0)
        cli_note(&a->common, "study.sweep is not used by pack: one packing is made, see `sonopack help study'");
    status = make(a, scene, p, err);
    if (status == SP_OK)
        status = text ? sp_packing_save_text(p, path, err) : sp_packing_save(p, path, err);
    return status == SP_OK ? summarise(a, scene, p, err) : status;
}

int cmd_pack(int argc, char **argv) {
    arguments a = {0};
    argp_parse(&argp, argc, argv, 0, NULL, &a);
    sp_error err = {0};
    sp_scene scene = sp_scene_default();
    sp_packing p = sp_packing_none();
    sp_status status = work(&a, &scene, &p, &err);
    sp_packing_free(&p);
    sp_scene_free(&scene);
    return status == SP_OK ? CLI_OK : cli_fail(&err);
}
