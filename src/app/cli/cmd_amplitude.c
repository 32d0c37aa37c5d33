/* sonopack amplitude: prints how the front of a pulse changes as it grows loud. */
#include "base/base.h"
#include "cli/amplitude.h"

#include <string.h>

enum { CYCLES = 6 };

typedef struct arguments {
    cli_common common;
    sp_amplitude_options o;
    double omega; /* 0: pulses */
    int64_t cycles;
    bool mean;
    int64_t planes; /* 0: the front at the top wall */
    int32_t n;
    double amplitude[AMPLITUDES_MAX];
    sp_amplitude_front pulse[AMPLITUDES_MAX];
    amplitude_means means;
} arguments;

static sp_status set_amplitudes(void *user, const char *text, sp_error *err) {
    arguments *a = user;
    for (a->n = 0;; text++) {
        char word[64] = "";
        const size_t length = strcspn(text, ",");
        if (a->n == AMPLITUDES_MAX)
            return sp_fail(err, SP_EINVAL, "--amplitudes: at most %d numbers", AMPLITUDES_MAX);
        if (length < sizeof word)
            memcpy(word, text, length);
        const sp_status status = cli_number("--amplitudes", word, 1e-9, 1e6, &a->amplitude[a->n++], err);
        text += length;
        if (status != SP_OK || *text == '\0')
            return status;
    }
}

static sp_status check(void *user, sp_error *err) {
    const arguments *a = user;
    if (a->omega > 0 && (a->mean || a->o.until > 0 || a->o.source != SP_SOURCE_IMPULSE))
        return sp_fail(err, SP_EINVAL, "--omega cannot be combined with --mean, --until or --source");
    if (a->cycles > 0 && !(a->omega > 0))
        return sp_fail(err, SP_EINVAL, "--cycles: applies only to a burst, --omega");
    if (a->planes > 0 && a->mean)
        return sp_fail(err, SP_EINVAL, "--planes and --mean cannot be combined: planes lie at other heights in others");
    if (a->common.sets > 0)
        return sp_fail(err, SP_EINVAL, "--set %.60s: no key changes a loud pulse", a->common.set[0]);
    return SP_OK;
}

static const cli_option options[] = {
    {"amplitudes", "A1,A2,...",
     "Amplitudes, relative to the mean overlap, as in signal --amplitude (0.001,0.01,0.1,1,10)",
     .parse = set_amplitudes},
    {"mean", NULL, "Print means over packings of the same pressure, friction and dimension, with standard errors",
     CLI_FLAG, .field = offsetof(arguments, mean)},
    {"planes", "N", "Print the fronts at N planes that divide the height into equal layers, and speeds between them",
     CLI_INTEGER, .field = offsetof(arguments, planes), .low = 1, .high = PLANES_MAX},
    {"omega", "W", "Send bursts of this frequency instead of pulses, and print their harmonics [sqrt(E* / rho)/d]",
     CLI_NUMBER, .field = offsetof(arguments, omega), .low = 1e-9, .high = 1e9, .unit = "sqrt(E* / rho)/d"},
    {"cycles", "N", "With --omega: length of the burst in periods (6)", CLI_INTEGER,
     .field = offsetof(arguments, cycles), .low = 3, .high = 10000},
    {"until", "T", "Last time; a run ends behind the front [d/sqrt(E* / rho)] ((8 H + 40) (p/1e-4)^(-1/6))", CLI_NUMBER,
     .field = offsetof(arguments, o.until), .low = 1e-9, .high = 1e9, .unit = "d/sqrt(E* / rho)"},
    {"tolerance", "EPS", "Largest relative error of the speed and of the balance of energy (0.001)", CLI_NUMBER,
     .field = offsetof(arguments, o.tolerance), .low = 1e-8, .high = 0.1},
    {"source", "impulse|velocity|displacement", "Kind of source at the bottom wall, as in signal (impulse)", CLI_CHOICE,
     .field = offsetof(arguments, o.source), .words = cli_source_names},
    {0}};

static const cli_syntax syntax = {
    .usage = "FILE...",
    .help =
        "The front of a pulse at the bottom wall as it grows loud, from the nonlinear motion of packings: Hertz's "
        "law, sliding, and contacts that open and close.\v"
        "At the amplitude 1 the fastest grain starts with the mean overlap as its displacement, or with the velocity "
        "that corresponds to it.\n"
        "\n"
        "t10: time at which the force on the top wall reaches a tenth of its first peak.\n"
        "speed_ratio, peak_ratio, width_ratio: H/t10, the height of the front over the strength of the source, and "
        "its width t_zero - t10, each over its linear limit, which is that of `signal --prestress --threshold 0'. The "
        "width is nan if the force does not come back to its value at rest before the end of the run.\n"
        "overpressure: largest change of the force on the top wall over the force at rest.\n"
        "carrying: contacts that carry a force at rest. Of these slid, opened: how many slid or were open at some "
        "time before the front had passed; lost: are open then. closed: gaps that closed. With --mean these are "
        "means.\n"
        "kinetic, normal, tangential, rubbed, released: energies at that time over the energy of the source: of "
        "motion, of normal springs, work of the tangential springs, what sliding has rubbed away, and what of it the "
        "forces at rest have done. kinetic + normal + tangential + rubbed - released = 1.\n"
        "balance: largest deviation from this on the way. It is the error of the time steps, and goes as their "
        "square. step: that of the finer run.\n"
        "\n"
        "With --planes the table has the fronts at planes instead: y is the mean height of the contacts that cross a "
        "plane, overpressure the largest change of the flux of momentum over the force at rest, speed that from the "
        "plane below by t10, speed_peak by t_peak. For a chain of equal balls solitary is "
        "the speed of a solitary wave of this peak, kdv and nesterenko are those of long waves (see `chain soliton').\n"
        "\n"
        "With --omega the bottom wall moves as A delta sin(omega t) (1 - cos(omega t/N))/2, where delta is the mean "
        "overlap. F1, F2, F3, F0: harmonics and mean of the flux of momentum over that at rest. ratio: F2/F1^2. k and "
        "speed: of the first harmonic. slope: growth of F2/F1^2 with distance. beta: the coefficient of u_tt = c^2 "
        "u_xx "
        "(1 - beta u_x) that it means, and beta_delta times delta; beta_field: M/(3 p), what M ~ p^(1/3) would give, "
        "with M = density speed^2. With --planes there is a row for each plane, else one for ten.\n"
        "\n"
        "Errors (_err) are estimated from steps of twice the length and from every second time; with --mean they are "
        "standard errors over packings, plus the mean of these (nan for one packing).",
    .finds_material = true,
    .options = options,
    .file_name = "packing",
    .files_min = 1,
    .files_max = CLI_ANY_NUMBER,
    .check = check};

static sp_status begin(void *user, sp_table *t, sp_error *err) {
    const arguments *a = user;
    cli_writer w = {.table = t, .err = err};
    cli_comment(&w, "source = %s", cli_source_names[a->o.source]);
    cli_value(&w, "tolerance", a->o.tolerance);
    if (w.status == SP_OK && a->omega > 0)
        w.status = amplitude_burst_columns(a->planes > 0, t, err);
    else if (w.status == SP_OK && a->planes > 0)
        w.status = amplitude_plane_columns(t, err);
    else if (w.status == SP_OK && !a->mean)
        w.status = amplitude_add_columns(t, err);
    return w.status;
}

static sp_status add_rows(void *user, cli_file *file, sp_table *t, sp_error *err) {
    arguments *a = user;
    sp_status status = SP_OK;
    if (a->omega > 0) {
        for (int32_t k = 0; k < a->n && status == SP_OK; k++) {
            const sp_amplitude_burst b = {a->amplitude[k], a->omega, a->cycles > 0 ? (int32_t)a->cycles : CYCLES};
            status = amplitude_burst_rows(file, &a->o, &b, (int32_t)a->planes, t, err);
        }
        return status;
    }
    if (a->planes > 0) {
        for (int32_t k = 0; k < a->n && status == SP_OK; k++)
            status = amplitude_plane_rows(file, &a->o, a->amplitude[k], (int32_t)a->planes, t, err);
        return status;
    }
    status = sp_amplitude_pulses(&file->packing, &a->o, a->n, a->amplitude, a->pulse, NULL, err);
    for (int32_t k = 0; k < a->n && status == SP_OK; k++)
        status = a->mean ? amplitude_add_mean(&a->means, &file->packing, &a->pulse[k], err)
                         : amplitude_add_row(file->path, file->packing.pressure, &a->pulse[k], t, err);
    return status;
}

static sp_status end(void *user, sp_table *t, sp_error *err) {
    const arguments *a = user;
    return a->mean ? amplitude_mean_rows(&a->means, t, err) : SP_OK;
}

int cmd_amplitude(int argc, char **argv) {
    static const cli_files command = {
        .groups = "", .contents = CLI_PACKING, .begin = begin, .add = add_rows, .end = end};
    arguments a = {.o = sp_amplitude_options_default(), .n = 5};
    for (int k = 0; k < a.n; k++)
        a.amplitude[k] = (const double[]){0.001, 0.01, 0.1, 1, 10}[k];
    cli_parse(&syntax, argc, argv, &a);
    const int status = cli_run_files(&command, &a);
    sp_free(a.means.group);
    return status;
}
