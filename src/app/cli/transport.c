/* Adds up the quantities of `transport` over packings, and prints their means. */
#include "cli/transport.h"

#include "base/base.h"

#include <math.h>
#include <stdio.h>

/* ---- means ------------------------------------------------------------------------------------------------------ */

void transport_add(transport_mean *m, double value, double error) {
    if (isnan(value))
        return;
    m->n++;
    m->sum += value;
    m->squares += value * value;
    m->own = error;
}

double transport_value(const transport_mean *m) { return m->n > 0 && !m->few ? m->sum / (double)m->n : NAN; }

double transport_error(const transport_mean *m) {
    const double n = (double)m->n;
    if (m->few)
        return NAN;
    if (m->n == 1)
        return m->own;
    return m->n > 1 ? sqrt(fmax(0, m->squares - m->sum * m->sum / n) / (n - 1) / n) : NAN;
}

/* ---- one packing ------------------------------------------------------------------------------------------------ */

/* The values of each quantity, in this order. */
enum { SPREAD_D = 0, SPREAD_SHIFT, SPREAD_HALF, SPREAD_FROM, SPREAD_TO };
enum { KUBO_D = 0, KUBO_SHIFT, KUBO_SPEED, KUBO_PATH };
enum { COHERENT_K = 0, COHERENT_ALPHA, COHERENT_PART };
enum { SPLIT_PULSE = 5, SPLIT_KINDS = 10 };

static transport_mean *means_at(const transport_arguments *a, int32_t l) {
    return a->mean + (int64_t)l * TRANSPORT_VALUES;
}

/* The axis of the core's options: -1 stands for the default. */
static int axis_of(const transport_arguments *a) { return a->axis - 1; }

/* What becomes of a frequency that is refused, such as one without modes: it has no value, but others may. The reason
 * counts if it is that of all. */
static sp_status pass_over(const transport_arguments *a, int32_t l, int32_t *left, sp_status status, sp_error *err) {
    if (status != SP_EREFUSED || --*left == 0)
        return status;
    cli_note(&a->common, "omega = %g has no value: %s", a->omega[l], err->text);
    return SP_OK;
}

static void add_spread(const sp_spread *s, transport_mean *m) {
    transport_add(&m[SPREAD_D], s->d, s->d_err);
    transport_add(&m[SPREAD_SHIFT], s->d_shift, NAN);
    transport_add(&m[SPREAD_HALF], s->d_half, NAN);
    transport_add(&m[SPREAD_FROM], s->from, NAN);
    transport_add(&m[SPREAD_TO], s->to, NAN);
}

static sp_status measure_spread(transport_arguments *a, const sp_network *net, sp_error *err) {
    sp_spread_options o = sp_spread_options_default();
    sp_status status = SP_OK;
    o.axis = axis_of(a);
    o.width = a->width;
    o.waves = (int32_t)a->waves;
    o.sources = (int32_t)a->sources;
    o.seed = (uint64_t)a->seed;
    o.until = a->until;
    for (int32_t l = 0, left = a->n; l < a->n && status == SP_OK; l++) {
        transport_mean *m = means_at(a, l);
        sp_spread s;
        status = sp_spread_make(net, a->omega[l], &o, &s, err);
        if (status != SP_OK)
            status = pass_over(a, l, &left, status, err);
        else if (!isnan(s.d))
            add_spread(&s, m);
    }
    return status;
}

static void add_kubo(transport_arguments *a, const sp_kubo *k, transport_mean *m) {
    const double path = a->dim * k->d / k->speed;
    transport_add(&m[KUBO_D], k->d, k->d_err);
    transport_add(&m[KUBO_SHIFT], k->d_shift, NAN);
    transport_add(&m[KUBO_SPEED], k->speed, k->speed_err);
    transport_add(&m[KUBO_PATH], path, path * hypot(k->d_err / k->d, k->speed_err / k->speed));
}

static sp_status measure_kubo(transport_arguments *a, const sp_network *net, sp_error *err) {
    sp_kubo_options o = sp_kubo_options_default();
    const sp_modes_options mo = sp_modes_options_default();
    sp_modes modes = sp_modes_none();
    sp_kubo *k = sp_alloc((size_t)a->n, sizeof *k);
    sp_status status = k ? SP_OK : sp_fail_memory(err, (size_t)a->n * sizeof *k);
    o.axis = axis_of(a);
    o.width = a->width;
    o.smear = a->smear;
    if (status == SP_OK)
        status = sp_modes_dense(net, &mo, &modes, err);
    if (status == SP_OK)
        status = sp_kubo_make(net, &modes, a->n, a->omega, &o, k, err);
    for (int32_t l = 0; l < a->n && status == SP_OK; l++)
        add_kubo(a, &k[l], means_at(a, l));
    sp_modes_free(&modes);
    sp_free(k);
    return status;
}

/* The error of k and of alpha, in one packing, from what the wave does not explain: that of a least-squares fit to
 * fluxes that are independent at planes a diameter apart. The weight of a plane in it is the square of the wave. */
static double fit_error(const sp_coherent_section *s, const sp_coherent_wave *c) {
    const double low = s->y[0], span = s->y[s->planes - 1] - low;
    double sum = 0, first = 0, second = 0;
    for (int32_t b = 0; b < s->planes; b++) {
        const double y = s->y[b] - low, weight = exp(-2 * c->alpha * y);
        sum += weight;
        first += weight * y;
        second += weight * y * y;
    }
    const double variance = second / sum - first * first / (sum * sum), count = fmin(s->planes, 1 + span);
    return sqrt((1 - c->part) / (2 * c->part * count * variance));
}

/* The own errors of a fit are what half of the time after the front changes, and what scattered waves do. Below
 * omega = 0.4 they agree with the standard deviation over 12 packings within a factor of two (docs/transport.md). */
static sp_status measure_coherent(transport_arguments *a, const sp_network *net, sp_error *err) {
    sp_coherent_section s = sp_coherent_section_none();
    sp_status status = sp_coherent_section_make(net, &a->section, &s, err);
    for (int32_t l = 0; l < a->n && status == SP_OK; l++) {
        transport_mean *m = means_at(a, l);
        sp_coherent_wave c;
        status = sp_coherent_fit(&s, a->omega[l], &c, err);
        if (status != SP_OK || isnan(c.k) || !(c.part >= 0.5)) /* most of the motion is scattered */
            continue;
        const double error = fit_error(&s, &c);
        transport_add(&m[COHERENT_K], c.k, hypot(c.k_shift, error));
        transport_add(&m[COHERENT_ALPHA], c.alpha, hypot(c.alpha_shift, error));
        transport_add(&m[COHERENT_PART], c.part, NAN);
    }
    sp_coherent_section_free(&s);
    return status;
}

static void add_energy(const sp_energy *e, const sp_energy *error, transport_mean *m) {
    transport_add(&m[0], e->along, error->along);
    transport_add(&m[1], e->across, error->across);
    transport_add(&m[2], e->rotation, error->rotation);
    transport_add(&m[3], e->normal, error->normal);
    transport_add(&m[4], e->tangential, error->tangential);
}

static sp_status measure_split(transport_arguments *a, const sp_network *net, sp_error *err) {
    sp_split_options o = sp_split_options_default();
    sp_status status = SP_OK;
    o.width = a->width;
    o.sources = (int32_t)a->sources;
    o.seed = (uint64_t)a->seed;
    for (int32_t l = 0, left = a->n; l < a->n && status == SP_OK; l++) {
        sp_split s;
        status = sp_split_make(net, a->omega[l], &o, &s, err);
        if (status != SP_OK) {
            status = pass_over(a, l, &left, status, err);
            continue;
        }
        add_energy(&s.rest, &s.rest_err, means_at(a, l));
        add_energy(&s.pulse, &s.pulse_err, means_at(a, l) + SPLIT_PULSE);
    }
    return status;
}

/* Planes at quarters of the height, and equally spaced times up to a.until, which the first packing sets. */
enum { BURST_TIMES = 24, BURST_PLANES = 3, BURST_VALUES = 5 };
static const double ROUNDING = 1e-11; /* of parts of the energy, by tests; the drift is that of all of it */
enum { BURST_BELOW = 0, BURST_FLUX, BURST_NORMAL, BURST_SIDEWAYS, BURST_ROTATION };
static const int burst_most =
    TRANSPORT_FREQUENCIES_MAX * TRANSPORT_VALUES / (BURST_TIMES * BURST_PLANES * BURST_VALUES);

static transport_mean *burst_means(const transport_arguments *a, int32_t l, int row) {
    return a->mean + ((int64_t)l * BURST_TIMES * BURST_PLANES + row) * BURST_VALUES;
}

static double burst_time(const transport_arguments *a, int k) { return a->until * (k + 1) / BURST_TIMES; }

/* The flux of an energy 1 is at most about the highest frequency, and so are its rounding errors beside those of the
 * energy. */
static void add_burst(const double *below, const sp_flux *flux, double drift, double highest, transport_mean *m) {
    const double error = highest * drift;
    transport_add(&m[BURST_BELOW], *below, drift);
    transport_add(&m[BURST_FLUX], sp_flux_sum(flux), error);
    transport_add(&m[BURST_NORMAL], flux->normal, error);
    transport_add(&m[BURST_SIDEWAYS], flux->sideways, error);
    transport_add(&m[BURST_ROTATION], flux->rotation, error);
}

static sp_status measure_energy(transport_arguments *a, const sp_network *net, sp_error *err) {
    double t[BURST_TIMES], height[BURST_PLANES], below[BURST_TIMES * BURST_PLANES], drift = 0;
    sp_flux flux[BURST_TIMES * BURST_PLANES];
    sp_status status = SP_OK;
    const double top = net->box[net->dim - 1];
    if (a->n > burst_most)
        return sp_fail(err, SP_EINVAL, "--at: %d frequencies, energy takes at most %d", a->n, burst_most);
    if (!(a->until > 0))
        a->until = sp_signal_window(top, net->pressure);
    for (int k = 0; k < BURST_TIMES; k++)
        t[k] = burst_time(a, k);
    for (int k = 0; k < BURST_PLANES; k++)
        height[k] = top * (k + 1) / (BURST_PLANES + 1);
    for (int32_t l = 0, left = a->n; l < a->n && status == SP_OK; l++) {
        const sp_burst_options o = {a->omega[l], a->width, BURST_TIMES, t, BURST_PLANES, height};
        status = sp_burst_make(net, &o, below, flux, &drift, err);
        if (status != SP_OK) {
            status = pass_over(a, l, &left, status, err);
            continue;
        }
        drift += ROUNDING;
        for (int row = 0; row < BURST_TIMES * BURST_PLANES; row++)
            add_burst(&below[row], &flux[row], drift, sp_network_omega_bound(net), burst_means(a, l, row));
    }
    return status;
}

sp_status transport_measure(transport_arguments *a, const sp_network *net, sp_error *err) {
    switch (a->quantity) {
    case TRANSPORT_KUBO: return measure_kubo(a, net, err);
    case TRANSPORT_COHERENT: return measure_coherent(a, net, err);
    case TRANSPORT_SPLIT: return measure_split(a, net, err);
    case TRANSPORT_ENERGY: return measure_energy(a, net, err);
    default: return measure_spread(a, net, err);
    }
}

/* ---- rows ------------------------------------------------------------------------------------------------------- */

static void print_spread(const transport_arguments *a, cli_writer *w) {
    cli_columns(w, SP_CELL_NUMBER, "omega", "sqrt(E* / rho)/d", "D", "d sqrt(E* / rho)", "D_err", "d sqrt(E* / rho)",
                "shift", "d sqrt(E* / rho)", "half", "d sqrt(E* / rho)", "from", "d/sqrt(E* / rho)", "to",
                "d/sqrt(E* / rho)", NULL);
    cli_columns(w, SP_CELL_INTEGER, "samples", "", NULL);
    for (int32_t l = 0; l < a->n && w->status == SP_OK; l++) {
        const transport_mean *m = means_at(a, l);
        w->status = sp_table_add_row(w->table, w->err, a->omega[l], transport_value(&m[SPREAD_D]),
                                     transport_error(&m[SPREAD_D]), transport_value(&m[SPREAD_SHIFT]),
                                     transport_value(&m[SPREAD_HALF]), transport_value(&m[SPREAD_FROM]),
                                     transport_value(&m[SPREAD_TO]), m[SPREAD_D].n);
    }
}

static void print_kubo(const transport_arguments *a, cli_writer *w) {
    cli_columns(w, SP_CELL_NUMBER, "omega", "sqrt(E* / rho)/d", "D", "d sqrt(E* / rho)", "D_err", "d sqrt(E* / rho)",
                "shift", "d sqrt(E* / rho)", "speed", "sqrt(E* / rho)", "speed_err", "sqrt(E* / rho)", "path", "d",
                "path_err", "d", NULL);
    cli_columns(w, SP_CELL_INTEGER, "samples", "", NULL);
    for (int32_t l = 0; l < a->n && w->status == SP_OK; l++) {
        const transport_mean *m = means_at(a, l);
        w->status = sp_table_add_row(w->table, w->err, a->omega[l], transport_value(&m[KUBO_D]),
                                     transport_error(&m[KUBO_D]), transport_value(&m[KUBO_SHIFT]),
                                     transport_value(&m[KUBO_SPEED]), transport_error(&m[KUBO_SPEED]),
                                     transport_value(&m[KUBO_PATH]), transport_error(&m[KUBO_PATH]), m[KUBO_D].n);
    }
}

/* The mean free path of the mean attenuation; only a bound if that is within two errors of 0. */
typedef struct free_path {
    double path, path_err, low, k_path, k_path_err;
} free_path;

static free_path path_of(const transport_mean *m) {
    const double k = transport_value(&m[COHERENT_K]), k_err = transport_error(&m[COHERENT_K]);
    const double alpha = transport_value(&m[COHERENT_ALPHA]), error = transport_error(&m[COHERENT_ALPHA]);
    free_path p = {NAN, NAN, 0.5 / (fmax(0, alpha) + 2 * error), NAN, NAN};
    if (alpha > 2 * error) {
        p.path = 0.5 / alpha;
        p.path_err = p.path * error / alpha;
        p.k_path = k * p.path;
        p.k_path_err = p.k_path * hypot(k_err / k, error / alpha);
    }
    return p;
}

/* Where the mean free path has fallen to half a wavelength, k path = pi (Ioffe and Regel), between two frequencies of
 * the table. */
static void note_ioffe_regel(const transport_arguments *a, cli_writer *w) {
    for (int32_t l = 1; l < a->n; l++) {
        const free_path one = path_of(means_at(a, l - 1)), two = path_of(means_at(a, l));
        if (!(one.k_path > M_PI && two.k_path <= M_PI))
            continue;
        const double part = (one.k_path - M_PI) / (one.k_path - two.k_path), step = a->omega[l] - a->omega[l - 1];
        const double error = hypot((1 - part) * one.k_path_err, part * two.k_path_err);
        cli_value(w, "ioffe_regel", a->omega[l - 1] + part * step);
        cli_value(w, "ioffe_regel_err", error * step / (one.k_path - two.k_path));
        return;
    }
}

static void print_coherent(const transport_arguments *a, cli_writer *w) {
    note_ioffe_regel(a, w);
    cli_columns(w, SP_CELL_NUMBER, "omega", "sqrt(E* / rho)/d", "k", "1/d", "k_err", "1/d", "alpha", "1/d", "alpha_err",
                "1/d", "path", "d", "path_err", "d", "path_low", "d", "k_path", "", "k_path_err", "", "part", "", NULL);
    cli_columns(w, SP_CELL_INTEGER, "samples", "", NULL);
    for (int32_t l = 0; l < a->n && w->status == SP_OK; l++) {
        const transport_mean *m = means_at(a, l);
        const free_path p = path_of(m);
        w->status = sp_table_add_row(w->table, w->err, a->omega[l], transport_value(&m[COHERENT_K]),
                                     transport_error(&m[COHERENT_K]), transport_value(&m[COHERENT_ALPHA]),
                                     transport_error(&m[COHERENT_ALPHA]), p.path, p.path_err, p.low, p.k_path,
                                     p.k_path_err, transport_value(&m[COHERENT_PART]), m[COHERENT_K].n);
    }
}

static void print_split(const transport_arguments *a, cli_writer *w) {
    static const char *const names[SPLIT_KINDS] = {"along",        "across",          "rotation",     "normal",
                                                   "tangential",   "pulse_along",     "pulse_across", "pulse_rotation",
                                                   "pulse_normal", "pulse_tangential"};
    double row[2 * SPLIT_KINDS + 2];
    char error[40];
    cli_columns(w, SP_CELL_NUMBER, "omega", "sqrt(E* / rho)/d", NULL);
    for (int k = 0; k < SPLIT_KINDS; k++) {
        snprintf(error, sizeof error, "%s_err", names[k]);
        cli_columns(w, SP_CELL_NUMBER, names[k], "", error, "", NULL);
    }
    cli_columns(w, SP_CELL_INTEGER, "samples", "", NULL);
    for (int32_t l = 0; l < a->n && w->status == SP_OK; l++) {
        const transport_mean *m = means_at(a, l);
        row[0] = a->omega[l];
        for (int k = 0; k < SPLIT_KINDS; k++) {
            row[1 + 2 * k] = transport_value(&m[k]);
            row[2 + 2 * k] = transport_error(&m[k]);
        }
        row[2 * SPLIT_KINDS + 1] = (double)m->n;
        w->status = sp_table_add_numbers(w->table, row, w->err);
    }
}

static void print_energy(const transport_arguments *a, cli_writer *w) {
    static const char *const names[BURST_VALUES] = {"below", "flux", "flux_normal", "flux_sideways", "flux_rotation"};
    double row[2 * BURST_VALUES + 4];
    char error[40];
    cli_columns(w, SP_CELL_NUMBER, "omega", "sqrt(E* / rho)/d", "t", "d/sqrt(E* / rho)", "plane", "", NULL);
    for (int k = 0; k < BURST_VALUES; k++) {
        const char *unit = k == BURST_BELOW ? "" : "sqrt(E* / rho)/d";
        snprintf(error, sizeof error, "%s_err", names[k]);
        cli_columns(w, SP_CELL_NUMBER, names[k], unit, error, unit, NULL);
    }
    cli_columns(w, SP_CELL_INTEGER, "samples", "", NULL);
    for (int32_t q = 0; q < a->n * BURST_TIMES * BURST_PLANES && w->status == SP_OK; q++) {
        const int32_t l = q / (BURST_TIMES * BURST_PLANES), at = q % (BURST_TIMES * BURST_PLANES);
        const transport_mean *m = burst_means(a, l, at);
        row[0] = a->omega[l];
        row[1] = burst_time(a, at / BURST_PLANES);
        row[2] = (at % BURST_PLANES + 1.0) / (BURST_PLANES + 1);
        for (int k = 0; k < BURST_VALUES; k++) {
            row[3 + 2 * k] = transport_value(&m[k]);
            row[4 + 2 * k] = transport_error(&m[k]);
        }
        row[2 * BURST_VALUES + 3] = (double)m->n;
        w->status = sp_table_add_numbers(w->table, row, w->err);
    }
}

void transport_print(transport_arguments *a, cli_writer *w) {
    for (int32_t k = 0; k < TRANSPORT_FREQUENCIES_MAX * TRANSPORT_VALUES; k++)
        a->mean[k].few = 2 * a->mean[k].n < a->common.files;
    switch (a->quantity) {
    case TRANSPORT_KUBO: print_kubo(a, w); break;
    case TRANSPORT_COHERENT: print_coherent(a, w); break;
    case TRANSPORT_SPLIT: print_split(a, w); break;
    case TRANSPORT_ENERGY: print_energy(a, w); break;
    default: print_spread(a, w); break;
    }
}
