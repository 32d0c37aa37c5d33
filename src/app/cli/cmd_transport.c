/* sonopack transport: prints how the energy of sound moves through packings, as a function of frequency. */
#include "base/base.h"
#include "cli/transport.h"

static const char *const quantity_names[] = {"diffusivity", "kubo", "coherent", "split", "energy", NULL};
static const char *const axis_names[] = {"up", "x", "y", NULL};

static const cli_option options[] = {
    {"quantity", "diffusivity|kubo|coherent|split|energy",
     "What to compute: the diffusivity of energy, from its spreading (diffusivity, the default) or from eigenmodes "
     "(kubo), the mean free path of the coherent wave (coherent), the parts of the energy (split), or its flux after a "
     "burst (energy)",
     CLI_CHOICE, .field = offsetof(transport_arguments, quantity), .words = quantity_names},
    {"at", "W1,W2,...|LOW:HIGH:N",
     "Frequencies (10, from 0.05 to 0.6 of the upper bound of the spectrum of the first packing)", CLI_TEXT,
     .field = offsetof(transport_arguments, at)},
    {"axis", "up|x|y",
     "diffusivity, kubo: the axis along which energy moves, y in 3D only (up; for kubo the mean over the axes without "
     "walls)",
     CLI_CHOICE, .field = offsetof(transport_arguments, axis), .words = axis_names},
    {"width", "W", "All but coherent: width of the band about each frequency, over the frequency (0.1)", CLI_NUMBER,
     .field = offsetof(transport_arguments, width), .low = 0.001, .high = 0.2},
    {"waves", "N", "diffusivity: how many waves of the energy's density the packing holds (1)", CLI_INTEGER,
     .field = offsetof(transport_arguments, waves), .low = 1, .high = 1000},
    {"sources", "N", "diffusivity, split: number of random motions of each packing (6)", CLI_INTEGER,
     .field = offsetof(transport_arguments, sources), .low = 2, .high = 1000},
    {"seed", "N", "diffusivity, split: seed of the random motions (1)", CLI_INTEGER,
     .field = offsetof(transport_arguments, seed), .high = 1e15},
    {"until", "T",
     "diffusivity, energy: last time [d/sqrt(E* / rho)] (300 periods; energy: the window of `signal' of the first "
     "packing)",
     CLI_NUMBER, .field = offsetof(transport_arguments, until), .low = 1e-6, .high = 1e12, .unit = "d/sqrt(E* / rho)"},
    {"smear", "W", "kubo: width of the delta function, over the frequency (0.1)", CLI_NUMBER,
     .field = offsetof(transport_arguments, smear), .low = 0.001, .high = 0.2},
    {"spacing", "D", "coherent: distance between planes [d] (1)", CLI_NUMBER,
     .field = offsetof(transport_arguments, section.spacing), .low = 0.01, .high = 1e6},
    {"low", "Y", "coherent: height of the lowest plane [d] (4)", CLI_NUMBER,
     .field = offsetof(transport_arguments, section.low), .high = 1e6},
    {"part", "F", "coherent: place planes up to this fraction of the height (0.6)", CLI_NUMBER,
     .field = offsetof(transport_arguments, section.part), .low = 0.01, .high = 1},
    {"shear", NULL, "coherent: the transverse wave, from a bottom wall that is moved along x", CLI_FLAG,
     .field = offsetof(transport_arguments, section.shear)},
    {0}};

static const cli_syntax syntax;

#define FOR(quantity) (1U << (quantity))

/* An option that would do nothing is a mistake of the user's. */
static sp_status check(void *user, sp_error *err) {
    static const struct {
        const char *name;
        unsigned used;
        const char *where;
    } only[] = {
        {"width", ~FOR(TRANSPORT_COHERENT), "all but coherent"},
        {"waves", FOR(TRANSPORT_DIFFUSIVITY), "diffusivity"},
        {"sources", FOR(TRANSPORT_DIFFUSIVITY) | FOR(TRANSPORT_SPLIT), "diffusivity or split"},
        {"seed", FOR(TRANSPORT_DIFFUSIVITY) | FOR(TRANSPORT_SPLIT), "diffusivity or split"},
        {"until", FOR(TRANSPORT_DIFFUSIVITY) | FOR(TRANSPORT_ENERGY), "diffusivity or energy"},
        {"smear", FOR(TRANSPORT_KUBO), "kubo"},
        {"spacing", FOR(TRANSPORT_COHERENT), "coherent"},
        {"low", FOR(TRANSPORT_COHERENT), "coherent"},
        {"part", FOR(TRANSPORT_COHERENT), "coherent"},
        {"shear", FOR(TRANSPORT_COHERENT), "coherent"},
    };
    const transport_arguments *a = user;
    for (size_t k = 0; k < sizeof only / sizeof *only; k++)
        if (!(only[k].used & FOR(a->quantity)) && cli_given(&syntax, &a->common, only[k].name))
            return sp_fail(err, SP_EINVAL, "--%s: only with --quantity=%s", only[k].name, only[k].where);
    if (a->axis > 0 && a->quantity >= TRANSPORT_COHERENT)
        return sp_fail(err, SP_EINVAL, "--axis: only with --quantity=diffusivity or kubo");
    return SP_OK;
}

static const cli_syntax syntax = {
    .usage = "FILE...",
    .help =
        "How the energy of sound moves through packings: diffusivity and mean free paths at each frequency.\v"
        "The table has the means over the packings and their standard errors; if only one packing gives a value, "
        "the error is that over its random motions or modes. samples: number of packings that gave a value. nan: fewer "
        "than half of the packings gave one, for example because energy crosses them before it is scattered, or does "
        "not leave the place where it starts.\n"
        "\n"
        "diffusivity: random motions in a band about omega, with more energy on one side of the packing than on the "
        "other. The difference decays like exp(-D q^2 t) from 0.7 to 0.2 of its value at the start, between the times "
        "from and to. shift: D of the later half of this decay minus D of the earlier half. half: D from a wave of "
        "half the length minus D. Both are near 0 if the energy diffuses.\n"
        "\n"
        "kubo: D from the matrix elements of the energy's current between all eigenmodes, speed: at which energy moves "
        "before it is scattered, path = dimension D/speed, the transport mean free path. shift: change of D if the "
        "delta function is half as wide. Needs an axis without walls.\n"
        "\n"
        "coherent: k and alpha of the wave as in `wave', path = 1/(2 alpha), the scattering mean free path, and k_path "
        "= k path. The comment ioffe_regel is the lowest frequency at which k_path falls to pi, where the mean free "
        "path is "
        "half a wavelength. path_low: lower bound of path, from alpha plus two errors; if alpha is not above twice its "
        "error, it is all that is known, and path and k_path are nan. part: fraction of the squared flux that the wave "
        "accounts for; a fit with less than half is left out. The errors of a single packing are estimated from what "
        "the fit leaves over, and from a fit to half of the time.\n"
        "\n"
        "split: parts of the energy in the band: kinetic of translation along the up axis (along), along the others "
        "(across) and of rotation, potential of normal and of tangential springs. They are those of random motions, in "
        "which all modes have the same energy; pulse_ are those of the motion after an impulse at the bottom wall, 100 "
        "to 200 periods later.\n"
        "\n"
        "energy: an impulse at the bottom wall, filtered to the band; its energy is 1. below: the part of it that is "
        "in "
        "the grains below the plane at this fraction of the height at the time t, one of 24; flux: what passes the "
        "plane upward in a unit of time (1/s in SI, shown as rad/s), and of it the work of normal forces, of "
        "tangential forces on the translation of the grains (sideways), and of their torques. For a single packing the "
        "errors are those of rounding.",
    .finds_material = true,
    .options = options,
    .file_name = "packing",
    .files_min = 1,
    .files_max = CLI_ANY_NUMBER,
    .springs = true,
    .check = check};

static sp_status begin(void *user, sp_table *t, sp_error *err) {
    transport_arguments *a = user;
    const size_t values = (size_t)TRANSPORT_FREQUENCIES_MAX * TRANSPORT_VALUES;
    (void)t;
    a->omega = sp_alloc(TRANSPORT_FREQUENCIES_MAX, sizeof *a->omega);
    a->mean = sp_alloc(values, sizeof *a->mean);
    return a->omega && a->mean ? SP_OK : sp_fail_memory(err, values * sizeof *a->mean);
}

static sp_status choose_frequencies(transport_arguments *a, const sp_network *net, sp_error *err) {
    if (a->at)
        return cli_frequencies(a->at, TRANSPORT_FREQUENCIES_MAX, &a->n, a->omega, err);
    const double bound = sp_network_omega_bound(net);
    for (a->n = 0; a->n < TRANSPORT_FREQUENCIES; a->n++)
        a->omega[a->n] = bound * (0.05 + 0.55 * a->n / (TRANSPORT_FREQUENCIES - 1));
    return SP_OK;
}

static sp_status add_packing(void *user, cli_file *file, sp_table *t, sp_error *err) {
    transport_arguments *a = user;
    (void)t;
    if (a->dim && a->dim != file->packing.dim)
        return sp_fail(err, SP_EREFUSED, "has %d dimensions, the packings before it have %d", file->packing.dim,
                       a->dim);
    a->dim = file->packing.dim;
    if (a->axis > a->dim - 1)
        return sp_fail(err, SP_EINVAL, "--axis=%s: the packing has %d dimensions", axis_names[a->axis], a->dim);
    sp_status status = a->n == 0 ? choose_frequencies(a, &file->network, err) : SP_OK;
    return status == SP_OK ? transport_measure(a, &file->network, err) : status;
}

static sp_status add_rows(void *user, sp_table *t, sp_error *err) {
    transport_arguments *a = user;
    cli_writer w = {.table = t, .err = err};
    cli_comment(&w, "packings = %d", a->common.files);
    cli_comment(&w, "dimension = %d", a->dim);
    cli_comment(&w, "quantity = %s", quantity_names[a->quantity]);
    if (a->quantity == TRANSPORT_COHERENT)
        cli_comment(&w, "motion = %s", a->section.shear ? "shear" : "compression");
    else if (a->quantity <= TRANSPORT_KUBO)
        cli_comment(&w, "axis = %s", a->quantity == TRANSPORT_KUBO && a->axis == 0 ? "mean" : axis_names[a->axis]);
    transport_print(a, &w);
    return w.status;
}

int cmd_transport(int argc, char **argv) {
    static const cli_files command = {.groups = "network",
                                      .contents = CLI_NETWORK,
                                      .stop = true,
                                      .begin = begin,
                                      .add = add_packing,
                                      .end = add_rows};
    transport_arguments a = {.width = 0.1, .smear = 0.1, .waves = 1, .sources = 6, .seed = 1};
    a.section = sp_coherent_section_options_default();
    cli_parse(&syntax, argc, argv, &a);
    const int status = cli_run_files(&command, &a);
    sp_free(a.omega);
    sp_free(a.mean);
    return status;
}
