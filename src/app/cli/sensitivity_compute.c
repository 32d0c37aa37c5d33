/* Computes what sonopack sensitivity prints. */
#include "cli/sensitivity.h"

static sp_status wave_options(const sensitivity_arguments *a, const cli_file *file, sp_sensitivity_options *out,
                              sp_error *err) {
    sp_sensitivity_options o = sp_sensitivity_options_default();
    if (a->sources.n == 0 && a->detectors.n == 0) {
        const sp_status status = cli_need_walls(&file->packing, "a front", err);
        if (status != SP_OK)
            return status;
    }
    o.parameters = a->by;
    o.source = (sp_source)a->source;
    o.from = a->sources.n > 0 ? a->sources.at : NULL;
    o.to = a->detectors.n > 0 ? a->detectors.at : NULL;
    o.pulse = a->pulse.word ? &a->pulse.pulse : NULL;
    o.until = a->until > 0 ? a->until : 0;
    o.threads = a->common.threads;
    o.packing = &file->packing;
    *out = o;
    return SP_OK;
}

static sp_status of_front(const sensitivity_arguments *a, const cli_file *file, sp_gradient *out, sp_error *err) {
    sp_sensitivity_options o;
    sp_front_gradient g;
    sp_status status = wave_options(a, file, &o, err);
    if (status == SP_OK)
        status = sp_sensitivity_front(&file->network, &o, a->of.front, &g, err);
    if (status != SP_OK)
        return status;
    sp_gradient *from = a->of.front == SP_FRONT_T10      ? &g.t10
                        : a->of.front == SP_FRONT_T_PEAK ? &g.t_peak
                        : a->of.front == SP_FRONT_PEAK   ? &g.peak
                        : a->of.front == SP_FRONT_T_ZERO ? &g.t_zero
                                                         : &g.width;
    *out = *from;
    *from = sp_gradient_none();
    sp_front_gradient_free(&g);
    return SP_OK;
}

static sp_status of_signal(const sensitivity_arguments *a, const cli_file *file, sp_gradient *out, sp_error *err) {
    sp_sensitivity_options o;
    const double one = 1;
    const sp_functional j = {1, &a->at, &one, NULL};
    const sp_status status = wave_options(a, file, &o, err);
    return status == SP_OK ? sp_sensitivity_signal(&file->network, &o, 1, &j, out, err) : status;
}

/* All modes up to the last one and one more, which tells how far the group is from the next. */
static sp_status of_modes(const sensitivity_arguments *a, const cli_file *file, sp_gradient *out, sp_error *err) {
    const sp_network *net = &file->network;
    sp_modes_options o = sp_modes_options_default();
    sp_modes m = sp_modes_none();
    o.vectors = true;
    o.threads = a->common.threads;
    const sp_modes_range all = sp_modes_range_all();
    sp_status status = sp_modes_make(net, &o, &all, &m, err);
    if (status == SP_OK)
        status = sp_sensitivity_modes(net, &m, a->of.first - m.first, a->of.last - a->of.first + 1, a->by,
                                      &file->packing, out, err);
    sp_modes_free(&m);
    return status;
}

static sp_status of_modulus(const sensitivity_arguments *a, const cli_file *file, sp_gradient *out, sp_error *err) {
    double density;
    sp_status status = sp_packing_density(&file->packing, file->scene->network.threshold, a->margin, &density, err);
    return status == SP_OK
               ? sp_sensitivity_moduli(&file->network, density, 1, &a->of.modulus, a->by, &file->packing, out, err)
               : status;
}

sp_status sensitivity_compute(const sensitivity_arguments *a, const cli_file *file, sp_gradient *out, sp_error *err) {
    switch (a->of.kind) {
    case SENSITIVITY_FRONT: return of_front(a, file, out, err);
    case SENSITIVITY_SIGNAL: return of_signal(a, file, out, err);
    case SENSITIVITY_OMEGA: return of_modes(a, file, out, err);
    default: return of_modulus(a, file, out, err);
    }
}
