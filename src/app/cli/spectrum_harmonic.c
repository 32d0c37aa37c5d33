/* sonopack spectrum harmonic. */
#include "base/base.h"
#include "cli/spectrum.h"

#include <math.h>
#include <string.h>

enum { FREQUENCIES_MAX = 100000 };

static sp_status put_responses(const sp_harmonic *h, sp_table *t, sp_error *err) {
    static const char *const columns[] = {"omega",     SPECTRUM_FREQUENCY,
                                          "magnitude", SPECTRUM_RESPONSE,
                                          "re",        SPECTRUM_RESPONSE,
                                          "im",        SPECTRUM_RESPONSE,
                                          "error",     SPECTRUM_RESPONSE,
                                          "k",         "1/d",
                                          "k_err",     "1/d",
                                          "speed",     "sqrt(E* / rho)",
                                          "speed_err", "sqrt(E* / rho)",
                                          "alpha",     "1/d",
                                          "alpha_err", "1/d",
                                          "misfit",    "",
                                          NULL};
    sp_status status = cli_add_columns(t, columns, err);
    for (int32_t l = 0; l < h->n && status == SP_OK; l++) {
        const sp_wave_fit *w = &h->fit[l];
        const double *f = h->f + 2 * l, speed = h->omega[l] / w->k;
        status = sp_table_add_row(t, err, h->omega[l], hypot(f[0], f[1]), f[0], f[1], h->error[l], w->k, w->k_err,
                                  speed, speed * w->k_err / w->k, w->alpha, w->alpha_err, w->misfit);
    }
    return status;
}

static sp_status put_profile(const sp_harmonic *h, sp_table *t, sp_error *err) {
    static const char *const columns[] = {"omega",     SPECTRUM_FREQUENCY, "height", "d",
                                          "magnitude", SPECTRUM_RESPONSE,  "re",     SPECTRUM_RESPONSE,
                                          "im",        SPECTRUM_RESPONSE,  "error",  SPECTRUM_RESPONSE,
                                          NULL};
    sp_status status = cli_add_columns(t, columns, err);
    for (int32_t l = 0; l < h->n; l++)
        for (int32_t k = 0; k < h->planes && status == SP_OK; k++) {
            const int64_t at = (int64_t)l * h->planes + k;
            const double *f = h->flux + 2 * at;
            status =
                sp_table_add_row(t, err, h->omega[l], h->height[k], hypot(f[0], f[1]), f[0], f[1], h->flux_error[at]);
        }
    return status;
}

static sp_status set_options(const spectrum_arguments *a, const sp_network *net, double *omega, sp_harmonic_options *o,
                             sp_error *err) {
    sp_status status = SP_OK;
    *o = sp_harmonic_options_default();
    o->source = a->source;
    o->omega = omega;
    if (a->damping >= 0)
        o->damping = a->damping;
    if (a->layers >= 0)
        o->planes = (int32_t)a->layers - 1;
    if (a->tolerance >= 0)
        o->tolerance = a->tolerance;
    if (!isnan(a->range[0])) {
        o->range[0] = a->range[0];
        o->range[1] = a->range[1];
    }
    if (a->at)
        status = cli_frequencies(a->at, FREQUENCIES_MAX, &o->n, omega, err);
    else
        for (o->n = 0; o->n < 20; o->n++)
            omega[o->n] = sp_network_omega_bound(net) * (o->n + 1) / 20;
    return status;
}

sp_status spectrum_harmonic(const spectrum_arguments *a, const sp_packing *p, const sp_network *net, sp_table *t,
                            sp_error *err) {
    sp_harmonic_options o;
    sp_harmonic h = sp_harmonic_none();
    double *omega = sp_alloc(FREQUENCIES_MAX, sizeof *omega);
    sp_status status = omega ? SP_OK : sp_fail_memory(err, FREQUENCIES_MAX * sizeof *omega);
    if (status == SP_OK)
        status = set_options(a, net, omega, &o, err);
    if (status == SP_OK)
        status = sp_harmonic_make(net, &o, &h, err);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "source = %s", cli_source_name(o.source));
    if (status == SP_OK)
        status = cli_add_number(t, "damping", o.damping, err);
    if (status == SP_OK)
        status = cli_add_number(t, "height", sp_packing_height(p), err);
    if (status == SP_OK)
        status = cli_add_number(t, "planes", h.planes, err);
    if (status == SP_OK)
        status = cli_add_number(t, "tolerance", o.tolerance, err);
    for (int32_t l = 0; l < h.n && !a->profile && status == SP_OK; l++)
        if (isnan(h.fit[l].k)) {
            status = sp_table_add_comment(t, err, "nan: no wave could be fitted to the planes");
            break;
        }
    if (status == SP_OK)
        status = a->profile ? put_profile(&h, t, err) : put_responses(&h, t, err);
    sp_harmonic_free(&h);
    sp_free(omega);
    return status;
}
