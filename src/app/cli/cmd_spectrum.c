/* sonopack spectrum: prints spectra of a packing, its response to driving, and the dispersion of its waves. */
#include "base/base.h"
#include "cli/excitation.h"
#include "cli/spectrum.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const char *const kinds[] = {"dos",           "transmission", "dispersion", "harmonic",
                                    "participation", "continuum",    NULL};
static const spectrum_table tables[] = {spectrum_dos,      spectrum_transmission,  spectrum_dispersion,
                                        spectrum_harmonic, spectrum_participation, spectrum_continuum};

spectrum_arguments spectrum_arguments_default(void) {
    spectrum_arguments a = {.method = -1, .norm = -1, .direction = -1, .range = {NAN, NAN}};
    a.bins = a.vectors = a.seed = a.waves = a.layers = a.lowest = -1;
    a.until = a.resolution = a.damping.value = a.node = a.tolerance = -1;
    return a;
}

static sp_status set_range(void *user, const char *text, sp_error *err) {
    spectrum_arguments *a = user;
    char low[64];
    const char *colon = strchr(text, ':');
    if (!colon || (size_t)(colon - text) >= sizeof low)
        return sp_fail(err, SP_EINVAL, "--range %.60s: must be LOW:HIGH", text);
    snprintf(low, sizeof low, "%.*s", (int)(colon - text), text);
    sp_status status = cli_number("--range", low, 0, 1e9, &a->range[0], err);
    return status == SP_OK ? cli_number("--range", colon + 1, 1e-9, 1e9, &a->range[1], err) : status;
}

static sp_status set_damping(void *user, const char *text, sp_error *err) {
    return cli_damping_read(text, 0, 1e6, &((spectrum_arguments *)user)->damping, err);
}

#define FIELD(name) .field = offsetof(spectrum_arguments, name)

typedef spectrum_arguments arguments;

static const cli_option options[] = {
    {"method", "auto|exact|kpm|count",
     "dos: all frequencies (exact), kernel polynomials (kpm), or the number of modes in each bin (count) (auto: exact "
     "up "
     "to 3000 degrees of freedom, else kpm)",
     CLI_CHOICE, FIELD(method), .words = spectrum_dos_methods, .kinds = "dos"},
    {"norm", "grain|one|modes", "dos: modes per grain (without rattlers), unit integral, or numbers of modes (grain)",
     CLI_CHOICE, FIELD(norm), .words = spectrum_dos_norms, .kinds = "dos"},
    {"bins", "N", "Number of equally spaced frequencies (100)", CLI_INTEGER, FIELD(bins), .low = 1, .high = 1000000,
     .kinds = "dos transmission dispersion participation"},
    {"omega-max", "OMEGA", "Last frequency (the upper bound of the spectrum).", CLI_NUMBER, FIELD(until), .low = 1e-9,
     .high = 1e9, .kinds = "dos transmission participation"},
    {"resolution", "WIDTH", "Standard deviation of the kernel at omega = 0 (one bin)", CLI_NUMBER, FIELD(resolution),
     .low = 1e-12, .high = 1e9, .kinds = "dos transmission dispersion"},
    {"vectors", "N", "dos, kpm: number of random vectors, even (4 to 64, fewer for larger packings)", CLI_INTEGER,
     FIELD(vectors), .low = 2, .high = 10000, .kinds = "dos"},
    {"seed", "S", "dos, kpm: seed of the random vectors (1)", CLI_INTEGER, FIELD(seed), .high = 9.3e18, .kinds = "dos"},
    {"source", "impulse|velocity|displacement", "transmission, harmonic: kind of source, as in signal (impulse)",
     CLI_CHOICE, FIELD(source), .words = cli_source_names, .kinds = "transmission harmonic"},
    {"lines", NULL, "transmission: print the weight of every mode instead (computes all modes)", CLI_FLAG, FIELD(lines),
     .kinds = "transmission"},
    {"direction", "x|up|y",
     "dispersion: plane waves along x, or standing waves between the walls (x; chains: up); y in three dimensions. "
     "Waves are plane where the cell is periodic, and stand where it has walls",
     CLI_CHOICE, FIELD(direction), .words = spectrum_directions, .kinds = "dispersion"},
    {"waves", "N", "dispersion: the N longest waves (8)", CLI_INTEGER, FIELD(waves), .low = 1, .high = 100000,
     .kinds = "dispersion"},
    {"node", "D", "dispersion up: distance of the nodes behind the walls [d] (0; chains: 0.5)", CLI_NUMBER, FIELD(node),
     .high = 1e6, .kinds = "dispersion"},
    {"profile", NULL, "dispersion: print the spectral functions S(k, omega); harmonic: print the force against height",
     CLI_FLAG, FIELD(profile), .kinds = "dispersion harmonic"},
    {"at", "W1,W2,...|LOW:HIGH:N", "harmonic: frequencies (20 up to the upper bound of the spectrum)", CLI_TEXT,
     FIELD(at), .kinds = "harmonic"},
    {"damping", CLI_DAMPING, "harmonic: dashpots of the contacts, as in signal (0)", .parse = set_damping,
     .kinds = "harmonic"},
    {"layers", "N", "harmonic: number of equal layers, with planes between them (one per diameter)", CLI_INTEGER,
     FIELD(layers), .low = 2, .high = 100000, .kinds = "harmonic"},
    {"range", "LOW:HIGH", "harmonic: fit the wave between these heights [d] (up to 2 d from the walls)",
     .parse = set_range, .kinds = "harmonic"},
    {"tolerance", "EPS", "harmonic: largest error, relative to |F| (1e-8)", CLI_NUMBER, FIELD(tolerance), .low = 1e-15,
     .high = 0.1, .kinds = "harmonic"},
    {"lowest", "K", "continuum: the K lowest modes (12)", CLI_INTEGER, FIELD(lowest), .low = 1, .high = 100000,
     .kinds = "continuum"},
    {"solver", CLI_SOLVERS, "continuum, participation, transmission --lines: solver of the modes, as in modes (auto)",
     CLI_CHOICE, FIELD(solver), .words = cli_solver_names, .kinds = "continuum participation transmission"},
    CLI_DRY_RUN,
    {0}};

static const cli_syntax syntax = {
    .usage = "KIND FILE",
    .help =
        "Spectra of the spring network of a packing between fixed walls. KIND is one of:\n"
        "  dos            density of states\n"
        "  transmission   spectrum of the signal from wall to wall\n"
        "  dispersion     frequencies of longitudinal, transverse and rotational waves\n"
        "  harmonic       response to harmonic driving, with wave number and attenuation\n"
        "  participation  participation ratio of the modes against frequency\n"
        "  continuum      lowest modes compared with those of a homogeneous elastic strip\v"
        "All frequencies are angular frequencies, in sqrt(E* / rho)/d. Comments give the method, the resolution, and "
        "what is left out. --set takes keys of the group network.",
    .finds_material = true,
    .options = options,
    .kinds = kinds,
    .kind_name = "kind of spectrum",
    .file_name = "packing",
    .files_min = 1,
    .files_max = 1,
    .springs = true};

static sp_status add_rows(void *user, cli_file *file, sp_table *t, sp_error *err) {
    const spectrum_arguments *a = user;
    cli_writer w = {.table = t, .err = err};
    cli_comment(&w, "spectrum = %s", kinds[a->common.kind]);
    cli_comment(&w, "file = %s", file->path);
    cli_value(&w, "pressure", file->packing.pressure);
    return w.status == SP_OK ? tables[a->common.kind](a, file, t, err) : w.status;
}

/* ---- --dry-run -------------------------------------------------------------------------------------------------- */

enum { DOS = 0, TRANSMISSION, DISPERSION, HARMONIC, PARTICIPATION, CONTINUUM }; /* as in kinds */

/* Number of frequencies of --at. */
static double count_frequencies(const spectrum_arguments *a) {
    int32_t n = SPECTRUM_FREQUENCIES;
    double *omega = sp_alloc(SPECTRUM_FREQUENCIES_MAX, sizeof *omega);
    if (omega && a->at)
        cli_frequencies(a->at, SPECTRUM_FREQUENCIES_MAX, &n, omega, NULL);
    sp_free(omega);
    return n;
}

/* Whether a kind needs all modes. */
static bool needs_modes(const spectrum_arguments *a, const sp_network_size *net) {
    enum { AUTO = 0, EXACT = 1, DENSE_MOST = 3000 };
    switch (a->common.kind) {
    case DOS: return a->method == EXACT || (a->method <= AUTO && net->dofs <= DENSE_MOST);
    case TRANSMISSION: return a->lines;
    default: return a->common.kind == PARTICIPATION;
    }
}

static sp_cost kind_cost(const spectrum_arguments *a, const sp_network_size *net, double rows,
                         const sp_machine *machine) {
    static const sp_network_result result[] = {SP_RESULT_DENSITY,  SP_RESULT_TRANSMISSION, SP_RESULT_DISPERSION,
                                               SP_RESULT_HARMONIC, SP_RESULT_DENSITY,      SP_RESULT_CONTINUUM};
    const int kind = a->common.kind;
    const sp_modes_options o = {.vectors = kind != DOS, .solver = (sp_modes_solver)a->solver};
    const sp_modes_range all = sp_modes_range_all();
    if (needs_modes(a, net))
        return sp_cost_modes(net, &o, &all, net->dofs, machine);
    return sp_cost_result(result[kind], net, kind == DOS || kind == HARMONIC ? rows : 1, machine);
}

static sp_status plan(void *user, const cli_file *file, cli_plan *p, sp_error *err) {
    const spectrum_arguments *a = user;
    const sp_network_size net = sp_network_size_of(&file->network, sp_packing_height(&file->packing));
    const double rows = a->common.kind == HARMONIC ? count_frequencies(a) : a->bins > 0 ? (double)a->bins : 100;
    (void)err;
    cli_plan_add(p, "network", 1, sp_cost_result(SP_RESULT_NETWORK, &net, 1, &p->machine), 0);
    cli_plan_add(p, kinds[a->common.kind], 1, kind_cost(a, &net, rows, &p->machine),
                 a->common.output ? sp_bytes_table(rows, 6) : 0);
    return SP_OK;
}

int cmd_spectrum(int argc, char **argv) {
    static const cli_files command = {.groups = "network",
                                      .contents = CLI_NETWORK,
                                      .stop = true,
                                      .add = add_rows,
                                      .plan = plan,
                                      .kernels =
                                          1U << SP_KERNEL_PRODUCT | 1U << SP_KERNEL_DENSE | 1U << SP_KERNEL_SPARSE};
    spectrum_arguments a = spectrum_arguments_default();
    cli_parse(&syntax, argc, argv, &a);
    return cli_run_files(&command, &a);
}
