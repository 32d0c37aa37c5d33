/* sonopack uncertainty: prints how errors of a measured packing carry into its sound. */
#include "base/base.h"
#include "cli/files.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct arguments {
    cli_common common;
    sp_uncertainty_options o;
    bool front_only, sampled_only;
    int by; /* of by_names */
} arguments;

enum { BY_QUANTITY = 0, BY_GRAIN, BY_CONTACT };
static const char *const by_names[] = {"quantity", "grain", "contact", NULL};

static const char *const measured_names[] = {
    [SP_MEASURED_FORCES] = "forces", [SP_MEASURED_OVERLAPS] = "overlaps", NULL};
static const char *const verdicts[] = {[SP_LINEAR_UNKNOWN] = "unknown", [SP_LINEAR_YES] = "yes", [SP_LINEAR_NO] = "no"};

static const cli_option options[] = {
    {.help = "Standard errors of the packing:"},
    {"position", "SD", "Of each coordinate of each grain [d] (0)", CLI_NUMBER, CLI_FIELD(o.errors.position), .high = 1,
     .unit = "d"},
    {"radius", "SD", "Of each radius [d] (0)", CLI_NUMBER, CLI_FIELD(o.errors.radius), .high = 0.3, .unit = "d"},
    {"force", "SD", "Of each normal force, relative to it (0)", CLI_NUMBER, CLI_FIELD(o.errors.force), .high = 2},
    {"stiffness", "SD", "Of the stiffness of each contact, relative to it (0)", CLI_NUMBER,
     CLI_FIELD(o.errors.stiffness), .high = 2},
    {"calibration", "SD", "Of all stiffnesses together, relative to them (0)", CLI_NUMBER,
     CLI_FIELD(o.errors.calibration), .high = 2},
    {"mean-one", NULL,
     "Factors of force, stiffness and calibration have the mean 1 (otherwise the median 1, so the mean exp(SD^2/2))",
     CLI_FLAG, CLI_FIELD(o.errors.mean_one)},
    {"false", "P", "Probability that a listed contact carries no force (0)", CLI_NUMBER, CLI_FIELD(o.errors.false_part),
     .high = 1},
    {"missing", "P", "Probability that two grains, or a grain and a wall, carry force although they are not listed (0)",
     CLI_NUMBER, CLI_FIELD(o.errors.missing), .high = 1},
    {"gap", "D", "Farthest that the surfaces of such a pair may be apart [d] (0.01)", CLI_NUMBER,
     CLI_FIELD(o.errors.gap), .high = 1, .unit = "d"},
    {"missing-force", "F", "Largest force of such a contact over the mean force (0.2)", CLI_NUMBER,
     CLI_FIELD(o.errors.missing_force), .high = 10},
    {"from", "forces|overlaps",
     "What was measured: the force of each contact, or nothing but positions and radii (forces)", CLI_CHOICE,
     CLI_FIELD(o.errors.measured), .words = measured_names},
    {.help = "Estimates:"},
    {"samples", "N", "Packings drawn with these errors; 0: first order alone (200)", CLI_INT, CLI_FIELD(o.samples),
     .high = 10000000},
    {"seed", "S", "Seed of the errors (1)", CLI_INTEGER, CLI_FIELD(o.seed), .high = 1e15},
    {"sampled-only", NULL, "No first order", CLI_FLAG, CLI_FIELD(sampled_only)},
    {"by", "quantity|grain|contact",
     "Rows of the table (quantity); grain, contact: the part of each one's errors in the square of sd_first of each "
     "quantity, without drawn packings",
     CLI_CHOICE, CLI_FIELD(by), .words = by_names},
    {.help = "Quantities:"},
    {"modes", "N", "Add the N lowest frequencies (0)", CLI_INT, CLI_FIELD(o.modes), .high = 10000},
    {"front-only", NULL, "Leave out the moduli and their speeds", CLI_FLAG, CLI_FIELD(front_only)},
    {"margin", "D", "Leave layers of this thickness at all walls out of the density [d] (3)", CLI_NUMBER,
     CLI_FIELD(o.margin), .high = 1e6, .unit = "d"},
    {"source", "impulse|velocity|displacement", "Kind of source at the bottom wall (impulse)", CLI_CHOICE,
     CLI_FIELD(o.source), .words = cli_source_names},
    {0}};

static sp_status check(void *user, sp_error *err) {
    const arguments *a = user;
    const bool missing = a->o.errors.missing > 0;
    sp_status status = cli_need(&cmd_uncertainty_syntax, &a->common, "gap", missing, "--missing", err);
    if (a->by != BY_QUANTITY &&
        (missing || a->sampled_only || cli_given(&cmd_uncertainty_syntax, &a->common, "samples")))
        return sp_fail(err, SP_EINVAL, "--by %s: is first order, without --missing, --sampled-only and --samples",
                       by_names[a->by]);
    CLI_THEN(status, cli_need(&cmd_uncertainty_syntax, &a->common, "missing-force", missing, "--missing", err));
    return status == SP_OK ? cli_need(&cmd_uncertainty_syntax, &a->common, "margin", !a->front_only,
                                      "moduli, which --front-only leaves out", err)
                           : status;
}

const cli_syntax cmd_uncertainty_syntax = {
    .usage = "FILE",
    .help =
        "Errors of the sound that is computed from a measured packing: of the first front, the moduli, the speeds of "
        "long waves and the lowest frequencies.\vThe errors of grains, contacts and directions are independent of each "
        "other. The box and the load are exact.\n"
        "\n"
        "With --from forces the force of each contact was measured by itself, as with photoelastic discs, and its "
        "stiffness follows from the force; positions give the directions of contacts, radii lever arms, masses and "
        "curvatures. With --from overlaps positions and radii decide which grains touch, and stiffnesses follow from "
        "the overlaps: errors must then be far below the mean overlap, which a comment tells.\n"
        "\n"
        "value: without errors, and numerically exact beside them. t10, t_peak, peak and width are those of the front, "
        "c is the height over t10 (one distance over its time, which is biased), C11, ... and c_l, c_t are as in "
        "moduli, omega_n are the lowest frequencies. sd_first: standard deviation to first order, from exact "
        "derivatives. shift_first: shift of the mean by false contacts, to first order. share_...: parts of the kinds "
        "of errors in the square of sd_first. sd, bias: standard deviation of the drawn packings, and their mean minus "
        "the value. sd_err, bias_err: their standard errors. linear: whether both ways agree, or unknown where one of "
        "them is missing. If it is no, they differ by more than these errors, and sd and bias count. It is also no if "
        "more than one in a hundred of the drawn packings has no sound, since sd and bias do not know of these; "
        "differences of 1e-9 of the value are rounding. A comment tells how many they are, and why the first of them "
        "has none. contacts_ratio: contacts that carry force in the drawn packings, over those of the packing. nan: "
        "there are no derivatives, as with missing contacts.\n"
        "\n"
        "--by grain: of the position and radius of each grain; --by contact: of the force, stiffness and existence of "
        "each contact, where j is a grain or a wall: -1 bottom, -2 top, -3 left, -4 right, -5 front, -6 back. The "
        "largest tell what to measure better. With the share of the calibration all are 1 together.",
    CLI_ONE_PACKING,
    .options = options,
    .springs = true,
    .check = check};

static sp_status add_columns(void *user, cli_writer *w) {
    if (((const arguments *)user)->by != BY_QUANTITY)
        return w->status; /* they follow from the quantities */
    cli_columns(w, SP_COLUMN_TEXT, "quantity", "", "unit", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "value", "", "sd_first", "", "shift_first", "", "sd", "", "sd_err", "", "bias", "",
                "bias_err", "", NULL);
    cli_columns(w, SP_COLUMN_INTEGER, "samples", "", NULL);
    cli_columns(w, SP_COLUMN_TEXT, "linear", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "share_position", "", "share_radius", "", "share_force", "", "share_stiffness", "",
                "share_calibration", "", "share_false", "", NULL);
    return w->status;
}

static void add_comments(const arguments *a, const cli_file *file, const sp_uncertainty *u, cli_writer *w) {
    const sp_errors *e = &a->o.errors;
    const struct {
        const char *key;
        double value;
    } given[] = {{"position", e->position},   {"radius", e->radius},           {"force", e->force},
                 {"stiffness", e->stiffness}, {"calibration", e->calibration}, {"false", e->false_part},
                 {"missing", e->missing}};
    cli_comment(w, "file = %s", file->path);
    cli_comment(w, "measured = %s", measured_names[e->measured]);
    if (e->force > 0 || e->stiffness > 0 || e->calibration > 0)
        cli_comment(w, "factors = %s", e->mean_one ? "mean 1" : "median 1");
    for (size_t k = 0; k < sizeof given / sizeof *given; k++)
        if (given[k].value > 0)
            cli_value(w, given[k].key, given[k].value);
    cli_value(w, "overlap", u->overlap);
    cli_comment(w, "seed = %llu", (unsigned long long)a->o.seed);
    if (e->missing > 0)
        cli_comment(w, "candidates = %d", u->candidates);
    if (u->samples > 0) {
        cli_value(w, "contacts_ratio", u->contacts);
        cli_value(w, "contacts_ratio_err", u->contacts_error);
        cli_comment(w, "without_sound = %d (of %d%s%s)", u->loose, u->samples, u->loose ? "; the first: " : "", u->why);
    }
}

/* Each row by itself, for a column has quantities of several dimensions. */
static double to_si(const arguments *a, const sp_uncertain *v, char unit[SP_UNIT_TEXT], sp_error *err) {
    double factor = 1;
    snprintf(unit, SP_UNIT_TEXT, "%s", v->unit);
    if (a->common.units == CLI_UNITS_SI && cli_material(&a->common))
        if (sp_unit_to_si(v->unit, cli_material(&a->common), &factor, unit, err) != SP_OK)
            return NAN;
    return factor;
}

static sp_status add_quantity(const arguments *a, const sp_uncertain *v, cli_writer *w) {
    char unit[SP_UNIT_TEXT];
    const double f = to_si(a, v, unit, w->err), *s = v->share;
    if (isnan(f))
        return w->err->status;
    return cli_row(w, v->name, unit, f * v->value, f * v->first_order, f * v->shift, f * v->sd, f * v->sd_error,
                   f * v->bias, f * v->bias_error, (int64_t)v->samples, verdicts[v->linear], s[SP_ERROR_POSITION],
                   s[SP_ERROR_RADIUS], s[SP_ERROR_FORCE], s[SP_ERROR_STIFFNESS], s[SP_ERROR_CALIBRATION],
                   s[SP_ERROR_FALSE]);
}

/* Stiffnesses that are given do not follow the forces. */
static void explain_force(const arguments *a, const cli_file *file) {
    const sp_network *net = &file->network;
    int32_t given = 0;
    for (int32_t k = 0; k < net->n_springs; k++)
        given += file->packing.contacts[net->springs[k].contact].kn > 0;
    if (given > 0 && a->o.errors.force > 0 && !file->scene->network.prestress)
        cli_note(&a->common,
                 "%s: --force does nothing to %d of %d contacts, whose stiffnesses are given and do not follow the "
                 "forces: see --stiffness",
                 file->path, given, net->n_springs);
}

static void explain(const arguments *a, const char *path, const sp_uncertainty *u) {
    int departs = 0;
    for (int32_t k = 0; k < u->n; k++)
        departs += u->quantity[k].linear == SP_LINEAR_NO;
    if (departs > 0)
        cli_note(&a->common, "%s: %d of %d quantities are not linear in these errors: take sd and bias", path, departs,
                 u->n);
    if (u->loose > 0)
        cli_note(&a->common, "%s: %d of %d drawn packings have no sound, and are left out of sd and bias", path,
                 u->loose, u->samples);
}

/* A row for each grain, or contact, with a column for each quantity. */
static sp_status add_parts(const arguments *a, const cli_file *file, const sp_uncertainty *u, cli_writer *w) {
    const bool grains = a->by == BY_GRAIN;
    const int32_t rows = grains ? u->grains : u->springs;
    if (!u->by_grain)
        return sp_fail(w->err, SP_EINVAL, "--by %s: is first order, which there is not with --prestress",
                       by_names[a->by]);
    if (u->n > CLI_CELLS_MAX - 5)
        return sp_fail(w->err, SP_EINVAL, "--modes %d: must be %d or less with --by", a->o.modes,
                       a->o.modes - (u->n - (CLI_CELLS_MAX - 5)));
    cli_columns(w, SP_COLUMN_INTEGER, grains ? "grain" : "i", "", grains ? NULL : "j", "", NULL);
    if (grains)
        cli_place_columns(w, file->packing.dim);
    for (int32_t q = 0; q < u->n; q++)
        cli_columns(w, SP_COLUMN_NUMBER, u->quantity[q].name, "", NULL);
    for (int32_t k = 0; k < rows && w->status == SP_OK; k++) {
        if (grains) {
            cli_put(w, u->grain[k]);
            cli_put_numbers(w, file->packing.dim, file->packing.x + 3 * (int64_t)u->grain[k]);
        } else {
            cli_put(w, u->pair[2 * k], u->pair[2 * k + 1]);
        }
        for (int32_t q = 0; q < u->n; q++)
            cli_put(w, (grains ? u->by_grain : u->by_contact)[(int64_t)q * rows + k]);
        cli_end_row(w);
    }
    return w->status;
}

static sp_status add_rows(void *user, cli_file *file, cli_writer *w) {
    arguments *a = user;
    sp_uncertainty u = sp_uncertainty_none();
    a->o.network = file->scene->network;
    a->o.moduli = !a->front_only;
    a->o.first_order = !a->sampled_only;
    a->o.threads = a->common.threads;
    a->o.parts = a->by != BY_QUANTITY;
    a->o.samples = a->o.parts ? 0 : a->o.samples;
    explain_force(a, file);
    sp_status status = sp_uncertainty_make(&file->packing, &a->o, &u, w->err);
    if (status == SP_OK) {
        add_comments(a, file, &u, w);
        status = w->status;
        explain(a, file->path, &u);
    }
    if (status == SP_OK && a->o.parts)
        status = add_parts(a, file, &u, w);
    for (int32_t k = 0; k < u.n && status == SP_OK && !a->o.parts; k++)
        status = add_quantity(a, &u.quantity[k], w);
    sp_uncertainty_free(&u);
    return status;
}

int cmd_uncertainty(int argc, char **argv) {
    static const cli_files command = {CLI_OF_NETWORK, .stop = true, .begin = add_columns, .add = add_rows};
    arguments a = {.o = sp_uncertainty_options_default()};
    a.o.samples = 200;
    a.o.seed = 1;
    a.o.modes = 0;
    cli_parse(&cmd_uncertainty_syntax, argc, argv, &a);
    return cli_run_files(&command, &a);
}
