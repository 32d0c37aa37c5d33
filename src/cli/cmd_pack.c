/* sonopack pack: compresses one packing of a scene and saves it. */
#include "base/base.h"
#include "base/file.h"
#include "cli/files.h"
#include "cost/remaining.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct pack_state {
    const cli_common *common;
    char path[SP_PATH_MAX];   /* "": no state is saved */
    double every, written_at; /* seconds between two writes, and the clock at the last one */
    bool due;                 /* the next state is written at once */
    char *found;              /* the state at the start, which the compression continues; or NULL */
    size_t found_size;
    char *last; /* the last state that has not been written */
    size_t last_size, last_capacity;
    bool kept; /* the file has a state of this compression */
} pack_state;

static sp_status find_state(pack_state *s, const sp_pack_spec *spec, sp_error *err) {
    struct stat info;
    if (stat(s->path, &info) != 0)
        return SP_OK;
    char *data = NULL;
    size_t size = 0;
    int64_t steps = 0;
    sp_error reason = {0};
    sp_status status = S_ISREG(info.st_mode) ? sp_file_read(s->path, &data, &size, err) : SP_OK;
    if (status != SP_OK)
        return status;
    if (!data || !sp_pack_is_state(data, size)) {
        sp_free(data);
        return sp_fail(err, SP_EINVAL,
                       "%s: the state of the compression belongs in this file, which is something else and is not "
                       "replaced: choose another name for -o",
                       s->path);
    }
    if (sp_pack_state_check(spec, data, size, &steps, &reason) == SP_OK) {
        cli_note(s->common, "continues from step %lld, saved in %s", (long long)steps, s->path);
        s->found = data;
        s->found_size = size;
        s->kept = true;
        return SP_OK;
    }
    cli_note(s->common, "%s is not used: %s", s->path, reason.text);
    sp_free(data);
    return SP_OK;
}

/* Looks for the state of an earlier, equal command. */
static sp_status pack_state_open(const cli_common *common, const sp_pack_spec *spec, double every, pack_state *out,
                                 sp_error *err) {
    pack_state s = {.common = common, .every = every, .written_at = sp_clock_wall()};
    struct stat info;
    if (stat(common->output, &info) != 0 || S_ISREG(info.st_mode)) { /* not for a device or a pipe */
        const int length = snprintf(s.path, sizeof s.path, "%s.state", common->output);
        if (length < 0 || (size_t)length >= sizeof s.path)
            return sp_fail(err, SP_EINVAL, "-o: the file name has %d bytes, must have fewer than %d", length - 6,
                           SP_PATH_MAX - 6);
    }
    sp_status status = s.path[0] ? find_state(&s, spec, err) : SP_OK;
    if (status == SP_OK)
        *out = s;
    return status;
}

static sp_status write_now(pack_state *s, const void *state, size_t size, sp_error *err) {
    sp_status status = sp_file_write(s->path, state, size, err);
    s->written_at = sp_clock_wall();
    s->due = false;
    s->kept = s->kept || status == SP_OK;
    s->last_size = 0;
    return status;
}

/* Takes the present state, and writes it if it is time to. */
static sp_status pack_state_update(pack_state *s, const void *state, size_t size, sp_error *err) {
    if (!s->path[0])
        return SP_OK;
    if (s->due || sp_clock_wall() - s->written_at >= s->every)
        return write_now(s, state, size, err);
    if (size > s->last_capacity) {
        sp_free(s->last);
        s->last_capacity = size + size / 4;
        s->last = sp_alloc(s->last_capacity, 1);
        if (!s->last) {
            s->last_capacity = s->last_size = 0;
            return sp_fail_memory(err, size);
        }
    }
    memcpy(s->last, state, size);
    s->last_size = size;
    return SP_OK;
}

/* Whether the compression can be stopped without loss: a state can be written, or none is to be saved. */
static bool pack_state_is_safe(const pack_state *s) { return !s->path[0] || s->kept || s->last_size > 0; }

/* Writes the last state after the compression was stopped. */
static sp_status pack_state_flush(pack_state *s, sp_error *err) {
    return s->last_size > 0 ? write_now(s, s->last, s->last_size, err) : SP_OK;
}

/* What of LAMMPS the command line gives; the package's program reads it (python/sonopack/formats/engine.py). */
typedef struct pack_engine {
    int lammps; /* whether it is the engine */
    int64_t ranks;
    const char *program, *prepare, *collect;
} pack_engine;

static const char *const engine_words[] = {"sonopack", "lammps", NULL};

typedef struct arguments {
    cli_common common;
    double every;
    pack_engine engine;
} arguments;

static sp_status check(void *user, sp_error *err) {
    const arguments *a = user;
    const pack_engine *e = &a->engine;
    if (e->lammps)
        return SP_OK; /* checked there */
    if (e->prepare || e->collect || e->program || e->ranks > 0)
        return sp_fail(err, SP_EINVAL, "%s: needs --engine lammps",
                       e->prepare   ? "--prepare"
                       : e->collect ? "--collect"
                       : e->program ? "--lammps"
                                    : "--ranks");
    if (!a->common.output)
        return sp_fail(err, SP_EINVAL, "no output: must be -o FILE.h5 or -o FILE.txt");
    return SP_OK;
}

static const cli_option options[] = {
    {"seed", "S", "Seed of the random numbers", CLI_INTEGER, .scene = true, .key = "packing.seed"},
    {"state-every", "SECONDS", "Save the state of the compression this often (10)", CLI_NUMBER, CLI_FIELD(every),
     .high = 1e9},
    CLI_DRY_RUN,
    {.help = "Packings that LAMMPS makes (docs/cluster.md):"},
    {"engine", "sonopack|lammps", "Program that compresses the packing (sonopack)", CLI_CHOICE,
     CLI_FIELD(engine.lammps), .words = engine_words},
    {"ranks", "N", "Run LAMMPS on N ranks, by mpirun -n N", CLI_INTEGER, CLI_FIELD(engine.ranks), .low = 1,
     .high = 1000000},
    {"lammps", "PATH", "The program LAMMPS (lmp)", CLI_TEXT, CLI_FIELD(engine.program)},
    {"prepare", "DIR", "Only write the input of LAMMPS to a folder", CLI_TEXT, CLI_FIELD(engine.prepare)},
    {"collect", "DIR", "Only read what LAMMPS has made of the files of --prepare, and bring it to rest", CLI_TEXT,
     CLI_FIELD(engine.collect)},
    {0}};

const cli_syntax cmd_pack_syntax = {
    .usage = "[SCENE] -o FILE\n"
             "[SCENE] --engine lammps --prepare DIR\n"
             "--engine lammps --collect DIR -o FILE",
    .help =
        "Compresses one packing of a scene, saves it, and prints a summary.\v"
        "FILE ends in .h5 (HDF5) or .txt (text). Without SCENE all keys have their defaults, except those of --set. A "
        "warning comes before the work if the box will be lower than 6 diameters. If the compression is interrupted, "
        "the same command continues it: the state is kept in FILE.state. With packing.history the packing at each of "
        "its pressures is saved beside FILE (P.stage1.h5). So is the packing at each step of packing.path, a path of "
        "strain of a periodic cell or a box; the table then has a row for each stage, first the one before any "
        "strain: strain (of the path's largest component), volume, the stresses (compression positive), and "
        "mobilised, the share of contacts at Coulomb's limit.\n"
        "\n"
        "  sonopack pack packings/single.cfg --seed 7 -o P.h5\n"
        "  sonopack pack --set packing.grains=200 --set packing.pressure=1e-5 -o P.txt\n"
        "  sonopack pack --set packing.cell=periodic --set packing.friction=0 -o C.h5\n"
        "  sonopack pack --set packing.cell=periodic -o B.h5 \\\n"
        "      --set packing.path.strain=[0,0.02,0] --set packing.path.lateral=stress\n"
        "  sonopack pack --dry-run packings/spheres.cfg -o P.h5\n"
        "\n"
        "With --engine lammps the grains are compressed by LAMMPS (pair_style granular), for packings that need more "
        "than one machine, and come to rest here. Its files are in FILE.lammps, and stay there if something fails.",
    .options = options,
    .file_name = "scene",
    .files_max = 1,
    .check = check};

/* A compression under way. */
typedef struct compression {
    const arguments *arguments;
    sp_scene *scene;
    pack_state state;
    double begun; /* clock at the start */
    sp_remaining left;
    bool watched; /* `left' has begun */
    double logged_at;
    const char *phase; /* that was last logged */
    int32_t made;      /* stages that are saved */
    bool stopping;     /* Ctrl-C was pressed */
    double stop_begun; /* CPU time when it was */
} compression;

/* After Ctrl-C a compression may run for so many seconds of CPU time until its first state can be saved. (On a busy
 * machine this takes longer.) */
static const double first_state_time = 5;

static bool may_stop(compression *c) {
    if (!c->stopping) {
        c->stopping = true;
        c->stop_begun = sp_clock_cpu();
    }
    return c->scene->pack.kind == SP_PACK_MINIMUM || pack_state_is_safe(&c->state) ||
           sp_clock_cpu() - c->stop_begun > first_state_time;
}

/* What the cost model expects: the clock then corrects its pace. */
static void begin_countdown(compression *c, int64_t steps) {
    const sp_machine machine = sp_machine_reference();
    const sp_packing_forecast f = sp_packing_expect(&c->scene->pack, c->arguments->common.threads, &machine);
    c->left = sp_remaining_begin(f.steps, (double)steps, f.steps > 0 ? f.cost.wall / f.steps : 0);
    c->watched = true;
}

static bool watch(const sp_pack_progress *progress, void *user) {
    compression *c = user;
    const cli_common *common = &c->arguments->common;
    const double now = sp_clock_wall(), steps = (double)progress->steps;
    char text[120];
    if (!c->watched)
        begin_countdown(c, progress->steps);
    const double fraction = sp_remaining_fraction(&c->left, steps);
    snprintf(text, sizeof text, "%s: strain %.4f, residual %.2g", progress->phase, progress->strain,
             progress->residual);
    const sp_time_left left = sp_remaining_next(&c->left, now - c->begun, steps);
    cli_progress_between(common, text, fraction, left.low, left.high);
    if (!isatty(STDERR_FILENO) && (!c->phase || strcmp(c->phase, progress->phase) != 0 || now - c->logged_at > 5)) {
        cli_debug(common, "%s, %lld steps, %.0f%%", text, (long long)progress->steps, 100 * fraction);
        c->phase = progress->phase;
        c->logged_at = now;
    }
    if (!cli_stopped() || progress->steps == 0) /* while grains are placed there is nothing to keep, nor to wait for */
        return true;
    cli_stop_patiently(); /* the state is to be saved */
    return !may_stop(c);
}

static sp_status save_state(const void *state, size_t size, void *user, sp_error *err) {
    compression *c = user;
    return pack_state_update(&c->state, state, size, err);
}

/* "P.h5" becomes "P.stage1.h5". */
static sp_status stage_path(const char *path, int32_t index, char out[SP_PATH_MAX], sp_error *err) {
    const char *dot = strrchr(path, '.');
    const int length = snprintf(out, SP_PATH_MAX, "%.*s.stage%d%s", (int)(dot - path), path, index + 1, dot);
    return length > 0 && length < SP_PATH_MAX
               ? SP_OK
               : sp_fail(err, SP_EINVAL, "-o: the file name has %d bytes, must have fewer than %d", length,
                         SP_PATH_MAX);
}

/* The scene that is saved with a stage has a history, or a path, that ends there. NULL without memory. */
static char *stage_scene(const sp_scene *whole, const sp_packing *stage, int32_t index) {
    sp_scene scene = *whole;
    if (index < scene.pack.history_count) {
        scene.pack.pressure = stage->pressure;
        scene.pack.history_count = index;
        scene.pack.strain_count = scene.pack.stages = 0;
    } else {
        scene.pack.stages = index + 1;
    }
    return sp_scene_text(&scene, "packing");
}

static sp_status save_stage(const sp_packing *stage, int32_t index, void *user, sp_error *err) {
    compression *c = user;
    char path[SP_PATH_MAX];
    sp_packing p = *stage;
    p.material = c->scene->material;
    p.scene = stage_scene(c->scene, stage, index);
    if (!p.scene)
        return sp_fail_memory(err, 1024);
    sp_status status = stage_path(c->arguments->common.output, index, path, err);
    CLI_THEN(status, cli_save_packing(&p, path, err));
    sp_free(p.scene);
    c->made = index + 1;
    c->state.due = true; /* a run that is stopped soon goes on from here */
    return status;
}

/* Reads a stage. SP_EFAILED if it is that of another scene; text files have none. */
static sp_status read_stage(const sp_scene *scene, const char *output, int32_t index, sp_packing *p, sp_error *err) {
    char path[SP_PATH_MAX], *text = NULL;
    sp_status status = stage_path(output, index, path, err);
    CLI_THEN(status, sp_packing_read(path, p, err));
    if (status == SP_OK && !(text = stage_scene(scene, p, index)))
        status = sp_fail_memory(err, 1024);
    if (status == SP_OK && p->scene && strcmp(p->scene, text) != 0)
        status = sp_fail(err, SP_EFAILED, "%s: is of another scene: must be stage %d of this one", path, index + 1);
    sp_free(text);
    return status;
}

/* A stage of the same scene may be written again: it is of a run that was interrupted. */
static sp_status may_write_stages(const compression *c, sp_error *err) {
    const cli_common *common = &c->arguments->common;
    sp_status status = SP_OK;
    for (int32_t k = 0; k < sp_pack_stages(&c->scene->pack) - 1 && status == SP_OK; k++) {
        char path[SP_PATH_MAX];
        sp_packing p = sp_packing_none();
        sp_error other = {0};
        status = stage_path(common->output, k, path, err);
        if (status == SP_OK && !common->force && !c->state.found && access(path, F_OK) == 0 &&
            (read_stage(c->scene, common->output, k, &p, &other) != SP_OK || !p.scene))
            status = cli_may_write(common, path, err);
        sp_packing_free(&p);
    }
    return status;
}

/* What the rows of a path have of the statics. */
static const char *stresses(int dim) {
    return dim == 3 ? "s_xx s_yy s_zz s_yz s_xz s_xy mobilised" : "s_xx s_yy s_xy mobilised";
}

/* Where a packing is on the path of strain, and its stress. */
static void add_path(const sp_pack_spec *spec, const sp_packing *p, const sp_statics *statics, int32_t stage,
                     cli_writer *w) {
    cli_put(w, stage + 1);
    cli_put(w, sp_pack_stage_strain(spec, stage));
    cli_put(w, sp_packing_volume(p));
    cli_put_quantities(w, sp_statics_quantities, stresses(p->dim), statics);
}

static void add_summary(const sp_scene *scene, const sp_packing *p, int32_t stage, cli_writer *w) {
    sp_statics statics;
    int32_t rattlers = 0;
    const double threshold = scene->network.threshold;
    CLI_THEN(w->status, sp_packing_rattlers(p, threshold, NULL, NULL, &rattlers, w->err));
    CLI_THEN(w->status, sp_statics_make(p, threshold, 3, &statics, w->err));
    if (w->status != SP_OK)
        return;
    cli_put(w, p->n);
    cli_put(w, sp_packing_height(p));
    cli_put(w, p->pressure);
    cli_put(w, statics.zs);
    cli_put(w, rattlers);
    cli_put(w, p->residual);
    cli_put(w, (double)p->steps);
    cli_put(w, p->seconds);
    if (scene->pack.strain_count > 0)
        add_path(&scene->pack, p, &statics, stage, w);
    cli_end_row(w);
}

static void summary_columns(const sp_scene *scene, cli_writer *w) {
    cli_columns(w, SP_COLUMN_INTEGER, "grains", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "height", "d", "p", "E*", "z_star", "", NULL);
    cli_columns(w, SP_COLUMN_INTEGER, "rattlers", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "residual", "E* / (rho d)", NULL);
    cli_columns(w, SP_COLUMN_INTEGER, "steps", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "seconds", "s", NULL);
    if (scene->pack.strain_count == 0)
        return;
    cli_columns(w, SP_COLUMN_INTEGER, "stage", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "strain", "", "volume", "d^3", NULL);
    cli_quantity_columns(w, sp_statics_quantities, stresses(scene->pack.dim));
}

/* Rows of the stages of a path before this one, which may be of an earlier run, and of the packing; NULL: there is
 * none. */
static sp_status summarise(const arguments *a, const sp_scene *scene, const sp_packing *p, int32_t before,
                           sp_error *err) {
    sp_table t = sp_table_none();
    cli_writer w = {.table = &t, .err = err};
    char strain[160] = "";
    const sp_pack_spec *spec = &scene->pack;
    for (int c = 0; c < spec->strain_count; c++)
        snprintf(strain + strlen(strain), sizeof strain - strlen(strain), "%s%.10g", c ? " " : "", spec->strain[c]);
    if (spec->strain_count > 0)
        cli_comment(&w, "path_strain = %s", strain);
    summary_columns(scene, &w);
    for (int32_t k = 0; k < before && spec->strain_count > 0 && w.status == SP_OK; k++) {
        sp_packing stage = sp_packing_none();
        w.status = read_stage(scene, a->common.output, k, &stage, err);
        CLI_THEN(w.status, (add_summary(scene, &stage, k, &w), w.status));
        sp_packing_free(&stage);
    }
    if (p && w.status == SP_OK)
        add_summary(scene, p, before, &w);
    CLI_THEN(w.status, cli_write_table_to(&a->common, NULL, &t, err));
    sp_table_free(&t);
    return w.status;
}

static sp_status compress(compression *c, const sp_packing *from, sp_packing *p, sp_error *err) {
    const cli_common *common = &c->arguments->common;
    const sp_pack_hooks hooks = {.watch = watch,
                                 .user = c,
                                 .threads = common->threads,
                                 .save = save_state,
                                 .state = c->state.found,
                                 .state_size = c->state.found_size,
                                 .from = from->n > 0 ? from : NULL,
                                 .stage = save_stage};
    cli_catch_signals(common);
    c->begun = sp_clock_wall();
    sp_status status = sp_packing_make_with(&c->scene->pack, &hooks, p, err);
    cli_progress_end();
    if (status == SP_EINTERRUPTED) {
        status = pack_state_flush(&c->state, err);
        if (status != SP_OK)
            return status;
        if (c->state.kept)
            return sp_fail(err, SP_EINTERRUPTED,
                           "stopped before the packing was at rest: its state is in %s, and the same command continues",
                           c->state.path);
        return sp_fail(err, SP_EINTERRUPTED, "stopped before the packing was at rest, and nothing was saved");
    }
    p->material = c->scene->material;
    if (status != SP_OK || p->scene)
        return status;
    p->scene = sp_scene_text(c->scene, "packing");
    return p->scene ? SP_OK : sp_fail_memory(err, 1024);
}

/* --dry-run. The stages of a history are saved beside the packing. */
static sp_status plan(const arguments *a, const sp_scene *scene, sp_error *err) {
    cli_plan plan;
    const sp_pack_spec *spec = &scene->pack;
    sp_status status = cli_plan_begin(&a->common, 1U << SP_KERNEL_STEP, &plan, err);
    if (status == SP_OK) {
        const sp_packing_forecast f = sp_packing_expect(spec, a->common.threads, &plan.machine);
        const double bytes = cli_has_ending(a->common.output, ".txt")
                                 ? sp_bytes_packing_text(spec->dim, spec->grains, f.contacts)
                                 : sp_bytes_packing(spec->dim, spec->grains, f.contacts);
        cli_comment(&plan.w, "expected: height %.3g d, %.3g steps, %.3g contacts, %.3g rattlers", f.height, f.steps,
                    f.contacts, f.rattlers);
        cli_plan_add(&plan, "packing", 1, f.cost, bytes);
        const int32_t before = sp_pack_stages(spec) - 1;
        if (before > 0)
            cli_plan_add(&plan, spec->strain_count > 0 ? "packings on the way" : "packings of the history", before,
                         (sp_cost){0}, before * bytes);
        status = cli_plan_end(&plan);
    }
    cli_plan_free(&plan);
    return status;
}

/* ---- all together ------------------------------------------------------------------------------------------------ */

/* Reads the scene, and the packing that it starts from, if it names one. */
static sp_status read_scene(arguments *a, sp_scene *scene, sp_packing *from, sp_error *err) {
    const char *path = a->common.files > 0 ? a->common.file[0] : NULL;
    sp_status status = cli_read_scene(&a->common, path, scene, err);
    CLI_THEN(status, cli_set_scene(&a->common, scene, err));
    CLI_THEN(status, sp_scene_resolve(scene, err));
    if (status != SP_OK)
        return status;
    if (scene->sweeps > 0)
        cli_note(&a->common, "the scene has sweeps, but only one packing is made: see `sonopack help study'");
    if (scene->from[0])
        status = cli_load_start(scene, from, err);
    CLI_THEN(status, cli_take_material(a, &scene->material, path ? path : "the scene", err));
    cli_note_material(&a->common, scene);
    if (status == SP_OK)
        cli_warn_low_box(&a->common, &scene->pack);
    return status;
}

static sp_status make_and_save(const arguments *a, sp_scene *scene, const sp_packing *from, sp_packing *p,
                               sp_error *err) {
    compression c = {.arguments = a, .scene = scene};
    sp_status status = pack_state_open(&a->common, &scene->pack, a->every, &c.state, err);
    CLI_THEN(status, may_write_stages(&c, err));
    CLI_THEN(status, compress(&c, from, p, err));
    CLI_THEN(status, cli_save_packing(p, a->common.output, err));
    sp_free(c.state.found);
    sp_free(c.state.last);
    if (status == SP_EFAILED && c.made > 0 && scene->pack.strain_count > 0) {
        sp_error none = {0};
        summarise(a, scene, NULL, c.made, &none); /* the path ended early: what there is of it */
    }
    CLI_THEN(status, summarise(a, scene, p, sp_pack_stages(&scene->pack) - 1, err));
    if (status == SP_OK && c.state.path[0])
        unlink(c.state.path);
    return status;
}

int cmd_pack(int argc, char **argv) {
    arguments a = {.every = 10};
    cli_parse(&cmd_pack_syntax, argc, argv, &a);
    if (a.engine.lammps) {
        char name[] = "sonopack pack-lammps";
        argv[0] = name;
        return cmd_dispatch(argc, argv);
    }
    sp_error err = {0};
    sp_scene scene = sp_scene_default();
    sp_packing p = sp_packing_none(), from = sp_packing_none();
    sp_status status = a.common.output ? cli_may_write_packing(&a.common, "-o", a.common.output, &err) : SP_OK;
    CLI_THEN(status, read_scene(&a, &scene, &from, &err));
    CLI_THEN(status, a.common.dry_run ? plan(&a, &scene, &err) : make_and_save(&a, &scene, &from, &p, &err));
    sp_packing_free(&from);
    sp_packing_free(&p);
    sp_scene_free(&scene);
    return status == SP_OK ? CLI_OK : cli_fail(&err);
}
