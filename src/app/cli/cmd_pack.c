/* sonopack pack: one packing of a scene. */
#include "base/base.h"
#include "cli/output.h"
#include "cli/pack_state.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

typedef struct arguments {
    cli_common common;
    const char *scene;
    int64_t seed;
    bool seed_given;
    double every;
} arguments;

enum { KEY_SEED = 0x1000, KEY_EVERY };

static const struct argp_option options[] = {
    {"seed", KEY_SEED, "S", 0, "Seed of the random streams", 0},
    {"state-every", KEY_EVERY, "SECONDS", 0, "Keep the state of the making so often (10)", 0},
    {0}};
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
    case KEY_EVERY:
        if (cli_number("--state-every", arg, 0, 1e9, &a->every, &err) != SP_OK)
            argp_error(state, "%s", err.text);
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
    "FILE ends in .h5 (HDF5) or .txt (text). Without SCENE all keys have their defaults but those of --set. A making "
    "that was ended, by whatever, goes on when the same command is given again: its state is kept in FILE.state. With "
    "packing.history the packing at each of its pressures is written beside FILE (P.stage1.h5).\n\n"
    "  sonopack pack packings/single.cfg --seed 7 -o P.h5\n"
    "  sonopack pack --set packing.grains=200 --set packing.pressure=1e-5 -o P.txt",
    children,
    NULL,
    NULL};

/* A making under way. */
typedef struct making {
    const arguments *arguments;
    sp_scene *scene;
    pack_state state;
    double begun, first_fraction; /* clock and progress at the start */
    double logged_at;
    const char *phase; /* in the log */
    bool stopping;     /* the user wants it to stop; it may go on to the first state that can be kept */
    double stop_begun; /* processor time then: a busy machine gets there later */
} making;

/* A making of which no state is kept yet may go on for so many seconds of its processor's time, so that what was made
 * till then is not lost. */
#define TO_FIRST_STATE 5.0

static bool may_stop(making *m) {
    if (!m->stopping) {
        m->stopping = true;
        m->stop_begun = sp_clock_cpu();
    }
    return pack_state_has(&m->state) || sp_clock_cpu() - m->stop_begun > TO_FIRST_STATE;
}

static bool watch(const sp_pack_progress *progress, void *user) {
    making *m = user;
    const cli_common *common = &m->arguments->common;
    const double now = sp_clock_wall(), done = progress->fraction - m->first_fraction;
    char text[120];
    if (m->first_fraction < 0)
        m->first_fraction = progress->fraction;
    snprintf(text, sizeof text, "%s: strain %.4f, residual %.2g", progress->phase, progress->strain,
             progress->residual);
    const double left = now - m->begun > 1 && done > 0.02 ? (now - m->begun) * (1 - progress->fraction) / done : NAN;
    cli_progress(common, text, progress->fraction, left);
    if (!isatty(STDERR_FILENO) && (!m->phase || strcmp(m->phase, progress->phase) != 0 || now - m->logged_at > 5)) {
        cli_debug(common, "%s, %lld steps, %.0f%%", text, (long long)progress->steps, 100 * progress->fraction);
        m->phase = progress->phase;
        m->logged_at = now;
    }
    return !cli_stopped() || !may_stop(m);
}

static sp_status keep_state(const void *state, size_t size, void *user, sp_error *err) {
    making *m = user;
    return pack_state_take(&m->state, state, size, err);
}

/* "P.h5" becomes "P.stage1.h5". */
static sp_status stage_path(const char *path, int32_t index, char out[SP_PATH_MAX], sp_error *err) {
    const char *dot = strrchr(path, '.');
    const int length = snprintf(out, SP_PATH_MAX, "%.*s.stage%d%s", (int)(dot - path), path, index + 1, dot);
    return length > 0 && length < SP_PATH_MAX
               ? SP_OK
               : sp_fail(err, SP_EINVAL, "-o: a name of %d bytes: must be below %d", length, SP_PATH_MAX);
}

static sp_status save_packing(const sp_packing *p, const char *path, sp_error *err) {
    return cli_has_ending(path, ".txt") ? sp_packing_save_text(p, path, err) : sp_packing_save(p, path, err);
}

/* The scene of a stage is that whose history ends there. */
static sp_status save_stage(const sp_packing *stage, int32_t index, void *user, sp_error *err) {
    making *m = user;
    char path[SP_PATH_MAX];
    sp_scene scene = *m->scene;
    sp_packing p = *stage;
    scene.pack.pressure = stage->pressure;
    scene.pack.history_count = index;
    p.scene = sp_scene_text(&scene, "packing");
    if (!p.scene)
        return sp_fail_memory(err, 1024);
    sp_status status = stage_path(m->arguments->common.output, index, path, err);
    if (status == SP_OK)
        status = save_packing(&p, path, err);
    sp_free(p.scene);
    m->state.due = true; /* or a new start would find this file in its way */
    return status;
}

static sp_status may_write_stages(const making *m, sp_error *err) {
    cli_common common = m->arguments->common;
    common.force = common.force || m->state.found;
    sp_status status = SP_OK;
    for (int32_t k = 0; k < m->scene->pack.history_count && status == SP_OK; k++) {
        char path[SP_PATH_MAX];
        status = stage_path(common.output, k, path, err);
        if (status == SP_OK)
            status = cli_may_write(&common, path, err);
    }
    return status;
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

static sp_status make(making *m, const sp_packing *from, sp_packing *p, sp_error *err) {
    const cli_common *common = &m->arguments->common;
    const sp_pack_hooks hooks = {.watch = watch,
                                 .user = m,
                                 .threads = common->threads,
                                 .save = keep_state,
                                 .state = m->state.found,
                                 .state_size = m->state.found_size,
                                 .from = from,
                                 .stage = save_stage};
    cli_catch_signals();
    m->begun = sp_clock_wall();
    m->first_fraction = -1;
    sp_status status = sp_packing_make_with(&m->scene->pack, &hooks, p, err);
    cli_progress_end(common);
    if (status == SP_EINTERRUPTED) {
        status = pack_state_stop(&m->state, err);
        if (status != SP_OK)
            return status;
        if (m->state.kept)
            return sp_fail(err, SP_EINTERRUPTED,
                           "stopped before the packing was at rest: its state is kept in %s, the same command goes on "
                           "from there",
                           m->state.path);
        return sp_fail(err, SP_EINTERRUPTED,
                       "stopped before the packing was at rest: nothing is written, start it again");
    }
    if (status != SP_OK || p->scene)
        return status;
    p->scene = sp_scene_text(m->scene, "packing");
    return p->scene ? SP_OK : sp_fail_memory(err, 1024);
}

static sp_status make_and_save(making *m, const sp_packing *from, sp_packing *p, sp_error *err) {
    const arguments *a = m->arguments;
    sp_status status = pack_state_open(&a->common, &m->scene->pack, a->every, &m->state, err);
    if (status == SP_OK)
        status = may_write_stages(m, err);
    if (status == SP_OK)
        status = make(m, from, p, err);
    if (status == SP_OK)
        status = save_packing(p, a->common.output, err);
    if (status == SP_OK)
        pack_state_done(&m->state);
    pack_state_free(&m->state);
    return status;
}

static sp_status work(const arguments *a, sp_scene *scene, sp_packing *p, sp_error *err) {
    const char *path = a->common.output;
    if (!cli_has_ending(path, ".txt") && !cli_has_ending(path, ".h5") && !cli_has_ending(path, ".hdf5"))
        return sp_fail(err, SP_EINVAL, "-o %s: a packing's ending must be .h5 or .txt", path);
    sp_status status = cli_may_write(&a->common, path, err);
    if (status == SP_OK)
        status = sp_scene_read(a->scene, a->common.sets, a->common.set, scene, err);
    if (status == SP_OK)
        status = sp_scene_resolve(scene, err); /* the height that a study keeps for its sweeps */
    if (status != SP_OK)
        return status;
    if (a->seed_given)
        scene->pack.seed = (uint64_t)a->seed;
    if (scene->sweeps > 0)
        cli_note(&a->common, "sweeps are not used by pack: one packing is made, see `sonopack help study'");
    sp_packing from = sp_packing_none();
    making m = {.arguments = a, .scene = scene};
    if (scene->pack.kind == SP_PACK_FILE)
        status = cli_load_start(scene, &from, err);
    if (status == SP_OK)
        status = make_and_save(&m, &from, p, err);
    sp_packing_free(&from);
    return status == SP_OK ? summarise(a, scene, p, err) : status;
}

int cmd_pack(int argc, char **argv) {
    arguments a = {.every = 10};
    argp_parse(&argp, argc, argv, 0, NULL, &a);
    sp_error err = {0};
    sp_scene scene = sp_scene_default();
    sp_packing p = sp_packing_none();
    sp_status status = work(&a, &scene, &p, &err);
    sp_packing_free(&p);
    sp_scene_free(&scene);
    return status == SP_OK ? CLI_OK : cli_fail(&err);
}
