/* sonopack amplitude: prints how the front of a pulse changes as it grows loud. */
#include "base/base.h"
#include "cli/files.h"
#include "packing/contact.h"

#include <math.h>
#include <sonopack/amplitude.h>
#include <string.h>

enum { AMPLITUDES_MAX = 200, PLANES_MAX = 1000, QUANTITIES = 17 };

/* Sums over packings of one pressure, friction and dimension at one amplitude. */
typedef struct group {
    double pressure, friction, amplitude;
    int dim;
    int64_t n;
    double sum[QUANTITIES], squares[QUANTITIES], errors[QUANTITIES];
} group;
typedef struct means {
    int32_t n;
    size_t capacity;
    group *group;
} means;

#define TIME  "d/sqrt(E* / rho)"
#define RATE  "sqrt(E* / rho)/d"
#define SPEED "sqrt(E* / rho)"

enum { WITH_ERRORS = 5, PLANES = 10 };

static void put(cli_writer *w, sp_amplitude_number x) { cli_put(w, x.value, x.error); }

/* ---- fronts ------------------------------------------------------------------------------------------------------ */

static const struct {
    const char *name, *unit, *error; /* the first WITH_ERRORS have one */
} quantities[QUANTITIES] = {{"t10", TIME, "t10_err"},
                            {"speed_ratio", "", "speed_ratio_err"},
                            {"peak_ratio", "", "peak_ratio_err"},
                            {"width_ratio", "", "width_ratio_err"},
                            {"overpressure", "", "overpressure_err"},
                            {"carrying", "", NULL},
                            {"slid", "", NULL},
                            {"opened", "", NULL},
                            {"lost", "", NULL},
                            {"closed", "", NULL},
                            {"kinetic", "", NULL},
                            {"normal", "", NULL},
                            {"tangential", "", NULL},
                            {"rubbed", "", NULL},
                            {"released", "", NULL},
                            {"balance", "", NULL},
                            {"step", TIME, NULL}};

/* The quantities of a pulse, as in the table above; errors: of the first WITH_ERRORS. */
static void measure(const sp_amplitude_front *a, double value[QUANTITIES], double error[WITH_ERRORS]) {
    const sp_amplitude_number over = {a->overpressure, a->overpressure * a->peak.error / a->peak.value};
    const sp_amplitude_number first[WITH_ERRORS] = {a->t10, a->speed, a->peak, a->width, over};
    const double input = a->energy.input;
    const double others[QUANTITIES - WITH_ERRORS] = {(double)a->carrying,      (double)a->slid,
                                                     (double)a->opened,        (double)a->lost,
                                                     (double)a->closed,        a->energy.kinetic / input,
                                                     a->energy.normal / input, a->energy.tangential / input,
                                                     a->energy.slid / input,   a->energy.released / input,
                                                     a->energy.defect,         a->step};
    for (int q = 0; q < QUANTITIES; q++)
        value[q] = q < WITH_ERRORS ? first[q].value : others[q - WITH_ERRORS];
    for (int q = 0; q < WITH_ERRORS; q++)
        error[q] = first[q].error;
}

static void quantity_columns(cli_writer *w) {
    for (int q = 0; q < QUANTITIES; q++) {
        cli_columns(w, SP_COLUMN_NUMBER, quantities[q].name, quantities[q].unit, NULL);
        if (quantities[q].error)
            cli_columns(w, SP_COLUMN_NUMBER, quantities[q].error, quantities[q].unit, NULL);
    }
}

static void front_columns(cli_writer *w) {
    cli_columns(w, SP_COLUMN_TEXT, "file", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "p", "E*", "amplitude", "", NULL);
    quantity_columns(w);
}

static void begin_row(const cli_file *file, double amplitude, cli_writer *w) {
    cli_put_text(w, file->path);
    cli_put(w, file->packing.pressure, amplitude);
}

static void front_row(const cli_file *file, const sp_amplitude_front *pulse, cli_writer *w) {
    double value[QUANTITIES], error[WITH_ERRORS];
    measure(pulse, value, error);
    begin_row(file, pulse->amplitude, w);
    for (int q = 0; q < QUANTITIES; q++) {
        cli_put(w, value[q]);
        if (q < WITH_ERRORS)
            cli_put(w, error[q]);
    }
    cli_end_row(w);
}

static group *group_of(means *m, const sp_packing *p, double amplitude) {
    for (int32_t k = 0; k < m->n; k++) {
        group *g = &m->group[k];
        if (g->pressure == p->pressure && g->friction == p->friction && g->dim == p->dim && g->amplitude == amplitude)
            return g;
    }
    group *grown = sp_grow(m->group, (size_t)m->n + 1, &m->capacity, sizeof *grown);
    if (!grown)
        return NULL;
    m->group = grown;
    grown[m->n] = (group){.pressure = p->pressure, .friction = p->friction, .dim = p->dim, .amplitude = amplitude};
    return &grown[m->n++];
}

static sp_status add_to_mean(means *m, const sp_packing *p, const sp_amplitude_front *pulse, sp_error *err) {
    double value[QUANTITIES], error[WITH_ERRORS];
    group *g = group_of(m, p, pulse->amplitude);
    if (!g)
        return sp_fail_memory(err, ((size_t)m->n + 1) * sizeof *g);
    measure(pulse, value, error);
    g->n++;
    for (int q = 0; q < QUANTITIES; q++) {
        g->sum[q] += value[q];
        g->squares[q] += value[q] * value[q];
        g->errors[q] += q < WITH_ERRORS ? error[q] : 0;
    }
    return SP_OK;
}

/* The standard error over packings and the mean error of the computation, which they may have in common. NAN for one
 * packing: nothing is known of others. */
static double mean_error(const group *g, int q) {
    const double n = (double)g->n, mean = g->sum[q] / n;
    return g->n > 1 ? sqrt(fmax(0, g->squares[q] / n - mean * mean) / (n - 1)) + g->errors[q] / n : NAN;
}

static void mean_rows(const means *m, cli_writer *w) {
    cli_columns(w, SP_COLUMN_INTEGER, "dimension", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "friction", "", "p", "E*", "amplitude", "", NULL);
    cli_columns(w, SP_COLUMN_INTEGER, "packings", "", NULL);
    quantity_columns(w);
    for (int32_t k = 0; k < m->n; k++) {
        const group *g = &m->group[k];
        cli_put(w, g->dim, g->friction, g->pressure, g->amplitude, (double)g->n);
        for (int q = 0; q < QUANTITIES; q++) {
            cli_put(w, g->sum[q] / (double)g->n);
            if (q < WITH_ERRORS)
                cli_put(w, mean_error(g, q));
        }
        cli_end_row(w);
    }
}

/* ---- fronts at planes, and the solitary waves of chains beside them ---------------------------------------------- */

/* Speeds that a chain of equal balls has for the peak of a front; NAN for other packings. */
typedef struct expected {
    double solitary, kdv, nesterenko;
} expected;

static bool is_equal_chain(const sp_packing *p) {
    for (int32_t i = 0; i < p->n; i++)
        if (p->dim != 1 || p->r[i] != p->r[0] || p->contacts[i].fn != p->contacts[0].fn)
            return false;
    return sp_packing_hertzian(p) && p->contacts[0].j >= 0;
}

static sp_status expect(const sp_packing *p, double overpressure, expected *out, sp_error *err) {
    const double peak = pow(1 + overpressure, 2.0 / 3.0) - 1;
    sp_solitary s;
    *out = (expected){NAN, NAN, NAN};
    if (!is_equal_chain(p) || !(peak > 1e-4 && peak < 1e9))
        return SP_OK;
    const double mass = grain_mass(p->r[0]), length = 2 * p->r[0] - p->contacts[0].overlap;
    const double c = sqrt(contact_kn(p, &p->contacts[0]) / mass) * length;
    const sp_status status = sp_solitary_make(peak, &s, err);
    if (status == SP_OK)
        *out = (expected){s.speed * c, s.kdv * c, s.nesterenko * c};
    return status;
}

static void plane_columns(cli_writer *w) {
    cli_columns(w, SP_COLUMN_TEXT, "file", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "p", "E*", "amplitude", "", "y", "d", "t10", TIME, "t10_err", TIME, "t_peak", TIME,
                "t_peak_err", TIME, "overpressure", "", "overpressure_err", "", "speed", SPEED, "speed_err", SPEED,
                "speed_peak", SPEED, "speed_peak_err", SPEED, "solitary", SPEED, "kdv", SPEED, "nesterenko", SPEED,
                NULL);
}

static void add_plane(const cli_file *file, double amplitude, const sp_amplitude_plane *a, cli_writer *w) {
    expected e;
    w->status = expect(&file->packing, a->overpressure.value, &e, w->err);
    if (w->status != SP_OK)
        return;
    begin_row(file, amplitude, w);
    cli_put(w, a->height);
    put(w, a->t10);
    put(w, a->t_peak);
    put(w, a->overpressure);
    put(w, a->speed);
    put(w, a->speed_peak);
    cli_put(w, e.solitary, e.kdv, e.nesterenko);
    cli_end_row(w);
}

static void plane_rows(const cli_file *file, const sp_amplitude_options *o, double amplitude, int32_t planes,
                       cli_writer *w) {
    double *height = sp_alloc((size_t)planes, sizeof *height);
    sp_amplitude_plane *plane = sp_alloc((size_t)planes, sizeof *plane);
    if (!height || !plane)
        w->status = sp_fail_memory(w->err, (size_t)planes * (sizeof *height + sizeof *plane));
    for (int32_t b = 0; b < planes && w->status == SP_OK; b++)
        height[b] = sp_packing_height(&file->packing) * (b + 1) / (planes + 1);
    CLI_THEN(w->status, sp_amplitude_planes(&file->packing, o, amplitude, planes, height, plane, NULL, w->err));
    for (int32_t b = 0; b < planes && w->status == SP_OK; b++)
        add_plane(file, amplitude, &plane[b], w);
    sp_free(plane);
    sp_free(height);
}

/* ---- harmonics of bursts ----------------------------------------------------------------------------------------- */

static void burst_columns(bool planes, cli_writer *w) {
    cli_columns(w, SP_COLUMN_TEXT, "file", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "p", "E*", "amplitude", "", "omega", RATE, NULL);
    if (planes)
        cli_columns(w, SP_COLUMN_NUMBER, "y", "d", "F1", "", "F1_err", "", "F2", "", "F2_err", "", "F3", "", "F3_err",
                    "", "F0", "", "F0_err", "", "ratio", "", "ratio_err", "", NULL);
    else
        cli_columns(w, SP_COLUMN_NUMBER, "k", "1/d", "k_err", "1/d", "speed", SPEED, "speed_err", SPEED, "slope", "1/d",
                    "slope_err", "1/d", "beta", "", "beta_err", "", "beta_delta", "", "beta_delta_err", "",
                    "beta_field", "", "balance", "", "step", TIME, NULL);
}

/* Mean overlap of the contacts that carry a force. */
static double mean_overlap(const sp_packing *p) {
    double sum = 0;
    int32_t n = 0;
    for (int32_t k = 0; k < p->n_contacts; k++)
        if (p->contacts[k].fn > 0) {
            sum += p->contacts[k].overlap;
            n++;
        }
    return sum / n;
}

/* beta of M ~ p^(1/3): d ln M/d(strain) = M/(3 p), with M = density c^2. */
static double field_beta(const sp_packing *p, double speed) {
    double mass = 0;
    for (int32_t i = 0; i < p->n; i++)
        mass += M_PI * 4 / 3 * p->r[i] * p->r[i] * p->r[i];
    return mass / sp_packing_volume(p) * speed * speed / (3 * p->pressure);
}

static void add_harmonics(const sp_amplitude_harmonics *h, cli_writer *w) {
    cli_put(w, h->height);
    put(w, h->first);
    put(w, h->second);
    put(w, h->third);
    put(w, h->mean);
    put(w, h->ratio);
}

static void add_summary(const sp_packing *p, const sp_amplitude_second *s, cli_writer *w) {
    const double delta = mean_overlap(p);
    put(w, s->k);
    put(w, s->speed);
    put(w, s->slope);
    put(w, s->beta);
    cli_put(w, delta * s->beta.value, delta * s->beta.error, field_beta(p, s->speed.value), s->energy.defect, s->step);
}

static void burst_rows(const cli_file *file, const sp_amplitude_options *o, const sp_amplitude_burst *burst,
                       int32_t planes, cli_writer *w) {
    const int32_t n = planes > 0 ? planes : PLANES;
    sp_amplitude_harmonics *plane = sp_alloc((size_t)n, sizeof *plane);
    sp_amplitude_second second;
    if (plane)
        w->status = sp_amplitude_bursts(&file->packing, o, burst, n, NULL, plane, planes > 0 ? NULL : &second, w->err);
    else
        w->status = sp_fail_memory(w->err, (size_t)n * sizeof *plane);
    for (int32_t b = 0; b < (planes > 0 ? n : 1) && w->status == SP_OK; b++) {
        begin_row(file, burst->amplitude, w);
        cli_put(w, burst->omega);
        if (planes > 0)
            add_harmonics(&plane[b], w);
        else
            add_summary(&file->packing, &second, w);
        cli_end_row(w);
    }
    sp_free(plane);
}

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
    means means;
} arguments;

static sp_status set_amplitudes(void *user, const char *text, sp_error *err) {
    arguments *a = user;
    return cli_numbers("--amplitudes", text, 1e-9, 1e6, AMPLITUDES_MAX, &a->n, a->amplitude, err);
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
     CLI_FLAG, CLI_FIELD(mean)},
    {"planes", "N", "Print the fronts at N planes that divide the height into equal layers, and speeds between them",
     CLI_INTEGER, CLI_FIELD(planes), .low = 1, .high = PLANES_MAX},
    {"omega", "W", "Send bursts of this frequency instead of pulses, and print their harmonics [sqrt(E* / rho)/d]",
     CLI_NUMBER, CLI_FIELD(omega), .low = 1e-9, .high = 1e9, .unit = "sqrt(E* / rho)/d"},
    {"cycles", "N", "With --omega: length of the burst in periods (6)", CLI_INTEGER, CLI_FIELD(cycles), .low = 3,
     .high = 10000},
    {"until", "T", "Last time; a run ends behind the front [d/sqrt(E* / rho)] ((8 H + 40) (p/1e-4)^(-1/6))", CLI_NUMBER,
     CLI_FIELD(o.until), .low = 1e-9, .high = 1e9, .unit = "d/sqrt(E* / rho)"},
    {"tolerance", "EPS", "Largest relative error of the speed and of the balance of energy (0.001)", CLI_NUMBER,
     CLI_FIELD(o.tolerance), .low = 1e-8, .high = 0.1},
    {"source", "impulse|velocity|displacement", "Kind of source at the bottom wall, as in signal (impulse)", CLI_CHOICE,
     CLI_FIELD(o.source), .words = cli_source_names},
    {0}};

const cli_syntax cmd_amplitude_syntax = {
    .usage = "FILE...",
    .help =
        "The front of a pulse at the bottom wall as it grows loud, from the nonlinear motion of packings: Hertz's law, "
        "sliding, and contacts that open and close.\vAt the amplitude 1 the fastest grain starts with the mean overlap "
        "as its displacement, or with the velocity that corresponds to it.\n"
        "\n"
        "t10: time at which the force on the top wall reaches a tenth of its first peak.\n"
        "speed_ratio, peak_ratio, width_ratio: H/t10, the height of the front over the strength of the source, and its "
        "width t_zero - t10, each over its linear limit, which is that of `signal --prestress --threshold 0'. The "
        "width is nan if the force does not come back to its value at rest before the end of the run.\n"
        "overpressure: largest change of the force on the top wall over the force at rest.\n"
        "carrying: contacts that carry a force at rest. Of these slid, opened: how many slid or were open at some time "
        "before the front had passed; lost: are open then. closed: gaps that closed. With --mean these are means.\n"
        "kinetic, normal, tangential, rubbed, released: energies at that time over the energy of the source: of "
        "motion, of normal springs, work of the tangential springs, what sliding has rubbed away, and what of it the "
        "forces at rest have done. kinetic + normal + tangential + rubbed - released = 1.\n"
        "balance: largest deviation from this on the way. It is the error of the time steps, and goes as their square. "
        "step: that of the finer run.\n"
        "\n"
        "With --planes the table has the fronts at planes instead: y is the mean height of the contacts that cross a "
        "plane, overpressure the largest change of the flux of momentum over the force at rest, speed that from the "
        "plane below by t10, speed_peak by t_peak. For a chain of equal balls solitary is the speed of a solitary wave "
        "of this peak, kdv and nesterenko are those of long waves (see `chain soliton').\n"
        "\n"
        "With --omega the bottom wall moves as A delta sin(omega t) (1 - cos(omega t/N))/2, where delta is the mean "
        "overlap. F1, F2, F3, F0: harmonics and mean of the flux of momentum over that at rest. ratio: F2/F1^2. k and "
        "speed: of the first harmonic. slope: growth of F2/F1^2 with distance. beta: the coefficient of u_tt = c^2 "
        "u_xx (1 - beta u_x) that it means, and beta_delta times delta; beta_field: M/(3 p), what M ~ p^(1/3) would "
        "give, with M = density speed^2. With --planes there is a row for each plane, else one for ten.\n"
        "\n"
        "Errors (_err) are estimated from steps of twice the length and from every second time; with --mean they are "
        "standard errors over packings, plus the mean of these (nan for one packing).",
    CLI_PACKINGS,
    .options = options,
    .check = check};

static sp_status begin(void *user, cli_writer *w) {
    const arguments *a = user;
    cli_comment(w, "source = %s", cli_source_names[a->o.source]);
    cli_value(w, "tolerance", a->o.tolerance);
    if (a->omega > 0)
        burst_columns(a->planes > 0, w);
    else if (a->planes > 0)
        plane_columns(w);
    else if (!a->mean)
        front_columns(w);
    return w->status;
}

static sp_status add_rows(void *user, cli_file *file, cli_writer *w) {
    arguments *a = user;
    const int32_t cycles = a->cycles > 0 ? (int32_t)a->cycles : CYCLES, planes = (int32_t)a->planes;
    if (!(a->omega > 0) && planes == 0)
        w->status = sp_amplitude_pulses(&file->packing, &a->o, a->n, a->amplitude, a->pulse, NULL, w->err);
    for (int32_t k = 0; k < a->n && w->status == SP_OK; k++)
        if (a->omega > 0)
            burst_rows(file, &a->o, &(sp_amplitude_burst){a->amplitude[k], a->omega, cycles}, planes, w);
        else if (planes > 0)
            plane_rows(file, &a->o, a->amplitude[k], planes, w);
        else if (a->mean)
            w->status = add_to_mean(&a->means, &file->packing, &a->pulse[k], w->err);
        else
            front_row(file, &a->pulse[k], w);
    return w->status;
}

static sp_status end(void *user, cli_writer *w) {
    const arguments *a = user;
    if (a->mean)
        mean_rows(&a->means, w);
    return w->status;
}

int cmd_amplitude(int argc, char **argv) {
    static const cli_files command = {
        .groups = "", .contents = CLI_PACKING, .begin = begin, .add = add_rows, .end = end};
    arguments a = {.o = sp_amplitude_options_default(), .n = 5};
    for (int k = 0; k < a.n; k++)
        a.amplitude[k] = (const double[]){0.001, 0.01, 0.1, 1, 10}[k];
    cli_parse(&cmd_amplitude_syntax, argc, argv, &a);
    const int status = cli_run_files(&command, &a);
    sp_free(a.means.group);
    return status;
}
