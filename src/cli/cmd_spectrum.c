/* sonopack spectrum: prints spectra of a packing, its response to driving, and the dispersion of its waves. */
#include "base/base.h"
#include "cli/excitation.h"
#include "cli/files.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Options of one kind stand where its computation wants them; 0, or -1 where that is a value: not given. */
typedef struct arguments {
    cli_common common;
    sp_dos_options dos;
    sp_harmonic_options harmonic;
    sp_dispersion_options dispersion;
    sp_damping damping;
    int direction, source, solver; /* sp_source, sp_modes_solver */
    int32_t bins, layers, lowest;
    double until, resolution, node;
    const char *at; /* frequencies; NULL: not given */
    bool lines, profile;
} arguments;

enum { FREQUENCIES_MAX = 100000, FREQUENCIES = 20 }; /* of --at; the latter by default */

#define RATE     "sqrt(E* / rho)/d"
#define TIME     "d/sqrt(E* / rho)"
#define RESPONSE "E* d^3/sqrt(E* / rho)"

static const char *const dos_methods[] = {"auto", "exact", "kpm", "count", NULL};
static const char *const dos_norms[] = {"grain", "one", "modes", NULL};

static void dos_columns(sp_dos_norm norm, cli_writer *w) {
    static const char *const numbers[] = {"modes/grain", "", "modes"};
    const char *unit = norm == SP_DOS_MODES ? "modes d/sqrt(E* / rho)" : TIME, *number = numbers[norm];
    cli_columns(w, SP_COLUMN_NUMBER, "omega", RATE, "low", RATE, "high", RATE, "density", unit, "density_err", unit,
                "cumulative", number, "cumulative_err", number, "smooth", unit, "smooth_err", unit, NULL);
}

static sp_status dos(const arguments *a, cli_file *file, cli_writer *w) {
    const sp_network *net = &file->network;
    sp_dos_options o = a->dos;
    sp_dos d = sp_dos_none();
    o.bins = a->bins > 0 ? a->bins : o.bins;
    o.until = a->until;
    o.resolution = a->resolution;
    o.threads = a->common.threads;
    w->status = sp_dos_make(net, &o, &d, w->err);
    if (w->status != SP_OK)
        return w->status;
    dos_columns(o.norm, w);
    cli_comment(w, "method = %s", dos_methods[d.method]);
    cli_comment(w, "norm = %s", dos_norms[o.norm]);
    cli_value(w, "modes", (double)d.modes);
    cli_zero_modes(w, &d.zero);
    if (d.zero.total < 0)
        cli_comment(w, "zero modes of the network are in the density, at omega = 0");
    cli_value(w, "resolution", d.resolution);
    cli_value(w, "omega_max", d.omega_max);
    if (d.vectors > 0)
        cli_value(w, "vectors", d.vectors);
    cli_value(w, "moments", (double)d.moments);
    for (int32_t b = 0; b < d.bins && w->status == SP_OK; b++)
        cli_row(w, 0.5 * (d.edge[b] + d.edge[b + 1]), d.edge[b], d.edge[b + 1], d.density[b], d.density_error[b],
                d.cumulative[b], d.cumulative_error[b], d.smooth[b], d.smooth_error[b]);
    sp_dos_free(&d);
    return w->status;
}

/* The table of --lines: every mode with its weight in the signal. */
static sp_status lines(const arguments *a, const sp_network *net, cli_writer *w) {
    const sp_modes_options o = {.vectors = true, .source = (sp_source)a->source, .solver = (sp_modes_solver)a->solver};
    const sp_modes_range range = sp_modes_range_all();
    sp_modes m = sp_modes_none();
    double all = 0, sum = 0;
    if (!sp_network_touches(net, SP_BOTTOM) || !sp_network_touches(net, SP_TOP))
        return sp_fail(w->err, SP_EREFUSED, "no carrying contact at the %s wall: no mode has a weight in a signal",
                       sp_network_touches(net, SP_BOTTOM) ? "top" : "bottom");
    w->status = sp_modes_make(net, &o, &range, &m, w->err);
    cli_columns(w, SP_COLUMN_INTEGER, "n", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "omega", RATE, "ab", "E* d^2", "share", "", NULL);
    cli_comment(w, "source = %s", cli_source_names[a->source]);
    cli_comment(w, "share: of the sum of |ab| over all modes, up to this one");
    for (int64_t k = 0; k < m.n && w->status == SP_OK; k++)
        all += fabs(m.a[k] * m.b[k]);
    for (int64_t k = m.n_rattler; k < m.n && w->status == SP_OK; k++) {
        sum += fabs(m.a[k] * m.b[k]);
        cli_row(w, k, m.omega[k], m.a[k] * m.b[k], all > 0 ? sum / all : 0.0);
    }
    sp_modes_free(&m);
    return w->status;
}

static sp_status transmission(const arguments *a, cli_file *file, cli_writer *w) {
    sp_transmission_options o = sp_transmission_options_default();
    sp_transmission s = sp_transmission_none();
    if (a->lines && (a->bins > 0 || a->until > 0 || a->resolution > 0))
        return sp_fail(w->err, SP_EINVAL, "--lines cannot be combined with --bins, --omega-max or --resolution");
    if (a->lines)
        return lines(a, &file->network, w);
    o.source = (sp_source)a->source;
    o.points = a->bins > 0 ? a->bins : o.points;
    o.until = a->until;
    o.resolution = a->resolution;
    w->status = sp_transmission_make(&file->network, &o, &s, w->err);
    cli_columns(w, SP_COLUMN_NUMBER, "omega", RATE, "density", RESPONSE, "magnitude", RESPONSE, "re", RESPONSE, "im",
                RESPONSE, "error", RESPONSE, NULL);
    cli_comment(w, "source = %s", cli_source_names[a->source]);
    cli_value(w, "resolution", s.resolution);
    cli_value(w, "omega_max", s.omega_max);
    cli_value(w, "moments", (double)s.moments);
    for (int32_t l = 0; l < s.n && w->status == SP_OK; l++)
        cli_row(w, s.omega[l], s.density[l], hypot(s.re[l], s.im[l]), s.re[l], s.im[l], s.error[l]);
    sp_transmission_free(&s);
    return w->status;
}

/* ---- dispersion -------------------------------------------------------------------------------------------------- */

static const char *const directions[] = {"x", "up", "y", NULL};
static const char *const polarizations[] = {"longitudinal", "transverse", "rotational"};

static void add_waves(const sp_dispersion *d, cli_writer *w) {
    cli_columns(w, SP_COLUMN_NUMBER, "k", "1/d", "rms", RATE, "spread", RATE, "peak", RATE, "half_width", RATE,
                "resolution", RATE, NULL);
    for (int32_t q = 0; q < d->n && w->status == SP_OK; q++) {
        const sp_dispersion_point *wave = &d->wave[q];
        cli_row(w, polarizations[wave->polarization], (int64_t)wave->n, wave->k, wave->rms, wave->spread, wave->peak,
                wave->half_width, wave->resolution);
    }
}

static void add_spectral(const sp_dispersion *d, cli_writer *w) {
    cli_columns(w, SP_COLUMN_NUMBER, "k", "1/d", "omega", RATE, "S", TIME, NULL);
    for (int32_t q = 0; q < d->n; q++)
        for (int32_t l = 0; l < d->profile && w->status == SP_OK; l++)
            cli_row(w, polarizations[d->wave[q].polarization], (int64_t)d->wave[q].n, d->wave[q].k, d->omega[l],
                    d->s[(int64_t)q * d->profile + l]);
}

static sp_status set_dispersion(const arguments *a, const cli_file *file, sp_dispersion_options *o, sp_error *err) {
    enum { UP = 1, ALONG_Y = 2 };
    *o = a->dispersion;
    o->up = a->direction >= 0 ? a->direction == UP : file->network.dim == 1;
    o->along_y = a->direction == ALONG_Y;
    const bool standing = file->packing.cell == SP_CELL_BOX || (o->up && file->packing.cell == SP_CELL_PISTON);
    if (!standing && a->node >= 0)
        return sp_fail(err, SP_EINVAL, "--node applies only to waves between walls%s",
                       file->packing.cell == SP_CELL_PISTON ? ", --direction up" : "");
    if (!a->profile && a->bins > 0)
        return sp_fail(err, SP_EINVAL, "--bins applies only to --profile");
    o->resolution = a->resolution;
    if (a->profile)
        o->profile = a->bins > 0 ? a->bins : 400;
    /* a wall that is like a fixed grain has that grain's centre behind it */
    o->node = a->node >= 0 ? a->node : standing && file->packing.wall == SP_WALL_GRAIN ? 0.5 : 0;
    return SP_OK;
}

static sp_status dispersion(const arguments *a, cli_file *file, cli_writer *w) {
    sp_dispersion_options o;
    sp_dispersion d = sp_dispersion_none();
    w->status = set_dispersion(a, file, &o, w->err);
    CLI_THEN(w->status, sp_dispersion_make(&file->network, &o, &d, w->err));
    if (w->status != SP_OK)
        return w->status;
    cli_columns(w, SP_COLUMN_TEXT, "polarization", "", NULL);
    cli_columns(w, SP_COLUMN_INTEGER, "n", "", NULL);
    cli_comment(w, "direction = %s", directions[o.along_y ? 2 : o.up]);
    if (o.up && file->packing.cell != SP_CELL_PERIODIC)
        cli_value(w, "node", o.node);
    cli_value(w, "omega_max", d.omega_max);
    cli_value(w, "moments", (double)d.moments);
    if (a->profile)
        add_spectral(&d, w);
    else
        add_waves(&d, w);
    sp_dispersion_free(&d);
    return w->status;
}

/* ---- participation ----------------------------------------------------------------------------------------------- */

static sp_status participation(const arguments *a, cli_file *file, cli_writer *w) {
    const sp_modes_options o = {.vectors = true, .solver = (sp_modes_solver)a->solver};
    const sp_modes_range all = sp_modes_range_all();
    const int32_t bins = a->bins > 0 ? a->bins : 40;
    sp_modes m = sp_modes_none();
    sp_participation_bin *bin = sp_alloc((size_t)bins, sizeof *bin);
    w->status =
        bin ? sp_modes_make(&file->network, &o, &all, &m, w->err) : sp_fail_memory(w->err, (size_t)bins * sizeof *bin);
    CLI_THEN(w->status, sp_participation(&m, bins, a->until, bin, w->err));
    cli_columns(w, SP_COLUMN_NUMBER, "omega", RATE, "low", RATE, "high", RATE, NULL);
    cli_columns(w, SP_COLUMN_INTEGER, "modes", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "participation", "", "sd", "", "min", "", "max", "", NULL);
    cli_zero_modes(w, &m.zero);
    cli_comment(w, "nan: no mode in the bin; sd: fewer than two");
    for (int32_t b = 0; b < bins && w->status == SP_OK; b++)
        cli_row(w, 0.5 * (bin[b].low + bin[b].high), bin[b].low, bin[b].high, bin[b].modes, bin[b].mean, bin[b].sd,
                bin[b].least, bin[b].largest);
    sp_modes_free(&m);
    sp_free(bin);
    return w->status;
}

static void add_responses(const sp_harmonic *h, cli_writer *w) {
    cli_columns(w, SP_COLUMN_NUMBER, "omega", RATE, "magnitude", RESPONSE, "re", RESPONSE, "im", RESPONSE, "error",
                RESPONSE, "k", "1/d", "k_err", "1/d", "speed", "sqrt(E* / rho)", "speed_err", "sqrt(E* / rho)", "alpha",
                "1/d", "alpha_err", "1/d", "misfit", "", "Q", "", "Q_err", "", NULL);
    for (int32_t l = 0; l < h->n && w->status == SP_OK; l++) {
        const sp_wave_fit *fit = &h->fit[l];
        const bool travels = fit->k > 3 * fit->k_err; /* else it only decays, and has no speed */
        const double *f = h->f + 2 * l, speed = travels ? h->omega[l] / fit->k : NAN;
        double q, q_err;
        sp_wave_quality(fit->k, fit->k_err, fit->alpha, fit->alpha_err, &q, &q_err);
        cli_row(w, h->omega[l], hypot(f[0], f[1]), f[0], f[1], h->error[l], fit->k, fit->k_err, speed,
                speed * fit->k_err / fit->k, fit->alpha, fit->alpha_err, fit->misfit, q, q_err);
    }
}

static void add_profile(const sp_harmonic *h, cli_writer *w) {
    cli_columns(w, SP_COLUMN_NUMBER, "omega", RATE, "height", "d", "magnitude", RESPONSE, "re", RESPONSE, "im",
                RESPONSE, "error", RESPONSE, NULL);
    for (int32_t l = 0; l < h->n; l++)
        for (int32_t k = 0; k < h->planes && w->status == SP_OK; k++) {
            const int64_t at = (int64_t)l * h->planes + k;
            const double *f = h->flux + 2 * at;
            cli_row(w, h->omega[l], h->height[k], hypot(f[0], f[1]), f[0], f[1], h->flux_error[at]);
        }
}

static sp_status set_harmonic(const arguments *a, const sp_network *net, double *omega, sp_harmonic_options *o,
                              sp_error *err) {
    *o = a->harmonic;
    o->keep = true;
    o->source = (sp_source)a->source;
    o->omega = omega;
    o->damping = a->damping.value;
    o->damping_kind = a->damping.kind;
    o->damping_ratio = a->damping.ratio;
    o->planes = a->layers > 0 ? a->layers - 1 : o->planes;
    if (a->at)
        return cli_frequencies(a->at, FREQUENCIES_MAX, &o->n, omega, err);
    for (o->n = 0; o->n < FREQUENCIES; o->n++)
        omega[o->n] = sp_network_omega_bound(net) * (o->n + 1) / FREQUENCIES;
    return SP_OK;
}

static bool lacks_a_fit(const sp_harmonic *h) {
    for (int32_t l = 0; l < h->n; l++)
        if (isnan(h->fit[l].k) && !isnan(h->error[l]))
            return true;
    return false;
}

/* The rows of refused frequencies have nan; the command then fails, but only after the others are written. */
static void report_refused(const sp_harmonic *h, cli_file *file, cli_writer *w) {
    sp_error why = {.status = SP_EREFUSED};
    if (h->refused == 0 || w->status != SP_OK)
        return;
    cli_comment(w, "refused = %d (their rows have nan: the first reason is %s)", h->refused, h->reason);
    snprintf(why.text, sizeof why.text, "%s: %d of %d frequencies are refused: %s", file->path, h->refused, h->n,
             h->reason);
    cli_fail(&why);
    file->failed = true;
}

static sp_status harmonic_rows(const arguments *a, cli_file *file, const sp_harmonic_options *o, cli_writer *w) {
    sp_harmonic h = sp_harmonic_none();
    w->status = sp_harmonic_make(&file->network, o, &h, w->err);
    report_refused(&h, file, w);
    cli_comment(w, "source = %s", cli_source_names[o->source]);
    cli_damping_comment(w, &a->damping);
    cli_value(w, "height", sp_packing_height(&file->packing));
    cli_value(w, "planes", h.planes);
    cli_value(w, "tolerance", o->tolerance);
    if (!a->profile && lacks_a_fit(&h))
        cli_comment(w, "nan: no wave could be fitted to the planes");
    if (a->profile)
        add_profile(&h, w);
    else
        add_responses(&h, w);
    sp_harmonic_free(&h);
    return w->status;
}

static sp_status harmonic(const arguments *a, cli_file *file, cli_writer *w) {
    sp_harmonic_options o;
    double *omega = sp_alloc(FREQUENCIES_MAX, sizeof *omega);
    sp_status status = omega ? SP_OK : sp_fail_memory(w->err, FREQUENCIES_MAX * sizeof *omega);
    CLI_THEN(status, set_harmonic(a, &file->network, omega, &o, w->err));
    CLI_THEN(status, harmonic_rows(a, file, &o, w));
    sp_free(omega);
    return status;
}

static void continuum_columns(cli_writer *w) {
    cli_columns(w, SP_COLUMN_INTEGER, "n", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "omega", RATE, NULL);
    cli_columns(w, SP_COLUMN_INTEGER, "n1", "", "n2", "", NULL);
    cli_columns(w, SP_COLUMN_TEXT, "branch", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "omega_plane", RATE, "omega_continuum", RATE, "ratio", "", "overlap", "", NULL);
}

static sp_status continuum(const arguments *a, cli_file *file, cli_writer *w) {
    const double threshold = 1e-4, margin = 3;
    sp_continuum c = sp_continuum_none();
    sp_statics s;
    w->status = sp_statics_make(&file->packing, threshold, margin, &s, w->err);
    double density;
    CLI_THEN(w->status, sp_packing_density(&file->packing, threshold, margin, &density, w->err));
    CLI_THEN(w->status, sp_continuum_make(&file->network, density, a->lowest, (sp_modes_solver)a->solver, &c, w->err));
    if (w->status != SP_OK)
        return w->status;
    cli_value(w, "Phi3s", s.phi3s);
    cli_value(w, "C11", c.moduli.c11);
    cli_value(w, "C12", c.moduli.c12);
    cli_value(w, "C22", c.moduli.c22);
    cli_value(w, "C33", c.moduli.c33);
    continuum_columns(w);
    for (int32_t k = 0; k < c.n && w->status == SP_OK; k++) {
        const sp_continuum_row *row = &c.row[k];
        const int64_t n1 = row->n1, n2 = row->n2;
        cli_row(w, row->n, row->omega, n1, n2, row->fast ? "+" : "-", row->omega_plane, row->omega_continuum,
                row->omega / row->omega_continuum, row->overlap);
    }
    sp_continuum_free(&c);
    return w->status;
}

static const char *const kinds[] = {"dos",           "transmission", "dispersion", "harmonic",
                                    "participation", "continuum",    NULL};
/* Each adds the columns, comments and rows of one kind. */
static sp_status (*const tables[])(const arguments *a, cli_file *file,
                                   cli_writer *w) = {dos, transmission, dispersion, harmonic, participation, continuum};

static const cli_option options[] = {
    {"method", "auto|exact|kpm|count",
     "dos: all frequencies (exact), kernel polynomials (kpm), or the number of modes in each bin (count) (auto: exact "
     "up to 3000 degrees of freedom, else kpm)",
     CLI_CHOICE, CLI_FIELD(dos.method), .words = dos_methods, .kinds = "dos"},
    {"norm", "grain|one|modes", "dos: modes per grain (without rattlers), unit integral, or numbers of modes (grain)",
     CLI_CHOICE, CLI_FIELD(dos.norm), .words = dos_norms, .kinds = "dos"},
    {"bins", "N", "Number of equally spaced frequencies (100)", CLI_INT, CLI_FIELD(bins), .low = 1, .high = 1000000,
     .kinds = "dos transmission dispersion participation"},
    {"omega-max", "OMEGA", "Last frequency (the upper bound of the spectrum).", CLI_NUMBER, CLI_FIELD(until),
     .low = 1e-9, .high = 1e9, .kinds = "dos transmission participation"},
    {"resolution", "WIDTH", "Standard deviation of the kernel at omega = 0 (one bin)", CLI_NUMBER,
     CLI_FIELD(resolution), .low = 1e-12, .high = 1e9, .kinds = "dos transmission dispersion"},
    {"vectors", "N", "dos, kpm: number of random vectors, even (4 to 64, fewer for larger packings)", CLI_INT,
     CLI_FIELD(dos.vectors), .low = 2, .high = 10000, .kinds = "dos"},
    {"seed", "S", "dos, kpm: seed of the random vectors (1)", CLI_INTEGER, CLI_FIELD(dos.seed), .high = 9.3e18,
     .kinds = "dos"},
    {"source", "impulse|velocity|displacement", "transmission, harmonic: kind of source, as in signal (impulse)",
     CLI_CHOICE, CLI_FIELD(source), .words = cli_source_names, .kinds = "transmission harmonic"},
    {"lines", NULL, "transmission: print the weight of every mode instead (computes all modes)", CLI_FLAG,
     CLI_FIELD(lines), .kinds = "transmission"},
    {"direction", "x|up|y",
     "dispersion: plane waves along x, or standing waves between the walls (x; chains: up); y in three dimensions. "
     "Waves are plane where the cell is periodic, and stand where it has walls",
     CLI_CHOICE, CLI_FIELD(direction), .words = directions, .kinds = "dispersion"},
    {"waves", "N", "dispersion: the N longest waves (8)", CLI_INT, CLI_FIELD(dispersion.waves), .low = 1,
     .high = 100000, .kinds = "dispersion"},
    {"node", "D", "dispersion up: distance of the nodes behind the walls [d] (0; chains: 0.5)", CLI_NUMBER,
     CLI_FIELD(node), .high = 1e6, .kinds = "dispersion"},
    {"profile", NULL, "dispersion: print the spectral functions S(k, omega); harmonic: print the force against height",
     CLI_FLAG, CLI_FIELD(profile), .kinds = "dispersion harmonic"},
    {"at", "W1,W2,...|LOW:HIGH:N", "harmonic: frequencies (20 up to the upper bound of the spectrum)", CLI_TEXT,
     CLI_FIELD(at), .kinds = "harmonic"},
    {"damping", CLI_DAMPING, "harmonic: dashpots of the contacts, as in signal (0)", CLI_DASHPOTS, CLI_FIELD(damping),
     .high = 1e6, .kinds = "harmonic"},
    {"layers", "N", "harmonic: number of equal layers, with planes between them (one per diameter)", CLI_INT,
     CLI_FIELD(layers), .low = 2, .high = 100000, .kinds = "harmonic"},
    {"range", "LOW:HIGH", "harmonic: fit the wave between these heights [d] (up to 2 d from the walls)", CLI_PAIR,
     CLI_FIELD(harmonic.range), .high = 1e9, .kinds = "harmonic"},
    {"tolerance", "EPS", "harmonic: largest error, relative to |F| (1e-8)", CLI_NUMBER, CLI_FIELD(harmonic.tolerance),
     .low = 1e-15, .high = 0.1, .kinds = "harmonic"},
    {"lowest", "K", "continuum: the K lowest modes (12)", CLI_INT, CLI_FIELD(lowest), .low = 1, .high = 100000,
     .kinds = "continuum"},
    {"solver", CLI_SOLVERS, "continuum, participation, transmission --lines: solver of the modes, as in modes (auto)",
     CLI_CHOICE, CLI_FIELD(solver), .words = cli_solver_names, .kinds = "continuum participation transmission"},
    CLI_DRY_RUN,
    {0}};

const cli_syntax cmd_spectrum_syntax = {
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
    CLI_ONE_PACKING,
    .options = options,
    .kinds = kinds,
    .kind_name = "kind of spectrum",
    .springs = true};

static sp_status add_rows(void *user, cli_file *file, cli_writer *w) {
    const arguments *a = user;
    cli_comment(w, "spectrum = %s", kinds[a->common.kind]);
    cli_comment(w, "file = %s", file->path);
    cli_value(w, "pressure", file->packing.pressure);
    return w->status == SP_OK ? tables[a->common.kind](a, file, w) : w->status;
}

/* ---- --dry-run --------------------------------------------------------------------------------------------------- */

enum { DOS = 0, TRANSMISSION, DISPERSION, HARMONIC, PARTICIPATION, CONTINUUM }; /* as in kinds */

static double count_frequencies(const arguments *a) {
    int32_t n = FREQUENCIES;
    double *omega = sp_alloc(FREQUENCIES_MAX, sizeof *omega);
    if (omega && a->at)
        cli_frequencies(a->at, FREQUENCIES_MAX, &n, omega, NULL);
    sp_free(omega);
    return n;
}

static bool needs_modes(const arguments *a, const sp_network_size *net) {
    enum { DENSE_MOST = 3000 };
    switch (a->common.kind) {
    case DOS: return a->dos.method == SP_DOS_EXACT || (a->dos.method == SP_DOS_AUTO && net->dofs <= DENSE_MOST);
    case TRANSMISSION: return a->lines;
    default: return a->common.kind == PARTICIPATION;
    }
}

static sp_cost kind_cost(const arguments *a, const sp_network_size *net, double rows, const sp_machine *machine) {
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
    const arguments *a = user;
    const sp_network_size net = sp_network_size_of(&file->network, sp_packing_height(&file->packing));
    const double rows = a->common.kind == HARMONIC ? count_frequencies(a) : a->bins > 0 ? a->bins : 100;
    (void)err;
    cli_plan_add(p, "network", 1, sp_cost_result(SP_RESULT_NETWORK, &net, 1, &p->machine), 0);
    cli_plan_add(p, kinds[a->common.kind], 1, kind_cost(a, &net, rows, &p->machine),
                 a->common.output ? sp_bytes_table(rows, 6) : 0);
    return SP_OK;
}

int cmd_spectrum(int argc, char **argv) {
    static const cli_files command = {CLI_OF_NETWORK, .stop = true, .add = add_rows, .plan = plan,
                                      .kernels =
                                          1U << SP_KERNEL_PRODUCT | 1U << SP_KERNEL_DENSE | 1U << SP_KERNEL_SPARSE};
    arguments a = {.dos = sp_dos_options_default(),
                   .harmonic = sp_harmonic_options_default(),
                   .dispersion = sp_dispersion_options_default(),
                   .damping = {.ratio = 1},
                   .direction = -1,
                   .lowest = 12,
                   .node = -1};
    cli_parse(&cmd_spectrum_syntax, argc, argv, &a);
    return cli_run_files(&command, &a);
}
