/* Fills the table of sonopack spectrum dos: the density of states. */
#include "base/base.h"
#include "cli/modes.h"
#include "cli/spectrum.h"

const char *const spectrum_dos_methods[] = {"auto", "exact", "kpm", "count", NULL};
const char *const spectrum_dos_norms[] = {"grain", "one", "modes", NULL};

static sp_dos_options options_of(const spectrum_arguments *a) {
    sp_dos_options o = sp_dos_options_default();
    o.method = (sp_dos_method)(a->method < 0 ? 0 : a->method);
    o.norm = (sp_dos_norm)(a->norm < 0 ? 0 : a->norm);
    if (a->bins >= 0)
        o.bins = (int32_t)a->bins;
    if (a->vectors >= 0)
        o.vectors = (int32_t)a->vectors;
    if (a->seed >= 0)
        o.seed = (uint64_t)a->seed;
    if (a->until >= 0)
        o.until = a->until;
    if (a->resolution >= 0)
        o.resolution = a->resolution;
    if (a->common.threads > 0)
        o.threads = a->common.threads;
    return o;
}

static void add_columns(sp_dos_norm norm, cli_writer *w) {
    static const char *const numbers[] = {"modes/grain", "", "modes"};
    const char *unit = norm == SP_DOS_MODES ? "modes d/sqrt(E* / rho)" : SPECTRUM_TIME, *number = numbers[norm];
    cli_columns(w, SP_COLUMN_NUMBER, "omega", SPECTRUM_FREQUENCY, "low", SPECTRUM_FREQUENCY, "high", SPECTRUM_FREQUENCY,
                "density", unit, "density_err", unit, "cumulative", number, "cumulative_err", number, "smooth", unit,
                "smooth_err", unit, NULL);
}

sp_status spectrum_dos(const spectrum_arguments *a, cli_file *file, sp_table *t, sp_error *err) {
    const sp_network *net = &file->network;
    const sp_dos_options o = options_of(a);
    sp_dos d = sp_dos_none();
    cli_writer w = {.table = t, .err = err, .status = sp_dos_make(net, &o, &d, err)};
    if (w.status != SP_OK)
        return w.status;
    add_columns(o.norm, &w);
    cli_comment(&w, "method = %s", spectrum_dos_methods[d.method]);
    cli_comment(&w, "norm = %s", spectrum_dos_norms[o.norm]);
    cli_value(&w, "modes", (double)d.modes);
    cli_zero_modes(&w, &d.zero);
    if (d.zero.total < 0)
        cli_comment(&w, "zero modes of the network are in the density, at omega = 0");
    cli_value(&w, "resolution", d.resolution);
    cli_value(&w, "omega_max", d.omega_max);
    if (d.vectors > 0)
        cli_value(&w, "vectors", d.vectors);
    cli_value(&w, "moments", (double)d.moments);
    for (int32_t b = 0; b < d.bins && w.status == SP_OK; b++)
        w.status = sp_table_add_row(t, err, 0.5 * (d.edge[b] + d.edge[b + 1]), d.edge[b], d.edge[b + 1], d.density[b],
                                    d.density_error[b], d.cumulative[b], d.cumulative_error[b], d.smooth[b],
                                    d.smooth_error[b]);
    sp_dos_free(&d);
    return w.status;
}
