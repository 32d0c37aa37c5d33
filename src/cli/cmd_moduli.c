/* sonopack moduli: elastic moduli by imposed strain, and the speeds of long waves; a row a packing. */
#include "base/base.h"
#include "cli/springs.h"

#include <math.h>

typedef struct arguments {
    cli_common common;
    cli_springs springs;
    double margin;
    int files;
    char **file;
} arguments;

enum { KEY_MARGIN = 0x1000 };

static const struct argp_option options[] = {
    {"margin", KEY_MARGIN, "D", 0, "Layers at both walls left out of the density, in mean diameters (3)", 0}, {0}};
static const struct argp_child children[] = {
    {&cli_springs_argp, 0, "Springs:", 50}, {&cli_common_argp, 0, "Common options:", 90}, {0}};

static error_t parse(int key, char *arg, struct argp_state *state) {
    arguments *a = state->input;
    sp_error err = {0};
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &a->springs;
        state->child_inputs[1] = &a->common;
        return 0;
    case KEY_MARGIN:
        if (cli_number("--margin", arg, 0, 1e6, &a->margin, &err) != SP_OK)
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
    "Elastic moduli of 2D packings (C22 also of chains) by imposed strain, with the walls' contact points strained "
    "along.\v"
    "1 is along the walls, 2 between them; c_l = sqrt(C22/Phi3*), c_t = sqrt(C33/Phi3*), with the density Phi3* of "
    "the grains that carry, away from the walls. C33 and c_t are nan where the walls do not grip (no friction): a "
    "smooth wall cannot shear. c_l and c_t are nan where the packing is too low to have a bulk, see --margin. --set "
    "takes keys of the group network.",
    children,
    NULL,
    NULL};

static sp_status add_columns(sp_table *t, sp_error *err) {
    static const char *const names[] = {"p", "C11", "C12", "C22", "C33", "c_l", "c_t"};
    sp_status status = sp_table_add_column(t, "file", "", SP_CELL_TEXT, err);
    for (int k = 0; k < 7 && status == SP_OK; k++)
        status = sp_table_add_column(t, names[k], k < 5 ? "E*" : "sqrt(E* / rho)", SP_CELL_NUMBER, err);
    return status;
}

static sp_status moduli_of(const arguments *a, const char *path, const sp_network_options *o, double *pressure,
                           sp_moduli *m, sp_error *err) {
    sp_packing p = sp_packing_none();
    sp_network net = sp_network_none();
    sp_statics s = {.phi3s = NAN};
    sp_status status = cli_read_network(path, o, &p, &net, err);
    if (status != SP_OK)
        goto out;
    *pressure = p.pressure;
    status = sp_statics_make(&p, o->threshold, a->margin, &s, err);
    if (status == SP_OK)
        status = sp_moduli_make(&net, s.phi3s, m, err);
    if (status != SP_OK)
        sp_fail_prefix(err, "%s", path);
out:
    sp_network_free(&net);
    sp_packing_free(&p);
    return status;
}

/* One row; a file that is no good is told on stderr and sets *failed. */
static sp_status add_file(const arguments *a, const char *path, const sp_network_options *o, sp_table *t, bool *failed,
                          sp_error *err) {
    sp_moduli m;
    sp_error fault = {0};
    double pressure = NAN;
    if (moduli_of(a, path, o, &pressure, &m, &fault) != SP_OK) {
        cli_fail(&fault);
        *failed = true;
        return SP_OK;
    }
    if (isnan(m.c33) && !isnan(m.c11))
        cli_note(&a->common, "%s: C33 and c_t are nan: walls that do not grip cannot shear", path);
    return sp_table_add_row(t, err, path, pressure, m.c11, m.c12, m.c22, m.c33, m.c_l, m.c_t);
}

static sp_status work(const arguments *a, bool *failed, sp_error *err) {
    sp_scene scene = sp_scene_default();
    sp_table t = sp_table_none();
    sp_status status = cli_may_write_table(&a->common, err);
    if (status == SP_OK)
        status = cli_springs_scene(&a->common, &a->springs, "network", &scene, err);
    if (status == SP_OK)
        status = add_columns(&t, err);
    for (int k = 0; k < a->files && status == SP_OK; k++)
        status = add_file(a, a->file[k], &scene.network, &t, failed, err);
    if (status == SP_OK && t.rows > 0)
        status = cli_write_table(&a->common, &t, err);
    sp_table_free(&t);
    sp_scene_free(&scene);
    return status;
}

int cmd_moduli(int argc, char **argv) {
    arguments a = {.margin = 3};
    argp_parse(&argp, argc, argv, 0, NULL, &a);
    sp_error err = {0};
    bool failed = false;
    if (work(&a, &failed, &err) != SP_OK)
        return cli_fail(&err);
    return failed ? CLI_FAILED : CLI_OK;
}
