/* sonopack statics: Table I of Somfai et al. 2005, a row a packing. */
#include "base/base.h"
#include "cli/cli.h"

#include <string.h>

typedef struct arguments {
    cli_common common;
    double margin;
    int files;
    char **file;
} arguments;

enum { KEY_MARGIN = 0x1000 };

static const struct argp_option options[] = {
    {"margin", KEY_MARGIN, "D", 0, "Layers at both walls that are left out, in mean diameters (3)", 0}, {0}};
static const struct argp_child children[] = {{&cli_common_argp, 0, "Common options:", 90}, {0}};

static error_t parse(int key, char *arg, struct argp_state *state) {
    arguments *a = state->input;
    sp_error err;
    switch (key) {
    case ARGP_KEY_INIT: state->child_inputs[0] = &a->common; return 0;
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
    "Densities, contacts, forces and stress of packings, averaged over the bulk.\v"
    "Phi2, Phi3: area and volume fraction; Phi3s: without rattlers; zs: contacts per grain that carries; f0: rattlers "
    "in percent; N_over_p: mean normal force over p d^2; Z2, Z3: reduced moments of the normal force; F2, F2S: mean "
    "square of the upward normal over all contacts and over those above the mean force; s1_over_s2: horizontal over "
    "vertical stress of the whole packing, walls included; s12_over_s2: shear over vertical stress, above 0 where what "
    "lies below pushes what lies above towards +x, and s32_over_s2 towards +y in three dimensions; mobilised: fraction "
    "of contacts within 1% of Coulomb's limit. nan: the packing is too low to have a bulk, see --margin, or the value "
    "has no meaning (s32_over_s2 in the plane, mobilised without friction). "
    "--set network.threshold=T changes what carries.",
    children,
    NULL,
    NULL};

static sp_status add_columns(sp_table *t, sp_error *err) {
    static const char *const names[] = {"p",   "Phi2",       "Phi3",        "Phi3s",       "zs",
                                        "f0",  "N_over_p",   "Z2",          "Z3",          "F2",
                                        "F2S", "s1_over_s2", "s12_over_s2", "s32_over_s2", "mobilised"};
    sp_status status = sp_table_add_column(t, "file", "", SP_CELL_TEXT, err);
    for (size_t k = 0; k < sizeof names / sizeof *names && status == SP_OK; k++) {
        const char *unit = k == 0 ? "E*" : strcmp(names[k], "f0") == 0 ? "%" : "";
        status = sp_table_add_column(t, names[k], unit, SP_CELL_NUMBER, err);
    }
    return status;
}

/* One row; a file that is no good is told on stderr and sets *failed. */
static sp_status add_file(const arguments *a, const char *path, double threshold, sp_table *t, bool *failed,
                          sp_error *err) {
    sp_packing p = sp_packing_none();
    sp_statics s;
    sp_error fault = {0};
    sp_status status = sp_packing_read(path, &p, &fault);
    if (status == SP_OK) {
        status = sp_statics_make(&p, threshold, a->margin, &s, &fault);
        if (status != SP_OK)
            sp_fail_prefix(&fault, "%s", path);
    }
    if (status == SP_OK) {
        status = sp_table_add_row(t, err, path, p.pressure, s.phi2, s.phi3, s.phi3s, s.zs, s.f0, s.n_over_p, s.z2, s.z3,
                                  s.f2, s.f2s, s.s1_over_s2, s.s12_over_s2, s.s32_over_s2, s.mobilised);
    } else {
        cli_fail(&fault);
        *failed = true;
        status = SP_OK;
    }
    sp_packing_free(&p);
    return status;
}

static sp_status work(const arguments *a, bool *failed, sp_error *err) {
    sp_scene scene = sp_scene_default();
    sp_table t = sp_table_none();
    sp_status status = cli_may_write_table(&a->common, err);
    if (status == SP_OK)
        status = cli_scene_of_sets(&a->common, "network", &scene, err);
    if (status == SP_OK)
        status = add_columns(&t, err);
    for (int k = 0; k < a->files && status == SP_OK; k++)
        status = add_file(a, a->file[k], scene.network.threshold, &t, failed, err);
    if (status == SP_OK && t.rows > 0)
        status = cli_write_table(&a->common, &t, err);
    sp_table_free(&t);
    sp_scene_free(&scene);
    return status;
}

int cmd_statics(int argc, char **argv) {
    arguments a = {.margin = 3};
    argp_parse(&argp, argc, argv, 0, NULL, &a);
    sp_error err = {0};
    bool failed = false;
    if (work(&a, &failed, &err) != SP_OK)
        return cli_fail(&err);
    return failed ? CLI_FAILED : CLI_OK;
}
