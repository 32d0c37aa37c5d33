/* sonopack check: whether packings are what they say they are. */
#include "base/base.h"
#include "cli/verify.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct arguments {
    cli_common common;
    double tolerance;
    int files;
    char **file;
} arguments;

enum { KEY_TOLERANCE = 0x1000 };

static const struct argp_option options[] = {
    {"tolerance", KEY_TOLERANCE, "EPS", 0, "Largest relative error that is ok (2e-5)", 0}, {0}};
static const struct argp_child children[] = {{&cli_common_argp, 0, "Common options:", 90}, {0}};

static error_t parse(int key, char *arg, struct argp_state *state) {
    arguments *a = state->input;
    sp_error err;
    switch (key) {
    case ARGP_KEY_INIT: state->child_inputs[0] = &a->common; return 0;
    case KEY_TOLERANCE:
        if (cli_number("--tolerance", arg, 0, 1, &a->tolerance, &err) != SP_OK)
            argp_error(state, "%s", err.text);
        return 0;
    case ARGP_KEY_ARGS:
        a->file = state->argv + state->next;
        a->files = state->argc - state->next;
        return 0;
    case ARGP_KEY_NO_ARGS: argp_error(state, "no file: must be one packing or more"); return 0;
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp argp = {
    options,
    parse,
    "FILE...",
    "Audits packings: structure, overlaps, force law, balance of forces and torques, "
    "Coulomb, walls against the pressure.\v"
    "residual is the largest relative error of all measures, reason the first fault (- if there is none). Then each "
    "measure: force and torque, what is left of them on a grain over p d^2; walls, their force against pressure times "
    "area; law, normal forces against Hertz's; geometry, overlaps against positions; coulomb, the largest tangential "
    "force above friction times the normal force. The exit "
    "status is 1 if any file is not ok. A packing that was made with a larger packing.tolerance, or read from a file "
    "with few digits, may need a larger EPS.",
    children,
    NULL,
    NULL};

static sp_status add_columns(sp_table *t, sp_error *err) {
    static const struct {
        const char *name;
        sp_cell_kind kind;
    } columns[] = {{"file", SP_CELL_TEXT},     {"ok", SP_CELL_TEXT},      {"residual", SP_CELL_NUMBER},
                   {"reason", SP_CELL_TEXT},   {"force", SP_CELL_NUMBER}, {"torque", SP_CELL_NUMBER},
                   {"walls", SP_CELL_NUMBER},  {"law", SP_CELL_NUMBER},   {"geometry", SP_CELL_NUMBER},
                   {"coulomb", SP_CELL_NUMBER}};
    sp_status status = SP_OK;
    for (size_t k = 0; k < sizeof columns / sizeof *columns && status == SP_OK; k++)
        status = sp_table_add_column(t, columns[k].name, "", columns[k].kind, err);
    return status;
}

/* One row of the table; *good says whether the file is ok. */
static sp_status check_file(const arguments *a, const char *path, double threshold, sp_table *t, bool *good,
                            sp_error *err) {
    sp_packing p = sp_packing_none();
    sp_audit audit = {NAN, NAN, NAN, NAN, NAN, NAN, 0, 0, 0};
    sp_error fault = {0};
    char reason[SP_ERROR_TEXT] = "";
    double residual = NAN;
    sp_status status = sp_packing_read(path, &p, &fault);
    if (status == SP_OK)
        status = sp_packing_audit(&p, threshold, &audit, &fault);
    if (status == SP_OK)
        residual = sp_audit_worst(&audit, a->tolerance, reason, sizeof reason);
    else
        snprintf(reason, sizeof reason, "%s", fault.text);
    *good = status == SP_OK && *reason == '\0';
    if (!*good) {
        const bool named = status == SP_EIO || status == SP_EFORMAT; /* by what reads the file */
        sp_fail(&fault, SP_EFAILED, "%s%s%s", named ? "" : path, named ? "" : ": ", reason);
        cli_fail(&fault);
    }
    sp_packing_free(&p);
    return sp_table_add_row(t, err, path, *good ? "yes" : "no", residual, *good ? "-" : reason, audit.force_residual,
                            audit.torque_residual, audit.wall_residual, audit.law_residual, audit.geometry_residual,
                            audit.coulomb_excess);
}

static sp_status work(const arguments *a, bool *all_good, sp_error *err) {
    sp_scene scene = sp_scene_default();
    sp_table t = sp_table_none();
    sp_status status = cli_may_write_table(&a->common, err);
    if (status == SP_OK)
        status = cli_scene_of_sets(&a->common, "network", &scene, err);
    if (status == SP_OK)
        status = add_columns(&t, err);
    for (int k = 0; k < a->files && status == SP_OK; k++) {
        bool good = false;
        status = check_file(a, a->file[k], scene.network.threshold, &t, &good, err);
        *all_good = *all_good && good;
    }
    if (status == SP_OK)
        status = cli_write_table(&a->common, &t, err);
    sp_table_free(&t);
    sp_scene_free(&scene);
    return status;
}

int cmd_check(int argc, char **argv) {
    arguments a = {.tolerance = CLI_AUDIT_TOLERANCE};
    argp_parse(&argp, argc, argv, 0, NULL, &a);
    sp_error err = {0};
    bool all_good = true;
    if (work(&a, &all_good, &err) != SP_OK)
        return cli_fail(&err);
    return all_good ? CLI_OK : CLI_FAILED;
}
