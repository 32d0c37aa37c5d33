/* sonopack check: checks that packings are in mechanical equilibrium and consistent with their force law. */
#include "base/base.h"
#include "cli/files.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct arguments {
    cli_common common;
    double tolerance;
} arguments;

static const cli_option options[] = {
    {"tolerance", "EPS", "Largest relative error that passes (2e-5)", CLI_NUMBER, CLI_FIELD(tolerance), .high = 1},
    {0}};

const cli_syntax cmd_check_syntax = {
    .usage = "FILE...",
    .help =
        "Checks packings: structure, overlaps, contact forces, balance of forces and torques, Coulomb's condition, and "
        "the force on the walls.\vresidual is the largest of the relative errors, and reason names the first one above "
        "EPS (- if there is none). The other columns are the errors themselves:\n"
        "force and torque: the unbalanced force and torque of a grain, over p d^2.\n"
        "walls: the force on a wall against pressure times area.\n"
        "law: normal forces against Hertz's law.\n"
        "geometry: overlaps against positions.\n"
        "coulomb: the largest excess of a tangential force over friction times the normal force.\n"
        "missing: overlaps of grains, walls and periodic images that no contact lists.\n"
        "A field of the file that is at odds with its scene or its contacts fails too.\n"
        "\n"
        "The exit status is 1 if any file fails. A packing that was made with a larger packing.tolerance, or that was "
        "read from a file with few digits, may need a larger EPS.",
    .options = options,
    .file_name = "packing",
    .files_min = 1,
    .files_max = CLI_ANY_NUMBER};

static sp_status add_columns(void *user, cli_writer *w) {
    (void)user;
    cli_columns(w, SP_COLUMN_TEXT, "file", "", "ok", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "residual", "", NULL);
    cli_columns(w, SP_COLUMN_TEXT, "reason", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "force", "", "torque", "", "walls", "", "law", "", "geometry", "", "coulomb", "",
                "missing", "", NULL);
    return w->status;
}

/* A file that cannot be read has a row as well. */
static sp_status check_file(void *user, cli_file *file, cli_writer *w) {
    const arguments *a = user;
    const char *path = file->path;
    sp_packing p = sp_packing_none();
    sp_audit audit = {NAN, NAN, NAN, NAN, NAN, NAN, 0, 0, 0, NAN, NAN};
    sp_error fault = {0};
    char reason[SP_ERROR_TEXT] = "";
    double residual = NAN;
    sp_status status = sp_packing_read(path, &p, &fault);
    CLI_THEN(status, sp_packing_audit(&p, file->scene->network.threshold, &audit, &fault));
    if (status == SP_OK)
        residual = sp_audit_worst(&audit, a->tolerance, reason, sizeof reason);
    if (status == SP_OK && !*reason)
        status = sp_packing_check_stated(path, &p, &audit, &fault);
    if (status != SP_OK)
        snprintf(reason, sizeof reason, "%s", fault.text);
    file->failed = status != SP_OK || *reason;
    if (file->failed) {
        const bool named = status == SP_EIO || status == SP_EFORMAT; /* by what reads the file */
        sp_fail(&fault, SP_EFAILED, "%s%s%s", named ? "" : path, named ? "" : ": ", reason);
        cli_fail(&fault);
    }
    cli_keep_series(&p, file);
    sp_packing_free(&p);
    return cli_row(w, path, file->failed ? "no" : "yes", residual, file->failed ? reason : "-", audit.force_residual,
                   audit.torque_residual, audit.wall_residual, audit.law_residual, audit.geometry_residual,
                   audit.coulomb_excess, isnan(audit.law_residual) ? NAN : (double)audit.missing);
}

int cmd_check(int argc, char **argv) {
    static const cli_files command = {.groups = "network", .begin = add_columns, .add = check_file};
    arguments a = {.tolerance = CLI_AUDIT_TOLERANCE};
    cli_parse(&cmd_check_syntax, argc, argv, &a);
    return cli_run_files(&command, &a);
}
