/* sonopack moduli: prints elastic moduli and speeds of long waves, one row for each packing. */
#include "base/base.h"
#include "cli/files.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { PROBES_MAX = 64 };
#define SPEED "sqrt(E* / rho)"

typedef struct probe {
    const char *text; /* as it was given */
    bool global;      /* imposed strain */
    bool rings;       /* the inner ring grows and turns */
    double width;     /* of parts, of local moduli; 0: `probe`, unless global or rings */
    sp_probe probe;
} probe;

typedef struct arguments {
    cli_common common;
    double margin;
    int engine; /* 1: PETSc */
    int probes, strains;
    probe probe[PROBES_MAX];
    double strain[PROBES_MAX];
    int dim;    /* of the packings so far; 0: none */
    bool whole; /* the table has the whole tensor: of packings without a piston */
} arguments;

/* "global", "rings", "sine:N", "lines:N" or "local:W". */
static sp_status read_probe(const char *text, probe *out, sp_error *err) {
    const char *colon = strchr(text, ':');
    int64_t n = 0;
    *out = (probe){.text = text, .global = strcmp(text, "global") == 0, .rings = strcmp(text, "rings") == 0};
    if (out->global || out->rings)
        return SP_OK;
    if (strncmp(text, "local:", 6) == 0)
        return cli_number("--probe local:W", colon + 1, 1e-3, 1e6, &out->width, err);
    if (strncmp(text, "sine:", 5) == 0)
        out->probe.kind = SP_PROBE_SINE;
    else if (strncmp(text, "lines:", 6) == 0)
        out->probe.kind = SP_PROBE_LINES;
    else
        return sp_fail(err, SP_EINVAL, "--probe %.60s: must be global, rings, sine:N, lines:N or local:W", text);
    if (cli_integer("N", colon + 1, 1, 1000000, &n, err) != SP_OK) {
        sp_fail_prefix(err, "--probe %.60s", text);
        return SP_EINVAL;
    }
    if (out->probe.kind == SP_PROBE_LINES && n % 2 == 0)
        return sp_fail(err, SP_EINVAL, "--probe %.60s: N must be odd, so that every second line is displaced", text);
    out->probe.n = (int32_t)n;
    return SP_OK;
}

static sp_status add_probe(void *user, const char *text, sp_error *err) {
    arguments *a = user;
    if (a->probes == PROBES_MAX)
        return sp_fail(err, SP_EINVAL, "--probe: may be given at most %d times", PROBES_MAX);
    return read_probe(text, &a->probe[a->probes++], err);
}

static sp_status add_strain(void *user, const char *text, sp_error *err) {
    arguments *a = user;
    if (a->strains == PROBES_MAX)
        return sp_fail(err, SP_EINVAL, "--strain: may be given at most %d times", PROBES_MAX);
    return cli_number("--strain", text, 1e-12, 0.01, &a->strain[a->strains++], err);
}

static sp_status check(void *user, sp_error *err) {
    const arguments *a = user;
    if (a->strains > 0 && a->probes > 0)
        return sp_fail(err, SP_EINVAL, "--strain and --probe cannot be combined: their tables have different columns");
    for (int k = 0; k < a->probes; k++)
        if (a->probe[k].width > 0 && (a->probes > 1 || a->common.files > 1))
            return sp_fail(err, SP_EINVAL, "--probe %.60s: must be the only probe of one packing, whose parts it lists",
                           a->probe[k].text);
        else if (a->probe[k].rings && a->probes > 1)
            return sp_fail(err, SP_EINVAL, "--probe rings: must be the only probe: its table has other columns");
    return SP_OK;
}

static const char *const engine_words[] = {"sonopack", "petsc", NULL};

static const cli_option options[] = {
    {"margin", "D", "Leave layers of this thickness at all walls out of the density [d] (3)", CLI_NUMBER,
     CLI_FIELD(margin), .high = 1e6},
    {"probe", "KIND",
     "Apparent moduli (repeatable): sine:N, a body force with N half waves between the walls; lines:N, N displaced "
     "lines of grains, N odd; or global, the imposed strain. local:W, alone: moduli of parts about W d wide. rings, "
     "alone: between two rings, of which the inner one grows or turns",
     .parse = add_probe},
    {"strain", "EPS",
     "Moduli at a finite strain of 1e-12 to 0.01, with the full contact law instead of linear springs (repeatable)",
     .parse = add_strain},
    {.help = "Beyond one machine (docs/cluster.md):"},
    {"engine", "sonopack|petsc", "Program that computes the moduli; petsc: on N ranks after mpirun -n N (sonopack)",
     CLI_CHOICE, CLI_FIELD(engine), .words = engine_words},
    {0}};

const cli_syntax cmd_moduli_syntax = {
    .usage = "FILE...",
    .help =
        "Elastic moduli of packings from an imposed homogeneous strain, in which the contact points on the walls take "
        "part. A chain has only C22.\vIn two dimensions axis 1 is along the walls and axis 2 points from wall to wall; "
        "c_l = sqrt(C22/Phi3*) and c_t = sqrt(C33/Phi3*), where Phi3* is the volume fraction without rattlers, away "
        "from the walls. In three dimensions axes 1 and 2 are along the walls and axis 3 points from wall to wall; "
        "C44, C55 and C66 are the shear moduli of 23, 13 and 12, c_l = sqrt(C33/Phi3*) and c_t = sqrt((C44+C55)/(2 "
        "Phi3*)). Shear moduli along the walls and c_t are nan without friction, because a smooth wall cannot shear; "
        "--probe sine:1 can. c_l and c_t are nan where the packing is too low to have a bulk (see --margin). With "
        "--probe the table has apparent moduli on smaller scales, and their ratios to those of the global strain; with "
        "--probe local:W one row for each of the equal parts of the packing, with the changes of its stress for a "
        "strain of the whole: their mean is the modulus of the whole, which comments tell with mean and standard "
        "deviation (_mean, _sd). With --probe rings it has the pressures on both rings over the relative growth of the "
        "inner one (p_inner, p_outer), with K and G of the elastic annulus between fixed rings that answers in the "
        "same way (Lame); and the torque over the angle by which the inner ring turns, with G of it (G_turn). With "
        "--strain it has changes of stress divided by the strain, for packings that are brought back to equilibrium, "
        "and counts the contacts that slide or open. --set takes keys of the group network.\n"
        "\n"
        "A periodic cell is strained itself, and a box or two rings by all of their walls; read \"along the up axis\" "
        "for \"from wall to wall\". Their tables have further columns: the rest of the stiffness tensor in Voigt's "
        "notation (in two dimensions 3 is the shear, so C13 and C23 couple it to the axes), the bulk modulus K and the "
        "shear modulus G of its isotropic part (Voigt's averages), the anisotropy |C - isotropic part|/|C|, and K_err, "
        "G_err, anisotropy_err. Columns _err are bounds of the errors, C_err that of all components.",
    CLI_PACKINGS,
    .options = options,
    .springs = true,
    .check = check};

/* Whether the walls cannot shear the packing, so that its shear moduli are nan. */
static bool no_shear(int dim, const sp_moduli *m) { return dim > 1 && isnan(dim == 3 ? m->c55 : m->c33); }

static const char *moduli_of(int dim) { return dim == 3 ? "C11 C12 C13 C22 C23 C33 C44 C55 C66" : "C11 C12 C22 C33"; }

/* ---- of an imposed strain ---------------------------------------------------------------------------------------- */

/* Notes which strains the network does not resist, or even helps. */
static void explain_mechanisms(const arguments *a, const char *path, const sp_moduli *m) {
    const char *symbols = "C11 C22 C33 C44 C55 C66";
    const sp_quantity *of;
    while ((of = sp_quantity_next(sp_moduli_quantities, &symbols))) {
        const double value = sp_quantity_value(of, m);
        if (value == 0)
            cli_note(&a->common, "%s: %s is 0: the grains can follow this strain without deforming a contact", path,
                     of->symbol);
        if (value < 0)
            cli_note(&a->common, "%s: %s is below 0: at its prestress the packing gives way to this strain", path,
                     of->symbol);
    }
}

/* Notes why values of the row are nan. */
static void explain(const arguments *a, const cli_file *file, double density, const sp_moduli *m) {
    const int dim = file->packing.dim;
    if (dim == 1)
        cli_note(&a->common, "%s: a chain has only C22; the other moduli are nan", file->path);
    else if (no_shear(dim, m))
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

/* The rest of the tensor, of cells without a piston: rows and columns of C, in Voigt's notation. */
static void whole_columns(int dim, cli_writer *w) {
    if (dim == 3)
        cli_columns(w, SP_COLUMN_NUMBER, "C14", "E*", "C15", "E*", "C16", "E*", "C24", "E*", "C25", "E*", "C26", "E*",
                    "C34", "E*", "C35", "E*", "C36", "E*", "C45", "E*", "C46", "E*", "C56", "E*", NULL);
    else
        cli_columns(w, SP_COLUMN_NUMBER, "C13", "E*", "C23", "E*", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "K", "E*", "K_err", "E*", "G", "E*", "G_err", "E*", "anisotropy", "",
                "anisotropy_err", "", NULL);
}

static void put_whole(const sp_elasticity *e, cli_writer *w) {
    const int axes = e->strains == SP_STRAINS_MAX ? 3 : 2;
    for (int a = 0; a < e->strains; a++)
        for (int b = a + 1; b < e->strains; b++)
            if (b >= axes)
                cli_put(w, e->c[a][b]);
    cli_put(w, e->bulk, e->bulk_error, e->shear, e->shear_error, e->anisotropy, e->anisotropy_error);
}

/* A bound of the error of sqrt(C/density), from that of C and the rounding of a sum over n grains. */
static double speed_error(double speed, double error, double density, int32_t n) {
    return fmin(error / density / speed, sqrt(error / density)) + 4 * n * DBL_EPSILON * speed;
}

static void put_errors(const cli_file *file, double density, const sp_moduli *m, const sp_elasticity *e,
                       cli_writer *w) {
    const bool space = file->packing.dim == 3;
    double most = 0;
    for (int a = 0; a < e->strains; a++)
        for (int b = 0; b < e->strains; b++)
            most = fmax(most, e->error[a][b]);
    cli_put(w, most, speed_error(m->c_l, space ? m->error33 : m->error22, density, file->packing.n),
            speed_error(m->c_t, space ? 0.5 * (m->error44 + m->error55) : m->error33, density, file->packing.n));
}

static void global_row(const arguments *a, const cli_file *file, cli_writer *w) {
    double density;
    sp_moduli m;
    sp_elasticity whole;
    w->status = sp_packing_density(&file->packing, file->scene->network.threshold, a->margin, &density, w->err);
    CLI_THEN(w->status, sp_elasticity_make(&file->network, density, &m, &whole, w->err));
    if (w->status != SP_OK)
        return;
    explain(a, file, density, &m);
    cli_put_text(w, file->path);
    cli_put(w, file->packing.pressure);
    cli_put_quantities(w, sp_moduli_quantities, moduli_of(file->packing.dim), &m);
    cli_put_quantities(w, sp_moduli_quantities, "c_l c_t", &m);
    if (a->whole)
        put_whole(&whole, w);
    put_errors(file, density, &m, &whole, w);
    cli_end_row(w);
}

/* ---- --probe: apparent moduli on smaller scales ------------------------------------------------------------------ */

static void explain_probe(const arguments *a, const cli_file *file, const char *name, const sp_probe_moduli *m) {
    if (file->packing.dim > 1 && isnan(m->shear))
        cli_note(&a->common, "%s: %s of %s is nan: grains slip along a wall without friction", file->path,
                 file->packing.dim == 3 ? "C55" : "C33", name);
    if (m->concentrated > 0.25)
        cli_note(&a->common,
                 "%s: %s: grain %d, which is loosely held, has %.2g of the elastic energy: these are not moduli of the "
                 "packing",
                 file->path, name, m->grain, m->concentrated);
    if (m->left_out > 0)
        cli_note(&a->common,
                 "%s: %s: %.2g of the squared body force is left out, because it acts on floppy parts, which no "
                 "contact holds",
                 file->path, name, m->left_out);
}

/* Notes why values of the rows are nan, and which moduli are not to be trusted. */
static void explain_probes(const arguments *a, const cli_file *file, const sp_moduli *global,
                           const sp_probe_moduli *each) {
    const int dim = file->packing.dim;
    if (dim == 1)
        cli_note(&a->common, "%s: a chain has only C22; C33 is nan", file->path);
    else if (no_shear(dim, global))
        cli_note(&a->common,
                 "%s: %s of the global strain and ratios to it are nan: walls without friction cannot shear a packing; "
                 "sine:N uses cosines for the shear instead, which exert no shear on the walls",
                 file->path, dim == 3 ? "C55" : "C33");
    for (int k = 0; k < a->probes; k++)
        if (!a->probe[k].global)
            explain_probe(a, file, a->probe[k].text, &each[k]);
}

static void probe_rows(const arguments *a, const cli_file *file, double density, cli_writer *w) {
    sp_probe asked[PROBES_MAX];
    sp_probe_moduli measured[PROBES_MAX], each[PROBES_MAX];
    sp_moduli m;
    int32_t count = 0, at = 0;
    for (int k = 0; k < a->probes; k++)
        if (!a->probe[k].global)
            asked[count++] = a->probe[k].probe;
    w->status = sp_moduli_probe(&file->network, density, count, asked, &m, measured, w->err);
    if (w->status != SP_OK)
        return;
    const bool space = file->packing.dim == 3;
    const double along = space ? m.c33 : m.c22, shear = space ? m.c55 : m.c33;
    const sp_probe_moduli global = {.along = along,
                                    .shear = shear,
                                    .error_along = space ? m.error33 : m.error22,
                                    .error_shear = space ? m.error55 : m.error33};
    for (int k = 0; k < a->probes; k++)
        each[k] = a->probe[k].global ? global : measured[at++];
    explain_probes(a, file, &m, each);
    for (int k = 0; k < a->probes; k++) {
        const double l = each[k].along, s = each[k].shear;
        cli_put_text(w, file->path);
        cli_put(w, file->packing.pressure);
        if (a->probes > 1)
            cli_put_text(w, a->probe[k].text);
        cli_put(w, l, s, l / along, shear > 0 ? s / shear : NAN, each[k].error_along, each[k].error_shear);
        cli_end_row(w);
    }
}

/* ---- --probe local:W: moduli of parts ---------------------------------------------------------------------------- */

/* Components of the tensor, of which strains are those of the whole, so that it is not symmetric. */
static const char *local_components(int dim) {
    return dim == 3 ? "C11 C12 C13 C21 C22 C23 C31 C32 C33 C44 C55 C66" : "C11 C12 C21 C22 C33";
}

static double pure_shear(const double *c) { return 0.25 * (c[0] + c[4] - c[1] - c[3]); }

/* What the comments tell of part q; -1: of the whole. */
static const char *const local_names[] = {"K", "G", "G_pure", "C33"};
static double local_value(const sp_local_moduli *m, int which, int32_t q) {
    const double *c = q < 0 ? m->whole : m->c + (int64_t)q * m->strains * m->strains;
    switch (which) {
    case 0: return q < 0 ? m->whole_bulk : m->bulk[q];
    case 1: return q < 0 ? m->whole_shear : m->shear[q];
    case 2: return pure_shear(c);
    default: return c[8];
    }
}

/* The modulus of the whole, the mean over the parts, and the standard deviation of the parts. */
static void local_comments(const sp_local_moduli *m, cli_writer *w) {
    cli_value(w, "edge_x", m->edge_x);
    cli_value(w, "edge_y", m->edge_y);
    if (m->strains == SP_STRAINS_MAX)
        cli_value(w, "edge_z", m->edge_z);
    for (int k = 0; k < (m->strains == SP_STRAINS_MAX ? 2 : 4); k++) {
        double mean = 0, squares = 0;
        char key[32];
        for (int32_t q = 0; q < m->n; q++)
            mean += local_value(m, k, q) / m->n;
        for (int32_t q = 0; q < m->n; q++)
            squares += (local_value(m, k, q) - mean) * (local_value(m, k, q) - mean) / m->n;
        cli_value(w, local_names[k], local_value(m, k, -1));
        snprintf(key, sizeof key, "%s_mean", local_names[k]);
        cli_value(w, key, mean);
        snprintf(key, sizeof key, "%s_sd", local_names[k]);
        cli_value(w, key, sqrt(squares));
    }
    cli_value(w, "C_err", m->whole_error);
}

static void local_columns(int dim, cli_writer *w) {
    char name[4] = "";
    cli_place_columns(w, dim);
    for (const char *at = local_components(dim); *at; at += strspn(at, " ")) {
        memcpy(name, at, 3);
        cli_columns(w, SP_COLUMN_NUMBER, name, "E*", NULL);
        at += 3;
    }
    cli_columns(w, SP_COLUMN_NUMBER, "K", "E*", "G", "E*", NULL);
    if (dim == 2)
        cli_columns(w, SP_COLUMN_NUMBER, "G_pure", "E*", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "error", "E*", NULL);
    cli_columns(w, SP_COLUMN_INTEGER, "grains", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "contacts", "", NULL);
}

static void local_row(const cli_file *file, const sp_local_moduli *m, int32_t q, cli_writer *w) {
    const int dim = file->packing.dim;
    const double *c = m->c + (int64_t)q * m->strains * m->strains;
    cli_put_text(w, file->path);
    cli_put(w, file->packing.pressure);
    cli_put_numbers(w, dim, m->x + 3 * (int64_t)q);
    for (const char *at = local_components(dim); *at; at += 3, at += strspn(at, " "))
        cli_put(w, c[(at[1] - '1') * m->strains + at[2] - '1']);
    cli_put(w, m->bulk[q], m->shear[q]);
    if (dim == 2)
        cli_put(w, pure_shear(c));
    cli_put(w, m->error[q], m->grains[q], m->contacts[q]);
    cli_end_row(w);
}

static void local_rows(const arguments *a, const cli_file *file, cli_writer *w) {
    sp_local_moduli m = sp_local_moduli_none();
    w->status = sp_local_moduli_make(&file->network, a->probe[0].width, &m, w->err);
    if (w->status != SP_OK)
        return;
    int32_t empty = 0;
    local_comments(&m, w);
    for (int32_t q = 0; q < m.n && w->status == SP_OK; q++) {
        local_row(file, &m, q, w);
        empty += m.contacts[q] == 0;
    }
    if (empty > 0)
        cli_note(&a->common, "%s: %d of %d parts have no contact, and moduli of 0", file->path, empty, m.n);
    sp_local_moduli_free(&m);
}

/* ---- --probe rings ----------------------------------------------------------------------------------------------- */

static void ring_row(const arguments *a, const cli_file *file, cli_writer *w) {
    sp_ring_moduli m;
    w->status = sp_ring_moduli_make(&file->network, &m, w->err);
    if (w->status != SP_OK)
        return;
    if (isnan(m.shear_turn))
        cli_note(&a->common, "%s: the inner ring turns freely, and G_turn is nan", file->path);
    cli_put_text(w, file->path);
    cli_put(w, file->packing.pressure, m.p_inner, m.p_outer, m.torque, m.bulk, m.error_bulk, m.shear, m.error_shear,
            m.shear_turn, m.error_shear_turn);
    cli_end_row(w);
}

/* ---- --strain: at a finite strain -------------------------------------------------------------------------------- */

static void strained_row(const cli_file *file, double strain, const sp_finite_strain *s, cli_writer *w) {
    cli_put_text(w, file->path);
    cli_put(w, file->packing.pressure, strain);
    cli_put_quantities(w, sp_moduli_quantities, moduli_of(file->packing.dim), &s->moduli);
    cli_put(w, s->sliding, s->lost, s->made, s->residual);
    cli_end_row(w);
}

static void strained_rows(const arguments *a, const cli_file *file, cli_writer *w) {
    const sp_packing *p = &file->packing;
    for (int k = 0; k < a->strains && w->status == SP_OK; k++) {
        sp_finite_strain_options o = sp_finite_strain_options_default();
        sp_finite_strain s;
        o.strain = a->strain[k];
        w->status = sp_moduli_finite_strain(p, &file->network, NAN, &o, &s, w->err);
        if (w->status != SP_OK)
            return;
        strained_row(file, o.strain, &s, w);
        if (k == 0 && p->dim == 1)
            cli_note(&a->common, "%s: a chain has only C22; the other moduli are nan", file->path);
        if (k == 0 && no_shear(p->dim, &s.moduli))
            cli_note(&a->common, "%s: shear moduli are nan: walls without friction cannot shear a packing", file->path);
        cli_debug(&a->common, "%s: strain %g: %d solves, %d factorisations", file->path, o.strain, s.solves, s.factors);
    }
}

/* ---- the table --------------------------------------------------------------------------------------------------- */

static bool has_parts(const arguments *a) { return a->probes == 1 && a->probe[0].width > 0; }

static bool has_rings(const arguments *a) { return a->probes == 1 && a->probe[0].rings; }

static bool has_probes(const arguments *a) { return a->probes > 1 || (a->probes == 1 && !a->probe[0].global); }

static void add_columns(const arguments *a, int dim, cli_writer *w) {
    cli_columns(w, SP_COLUMN_TEXT, "file", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "p", "E*", NULL);
    if (a->strains > 0) {
        cli_columns(w, SP_COLUMN_NUMBER, "strain", "", NULL);
        cli_quantity_columns(w, sp_moduli_quantities, moduli_of(dim));
        cli_columns(w, SP_COLUMN_INTEGER, "sliding", "", "lost", "", "made", "", NULL);
        cli_columns(w, SP_COLUMN_NUMBER, "residual", "", NULL);
    } else if (has_parts(a)) {
        local_columns(dim, w);
    } else if (has_rings(a)) {
        cli_columns(w, SP_COLUMN_NUMBER, "p_inner", "E*", "p_outer", "E*", "torque", "E* d^3", "K", "E*", "K_err", "E*",
                    "G", "E*", "G_err", "E*", "G_turn", "E*", "G_turn_err", "E*", NULL);
    } else if (has_probes(a)) {
        if (a->probes > 1)
            cli_columns(w, SP_COLUMN_TEXT, "probe", "", NULL);
        cli_columns(w, SP_COLUMN_NUMBER, dim == 3 ? "C33" : "C22", "E*", dim == 3 ? "C55" : "C33", "E*",
                    dim == 3 ? "C33_ratio" : "C22_ratio", "", dim == 3 ? "C55_ratio" : "C33_ratio", "",
                    dim == 3 ? "C33_err" : "C22_err", "E*", dim == 3 ? "C55_err" : "C33_err", "E*", NULL);
    } else {
        cli_quantity_columns(w, sp_moduli_quantities, moduli_of(dim));
        cli_quantity_columns(w, sp_moduli_quantities, "c_l c_t");
        if (a->whole)
            whole_columns(dim, w);
        cli_columns(w, SP_COLUMN_NUMBER, "C_err", "E*", "c_l_err", SPEED, "c_t_err", SPEED, NULL);
    }
}

/* The first packing decides the columns. */
static sp_status check_alike(const arguments *a, int dim, bool whole, sp_error *err) {
    if (a->dim != 0 && (dim == 3) != (a->dim == 3))
        return sp_fail(err, SP_EREFUSED,
                       "a packing in %d dimensions after one in %d: their moduli have different names, so they must "
                       "be in separate tables",
                       dim, a->dim);
    if (a->dim != 0 && whole != a->whole)
        return sp_fail(err, SP_EREFUSED,
                       "a packing %s a piston after one %s: the table of a periodic cell or a box has more columns, so "
                       "they must be in separate tables",
                       whole ? "without" : "with", whole ? "with" : "without");
    return SP_OK;
}

static sp_status add_rows(void *user, cli_file *file, cli_writer *w) {
    arguments *a = user;
    const int dim = file->packing.dim;
    const bool whole = dim > 1 && file->packing.cell != SP_CELL_PISTON;
    sp_statics s;
    w->status = sp_statics_make(&file->packing, file->scene->network.threshold, a->margin, &s, w->err);
    if (!has_rings(a))
        CLI_THEN(w->status, check_alike(a, dim, whole, w->err));
    if (w->status == SP_OK && a->dim == 0) {
        a->whole = whole;
        a->dim = dim;
        add_columns(a, dim, w);
    }
    if (w->status != SP_OK)
        return w->status;
    if (a->strains > 0)
        strained_rows(a, file, w);
    else if (has_parts(a))
        local_rows(a, file, w);
    else if (has_rings(a))
        ring_row(a, file, w);
    else if (has_probes(a))
        probe_rows(a, file, s.phi3s, w);
    else
        global_row(a, file, w);
    return w->status;
}

int cmd_moduli(int argc, char **argv) {
    static const cli_files command = {CLI_OF_NETWORK, .add = add_rows};
    arguments a = {.margin = 3};
    cli_parse(&cmd_moduli_syntax, argc, argv, &a);
    if (a.engine)
        return cmd_engine("sonopack moduli-petsc", argc, argv);
    return cli_run_files(&command, &a);
}
