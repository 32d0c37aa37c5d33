/* Tables of loud pulses: fronts and their means over packings, fronts at planes, harmonics of bursts. */
#include "base/base.h"
#include "cli/amplitude.h"
#include "packing/contact.h"

#include <math.h>

#define TIME  "d/sqrt(E* / rho)"
#define RATE  "sqrt(E* / rho)/d"
#define SPEED "sqrt(E* / rho)"

enum { WITH_ERRORS = 5, PLANES = 10 };

static void put(cli_writer *w, sp_amplitude_number x) {
    cli_put(w, x.value);
    cli_put(w, x.error);
}

/* ---- fronts ----------------------------------------------------------------------------------------------------- */

static const struct {
    const char *name, *unit, *error; /* the first WITH_ERRORS have one */
} quantities[AMPLITUDE_QUANTITIES] = {{"t10", TIME, "t10_err"},
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
static void measure(const sp_amplitude_front *a, double value[AMPLITUDE_QUANTITIES], double error[WITH_ERRORS]) {
    const sp_amplitude_number over = {a->overpressure, a->overpressure * a->peak.error / a->peak.value};
    const sp_amplitude_number first[WITH_ERRORS] = {a->t10, a->speed, a->peak, a->width, over};
    const double input = a->energy.input;
    const double others[AMPLITUDE_QUANTITIES - WITH_ERRORS] = {(double)a->carrying,      (double)a->slid,
                                                               (double)a->opened,        (double)a->lost,
                                                               (double)a->closed,        a->energy.kinetic / input,
                                                               a->energy.normal / input, a->energy.tangential / input,
                                                               a->energy.slid / input,   a->energy.released / input,
                                                               a->energy.defect,         a->step};
    for (int q = 0; q < AMPLITUDE_QUANTITIES; q++)
        value[q] = q < WITH_ERRORS ? first[q].value : others[q - WITH_ERRORS];
    for (int q = 0; q < WITH_ERRORS; q++)
        error[q] = first[q].error;
}

static void quantity_columns(cli_writer *w) {
    for (int q = 0; q < AMPLITUDE_QUANTITIES; q++) {
        cli_columns(w, SP_COLUMN_NUMBER, quantities[q].name, quantities[q].unit, NULL);
        if (quantities[q].error)
            cli_columns(w, SP_COLUMN_NUMBER, quantities[q].error, quantities[q].unit, NULL);
    }
}

void amplitude_add_columns(cli_writer *w) {
    cli_columns(w, SP_COLUMN_TEXT, "file", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "p", "E*", "amplitude", "", NULL);
    quantity_columns(w);
}

static void begin_row(const cli_file *file, double amplitude, cli_writer *w) {
    cli_put_text(w, file->path);
    cli_put(w, file->packing.pressure);
    cli_put(w, amplitude);
}

void amplitude_add_row(const cli_file *file, const sp_amplitude_front *pulse, cli_writer *w) {
    double value[AMPLITUDE_QUANTITIES], error[WITH_ERRORS];
    measure(pulse, value, error);
    begin_row(file, pulse->amplitude, w);
    for (int q = 0; q < AMPLITUDE_QUANTITIES; q++) {
        cli_put(w, value[q]);
        if (q < WITH_ERRORS)
            cli_put(w, error[q]);
    }
    cli_end_row(w);
}

static amplitude_group *group_of(amplitude_means *m, const sp_packing *p, double amplitude) {
    for (int32_t k = 0; k < m->n; k++) {
        amplitude_group *g = &m->group[k];
        if (g->pressure == p->pressure && g->friction == p->friction && g->dim == p->dim && g->amplitude == amplitude)
            return g;
    }
    amplitude_group *grown = sp_grow(m->group, (size_t)m->n + 1, &m->capacity, sizeof *grown);
    if (!grown)
        return NULL;
    m->group = grown;
    grown[m->n] =
        (amplitude_group){.pressure = p->pressure, .friction = p->friction, .dim = p->dim, .amplitude = amplitude};
    return &grown[m->n++];
}

sp_status amplitude_add_mean(amplitude_means *m, const sp_packing *p, const sp_amplitude_front *pulse, sp_error *err) {
    double value[AMPLITUDE_QUANTITIES], error[WITH_ERRORS];
    amplitude_group *g = group_of(m, p, pulse->amplitude);
    if (!g)
        return sp_fail_memory(err, ((size_t)m->n + 1) * sizeof *g);
    measure(pulse, value, error);
    g->n++;
    for (int q = 0; q < AMPLITUDE_QUANTITIES; q++) {
        g->sum[q] += value[q];
        g->squares[q] += value[q] * value[q];
        g->errors[q] += q < WITH_ERRORS ? error[q] : 0;
    }
    return SP_OK;
}

/* The standard error over packings and the mean error of the computation, which they may have in common. NAN for one
 * packing: nothing is known of others. */
static double mean_error(const amplitude_group *g, int q) {
    const double n = (double)g->n, mean = g->sum[q] / n;
    return g->n > 1 ? sqrt(fmax(0, g->squares[q] / n - mean * mean) / (n - 1)) + g->errors[q] / n : NAN;
}

void amplitude_mean_rows(const amplitude_means *m, cli_writer *w) {
    cli_columns(w, SP_COLUMN_INTEGER, "dimension", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "friction", "", "p", "E*", "amplitude", "", NULL);
    cli_columns(w, SP_COLUMN_INTEGER, "packings", "", NULL);
    quantity_columns(w);
    for (int32_t k = 0; k < m->n; k++) {
        const amplitude_group *g = &m->group[k];
        cli_put(w, g->dim);
        cli_put(w, g->friction);
        cli_put(w, g->pressure);
        cli_put(w, g->amplitude);
        cli_put(w, (double)g->n);
        for (int q = 0; q < AMPLITUDE_QUANTITIES; q++) {
            cli_put(w, g->sum[q] / (double)g->n);
            if (q < WITH_ERRORS)
                cli_put(w, mean_error(g, q));
        }
        cli_end_row(w);
    }
}

/* ---- fronts at planes, and the solitary waves of chains beside them --------------------------------------------- */

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

void amplitude_plane_columns(cli_writer *w) {
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
    cli_put(w, e.solitary);
    cli_put(w, e.kdv);
    cli_put(w, e.nesterenko);
    cli_end_row(w);
}

void amplitude_plane_rows(const cli_file *file, const sp_amplitude_options *o, double amplitude, int32_t planes,
                          cli_writer *w) {
    double *height = sp_alloc((size_t)planes, sizeof *height);
    sp_amplitude_plane *plane = sp_alloc((size_t)planes, sizeof *plane);
    if (!height || !plane)
        w->status = sp_fail_memory(w->err, (size_t)planes * (sizeof *height + sizeof *plane));
    for (int32_t b = 0; b < planes && w->status == SP_OK; b++)
        height[b] = sp_packing_height(&file->packing) * (b + 1) / (planes + 1);
    if (w->status == SP_OK)
        w->status = sp_amplitude_planes(&file->packing, o, amplitude, planes, height, plane, NULL, w->err);
    for (int32_t b = 0; b < planes && w->status == SP_OK; b++)
        add_plane(file, amplitude, &plane[b], w);
    sp_free(plane);
    sp_free(height);
}

/* ---- harmonics of bursts ---------------------------------------------------------------------------------------- */

void amplitude_burst_columns(bool planes, cli_writer *w) {
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
    cli_put(w, delta * s->beta.value);
    cli_put(w, delta * s->beta.error);
    cli_put(w, field_beta(p, s->speed.value));
    cli_put(w, s->energy.defect);
    cli_put(w, s->step);
}

void amplitude_burst_rows(const cli_file *file, const sp_amplitude_options *o, const sp_amplitude_burst *burst,
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
