/* What `pack --engine lammps' does: the folder of a run, progress, and what is saved. */
#include "cli/pack_engine.h"
#include "base/base.h"
#include "base/file.h"
#include "base/text.h"
#include "cli/pack_run.h"
#include "foreign/engine.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

const char *const pack_engine_words[] = {"sonopack", "lammps", NULL};

sp_status pack_engine_check(const pack_engine *e, const cli_common *common, bool seed_given, sp_error *err) {
    const bool lammps = e->engine == PACK_ENGINE_LAMMPS;
    const char *const option = e->prepare ? "--prepare" : e->collect ? "--collect" : e->lammps ? "--lammps" : "--ranks";
    if (!lammps && (e->prepare || e->collect || e->lammps || e->ranks > 0))
        return sp_fail(err, SP_EINVAL, "%s: needs --engine lammps", option);
    if (e->prepare && e->collect)
        return sp_fail(err, SP_EINVAL, "--prepare and --collect: must be two commands, with LAMMPS between them");
    if ((e->prepare || e->collect) && (e->lammps || e->ranks > 0))
        return sp_fail(err, SP_EINVAL, "%s: does not run LAMMPS, so that --lammps and --ranks are not for it", option);
    if (e->prepare && common->output)
        return sp_fail(err, SP_EINVAL, "--prepare: makes no packing, -o is not for it but for --collect");
    if (e->collect && (common->files > 0 || common->sets > 0 || seed_given))
        return sp_fail(err, SP_EINVAL,
                       "--collect: takes the scene and the seed of --prepare from %s/%s: no others may be given",
                       e->collect, sp_engine_names[SP_ENGINE_SCENE]);
    if (lammps && common->dry_run)
        return sp_fail(err, SP_EINVAL, "--dry-run: what LAMMPS will take is not known, --engine must be sonopack");
    return SP_OK;
}

/* ---- folder ----------------------------------------------------------------------------------------------------- */

static sp_status run_folder(const cli_common *common, char *out, sp_error *err) {
    const int length = snprintf(out, SP_PATH_MAX, "%s.lammps", common->output);
    return length > 0 && length < SP_PATH_MAX - 32
               ? SP_OK
               : sp_fail(err, SP_EINVAL, "-o: the name has %d bytes, must have fewer", length);
}

/* Whether the folder has one of our files. */
static bool has_files(const char *folder) {
    char path[SP_PATH_MAX];
    for (int k = 0; k < SP_ENGINE_FILES; k++)
        if (sp_engine_path(folder, (sp_engine_file)k, path, NULL) == SP_OK && access(path, F_OK) == 0)
            return true;
    return false;
}

static void remove_files(const char *folder) {
    char path[SP_PATH_MAX];
    for (int k = 0; k < SP_ENGINE_FILES; k++)
        if (sp_engine_path(folder, (sp_engine_file)k, path, NULL) == SP_OK)
            unlink(path);
}

/* Makes the folder. One that has files of a run is only used again with --force. */
static sp_status make_folder(const cli_common *common, const char *folder, sp_error *err) {
    struct stat info;
    if (mkdir(folder, 0777) == 0)
        return SP_OK;
    if (errno != EEXIST)
        return sp_fail(err, SP_EIO, "%s: the folder cannot be made: %s", folder, strerror(errno));
    if (stat(folder, &info) != 0 || !S_ISDIR(info.st_mode))
        return sp_fail(err, SP_EIO, "%s: must be a folder, for the files of LAMMPS", folder);
    if (!has_files(folder))
        return SP_OK;
    if (!common->force)
        return sp_fail(err, SP_EIO,
                       "%s: has the files of a run of LAMMPS: --collect %s reads them, --force replaces them", folder,
                       folder);
    remove_files(folder);
    return SP_OK;
}

static sp_status save_scene(const sp_scene *scene, const char *folder, sp_error *err) {
    char path[SP_PATH_MAX];
    sp_status status = sp_engine_path(folder, SP_ENGINE_SCENE, path, err);
    char *text = status == SP_OK ? sp_scene_text(scene, NULL) : NULL;
    if (status == SP_OK)
        status = text ? sp_file_write(path, text, strlen(text), err) : sp_fail_memory(err, 1024);
    sp_free(text);
    return status;
}

static sp_status prepare(const cli_common *common, const sp_scene *scene, const char *folder, sp_error *err) {
    sp_status status = sp_engine_check(&scene->pack, err);
    if (status == SP_OK)
        status = make_folder(common, folder, err);
    if (status == SP_OK)
        status = sp_engine_write(&scene->pack, folder, err);
    return status == SP_OK ? save_scene(scene, folder, err) : status;
}

sp_status pack_engine_prepare(const pack_engine *e, const cli_common *common, sp_scene *scene, sp_error *err) {
    sp_status status = prepare(common, scene, e->prepare, err);
    if (status == SP_OK)
        cli_note(common,
                 "%s: run `lmp -nocite -in %s' there (mpirun -n N before it), then `sonopack pack --engine lammps "
                 "--collect %s'",
                 e->prepare, sp_engine_names[SP_ENGINE_INPUT], e->prepare);
    return status;
}

sp_status pack_engine_scene(const pack_engine *e, char *path, sp_error *err) {
    return sp_engine_path(e->collect, SP_ENGINE_SCENE, path, err);
}

/* ---- run -------------------------------------------------------------------------------------------------------- */

static bool watch(const sp_pack_progress *progress, void *user) {
    char text[120];
    snprintf(text, sizeof text, "%s: %lld steps, residual %.2g", progress->phase, (long long)progress->steps,
             progress->residual);
    cli_progress(user, text, -1, 0.0 / 0.0);
    if (cli_stopped())
        cli_stop_patiently(); /* LAMMPS needs some seconds to end */
    return !cli_stopped();
}

/* The scene as it is saved with the packing: another engine would make another packing of it. */
static sp_status give_scene(const sp_scene *scene, const sp_engine_result *r, int64_t ranks, sp_packing *p,
                            sp_error *err) {
    sp_text t = {0};
    char *text = sp_scene_text(scene, "packing");
    sp_text_add(&t, "# engine: LAMMPS (%s)", r->version);
    if (ranks > 0)
        sp_text_add(&t, ", %lld ranks", (long long)ranks);
    sp_text_add(&t, ", %lld steps; brought to rest by sonopack %s\n%s", (long long)r->steps, sp_version(),
                text ? text : "");
    sp_free(p->scene);
    p->scene = text && !t.failed ? t.data : NULL;
    if (!p->scene)
        sp_text_free(&t);
    sp_free(text);
    return p->scene ? SP_OK : sp_fail_memory(err, 1024);
}

/* Runs LAMMPS in the folder, if there is nothing to collect, and reads what it has made. */
static sp_status run(const pack_engine *e, cli_common *common, const sp_scene *scene, const char *folder,
                     sp_packing *out, sp_error *err) {
    double seconds = 0;
    sp_engine_result result;
    const sp_engine_run lammps = {
        .program = e->lammps, .ranks = (int)e->ranks, .folder = folder, .watch = watch, .user = common};
    const sp_pack_hooks hooks = {.watch = watch, .user = common, .threads = common->threads};
    sp_status status = e->collect ? SP_OK : sp_engine_execute(&lammps, &seconds, err);
    if (status == SP_OK)
        status = sp_engine_collect(&scene->pack, folder, &hooks, out, &result, err);
    cli_progress_end();
    if (status != SP_OK)
        return status;
    out->seconds += seconds;
    out->material = scene->material;
    return give_scene(scene, &result, e->ranks, out, err);
}

sp_status pack_engine_make(const pack_engine *e, const cli_common *common, sp_scene *scene, sp_packing *out,
                           sp_error *err) {
    char folder[SP_PATH_MAX], found[2][SP_PATH_MAX];
    cli_common shown = *common;
    sp_status status = run_folder(common, folder, err);
    if (status != SP_OK)
        return status;
    const sp_engine_run lammps = {.program = e->lammps, .ranks = (int)e->ranks};
    if (!e->collect)
        status = sp_engine_find(&lammps, found[0], found[1], err);
    if (status == SP_OK && !e->collect)
        status = prepare(common, scene, folder, err);
    if (status != SP_OK)
        return status;
    cli_catch_signals(common);
    status = run(e, &shown, scene, e->collect ? e->collect : folder, out, err);
    if (status != SP_OK) {
        status = sp_fail_prefix(err, "the files are in %s", e->collect ? e->collect : folder);
        if (status == SP_EINVAL) /* the command line was right */
            err->status = SP_EFAILED;
        return err->status;
    }
    return status;
}

void pack_engine_clean(const pack_engine *e, const cli_common *common) {
    char folder[SP_PATH_MAX];
    if (e->collect || run_folder(common, folder, NULL) != SP_OK)
        return;
    remove_files(folder);
    rmdir(folder);
}
