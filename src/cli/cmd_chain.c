/* sonopack chain: prints fronts, signals and modes of a chain of equal balls, in closed form. */
#include "base/base.h"
#include "cli/files.h"
#include "packing/contact.h"

#include <math.h>
#include <sonopack/amplitude.h>
#include <sonopack/transport.h>
#include <stdio.h>
#include <string.h>

enum { LENGTHS_MAX = 1000, GRAINS_MAX = 100000000, MODES_MAX = 1000000, RANDOM_MAX = 10000000 };

/* Values of Bessel functions take 0.5 ns for each order. Computations of more than about ten minutes are refused. */
static const double work_max = 1e12;

typedef struct arguments {
    cli_common common;
    const char *grains, *peaks;
    int initial;                  /* sp_chain_source */
    double from, until, pressure; /* NAN: not given */
    double wall;
    int64_t points, seed;
    double disorder;
    const char *at;
} arguments;

/* The units of the table, in those of chain.h. */
typedef struct units {
    double time, force;
    const char *time_name, *force_name;
} units;

enum { KIND_FRONT, KIND_SIGNAL, KIND_MODES, KIND_SOLITON, KIND_LOCALISATION };
static const char *const kinds[] = {"front", "signal", "modes", "soliton", "localisation", NULL};
static const char *const initial_names[] = {[SP_CHAIN_VELOCITY] = "A", [SP_CHAIN_DISPLACEMENT] = "B", NULL};

static sp_status check(void *user, sp_error *err) {
    const arguments *a = user;
    if (a->common.sets > 0)
        return sp_fail(err, SP_EINVAL, "--set %.60s: this command uses no scene", a->common.set[0]);
    const bool lengths = a->common.kind == KIND_SIGNAL || a->common.kind == KIND_MODES;
    if (!a->grains && lengths)
        return sp_fail(err, SP_EINVAL, "no --grains: must be the number of balls");
    if (a->common.units == CLI_UNITS_SI && isnan(a->pressure))
        return sp_fail(err, SP_EINVAL, "--units si: only front and signal with --pressure have units of a material");
    if (a->common.units == CLI_UNITS_SI && !(a->common.material.young > 0))
        return sp_fail(err, SP_EINVAL, "--units si: no material: must be --material E=70e9,nu=0.22,rho=2500,d=1e-3");
    return SP_OK;
}

static const cli_option options[] = {
    {"grains", "N|N1,N2,...|FROM:TO:FACTOR",
     "Number of balls; front: several lengths, or a range with a constant factor (10:1000000:2)", CLI_TEXT,
     CLI_FIELD(grains), .kinds = "front signal modes localisation"},
    {"peaks", "P1,P2,...",
     "soliton: largest additional overlap over that at rest, or inf for a chain that bears no force at rest "
     "(0.001,0.01,0.1,1,10,100,1000,inf)",
     CLI_TEXT, CLI_FIELD(peaks), .kinds = "soliton"},
    {"initial", "A|B", "Initial condition: the first ball has a velocity (A) or is displaced (B) (A)", CLI_CHOICE,
     CLI_FIELD(initial), .words = initial_names, .kinds = "front signal modes"},
    {"start", "T", "signal: first time (0).", CLI_NUMBER, CLI_FIELD(from), .high = 1e12, .kinds = "signal"},
    {"until", "T", "signal: last time (twice the travel time from wall to wall)", CLI_NUMBER, CLI_FIELD(until),
     .low = 1e-9, .high = 1e12, .kinds = "signal"},
    {"points", "N", "signal: number of equally spaced times (1001)", CLI_INTEGER, CLI_FIELD(points), .low = 2,
     .high = 10000000, .kinds = "signal"},
    {"pressure", "P",
     "front, signal: use d/sqrt(E* / rho) and E* d^2 as units, for Hertzian balls under the pressure P [E*]",
     CLI_NUMBER, CLI_FIELD(pressure), .low = 1e-12, .high = 1e-2, .kinds = "front signal", .unit = "E*"},
    {"wall", "RATIO", "signal: stiffness of the contacts with the walls, relative to the others (1)", CLI_NUMBER,
     CLI_FIELD(wall), .low = 1e-6, .high = 1.999, .kinds = "signal"},
    {"disorder", "S", "localisation: standard deviation of the masses over their mean, 0 to 0.577 (0.3)", CLI_NUMBER,
     CLI_FIELD(disorder), .high = 0.577, .kinds = "localisation"},
    {"at", "W1,W2,...|LOW:HIGH:N", "localisation: frequencies [c/l] (0.1:1.9:19)", CLI_TEXT, CLI_FIELD(at),
     .kinds = "localisation"},
    {"seed", "N", "localisation: seed of the masses (1)", CLI_INTEGER, CLI_FIELD(seed), .high = 1e15,
     .kinds = "localisation"},
    {0}};

const cli_syntax cmd_chain_syntax = {
    .usage = "KIND",
    .help =
        "The chain of N equal balls between two walls in closed form (Somfai et al. 2005, Section V A and Appendix "
        "C). KIND is one of:\n"
        "  front   the first front, and its local exponents against length\n"
        "  signal  force on the wall, and the front of an infinitely long chain\n"
        "  modes   frequencies and amplitudes\n"
        "  soliton speed and width of solitary waves of any strength\n"
        "  localisation  decay of waves where the masses are random, as in exp(-gamma j)\v"
        "Lengths are in units of the distance l between two balls, times in l/c, forces in K l, where c is the speed "
        "of long waves and K the stiffness of a contact. The first ball has the speed c (A), or is displaced by l "
        "(B). With --pressure the units are those of packings, and the signal is that of `sonopack signal' for "
        "packing.kind = chain, from an impulse (A) or a displacement (B).\n"
        "\n"
        "A solitary wave of Hertzian balls keeps its form without walls. Its peak is its largest additional overlap "
        "over the overlap delta0 at rest, force its largest force over that at rest, speed is in c, velocity the "
        "largest of a ball in c delta0/l, width the balls between the places of half the peak. kdv and kdv_width are "
        "those of long and weak waves (Korteweg and de Vries), nesterenko is the speed of long waves of any strength. "
        "speed_at_peak and velocity_at_peak are the same in units of a chain that rests with the overlap of the peak; "
        "with the peak inf only these are finite.\n"
        "\n"
        "localisation: gamma with its standard error from 32 parts of the chain (of 10^6 balls without --grains), at "
        "least 1/N, length = 1/gamma, and law = omega^2 <dm^2>/(8 K <m>), which holds for low frequencies (Matsuda "
        "and Ishii 1970). If gamma is not above twice its error, length is nan and length_low is a lower bound.",
    .options = options,
    .kinds = kinds,
    .kind_name = "kind of table",
    .check = check};

/* ---- lengths ----------------------------------------------------------------------------------------------------- */

/* Numbers of balls: N1,N2,... or FROM:TO:FACTOR. */
static sp_status read_lengths(const char *text, int32_t *count, double *length, sp_error *err) {
    char list[64];
    double range[3] = {0};
    int32_t n = 0;
    if (!strchr(text, ':'))
        return cli_numbers("--grains", text, 1, GRAINS_MAX, LENGTHS_MAX, count, length, err);
    snprintf(list, sizeof list, "%s", text);
    for (char *colon = list; (colon = strchr(colon, ':')) != NULL;)
        *colon = ',';
    const sp_status status = cli_numbers("--grains", list, 1, 1e9, 3, &n, range, err);
    if (status != SP_OK)
        return status;
    if (n != 3 || range[1] < range[0] || range[1] > GRAINS_MAX || range[2] < 1.001)
        return sp_fail(err, SP_EINVAL,
                       "--grains %.60s: must be FROM:TO:FACTOR with FROM <= TO <= %d and a FACTOR of 1.001 or more",
                       text, GRAINS_MAX);
    for (double each = range[0], last = 0; *count < LENGTHS_MAX && round(each) <= range[1]; each *= range[2]) {
        if (round(each) > last)
            length[(*count)++] = round(each);
        last = round(each);
    }
    return SP_OK;
}

/* A number of balls must be whole. */
static sp_status check_lengths(int32_t count, const double *length, sp_error *err) {
    for (int32_t k = 0; k < count; k++)
        if (length[k] != floor(length[k]))
            return sp_fail(err, SP_EINVAL, "--grains %g: must be an integer 1 .. %d", length[k], GRAINS_MAX);
    return SP_OK;
}

static sp_status refuse_work(double work, sp_error *err) {
    if (work <= work_max)
        return SP_OK;
    return sp_fail(err, SP_EINVAL, "chain: this would take about %.0f minutes: use fewer points or a shorter chain",
                   ceil(work / work_max * 10));
}

/* ---- tables ------------------------------------------------------------------------------------------------------ */

static void limit_comments(cli_writer *w, const sp_chain_limit *limit, const units *u) {
    cli_comment(w,
                "exponents are local, between N and 2 N; limits of them, of amplitude N^gamma and of widths/N^alpha:");
    cli_value(w, "gamma_limit", limit->gamma);
    cli_value(w, "alpha_limit", limit->alpha);
    cli_value(w, "height_limit", limit->height * u->force);
    cli_value(w, "width_limit", limit->width * u->time);
    cli_value(w, "width_peak_limit", limit->width_peak * u->time);
}

static sp_status front_row(const arguments *a, const units *u, int64_t grains, sp_table *t, sp_error *err) {
    sp_front one, two;
    sp_status status = sp_chain_front(grains, (sp_chain_source)a->initial, &one, err);
    CLI_THEN(status, sp_chain_front(2 * grains, (sp_chain_source)a->initial, &two, err));
    if (status != SP_OK)
        return status;
    const double width_peak = one.t_zero - one.t_peak;
    return sp_table_add_row(t, err, grains, one.t10 * u->time, one.t_peak * u->time, one.t_zero * u->time,
                            one.amplitude * u->force, one.width * u->time, width_peak * u->time,
                            -log2(two.amplitude / one.amplitude), log2(two.width / one.width),
                            log2((two.t_zero - two.t_peak) / width_peak));
}

static sp_status front_table(const arguments *a, const units *u, cli_writer *w) {
    const sp_chain_limit limit = sp_chain_limit_of((sp_chain_source)a->initial);
    double length[LENGTHS_MAX], work = 0;
    int32_t count = 0;
    CLI_THEN(w->status, read_lengths(a->grains ? a->grains : "10:1000000:2", &count, length, w->err));
    CLI_THEN(w->status, check_lengths(count, length, w->err));
    for (int k = 0; k < count && w->status == SP_OK; k++)
        work += 3 * 48.0 * length[k];
    CLI_THEN(w->status, refuse_work(work, w->err));
    cli_comment(w, "errors: 1e-11 of a time; amplitude and widths 1e-14 (1 + N^(2/3)) in units of K l and l/c");
    limit_comments(w, &limit, u);
    cli_columns(w, SP_COLUMN_INTEGER, "grains", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "t10", u->time_name, "t_peak", u->time_name, "t_zero", u->time_name, "amplitude",
                u->force_name, "width", u->time_name, "width_peak", u->time_name, "gamma", "", "alpha", "",
                "alpha_peak", "", NULL);
    for (int k = 0; k < count && w->status == SP_OK; k++)
        CLI_THEN(w->status, front_row(a, u, (int64_t)length[k], w->table, w->err));
    return w->status;
}

static sp_status one_length(const arguments *a, int64_t most, int64_t *grains, cli_writer *w) {
    CLI_THEN(w->status, cli_integer("--grains", a->grains, 1, most, grains, w->err));
    cli_comment(w, "grains = %lld", (long long)*grains);
    return w->status;
}

static sp_status signal_rows(const arguments *a, const units *u, const sp_chain *chain, double from, double until,
                             cli_writer *w) {
    const size_t n = (size_t)a->points;
    double *time = sp_alloc(3 * n, sizeof *time);
    if (!time)
        return sp_fail_memory(w->err, 3 * n * sizeof *time);
    double *f = time + n, *airy = f + n;
    for (size_t l = 0; l < n; l++)
        time[l] = from + (until - from) * ((double)l / (double)(n - 1));
    CLI_THEN(w->status, sp_chain_walls_signal(chain, a->points, time, f, w->err));
    CLI_THEN(w->status, sp_chain_airy(chain->grains, chain->source, a->points, time, airy, w->err));
    for (size_t l = 0; l < n && w->status == SP_OK; l++)
        cli_row(w, time[l] * u->time, f[l] * u->force, airy[l] * u->force);
    sp_free(time);
    return w->status;
}

static sp_status signal_table(const arguments *a, const units *u, cli_writer *w) {
    sp_chain chain = {.source = (sp_chain_source)a->initial, .wall = a->wall};
    if (one_length(a, GRAINS_MAX, &chain.grains, w) != SP_OK)
        return w->status;
    const double from = isnan(a->from) ? 0 : a->from / u->time,
                 until = isnan(a->until) ? 2 * ((double)chain.grains + 1) : a->until / u->time;
    if (!(until > from))
        return sp_fail(w->err, SP_EINVAL, "--start %g: must be below --until, %g", from * u->time, until * u->time);
    CLI_THEN(w->status, refuse_work((double)a->points * 0.5 * (from + until), w->err));
    cli_value(w, "wall", a->wall);
    /* the last time has the largest; the rest is rounding of the units */
    cli_value(w, "error", (sp_chain_signal_error(&chain, until) + 1e-15) * u->force);
    cli_comment(w, "airy: of an infinitely long chain, twice (16) of Somfai et al. 2005%s",
                chain.source == SP_CHAIN_VELOCITY ? "" : ", differentiated");
    cli_columns(w, SP_COLUMN_NUMBER, "t", u->time_name, "F", u->force_name, "airy", u->force_name, NULL);
    return w->status == SP_OK ? signal_rows(a, u, &chain, from, until, w) : w->status;
}

static sp_status modes_table(const arguments *a, cli_writer *w) {
    const sp_chain_source source = (sp_chain_source)a->initial;
    int64_t grains = 0;
    if (one_length(a, MODES_MAX, &grains, w) != SP_OK)
        return w->status;
    cli_value(w, "relative_error", 1e-15);
    cli_comment(w, "F(t) = sum of a b %s(omega t)", source == SP_CHAIN_VELOCITY ? "sin" : "cos");
    cli_columns(w, SP_COLUMN_INTEGER, "n", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "omega", "c/l", "a", "l", "b", "K", NULL);
    for (int64_t n = 1; n <= grains && w->status == SP_OK; n++) {
        const double b = 0.5 * ((double)grains + 1) * sp_chain_amplitude(grains, n, SP_CHAIN_DISPLACEMENT);
        cli_row(w, n, sp_chain_omega(grains, n), sp_chain_amplitude(grains, n, source), n % 2 ? b : -b);
    }
    return w->status;
}

static void soliton_row(double peak, cli_writer *w) {
    sp_solitary s;
    CLI_THEN(w->status, sp_solitary_make(peak, &s, w->err));
    cli_row(w, s.peak, s.force, s.speed, s.kdv, s.nesterenko, s.velocity, s.width, s.kdv_width, s.speed_at_peak,
            s.nesterenko_at_peak, s.velocity_at_peak, s.error);
}

static sp_status soliton_table(const arguments *a, cli_writer *w) {
    const char *text = a->peaks ? a->peaks : "0.001,0.01,0.1,1,10,100,1000,inf";
    double peak[LENGTHS_MAX];
    int32_t n = 0;
    CLI_THEN(w->status, cli_numbers("--peaks", text, 1e-4, INFINITY, LENGTHS_MAX, &n, peak, w->err));
    cli_comment(w, "relative_error: of speed, velocity and width, an estimate");
    cli_columns(w, SP_COLUMN_NUMBER, "peak", "", "force", "", "speed", "c", "kdv", "c", "nesterenko", "c", "velocity",
                "c delta0/l", "width", "l", "kdv_width", "l", "speed_at_peak", "", "nesterenko_at_peak", "",
                "velocity_at_peak", "", "relative_error", "", NULL);
    for (int32_t k = 0; k < n && w->status == SP_OK; k++)
        soliton_row(peak[k], w);
    return w->status;
}

/* The units of a chain that packing.kind = chain makes. `impulse' gives its first ball the impulse K, and
 * `displacement' displaces it by K. */
static units units_of(double pressure, sp_chain_source source) {
    if (isnan(pressure))
        return (units){1, 1, "l/c", "K l"};
    const double e = contact_stiffness(0.5, 0.5);
    const double k = contact_normal_stiffness(e, contact_overlap(e, pressure)), rate = sqrt(k / grain_mass(0.5));
    return (units){1 / rate, k * (source == SP_CHAIN_VELOCITY ? rate : k), "d/sqrt(E* / rho)", "E* d^2"};
}

static void localisation_rows(const arguments *a, int64_t grains, int32_t n, const double *omega, const double *mass,
                              const double *spring, cli_writer *w) {
    for (int32_t l = 0; l < n && w->status == SP_OK; l++) {
        sp_localisation r;
        w->status = sp_localisation_chain(grains, mass, spring, omega[l], &r, w->err);
        const bool seen = w->status == SP_OK && r.gamma > 2 * r.gamma_err;
        const double length = seen ? 1 / r.gamma : NAN;
        cli_row(w, omega[l], r.gamma, r.gamma_err, length, length * length * r.gamma_err,
                1 / (fmax(0, r.gamma) + 2 * r.gamma_err),
                sp_localisation_law(omega[l], 1, a->disorder * a->disorder, 1));
    }
}

static sp_status localisation_table(const arguments *a, cli_writer *w) {
    double omega[LENGTHS_MAX];
    int32_t n = 0;
    int64_t grains = 1000000;
    if (a->grains)
        CLI_THEN(w->status, cli_integer("--grains", a->grains, 1000, RANDOM_MAX, &grains, w->err));
    CLI_THEN(w->status, cli_frequencies(a->at ? a->at : "0.1:1.9:19", LENGTHS_MAX, &n, omega, w->err));
    if (w->status != SP_OK)
        return w->status;
    double *mass = sp_alloc(2 * (size_t)grains + 1, sizeof *mass);
    if (!mass)
        return sp_fail_memory(w->err, (2 * (size_t)grains + 1) * sizeof *mass);
    double *spring = mass + grains;
    CLI_THEN(w->status, sp_localisation_masses(grains, a->disorder, (uint64_t)a->seed, mass, w->err));
    for (int64_t j = 0; j <= grains; j++)
        spring[j] = 1;
    cli_comment(w, "grains = %lld", (long long)grains);
    cli_value(w, "disorder", a->disorder);
    cli_columns(w, SP_COLUMN_NUMBER, "omega", "c/l", "gamma", "1/l", "gamma_err", "1/l", "length", "l", "length_err",
                "l", "length_low", "l", "law", "1/l", NULL);
    localisation_rows(a, grains, n, omega, mass, spring, w);
    sp_free(mass);
    return w->status;
}

static sp_status work(void *user, cli_writer *w) {
    const arguments *a = user;
    const units u = units_of(a->pressure, (sp_chain_source)a->initial);
    if (a->common.kind == KIND_LOCALISATION)
        cli_comment(w, "chain of equal springs K and random masses of mean m");
    else if (a->common.kind == KIND_SOLITON)
        cli_comment(w, "chain of equal balls, solitary waves");
    else
        cli_comment(w, "chain of equal balls, initial condition %s",
                    a->initial == SP_CHAIN_VELOCITY ? "A: velocity" : "B: displacement");
    if (!isnan(a->pressure))
        cli_value(w, "pressure", a->pressure);
    switch (a->common.kind) {
    case KIND_FRONT: return front_table(a, &u, w);
    case KIND_SIGNAL: return signal_table(a, &u, w);
    case KIND_SOLITON: return soliton_table(a, w);
    case KIND_LOCALISATION: return localisation_table(a, w);
    default: return modes_table(a, w);
    }
}

int cmd_chain(int argc, char **argv) {
    arguments a = {.initial = SP_CHAIN_VELOCITY,
                   .from = NAN,
                   .until = NAN,
                   .pressure = NAN,
                   .wall = 1,
                   .points = 1001,
                   .disorder = 0.3,
                   .seed = 1};
    cli_parse(&cmd_chain_syntax, argc, argv, &a);
    return cli_run_table(&a, work);
}
