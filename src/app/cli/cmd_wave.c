/* sonopack wave: phase speed and attenuation of the coherent wave inside packings. */
#include "base/base.h"
#include "cli/springs.h"

#include <math.h>
#include <sonopack/coherent.h>

enum { FREQUENCIES_MAX = 10000, USUAL = 24 };

typedef struct arguments {
    cli_common common;
    cli_springs springs;
    sp_coherent_section_options section;
    const char *at;
    int files;
    char **file;
} arguments;

enum { KEY_AT = 0x1000, KEY_SPACING, KEY_LOW, KEY_PART, KEY_SOURCE };

static const struct argp_option options[] = {
    {"at", KEY_AT, "W1,W2,...|LOW:HIGH:N", 0,
     "Frequencies (24 from four periods in the record up to 0.3 of the bound of the spectrum)", 0},
    {"spacing", KEY_SPACING, "D", 0, "Distance of the planes (1)", 0},
    {"low", KEY_LOW, "Y", 0, "Height of the lowest plane (4)", 0},
    {"part", KEY_PART, "F", 0, "Planes up to this part of the height (0.6)", 0},
    {"source", KEY_SOURCE, "impulse|velocity|displacement", 0, "What the bottom wall does, as in signal (impulse)", 0},
    {0}};
static const struct argp_child children[] = {
    {&cli_springs_argp, 0, "Springs:", 50}, {&cli_common_argp, 0, "Common options:", 90}, {0}};

static error_t parse(int key, char *arg, struct argp_state *state) {
    arguments *a = state->input;
    sp_error err = {0};
    sp_status status = SP_OK;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &a->springs;
        state->child_inputs[1] = &a->common;
        return 0;
    case KEY_AT: a->at = arg; break;
    case KEY_SPACING: status = cli_number("--spacing", arg, 0.01, 1e6, &a->section.spacing, &err); break;
    case KEY_LOW: status = cli_number("--low", arg, 0, 1e6, &a->section.low, &err); break;
    case KEY_PART: status = cli_number("--part", arg, 0.01, 1, &a->section.part, &err); break;
    case KEY_SOURCE:
        if (!cli_source_of(arg, &a->section.source))
            argp_error(state, "--source %.60s: must be impulse, velocity or displacement", arg);
        break;
    case ARGP_KEY_ARGS:
        a->file = state->argv + state->next;
        a->files = state->argc - state->next;
        return 0;
    case ARGP_KEY_NO_ARGS: argp_error(state, "no file: must be one packing or more"); break;
    default: return ARGP_ERR_UNKNOWN;
    }
    if (status != SP_OK)
        argp_error(state, "%s", err.text);
    return 0;
}

static const struct argp argp = {
    options,
    parse,
    "FILE...",
    "Phase speed and attenuation of the coherent wave that a pulse at the bottom wall sends up through packings.\v"
    "The momentum flux through horizontal planes, up to the echo of the top wall, is brought to A e^(i k y - alpha y) "
    "at every frequency by least squares, for each packing by itself; the table has the means over the packings, and "
    "their standard errors (nan for one packing). alpha: attenuation of the amplitude, by scattering alone. part: how "
    "much of the squares the wave accounts for; the rest is scattered waves. samples: packings whose planes tell k and "
    "alpha. k_shift and alpha_shift: by how much the means change if half as long a time counts; mostly more than what "
    "the "
    "end of the records does to them. The packings should be of one material, at one pressure.",
    children,
    NULL,
    NULL};

/* Sums over packings at one frequency. */
typedef struct sums {
    int64_t n;
    double k, kk, alpha, aa, part, k_shift, alpha_shift;
} sums;

/* All frequencies, chosen by the first packing. */
typedef struct waves {
    int dim; /* of the packings; 0: none read yet */
    int32_t n;
    double *omega;
    sums *sum;
} waves;

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

static sp_status choose(const arguments *a, const sp_network *net, const sp_coherent_section *s, int32_t *n,
                        double *omega, sp_error *err) {
    if (a->at)
        return cli_frequencies(a->at, FREQUENCIES_MAX, n, omega, err);
    const double low = 4 * 2 * M_PI / s->until[0], high = 0.3 * sp_network_omega_bound(net);
    if (!(low < high))
        return sp_fail(err, SP_EREFUSED, "the record is too short for frequencies of its own choice, see --at");
    for (*n = 0; *n < USUAL; ++*n)
        omega[*n] = low * pow(high / low, *n / (USUAL - 1.0));
    return SP_OK;
}

/* The fits of one packing. */
static sp_status add_packing(const arguments *a, const sp_scene *scene, const char *path, waves *w, sp_error *err) {
    int32_t *const n = &w->n;
    double *const omega = w->omega;
    sp_packing p = sp_packing_none();
    sp_network net = sp_network_none();
    sp_coherent_section s = sp_coherent_section_none();
    sp_coherent_wave fit;
    sp_status status = cli_read_network(path, &scene->network, &p, &net, err);
    const bool readable = status == SP_OK;
    if (status == SP_OK && w->dim && w->dim != p.dim)
        status =
            sp_fail(err, SP_EREFUSED, "has %d dimensions and the packings before %d: must be alike", p.dim, w->dim);
    w->dim = p.dim;
    if (status == SP_OK)
        status = sp_coherent_section_make(&net, &a->section, &s, err);
    if (status == SP_OK && *n == 0)
        status = choose(a, &net, &s, n, omega, err);
    for (int32_t l = 0; l < *n && status == SP_OK; l++) {
        status = sp_coherent_fit(&s, omega[l], &fit, err);
        if (status == SP_OK)
            add_fit(&w->sum[l], &fit);
    }
    if (status != SP_OK && status != SP_EINVAL && readable)
        sp_fail_prefix(err, "%s", path);
    sp_coherent_section_free(&s);
    sp_network_free(&net);
    sp_packing_free(&p);
    return status;
}

static sp_status put(const waves *w, sp_table *t, sp_error *err) {
    static const char *const columns[] = {
        "omega",     "sqrt(E* / rho)/d", "k",     "1/d", "k_err",     "1/d", "speed", "sqrt(E* / rho)",
        "speed_err", "sqrt(E* / rho)",   "alpha", "1/d", "alpha_err", "1/d", "part",  "",
        NULL};
    static const char *const shifts[] = {"k_shift", "1/d", "alpha_shift", "1/d", NULL};
    sp_status status = cli_add_columns(t, columns, err);
    if (status == SP_OK)
        status = sp_table_add_column(t, "samples", "", SP_CELL_INTEGER, err);
    if (status == SP_OK)
        status = cli_add_columns(t, shifts, err);
    for (int32_t l = 0; l < w->n && status == SP_OK; l++) {
        const sums *s = &w->sum[l];
        const double k = mean(s->k, s->n), k_err = error_of_mean(s->k, s->kk, s->n), speed = w->omega[l] / k;
        status = sp_table_add_row(t, err, w->omega[l], k, k_err, speed, speed * k_err / k, mean(s->alpha, s->n),
                                  error_of_mean(s->alpha, s->aa, s->n), mean(s->part, s->n), s->n,
                                  mean(s->k_shift, s->n), mean(s->alpha_shift, s->n));
    }
    return status;
}

/* What rows of nan are due to. */
static void explain(const arguments *a, const waves *w) {
    int32_t none = 0;
    for (int32_t l = 0; l < w->n; l++)
        none += w->sum[l].n == 0;
    if (none > 0)
        cli_note(
            &a->common,
            "k and alpha are nan at %d of %d frequencies: no packing tells them (fewer than four planes with a record "
            "as long as the wave, no wave that spans planes, or a frequency above the largest of the network)",
            none, w->n);
}

static sp_status work(const arguments *a, sp_error *err) {
    sp_scene scene = sp_scene_default();
    sp_table t = sp_table_none();
    waves w = {.omega = sp_alloc(FREQUENCIES_MAX, sizeof *w.omega), .sum = sp_alloc(FREQUENCIES_MAX, sizeof *w.sum)};
    sp_status status =
        w.omega && w.sum ? SP_OK : sp_fail_memory(err, FREQUENCIES_MAX * (sizeof *w.omega + sizeof *w.sum));
    if (status == SP_OK)
        status = cli_may_write_table(&a->common, err);
    if (status == SP_OK)
        status = cli_springs_scene(&a->common, &a->springs, "network", &scene, err);
    for (int k = 0; k < a->files && status == SP_OK; k++)
        status = add_packing(a, &scene, a->file[k], &w, err);
    if (status == SP_OK)
        status = sp_table_add_comment(&t, err, "packings = %d", a->files);
    if (status == SP_OK)
        status = sp_table_add_comment(&t, err, "dimension = %d", w.dim);
    if (status == SP_OK)
        status = sp_table_add_comment(&t, err, "source = %s", cli_source_name(a->section.source));
    if (status == SP_OK) {
        explain(a, &w);
        status = put(&w, &t, err);
    }
    if (status == SP_OK)
        status = cli_write_table(&a->common, &t, err);
    sp_table_free(&t);
    sp_scene_free(&scene);
    sp_free(w.omega);
    sp_free(w.sum);
    return status;
}

int cmd_wave(int argc, char **argv) {
    arguments a = {.section = sp_coherent_section_options_default()};
    argp_parse(&argp, argc, argv, 0, NULL, &a);
    sp_error err = {0};
    return work(&a, &err) == SP_OK ? CLI_OK : cli_fail(&err);
}
