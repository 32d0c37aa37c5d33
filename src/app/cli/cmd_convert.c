/* sonopack convert: imports and exports packings. */
#include "base/base.h"
#include "cli/convert.h"
#include "cli/output.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

typedef convert_arguments arguments;

static const cli_option options[] = {
    {"grain-table", "FILE.tsv", "Table of grains: id x y [z] radius. --grains is its older name", CLI_TEXT,
     .field = offsetof(arguments, grains)},
    {"contact-table", "FILE.tsv",
     "Table of contacts: i j nx ny [nz] overlap Fn Ft. Its older name is --contacts, which with files of other "
     "programs names their list of contacts, or is overlap: all pairs that overlap",
     CLI_TEXT, .field = offsetof(arguments, contacts)},
    {.help = "Packings of other programs:"},
    {"from", "FORM", "Form of IN: " CONVERT_FORMS " (auto)", CLI_CHOICE, .field = offsetof(arguments, from),
     .words = sp_form_names},
    {"walls", "FILE|overlap|balance|none", "Contacts with the walls (those that IN has, else overlap)", CLI_TEXT,
     .field = offsetof(arguments, walls)},
    {"columns", "ROLE=NAME,...", "Columns of IN and its contacts, as in id1=c_1[1],ft_x=c_2[5]", CLI_TEXT,
     .field = offsetof(arguments, columns)},
    {"types", "T,...", "Only grains of these types", CLI_TEXT, .field = offsetof(arguments, types)},
    {"frame", "N", "Frame or time step N (the last)", CLI_INTEGER, .field = offsetof(arguments, frame), .low = 0,
     .high = 9e15},
    {"material", "E=...,nu=...,rho=...,d=...",
     "Material of the grains in SI; files of other programs are then in SI too", .parse = convert_set_material},
    {"length-unit", "L", "Length unit of IN over that of the material (1)", CLI_NUMBER,
     .field = offsetof(arguments, length_unit), .low = 1e-30, .high = 1e30},
    {"force-unit", "F", "The same for forces", CLI_NUMBER, .field = offsetof(arguments, force_unit), .low = 1e-30,
     .high = 1e30},
    {"mass-unit", "M", "The same for masses", CLI_NUMBER, .field = offsetof(arguments, mass_unit), .low = 1e-30,
     .high = 1e30},
    {"kn", "K", "Normal stiffness of all contacts, in units of the material (Hertz's law)", CLI_NUMBER,
     .field = offsetof(arguments, kn), .low = 1e-300, .high = 1e300},
    {"kt-ratio", "X", "Tangential over normal stiffness (Mindlin's)", CLI_NUMBER,
     .field = offsetof(arguments, kt_ratio), .low = 0, .high = 100},
    {"thickness", "H", "Grains are disks of this thickness, in units of the material", CLI_NUMBER,
     .field = offsetof(arguments, thickness), .low = 1e-300, .high = 1e300},
    {"rest", NULL, "Bring the grains to rest under their pressure", CLI_FLAG, .field = offsetof(arguments, rest)},
    {.help = "Files for other programs:"},
    {"to", "KIND", "Form of OUT, in place of its ending: h5, txt, vtp, pvd, lammps-data, lammps-dump, xyz, csv or mat",
     CLI_TEXT, .field = offsetof(arguments, to.to)},
    {"vectors", "FILE", "Displacements to write: a file of modes, or a table of displacements of this packing",
     CLI_TEXT, .field = offsetof(arguments, to.vectors)},
    {"mode", "N", "Displacements in mode N, of --vectors or computed", CLI_INTEGER,
     .field = offsetof(arguments, to.mode), .low = 0, .high = 1e15},
    {"times", "T|LOW:HIGH:N", "Displacements at these times after a pulse at the bottom wall; several need .pvd",
     CLI_TEXT, .field = offsetof(arguments, to.times)},
    {"frames", "N", ".pvd of a mode: snapshots of one period (24)", CLI_INTEGER,
     .field = offsetof(arguments, to.frames), .low = 1, .high = SP_EXPORT_FRAMES_MAX},
    {"amplitude", "D", ".pvd: largest displacement shown [d] (0.25)", CLI_NUMBER,
     .field = offsetof(arguments, to.amplitude), .high = 1e6},
    {0}};

static const cli_syntax syntax = {
    .usage = "IN OUT [--contacts FILE|overlap]\n"
             "IN|OUT --grain-table G.tsv --contact-table C.tsv",
    .help =
        "Converts packings between HDF5 (.h5), a text file (.txt), two tables, and the files of other programs.\v"
        "The format of IN is recognised by its content, that of OUT by its ending or --to. With two tables and "
        "one packing file, the existing one of the two is read and the other is written. A table of grains may also "
        "take the place of IN or OUT; then only the table of contacts needs an option:\n"
        "  sonopack convert grains.tsv P.h5 --contact-table contacts.tsv\n"
        "With IN, OUT and both tables the packing is written in both forms.\n"
        "IN may also be a file of LAMMPS, LIGGGHTS, Yade or MercuryDPM, extended XYZ, or a table; its contacts are "
        "then "
        "in --contacts FILE or, with --contacts overlap, found by overlap:\n"
        "  sonopack convert grains.dump P.h5 --contacts contacts.dump --set friction=0.5\n"
        "--set then takes dimension, up, cell (piston, periodic or box: that of the file), sides, across, width, "
        "depth, bottom, top, height, left, right, front, back, xy, xz, yz, gravity, pressure, friction, poisson, wall, "
        "digits, first_id (docs/formats.md). For our own tables:\n"
        "Box and material of tables are in comment lines `# key = value' or in --set key=value: width, depth (3D), "
        "height, cell, xy, xz, yz, gravity, pressure, friction, poisson, wall, material, seed. Lengths are in mean "
        "grain diameters, pressures in E*.\n"
        "\n"
        "Endings of OUT for other programs: .vtp (ParaView, OVITO: also NAME-contacts.vtp, NAME-walls.vtp and "
        "NAME.vtm), "
        ".pvd (ParaView: a series of snapshots, NAME-0000.vtp and so on), .data and .dump (LAMMPS), .xyz (extended "
        "XYZ), "
        ".csv (spreadsheets: also NAME-contacts.csv), .mat (MATLAB, Octave).",
    .finds_material = true,
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
            return sp_fail(
                err, SP_EINVAL,
                "no OUT: must be a file name that ends in .h5, .txt, .vtp, .pvd, .data, .dump, .xyz, .csv or "
                ".mat");
        if (!two)
            return choose_direction(a, err);
    }
    return SP_OK;
}

/* ---- conversion ------------------------------------------------------------------------------------------------- */

static bool writes_tables(const arguments *a) { return a->in && a->grains; }

static sp_status check_output(arguments *a, sp_error *err) {
    sp_status status = a->out ? convert_out_ending(&a->to, a->out, &a->ending, err) : SP_OK;
    if (status == SP_OK && a->out && !a->ending)
        return sp_fail(err, SP_EINVAL,
                       "%s: its ending must be .h5, .txt, .vtp, .pvd, .data, .dump, .xyz, .csv or .mat; or use --to",
                       a->out);
    if (status == SP_OK && a->out)
        status = convert_out_check(&a->common, &a->to, a->ending, a->out, err);
    if (status == SP_OK && a->common.units == CLI_UNITS_SI && (!convert_out_is_foreign(a->ending) || writes_tables(a)))
        return sp_fail(err, SP_EINVAL,
                       "--units si: packings are stored in d, E* and rho, in .h5, .txt and tables; files for other "
                       "programs may be in SI");
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
    if (convert_out_is_foreign(a->ending))
        status = convert_out_write(&a->common, &a->to, a->ending, p, a->in, a->out, err);
    else if (a->out && strcmp(a->ending, ".txt") == 0)
        status = sp_packing_save_text(p, a->out, err);
    else if (a->out)
        status = sp_packing_save(p, a->out, err);
    if (status == SP_OK && writes_tables(a))
        status = sp_packing_save_tables(p, a->grains, a->contacts, err);
    return status;
}

static void print_result(const arguments *a, const sp_packing *p) {
    char si[64] = "";
    if (p->material.young > 0)
        snprintf(si, sizeof si, " E* (%.6g kPa)", 1e-3 * p->pressure * sp_material_modulus(&p->material));
    cli_note(&a->common, "%s -> %s: %d grains, %d contacts in %dD at p = %g%s", a->in ? a->in : a->grains,
             a->out ? a->out : a->grains, p->n, p->n_contacts, p->dim, p->pressure, si);
}

static sp_status work(arguments *a, sp_error *err) {
    sp_packing p = sp_packing_none();
    bool foreign = false;
    sp_status status = convert_is_foreign(a, &foreign, err);
    if (status == SP_OK && !foreign)
        status = convert_refuse_options(a, &syntax, err);
    if (status == SP_OK && foreign)
        status = convert_take_files(a, err);
    else if (status == SP_OK)
        status = resolve_files(a, err);
    if (status == SP_OK)
        status = check_output(a, err);
    if (status == SP_OK)
        status = foreign ? convert_import(a, &syntax, &p, err) : read_input(a, &p, err);
    if (status == SP_OK && foreign && a->common.material.young > 0)
        a->common.material = p.material; /* that of the option, with the diameter of the file */
    if (status == SP_OK)
        status = cli_take_material(a, &p.material, a->in ? a->in : a->grains, err);
    if (status == SP_OK && !foreign)
        status = convert_give_material(a, &p, err);
    if (status == SP_OK)
        status = write_output(a, &p, err);
    if (status == SP_OK)
        print_result(a, &p);
    sp_packing_free(&p);
    return status;
}

int cmd_convert(int argc, char **argv) {
    arguments a = {.length_unit = 1,
                   .force_unit = 1,
                   .mass_unit = 1,
                   .kn = NAN,
                   .kt_ratio = NAN,
                   .thickness = NAN,
                   .to = {.mode = -1, .amplitude = -1}};
    cli_parse(&syntax, argc, argv, &a);
    a.in = a.common.files > 0 ? a.common.file[0] : NULL;
    a.out = a.common.files > 1 ? a.common.file[1] : NULL;
    sp_error err = {0};
    return work(&a, &err) == SP_OK ? CLI_OK : cli_fail(&err);
}
