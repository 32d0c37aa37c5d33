/* sonopack moduli: prints elastic moduli and speeds of long waves, one row for each packing. */
#include "base/base.h"
#include "cli/moduli.h"

#include <math.h>
#include <string.h>

/* "global", "sine:N" or "lines:N". */
static sp_status read_probe(const char *text, moduli_probe *out, sp_error *err) {
    const char *colon = strchr(text, ':');
    int64_t n = 0;
    *out = (moduli_probe){.text = text, .global = strcmp(text, "global") == 0};
    if (out->global)
        return SP_OK;
    if (strncmp(text, "sine:", 5) == 0)
        out->probe.kind = SP_PROBE_SINE;
    else if (strncmp(text, "lines:", 6) == 0)
        out->probe.kind = SP_PROBE_LINES;
    else
        return sp_fail(err, SP_EINVAL, "--probe %.60s: must be global, sine:N or lines:N", text);
    if (cli_integer("N", colon + 1, 1, 1000000, &n, err) != SP_OK) {
        sp_fail_prefix(err, "--probe %.60s", text);
        return SP_EINVAL;
    }
    if (out->probe.kind == SP_PROBE_LINES && n % 2 == 0)
        return sp_fail(err, SP_EINVAL, "--probe %.60s: N must be odd, so that every second line is displaced", text);
    out->probe.n = (int32_t)n;
    return SP_OK;
}

static sp_status add_probe(void *arguments, const char *text, sp_error *err) {
    moduli_arguments *a = arguments;
    if (a->probes == MODULI_PROBES_MAX)
        return sp_fail(err, SP_EINVAL, "--probe: may be given at most %d times", MODULI_PROBES_MAX);
    return read_probe(text, &a->probe[a->probes++], err);
}

static sp_status add_strain(void *arguments, const char *text, sp_error *err) {
    moduli_arguments *a = arguments;
    if (a->strains == MODULI_PROBES_MAX)
        return sp_fail(err, SP_EINVAL, "--strain: may be given at most %d times", MODULI_PROBES_MAX);
    return cli_number("--strain", text, 1e-12, 0.01, &a->strain[a->strains++], err);
}

static sp_status check(void *arguments, sp_error *err) {
    const moduli_arguments *a = arguments;
    if (a->strains > 0 && a->probes > 0)
        return sp_fail(err, SP_EINVAL, "--strain and --probe cannot be combined: their tables have different columns");
    return SP_OK;
}

static const cli_option options[] = {
    {"margin", "D", "Leave layers of this thickness at all walls out of the density [d] (3)", CLI_NUMBER,
     .field = offsetof(moduli_arguments, margin), .high = 1e6},
    {"probe", "KIND",
     "Apparent moduli (repeatable): sine:N, a body force with N half waves between the walls; lines:N, N displaced "
     "lines of grains, N odd; or global, the imposed strain",
     .parse = add_probe},
    {"strain", "EPS",
     "Moduli at a finite strain of 1e-12 to 0.01, with the full contact law instead of linear springs (repeatable)",
     .parse = add_strain},
    {0}};

static const cli_syntax syntax = {
    .usage = "FILE...",
    .help =
        "Elastic moduli of packings from an imposed homogeneous strain, in which the contact points on the walls "
        "take part. A chain has only C22.\v"
        "In two dimensions axis 1 is along the walls and axis 2 points from wall to wall; c_l = sqrt(C22/Phi3*) and "
        "c_t = sqrt(C33/Phi3*), where Phi3* is the volume fraction without rattlers, away from the walls. In three "
        "dimensions axes 1 and 2 are along the walls and axis 3 points from wall to wall; C44, C55 and C66 are the "
        "shear moduli of 23, 13 and 12, c_l = sqrt(C33/Phi3*) and c_t = sqrt((C44+C55)/(2 Phi3*)). Shear moduli and "
        "c_t are nan without friction, because a smooth wall cannot shear; --probe sine:1 can. c_l and c_t are nan "
        "where the packing is too low to have a bulk (see --margin). With --probe the table has apparent moduli on "
        "smaller scales, and their ratios to those of the global strain. With --strain it has changes of stress "
        "divided by the strain, for packings that are brought back to equilibrium, and counts the contacts that "
        "slide or open. --set takes keys of the group network.\n"
        "\n"
        "A periodic cell is strained itself, and a box by all of its walls; read \"along the up axis\" for \"from wall "
        "to "
        "wall\". Their tables have further columns: the rest of the stiffness tensor in Voigt's notation (in two "
        "dimensions 3 is the shear, so C13 and C23 couple it to the axes), the bulk modulus K and the shear modulus G "
        "of its isotropic part (Voigt's averages), the anisotropy |C - isotropic part|/|C|, and bounds of the errors: "
        "K_err, G_err, anisotropy_err, and C_err of all components.",
    .finds_material = true,
    .options = options,
    .file_name = "packing",
    .files_min = 1,
    .files_max = CLI_ANY_NUMBER,
    .springs = true,
    .check = check};

/* Notes which strains the network does not resist, or even helps. */
static void explain_mechanisms(const moduli_arguments *a, const char *path, const sp_moduli *m) {
    const struct {
        const char *name;
        double value;
    } each[] = {{"C11", m->c11}, {"C22", m->c22}, {"C33", m->c33}, {"C44", m->c44}, {"C55", m->c55}, {"C66", m->c66}};
    for (size_t k = 0; k < sizeof each / sizeof *each; k++) {
        if (each[k].value == 0)
            cli_note(&a->common, "%s: %s is 0: the grains can follow this strain without deforming a contact", path,
                     each[k].name);
        if (each[k].value < 0)
            cli_note(&a->common, "%s: %s is below 0: at its prestress the packing gives way to this strain", path,
                     each[k].name);
    }
}

/* Notes why values of the row are nan. */
static void explain(const moduli_arguments *a, const cli_file *file, double density, const sp_moduli *m) {
    const int dim = file->packing.dim;
    if (dim == 1)
        cli_note(&a->common, "%s: a chain has only C22; the other moduli are nan", file->path);
    else if (moduli_no_shear(dim, m))
        cli_note(&a->common,
                 "%s: %s and c_t are nan: walls without friction cannot shear a packing; --probe sine:1 shears it with "
                 "a body force",
                 file->path, dim == 3 ? "C44, C55" : "C33");
    explain_mechanisms(a, file->path, m);
    if (isnan(density))
        cli_note(&a->common,
                 "%s: c_l and c_t are nan: no grain of this packing, which is %.3g d high, is %.3g d away from both "
                 "walls; see --margin",
                 file->path, sp_packing_height(&file->packing), a->margin);
}

static sp_status global_row(const moduli_arguments *a, const cli_file *file, double density, sp_table *t,
                            sp_error *err) {
    const double pressure = file->packing.pressure;
    sp_moduli m;
    sp_elasticity whole;
    sp_status status = sp_elasticity_make(&file->network, density, &m, &whole, err);
    if (status != SP_OK)
        return status;
    explain(a, file, density, &m);
    if (a->whole)
        return moduli_whole_row(file->path, pressure, &m, &whole, t, err);
    if (file->packing.dim == 3)
        return sp_table_add_row(t, err, file->path, pressure, m.c11, m.c12, m.c13, m.c22, m.c23, m.c33, m.c44, m.c55,
                                m.c66, m.c_l, m.c_t);
    return sp_table_add_row(t, err, file->path, pressure, m.c11, m.c12, m.c22, m.c33, m.c_l, m.c_t);
}

static bool has_probes(const moduli_arguments *a) { return a->probes > 1 || (a->probes == 1 && !a->probe[0].global); }

static sp_status add_columns(const moduli_arguments *a, int dim, sp_table *t, sp_error *err) {
    cli_writer w = {.table = t, .err = err};
    cli_columns(&w, SP_CELL_TEXT, "file", "", NULL);
    cli_columns(&w, SP_CELL_NUMBER, "p", "E*", NULL);
    if (a->strains > 0) {
        moduli_strained_columns(&w, dim);
    } else if (has_probes(a)) {
        moduli_probe_columns(&w, a, dim);
    } else {
        moduli_columns(&w, dim);
        cli_columns(&w, SP_CELL_NUMBER, "c_l", "sqrt(E* / rho)", "c_t", "sqrt(E* / rho)", NULL);
        if (a->whole)
            moduli_whole_columns(&w, dim);
    }
    return w.status;
}

/* Adds the rows of one packing. The first packing decides the columns. */
static sp_status add_rows(void *arguments, cli_file *file, sp_table *t, sp_error *err) {
    moduli_arguments *a = arguments;
    const int dim = file->packing.dim;
    const bool whole = dim > 1 && file->packing.cell != SP_CELL_PISTON;
    sp_statics s;
    sp_status status = sp_statics_make(&file->packing, file->scene->network.threshold, a->margin, &s, err);
    if (status == SP_OK && a->dim != 0 && (dim == 3) != (a->dim == 3))
        status = sp_fail(err, SP_EREFUSED,
                         "a packing in %d dimensions after one in %d: their moduli have different names, so they must "
                         "be in separate tables",
                         dim, a->dim);
    if (status == SP_OK && a->dim != 0 && whole != a->whole)
        status =
            sp_fail(err, SP_EREFUSED,
                    "a packing %s a piston after one %s: the table of a periodic cell or a box has more columns, so "
                    "they must be in separate tables",
                    whole ? "without" : "with", whole ? "with" : "without");
    if (status == SP_OK && a->dim == 0) {
        a->whole = whole;
        status = add_columns(a, dim, t, err);
        a->dim = dim;
    }
    if (status != SP_OK)
        return status;
    if (a->strains > 0)
        return moduli_strained_rows(a, file, t, err);
    if (has_probes(a))
        return moduli_probe_rows(a, file, s.phi3s, t, err);
    double density;
    status = sp_packing_density(&file->packing, file->scene->network.threshold, a->margin, &density, err);
    return status == SP_OK ? global_row(a, file, density, t, err) : status;
}

int cmd_moduli(int argc, char **argv) {
    static const cli_files command = {.groups = "network", .contents = CLI_NETWORK, .add = add_rows};
    moduli_arguments a = {.margin = 3};
    cli_parse(&syntax, argc, argv, &a);
    return cli_run_files(&command, &a);
}
