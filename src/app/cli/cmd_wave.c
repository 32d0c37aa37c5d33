/* sonopack wave: prints phase speed and attenuation of the coherent wave inside packings. */
#include "base/base.h"
#include "cli/excitation.h"
#include "cli/files.h"

#include <math.h>
#include <sonopack/coherent.h>

enum { FREQUENCIES_MAX = 10000, FREQUENCIES_DEFAULT = 24 };

/* Sums over packings at one frequency. */
typedef struct sums {
    int64_t n;
    double k, kk, alpha, aa, part, k_shift, alpha_shift;
} sums;

typedef struct arguments {
    cli_common common;
    sp_coherent_section_options section;
    sp_damping damping;
    const char *at;
    int dim;   /* of the packings so far; 0: none */
    int32_t n; /* frequencies; the first packing decides */
    double *omega;
    sums *sum;
} arguments;

static const cli_option options[] = {
    {"at", "W1,W2,...|LOW:HIGH:N",
     "Frequencies (24, from four periods in the record to 0.3 of the upper bound of the spectrum)", CLI_TEXT,
     .field = offsetof(arguments, at)},
    {"spacing", "D", "Distance between planes [d] (1)", CLI_NUMBER, .field = offsetof(arguments, section.spacing),
     .low = 0.01, .high = 1e6},
    {"low", "Y", "Height of the lowest plane [d] (4)", CLI_NUMBER, .field = offsetof(arguments, section.low),
     .high = 1e6},
    {"part", "F", "Place planes up to this fraction of the height (0.6)", CLI_NUMBER,
     .field = offsetof(arguments, section.part), .low = 0.01, .high = 1},
    {"damping", CLI_DAMPING, "Dashpots of the contacts, as in signal (0)", CLI_DASHPOTS,
     .field = offsetof(arguments, damping), .high = 100},
    {"source", "impulse|velocity|displacement", "Kind of source at the bottom wall, as in signal (impulse)", CLI_CHOICE,
     .field = offsetof(arguments, section.source), .words = cli_source_names},
    {0}};

static const cli_syntax syntax = {
    .usage = "FILE...",
    .help =
        "Phase speed and attenuation of the coherent wave that a pulse at the bottom wall sends up through "
        "packings.\v"
        "For each packing and each frequency, A e^(i k y - alpha y) is fitted by least squares to the momentum flux "
        "through horizontal planes, recorded until the echo from the top wall arrives. The table has the means over "
        "the packings and their standard errors (nan for a single packing). alpha: attenuation of the amplitude, "
        "which is due to scattering alone unless --damping is given. Q = k/(2 alpha) is the quality factor (nan where "
        "alpha is within three errors of 0). part: fraction of the squared flux that the wave accounts for; the rest "
        "is scattered waves. samples: number of packings for which the fit succeeded. k_shift and alpha_shift: "
        "change of the means when only the first half of the record is used, which is usually more than the effect "
        "of the end of the record. The packings should have the same material and pressure.",
    CLI_PACKINGS,
    .options = options,
    .springs = true};

static sp_status begin(void *user, cli_writer *w) {
    arguments *a = user;
    a->section.damping = a->damping.value;
    a->section.damping_kind = a->damping.kind;
    a->section.damping_ratio = a->damping.ratio;
    a->omega = sp_alloc(FREQUENCIES_MAX, sizeof *a->omega);
    a->sum = sp_alloc(FREQUENCIES_MAX, sizeof *a->sum);
    return a->omega && a->sum ? SP_OK : sp_fail_memory(w->err, FREQUENCIES_MAX * (sizeof *a->omega + sizeof *a->sum));
}

static void add_fit(sums *s, const sp_coherent_wave *c) {
    if (isnan(c->k))
        return;
    s->n++;
    s->k += c->k;
    s->kk += c->k * c->k;
    s->alpha += c->alpha;
    s->aa += c->alpha * c->alpha;
    s->part += c->part;
    s->k_shift += c->k_shift;
    s->alpha_shift += c->alpha_shift;
}

static double mean(double sum, int64_t n) { return n > 0 ? sum / (double)n : NAN; }

static double error_of_mean(double sum, double squares, int64_t n) {
    const double m = (double)n;
    return n > 1 ? sqrt(fmax(0, squares - sum * sum / m) / (m - 1) / m) : NAN;
}

static sp_status choose_frequencies(arguments *a, const sp_network *net, const sp_coherent_section *s, sp_error *err) {
    if (a->at)
        return cli_frequencies(a->at, FREQUENCIES_MAX, &a->n, a->omega, err);
    const double low = 4 * 2 * M_PI / s->until[0], high = 0.3 * sp_network_omega_bound(net);
    if (!(low < high))
        return sp_fail(err, SP_EREFUSED, "the record is too short for the default frequencies: use --at");
    for (a->n = 0; a->n < FREQUENCIES_DEFAULT; a->n++)
        a->omega[a->n] = low * pow(high / low, a->n / (FREQUENCIES_DEFAULT - 1.0));
    return SP_OK;
}

static sp_status add_packing(void *user, cli_file *file, cli_writer *w) {
    arguments *a = user;
    sp_coherent_section s = sp_coherent_section_none();
    sp_coherent_wave fit;
    if (a->dim && a->dim != file->packing.dim)
        return sp_fail(w->err, SP_EREFUSED, "has %d dimensions, the packings before it have %d", file->packing.dim,
                       a->dim);
    a->dim = file->packing.dim;
    sp_status status = sp_coherent_section_make(&file->network, &a->section, &s, w->err);
    if (status == SP_OK && a->n == 0)
        status = choose_frequencies(a, &file->network, &s, w->err);
    for (int32_t l = 0; l < a->n && status == SP_OK; l++) {
        status = sp_coherent_fit(&s, a->omega[l], &fit, w->err);
        if (status == SP_OK)
            add_fit(&a->sum[l], &fit);
    }
    sp_coherent_section_free(&s);
    return status;
}

/* Notes why rows are nan. */
static void explain(const arguments *a) {
    int32_t none = 0;
    for (int32_t l = 0; l < a->n; l++)
        none += a->sum[l].n == 0;
    if (none > 0)
        cli_note(&a->common,
                 "k and alpha are nan at %d of %d frequencies: either fewer than four planes have a record as long as "
                 "a period, or the wave spans too few planes, or the frequency is above the largest of the network",
                 none, a->n);
}

static sp_status add_rows(void *user, cli_writer *w) {
    const arguments *a = user;
    explain(a);
    cli_comment(w, "packings = %d", a->common.files);
    cli_comment(w, "dimension = %d", a->dim);
    cli_comment(w, "source = %s", cli_source_names[a->section.source]);
    if (a->damping.value > 0)
        cli_damping_comment(w, &a->damping);
    cli_columns(w, SP_COLUMN_NUMBER, "omega", "sqrt(E* / rho)/d", "k", "1/d", "k_err", "1/d", "speed", "sqrt(E* / rho)",
                "speed_err", "sqrt(E* / rho)", "alpha", "1/d", "alpha_err", "1/d", "part", "", NULL);
    cli_columns(w, SP_COLUMN_INTEGER, "samples", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "k_shift", "1/d", "alpha_shift", "1/d", "Q", "", "Q_err", "", NULL);
    for (int32_t l = 0; l < a->n && w->status == SP_OK; l++) {
        const sums *s = &a->sum[l];
        const double k = mean(s->k, s->n), k_err = error_of_mean(s->k, s->kk, s->n), speed = a->omega[l] / k,
                     alpha = mean(s->alpha, s->n), alpha_err = error_of_mean(s->alpha, s->aa, s->n);
        double q, q_err;
        sp_wave_quality(k, k_err, alpha, alpha_err, &q, &q_err);
        cli_row(w, a->omega[l], k, k_err, speed, speed * k_err / k, alpha, alpha_err, mean(s->part, s->n), s->n,
                mean(s->k_shift, s->n), mean(s->alpha_shift, s->n), q, q_err);
    }
    return w->status;
}

int cmd_wave(int argc, char **argv) {
    static const cli_files command = {.groups = "network",
                                      .contents = CLI_NETWORK,
                                      .stop = true,
                                      .begin = begin,
                                      .add = add_packing,
                                      .end = add_rows};
    arguments a = {.damping = {.ratio = 1}, .section = sp_coherent_section_options_default()};
    cli_parse(&syntax, argc, argv, &a);
    const int status = cli_run_files(&command, &a);
    sp_free(a.omega);
    sp_free(a.sum);
    return status;
}
