/* sonopack convert: imports and exports packings. */
#include "base/base.h"
#include "cli/output.h"

#include <string.h>
#include <unistd.h>

typedef struct arguments {
    cli_common common;
    const char *grains, *contacts; /* the two tables; NULL: none */
    const char *in, *out;          /* packing files as given; NULL: none */
} arguments;

static const cli_option options[] = {
    {"grain-table", "FILE.tsv", "Table of grains: id x y [z] radius. --grains is its older name", CLI_TEXT,
     .field = offsetof(arguments, grains), .alias = "grains"},
    {"contact-table", "FILE.tsv", "Table of contacts: i j nx ny [nz] overlap Fn Ft. --contacts is its older name",
     CLI_TEXT, .field = offsetof(arguments, contacts), .alias = "contacts"},
    {0}};

static const cli_syntax syntax = {
    .usage = "IN OUT [--grain-table G.tsv --contact-table C.tsv]\nIN --grain-table G.tsv --contact-table C.tsv\n"
             "OUT --grain-table G.tsv --contact-table C.tsv",
    .help =
        "Converts packings between HDF5 (.h5), a text file (.txt), and two tables.\v"
        "The format of IN is recognised by its content, that of OUT by its ending, .h5 or .txt. With two tables and "
        "one packing file, the existing one of the two is read and the other is written. A table of grains may also "
        "take the place of IN or OUT; then only the table of contacts needs an option:\n"
        "  sonopack convert grains.tsv P.h5 --contact-table contacts.tsv\n"
        "With IN, OUT and both tables the packing is written in both forms.\n"
        "Box and material of tables are in comment lines `# key = value' or in --set key=value: width, depth (3D), "
        "height, pressure, friction, poisson, wall, material, seed. Lengths are in mean grain diameters, pressures in "
        "E*.",
    .not_si = "it writes packings, which are stored in d, E* and rho; --material stores a material with them",
    .options = options,
    .file_name = "packing",
    .files_max = 2};

static bool is_file(const char *path) { return access(path, F_OK) == 0; }

/* ---- input and output ------------------------------------------------------------------------------------------- */

/* With one packing file and both tables, what exists is read. */
static sp_status choose_direction(arguments *a, sp_error *err) {
    const bool tables = is_file(a->grains) && is_file(a->contacts), packing = is_file(a->in);
    if (tables && packing)
        return sp_fail(err, SP_EINVAL,
                       "%s and both tables exist: use `convert %s %s --contact-table ...' to write the tables, or "
                       "`convert %s %s --contact-table ...' to read them",
                       a->in, a->in, a->grains, a->grains, a->in);
    if (tables || (!packing && (is_file(a->grains) || is_file(a->contacts)))) {
        a->out = a->in;
        a->in = NULL;
    }
    return SP_OK;
}

/* Decides what is read and what is written. Afterwards `in` is the packing to read (NULL: the tables) and `out` the
 * packing to write (NULL: none). Tables that are not read are written. */
static sp_status resolve_files(arguments *a, sp_error *err) {
    if (a->common.output && a->in && a->out)
        return sp_fail(err, SP_EINVAL, "OUT is given twice, as %s and -o %s", a->out, a->common.output);
    const bool two = a->in && (a->out || a->common.output);
    if (a->common.output)
        a->out = a->common.output;
    if (!a->in && !a->out)
        return sp_fail(err, SP_EINVAL, "no file: must be IN and OUT; see `sonopack help convert'");
    if (two && (!a->grains || strcmp(a->grains, a->in) == 0) && cli_has_ending(a->in, ".tsv")) {
        a->grains = a->in;
        a->in = NULL;
    } else if (two && (!a->grains || strcmp(a->grains, a->out) == 0) && cli_has_ending(a->out, ".tsv")) {
        a->grains = a->out;
        a->out = NULL;
    }
    if (!a->grains != !a->contacts)
        return sp_fail(err, SP_EINVAL,
                       "a table of %s alone: give both --grain-table and --contact-table (or --grains and --contacts)",
                       a->grains ? "grains" : "contacts");
    if (a->in && strcmp(a->in, "-") == 0 && a->grains)
        a->in = NULL;
    if (a->in && !a->out) {
        if (!a->grains)
            return sp_fail(err, SP_EINVAL, "no OUT: must be a file name that ends in .h5 or .txt");
        if (!two)
            return choose_direction(a, err);
    }
    return SP_OK;
}

/* ---- conversion ------------------------------------------------------------------------------------------------- */

static bool writes_tables(const arguments *a) { return a->in && a->grains; }

static sp_status check_output(const arguments *a, sp_error *err) {
    sp_status status = SP_OK;
    if (a->out && !cli_is_hdf5(a->out) && !cli_has_ending(a->out, ".txt"))
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
        return sp_fail(err, SP_EINVAL, "--set %.60s: applies only to tables; %s has its own values", a->common.set[0],
                       a->in);
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
    sp_status status = resolve_files(a, err);
    if (status == SP_OK)
        status = check_output(a, err);
    if (status == SP_OK)
        status = read_input(a, &p, err);
    if (status == SP_OK && a->common.material.young > 0)
        p.material = a->common.material;
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
    cli_parse(&syntax, argc, argv, &a);
    a.in = a.common.files > 0 ? a.common.file[0] : NULL;
    a.out = a.common.files > 1 ? a.common.file[1] : NULL;
    sp_error err = {0};
    return work(&a, &err) == SP_OK ? CLI_OK : cli_fail(&err);
}
