/* sonopack moduli: elastic moduli by imposed strain or by probes, and the speeds of long waves; a row a packing. */
#include "base/base.h"
#include "cli/moduli.h"

#include <math.h>
#include <string.h>

enum { KEY_MARGIN = 0x1000, KEY_PROBE, KEY_STRAIN };

static const struct argp_option options[] = {
    {"margin", KEY_MARGIN, "D", 0, "Layers at both walls left out of the density, in mean diameters (3)", 0},
    {"probe", KEY_PROBE, "KIND", 0,
     "global (imposed strain), sine:N (body force of N half waves between the walls), or lines:N (N displaced lines, N "
     "odd); repeatable",
     0},
    {"strain", KEY_STRAIN, "EPS", 0,
     "Moduli of a finite strain, 1e-12 to 0.01, by the full contact law instead of springs; repeatable", 0},
    {0}};
static const struct argp_child children[] = {
    {&cli_springs_argp, 0, "Springs:", 50}, {&cli_common_argp, 0, "Common options:", 90}, {0}};

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
        return sp_fail(err, SP_EINVAL,
                       "--probe %.60s: N must be odd, so that displaced lines and lines at rest alternate", text);
    out->probe.n = (int32_t)n;
    return SP_OK;
}

static void parse_repeatable(moduli_arguments *a, int key, char *arg, struct argp_state *state) {
    sp_error err = {0};
    sp_status status = SP_OK;
    if (key == KEY_PROBE && a->probes == MODULI_PROBES_MAX)
        argp_error(state, "--probe: must be given %d times at the most", MODULI_PROBES_MAX);
    else if (key == KEY_PROBE)
        status = read_probe(arg, &a->probe[a->probes++], &err);
    else if (a->strains == MODULI_PROBES_MAX)
        argp_error(state, "--strain: must be given %d times at the most", MODULI_PROBES_MAX);
    else
        status = cli_number("--strain", arg, 1e-12, 0.01, &a->strain[a->strains++], &err);
    if (status != SP_OK)
        argp_error(state, "%s", err.text);
}

static error_t parse(int key, char *arg, struct argp_state *state) {
    moduli_arguments *a = state->input;
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
    case KEY_PROBE:
    case KEY_STRAIN: parse_repeatable(a, key, arg, state); return 0;
    case ARGP_KEY_ARGS:
        a->file = state->argv + state->next;
        a->files = state->argc - state->next;
        return 0;
    case ARGP_KEY_NO_ARGS: argp_error(state, "no file: must be one packing or more"); return 0;
    case ARGP_KEY_SUCCESS:
        if (a->strains > 0 && a->probes > 0)
            argp_error(state, "--strain and --probe: must not be given together, each has a table of its own");
        return 0;
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp argp = {
    options,
    parse,
    "FILE...",
    "Elastic moduli of packings (of chains C22 alone) by imposed strain, with the walls' contact points strained "
    "along.\v"
    "1 is along the walls, 2 between them; c_l = sqrt(C22/Phi3*), c_t = sqrt(C33/Phi3*), with the density Phi3* of "
    "the grains that carry, away from the walls. In three dimensions 1 and 2 are along the walls, 3 between them, C44, "
    "C55 and C66 the shear moduli of 23, 13 and 12, c_l = sqrt(C33/Phi3*), c_t = sqrt((C44+C55)/(2 Phi3*)). Shear "
    "moduli and c_t are nan where the walls do not grip (no friction): a smooth wall cannot shear, but --probe sine:1 "
    "can. c_l and c_t are nan where the packing is too low to have a bulk, see --margin. With --probe: apparent moduli "
    "on smaller scales, and their ratios to those of global strain. With --strain: stress changes over the strain of "
    "packings brought to equilibrium again, and how many contacts slide or are lost. --set takes keys of the group "
    "network.",
    children,
    NULL,
    NULL};

/* What one packing is measured with. */
typedef struct subject {
    sp_packing p;
    sp_network net;
    sp_statics s;
} subject;

static sp_status open_subject(const moduli_arguments *a, const char *path, const sp_network_options *o, subject *out,
                              sp_error *err) {
    sp_status status = cli_read_network(path, o, &out->p, &out->net, err);
    if (status == SP_OK) {
        status = sp_statics_make(&out->p, o->threshold, a->margin, &out->s, err);
        if (status != SP_OK)
            sp_fail_prefix(err, "%s", path);
    }
    return status;
}

/* Which strains the network yields to. */
static void explain_mechanisms(const moduli_arguments *a, const char *path, const sp_moduli *m) {
    const struct {
        const char *name;
        double value;
    } each[] = {{"C11", m->c11}, {"C22", m->c22}, {"C33", m->c33}, {"C44", m->c44}, {"C55", m->c55}, {"C66", m->c66}};
    for (size_t k = 0; k < sizeof each / sizeof *each; k++)
        if (each[k].value == 0)
            cli_note(&a->common,
                     "%s: %s is 0: the grains follow this strain and stretch no contact, as rolling ones do", path,
                     each[k].name);
}

/* What nan in a row is due to. */
static void explain(const moduli_arguments *a, const char *path, const subject *s, const sp_moduli *m) {
    const double height = sp_packing_height(&s->p);
    const bool space = s->p.dim == 3;
    if (s->p.dim == 1)
        cli_note(&a->common, "%s: a chain has C22 alone, the others are nan", path);
    else if (isnan(space ? m->c55 : m->c33))
        cli_note(&a->common,
                 "%s: %s and c_t are nan: walls that do not grip (no friction) cannot shear, the modulus would be 0 "
                 "whatever the packing; --probe sine:1 shears by a body force",
                 path, space ? "C44, C55" : "C33");
    explain_mechanisms(a, path, m);
    if (isnan(s->s.phi3s))
        cli_note(
            &a->common,
            "%s: c_l and c_t are nan: the packing is %.3g d high, which leaves no bulk %.3g d away from both walls "
            "for the density; see --margin",
            path, height, a->margin);
}

static sp_status global_columns(const sp_packing *p, sp_table *t, sp_error *err) {
    static const char *const plane[] = {"C11", "C12", "C22", "C33", NULL};
    static const char *const space[] = {"C11", "C12", "C13", "C22", "C23", "C33", "C44", "C55", "C66", NULL};
    const char *const *name = p->dim == 3 ? space : plane;
    sp_status status = sp_table_add_column(t, "file", "", SP_CELL_TEXT, err);
    if (status == SP_OK)
        status = sp_table_add_column(t, "p", "E*", SP_CELL_NUMBER, err);
    for (; *name && status == SP_OK; name++)
        status = sp_table_add_column(t, *name, "E*", SP_CELL_NUMBER, err);
    if (status == SP_OK)
        status = sp_table_add_column(t, "c_l", "sqrt(E* / rho)", SP_CELL_NUMBER, err);
    if (status == SP_OK)
        status = sp_table_add_column(t, "c_t", "sqrt(E* / rho)", SP_CELL_NUMBER, err);
    return status;
}

static sp_status global_row(const moduli_arguments *a, const char *path, subject *s, sp_table *t, sp_error *err) {
    sp_moduli m;
    sp_status status = sp_moduli_make(&s->net, s->s.phi3s, &m, err);
    if (status != SP_OK) {
        sp_fail_prefix(err, "%s", path);
        return status;
    }
    explain(a, path, s, &m);
    if (s->p.dim == 3)
        return sp_table_add_row(t, err, path, s->p.pressure, m.c11, m.c12, m.c13, m.c22, m.c23, m.c33, m.c44, m.c55,
                                m.c66, m.c_l, m.c_t);
    return sp_table_add_row(t, err, path, s->p.pressure, m.c11, m.c12, m.c22, m.c33, m.c_l, m.c_t);
}

static sp_status probe_columns(const moduli_arguments *a, const sp_packing *p, sp_table *t, sp_error *err) {
    static const char *const name[2][4] = {{"C22", "C33", "C22_ratio", "C33_ratio"},
                                           {"C33", "C55", "C33_ratio", "C55_ratio"}};
    sp_status status = sp_table_add_column(t, "file", "", SP_CELL_TEXT, err);
    if (status == SP_OK)
        status = sp_table_add_column(t, "p", "E*", SP_CELL_NUMBER, err);
    if (status == SP_OK && a->probes > 1)
        status = sp_table_add_column(t, "probe", "", SP_CELL_TEXT, err);
    for (int k = 0; k < 4 && status == SP_OK; k++)
        status = sp_table_add_column(t, name[p->dim == 3][k], k < 2 ? "E*" : "", SP_CELL_NUMBER, err);
    return status;
}

/* What nan in the rows of probes is due to. */
static void explain_probes(const moduli_arguments *a, const char *path, const subject *s, const sp_moduli *m,
                           const sp_probe_moduli *each) {
    const char *shear = s->p.dim == 3 ? "C55" : "C33";
    if (s->p.dim == 1)
        cli_note(&a->common, "%s: a chain has C22 alone, C33 is nan", path);
    else if (isnan(s->p.dim == 3 ? m->c55 : m->c33))
        cli_note(&a->common,
                 "%s: %s of the global strain and ratios to it are nan: walls that do not grip (no friction) cannot "
                 "shear; the sines that shear are cosines here, which do not shear the walls",
                 path, shear);
    for (int k = 0; k < a->probes; k++) {
        if (a->probe[k].global)
            continue;
        if (s->p.dim > 1 && isnan(each[k].shear))
            cli_note(&a->common, "%s: %s of %s is nan: a wall does not grip, layers at it would slip", path, shear,
                     a->probe[k].text);
        if (each[k].concentrated > 0.25)
            cli_note(&a->common,
                     "%s: %s: %.2g of the energy is that of grain %d, which hangs loose: no modulus of the packing",
                     path, a->probe[k].text, each[k].concentrated, each[k].grain);
        if (each[k].left_out > 0)
            cli_note(&a->common,
                     "%s: %s: %.2g of the squared body force is left out: it acts on floppy parts, which nothing holds",
                     path, a->probe[k].text, each[k].left_out);
    }
}

static sp_status probe_rows(const moduli_arguments *a, const char *path, subject *s, sp_table *t, sp_error *err) {
    sp_probe probe[MODULI_PROBES_MAX];
    sp_probe_moduli measured[MODULI_PROBES_MAX], each[MODULI_PROBES_MAX];
    sp_moduli m;
    int32_t count = 0, at = 0;
    for (int k = 0; k < a->probes; k++)
        if (!a->probe[k].global)
            probe[count++] = a->probe[k].probe;
    sp_status status = sp_moduli_probe(&s->net, s->s.phi3s, count, probe, &m, measured, err);
    if (status != SP_OK) {
        sp_fail_prefix(err, "%s", path);
        return status;
    }
    const double along = s->p.dim == 3 ? m.c33 : m.c22, shear = s->p.dim == 3 ? m.c55 : m.c33;
    for (int k = 0; k < a->probes; k++)
        each[k] = a->probe[k].global ? (sp_probe_moduli){.along = along, .shear = shear} : measured[at++];
    explain_probes(a, path, s, &m, each);
    for (int k = 0; k < a->probes && status == SP_OK; k++) {
        const double l = each[k].along, t_ = each[k].shear;
        status = a->probes > 1
                     ? sp_table_add_row(t, err, path, s->p.pressure, a->probe[k].text, l, t_, l / along,
                                        shear > 0 ? t_ / shear : NAN)
                     : sp_table_add_row(t, err, path, s->p.pressure, l, t_, l / along, shear > 0 ? t_ / shear : NAN);
    }
    return status;
}

/* The rows of one file; the first file decides the columns. */
static sp_status add_rows(const moduli_arguments *a, const char *path, subject *s, int *dim, sp_table *t,
                          sp_error *err) {
    const bool space = s->p.dim == 3;
    const bool probes = a->probes > 1 || (a->probes == 1 && !a->probe[0].global);
    sp_status status = SP_OK;
    if (*dim != 0 && space != (*dim == 3))
        return sp_fail(
            err, SP_EREFUSED,
            "%s: a packing in %d dimensions among others in %d: must have a table of its own, its moduli are "
            "named otherwise",
            path, s->p.dim, *dim);
    if (*dim == 0) {
        status = a->strains > 0 ? moduli_strained_columns(&s->p, t, err)
                 : probes       ? probe_columns(a, &s->p, t, err)
                                : global_columns(&s->p, t, err);
        *dim = s->p.dim;
    }
    if (status != SP_OK)
        return status;
    if (a->strains > 0)
        return moduli_strained_rows(a, path, &s->p, &s->net, t, err);
    return probes ? probe_rows(a, path, s, t, err) : global_row(a, path, s, t, err);
}

static sp_status work(const moduli_arguments *a, bool *failed, sp_error *err) {
    sp_scene scene = sp_scene_default();
    sp_table t = sp_table_none();
    int dim = 0;
    sp_status status = cli_may_write_table(&a->common, err);
    if (status == SP_OK)
        status = cli_springs_scene(&a->common, &a->springs, "network", &scene, err);
    for (int k = 0; k < a->files && status == SP_OK; k++) {
        subject s = {.p = sp_packing_none(), .net = sp_network_none(), .s = {.phi3s = NAN}};
        sp_error fault = {0};
        if (open_subject(a, a->file[k], &scene.network, &s, &fault) != SP_OK ||
            add_rows(a, a->file[k], &s, &dim, &t, &fault) != SP_OK) {
            cli_fail(&fault); /* a file that is no good is told, the others are done */
            *failed = true;
        }
        sp_network_free(&s.net);
        sp_packing_free(&s.p);
    }
    if (status == SP_OK && t.rows > 0)
        status = cli_write_table(&a->common, &t, err);
    sp_table_free(&t);
    sp_scene_free(&scene);
    return status;
}

int cmd_moduli(int argc, char **argv) {
    moduli_arguments a = {.margin = 3};
    argp_parse(&argp, argc, argv, 0, NULL, &a);
    sp_error err = {0};
    bool failed = false;
    if (work(&a, &failed, &err) != SP_OK)
        return cli_fail(&err);
    return failed ? CLI_FAILED : CLI_OK;
}
