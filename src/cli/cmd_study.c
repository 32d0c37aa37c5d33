/* sonopack study: computes the samples of an ensemble, keeps them in a store, and prints its tables. */
#include "base/base.h"
#include "cli/files.h"
#include "cli/ranks.h"
#include "cli/tables.h"
#include "cost/remaining.h"
#include "ensemble/sample.h"

#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct verification {
    const cli_common *common;
    sp_table table;
    int64_t samples, failed, bad; /* files: good samples, good records of failures, others */
    int64_t expected;             /* samples of the scene; 0: no scene */
    int64_t present, last;        /* how many of them have a file; the number of the last one */
    double begun;
    sp_status status; /* of the table */
    sp_error error;
} verification;

static bool found(const sp_store_finding *f, void *user) {
    verification *v = user;
    char text[120];
    const double seconds = sp_clock_wall() - v->begun, fraction = (double)f->done / (double)f->names;
    const bool sound = f->verdict == SP_SOUND;
    v->present += f->done != v->last;
    v->last = f->done;
    v->samples += sound && !f->record;
    v->failed += sound && f->record;
    v->bad += !sound;
    if (!sound) {
        sp_error fault = {0};
        cli_progress_end();
        sp_fail(&fault, SP_EFAILED, "%s: %s%s", f->file, f->reason,
                f->aside                   ? "; renamed to .bad"
                : f->verdict == SP_DAMAGED ? "; it could not be renamed"
                                           : "");
        cli_fail(&fault);
    }
    char reason[SP_ERROR_TEXT + 16];
    snprintf(reason, sizeof reason, "%s%s", sound && f->record ? "failed: " : "", *f->reason ? f->reason : "-");
    v->status =
        sp_table_add_row(&v->table, &v->error, f->file, sound ? "yes" : "no", reason, *f->field ? f->field : "-");
    snprintf(text, sizeof text, "%lld/%lld samples checked", (long long)f->done, (long long)f->names);
    cli_progress(v->common, text, fraction, seconds * (1 / fraction - 1));
    return v->status == SP_OK && !cli_stopped();
}

static sp_status scene_names(const sp_scene *scene, sp_store_check *check, char (**out)[SP_NAME_MAX], sp_error *err) {
    const int64_t count = sp_study_count(scene);
    if (count < 1)
        return sp_fail(err, SP_EINVAL, "study.sweep: no values, or more than 2^63 samples");
    char(*name)[SP_NAME_MAX] = sp_alloc((size_t)count, sizeof *name);
    if (!name)
        return sp_fail_memory(err, (size_t)count * sizeof *name);
    *out = name;
    for (int64_t k = 0; k < count; k++) {
        sp_scene one;
        sp_status status = sp_study_sample(scene, k, &one, name[k], err);
        if (status != SP_OK)
            return status;
    }
    check->names = count;
    check->name = (const char(*)[SP_NAME_MAX])name;
    return SP_OK;
}

static sp_status verify(verification *v, sp_store *store, const sp_scene *scene, double tolerance, int jobs,
                        sp_error *err) {
    sp_store_check check = {.names = -1, .tolerance = tolerance, .jobs = jobs, .found = found, .user = v};
    char(*name)[SP_NAME_MAX] = NULL;
    cli_writer w = {.table = &v->table, .err = err};
    cli_columns(&w, SP_COLUMN_TEXT, "file", "", "ok", "", "reason", "", "field", "", NULL);
    sp_status status = w.status;
    if (status == SP_OK && scene)
        status = scene_names(scene, &check, &name, err);
    if (status == SP_OK && scene)
        v->expected = check.names;
    CLI_THEN(status, sp_store_verify(store, &check, err));
    if (v->status != SP_OK) {
        status = v->status;
        *err = v->error;
    }
    sp_free(name);
    return status;
}

/* --verify: prints a table of the files of a scene's samples, or of all files of the store if scene is NULL. jobs: how
 * many samples are computed again at a time. *good: all pass. */
static sp_status verify_store(const cli_common *common, const char *dir, const sp_scene *scene, double tolerance,
                              int jobs, bool *good, sp_error *err) {
    verification v = {.common = common, .table = sp_table_none(), .begun = sp_clock_wall()};
    sp_store *store = NULL;
    sp_status status = cli_may_write_table(common, err);
    CLI_THEN(status, sp_store_open(dir, false, &store, err));
    if (status == SP_OK) {
        cli_catch_signals(common);
        status = verify(&v, store, scene, tolerance, jobs, err);
        cli_progress_end();
    }
    CLI_THEN(status, cli_write_table(common, &v.table, err));
    if (status == SP_OK)
        cli_note(common, "%lld samples are sound, %lld are recorded as failed, %lld files are not ok",
                 (long long)v.samples, (long long)v.failed, (long long)v.bad);
    if (status == SP_OK && v.expected > v.present)
        cli_note(common, "%lld of the %lld samples of the scene are not in the store",
                 (long long)(v.expected - v.present), (long long)v.expected);
    *good = v.bad == 0;
    if (store)
        sp_store_close(store);
    sp_table_free(&v.table);
    return status;
}

typedef struct arguments {
    cli_common common;
    const char *store;
    int64_t jobs; /* 0: as many as --threads */
    bool verify, retry;
    double tolerance; /* of --verify; NAN: not given */
    double level;     /* confidence level of the intervals */
    sp_study_options study;
    cli_ranks ranks;
} arguments;

static sp_status set_shard(void *user, const char *text, sp_error *err) {
    arguments *a = user;
    char first[24];
    const char *slash = strchr(text, '/');
    int64_t shard, shards;
    snprintf(first, sizeof first, "%.*s", slash ? (int)strcspn(text, "/") : 0, text);
    if (!slash || cli_integer("--shard", slash + 1, 1, INT32_MAX, &shards, NULL) != SP_OK ||
        cli_integer("--shard", first, 1, shards, &shard, NULL) != SP_OK)
        return sp_fail(err, SP_EINVAL, "--shard %.60s: must be I/N with 1 <= I <= N, as in 2/8", text);
    a->study.shard = (int)shard;
    a->study.shards = (int)shards;
    return SP_OK;
}

static sp_status check(void *user, sp_error *err) {
    const arguments *a = user;
    if (!a->verify && !isnan(a->tolerance))
        return sp_fail(err, SP_EINVAL, "--tolerance applies only to --verify");
    if (a->common.files == 0 && a->common.sets == 0 && !a->verify)
        return sp_fail(err, SP_EINVAL, "no scene: must be a scene file, or --set KEY=VALUE");
    if (!a->store)
        return sp_fail(err, SP_EINVAL, "no store: must be --store DIR");
    if (a->verify && a->common.dry_run)
        return sp_fail(err, SP_EINVAL, "--verify cannot be combined with --dry-run: it makes nothing either");
    if (a->common.dry_run && a->ranks.size > 1)
        return sp_fail(err, SP_EINVAL, "--dry-run: must run as one process, not as %d ranks", a->ranks.size);
    if (a->verify && (a->retry || a->study.shards > 1))
        return sp_fail(err, SP_EINVAL, "--verify cannot be combined with --retry or --shard");
    if (a->verify && a->ranks.size > 1)
        return sp_fail(err, SP_EINVAL, "--verify: must run as one process, not as %d ranks", a->ranks.size);
    return cli_ranks_check(&a->ranks, a->study.shards, err);
}

static const cli_option options[] = {
    {"store", "DIR", "Folder of the samples; it is created if necessary", CLI_TEXT, CLI_FIELD(store)},
    {"jobs", "N", "Number of samples computed at the same time (one per core)", CLI_INTEGER, CLI_FIELD(jobs), .low = 1,
     .high = 4096},
    {"shard", "I/N", "Compute only every N-th sample, starting with the I-th", .parse = set_shard},
    {"retry", NULL, "Try again the samples that are recorded as failed", CLI_FLAG, CLI_FIELD(retry)},
    {"verify", NULL,
     "Make no sample: compute all results of the scene's samples, or of the store, again from the stored packings, and "
     "compare",
     CLI_FLAG, CLI_FIELD(verify)},
    {"tolerance", "EPS", "With --verify: largest relative error that passes (2e-5)", CLI_NUMBER, CLI_FIELD(tolerance),
     .high = 1},
    {"interval", "LEVEL", "Confidence level of the intervals, 0.5 to 0.999 (0.95)", CLI_NUMBER, CLI_FIELD(level),
     .low = SP_LEVEL_LEAST, .high = SP_LEVEL_MOST},
    CLI_DRY_RUN,
    {0}};

const cli_syntax cmd_study_syntax = {
    .usage = "[SCENE] --store DIR",
    .help =
        "Computes every sample of a scene that is not in the store yet, and prints the tables that the scene asks "
        "for.\vA sample is identified by all that determines it. So an interrupted study continues where it stopped, "
        "and larger studies or further results reuse what is there. Several studies may share a store, and several "
        "processes may fill it at the same time. A blank line separates the tables; with -o FILE.tsv the first goes "
        "there, and the others to FILE-moduli.tsv and so on. If a key other than packing.pressure, packing.fraction, "
        "packing.stages, packing.grains, packing.height and packing.seed is swept, each of its values has tables of "
        "its own, from the second value on in FILE-ctof-2.tsv, FILE-moduli-2.tsv and so on, with the value in a "
        "comment. (Of scaling and planes, packing.width and packing.friction are not among these keys; of spectrum, "
        "all keys but packing.seed are.)\n"
        "\n"
        "Samples that cannot be computed are recorded with the reason and counted in the tables; the exit status is "
        "still 0. They would fail again in the same way, so --retry is for a new version of the program. The words "
        "packings and signal of study.want only store something, and print no table.\n"
        "\n"
        "--verify reads all files of the samples and prints a table of them: whether each is the sample of its name, "
        "and whether its packing passes `sonopack check'. A file that cannot be read, or is not the sample of its "
        "name, is renamed to NAME.bad, and the next study computes the sample again. All that follows from scene and "
        "packing is computed again, --jobs samples at a time, and compared within its errors: this takes as long as "
        "the study without its packings. A false number is named with what it must be, and its file stays. The exit "
        "status is 1 if any file fails.\n"
        "\n"
        "  sonopack study packings/ctof-quick.cfg --store results/quick\n"
        "  sonopack study big.cfg --store results/big --shard 3/16 --jobs 1\n"
        "  mpirun -n 16 sonopack study big.cfg --store results/big          (a build with -DSONOPACK_MPI=ON)",
    .options = options,
    .file_name = "scene",
    .files_max = 1,
    .check = check};

/* The tables of study.want, in the order of cli_table_names. */
static cli_tables tables_of(const cli_common *common, const sp_scene *scene) {
    static const unsigned want[] = {SP_WANT_CTOF,   SP_WANT_SCALING, SP_WANT_PLANES,  SP_WANT_STATICS,
                                    SP_WANT_MODULI, SP_WANT_PROBES,  SP_WANT_SPECTRUM};
    cli_tables tables = {.common = common, .scene = scene, .filter = cli_filter_none()};
    for (size_t k = 0; k < sizeof want / sizeof *want; k++)
        if (scene->want & want[k])
            tables.name[tables.count++] = cli_table_names[k];
    return tables;
}

/* Of the study that is made: at first what the cost model expects of it. */
static sp_remaining left;
static int side_by_side = 1;

static void show(const cli_common *common, const char *text, const sp_study_progress *now) {
    const double fraction = now->cost > 0 ? now->cost_done / now->cost : 1;
    if (left.shown < 0)
        left = sp_remaining_begin(now->cost, 0, 1.0 / side_by_side);
    left.before = now->cost_done - now->cost_computed; /* what was stored */
    if (now->done >= now->total)
        cli_progress(common, text, 1, 0);
    else if (now->done + now->elsewhere >= now->total) /* the rest depends on other processes */
        cli_progress(common, text, fraction, NAN);
    else {
        const sp_time_left t = sp_remaining_next(&left, now->seconds, now->cost_done);
        cli_progress_between(common, text, fraction, t.low, t.high);
    }
}

static bool watch(const sp_study_progress *progress, void *user) {
    sp_study_progress now = *progress;
    const bool go_on = cli_ranks_share(&now, cli_stopped());
    char text[120];
    int length = snprintf(text, sizeof text, "%lld/%lld samples", (long long)now.done, (long long)now.total);
    if (now.failed > 0)
        length += snprintf(text + length, sizeof text - (size_t)length, ", %lld failed", (long long)now.failed);
    if (now.elsewhere > 0)
        snprintf(text + length, sizeof text - (size_t)length, ", %lld in other processes", (long long)now.elsewhere);
    show(user, text, &now);
    return go_on;
}

/* Tells the other ranks what this one computes: the scene, the store and the shard. */
static sp_status announce(const arguments *a, const sp_scene *scene, sp_error *err) {
    char *text = sp_scene_text(scene, NULL), *what = NULL;
    const int size = text ? asprintf(&what, "%s\n%s\n%d/%d", text, a->store, a->study.shard, a->study.shards) : -1;
    sp_free(text);
    if (size < 0)
        return sp_fail_memory(err, 1 << 14);
    cli_ranks_begin(what);
    free(what);
    return SP_OK;
}

/* Refuses before the work what no sample could have: most results of the command lead from wall to wall, and probes
 * need the sides to be periodic too. Packings from files say it themselves. */
static sp_status check_cell(const sp_scene *scene, sp_error *err) {
    static const struct {
        unsigned part;
        const char *word;
    } wall[] = {{SP_WANT_CTOF, "ctof"},
                {SP_WANT_SCALING, "scaling"},
                {SP_WANT_PLANES, "planes"},
                {SP_WANT_SIGNAL, "signal"},
                {SP_WANT_PROBES, "probes"}};
    if (scene->pack.kind == SP_PACK_FILE || scene->pack.cell == SP_CELL_PISTON)
        return SP_OK;
    for (size_t k = 0; k < sizeof wall / sizeof *wall; k++)
        if (scene->want & wall[k].part && (scene->pack.cell == SP_CELL_PERIODIC || wall[k].part == SP_WANT_PROBES))
            return sp_fail_key(err, SP_EINVAL, "study.want",
                               ": %s needs packing.cell = \"piston\"%s; cells take statics, moduli and spectrum",
                               wall[k].word, wall[k].part == SP_WANT_PROBES ? "" : " or \"box\"");
    return SP_OK;
}

/* Reads the scene, and the packing that it starts from, if it names one. */
static sp_status read_scene(arguments *a, sp_scene *scene, sp_packing *from, sp_error *err) {
    const char *path = a->common.files > 0 ? a->common.file[0] : NULL;
    sp_status status = cli_read_scene(&a->common, path, scene, err);
    CLI_THEN(status, sp_scene_check_sweeps(scene, err));
    CLI_THEN(status, check_cell(scene, err));
    if (status == SP_OK && scene->from[0]) {
        status = cli_load_start(scene, from, err);
        a->study.from = from;
    }
    CLI_THEN(status, cli_take_material(a, &scene->material, path ? path : "the scene", err));
    if (status == SP_OK)
        cli_note_material(&a->common, scene);
    return status;
}

static void share_threads(arguments *a) {
    a->study.jobs = a->jobs > 0 ? (int)a->jobs : a->common.threads;
    a->study.threads = a->common.threads;
}

/* The tables that the scene wants, and whether -o may be written. */
static sp_status choose_tables(arguments *a, const sp_scene *scene, cli_tables *out, sp_error *err) {
    *out = tables_of(&a->common, scene);
    out->level = a->level;
    if (a->common.output && out->count == 0)
        return sp_fail(err, SP_EINVAL, "-o %s: study.want names no table", a->common.output);
    return cli_tables_may_write(out, err);
}

static sp_status plan(arguments *a, sp_scene *scene, sp_packing *from, sp_error *err) {
    cli_plan plan;
    cli_tables tables;
    sp_status status = read_scene(a, scene, from, err);
    CLI_THEN(status, choose_tables(a, scene, &tables, err));
    if (status != SP_OK)
        return status;
    share_threads(a);
    status =
        cli_plan_begin(&a->common, 1U << SP_KERNEL_STEP | 1U << SP_KERNEL_PRODUCT | 1U << SP_KERNEL_SPARSE, &plan, err);
    CLI_THEN(status, cli_plan_study(&plan, scene, &a->study, a->store, err));
    CLI_THEN(status, cli_plan_end(&plan));
    cli_plan_free(&plan);
    return status;
}

static sp_status run(arguments *a, const sp_scene *scene, sp_store *store, sp_study_progress *done, sp_error *err) {
    sp_study_sink sink = sp_store_sink(store);
    sp_store_retry(store, a->retry);
    share_threads(a);
    a->study.take = a->ranks.take;
    left = sp_remaining_begin(1, 0, 1);
    side_by_side = a->study.jobs * a->ranks.size;
    sp_status status = announce(a, scene, err);
    cli_catch_signals(&a->common);
    if (a->ranks.size > 1) /* all ranks end together */
        cli_stop_patiently();
    return status == SP_OK ? sp_study_run(scene, &a->study, &sink, watch, &a->common, done, err) : status;
}

static sp_status report(const arguments *a, sp_status status, const sp_study_progress *done, sp_error *err) {
    char ranks[40] = "";
    cli_progress_end();
    if (status == SP_EINTERRUPTED)
        return sp_fail(err, status,
                       "stopped with %lld of %lld samples done, all kept in %s: the same command continues",
                       (long long)done->done, (long long)done->total, a->store);
    if (a->ranks.size > 1)
        snprintf(ranks, sizeof ranks, " by %d ranks", a->ranks.size);
    if (status == SP_OK)
        cli_note(&a->common, "%lld samples, %lld of them made now in %.1f s%s", (long long)done->total,
                 (long long)done->computed, done->seconds, ranks);
    if (status == SP_OK && done->failed > 0)
        cli_note(&a->common, "%lld samples failed, or lack a result: see `sonopack table ensemble --store %s'",
                 (long long)done->failed, a->store);
    return status;
}

/* Checks that what was finished is still there, before the tables leave it out: somebody may have removed or damaged it
 * meanwhile, and for ranks on other machines --store might be another folder. */
static sp_status check_complete(const arguments *a, const sp_scene *scene, sp_store *store, sp_error *err) {
    const sp_study_sink sink = sp_store_sink(store);
    const int64_t count = a->ranks.rank == 0 ? sp_study_count(scene) : 0;
    int64_t missing = 0;
    sp_status status = SP_OK;
    sp_store_retry(store, false); /* those that have failed again are there too */
    for (int64_t k = a->study.shard - 1; k < count && status == SP_OK; k += a->study.shards) {
        sp_scene one;
        char name[SP_NAME_MAX];
        status = sp_study_sample(scene, k, &one, name, err);
        missing += status == SP_OK && sink.has(sink.user, &one, name) == SP_STORED_NOT;
    }
    if (status != SP_OK || missing == 0)
        return status;
    if (a->ranks.size > 1)
        return sp_fail(err, SP_EIO,
                       "rank 0 does not see %lld of the computed samples in %s: --store must be one folder that all "
                       "ranks share",
                       (long long)missing, a->store);
    return sp_fail(
        err, SP_EIO,
        "%lld of the finished samples are gone from %s, or cannot be read: the same command makes them again",
        (long long)missing, a->store);
}

/* Computes the samples, then writes their tables. All ranks call cli_ranks_join, even after a failure, so that all of
 * them learn of it. */
static sp_status make(arguments *a, sp_scene *scene, sp_packing *from, sp_store **store, sp_error *err) {
    sp_study_progress done = {0};
    cli_tables tables = {0};
    sp_status status = read_scene(a, scene, from, err);
    CLI_THEN(status, choose_tables(a, scene, &tables, err));
    CLI_THEN(status, sp_store_open(a->store, true, store, err));
    CLI_THEN(status, run(a, scene, *store, &done, err));
    status = cli_ranks_join(status, done.total > 0 ? watch : NULL, &a->common, &done, err);
    status = report(a, status, &done, err);
    CLI_THEN(status, check_complete(a, scene, *store, err));
    return status == SP_OK && tables.count > 0 && a->ranks.rank == 0 ? cli_tables_write(&tables, *store, err) : status;
}

/* argp prints messages by itself, and exits: on ranks other than 0 nothing is to be printed. */
static void read_arguments(arguments *a, int argc, char **argv) {
    int keep[2] = {-1, -1};
    for (int file = STDOUT_FILENO; a->ranks.rank > 0 && file <= STDERR_FILENO; file++) {
        const int null = open("/dev/null", O_WRONLY);
        keep[file - STDOUT_FILENO] = dup(file);
        dup2(null, file);
        close(null);
    }
    /* with several ranks, one thread each is the default */
    a->common.threads = a->ranks.size > 1 ? 1 : 0;
    cli_parse(&cmd_study_syntax, argc, argv, a);
    for (int file = STDOUT_FILENO; file <= STDERR_FILENO && a->ranks.rank > 0; file++) {
        dup2(keep[file - STDOUT_FILENO], file);
        close(keep[file - STDOUT_FILENO]);
    }
}

static int study(arguments *a, int argc, char **argv) {
    const bool silent = a->ranks.rank > 0;
    read_arguments(a, argc, argv);
    a->common.quiet = a->common.quiet || silent;
    sp_error err = {0};
    sp_scene scene = sp_scene_default();
    sp_store *store = NULL;
    sp_packing from = sp_packing_none();
    const bool whole = a->common.files == 0 && a->common.sets == 0; /* --verify of the whole store */
    bool good = true;
    sp_status status = SP_OK;
    if (a->common.dry_run)
        status = plan(a, &scene, &from, &err);
    else if (!a->verify)
        status = make(a, &scene, &from, &store, &err);
    else if (!whole)
        status = read_scene(a, &scene, &from, &err);
    share_threads(a);
    if (status == SP_OK && a->verify)
        status = verify_store(&a->common, a->store, whole ? NULL : &scene,
                              isnan(a->tolerance) ? CLI_AUDIT_TOLERANCE : a->tolerance, a->study.jobs, &good, &err);
    if (store)
        sp_store_close(store);
    a->study.from = NULL;
    sp_packing_free(&from);
    sp_scene_free(&scene);
    if (status != SP_OK)
        return silent ? CLI_FAILED : cli_fail(&err);
    return good ? CLI_OK : CLI_FAILED;
}

int cmd_study(int argc, char **argv) {
    arguments a = {
        .study = {.jobs = 1, .shard = 1, .shards = 1}, .tolerance = NAN, .level = sp_table_options_default().level};
    sp_error err = {0};
    if (cli_ranks_start(&a.ranks, &err) != SP_OK)
        return cli_fail(&err);
    return cli_ranks_end(study(&a, argc, argv));
}
