/* Fills the table of sonopack spectrum harmonic: the response to harmonic driving. */
#include "base/base.h"
#include "cli/excitation.h"
#include "cli/spectrum.h"

#include <math.h>
#include <stdio.h>

static void add_responses(const sp_harmonic *h, cli_writer *w) {
    cli_columns(w, SP_COLUMN_NUMBER, "omega", SPECTRUM_FREQUENCY, "magnitude", SPECTRUM_RESPONSE, "re",
                SPECTRUM_RESPONSE, "im", SPECTRUM_RESPONSE, "error", SPECTRUM_RESPONSE, "k", "1/d", "k_err", "1/d",
                "speed", "sqrt(E* / rho)", "speed_err", "sqrt(E* / rho)", "alpha", "1/d", "alpha_err", "1/d", "misfit",
                "", "Q", "", "Q_err", "", NULL);
    for (int32_t l = 0; l < h->n && w->status == SP_OK; l++) {
        const sp_wave_fit *fit = &h->fit[l];
        const bool travels = fit->k > 3 * fit->k_err; /* else it only decays, and has no speed */
        const double *f = h->f + 2 * l, speed = travels ? h->omega[l] / fit->k : NAN;
        double q, q_err;
        sp_wave_quality(fit->k, fit->k_err, fit->alpha, fit->alpha_err, &q, &q_err);
        w->status = sp_table_add_row(w->table, w->err, h->omega[l], hypot(f[0], f[1]), f[0], f[1], h->error[l], fit->k,
                                     fit->k_err, speed, speed * fit->k_err / fit->k, fit->alpha, fit->alpha_err,
                                     fit->misfit, q, q_err);
    }
}

static void add_profile(const sp_harmonic *h, cli_writer *w) {
    cli_columns(w, SP_COLUMN_NUMBER, "omega", SPECTRUM_FREQUENCY, "height", "d", "magnitude", SPECTRUM_RESPONSE, "re",
                SPECTRUM_RESPONSE, "im", SPECTRUM_RESPONSE, "error", SPECTRUM_RESPONSE, NULL);
    for (int32_t l = 0; l < h->n; l++)
        for (int32_t k = 0; k < h->planes && w->status == SP_OK; k++) {
            const int64_t at = (int64_t)l * h->planes + k;
            const double *f = h->flux + 2 * at;
            w->status = sp_table_add_row(w->table, w->err, h->omega[l], h->height[k], hypot(f[0], f[1]), f[0], f[1],
                                         h->flux_error[at]);
        }
}

static sp_status set_options(const spectrum_arguments *a, const sp_network *net, double *omega, sp_harmonic_options *o,
                             sp_error *err) {
    *o = sp_harmonic_options_default();
    o->keep = true;
    o->source = (sp_source)a->source;
    o->omega = omega;
    if (a->damping.value >= 0) {
        o->damping = a->damping.value;
        o->damping_kind = a->damping.kind;
        o->damping_ratio = a->damping.ratio;
    }
    if (a->layers >= 0)
        o->planes = (int32_t)a->layers - 1;
    if (a->tolerance >= 0)
        o->tolerance = a->tolerance;
    if (!isnan(a->range[0])) {
        o->range[0] = a->range[0];
        o->range[1] = a->range[1];
    }
    if (a->at)
        return cli_frequencies(a->at, SPECTRUM_FREQUENCIES_MAX, &o->n, omega, err);
    for (o->n = 0; o->n < SPECTRUM_FREQUENCIES; o->n++)
        omega[o->n] = sp_network_omega_bound(net) * (o->n + 1) / SPECTRUM_FREQUENCIES;
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

static sp_status add_rows(const spectrum_arguments *a, cli_file *file, const sp_harmonic_options *o, sp_table *t,
                          sp_error *err) {
    sp_harmonic h = sp_harmonic_none();
    cli_writer w = {.table = t, .err = err, .status = sp_harmonic_make(&file->network, o, &h, err)};
    const sp_damping law = {.kind = o->damping_kind, .value = o->damping, .ratio = o->damping_ratio};
    report_refused(&h, file, &w);
    cli_comment(&w, "source = %s", cli_source_names[o->source]);
    cli_damping_comment(&w, &law);
    cli_value(&w, "height", sp_packing_height(&file->packing));
    cli_value(&w, "planes", h.planes);
    cli_value(&w, "tolerance", o->tolerance);
    if (!a->profile && lacks_a_fit(&h))
        cli_comment(&w, "nan: no wave could be fitted to the planes");
    if (a->profile)
        add_profile(&h, &w);
    else
        add_responses(&h, &w);
    sp_harmonic_free(&h);
    return w.status;
}

sp_status spectrum_harmonic(const spectrum_arguments *a, cli_file *file, sp_table *t, sp_error *err) {
    sp_harmonic_options o;
    double *omega = sp_alloc(SPECTRUM_FREQUENCIES_MAX, sizeof *omega);
    sp_status status = omega ? SP_OK : sp_fail_memory(err, SPECTRUM_FREQUENCIES_MAX * sizeof *omega);
    if (status == SP_OK)
        status = set_options(a, &file->network, omega, &o, err);
    if (status == SP_OK)
        status = add_rows(a, file, &o, t, err);
    sp_free(omega);
    return status;
}
