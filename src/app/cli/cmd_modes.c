/* sonopack modes: eigenfrequencies and eigenmodes, all of them or a part. */
#include "base/base.h"
#include "cli/modes_damped.h"
#include "cli/modes_stability.h"
#include "cli/springs.h"

#include <stdlib.h>
#include <string.h>

typedef struct arguments {
    cli_common common;
    cli_springs springs;
    bool frequencies_only;
    sp_source source;
    sp_modes_range range;
    bool part;      /* --lowest or --band */
    int ranges;     /* how many of --all, --lowest, --band */
    double damping; /* 0: none */
    bool stability;
    char *file;
} arguments;

enum { KEY_ALL = 0x1000, KEY_FREQUENCIES, KEY_SOURCE, KEY_LOWEST, KEY_BAND, KEY_DAMPING, KEY_STABILITY };

static const struct argp_option options[] = {
    {"all", KEY_ALL, NULL, 0, "All modes (the default)", 0},
    {"lowest", KEY_LOWEST, "K", 0, "Only the K lowest that are not zero modes of rattlers; n counts on from those", 0},
    {"band", KEY_BAND, "LO:HI", 0,
     "Only the modes with LO <= omega <= HI; n counts from the lowest of all. HI may be inf", 0},
    {"frequencies-only", KEY_FREQUENCIES, NULL, 0, "No amplitudes and participation: columns n, omega, error", 0},
    {"damping", KEY_DAMPING, "ZETA", 0,
     "With dashpots, a fraction ZETA of critical: columns n, omega, decay, cosine, sine, error (up to 2000 degrees of "
     "freedom)",
     0},
    {"stability", KEY_STABILITY, NULL, 0,
     "A verdict instead, of one row: whether a motion grows (up to 6000 degrees of freedom with --prestress and "
     "friction; beyond, undecided with a bound)",
     0},
    {"source", KEY_SOURCE, "impulse|velocity|displacement", 0, "Of the amplitudes a (impulse)", 0},
    {0}};
static const struct argp_child children[] = {
    {&cli_springs_argp, 0, "Springs:", 50}, {&cli_common_argp, 0, "Common options:", 90}, {0}};

/* LO:HI */
static bool band_of(char *text, sp_modes_range *out) {
    char *colon = strchr(text, ':'), *end = text;
    if (!colon)
        return false;
    const double from = strtod(text, &end);
    if (end == text || end != colon)
        return false;
    const double to = strtod(colon + 1, &end);
    if (end == colon + 1 || *end || !(from >= 0 && from < to))
        return false;
    *out = sp_modes_range_band(from, to);
    return true;
}

static error_t parse(int key, char *arg, struct argp_state *state) {
    arguments *a = state->input;
    sp_error err = {0};
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &a->springs;
        state->child_inputs[1] = &a->common;
        return 0;
    case KEY_ALL: a->ranges++; return 0;
    case KEY_FREQUENCIES: a->frequencies_only = true; return 0;
    case KEY_LOWEST:
        a->range = sp_modes_range_all();
        a->part = true;
        a->ranges++;
        if (cli_integer("--lowest", arg, 1, 1000000000, &a->range.lowest, &err) != SP_OK)
            argp_error(state, "%s", err.text);
        return 0;
    case KEY_DAMPING:
        if (cli_number("--damping", arg, 1e-12, 100, &a->damping, &err) != SP_OK)
            argp_error(state, "%s", err.text);
        return 0;
    case KEY_STABILITY: a->stability = true; return 0;
    case KEY_BAND:
        a->part = true;
        a->ranges++;
        if (!band_of(arg, &a->range))
            argp_error(state, "--band %.60s: must be LO:HI, frequencies with 0 <= LO < HI", arg);
        return 0;
    case KEY_SOURCE:
        if (!cli_source_of(arg, &a->source))
            argp_error(state, "--source %.60s: must be impulse, velocity or displacement", arg);
        return 0;
    case ARGP_KEY_ARG:
        if (a->file)
            argp_error(state, "%.200s: a second file; must be one packing at a time", arg);
        a->file = arg;
        return 0;
    case ARGP_KEY_END:
        if (!a->file)
            argp_error(state, "no file: must be one packing");
        if (a->ranges > 1)
            argp_error(state, "--all, --lowest and --band: must be one of them, once");
        if (a->damping > 0 && (a->part || a->frequencies_only))
            argp_error(state, "--damping: must be without --lowest, --band and --frequencies-only");
        if (a->stability && (a->part || a->frequencies_only || a->damping > 0))
            argp_error(state, "--stability: must be without --lowest, --band, --frequencies-only and --damping");
        return 0;
    default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp argp = {
    options,
    parse,
    "FILE",
    "Eigenfrequencies of the network of springs, both walls fixed, with their weights in the signal.\v"
    "omega ascends, rattlers' zero modes first. F(t) = sum of ab sin(omega t) (cos for displacements); participation "
    "= (sum w)^2/(N sum w^2) with w a grain's share of the mode, N grains without the rattlers; error bounds that of "
    "omega. --set takes keys of the group network.\n\n"
    "With --damping, F(t) = sum of exp(-decay t) (cosine cos(omega t) + sine sin(omega t)), one row a conjugate pair, "
    "n "
    "from 0 without rattlers; what is overdamped has rows of its own with omega = 0.",
    children,
    NULL,
    NULL};

static sp_status add_columns(bool vectors, sp_table *t, sp_error *err) {
    static const char *const names[] = {"omega", "a", "b", "ab", "participation", "error"};
    const int count = sizeof names / sizeof *names;
    static const char *const units[] = {"sqrt(E* / rho)/d", "", "", "E* d^2", "", "sqrt(E* / rho)/d"};
    sp_status status = sp_table_add_column(t, "n", "", SP_CELL_INTEGER, err);
    for (int k = 0; k < count && status == SP_OK; k++)
        if (vectors || k == 0 || k == count - 1)
            status = sp_table_add_column(t, names[k], units[k], SP_CELL_NUMBER, err);
    return status;
}

/* How the modes were found, and between which frequencies none is missing. */
static sp_status add_proof(const sp_modes *m, sp_table *t, sp_error *err) {
    char from[SP_NUMBER_TEXT], to[SP_NUMBER_TEXT];
    sp_status status = sp_table_add_comment(t, err, "method = %s", m->method == SP_MODES_SPARSE ? "sparse" : "dense");
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "complete = %s:%s", sp_number_text(m->certified_from, from),
                                      sp_number_text(m->certified_to, to));
    if (status == SP_OK && m->method == SP_MODES_SPARSE)
        status = sp_table_add_comment(t, err, "factors = %lld", (long long)m->factors);
    if (status == SP_OK && m->on_edge > 0)
        status = sp_table_add_comment(t, err, "on_edge = %lld", (long long)m->on_edge);
    return status;
}

static sp_status fill(const arguments *a, const sp_packing *p, int64_t rattlers, const sp_modes *m, sp_table *t,
                      sp_error *err) {
    char number[SP_NUMBER_TEXT];
    sp_status status = add_columns(!a->frequencies_only, t, err);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "file = %s", a->file);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "pressure = %s", sp_number_text(p->pressure, number));
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "zero_modes = %lld", (long long)m->n_zero);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "rattler_modes = %lld", (long long)rattlers);
    if (status == SP_OK && !a->frequencies_only)
        status = sp_table_add_comment(t, err, "source = %s", cli_source_name(a->source));
    if (status == SP_OK && m->vectors)
        status = sp_table_add_comment(t, err, "residual = %.3g", m->residual);
    if (status == SP_OK && m->vectors)
        status = sp_table_add_comment(t, err, "orthogonality = %.3g", m->orthogonality);
    if (status == SP_OK)
        status = add_proof(m, t, err);
    for (int64_t k = a->range.lowest > 0 ? m->n_rattler : 0; k < m->n && status == SP_OK; k++) {
        const int64_t n = m->first + k;
        if (m->vectors)
            status = sp_table_add_row(t, err, n, m->omega[k], m->a[k], m->b[k], m->a[k] * m->b[k], m->participation[k],
                                      m->error[k]);
        else
            status = sp_table_add_row(t, err, n, m->omega[k], m->error[k]);
    }
    return status;
}

/* Of a part or all of the modes, each a row. */
static sp_status table_of_modes(const arguments *a, const sp_packing *p, const sp_network *net, sp_table *t,
                                sp_error *err) {
    const sp_modes_options o = {.vectors = !a->frequencies_only, .source = a->source};
    sp_modes m = sp_modes_none();
    sp_status status = sp_modes_make(net, &o, &a->range, &m, err);
    if (status == SP_OK)
        status = fill(a, p, (int64_t)net->rattlers * net->dof, &m, t, err);
    sp_modes_free(&m);
    return status;
}

static sp_status make_table(const arguments *a, const sp_packing *p, const sp_network *net, sp_table *t,
                            sp_error *err) {
    if (!a->stability && !(a->damping > 0))
        return table_of_modes(a, p, net, t, err);
    sp_status status = sp_table_add_comment(t, err, "file = %s", a->file);
    if (status != SP_OK)
        return status;
    return a->stability ? cli_stability(p, net, t, err) : cli_damped_modes(p, net, a->damping, a->source, t, err);
}

static sp_status work(const arguments *a, sp_error *err) {
    sp_scene scene = sp_scene_default();
    sp_packing p = sp_packing_none();
    sp_network net = sp_network_none();
    sp_table t = sp_table_none();
    sp_status status = cli_may_write_table(&a->common, err);
    if (status == SP_OK)
        status = cli_springs_scene(&a->common, &a->springs, "network", &scene, err);
    if (status == SP_OK)
        status = cli_read_network(a->file, &scene.network, &p, &net, err);
    if (status == SP_OK) {
        status = make_table(a, &p, &net, &t, err);
        if (status != SP_OK)
            sp_fail_prefix(err, "%s", a->file);
    }
    if (status == SP_OK)
        status = cli_write_table(&a->common, &t, err);
    sp_table_free(&t);
    sp_network_free(&net);
    sp_packing_free(&p);
    sp_scene_free(&scene);
    return status;
}

int cmd_modes(int argc, char **argv) {
    arguments a = {.range = sp_modes_range_all(), .source = SP_SOURCE_IMPULSE};
    argp_parse(&argp, argc, argv, 0, NULL, &a);
    sp_error err = {0};
    return work(&a, &err) == SP_OK ? CLI_OK : cli_fail(&err);
}
