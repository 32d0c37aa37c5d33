/* sonopack statics: prints the static properties of packings, one row each (Table I of Somfai et al. 2005). */
#include "cli/files.h"

#include <math.h>

typedef struct arguments {
    cli_common common;
    double margin;
    enum { PLAIN, TENSOR, RING } stress; /* what the table has of stress: the ratios; the tensor; that of rings */
} arguments;

static const cli_option options[] = {{"margin", "D", "Leave out layers of this thickness at all walls [d] (3)",
                                      CLI_NUMBER, CLI_FIELD(margin), .high = 1e6, .unit = "d"},
                                     {"threshold", "F", "Use only contacts with a normal force above F p d^2 (1e-4)",
                                      CLI_NUMBER, .scene = true, .key = "network.threshold"},
                                     {0}};

const cli_syntax cmd_statics_syntax = {
    .usage = "FILE...",
    .help =
        "Densities, contacts, forces and stress of packings, averaged over the bulk.\v"
#define STATICS(member, symbol, unit, meaning) symbol ": " meaning ".\n"
#include <sonopack/quantities.inc>
#undef STATICS
#define RING_STATICS(member, symbol, unit, meaning) symbol ": " meaning ".\n"
#include <sonopack/quantities.inc>
#undef RING_STATICS
        "s12_over_s2 is positive where the grains below push those above towards +x. Stresses are those of the whole "
        "packing, walls included, by contacts above the threshold; tables whose first packing is periodic or a box "
        "have the tensor. Between two rings vertical is along the radius, +x leads clockwise, and the tensor is "
        "on polar axes, with the stresses at both rings.\n"
        "\n"
        "nan means that the packing is too low to have a bulk (see --margin), or that the quantity is not defined "
        "(s32_over_s2 in two dimensions, mobilised without friction).",
    CLI_PACKINGS,
    .options = options};

#define RATIOS "Phi2 Phi3 Phi3s zs f0 N_over_p Z2 Z3 F2 F2S s1_over_s2 s12_over_s2 s32_over_s2 mobilised"
#define AXES   "s_xx s_yy s_zz s_yz s_xz s_xy"
#define POLAR  "p_inner p_outer t_inner t_outer s_rr s_tt s_rt"

static sp_status add_columns(void *user, cli_writer *w) {
    (void)user;
    cli_columns(w, SP_COLUMN_TEXT, "file", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "p", "E*", NULL);
    cli_quantity_columns(w, sp_statics_quantities, RATIOS);
    return w->status;
}

/* Under a piston the load gives the stress, and the ratios the rest. The first packing decides. */
static void add_stress(arguments *a, const cli_file *file, cli_writer *w) {
    const sp_cell cell = file->packing.cell;
    if (w->table->rows == 0) {
        a->stress = cell == SP_CELL_PISTON ? PLAIN : cell == SP_CELL_RING ? RING : TENSOR;
        if (a->stress == TENSOR)
            cli_quantity_columns(w, sp_statics_quantities, AXES);
        if (a->stress == RING)
            cli_quantity_columns(w, sp_ring_statics_quantities, POLAR);
    } else if (cell != SP_CELL_PISTON && a->stress != (cell == SP_CELL_RING ? RING : TENSOR)) {
        cli_note(&a->common, "%s: its %s left out: the first packing has %s; put it in front", file->path,
                 cell == SP_CELL_RING ? "stresses at the rings are" : "stress tensor is",
                 a->stress == PLAIN  ? "a piston"
                 : a->stress == RING ? "rings"
                                     : "no rings");
    }
}

static void put_rings(const cli_file *file, cli_writer *w) {
    sp_ring_statics s = {NAN, NAN, NAN, NAN, NAN, NAN, NAN};
    if (file->packing.cell == SP_CELL_RING)
        w->status = sp_ring_statics_make(&file->packing, file->scene->network.threshold, &s, w->err);
    if (w->status == SP_OK)
        cli_put_quantities(w, sp_ring_statics_quantities, POLAR, &s);
}

static sp_status add_row(void *user, cli_file *file, cli_writer *w) {
    arguments *a = user;
    sp_statics s;
    w->status = sp_statics_make(&file->packing, file->scene->network.threshold, a->margin, &s, w->err);
    if (w->status == SP_OK)
        add_stress(a, file, w);
    cli_put_text(w, file->path);
    cli_put(w, file->packing.pressure);
    cli_put_quantities(w, sp_statics_quantities, a->stress == TENSOR ? RATIOS " " AXES : RATIOS, &s);
    if (a->stress == RING)
        put_rings(file, w);
    cli_end_row(w);
    return w->status;
}

int cmd_statics(int argc, char **argv) {
    static const cli_files command = {
        .groups = "network", .contents = CLI_PACKING, .begin = add_columns, .add = add_row};
    arguments a = {.margin = 3};
    cli_parse(&cmd_statics_syntax, argc, argv, &a);
    return cli_run_files(&command, &a);
}
