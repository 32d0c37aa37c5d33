/* Fills the tables of sonopack spectrum transmission, dispersion and participation. */
#include "base/base.h"
#include "cli/modes.h"
#include "cli/spectrum.h"

#include <math.h>

/* The table of --lines: every mode with its weight in the signal. */
static sp_status lines(const spectrum_arguments *a, const sp_network *net, sp_table *t, sp_error *err) {
    const sp_modes_options o = {.vectors = true, .source = (sp_source)a->source, .solver = (sp_modes_solver)a->solver};
    const sp_modes_range range = sp_modes_range_all();
    sp_modes m = sp_modes_none();
    double all = 0, sum = 0;
    if (!sp_network_touches(net, SP_BOTTOM) || !sp_network_touches(net, SP_TOP))
        return sp_fail(err, SP_EREFUSED, "no carrying contact at the %s wall: no mode has a weight in a signal",
                       sp_network_touches(net, SP_BOTTOM) ? "top" : "bottom");
    cli_writer w = {.table = t, .err = err, .status = sp_modes_make(net, &o, &range, &m, err)};
    cli_columns(&w, SP_COLUMN_INTEGER, "n", "", NULL);
    cli_columns(&w, SP_COLUMN_NUMBER, "omega", SPECTRUM_FREQUENCY, "ab", "E* d^2", "share", "", NULL);
    cli_comment(&w, "source = %s", cli_source_names[a->source]);
    cli_comment(&w, "share: of the sum of |ab| over all modes, up to this one");
    for (int64_t k = 0; k < m.n && w.status == SP_OK; k++)
        all += fabs(m.a[k] * m.b[k]);
    for (int64_t k = m.n_rattler; k < m.n && w.status == SP_OK; k++) {
        sum += fabs(m.a[k] * m.b[k]);
        w.status = sp_table_add_row(t, err, k, m.omega[k], m.a[k] * m.b[k], all > 0 ? sum / all : 0.0);
    }
    sp_modes_free(&m);
    return w.status;
}

sp_status spectrum_transmission(const spectrum_arguments *a, cli_file *file, sp_table *t, sp_error *err) {
    sp_transmission_options o = sp_transmission_options_default();
    sp_transmission s = sp_transmission_none();
    if (a->lines && (a->bins >= 0 || a->until >= 0 || a->resolution >= 0))
        return sp_fail(err, SP_EINVAL, "--lines cannot be combined with --bins, --omega-max or --resolution");
    if (a->lines)
        return lines(a, &file->network, t, err);
    o.source = (sp_source)a->source;
    if (a->bins >= 0)
        o.points = (int32_t)a->bins;
    if (a->until >= 0)
        o.until = a->until;
    if (a->resolution >= 0)
        o.resolution = a->resolution;
    cli_writer w = {.table = t, .err = err, .status = sp_transmission_make(&file->network, &o, &s, err)};
    cli_columns(&w, SP_COLUMN_NUMBER, "omega", SPECTRUM_FREQUENCY, "density", SPECTRUM_RESPONSE, "magnitude",
                SPECTRUM_RESPONSE, "re", SPECTRUM_RESPONSE, "im", SPECTRUM_RESPONSE, "error", SPECTRUM_RESPONSE, NULL);
    cli_comment(&w, "source = %s", cli_source_names[a->source]);
    cli_value(&w, "resolution", s.resolution);
    cli_value(&w, "omega_max", s.omega_max);
    cli_value(&w, "moments", (double)s.moments);
    for (int32_t l = 0; l < s.n && w.status == SP_OK; l++)
        w.status =
            sp_table_add_row(t, err, s.omega[l], s.density[l], hypot(s.re[l], s.im[l]), s.re[l], s.im[l], s.error[l]);
    sp_transmission_free(&s);
    return w.status;
}

/* ---- dispersion ------------------------------------------------------------------------------------------------- */

const char *const spectrum_directions[] = {"x", "up", "y", NULL};
static const char *const polarizations[] = {"longitudinal", "transverse", "rotational"};

static void add_waves(const sp_dispersion *d, cli_writer *w) {
    cli_columns(w, SP_COLUMN_NUMBER, "k", "1/d", "rms", SPECTRUM_FREQUENCY, "spread", SPECTRUM_FREQUENCY, "peak",
                SPECTRUM_FREQUENCY, "half_width", SPECTRUM_FREQUENCY, "resolution", SPECTRUM_FREQUENCY, NULL);
    for (int32_t q = 0; q < d->n && w->status == SP_OK; q++) {
        const sp_dispersion_point *wave = &d->wave[q];
        w->status = sp_table_add_row(w->table, w->err, polarizations[wave->polarization], (int64_t)wave->n, wave->k,
                                     wave->rms, wave->spread, wave->peak, wave->half_width, wave->resolution);
    }
}

static void add_profile(const sp_dispersion *d, cli_writer *w) {
    cli_columns(w, SP_COLUMN_NUMBER, "k", "1/d", "omega", SPECTRUM_FREQUENCY, "S", SPECTRUM_TIME, NULL);
    for (int32_t q = 0; q < d->n; q++)
        for (int32_t l = 0; l < d->profile && w->status == SP_OK; l++)
            w->status =
                sp_table_add_row(w->table, w->err, polarizations[d->wave[q].polarization], (int64_t)d->wave[q].n,
                                 d->wave[q].k, d->omega[l], d->s[(int64_t)q * d->profile + l]);
}

static sp_status set_options(const spectrum_arguments *a, const cli_file *file, sp_dispersion_options *o,
                             sp_error *err) {
    enum { UP = 1, ALONG_Y = 2 };
    *o = sp_dispersion_options_default();
    o->up = a->direction >= 0 ? a->direction == UP : file->network.dim == 1;
    o->along_y = a->direction == ALONG_Y;
    const bool standing = file->packing.cell == SP_CELL_BOX || (o->up && file->packing.cell == SP_CELL_PISTON);
    if (!standing && a->node >= 0)
        return sp_fail(err, SP_EINVAL, "--node applies only to waves between walls%s",
                       file->packing.cell == SP_CELL_PISTON ? ", --direction up" : "");
    if (!a->profile && a->bins >= 0)
        return sp_fail(err, SP_EINVAL, "--bins applies only to --profile");
    if (a->waves >= 0)
        o->waves = (int32_t)a->waves;
    if (a->resolution >= 0)
        o->resolution = a->resolution;
    if (a->profile)
        o->profile = a->bins >= 0 ? (int32_t)a->bins : 400;
    /* a wall that is like a fixed grain has that grain's centre behind it */
    o->node = a->node >= 0 ? a->node : standing && file->packing.wall == SP_WALL_GRAIN ? 0.5 : 0;
    return SP_OK;
}

sp_status spectrum_dispersion(const spectrum_arguments *a, cli_file *file, sp_table *t, sp_error *err) {
    sp_dispersion_options o;
    sp_dispersion d = sp_dispersion_none();
    cli_writer w = {.table = t, .err = err, .status = set_options(a, file, &o, err)};
    if (w.status == SP_OK)
        w.status = sp_dispersion_make(&file->network, &o, &d, err);
    if (w.status != SP_OK)
        return w.status;
    cli_columns(&w, SP_COLUMN_TEXT, "polarization", "", NULL);
    cli_columns(&w, SP_COLUMN_INTEGER, "n", "", NULL);
    cli_comment(&w, "direction = %s", spectrum_directions[o.along_y ? 2 : o.up]);
    if (o.up && file->packing.cell != SP_CELL_PERIODIC)
        cli_value(&w, "node", o.node);
    cli_value(&w, "omega_max", d.omega_max);
    cli_value(&w, "moments", (double)d.moments);
    if (a->profile)
        add_profile(&d, &w);
    else
        add_waves(&d, &w);
    sp_dispersion_free(&d);
    return w.status;
}

/* ---- participation ---------------------------------------------------------------------------------------------- */

sp_status spectrum_participation(const spectrum_arguments *a, cli_file *file, sp_table *t, sp_error *err) {
    const sp_modes_options o = {.vectors = true, .solver = (sp_modes_solver)a->solver};
    const sp_modes_range all = sp_modes_range_all();
    const int32_t bins = a->bins >= 0 ? (int32_t)a->bins : 40;
    sp_modes m = sp_modes_none();
    sp_participation_bin *bin = sp_alloc((size_t)bins, sizeof *bin);
    cli_writer w = {.table = t, .err = err};
    w.status = bin ? sp_modes_make(&file->network, &o, &all, &m, err) : sp_fail_memory(err, (size_t)bins * sizeof *bin);
    if (w.status == SP_OK)
        w.status = sp_participation(&m, bins, a->until >= 0 ? a->until : 0, bin, err);
    cli_columns(&w, SP_COLUMN_NUMBER, "omega", SPECTRUM_FREQUENCY, "low", SPECTRUM_FREQUENCY, "high",
                SPECTRUM_FREQUENCY, NULL);
    cli_columns(&w, SP_COLUMN_INTEGER, "modes", "", NULL);
    cli_columns(&w, SP_COLUMN_NUMBER, "participation", "", "sd", "", "min", "", "max", "", NULL);
    cli_zero_modes(&w, &m.zero);
    cli_comment(&w, "nan: no mode in the bin; sd: fewer than two");
    for (int32_t b = 0; b < bins && w.status == SP_OK; b++)
        w.status = sp_table_add_row(t, err, 0.5 * (bin[b].low + bin[b].high), bin[b].low, bin[b].high, bin[b].modes,
                                    bin[b].mean, bin[b].sd, bin[b].least, bin[b].largest);
    sp_modes_free(&m);
    sp_free(bin);
    return w.status;
}
