/* sonopack convert: import and export of packings. */
#include "base/base.h"
#include "cli/output.h"

#include <string.h>
#include <unistd.h>

typedef struct arguments {
    cli_common common;
    const char *grains, *contacts; /* the two tables; NULL: none */
    const char *in, *out;          /* packing files as given; NULL: none */
} arguments;

enum { KEY_GRAINS = 0x1000, KEY_CONTACTS };

static const struct argp_option options[] = {
    {"grains", KEY_GRAINS, "FILE.tsv", 0, "Table of grains: id x y [z] radius", 0},
    {"contacts", KEY_CONTACTS, "FILE.tsv", 0, "Table of contacts: i j nx ny [nz] overlap Fn Ft", 0},
    {0}};
static const struct argp_child children[] = {{&cli_common_argp, 0, "Common options:", 90}, {0}};

static error_t parse(int key, char *arg, struct argp_state *state) {
    arguments *a = state->input;
    switch (key) {
    case ARGP_KEY_INIT: state->child_inputs[0] = &a->common; return 0;
    case KEY_GRAINS: a->grains = arg; return 0;
    case KEY_CONTACTS: a->contacts = arg; return 0;
    case ARGP_KEY_ARG:
        if (!a->in)
            a->in = arg;
        else if (!a->out)
            a->out = arg;
        else
            argp_error(state, "%s: must be two files at the most, IN and OUT", arg);
        return 0;
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp argp = {
    options,
    parse,
    "IN OUT [--grains G.tsv --contacts C.tsv]\nIN --grains G.tsv --contacts C.tsv\nOUT --grains G.tsv --contacts C.tsv",
    "Converts packings: HDF5 (.h5), one text file (.txt), or two tables.\v"
    "IN is told by its content, OUT by its ending: .h5 or .txt. With the two tables and one packing file, the packing "
    "is "
    "made from the tables if they are there and it is not, and the tables from the packing if it is the other way "
    "round. A table may also take the place of IN or OUT, then --contacts alone says the other one:\n"
    "  sonopack convert grains.tsv P.h5 --contacts contacts.tsv\n"
    "With IN, OUT and both tables the packing is written in both forms.\n"
    "Box and material of tables stand in their comment lines `# key = value', or in --set key=value: width, depth "
    "(3D), "
    "height, pressure, friction, poisson, wall, seed. Lengths are in mean grain diameters, pressures in E*.",
    children,
    NULL,
    NULL};

static bool is_file(const char *path) { return access(path, F_OK) == 0; }

/* ---- what is asked for ----------------------------------------------------------------------------------------- */

/* One packing file and both tables: which way, by what is there. */
static sp_status choose_direction(arguments *a, sp_error *err) {
    const bool tables = is_file(a->grains) && is_file(a->contacts), packing = is_file(a->in);
    if (tables && packing)
        return sp_fail(err, SP_EINVAL,
                       "%s and both tables exist: must be `convert %s %s --contacts ...' to write the tables, or "
                       "`convert %s %s --contacts ...' to read them",
                       a->in, a->in, a->grains, a->grains, a->in);
    if (tables || (!packing && (is_file(a->grains) || is_file(a->contacts)))) {
        a->out = a->in;
        a->in = NULL;
    }
    return SP_OK;
}

/* Puts what the command line says in order: afterwards `in` is the packing to read (NULL: the tables) and `out` the
 * packing to write (NULL: none); tables that are not read are written. */
static sp_status understand(arguments *a, sp_error *err) {
    if (a->common.output && a->in && a->out)
        return sp_fail(err, SP_EINVAL, "OUT is given twice: %s and -o %s", a->out, a->common.output);
    const bool two = a->in && (a->out || a->common.output);
    if (a->common.output)
        a->out = a->common.output;
    if (!a->in && !a->out)
        return sp_fail(err, SP_EINVAL, "no file: must be IN and OUT, see `sonopack help convert'");
    if (two && (!a->grains || strcmp(a->grains, a->in) == 0) && cli_has_ending(a->in, ".tsv")) {
        a->grains = a->in;
        a->in = NULL;
    } else if (two && (!a->grains || strcmp(a->grains, a->out) == 0) && cli_has_ending(a->out, ".tsv")) {
        a->grains = a->out;
        a->out = NULL;
    }
    if (!a->grains != !a->contacts)
        return sp_fail(err, SP_EINVAL, "a table of %s alone: must be --grains and --contacts",
                       a->grains ? "grains" : "contacts");
    if (a->in && strcmp(a->in, "-") == 0 && a->grains)
        a->in = NULL;
    if (a->in && !a->out) {
        if (!a->grains)
            return sp_fail(err, SP_EINVAL, "no OUT: must be a name that ends in .h5 or .txt");
        if (!two)
            return choose_direction(a, err);
    }
    return SP_OK;
}

/* ---- doing it -------------------------------------------------------------------------------------------------- */

static bool writes_tables(const arguments *a) { return a->in && a->grains; }

static sp_status check_output(const arguments *a, sp_error *err) {
    sp_status status = SP_OK;
    if (a->out && !cli_has_ending(a->out, ".h5") && !cli_has_ending(a->out, ".hdf5") && !cli_has_ending(a->out, ".txt"))
        return sp_fail(err, SP_EINVAL, "%s: its ending must be .h5 or .txt", a->out);
    if (a->out)
        status = cli_may_write(&a->common, a->out, err);
    if (status == SP_OK && writes_tables(a))
        status = cli_may_write(&a->common, a->grains, err);
    if (status == SP_OK && writes_tables(a))
        status = cli_may_write(&a->common, a->contacts, err);
    return status;
}

static sp_status read_input(const arguments *a, sp_packing *p, sp_error *err) {
    if (!a->in)
        return sp_packing_read_tables(a->grains, a->contacts, a->common.sets, a->common.set, p, err);
    if (a->common.sets > 0)
        return sp_fail(err, SP_EINVAL, "--set %.60s: is only for tables, %s says its own", a->common.set[0], a->in);
    return sp_packing_read(a->in, p, err);
}

static sp_status write_output(const arguments *a, const sp_packing *p, sp_error *err) {
    sp_status status = SP_OK;
    if (a->out && cli_has_ending(a->out, ".txt"))
        status = sp_packing_save_text(p, a->out, err);
    else if (a->out)
        status = sp_packing_save(p, a->out, err);
    if (status == SP_OK && writes_tables(a))
        status = sp_packing_save_tables(p, a->grains, a->contacts, err);
    return status;
}

static sp_status work(arguments *a, sp_error *err) {
    sp_packing p = sp_packing_none();
    sp_status status = understand(a, err);
    if (status == SP_OK)
        status = check_output(a, err);
    if (status == SP_OK)
        status = read_input(a, &p, err);
    if (status == SP_OK)
        status = write_output(a, &p, err);
    if (status == SP_OK)
        cli_note(&a->common, "%s -> %s: %d grains, %d contacts in %dD at p = %g", a->in ? a->in : a->grains,
                 a->out ? a->out : a->grains, p.n, p.n_contacts, p.dim, p.pressure);
    sp_packing_free(&p);
    return status;
}

int cmd_convert(int argc, char **argv) {
    arguments a = {0};
    argp_parse(&argp, argc, argv, 0, NULL, &a);
    sp_error err = {0};
    return work(&a, &err) == SP_OK ? CLI_OK : cli_fail(&err);
}
