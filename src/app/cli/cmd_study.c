/* sonopack study: an ensemble of samples, kept in a store, and its tables. */
#include "base/base.h"
#include "cli/output.h"
#include "cli/ranks.h"
#include "cli/tables.h"
#include "cli/verify.h"
#include "ensemble/sample.h"

#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct arguments {
    cli_common common;
    const char *scene, *store;
    int64_t jobs; /* 0: as many as --threads */
    bool verify, retry;
    double tolerance; /* of --verify; NAN: not given */
    double level;     /* of the tables' intervals */
    sp_study_options study;
    cli_ranks ranks;
} arguments;

enum { KEY_STORE = 0x1000, KEY_JOBS, KEY_SHARD, KEY_RETRY, KEY_VERIFY, KEY_TOLERANCE, KEY_INTERVAL };

static const struct argp_option options[] = {
    {"store", KEY_STORE, "DIR", 0, "Folder of the samples; made if it is not there", 0},
    {"jobs", KEY_JOBS, "N", 0, "Samples made at the same time (as many as cores it may use)", 0},
    {"shard", KEY_SHARD, "I/N", 0, "Make only every N-th sample, beginning with the I-th", 0},
    {"retry", KEY_RETRY, NULL, 0, "Try again the samples that are recorded as failed", 0},
    {"verify", KEY_VERIFY, NULL, 0, "Make nothing: check every file of the scene's samples, or of the store", 0},
    {"tolerance", KEY_TOLERANCE, "EPS", 0, "With --verify: largest relative error that is ok (2e-5)", 0},
    {"interval", KEY_INTERVAL, "LEVEL", 0, "Confidence of the tables' intervals, 0.5 to 0.999 (0.95)", 0},
    {0}};
static const struct argp_child children[] = {{&cli_common_argp, 0, "Common options:", 90}, {0}};

static void parse_shard(arguments *a, const char *arg, struct argp_state *state) {
    char first[24];
    const char *slash = strchr(arg, '/');
    int64_t shard, shards;
    snprintf(first, sizeof first, "%.*s", slash ? (int)strcspn(arg, "/") : 0, arg);
    if (!slash || cli_integer("--shard", slash + 1, 1, INT32_MAX, &shards, NULL) != SP_OK ||
        cli_integer("--shard", first, 1, shards, &shard, NULL) != SP_OK) {
        argp_error(state, "--shard %.60s: must be I/N with 1 <= I <= N, as in 2/8", arg);
        return;
    }
    a->study.shard = (int)shard;
    a->study.shards = (int)shards;
}

static void check_usage(const arguments *a, struct argp_state *state) {
    if (!a->scene && a->common.sets == 0 && !a->verify)
        argp_error(state, "no scene: must be a scene file, or --set KEY=VALUE");
    if (!a->store)
        argp_error(state, "no store: must be --store DIR");
    if (a->verify && (a->retry || a->study.shards > 1 || a->jobs > 0))
        argp_error(state, "--verify makes no sample: must be without --retry, --shard and --jobs");
    if (!a->verify && !isnan(a->tolerance))
        argp_error(state, "--tolerance: only with --verify");
    if (a->verify && a->ranks.size > 1)
        argp_error(state, "--verify: must be one process, not %d ranks", a->ranks.size);
    sp_error err;
    if (cli_ranks_check(&a->ranks, a->study.shards, &err) != SP_OK)
        argp_error(state, "%s", err.text);
}

static error_t parse(int key, char *arg, struct argp_state *state) {
    arguments *a = state->input;
    sp_error err;
    switch (key) {
    case ARGP_KEY_INIT: state->child_inputs[0] = &a->common; return 0;
    case KEY_STORE: a->store = arg; return 0;
    case KEY_JOBS:
        if (cli_integer("--jobs", arg, 1, 4096, &a->jobs, &err) != SP_OK)
            argp_error(state, "%s", err.text);
        return 0;
    case KEY_SHARD: parse_shard(a, arg, state); return 0;
    case KEY_RETRY: a->retry = true; return 0;
    case KEY_VERIFY: a->verify = true; return 0;
    case KEY_TOLERANCE:
        if (cli_number("--tolerance", arg, 0, 1, &a->tolerance, &err) != SP_OK)
            argp_error(state, "%s", err.text);
        return 0;
    case KEY_INTERVAL: cli_parse_interval(&a->level, arg, state); return 0;
    case ARGP_KEY_ARG:
        if (a->scene)
            argp_error(state, "%s: one scene only", arg);
        a->scene = arg;
        return 0;
    case ARGP_KEY_END: check_usage(a, state); return 0;
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp argp = {
    options,
    parse,
    "[SCENE] --store DIR",
    "Makes every sample of a scene that is not in the store yet, and prints the tables that the scene wants.\v"
    "A sample is known by what made it, so an interrupted study goes on where it stopped, more samples or more wishes "
    "add to what is there, several studies may share a store, and several processes may fill one at the same time. "
    "Several tables follow each other with a blank line between; with -o FILE.tsv the first goes there and the others "
    "beside it (FILE-moduli.tsv). Values of swept keys other than packing.pressure, packing.grains, packing.height and "
    "packing.seed have tables of their own, from the second value on in FILE-ctof-2.tsv, FILE-moduli-2.tsv and so on, "
    "with a comment that says the value (of fronts over distance, scaling and planes, those other than "
    "packing.width and packing.friction as well; of spectrum all but packing.seed).\n\n"
    "Samples that cannot be made are recorded with their reasons and counted, also in the tables; the exit status is 0 "
    "all the same. They would fail again in the same way: --retry is for another version of the program. The words "
    "packings and signal of study.want only keep something in the store and have no table here.\n\n"
    "--verify reads every file of the samples and prints a table of them: whether each is the sample of its name, and "
    "its packing passes what `sonopack check' looks at. What cannot be read, or is not the sample of its name, is "
    "renamed to NAME.bad: the next study makes it anew. The exit status is 1 if any file is not ok.\n\n"
    "  sonopack study packings/ctof-quick.cfg --store results/quick\n"
    "  sonopack study big.cfg --store results/big --shard 3/16 --jobs 1\n"
    "  mpirun -n 16 sonopack study big.cfg --store results/big          (a build with -DSONOPACK_MPI=ON)",
    children,
    NULL,
    NULL};

/* The tables of study.want, in their usual order. */
static cli_tables wanted_tables(const cli_common *common, const sp_scene *scene) {
    static const struct {
        unsigned want;
        const char *name;
    } all[] = {{SP_WANT_CTOF, "ctof"},        {SP_WANT_SCALING, "scaling"}, {SP_WANT_PLANES, "planes"},
               {SP_WANT_STATICS, "statics"},  {SP_WANT_MODULI, "moduli"},   {SP_WANT_PROBES, "probes"},
               {SP_WANT_SPECTRUM, "spectrum"}};
    cli_tables tables = {.common = common, .scene = scene, .filter = cli_filter_none(), .bins = cli_bins_default()};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        if (scene->want & all[k].want)
            tables.name[tables.count++] = all[k].name;
    return tables;
}

static bool watch(const sp_study_progress *progress, void *user) {
    sp_study_progress now = *progress;
    const bool go_on = cli_ranks_share(&now, cli_stopped());
    char text[120];
    int length = snprintf(text, sizeof text, "%lld/%lld samples", (long long)now.done, (long long)now.total);
    if (now.failed > 0)
        length += snprintf(text + length, sizeof text - (size_t)length, ", %lld failed", (long long)now.failed);
    if (now.elsewhere > 0)
        snprintf(text + length, sizeof text - (size_t)length, ", %lld at other processes", (long long)now.elsewhere);
    cli_progress(user, text, now.total > 0 ? (double)now.done / (double)now.total : 1, now.seconds_left);
    return go_on;
}

/* Ranks of MPI share the numbers of one scene, one shard, and one store. */
static sp_status say_what(const arguments *a, const sp_scene *scene, sp_error *err) {
    char *text = sp_scene_text(scene, NULL);
    const size_t size = text ? strlen(text) + strlen(a->store) + 64 : 0;
    char *what = text ? sp_alloc(size, 1) : NULL;
    if (what) {
        snprintf(what, size, "%s\n%s\n%d/%d", text, a->store, a->study.shard, a->study.shards);
        cli_ranks_begin(what);
    }
    sp_status status = what ? SP_OK : sp_fail_memory(err, 1 << 14);
    sp_free(what);
    sp_free(text);
    return status;
}

static sp_status run(arguments *a, const sp_scene *scene, sp_store *store, sp_study_progress *done, sp_error *err) {
    sp_study_sink sink = sp_store_sink(store);
    sp_store_retry(store, a->retry);
    a->study.jobs = a->jobs > 0 ? (int)a->jobs : a->common.threads;
    a->study.threads = a->common.threads;
    a->study.take = a->ranks.take;
    sp_status status = say_what(a, scene, err);
    cli_catch_signals();
    return status == SP_OK ? sp_study_run(scene, &a->study, &sink, watch, &a->common, done, err) : status;
}

static sp_status tell(const arguments *a, sp_status status, const sp_study_progress *done, sp_error *err) {
    char ranks[40] = "";
    cli_progress_end(&a->common);
    if (status == SP_EINTERRUPTED)
        return sp_fail(err, status, "stopped with %lld of %lld samples done, all kept in %s: the same command goes on",
                       (long long)done->done, (long long)done->total, a->store);
    if (a->ranks.size > 1)
        snprintf(ranks, sizeof ranks, " by %d ranks", a->ranks.size);
    if (status == SP_OK)
        cli_note(&a->common, "%lld samples, %lld of them made now in %.1f s%s", (long long)done->total,
                 (long long)done->computed, done->seconds, ranks);
    if (status == SP_OK && done->failed > 0)
        cli_note(&a->common,
                 "%lld samples failed, or lack a part that is wanted: see `sonopack table ensemble --store %s'",
                 (long long)done->failed, a->store);
    return status;
}

/* The scene, and the packing that it begins with. */
static sp_status read_scene(arguments *a, sp_scene *scene, sp_packing *from, sp_error *err) {
    sp_status status = sp_scene_read(a->scene, a->common.sets, a->common.set, scene, err);
    if (status == SP_OK)
        status = sp_scene_check_sweeps(scene, err);
    if (status == SP_OK && scene->pack.kind == SP_PACK_FILE) {
        status = cli_load_start(scene, from, err);
        a->study.from = from;
    }
    return status;
}

/* The store of rank 0 has what all ranks made, unless theirs is another folder of the same name. */
static sp_status check_whole(const arguments *a, const sp_scene *scene, sp_store *store, sp_error *err) {
    const sp_study_sink sink = sp_store_sink(store);
    const int64_t count = a->ranks.size > 1 && a->ranks.rank == 0 ? sp_study_count(scene) : 0;
    int64_t missing = 0;
    sp_status status = SP_OK;
    for (int64_t k = a->study.shard - 1; k < count && status == SP_OK; k += a->study.shards) {
        sp_scene one;
        char name[SP_NAME_MAX];
        status = sp_study_sample(scene, k, &one, name, err);
        missing += status == SP_OK && sink.has(sink.user, &one, name) == SP_STORED_NOT;
    }
    if (status == SP_OK && missing > 0 && !a->retry)
        status = sp_fail(err, SP_EIO,
                         "%lld samples that were made are not in %s, as rank 0 sees it: --store must be one folder for "
                         "all ranks",
                         (long long)missing, a->store);
    return status;
}

/* The samples, then their tables. Of several ranks each makes samples, whatever became of the scene there: all of them
 * are to know when one cannot. */
static sp_status make(arguments *a, sp_scene *scene, sp_packing *from, sp_store **store, sp_error *err) {
    sp_study_progress done = {0};
    cli_tables tables = {0};
    sp_status status = read_scene(a, scene, from, err);
    if (status == SP_OK) {
        tables = wanted_tables(&a->common, scene);
        tables.level = a->level;
        if (a->common.output && tables.count == 0)
            status = sp_fail(err, SP_EINVAL, "-o %s: study.want names no table", a->common.output);
    }
    if (status == SP_OK)
        status = cli_tables_may_write(&tables, err);
    if (status == SP_OK)
        status = sp_store_open(a->store, true, store, err);
    if (status == SP_OK)
        status = run(a, scene, *store, &done, err);
    status = cli_ranks_join(status, done.total > 0 ? watch : NULL, &a->common, &done, err);
    status = tell(a, status, &done, err);
    if (status == SP_OK)
        status = check_whole(a, scene, *store, err);
    return status == SP_OK && tables.count > 0 && a->ranks.rank == 0 ? cli_tables_write(&tables, *store, err) : status;
}

/* argp speaks by itself, and ends the process: on other ranks than the first in silence. */
static void read_arguments(arguments *a, int argc, char **argv) {
    int keep[2] = {-1, -1};
    for (int file = STDOUT_FILENO; a->ranks.rank > 0 && file <= STDERR_FILENO; file++) {
        const int null = open("/dev/null", O_WRONLY);
        keep[file - STDOUT_FILENO] = dup(file);
        dup2(null, file);
        close(null);
    }
    /* several ranks are several threads already; options may say otherwise */
    a->common.threads = a->ranks.size > 1 ? 1 : 0;
    argp_parse(&argp, argc, argv, 0, NULL, a);
    for (int file = STDOUT_FILENO; file <= STDERR_FILENO; file++) {
        if (keep[file - STDOUT_FILENO] >= 0) {
            dup2(keep[file - STDOUT_FILENO], file);
            close(keep[file - STDOUT_FILENO]);
        }
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
    const bool whole = !a->scene && a->common.sets == 0; /* of the store: with --verify only */
    bool good = true;
    sp_status status = SP_OK;
    if (!a->verify)
        status = make(a, &scene, &from, &store, &err);
    else if (!whole)
        status = read_scene(a, &scene, &from, &err);
    if (status == SP_OK && a->verify)
        status = cli_verify(&a->common, a->store, whole ? NULL : &scene,
                            isnan(a->tolerance) ? CLI_AUDIT_TOLERANCE : a->tolerance, &good, &err);
    if (store)
        sp_store_close(store);
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
