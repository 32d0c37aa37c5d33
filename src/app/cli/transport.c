/* Adds up the quantities of `transport` over packings, and prints their means. */
#include "cli/transport.h"

#include "base/base.h"

#include <math.h>

/* ---- means ------------------------------------------------------------------------------------------------------ */

void transport_add(transport_mean *m, double value, double error) {
    if (isnan(value))
        return;
    m->n++;
    m->sum += value;
    m->squares += value * value;
    m->own = error;
}

double transport_value(const transport_mean *m) { return m->n > 0 ? m->sum / (double)m->n : NAN; }

double transport_error(const transport_mean *m) {
    const double n = (double)m->n;
    if (m->n == 1)
        return m->own;
    return m->n > 1 ? sqrt(fmax(0, m->squares - m->sum * m->sum / n) / (n - 1) / n) : NAN;
}

/* ---- one packing ------------------------------------------------------------------------------------------------ */

/* The values of each quantity, in this order. */
enum { SPREAD_D = 0, SPREAD_SHIFT, SPREAD_HALF, SPREAD_FROM, SPREAD_TO };
enum { KUBO_D = 0, KUBO_SHIFT, KUBO_SPEED, KUBO_PATH };
enum { COHERENT_K = 0, COHERENT_ALPHA, COHERENT_PART };

static transport_mean *means_at(const transport_arguments *a, int32_t l) {
    return a->mean + (int64_t)l * TRANSPORT_VALUES;
}

/* The axis of the core's options: -1 stands for the default. */
static int axis_of(const transport_arguments *a) { return a->axis - 1; }

static sp_status measure_spread(transport_arguments *a, const sp_network *net, sp_error *err) {
    sp_spread_options o = sp_spread_options_default();
    sp_status status = SP_OK;
    o.axis = axis_of(a);
    o.width = a->width;
    o.waves = (int32_t)a->waves;
    o.sources = (int32_t)a->sources;
    o.seed = (uint64_t)a->seed;
    o.until = a->until;
    for (int32_t l = 0; l < a->n && status == SP_OK; l++) {
        transport_mean *m = means_at(a, l);
        sp_spread s;
        status = sp_spread_make(net, a->omega[l], &o, &s, err);
        if (status != SP_OK || isnan(s.d))
            continue;
        transport_add(&m[SPREAD_D], s.d, s.d_err);
        transport_add(&m[SPREAD_SHIFT], s.d_shift, NAN);
        transport_add(&m[SPREAD_HALF], s.d_half, NAN);
        transport_add(&m[SPREAD_FROM], s.from, NAN);
        transport_add(&m[SPREAD_TO], s.to, NAN);
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

/* The own errors of a fit are what half of the time after the front changes. */
static sp_status measure_coherent(transport_arguments *a, const sp_network *net, sp_error *err) {
    sp_coherent_section s = sp_coherent_section_none();
    sp_status status = sp_coherent_section_make(net, &a->section, &s, err);
    for (int32_t l = 0; l < a->n && status == SP_OK; l++) {
        transport_mean *m = means_at(a, l);
        sp_coherent_wave c;
        status = sp_coherent_fit(&s, a->omega[l], &c, err);
        if (status != SP_OK || !(c.part >= 0.5)) /* most of the motion is scattered */
            continue;
        transport_add(&m[COHERENT_K], c.k, fabs(c.k_shift));
        transport_add(&m[COHERENT_ALPHA], c.alpha, fabs(c.alpha_shift));
        transport_add(&m[COHERENT_PART], c.part, NAN);
    }
    sp_coherent_section_free(&s);
    return status;
}

sp_status transport_measure(transport_arguments *a, const sp_network *net, sp_error *err) {
    switch (a->quantity) {
    case TRANSPORT_KUBO: return measure_kubo(a, net, err);
    case TRANSPORT_COHERENT: return measure_coherent(a, net, err);
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

static void print_coherent(const transport_arguments *a, cli_writer *w) {
    cli_columns(w, SP_CELL_NUMBER, "omega", "sqrt(E* / rho)/d", "k", "1/d", "k_err", "1/d", "alpha", "1/d", "alpha_err",
                "1/d", "path", "d", "path_err", "d", "path_low", "d", "k_path", "", "k_path_err", "", "part", "", NULL);
    cli_columns(w, SP_CELL_INTEGER, "samples", "", NULL);
    for (int32_t l = 0; l < a->n && w->status == SP_OK; l++) {
        static const transport_mean nothing[TRANSPORT_VALUES];
        /* a wave that few of the packings have is none of the material */
        const bool found = 2 * means_at(a, l)->n >= a->common.files;
        const transport_mean *m = found ? means_at(a, l) : nothing;
        const free_path p = path_of(m);
        w->status = sp_table_add_row(w->table, w->err, a->omega[l], transport_value(&m[COHERENT_K]),
                                     transport_error(&m[COHERENT_K]), transport_value(&m[COHERENT_ALPHA]),
                                     transport_error(&m[COHERENT_ALPHA]), p.path, p.path_err, p.low, p.k_path,
                                     p.k_path_err, transport_value(&m[COHERENT_PART]), means_at(a, l)->n);
    }
}

void transport_print(transport_arguments *a, cli_writer *w) {
    switch (a->quantity) {
    case TRANSPORT_KUBO: print_kubo(a, w); break;
    case TRANSPORT_COHERENT: print_coherent(a, w); break;
    default: print_spread(a, w); break;
    }
}
