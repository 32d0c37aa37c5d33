/* sonopack spectrum dos. */
#include "base/base.h"
#include "cli/spectrum.h"

#include <math.h>
#include <string.h>

spectrum_arguments spectrum_arguments_default(void) {
    spectrum_arguments a = {.bins = -1, .vectors = -1, .seed = -1, .waves = -1, .layers = -1, .lowest = -1};
    a.until = a.resolution = a.damping = a.node = a.tolerance = -1;
    a.range[0] = a.range[1] = NAN;
    return a;
}

/* The number of a word in a list ended by NULL. */
static sp_status choose(const char *option, const char *word, const char *const *words, int *out, sp_error *err) {
    for (int k = 0; words[k]; k++)
        if (strcmp(word, words[k]) == 0) {
            *out = k;
            return SP_OK;
        }
    return sp_fail(err, SP_EINVAL, "%s %.60s: must be %s, %s%s%s or %s", option, word, words[0], words[1],
                   words[3] ? ", " : "", words[3] ? words[2] : "", words[3] ? words[3] : words[2]);
}

static const char *const methods[] = {"auto", "exact", "kpm", "count", NULL};
static const char *const norms[] = {"grain", "one", "modes", NULL};

static sp_status options_of(const spectrum_arguments *a, sp_dos_options *o, sp_error *err) {
    int method = 0, norm = 0;
    sp_status status = SP_OK;
    *o = sp_dos_options_default();
    if (a->method)
        status = choose("--method", a->method, methods, &method, err);
    if (status == SP_OK && a->norm)
        status = choose("--norm", a->norm, norms, &norm, err);
    o->method = (sp_dos_method)method;
    o->norm = (sp_dos_norm)norm;
    if (a->bins >= 0)
        o->bins = (int32_t)a->bins;
    if (a->vectors >= 0)
        o->vectors = (int32_t)a->vectors;
    if (a->seed >= 0)
        o->seed = (uint64_t)a->seed;
    if (a->until >= 0)
        o->until = a->until;
    if (a->resolution >= 0)
        o->resolution = a->resolution;
    if (a->common.threads > 0)
        o->threads = a->common.threads;
    return status;
}

sp_status spectrum_dos(const spectrum_arguments *a, const sp_packing *p, const sp_network *net, sp_table *t,
                       sp_error *err) {
    static const char *const per_mode[] = {"modes/grain", "", "modes"};
    sp_dos_options o;
    sp_dos d = sp_dos_none();
    (void)p;
    sp_status status = options_of(a, &o, err);
    if (status == SP_OK)
        status = sp_dos_make(net, &o, &d, err);
    if (status != SP_OK)
        return status;
    const char *unit = o.norm == SP_DOS_MODES ? "modes d/sqrt(E* / rho)" : SPECTRUM_TIME;
    const char *const columns[] = {"omega",
                                   SPECTRUM_FREQUENCY,
                                   "low",
                                   SPECTRUM_FREQUENCY,
                                   "high",
                                   SPECTRUM_FREQUENCY,
                                   "density",
                                   unit,
                                   "density_err",
                                   unit,
                                   "cumulative",
                                   per_mode[o.norm],
                                   "cumulative_err",
                                   per_mode[o.norm],
                                   "smooth",
                                   unit,
                                   "smooth_err",
                                   unit,
                                   NULL};
    status = cli_add_columns(t, columns, err);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "method = %s", methods[d.method]);
    if (status == SP_OK)
        status = sp_table_add_comment(t, err, "norm = %s", norms[o.norm]);
    if (status == SP_OK)
        status = cli_add_number(t, "modes", (double)d.modes, err);
    if (status == SP_OK)
        status = cli_add_number(t, "rattler_modes", (double)net->rattlers * net->dof, err);
    if (status == SP_OK && d.zero_modes >= 0)
        status = cli_add_number(t, "zero_modes", (double)d.zero_modes, err);
    if (status == SP_OK && d.zero_modes < 0)
        status = sp_table_add_comment(t, err, "zero modes of the network are not told apart: they are at omega = 0");
    if (status == SP_OK)
        status = cli_add_number(t, "resolution", d.resolution, err);
    if (status == SP_OK)
        status = cli_add_number(t, "omega_max", d.omega_max, err);
    if (status == SP_OK && d.vectors > 0)
        status = cli_add_number(t, "vectors", d.vectors, err);
    if (status == SP_OK)
        status = cli_add_number(t, "moments", (double)d.moments, err);
    for (int32_t b = 0; b < d.bins && status == SP_OK; b++)
        status = sp_table_add_row(t, err, 0.5 * (d.edge[b] + d.edge[b + 1]), d.edge[b], d.edge[b + 1], d.density[b],
                                  d.density_error[b], d.cumulative[b], d.cumulative_error[b], d.smooth[b],
                                  d.smooth_error[b]);
    sp_dos_free(&d);
    return status;
}
