/* sonopack reproduce: the tables and figures of a paper beside our own values. */
#include "base/base.h"
#include "cli/output.h"
#include "scene/field.h"

#include "paper/reproduce.h"
#include <stdio.h>
#include <string.h>

typedef struct arguments {
    cli_common common;
    const char *paper, *store, *only;
    bool column;           /* the paper of the tapped column, which makes no packings */
    int64_t samples, jobs; /* jobs 0: as many as --threads */
    const char *idle;      /* an option that is for packings alone */
    uint32_t items;
    const char *figures;
    sp_protocol protocol;
    int64_t failed; /* samples, as the progress tells */
} arguments;

enum { KEY_STORE = 0x1000, KEY_JOBS, KEY_ONLY, KEY_SAMPLES, KEY_FIGURES, KEY_PROTOCOL };

static const struct argp_option options[] = {
    {"store", KEY_STORE, "DIR", 0, "Folder of the samples; made if it is not there (somfai2005)", 0},
    {"only", KEY_ONLY, "ITEMS", 0, "These alone, as in fig6,table2, or fig1,chaos (all)", 0},
    {"samples", KEY_SAMPLES, "N", 0, "Packings of each pressure (30, as in the paper; somfai2005)", 0},
    {"jobs", KEY_JOBS, "N", 0, "Samples made at the same time (as many as there are cores)", 0},
    {"figures", KEY_FIGURES, "svg|png|pdf", 0, "Form of the figures (svg)", 0},
    {"protocol", KEY_PROTOCOL, "NAME", 0,
     "How packings are compressed, as packing.protocol: default; somfai2005, the same motion until all is damped in "
     "the "
     "end; or quick, another material, several times faster. What lattices of unequal balls are made by stays the "
     "default",
     0},
    {0}};
static const struct argp_child children[] = {{&cli_common_argp, 0, "Common options:", 90}, {0}};

static const char *item_name(const arguments *a, int item) {
    return a->column ? sp_paper_column_item_name(item) : sp_paper_item_name(item);
}

/* "table1 .. table5, fig1 .. fig12" */
static void item_names(const arguments *a, char *text, size_t size) {
    size_t used = 0;
    for (int k = 0; item_name(a, k) && used < size; k++)
        used += (size_t)snprintf(text + used, size - used, "%s%s", k > 0 ? ", " : "", item_name(a, k));
}

static sp_status find_item(const arguments *a, const char *name, int *item, sp_error *err) {
    int near = -1, least = 1000;
    for (int k = 0; item_name(a, k); k++) {
        const int distance = sp_edit_distance(name, item_name(a, k));
        if (distance == 0) {
            *item = k;
            return SP_OK;
        }
        if (distance < least && sp_is_near(name, distance)) {
            least = distance;
            near = k;
        }
    }
    char names[200];
    item_names(a, names, sizeof names);
    if (near >= 0)
        return sp_fail(err, SP_EINVAL, "--only %.60s: did you mean %s? must be one of %s", name, item_name(a, near),
                       names);
    return sp_fail(err, SP_EINVAL, "--only %.60s: must be one of %s", name, names);
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

static void set_paper(arguments *a, const char *name, struct argp_state *state) {
    if (a->paper)
        argp_error(state, "%.60s: one paper only", name);
    if (strcmp(name, "somfai2005") != 0 && strcmp(name, "blackmore2011") != 0)
        argp_error(state, "paper %.60s: must be somfai2005 or blackmore2011", name);
    a->paper = name;
    a->column = strcmp(name, "blackmore2011") == 0;
}

/* Every protocol that scenes know. */
static void set_protocol(arguments *a, const char *name, struct argp_state *state) {
    const sp_field *field = sp_field_find("packing.protocol");
    char right[200];
    for (const sp_word *w = field->words; w->word; w++)
        if (strcmp(w->word, name) == 0) {
            a->protocol = (sp_protocol)w->value;
            return;
        }
    argp_error(state, "--protocol %.60s: must be %s", name, sp_field_right(field, right, sizeof right));
}

/* What can be said when the paper is known. */
static void check(arguments *a, struct argp_state *state) {
    sp_error err;
    if (!a->paper)
        argp_error(state, "no paper: must be somfai2005 or blackmore2011");
    if (!a->store && !a->column)
        argp_error(state, "no store: must be --store DIR");
    if (a->common.sets > 0)
        argp_error(state, "--set: has no place here, the paper decides the scenes");
    if (a->only && read_items(a, &err) != SP_OK)
        argp_error(state, "%s", err.text);
}

static error_t parse(int key, char *arg, struct argp_state *state) {
    arguments *a = state->input;
    sp_error err;
    sp_status status = SP_OK;
    switch (key) {
    case ARGP_KEY_INIT: state->child_inputs[0] = &a->common; return 0;
    case KEY_STORE: a->store = arg; return 0;
    case KEY_JOBS:
        a->idle = "--jobs";
        status = cli_integer("--jobs", arg, 1, 4096, &a->jobs, &err);
        break;
    case KEY_SAMPLES:
        a->idle = "--samples";
        status = cli_integer("--samples", arg, 1, 100000, &a->samples, &err);
        break;
    case KEY_ONLY: a->only = arg; return 0;
    case KEY_FIGURES:
        if (strcmp(arg, "svg") != 0 && strcmp(arg, "png") != 0 && strcmp(arg, "pdf") != 0)
            argp_error(state, "--figures %.60s: must be svg, png or pdf", arg);
        a->figures = arg;
        return 0;
    case KEY_PROTOCOL:
        set_protocol(a, arg, state);
        a->idle = "--protocol";
        return 0;
    case ARGP_KEY_ARG: set_paper(a, arg, state); return 0;
    case ARGP_KEY_END: check(a, state); return 0;
    default: return ARGP_ERR_UNKNOWN;
    }
    if (status != SP_OK)
        argp_error(state, "%s", err.text);
    return 0;
}

static const struct argp argp = {
    options,
    parse,
    "somfai2005 --store DIR [-o FOLDER]\nblackmore2011 [-o FOLDER]",
    "Computes a paper again and prints its values beside ours. somfai2005: E. Somfai, J.-N. Roux, J. H. Snoeijer, M. "
    "van "
    "Hecke, W. van Saarloos, Phys. Rev. E 72, 021301 (2005), whose packings are made; blackmore2011: D. Blackmore, A. "
    "Rosato, X. Tricoche, K. Urban, V. Ratnaswamy, J. Mech. Mater. Struct. 6 (2011), on the tapped column.\v"
    "With -o FOLDER there is a report, report.html and report.md, with every figure, and the numbers of each beside "
    "it.\n\n"
    "somfai2005: a row a value: the paper's mean and standard deviation, our mean and its standard error, sigma, the "
    "difference over one standard deviation, and the verdict: agrees within one, else deviates, or missing without a "
    "value or a scatter; deviation_err: the difference over the standard errors of both means and the rounding of "
    "print. Comments count both ways, with chi^2 and the differences that have a system. Claims in words hold, are "
    "contradicted or undecided. Items: table1 to table5, fig1 to fig12, claims; only what they need is made. The "
    "samples "
    "stay in the "
    "store: an interrupted run goes on where it stopped, and more samples or items add to what is there.\n\n"
    "blackmore2011: a row a value: what is printed or follows from what is printed, ours with its error, the verdict "
    "(agrees, deviates, erratum, not given; of claims in words holds, contradicted, undecided), and why. Items: "
    "errata, "
    "fig1, fig2, symbols, chaos, claims. Seconds, no store.\n\n"
    "  sonopack reproduce somfai2005 --store results/somfai2005 -o results/report\n"
    "  sonopack reproduce somfai2005 --only table2,fig8 --samples 4 --store results/somfai2005\n"
    "  sonopack reproduce blackmore2011 --only errata",
    children,
    NULL,
    NULL};

static bool watch(const sp_paper_progress *now, void *user) {
    arguments *a = user;
    char text[120];
    a->failed = now->failed;
    if (a->column) {
        cli_progress(&a->common, now->what, now->fraction, now->seconds_left);
        return !cli_stopped();
    }
    int length = snprintf(text, sizeof text, "%s, %lld samples made", now->what, (long long)now->computed);
    if (now->failed > 0)
        snprintf(text + length, sizeof text - (size_t)length, ", %lld failed", (long long)now->failed);
    cli_progress(&a->common, text, now->fraction, now->seconds_left);
    return !cli_stopped();
}

static sp_status finish(arguments *a, sp_table *t, sp_error *err) {
    const char *folder = a->common.output;
    if (folder)
        cli_note(&a->common, "report: %s/report.html", folder);
    else if (t->rows == 0)
        cli_note(&a->common, "no values to compare, and figures need -o FOLDER");
    a->common.output = NULL; /* the folder has the report; the table is for stdout */
    return cli_write_table(&a->common, t, err);
}

static sp_status work_column(arguments *a, sp_table *t, sp_error *err) {
    sp_paper_column_options o = sp_paper_column_options_default();
    o.items = a->items;
    o.threads = a->common.threads;
    o.folder = a->common.output;
    o.figures = a->figures;
    sp_status status = o.folder ? sp_paper_check_folder(o.folder, a->common.force, err) : SP_OK;
    if (status != SP_OK)
        return status;
    if (a->idle)
        cli_note(&a->common, "%s: without effect, blackmore2011 makes no packings", a->idle);
    cli_catch_signals();
    status = sp_paper_column_reproduce(&o, watch, a, t, err);
    cli_progress_end(&a->common);
    if (status == SP_EINTERRUPTED)
        return sp_fail(err, status, "stopped, nothing is kept: the same command starts anew");
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
    o.figures = a->figures;
    sp_status status = folder ? sp_paper_check_folder(folder, a->common.force, err) : SP_OK;
    if (status == SP_OK)
        status = sp_store_open(a->store, true, store, err);
    if (status != SP_OK)
        return status;
    cli_catch_signals();
    status = sp_paper_reproduce(*store, &o, watch, a, t, err);
    cli_progress_end(&a->common);
    if (status == SP_EINTERRUPTED)
        return sp_fail(err, status, "stopped, all finished samples are in %s: the same command goes on", a->store);
    if (status != SP_OK)
        return status;
    if (a->failed > 0)
        cli_note(&a->common, "%lld samples failed or lack a part: column `samples' says how many are left",
                 (long long)a->failed);
    return finish(a, t, err);
}

int cmd_reproduce(int argc, char **argv) {
    arguments a = {.samples = sp_paper_options_default().samples, .figures = "svg"};
    argp_parse(&argp, argc, argv, 0, NULL, &a);
    sp_error err = {0};
    sp_store *store = NULL;
    sp_table t = sp_table_none();
    sp_status status = a.column ? work_column(&a, &t, &err) : work(&a, &store, &t, &err);
    if (store)
        sp_store_close(store);
    sp_table_free(&t);
    return status == SP_OK ? CLI_OK : cli_fail(&err);
}
