/* sonopack design: finds which grains to make heavier, stiffer or larger, and writes the packing of such grains. */
#include "base/base.h"
#include "cli/files.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct arguments {
    cli_common common;
    sp_design_options o;
    const char *packing; /* file of the result */
    int rows;
    bool goal_given;
    double limits[2]; /* NAN: not given, they depend on what is varied */
} arguments;

static const char *const goal_names[] = {
    [SP_DESIGN_DELAY] = "delay", [SP_DESIGN_ADVANCE] = "advance", [SP_DESIGN_BAND] = "band", NULL};
static const char *const vary_names[] = {
    [SP_DESIGN_MASS] = "mass", [SP_DESIGN_MODULUS] = "modulus", [SP_DESIGN_RADIUS] = "radius", NULL};
enum { ROWS_STEPS = 0, ROWS_GRAINS };
static const char *const row_names[] = {[ROWS_STEPS] = "steps", [ROWS_GRAINS] = "grains", NULL};

static sp_status set_goal(void *user, const char *text, sp_error *err) {
    arguments *a = user;
    char word[16] = "";
    const size_t length = strcspn(text, ":");
    int goal;
    double band[2] = {a->o.band_low, a->o.band_high};
    if (length < sizeof word)
        memcpy(word, text, length);
    sp_status status = cli_choose("--goal", word, goal_names, &goal, err);
    if (status == SP_OK && (goal == SP_DESIGN_BAND) != (text[length] == ':'))
        status = sp_fail(err, SP_EINVAL, "--goal %.60s: must be delay, advance or band:W1:W2", text);
    if (status == SP_OK && goal == SP_DESIGN_BAND)
        status = cli_pair("--goal band:", text + length + 1, 0, 1e9, band, err);
    a->o.band_low = band[0];
    a->o.band_high = band[1];
    a->o.goal = (sp_design_goal)goal;
    a->goal_given = true;
    return status;
}

static sp_status check(void *user, sp_error *err) {
    const arguments *a = user;
    return a->goal_given ? SP_OK : sp_fail(err, SP_EINVAL, "--goal: must be given: delay, advance or band:W1:W2");
}

static const cli_option options[] = {
    {"goal", "delay|advance|band:W1:W2",
     "A late front, an early front, or little energy between two frequencies [sqrt(E* / rho)/d]", .parse = set_goal,
     .words = goal_names},
    {"vary", "mass|modulus|radius", "What of each grain is changed (mass)", CLI_CHOICE, CLI_FIELD(o.vary),
     .words = vary_names},
    {"limits", "LOW:HIGH", "Limits of the factor of each grain (0.5:2; radius: 0.98:1.02)", CLI_PAIR, CLI_FIELD(limits),
     .high = 1e9},
    {"free", NULL, "The total mass, sum of moduli or volume need not be kept", CLI_FLAG, CLI_FIELD(o.free)},
    {"packing", "FILE", "Write the packing of these grains, .h5 or .txt", CLI_TEXT, CLI_FIELD(packing)},
    {"rows", "steps|grains", "Rows of the table: the steps of the search, or the grains with their factors (steps)",
     CLI_CHOICE, CLI_FIELD(rows), .words = row_names},
    {"iterations", "N", "Steps at most; 0: the first gradient alone (50)", CLI_INT, CLI_FIELD(o.iterations),
     .high = 100000},
    {"tolerance", "EPS", "End where a step gains less than this part of all that was gained (0.001)", CLI_NUMBER,
     CLI_FIELD(o.tolerance), .high = 0.999},
    {"until", "T", "band: length of the signal [d/sqrt(E* / rho)] ((8 H + 40) (p/1e-4)^(-1/6))", CLI_NUMBER,
     CLI_FIELD(o.until), .low = 1e-9, .high = 1e9, .unit = "d/sqrt(E* / rho)"},
    {"source", "impulse|velocity|displacement", "Kind of source at the bottom wall (impulse)", CLI_CHOICE,
     CLI_FIELD(o.source), .words = cli_source_names},
    {0}};

const cli_syntax cmd_design_syntax = {
    .usage = "FILE",
    .help =
        "Which grains to make heavier, stiffer or larger so that the front arrives late or early, or little passes in "
        "a band of frequencies: by projected gradients, from exact derivatives.\v"
        "mass: masses do not enter the balance of forces, so that the packing at rest stays the same. modulus: the "
        "stiffness of a contact follows by Hertz's law at the force that it has. radius: every candidate is "
        "compressed again, from the best one so far. The total mass, the sum of moduli or, to first order, the volume "
        "of the grains that carry force is kept, unless --free is given.\n"
        "\n"
        "The first row is the packing as it is. predicted: what the gradient of the step before promises for this "
        "one, by the logarithm of the value. energy: over that of the packing as it is. at_limit: number of grains "
        "whose factor is at a limit. t10_err and energy_err are numerical. factor: by what the mass, modulus or "
        "radius of the grain is multiplied. The comments give the ratio of the last value to the first one, the ratio "
        "that the first gradient promises for the best factors within the limits (linear_predicted_ratio), and the "
        "one that these factors really have (linear_ratio). effective: number of grains that share the first "
        "gradient. The result is a local optimum; others may be better.",
    CLI_ONE_PACKING,
    .options = options,
    .springs = true,
    .check = check};

static bool is_band(const arguments *a) { return a->o.goal == SP_DESIGN_BAND; }

static sp_status begin(void *user, cli_writer *w) {
    const arguments *a = user;
    if (a->packing)
        w->status = cli_may_write_packing(&a->common, "--packing", a->packing, w->err);
    if (a->rows == ROWS_GRAINS) {
        cli_columns(w, SP_COLUMN_INTEGER, "grain", "", NULL);
        cli_columns(w, SP_COLUMN_NUMBER, "x", "d", "y", "d", "z", "d", "r", "d", "factor", "", NULL);
        return w->status;
    }
    const char *const name = is_band(a) ? "energy" : "t10", *const unit = is_band(a) ? "" : "d/sqrt(E* / rho)";
    cli_columns(w, SP_COLUMN_INTEGER, "step", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, name, unit, is_band(a) ? "energy_err" : "t10_err", unit, "predicted", unit, NULL);
    cli_columns(w, SP_COLUMN_INTEGER, "at_limit", "", NULL);
    return w->status;
}

static sp_status add_rows(const arguments *a, const sp_design *d, cli_writer *w) {
    const sp_packing *p = &d->packing;
    sp_status status = SP_OK;
    for (int32_t i = 0; i < d->n && a->rows == ROWS_GRAINS && status == SP_OK; i++) {
        const double *x = p->x + 3 * (size_t)i;
        status = cli_row(w, (int64_t)i, x[0], x[1], x[2], p->r[i], d->factor[i]);
    }
    for (int32_t k = 0; k < d->steps && a->rows == ROWS_STEPS && status == SP_OK; k++) {
        const sp_design_step *s = &d->step[k];
        status = cli_row(w, (int64_t)k, s->value, s->error, s->predicted, s->bound);
    }
    return status;
}

static void add_comments(const arguments *a, const cli_file *file, const sp_design *d, cli_writer *w) {
    const sp_design_step *first = &d->step[0], *last = &d->step[d->steps - 1];
    const char *const what = is_band(a) ? "energy" : "t10";
    cli_comment(w, "file = %s", file->path);
    if (is_band(a)) {
        cli_value(w, "band_low", a->o.band_low);
        cli_value(w, "band_high", a->o.band_high);
    }
    cli_comment(w, "goal = %s", goal_names[a->o.goal]);
    cli_comment(w, "vary = %s", vary_names[a->o.vary]);
    cli_value(w, "factor_low", a->o.low);
    cli_value(w, "factor_high", a->o.high);
    cli_comment(w, "total = %s", a->o.free ? "free" : "kept");
    cli_value(w, "effective", d->effective);
    cli_comment(w, "%s_ratio = %.6g", what, last->value / first->value);
    cli_comment(w, "linear_predicted_ratio = %.6g", d->linear_predicted / first->value);
    cli_comment(w, "linear_ratio = %.6g", d->linear / first->value);
}

static sp_status design(void *user, cli_file *file, cli_writer *w) {
    arguments *a = user;
    sp_design d = sp_design_none();
    a->o.network = file->scene->network;
    a->o.threads = a->common.threads;
    const bool given = !isnan(a->limits[0]), radius = a->o.vary == SP_DESIGN_RADIUS;
    a->o.low = given ? a->limits[0] : radius ? 0.98 : 0.5;
    a->o.high = given ? a->limits[1] : radius ? 1.02 : 2;
    sp_status status = cli_need_walls(&file->packing, "a front", w->err);
    CLI_THEN(status, sp_design_make(&file->packing, &a->o, &d, w->err));
    if (status == SP_OK) {
        add_comments(a, file, &d, w);
        status = w->status;
    }
    CLI_THEN(status, add_rows(a, &d, w));
    if (status == SP_OK && a->packing)
        status = cli_save_packing(&d.packing, a->packing, w->err);
    sp_design_free(&d);
    return status;
}

int cmd_design(int argc, char **argv) {
    static const cli_files command = {CLI_OF_NETWORK, .stop = true, .begin = begin, .add = design};
    arguments a = {.o = sp_design_options_default(), .limits = {NAN, NAN}};
    a.o.iterations = 50;
    cli_parse(&cmd_design_syntax, argc, argv, &a);
    return cli_run_files(&command, &a);
}
