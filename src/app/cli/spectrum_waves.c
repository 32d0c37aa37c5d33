/* sonopack spectrum transmission, dispersion and participation. */
#include "base/base.h"
#include "cli/spectrum.h"

#include <math.h>
#include <string.h>

/* Lines: every mode with its weight in the signal. */
static sp_status lines(const spectrum_arguments *a, const sp_network *net, sp_table *t, sp_error *err) {
    static const char *const columns[] = {"omega", SPECTRUM_FREQUENCY, "ab", "E* d^2", "share", "", NULL};
    const sp_modes_options o = {.vectors = true, .source = a->source};
    sp_modes m = sp_modes_none();
    double all = 0, sum = 0;
    sp_status status = sp_modes_dense(net, &o, &m, err);
    if (status == SP_OK)
        status = sp_table_add_column(t, "n", "", SP_CELL_INTEGER, err);
    if (status == SP_OK)
        status = cli_add_columns(t, columns, err);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "source = %s", cli_source_name(a->source));
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "share: of the sum of |ab| over all modes, up to this one");
    for (int64_t k = 0; k < m.n && status == SP_OK; k++)
        all += fabs(m.a[k] * m.b[k]);
    for (int64_t k = m.n_rattler; k < m.n && status == SP_OK; k++) {
        sum += fabs(m.a[k] * m.b[k]);
        status = sp_table_add_row(t, err, k, m.omega[k], m.a[k] * m.b[k], all > 0 ? sum / all : 0.0);
    }
    sp_modes_free(&m);
    return status;
}

sp_status spectrum_transmission(const spectrum_arguments *a, const sp_packing *p, const sp_network *net, sp_table *t,
                                sp_error *err) {
    static const char *const columns[] = {"omega",     SPECTRUM_FREQUENCY, "density", SPECTRUM_RESPONSE,
                                          "magnitude", SPECTRUM_RESPONSE,  "re",      SPECTRUM_RESPONSE,
                                          "im",        SPECTRUM_RESPONSE,  "error",   SPECTRUM_RESPONSE,
                                          NULL};
    sp_transmission_options o = sp_transmission_options_default();
    sp_transmission s = sp_transmission_none();
    (void)p;
    if (a->lines && (a->bins >= 0 || a->until >= 0 || a->resolution >= 0))
        return sp_fail(err, SP_EINVAL, "--lines: must be without --bins, --until and --resolution");
    if (a->lines)
        return lines(a, net, t, err);
    o.source = a->source;
    if (a->bins >= 0)
        o.points = (int32_t)a->bins;
    if (a->until >= 0)
        o.until = a->until;
    if (a->resolution >= 0)
        o.resolution = a->resolution;
    sp_status status = sp_transmission_make(net, &o, &s, err);
    if (status == SP_OK)
        status = cli_add_columns(t, columns, err);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "source = %s", cli_source_name(a->source));
    if (status == SP_OK)
        status = cli_add_number(t, "resolution", s.resolution, err);
    if (status == SP_OK)
        status = cli_add_number(t, "omega_max", s.omega_max, err);
    if (status == SP_OK)
        status = cli_add_number(t, "moments", (double)s.moments, err);
    for (int32_t l = 0; l < s.n && status == SP_OK; l++)
        status =
            sp_table_add_row(t, err, s.omega[l], s.density[l], hypot(s.re[l], s.im[l]), s.re[l], s.im[l], s.error[l]);
    sp_transmission_free(&s);
    return status;
}

static const char *const polarizations[] = {"longitudinal", "transverse", "rotational"};

static sp_status put_waves(const sp_dispersion *d, sp_table *t, sp_error *err) {
    static const char *const columns[] = {"k",          "1/d",
                                          "rms",        SPECTRUM_FREQUENCY,
                                          "spread",     SPECTRUM_FREQUENCY,
                                          "peak",       SPECTRUM_FREQUENCY,
                                          "half_width", SPECTRUM_FREQUENCY,
                                          "resolution", SPECTRUM_FREQUENCY,
                                          NULL};
    sp_status status = cli_add_columns(t, columns, err);
    for (int32_t q = 0; q < d->n && status == SP_OK; q++) {
        const sp_dispersion_point *w = &d->wave[q];
        status = sp_table_add_row(t, err, polarizations[w->polarization], (int64_t)w->n, w->k, w->rms, w->spread,
                                  w->peak, w->half_width, w->resolution);
    }
    return status;
}

static sp_status put_profile(const sp_dispersion *d, sp_table *t, sp_error *err) {
    static const char *const columns[] = {"k", "1/d", "omega", SPECTRUM_FREQUENCY, "S", SPECTRUM_TIME, NULL};
    sp_status status = cli_add_columns(t, columns, err);
    for (int32_t q = 0; q < d->n; q++)
        for (int32_t l = 0; l < d->profile && status == SP_OK; l++)
            status = sp_table_add_row(t, err, polarizations[d->wave[q].polarization], (int64_t)d->wave[q].n,
                                      d->wave[q].k, d->omega[l], d->s[(int64_t)q * d->profile + l]);
    return status;
}

sp_status spectrum_dispersion(const spectrum_arguments *a, const sp_packing *p, const sp_network *net, sp_table *t,
                              sp_error *err) {
    sp_dispersion_options o = sp_dispersion_options_default();
    sp_dispersion d = sp_dispersion_none();
    const char *direction = a->direction ? a->direction : net->dim > 1 ? "x" : "up";
    if (strcmp(direction, "x") != 0 && strcmp(direction, "up") != 0)
        return sp_fail(err, SP_EINVAL, "--direction %.60s: must be x or up", direction);
    o.up = strcmp(direction, "up") == 0;
    if (!o.up && a->node >= 0)
        return sp_fail(err, SP_EINVAL, "--node: must be with --direction up");
    if (a->waves >= 0)
        o.waves = (int32_t)a->waves;
    if (a->resolution >= 0)
        o.resolution = a->resolution;
    if (a->profile)
        o.profile = a->bins >= 0 ? (int32_t)a->bins : 400;
    else if (a->bins >= 0)
        return sp_fail(err, SP_EINVAL, "--bins: must be with --profile");
    /* a wall that answers like a grain holds the place of a fixed one, whose centre is behind it */
    o.node = o.up && p->wall == SP_WALL_GRAIN ? 0.5 : 0;
    if (a->node >= 0)
        o.node = a->node;
    sp_status status = sp_dispersion_make(net, &o, &d, err);
    if (status == SP_OK)
        status = sp_table_add_column(t, "polarization", "", SP_CELL_TEXT, err);
    if (status == SP_OK)
        status = sp_table_add_column(t, "n", "", SP_CELL_INTEGER, err);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "direction = %s", direction);
    if (status == SP_OK && o.up)
        status = cli_add_number(t, "node", o.node, err);
    if (status == SP_OK)
        status = cli_add_number(t, "omega_max", d.omega_max, err);
    if (status == SP_OK)
        status = cli_add_number(t, "moments", (double)d.moments, err);
    if (status == SP_OK)
        status = a->profile ? put_profile(&d, t, err) : put_waves(&d, t, err);
    sp_dispersion_free(&d);
    return status;
}

sp_status spectrum_participation(const spectrum_arguments *a, const sp_packing *p, const sp_network *net, sp_table *t,
                                 sp_error *err) {
    static const char *const columns[] = {"omega", SPECTRUM_FREQUENCY, "low", SPECTRUM_FREQUENCY,
                                          "high",  SPECTRUM_FREQUENCY, NULL};
    static const char *const values[] = {"participation", "", "sd", "", "min", "", "max", "", NULL};
    const sp_modes_options o = {.vectors = true, .source = SP_SOURCE_IMPULSE};
    const int32_t bins = a->bins >= 0 ? (int32_t)a->bins : 40;
    sp_modes m = sp_modes_none();
    sp_participation_bin *bin = sp_alloc((size_t)bins, sizeof *bin);
    (void)p;
    sp_status status = bin ? SP_OK : sp_fail_memory(err, (size_t)bins * sizeof *bin);
    if (status == SP_OK)
        status = sp_modes_dense(net, &o, &m, err);
    if (status == SP_OK)
        status = sp_participation(&m, bins, a->until >= 0 ? a->until : 0, bin, err);
    if (status == SP_OK)
        status = cli_add_columns(t, columns, err);
    if (status == SP_OK)
        status = sp_table_add_column(t, "modes", "", SP_CELL_INTEGER, err);
    if (status == SP_OK)
        status = cli_add_columns(t, values, err);
    if (status == SP_OK)
        status = cli_add_number(t, "zero_modes", (double)(m.n_zero - m.n_rattler), err);
    if (status == SP_OK)
        status = cli_add_number(t, "rattler_modes", (double)m.n_rattler, err);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "nan: no mode in the bin; sd: fewer than two");
    for (int32_t b = 0; b < bins && status == SP_OK; b++)
        status = sp_table_add_row(t, err, 0.5 * (bin[b].low + bin[b].high), bin[b].low, bin[b].high, bin[b].modes,
                                  bin[b].mean, bin[b].sd, bin[b].least, bin[b].largest);
    sp_modes_free(&m);
    sp_free(bin);
    return status;
}
