/* sonopack statics: prints the static properties of packings, one row each (Table I of Somfai et al. 2005). */
#include "cli/files.h"

typedef struct arguments {
    cli_common common;
    double margin;
    bool stress; /* the table has the stress tensor */
} arguments;

static const cli_option options[] = {{"margin", "D", "Leave out layers of this thickness at all walls [d] (3)",
                                      CLI_NUMBER, .field = offsetof(arguments, margin), .high = 1e6, .unit = "d"},
                                     {0}};

static const cli_syntax syntax = {
    .usage = "FILE...",
    .help =
        "Densities, contacts, forces and stress of packings, averaged over the bulk.\v"
        "Phi2, Phi3: area and volume fraction.\n"
        "Phi3s: volume fraction without rattlers.\n"
        "zs: contacts per grain, without rattlers.\n"
        "f0: percentage of rattlers.\n"
        "N_over_p: mean normal force over p d^2.\n"
        "Z2, Z3: reduced moments of the normal force.\n"
        "F2, F2S: mean square of the upward component of the contact normal, over all contacts and over those with "
        "more than the mean force.\n"
        "s1_over_s2: horizontal over vertical stress of the whole packing, walls included.\n"
        "s12_over_s2: shear over vertical stress; it is positive where the grains below push those above towards "
        "+x.\n"
        "s32_over_s2: the same towards +y, in three dimensions.\n"
        "mobilised: fraction of contacts within 1% of the Coulomb limit.\n"
        "s_xx, s_yy, s_zz, s_yz, s_xz, s_xy: the stress tensor of the whole packing, positive in compression. Tables "
        "whose first packing is periodic or a box have it.\n"
        "\n"
        "nan means that the packing is too low to have a bulk (see --margin), or that the quantity is not defined "
        "(s32_over_s2 in two dimensions, mobilised without friction). --set network.threshold=T sets the smallest "
        "force of a contact.",
    .finds_material = true,
    .options = options,
    .file_name = "packing",
    .files_min = 1,
    .files_max = CLI_ANY_NUMBER};

static sp_status add_columns(void *user, sp_table *t, sp_error *err) {
    cli_writer w = {.table = t, .err = err};
    (void)user;
    cli_columns(&w, SP_CELL_TEXT, "file", "", NULL);
    cli_columns(&w, SP_CELL_NUMBER, "p", "E*", "Phi2", "", "Phi3", "", "Phi3s", "", "zs", "", "f0", "%", "N_over_p", "",
                "Z2", "", "Z3", "", "F2", "", "F2S", "", "s1_over_s2", "", "s12_over_s2", "", "s32_over_s2", "",
                "mobilised", "", NULL);
    return w.status;
}

/* Under a piston the load gives the stress, and the ratios the rest. */
static sp_status add_stress(arguments *a, const cli_file *file, sp_table *t, sp_error *err) {
    cli_writer w = {.table = t, .err = err};
    if (file->packing.cell == SP_CELL_PISTON || a->stress)
        return SP_OK;
    if (t->rows > 0) {
        cli_note(&a->common, "%s: its stress tensor is left out: the first packing has a piston; put it in front",
                 file->path);
        return SP_OK;
    }
    cli_columns(&w, SP_CELL_NUMBER, "s_xx", "E*", "s_yy", "E*", "s_zz", "E*", "s_yz", "E*", "s_xz", "E*", "s_xy", "E*",
                NULL);
    a->stress = true;
    return w.status;
}

static sp_status add_row(void *user, cli_file *file, sp_table *t, sp_error *err) {
    arguments *a = user;
    sp_statics s;
    sp_status status = sp_statics_make(&file->packing, file->scene->network.threshold, a->margin, &s, err);
    if (status == SP_OK)
        status = add_stress(a, file, t, err);
    if (status != SP_OK)
        return status;
    if (a->stress)
        return sp_table_add_row(t, err, file->path, file->packing.pressure, s.phi2, s.phi3, s.phi3s, s.zs, s.f0,
                                s.n_over_p, s.z2, s.z3, s.f2, s.f2s, s.s1_over_s2, s.s12_over_s2, s.s32_over_s2,
                                s.mobilised, s.s_xx, s.s_yy, s.s_zz, s.s_yz, s.s_xz, s.s_xy);
    return sp_table_add_row(t, err, file->path, file->packing.pressure, s.phi2, s.phi3, s.phi3s, s.zs, s.f0, s.n_over_p,
                            s.z2, s.z3, s.f2, s.f2s, s.s1_over_s2, s.s12_over_s2, s.s32_over_s2, s.mobilised);
}

int cmd_statics(int argc, char **argv) {
    static const cli_files command = {
        .groups = "network", .contents = CLI_PACKING, .begin = add_columns, .add = add_row};
    arguments a = {.margin = 3};
    cli_parse(&syntax, argc, argv, &a);
    return cli_run_files(&command, &a);
}
