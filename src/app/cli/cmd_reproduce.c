/* sonopack reproduce: computes the tables and figures of a paper and compares them with the printed values. */
#include "base/base.h"
#include "cli/output.h"
#include "cli/plan_study.h"
#include "cost/remaining.h"
#include "scene/field.h"

#include "paper/reproduce.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { PAPER_SOMFAI = 0, PAPER_BLACKMORE };
static const char *const papers[] = {"somfai2005", "blackmore2011", NULL};
static const char *const figure_formats[] = {"svg", "png", "pdf", NULL};

typedef struct arguments {
    cli_common common;
    const char *store, *only;
    bool column;           /* the paper on the tapped column, which needs no packings */
    int64_t samples, jobs; /* jobs 0: as many as --threads */
    uint32_t items;
    int figures; /* index of the format */
    sp_protocol protocol;
    int64_t failed; /* samples, as of the last progress report */
    char step[64];  /* that was last said */
    sp_remaining left;
} arguments;

static const char *item_name(int item, const void *user) {
    const arguments *a = user;
    return a->column ? sp_paper_column_item_name(item) : sp_paper_item_name(item);
}

static sp_status find_item(const arguments *a, const char *name, int *item, sp_error *err) {
    char names[200] = "";
    size_t used = 0;
    for (int k = 0; item_name(k, a) && used < sizeof names; k++)
        used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", k > 0 ? ", " : "", item_name(k, a));
    *item = cli_nearest(name, item_name, a);
    if (*item < 0)
        return sp_fail(err, SP_EINVAL, "--only %.60s: must be one of %s", name, names);
    if (strcmp(name, item_name(*item, a)) == 0)
        return SP_OK;
    return sp_fail(err, SP_EINVAL, "--only %.60s: did you mean %s? must be one of %s", name, item_name(*item, a),
                   names);
}

static sp_status read_items(arguments *a, sp_error *err) {
    for (const char *text = a->only;;) {
        char name[64];
        const size_t length = strcspn(text, ",");
        int item = 0;
        snprintf(name, sizeof name, "%.*s", (int)(length < 60 ? length : 60), text);
        sp_status status = find_item(a, name, &item, err);
        if (status != SP_OK)
            return status;
        a->items |= UINT32_C(1) << item;
        if (text[length] == '\0')
            return SP_OK;
        text += length + 1;
    }
}

/* The items of both papers. */
static const char *any_item(int k) {
    return k < SP_PAPER_ITEMS ? sp_paper_item_name(k) : sp_paper_column_item_name(k - SP_PAPER_ITEMS);
}

static sp_status set_protocol(void *user, const char *name, sp_error *err) {
    const sp_field *field = sp_field_find("packing.protocol");
    char right[200];
    for (const sp_word *w = field->words; w->word; w++)
        if (strcmp(w->word, name) == 0) {
            ((arguments *)user)->protocol = (sp_protocol)w->value;
            return SP_OK;
        }
    return sp_fail(err, SP_EINVAL, "--protocol %.60s: must be %s", name, sp_field_right(field, right, sizeof right));
}

static sp_status check(void *user, sp_error *err) {
    arguments *a = user;
    a->column = a->common.kind == PAPER_BLACKMORE;
    if (!a->store && !a->column)
        return sp_fail(err, SP_EINVAL, "no store: must be --store DIR");
    if (a->common.sets > 0)
        return sp_fail(err, SP_EINVAL, "--set: not used here, because the paper determines the scenes");
    return a->only ? read_items(a, err) : SP_OK;
}

static const cli_option options[] = {
    {"store", "DIR", "somfai2005: folder of the samples; it is created if necessary", CLI_TEXT,
     .field = offsetof(arguments, store)},
    {"only", "ITEMS", "Compute only these items, as in fig6,table2 or fig1,chaos (all)", CLI_TEXT,
     .field = offsetof(arguments, only), .word = any_item},
    {"samples", "N", "somfai2005: number of packings at each pressure (30, as in the paper)", CLI_INTEGER,
     .field = offsetof(arguments, samples), .low = 1, .high = 100000},
    {"jobs", "N", "somfai2005: number of samples computed at the same time (one per core)", CLI_INTEGER,
     .field = offsetof(arguments, jobs), .low = 1, .high = 4096},
    {"figures", "svg|png|pdf", "Format of the figures (svg)", CLI_CHOICE, .field = offsetof(arguments, figures),
     .words = figure_formats},
    {"protocol", "NAME",
     "somfai2005: how packings are compressed, as packing.protocol: default; somfai2005, the same motion, damped until "
     "the end; or quick and affine, with other materials, several times faster. Lattices of unequal balls always use "
     "the default",
     .parse = set_protocol, .key = "packing.protocol"},
    CLI_DRY_RUN,
    {0}};

static const cli_syntax syntax = {
    .usage = "somfai2005 --store DIR [-o FOLDER]\nblackmore2011 [-o FOLDER]",
    .help =
        "Computes the results of a paper and compares them with the printed values. somfai2005: E. Somfai, J.-N. "
        "Roux, J. H. Snoeijer, M. van Hecke, W. van Saarloos, Phys. Rev. E 72, 021301 (2005), with newly compressed "
        "packings. blackmore2011: D. Blackmore, A. Rosato, X. Tricoche, K. Urban, V. Ratnaswamy, J. Mech. Mater. "
        "Struct. 6 (2011), on the tapped column.\v"
        "With -o FOLDER a report is written, report.html and report.md, with all figures and their numbers.\n"
        "\n"
        "somfai2005 prints one row per value: mean and standard deviation in the paper, our mean and its standard "
        "error, the difference in standard deviations (sigma), and the verdict: agrees (within one standard "
        "deviation), deviates, or missing (no value or no scatter). deviation_err is the difference divided by the "
        "standard errors of both means and the rounding in print. Comments count both, with chi^2 and with "
        "systematic differences. Statements in words hold, are contradicted or undecided. Items: table1 to table5, "
        "fig1 to fig12, claims; only the samples that they need are computed. The samples stay in the store: an "
        "interrupted run continues where it stopped, and further samples or items reuse what is there.\n"
        "\n"
        "blackmore2011 prints one row per value: what is printed or follows from it, our value with its error, the "
        "verdict (agrees, deviates, erratum, not given; for statements holds, contradicted, undecided), and the "
        "reason. Items: errata, fig1, fig2, symbols, chaos, claims. This takes seconds and needs no store.\n"
        "\n"
        "  sonopack reproduce somfai2005 --store results/somfai2005 -o results/report\n"
        "  sonopack reproduce somfai2005 --only table2,fig8 --samples 4 --store results/somfai2005\n"
        "  sonopack reproduce blackmore2011 --only errata",
    .not_si = "the report is in the units of the paper",
    .options = options,
    .kinds = papers,
    .kind_name = "paper",
    .check = check};

/* Where no progress line can be shown: a line for each step. */
static void say_step(arguments *a, const sp_paper_progress *now) {
    if (isatty(STDERR_FILENO) || strcmp(a->step, now->what) == 0)
        return;
    snprintf(a->step, sizeof a->step, "%.63s", now->what);
    cli_note(&a->common, "%s, %.0f%% done", now->what, 100 * fmin(1, fmax(0, now->fraction)));
}

static bool watch(const sp_paper_progress *now, void *user) {
    arguments *a = user;
    char text[120];
    a->failed = now->failed;
    say_step(a, now);
    const double left = isnan(now->seconds_left) ? NAN : sp_remaining_fall(&a->left, now->seconds, now->seconds_left);
    if (a->column) {
        cli_progress(&a->common, now->what, now->fraction, left);
        return !cli_stopped();
    }
    int length = snprintf(text, sizeof text, "%s, %lld samples computed", now->what, (long long)now->computed);
    if (now->failed > 0)
        snprintf(text + length, sizeof text - (size_t)length, ", %lld failed", (long long)now->failed);
    cli_progress(&a->common, text, now->fraction, left);
    return !cli_stopped();
}

static sp_status finish(arguments *a, sp_table *t, sp_error *err) {
    const char *folder = a->common.output;
    if (folder)
        cli_note(&a->common, "report: %s/report.html", folder);
    else if (t->rows == 0)
        cli_note(&a->common, "there are no values to compare, and figures need -o FOLDER");
    a->common.output = NULL; /* the table goes to stdout */
    return cli_write_table(&a->common, t, err);
}

/* ---- --dry-run -------------------------------------------------------------------------------------------------- */

typedef struct planning {
    const arguments *arguments;
    cli_plan plan;
    const char *name; /* of the last ensemble; several of one name follow each other */
    int same;
} planning;

static sp_status plan_ensemble(const char *name, const sp_scene *scene, void *user, sp_error *err) {
    planning *p = user;
    const arguments *a = p->arguments;
    const sp_study_options o = {
        .jobs = a->jobs > 0 ? (int)a->jobs : a->common.threads, .threads = a->common.threads, .shard = 1, .shards = 1};
    char prefix[64];
    p->same = p->name && strcmp(p->name, name) == 0 ? p->same + 1 : 1;
    p->name = name;
    if (p->same > 1)
        snprintf(prefix, sizeof prefix, "%s %d: ", name, p->same);
    else
        snprintf(prefix, sizeof prefix, "%s: ", name);
    return cli_plan_study(&p->plan, prefix, scene, &o, a->store, err);
}

/* What follows the samples: seconds on the machine of the laws. */
static void plan_items(planning *p) {
    const arguments *a = p->arguments;
    const bool drawn = a->common.output != NULL;
    int items = 0;
    double seconds = 0;
    for (int k = 0; item_name(k, a); k++)
        if (a->items == 0 || a->items >> k & 1) {
            items++;
            seconds += a->column ? sp_paper_column_item_seconds(k, drawn) : sp_paper_item_seconds(k, drawn);
        }
    seconds *= p->plan.machine.slower[SP_KERNEL_STEP];
    cli_plan_add(&p->plan, drawn ? "items and figures" : "items", items, (sp_cost){seconds, seconds, 1e7},
                 drawn ? 4e5 * items : 0);
}

static sp_status plan(const arguments *a, sp_error *err) {
    planning p = {.arguments = a};
    sp_paper_options o = sp_paper_options_default();
    const unsigned kernels = 1U << SP_KERNEL_STEP | (a->column ? 0 : 1U << SP_KERNEL_PRODUCT | 1U << SP_KERNEL_SPARSE);
    o.items = a->items;
    o.samples = (int32_t)a->samples;
    o.protocol = a->protocol;
    o.folder = a->common.output;
    sp_status status = cli_plan_begin(&a->common, kernels, &p.plan, err);
    if (status == SP_OK && !a->column)
        status = sp_paper_ensembles(&o, plan_ensemble, &p, err);
    if (status == SP_OK) {
        plan_items(&p);
        status = cli_plan_end(&p.plan);
    }
    cli_plan_free(&p.plan);
    return status;
}

/* ---- the work --------------------------------------------------------------------------------------------------- */

static sp_status work_column(arguments *a, sp_table *t, sp_error *err) {
    sp_paper_column_options o = sp_paper_column_options_default();
    o.items = a->items;
    o.threads = a->common.threads;
    o.folder = a->common.output;
    o.figures = figure_formats[a->figures];
    sp_status status = o.folder ? sp_paper_check_folder(o.folder, a->common.force, err) : SP_OK;
    if (status != SP_OK)
        return status;
    static const char *const unused[] = {"jobs", "samples", "protocol"};
    for (int k = 0; k < 3; k++)
        if (cli_given(&syntax, &a->common, unused[k]))
            cli_note(&a->common, "--%s has no effect: blackmore2011 needs no packings", unused[k]);
    cli_catch_signals(&a->common);
    status = sp_paper_column_reproduce(&o, watch, a, t, err);
    cli_progress_end();
    if (status == SP_EINTERRUPTED)
        return sp_fail(err, status, "stopped, and nothing was saved");
    return status == SP_OK ? finish(a, t, err) : status;
}

static sp_status work(arguments *a, sp_store **store, sp_table *t, sp_error *err) {
    sp_paper_options o = sp_paper_options_default();
    const char *folder = a->common.output;
    o.items = a->items;
    o.samples = (int32_t)a->samples;
    o.jobs = a->jobs > 0 ? (int)a->jobs : a->common.threads;
    o.threads = a->common.threads;
    o.protocol = a->protocol;
    o.folder = folder;
    o.figures = figure_formats[a->figures];
    sp_status status = folder ? sp_paper_check_folder(folder, a->common.force, err) : SP_OK;
    if (status == SP_OK)
        status = sp_store_open(a->store, true, store, err);
    if (status != SP_OK)
        return status;
    cli_catch_signals(&a->common);
    status = sp_paper_reproduce(*store, &o, watch, a, t, err);
    cli_progress_end();
    if (status == SP_EINTERRUPTED)
        return sp_fail(err, status, "stopped: all finished samples are in %s, and the same command continues",
                       a->store);
    if (status != SP_OK)
        return status;
    if (a->failed > 0)
        cli_note(&a->common, "%lld samples failed or lack a result: the column `samples' counts those that were used",
                 (long long)a->failed);
    return finish(a, t, err);
}

int cmd_reproduce(int argc, char **argv) {
    arguments a = {.samples = sp_paper_options_default().samples, .left = sp_remaining_begin(1, 0, 1)};
    cli_parse(&syntax, argc, argv, &a);
    sp_error err = {0};
    sp_store *store = NULL;
    sp_table t = sp_table_none();
    sp_status status = a.common.dry_run ? plan(&a, &err)
                       : a.column       ? work_column(&a, &t, &err)
                                        : work(&a, &store, &t, &err);
    if (store)
        sp_store_close(store);
    sp_table_free(&t);
    return status == SP_OK ? CLI_OK : cli_fail(&err);
}
