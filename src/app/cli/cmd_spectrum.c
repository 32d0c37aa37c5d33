/* sonopack spectrum: what frequencies a packing has, which reach the other wall, and how waves travel in it. */
#include "base/base.h"
#include "cli/spectrum.h"

#include <string.h>

enum {
    KEY_METHOD = 0x1000,
    KEY_NORM,
    KEY_BINS,
    KEY_UNTIL,
    KEY_RESOLUTION,
    KEY_VECTORS,
    KEY_SEED,
    KEY_SOURCE,
    KEY_LINES,
    KEY_DIRECTION,
    KEY_WAVES,
    KEY_NODE,
    KEY_PROFILE,
    KEY_AT,
    KEY_DAMPING,
    KEY_LAYERS,
    KEY_RANGE,
    KEY_TOLERANCE,
    KEY_LOWEST,
    KEY_LAST,
    KEYS = KEY_LAST - KEY_METHOD
};
#define BIT(key)   (1u << ((key)-KEY_METHOD))
#define KIND_NAMES "dos, transmission, dispersion, harmonic, participation or continuum"

static const struct kind {
    const char *name;
    spectrum_table table;
    unsigned options;
} kinds[] = {
    {"dos", spectrum_dos,
     BIT(KEY_METHOD) | BIT(KEY_NORM) | BIT(KEY_BINS) | BIT(KEY_UNTIL) | BIT(KEY_RESOLUTION) | BIT(KEY_VECTORS) |
         BIT(KEY_SEED)},
    {"transmission", spectrum_transmission,
     BIT(KEY_SOURCE) | BIT(KEY_BINS) | BIT(KEY_UNTIL) | BIT(KEY_RESOLUTION) | BIT(KEY_LINES)},
    {"dispersion", spectrum_dispersion,
     BIT(KEY_DIRECTION) | BIT(KEY_WAVES) | BIT(KEY_NODE) | BIT(KEY_RESOLUTION) | BIT(KEY_PROFILE) | BIT(KEY_BINS)},
    {"harmonic", spectrum_harmonic,
     BIT(KEY_SOURCE) | BIT(KEY_AT) | BIT(KEY_DAMPING) | BIT(KEY_LAYERS) | BIT(KEY_RANGE) | BIT(KEY_TOLERANCE) |
         BIT(KEY_PROFILE)},
    {"participation", spectrum_participation, BIT(KEY_BINS) | BIT(KEY_UNTIL)},
    {"continuum", spectrum_continuum, BIT(KEY_LOWEST)},
};
enum { KINDS = sizeof kinds / sizeof *kinds };

typedef struct arguments {
    spectrum_arguments a;
    const struct kind *kind;
    const char *given[KEYS]; /* names of the options that were given */
} arguments;

static const struct argp_option options[] = {
    {"method", KEY_METHOD, "auto|exact|kpm|count", 0,
     "dos: all frequencies, kernel polynomials, or modes counted bin by bin (auto: exact up to 3000 degrees of "
     "freedom, "
     "else kpm)",
     0},
    {"norm", KEY_NORM, "grain|one|modes", 0, "dos: modes a carrying grain, integral 1, or numbers of modes (grain)", 0},
    {"bins", KEY_BINS, "N", 0, "Number of frequencies, equally spaced (100)", 0},
    {"until", KEY_UNTIL, "OMEGA", 0, "Last frequency (the bound of the spectrum)", 0},
    {"resolution", KEY_RESOLUTION, "WIDTH", 0, "Standard deviation of the kernel at omega = 0 (one bin)", 0},
    {"vectors", KEY_VECTORS, "N", 0, "dos, kpm: random vectors, an even number (4 to 64, fewer for more grains)", 0},
    {"seed", KEY_SEED, "S", 0, "dos, kpm: of the random vectors (1)", 0},
    {"source", KEY_SOURCE, "impulse|velocity|displacement", 0, "transmission, harmonic: as in signal (impulse)", 0},
    {"lines", KEY_LINES, NULL, 0, "transmission: the weight of every mode instead (dense)", 0},
    {"direction", KEY_DIRECTION, "x|up", 0, "dispersion: plane waves along x, standing ones along up (x; 1D: up)", 0},
    {"waves", KEY_WAVES, "N", 0, "dispersion: the N longest waves (8)", 0},
    {"node", KEY_NODE, "D", 0, "dispersion, up: nodes so far behind the walls (0; chains: 0.5)", 0},
    {"profile", KEY_PROFILE, NULL, 0, "dispersion: the spectral functions S(k, omega); harmonic: force against height",
     0},
    {"at", KEY_AT, "W1,W2,...|LOW:HIGH:N", 0, "harmonic: frequencies (20 up to the bound of the spectrum)", 0},
    {"damping", KEY_DAMPING, "ZETA", 0, "harmonic: of every contact, a fraction of critical (0)", 0},
    {"layers", KEY_LAYERS, "N", 0, "harmonic: equal layers with planes between them (one a diameter)", 0},
    {"range", KEY_RANGE, "LOW:HIGH", 0, "harmonic: heights that the wave is fitted in (2 d from the walls)", 0},
    {"tolerance", KEY_TOLERANCE, "EPS", 0, "harmonic: error asked for, over |F| (1e-8)", 0},
    {"lowest", KEY_LOWEST, "K", 0, "continuum: the K lowest modes (12)", 0},
    {0}};
static const struct argp_child children[] = {
    {&cli_springs_argp, 0, "Springs:", 50}, {&cli_common_argp, 0, "Common options:", 90}, {0}};

static const struct kind *find_kind(const char *word) {
    for (int k = 0; k < KINDS; k++)
        if (strcmp(word, kinds[k].name) == 0)
            return &kinds[k];
    return NULL;
}

static void positional(arguments *all, char *arg, struct argp_state *state) {
    if (!all->kind) {
        all->kind = find_kind(arg);
        if (!all->kind)
            argp_error(state, "%.60s: must be a kind of spectrum: " KIND_NAMES, arg);
    } else if (all->a.file) {
        argp_error(state, "%.200s: a second file; must be one packing at a time", arg);
    } else {
        all->a.file = arg;
    }
}

/* Kind and file are there, and every option is one of the kind's. */
static void check_usage(const arguments *all, struct argp_state *state) {
    if (!all->kind)
        argp_error(state, "no kind of spectrum: must be " KIND_NAMES);
    if (!all->a.file)
        argp_error(state, "no file: must be one packing");
    for (int k = 0; k < KEYS; k++)
        if (all->given[k] && !(all->kind->options & 1u << k))
            argp_error(state, "--%s: is no option of spectrum %s", all->given[k], all->kind->name);
}

static const char *name_of(int key) {
    for (int k = 0; options[k].name || options[k].key || options[k].doc; k++)
        if (options[k].key == key)
            return options[k].name;
    return "";
}

static sp_status parse_heights(const char *text, double range[2], sp_error *err) {
    char low[64];
    const char *colon = strchr(text, ':');
    if (!colon || (size_t)(colon - text) >= sizeof low)
        return sp_fail(err, SP_EINVAL, "--range %.60s: must be LOW:HIGH", text);
    memcpy(low, text, (size_t)(colon - text));
    low[colon - text] = '\0';
    sp_status status = cli_number("--range", low, 0, 1e9, &range[0], err);
    return status == SP_OK ? cli_number("--range", colon + 1, 1e-9, 1e9, &range[1], err) : status;
}

static error_t parse(int key, char *arg, struct argp_state *state) {
    arguments *all = state->input;
    spectrum_arguments *a = &all->a;
    sp_error err = {0};
    sp_status status = SP_OK;
    if (key >= KEY_METHOD && key < KEY_LAST)
        all->given[key - KEY_METHOD] = name_of(key);
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &a->springs;
        state->child_inputs[1] = &a->common;
        return 0;
    case KEY_METHOD: a->method = arg; break;
    case KEY_NORM: a->norm = arg; break;
    case KEY_BINS: status = cli_integer("--bins", arg, 1, 1000000, &a->bins, &err); break;
    case KEY_UNTIL: status = cli_number("--until", arg, 1e-9, 1e9, &a->until, &err); break;
    case KEY_RESOLUTION: status = cli_number("--resolution", arg, 1e-12, 1e9, &a->resolution, &err); break;
    case KEY_VECTORS: status = cli_integer("--vectors", arg, 2, 10000, &a->vectors, &err); break;
    case KEY_SOURCE:
        if (!cli_source_of(arg, &a->source))
            argp_error(state, "--source %.60s: must be impulse, velocity or displacement", arg);
        break;
    case KEY_LINES: a->lines = true; break;
    case KEY_DIRECTION: a->direction = arg; break;
    case KEY_WAVES: status = cli_integer("--waves", arg, 1, 100000, &a->waves, &err); break;
    case KEY_NODE: status = cli_number("--node", arg, 0, 1e6, &a->node, &err); break;
    case KEY_PROFILE: a->profile = true; break;
    case KEY_AT: a->at = arg; break;
    case KEY_DAMPING: status = cli_number("--damping", arg, 0, 1e6, &a->damping, &err); break;
    case KEY_LAYERS: status = cli_integer("--layers", arg, 2, 100000, &a->layers, &err); break;
    case KEY_LOWEST: status = cli_integer("--lowest", arg, 1, 100000, &a->lowest, &err); break;
    case KEY_RANGE: status = parse_heights(arg, a->range, &err); break;
    case KEY_TOLERANCE: status = cli_number("--tolerance", arg, 1e-15, 0.1, &a->tolerance, &err); break;
    case KEY_SEED: status = cli_integer("--seed", arg, 0, INT64_MAX, &a->seed, &err); break;
    case ARGP_KEY_ARG: positional(all, arg, state); break;
    case ARGP_KEY_END: check_usage(all, state); break;
    default: return ARGP_ERR_UNKNOWN;
    }
    if (status != SP_OK)
        argp_error(state, "%s", err.text);
    return 0;
}

static const struct argp argp = {
    options,
    parse,
    "KIND FILE",
    "Spectra of the network of springs of a packing, both walls fixed. KIND is one of:\n"
    "  dos            density of states\n"
    "  transmission   spectrum of the signal from wall to wall\n"
    "  dispersion     frequencies of longitudinal, transverse and rotational waves\n"
    "  harmonic       response to steady driving; wave number and attenuation\n"
    "  participation  participation ratio of modes against frequency\n"
    "  continuum      lowest modes beside those of a homogeneous elastic strip\v"
    "Frequencies are angular, in sqrt(E* / rho)/d. Comments say method, resolution and what is left out. --set takes "
    "keys of the group network.",
    children,
    NULL,
    NULL};

static sp_status work(const arguments *all, sp_error *err) {
    const spectrum_arguments *a = &all->a;
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
        status = sp_table_add_comment(&t, err, "spectrum = %s", all->kind->name);
        if (status == SP_OK)
            status = sp_table_add_comment(&t, err, "file = %s", a->file);
        if (status == SP_OK)
            status = cli_add_number(&t, "pressure", p.pressure, err);
        if (status == SP_OK)
            status = all->kind->table(a, &p, &net, &t, err);
        if (status != SP_OK && status != SP_EINVAL)
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

int cmd_spectrum(int argc, char **argv) {
    arguments all = {.a = spectrum_arguments_default()};
    argp_parse(&argp, argc, argv, 0, NULL, &all);
    sp_error err = {0};
    return work(&all, &err) == SP_OK ? CLI_OK : cli_fail(&err);
}
