/* Prints (sonopack transport, sonopack wave) how the energy of sound and its coherent wave move through packings, as
 * means over packings at each frequency. */
#include "base/base.h"
#include "cli/excitation.h"
#include "cli/files.h"

#include <math.h>
#include <sonopack/coherent.h>
#include <sonopack/transport.h>
#include <stdio.h>

#define RATE        "sqrt(E* / rho)/d"
#define TIME        "d/sqrt(E* / rho)"
#define SPEED       "sqrt(E* / rho)"
#define DIFFUSIVITY "d sqrt(E* / rho)"

enum { FREQUENCIES_MAX = 10000, VALUES_MAX = 10 };

/* Of --quantity. */
enum { SPREAD = 0, KUBO, COHERENT, SPLIT, ENERGY };
static const char *const quantity_names[] = {"diffusivity", "kubo", "coherent", "split", "energy", NULL};
static const char *const axis_names[] = {"up", "x", "y", NULL};

/* A mean over packings. The error is the standard error of the mean; with one packing it is what that packing gave. A
 * value that only `few` of the packings gave would be a mean over chosen packings: nan. */
typedef struct mean {
    bool few;
    int64_t n;
    double sum, squares, own, shared[2];
} mean;

typedef struct arguments {
    cli_common common;
    int axis;
    const char *at;
    double smear;
    sp_spread_options spread; /* with what the other quantities share of it */
    sp_coherent_section_options section;
    sp_damping damping;
    int dim; /* of the packings so far; 0: none */
    int32_t n;
    double *omega; /* [n] */
    mean *mean;    /* [n][VALUES_MAX], or for energy [n][times][planes][values] */
} arguments;

static const cli_option options[] = {
    {"quantity", "diffusivity|kubo|coherent|split|energy",
     "What to compute: the diffusivity of energy, from its spreading (diffusivity, the default) or from eigenmodes "
     "(kubo), the mean free path of the coherent wave (coherent), the parts of the energy (split), or its flux after a "
     "burst (energy)",
     CLI_CHOICE, CLI_FIELD(common.kind), .words = quantity_names},
    {"at", "W1,W2,...|LOW:HIGH:N",
     "Frequencies (10, from 0.05 to 0.6 of the upper bound of the spectrum of the first packing)", CLI_TEXT,
     CLI_FIELD(at)},
    {"axis", "up|x|y",
     "diffusivity, kubo: the axis along which energy moves, y in 3D only (up; for kubo the mean over the axes without "
     "walls)",
     CLI_CHOICE, CLI_FIELD(axis), .words = axis_names, .kinds = "diffusivity kubo"},
    {"width", "W", "All but coherent: width of the band about each frequency, over the frequency (0.1)", CLI_NUMBER,
     CLI_FIELD(spread.width), .low = 0.001, .high = 0.2, .kinds = "diffusivity kubo split energy"},
    {"waves", "N", "diffusivity: how many waves of the energy's density the packing holds (1)", CLI_INT,
     CLI_FIELD(spread.waves), .low = 1, .high = 1000, .kinds = "diffusivity"},
    {"sources", "N", "diffusivity, split: number of random motions of each packing (6)", CLI_INT,
     CLI_FIELD(spread.sources), .low = 2, .high = 1000, .kinds = "diffusivity split"},
    {"seed", "N", "diffusivity, split: seed of the random motions (1)", CLI_INTEGER, CLI_FIELD(spread.seed),
     .high = 1e15, .kinds = "diffusivity split"},
    {"until", "T",
     "diffusivity, energy: last time [d/sqrt(E* / rho)] (300 periods; energy: the window of `signal' of the first "
     "packing)",
     CLI_NUMBER, CLI_FIELD(spread.until), .low = 1e-6, .high = 1e12, .unit = "d/sqrt(E* / rho)",
     .kinds = "diffusivity energy"},
    {"smear", "W", "kubo: width of the delta function, over the frequency (0.1)", CLI_NUMBER, CLI_FIELD(smear),
     .low = 0.001, .high = 0.2, .kinds = "kubo"},
    {"spacing", "D", "coherent: distance between planes [d] (1)", CLI_NUMBER, CLI_FIELD(section.spacing), .low = 0.01,
     .high = 1e6, .kinds = "coherent"},
    {"low", "Y", "coherent: height of the lowest plane [d] (4)", CLI_NUMBER, CLI_FIELD(section.low), .high = 1e6,
     .kinds = "coherent"},
    {"part", "F", "coherent: place planes up to this fraction of the height (0.6)", CLI_NUMBER, CLI_FIELD(section.part),
     .low = 0.01, .high = 1, .kinds = "coherent"},
    {"shear", NULL, "coherent: the transverse wave, from a bottom wall that is moved along x", CLI_FLAG,
     CLI_FIELD(section.shear), .kinds = "coherent"},
    {0}};

const cli_syntax cmd_transport_syntax = {
    .usage = "FILE...",
    .help =
        "How the energy of sound moves through packings: diffusivity and mean free paths at each frequency.\v"
        "The table has the means over the packings and their standard errors; if only one packing gives a value, the "
        "error is that over its random motions or modes. samples: number of packings that gave a value. nan: fewer "
        "than half of the packings gave one, for example because energy crosses them before it is scattered, or does "
        "not leave the place where it starts.\n"
        "\n"
        "diffusivity: random motions in a band about omega, with more energy on one side of the packing than on the "
        "other. The difference decays like exp(-D q^2 t) from 0.7 to 0.2 of its value at the start, between the times "
        "from and to. shift: D of the later half of this decay minus D of the earlier half. half: D from a wave of "
        "half the length minus D. Both are near 0 if the energy diffuses; the error of D holds shift and twice half in "
        "quadrature.\n"
        "\n"
        "kubo: D from the matrix elements of the energy's current between all eigenmodes, speed: at which energy "
        "moves before it is scattered, path = dimension D/speed, the transport mean free path. shift: change of D if "
        "the delta function is half as wide; the errors of D and path hold twice that in quadrature. Needs an axis "
        "without walls.\n"
        "\n"
        "coherent: k and alpha of the wave as in `wave', path = 1/(2 alpha), the scattering mean free path, and "
        "k_path = k path. The comment ioffe_regel is the lowest frequency at which k_path falls to pi, where the mean "
        "free path is half a wavelength. path_low: lower bound of path, from alpha plus two errors; if alpha is not "
        "above twice its error, it is all that is known, and path and k_path are nan. part: fraction of the squared "
        "flux that the wave accounts for; a fit with less than half is left out. The errors of a single packing are "
        "estimated from what the fit leaves over, and from a fit to half of the time.\n"
        "\n"
        "split: parts of the energy in the band: kinetic of translation along the up axis (along), along the others "
        "(across) and of rotation, potential of normal and of tangential springs. They are those of random motions, "
        "in which all modes have the same energy; pulse_ are those of the motion after an impulse at the bottom wall, "
        "100 to 200 periods later.\n"
        "\n"
        "energy: an impulse at the bottom wall, filtered to the band; its energy is 1. below: the part of it that is "
        "in the grains below the plane at this fraction of the height at the time t, one of 24; flux: what passes the "
        "plane upward in a unit of time (1/s in SI, shown as rad/s), and of it the work of normal forces, of "
        "tangential forces on the translation of the grains (sideways), and of their torques. For a single packing "
        "the errors are those of rounding.",
    CLI_PACKINGS,
    .options = options,
    .springs = true,
    .kinds_by_option = quantity_names};

/* ---- means ------------------------------------------------------------------------------------------------------- */

static mean *means_at(const arguments *a, int32_t l) { return a->mean + (int64_t)l * VALUES_MAX; }

/* Adds the value of one packing with its own error; nothing if the value is nan. */
static void add(mean *m, double value, double error) {
    if (isnan(value))
        return;
    m->n++;
    m->sum += value;
    m->squares += value * value;
    m->own = error;
}

/* An error that all packings share: that of the method, not of the sample. */
static void add_shared(mean *m, int kind, double error) { m->shared[kind] += isnan(error) ? 0 : error; }

static double value_of(const mean *m) { return m->n > 0 && !m->few ? m->sum / (double)m->n : NAN; }

static double error_of(const mean *m) {
    const double n = (double)m->n;
    if (m->few)
        return NAN;
    if (m->n == 1)
        return m->own;
    return m->n > 1 ? hypot(sqrt(fmax(0, m->squares - m->sum * m->sum / n) / (n - 1) / n),
                            hypot(m->shared[0], m->shared[1]) / n)
                    : NAN;
}

/* ---- one packing ------------------------------------------------------------------------------------------------- */

/* Measures at frequency l, and adds to the means of it. */
typedef sp_status (*measure)(const arguments *a, const sp_network *net, int32_t l, sp_error *err);

/* A frequency that is refused, such as one without modes, has no value, but others may. The reason counts if it is that
 * of all. */
static sp_status at_each(const arguments *a, const sp_network *net, measure one, sp_error *err) {
    sp_status status = SP_OK;
    for (int32_t l = 0, left = a->n; l < a->n && status == SP_OK; l++) {
        status = one(a, net, l, err);
        if (status != SP_EREFUSED || --left == 0)
            continue;
        cli_note(&a->common, "omega = %g has no value: %s", a->omega[l], err->text);
        status = SP_OK;
    }
    return status;
}

static sp_status measure_spread(const arguments *a, const sp_network *net, int32_t l, sp_error *err) {
    sp_spread_options o = a->spread;
    mean *m = means_at(a, l);
    sp_spread s;
    o.axis = a->axis - 1; /* -1: the default */
    const sp_status status = sp_spread_make(net, a->omega[l], &o, &s, err);
    if (status != SP_OK || isnan(s.d))
        return status;
    add(&m[0], s.d, s.d_err);
    add_shared(&m[0], 0, s.d_shift);
    add_shared(&m[0], 1, SP_SPREAD_HALVES * s.d_half);
    add(&m[1], s.d_shift, NAN);
    add(&m[2], s.d_half, NAN);
    add(&m[3], s.from, NAN);
    add(&m[4], s.to, NAN);
    return SP_OK;
}

static void add_kubo(const arguments *a, const sp_kubo *k, mean *m) {
    const double path = a->dim * k->d / k->speed;
    add(&m[0], k->d, k->d_err);
    add(&m[1], k->d_shift, NAN);
    add(&m[2], k->speed, k->speed_err);
    add(&m[3], path, path * hypot(k->d_err / k->d, k->speed_err / k->speed));
    add_shared(&m[0], 0, SP_KUBO_SHIFTS * k->d_shift);
    add_shared(&m[3], 0, SP_KUBO_SHIFTS * k->d_shift * path / k->d);
}

static sp_status measure_kubo(const arguments *a, const sp_network *net, sp_error *err) {
    const sp_modes_options mo = sp_modes_options_default();
    const sp_kubo_options o = {.axis = a->axis - 1, .width = a->spread.width, .smear = a->smear};
    sp_modes modes = sp_modes_none();
    sp_kubo *k = sp_alloc((size_t)a->n, sizeof *k);
    sp_status status = k ? SP_OK : sp_fail_memory(err, (size_t)a->n * sizeof *k);
    CLI_THEN(status, sp_modes_dense(net, &mo, &modes, err));
    CLI_THEN(status, sp_kubo_make(net, &modes, a->n, a->omega, &o, k, err));
    for (int32_t l = 0; l < a->n && status == SP_OK; l++)
        add_kubo(a, &k[l], means_at(a, l));
    sp_modes_free(&modes);
    sp_free(k);
    return status;
}

static sp_status measure_coherent(const arguments *a, const sp_network *net, sp_error *err) {
    sp_coherent_section s = sp_coherent_section_none();
    sp_status status = sp_coherent_section_make(net, &a->section, &s, err);
    for (int32_t l = 0; l < a->n && status == SP_OK; l++) {
        sp_coherent_wave c;
        double k_err, alpha_err;
        status = sp_coherent_fit(&s, a->omega[l], &c, err);
        if (status != SP_OK || isnan(c.k) || !(c.part >= 0.5)) /* most of the motion is scattered */
            continue;
        sp_coherent_errors(&s, &c, &k_err, &alpha_err);
        add(&means_at(a, l)[0], c.k, k_err);
        add(&means_at(a, l)[1], c.alpha, alpha_err);
        add(&means_at(a, l)[2], c.part, NAN);
    }
    sp_coherent_section_free(&s);
    return status;
}

static void add_energy(const sp_energy *e, const sp_energy *error, mean *m) {
    add(&m[0], e->along, error->along);
    add(&m[1], e->across, error->across);
    add(&m[2], e->rotation, error->rotation);
    add(&m[3], e->normal, error->normal);
    add(&m[4], e->tangential, error->tangential);
}

static sp_status measure_split(const arguments *a, const sp_network *net, int32_t l, sp_error *err) {
    sp_split_options o = sp_split_options_default();
    sp_split s;
    o.width = a->spread.width;
    o.sources = a->spread.sources;
    o.seed = a->spread.seed;
    const sp_status status = sp_split_make(net, a->omega[l], &o, &s, err);
    if (status != SP_OK)
        return status;
    add_energy(&s.rest, &s.rest_err, means_at(a, l));
    add_energy(&s.pulse, &s.pulse_err, means_at(a, l) + 5);
    return SP_OK;
}

/* Planes at quarters of the height, and equally spaced times up to a->spread.until, which the first packing sets. */
enum { TIMES = 24, PLANES = 3, BURST_VALUES = 5, BURST_ROWS = TIMES * PLANES };
static const double ROUNDING = 1e-11; /* of parts of the energy, by tests; the drift is that of all of it */

static double burst_time(const arguments *a, int k) { return a->spread.until * (k + 1) / TIMES; }

/* The flux of an energy 1 is at most about the highest frequency, and so are its rounding errors beside those of the
 * energy. */
static void add_burst(double below, const sp_flux *flux, double drift, double highest, mean *m) {
    const double error = highest * drift;
    add(&m[0], below, drift);
    add(&m[1], sp_flux_sum(flux), error);
    add(&m[2], flux->normal, error);
    add(&m[3], flux->sideways, error);
    add(&m[4], flux->rotation, error);
}

static sp_status measure_burst(const arguments *a, const sp_network *net, int32_t l, sp_error *err) {
    double t[TIMES], height[PLANES], below[BURST_ROWS], drift = 0;
    sp_flux flux[BURST_ROWS];
    for (int k = 0; k < TIMES; k++)
        t[k] = burst_time(a, k);
    for (int k = 0; k < PLANES; k++)
        height[k] = net->box[net->dim - 1] * (k + 1) / (PLANES + 1);
    const sp_burst_options o = {a->omega[l], a->spread.width, TIMES, t, PLANES, height};
    const sp_status status = sp_burst_make(net, &o, below, flux, &drift, err);
    for (int row = 0; row < BURST_ROWS && status == SP_OK; row++)
        add_burst(below[row], &flux[row], drift + ROUNDING, sp_network_omega_bound(net),
                  a->mean + ((int64_t)l * BURST_ROWS + row) * BURST_VALUES);
    return status;
}

static sp_status measure_energy(arguments *a, const sp_network *net, sp_error *err) {
    enum { MOST = 27 }; /* the table has BURST_ROWS rows for each */
    if (a->n > MOST)
        return sp_fail(err, SP_EINVAL, "--at: %d frequencies, energy takes at most %d", a->n, MOST);
    if (!(a->spread.until > 0))
        a->spread.until = sp_signal_window(net->box[net->dim - 1], net->pressure);
    return at_each(a, net, measure_burst, err);
}

static sp_status measure_packing(arguments *a, const sp_network *net, sp_error *err) {
    switch (a->common.kind) {
    case KUBO: return measure_kubo(a, net, err);
    case COHERENT: return measure_coherent(a, net, err);
    case SPLIT: return at_each(a, net, measure_split, err);
    case ENERGY: return measure_energy(a, net, err);
    default: return at_each(a, net, measure_spread, err);
    }
}

static sp_status begin(void *user, cli_writer *w) {
    arguments *a = user;
    const size_t values = (size_t)FREQUENCIES_MAX * VALUES_MAX;
    a->omega = sp_alloc(FREQUENCIES_MAX, sizeof *a->omega);
    a->mean = sp_alloc(values, sizeof *a->mean);
    return a->omega && a->mean ? SP_OK : sp_fail_memory(w->err, values * sizeof *a->mean);
}

static sp_status choose_frequencies(arguments *a, const sp_network *net, sp_error *err) {
    enum { MANY = 10 };
    if (a->n > 0)
        return SP_OK;
    if (a->at)
        return cli_frequencies(a->at, FREQUENCIES_MAX, &a->n, a->omega, err);
    for (; a->n < MANY; a->n++)
        a->omega[a->n] = sp_network_omega_bound(net) * (0.05 + 0.55 * a->n / (MANY - 1));
    return SP_OK;
}

static sp_status check_dimension(arguments *a, const cli_file *file, sp_error *err) {
    if (a->dim && a->dim != file->packing.dim)
        return sp_fail(err, SP_EREFUSED, "has %d dimensions, the packings before it have %d", file->packing.dim,
                       a->dim);
    a->dim = file->packing.dim;
    return SP_OK;
}

static sp_status add_packing(void *user, cli_file *file, cli_writer *w) {
    arguments *a = user;
    sp_status status = check_dimension(a, file, w->err);
    if (status == SP_OK && a->axis > a->dim - 1)
        return sp_fail(w->err, SP_EINVAL, "--axis=%s: the packing has %d dimensions", axis_names[a->axis], a->dim);
    CLI_THEN(status, choose_frequencies(a, &file->network, w->err));
    CLI_THEN(status, measure_packing(a, &file->network, w->err));
    return status;
}

/* ---- the table --------------------------------------------------------------------------------------------------- */

/* The values of a quantity, in the order in which they are measured. */
typedef struct column {
    const char *name, *unit;
    bool has_error; /* a column of it follows */
} column;
static const column columns[][VALUES_MAX + 1] = {
    [SPREAD] = {{"D", DIFFUSIVITY, true},
                {"shift", DIFFUSIVITY, false},
                {"half", DIFFUSIVITY, false},
                {"from", TIME, false},
                {"to", TIME, false}},
    [KUBO] = {{"D", DIFFUSIVITY, true}, {"shift", DIFFUSIVITY, false}, {"speed", SPEED, true}, {"path", "d", true}},
    [SPLIT] = {{"along", "", true},
               {"across", "", true},
               {"rotation", "", true},
               {"normal", "", true},
               {"tangential", "", true},
               {"pulse_along", "", true},
               {"pulse_across", "", true},
               {"pulse_rotation", "", true},
               {"pulse_normal", "", true},
               {"pulse_tangential", "", true}},
    [ENERGY] = {{"below", "", true},
                {"flux", RATE, true},
                {"flux_normal", RATE, true},
                {"flux_sideways", RATE, true},
                {"flux_rotation", RATE, true}}};

static void add_columns(const column *c, cli_writer *w) {
    char error[40];
    for (; c->name; c++) {
        snprintf(error, sizeof error, "%s_err", c->name);
        cli_columns(w, SP_COLUMN_NUMBER, c->name, c->unit, c->has_error ? error : NULL, c->unit, NULL);
    }
    cli_columns(w, SP_COLUMN_INTEGER, "samples", "", NULL);
}

/* The values with their errors, and how many packings gave the first, end a row. */
static void end_row(const column *c, const mean *m, cli_writer *w) {
    const mean *first = m;
    for (; c->name; c++, m++) {
        cli_put(w, value_of(m));
        if (c->has_error)
            cli_put(w, error_of(m));
    }
    cli_put(w, (double)first->n);
    cli_end_row(w);
}

static void print_values(const arguments *a, cli_writer *w) {
    const column *c = columns[a->common.kind];
    const bool energy = a->common.kind == ENERGY;
    cli_columns(w, SP_COLUMN_NUMBER, "omega", RATE, NULL);
    if (energy)
        cli_columns(w, SP_COLUMN_NUMBER, "t", TIME, "plane", "", NULL);
    add_columns(c, w);
    for (int32_t l = 0; l < a->n; l++)
        for (int k = 0; k < (energy ? BURST_ROWS : 1); k++) {
            cli_put(w, a->omega[l]);
            if (energy) {
                cli_put(w, burst_time(a, k / PLANES), (k % PLANES + 1.0) / (PLANES + 1));
            }
            end_row(c, energy ? a->mean + ((int64_t)l * BURST_ROWS + k) * BURST_VALUES : means_at(a, l), w);
        }
}

static void print_coherent(const arguments *a, cli_writer *w) {
    sp_free_path *path = sp_alloc((size_t)a->n, sizeof *path);
    double omega, error;
    if (!path)
        w->status = sp_fail_memory(w->err, (size_t)a->n * sizeof *path);
    if (w->status != SP_OK)
        return;
    for (int32_t l = 0; l < a->n; l++) {
        const mean *m = means_at(a, l);
        path[l] = sp_free_path_of(value_of(&m[0]), error_of(&m[0]), value_of(&m[1]), error_of(&m[1]));
    }
    if (sp_ioffe_regel(a->n, a->omega, path, &omega, &error)) {
        cli_value(w, "ioffe_regel", omega);
        cli_value(w, "ioffe_regel_err", error);
    }
    cli_columns(w, SP_COLUMN_NUMBER, "omega", RATE, "k", "1/d", "k_err", "1/d", "alpha", "1/d", "alpha_err", "1/d",
                "path", "d", "path_err", "d", "path_low", "d", "k_path", "", "k_path_err", "", "part", "", NULL);
    cli_columns(w, SP_COLUMN_INTEGER, "samples", "", NULL);
    for (int32_t l = 0; l < a->n && w->status == SP_OK; l++) {
        const mean *m = means_at(a, l);
        const sp_free_path *p = &path[l];
        cli_row(w, a->omega[l], value_of(&m[0]), error_of(&m[0]), value_of(&m[1]), error_of(&m[1]), p->path,
                p->path_err, p->low, p->k_path, p->k_path_err, value_of(&m[2]), m->n);
    }
    sp_free(path);
}

static sp_status add_rows(void *user, cli_writer *w) {
    arguments *a = user;
    cli_comment(w, "packings = %d", a->common.files);
    cli_comment(w, "dimension = %d", a->dim);
    cli_comment(w, "quantity = %s", quantity_names[a->common.kind]);
    if (a->common.kind == COHERENT)
        cli_comment(w, "motion = %s", a->section.shear ? "shear" : "compression");
    else if (a->common.kind <= KUBO)
        cli_comment(w, "axis = %s", a->common.kind == KUBO && a->axis == 0 ? "mean" : axis_names[a->axis]);
    for (int32_t k = 0; k < FREQUENCIES_MAX * VALUES_MAX; k++)
        a->mean[k].few = 2 * a->mean[k].n < a->common.files;
    (a->common.kind == COHERENT ? print_coherent : print_values)(a, w);
    return w->status;
}

/* ---- wave -------------------------------------------------------------------------------------------------------- */

static const cli_option wave_options[] = {
    {"at", "W1,W2,...|LOW:HIGH:N",
     "Frequencies (24, from four periods in the record to 0.3 of the upper bound of the spectrum)", CLI_TEXT,
     CLI_FIELD(at)},
    {"spacing", "D", "Distance between planes [d] (1)", CLI_NUMBER, CLI_FIELD(section.spacing), .low = 0.01,
     .high = 1e6},
    {"low", "Y", "Height of the lowest plane [d] (4)", CLI_NUMBER, CLI_FIELD(section.low), .high = 1e6},
    {"part", "F", "Place planes up to this fraction of the height (0.6)", CLI_NUMBER, CLI_FIELD(section.part),
     .low = 0.01, .high = 1},
    {"damping", CLI_DAMPING, "Dashpots of the contacts, as in signal (0)", CLI_DASHPOTS, CLI_FIELD(damping),
     .high = 100},
    {"source", "impulse|velocity|displacement", "Kind of source at the bottom wall, as in signal (impulse)", CLI_CHOICE,
     CLI_FIELD(section.source), .words = cli_source_names},
    {0}};

const cli_syntax cmd_wave_syntax = {
    .usage = "FILE...",
    .help =
        "Phase speed and attenuation of the coherent wave that a pulse at the bottom wall sends up through packings.\v"
        "For each packing and each frequency, A e^(i k y - alpha y) is fitted by least squares to the momentum flux "
        "through horizontal planes, recorded until the echo from the top wall arrives. The table has the means over "
        "the packings and their standard errors (nan for a single packing). alpha: attenuation of the amplitude, "
        "which is due to scattering alone unless --damping is given. Q = k/(2 alpha) is the quality factor (nan where "
        "alpha is within three errors of 0). part: fraction of the squared flux that the wave accounts for; the rest "
        "is scattered waves. samples: number of packings for which the fit succeeded. k_shift and alpha_shift: change "
        "of the means when only the first half of the record is used, which is usually more than the effect of the "
        "end of the record. The packings should have the same material and pressure.",
    CLI_PACKINGS,
    .options = wave_options,
    .springs = true};

static sp_status choose_wave(arguments *a, const sp_network *net, const sp_coherent_section *s, sp_error *err) {
    enum { MANY = 24 };
    const double low = 4 * 2 * M_PI / s->until[0], high = 0.3 * sp_network_omega_bound(net);
    if (a->n > 0 || a->at)
        return choose_frequencies(a, net, err);
    if (!(low < high))
        return sp_fail(err, SP_EREFUSED, "the record is too short for the default frequencies: use --at");
    for (; a->n < MANY; a->n++)
        a->omega[a->n] = low * pow(high / low, a->n / (MANY - 1.0));
    return SP_OK;
}

static sp_status add_wave(void *user, cli_file *file, cli_writer *w) {
    arguments *a = user;
    sp_coherent_section s = sp_coherent_section_none();
    sp_coherent_wave c;
    a->section.damping = a->damping.value;
    a->section.damping_kind = a->damping.kind;
    a->section.damping_ratio = a->damping.ratio;
    sp_status status = check_dimension(a, file, w->err);
    CLI_THEN(status, sp_coherent_section_make(&file->network, &a->section, &s, w->err));
    CLI_THEN(status, choose_wave(a, &file->network, &s, w->err));
    for (int32_t l = 0; l < a->n && status == SP_OK; l++) {
        status = sp_coherent_fit(&s, a->omega[l], &c, w->err);
        const double value[] = {c.k, c.alpha, c.part, c.k_shift, c.alpha_shift};
        for (size_t k = 0; k < sizeof value / sizeof *value && status == SP_OK && !isnan(c.k); k++)
            add(&means_at(a, l)[k], value[k], NAN);
    }
    sp_coherent_section_free(&s);
    return status;
}

/* Notes why rows are nan. */
static void explain(const arguments *a) {
    int32_t none = 0;
    for (int32_t l = 0; l < a->n; l++)
        none += means_at(a, l)->n == 0;
    if (none > 0)
        cli_note(&a->common,
                 "k and alpha are nan at %d of %d frequencies: either fewer than four planes have a record as long as "
                 "a period, or the wave spans too few planes, or the frequency is above the largest of the network",
                 none, a->n);
}

static sp_status wave_rows(void *user, cli_writer *w) {
    const arguments *a = user;
    explain(a);
    cli_comment(w, "packings = %d", a->common.files);
    cli_comment(w, "dimension = %d", a->dim);
    cli_comment(w, "source = %s", cli_source_names[a->section.source]);
    if (a->damping.value > 0)
        cli_damping_comment(w, &a->damping);
    cli_columns(w, SP_COLUMN_NUMBER, "omega", RATE, "k", "1/d", "k_err", "1/d", "speed", SPEED, "speed_err", SPEED,
                "alpha", "1/d", "alpha_err", "1/d", "part", "", NULL);
    cli_columns(w, SP_COLUMN_INTEGER, "samples", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "k_shift", "1/d", "alpha_shift", "1/d", "Q", "", "Q_err", "", NULL);
    for (int32_t l = 0; l < a->n; l++) {
        const mean *m = means_at(a, l);
        const double k = value_of(&m[0]), k_err = error_of(&m[0]), speed = a->omega[l] / k, alpha = value_of(&m[1]),
                     alpha_err = error_of(&m[1]);
        double q, q_err;
        sp_wave_quality(k, k_err, alpha, alpha_err, &q, &q_err);
        cli_row(w, a->omega[l], k, k_err, speed, speed * k_err / k, alpha, alpha_err, value_of(&m[2]), m->n,
                value_of(&m[3]), value_of(&m[4]), q, q_err);
    }
    return w->status;
}

/* ---- both commands ----------------------------------------------------------------------------------------------- */

static int run(const cli_syntax *syntax_of, const cli_files *command, int argc, char **argv) {
    arguments a = {.smear = 0.1,
                   .spread = sp_spread_options_default(),
                   .section = sp_coherent_section_options_default(),
                   .damping = {.ratio = 1}};
    cli_parse(syntax_of, argc, argv, &a);
    const int status = cli_run_files(command, &a);
    sp_free(a.omega);
    sp_free(a.mean);
    return status;
}

int cmd_transport(int argc, char **argv) {
    static const cli_files command = {CLI_OF_NETWORK, .stop = true, .begin = begin, .add = add_packing,
                                      .end = add_rows};
    return run(&cmd_transport_syntax, &command, argc, argv);
}

int cmd_wave(int argc, char **argv) {
    static const cli_files command = {CLI_OF_NETWORK, .stop = true, .begin = begin, .add = add_wave, .end = wave_rows};
    return run(&cmd_wave_syntax, &command, argc, argv);
}
