#include "study/sample.h"

#include "base/base.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Layers left out at both walls for bulk averages (Somfai et al. 2005, Table I) [d]. */
static const double bulk_margin = 3;

/* Measured at p = 1e-4 and 1e-7: marks within 2e-5 of those on a grid 20 times finer for packings of 200 and 600
 * grains, within 7e-5 for a chain of 3 grains, at a cost of 2 ms; twice the spacing makes the errors three to five
 * times larger. */
double sp_front_spacing(double pressure) { return 0.1 * pow(pressure / 1e-4, -1.0 / 6); }

sp_status sp_network_front(const sp_network *net, sp_source source, double window, sp_front *out, sp_error *err) {
    if (!(window > 0))
        window = sp_signal_window(net->box[net->dim - 1], net->pressure);
    double points = ceil(window / sp_front_spacing(net->pressure)) + 1;
    if (!(points < 1e8))
        return sp_fail(err, SP_EINVAL, "front: window %g at pressure %g needs %g points, at most 1e8", window,
                       net->pressure, points);
    sp_signal_options options = sp_signal_options_default();
    options.method = SP_SIGNAL_CHEBYSHEV;
    options.source = source;
    options.until = window;
    options.points = points > 3 ? (int32_t)points : 3;
    sp_signal signal = sp_signal_none();
    sp_status status = sp_signal_make(net, &options, &signal, err);
    if (status == SP_OK) {
        sp_front_options rule = sp_front_options_default();
        status = sp_front_find(signal.n, signal.t, signal.f, &rule, out, err);
    }
    sp_signal_free(&signal);
    return status;
}

/* The signal itself, as the scene describes it. */
static sp_status wanted_signal(const sp_scene *scene, const sp_packing *packing, const sp_network *net, sp_signal *out,
                               sp_error *err) {
    sp_signal_options options = scene->signal;
    if (!(options.until > 0))
        options.until = sp_signal_window(net->box[net->dim - 1], net->pressure);
    sp_signal signal = sp_signal_none();
    sp_status status = sp_signal_dynamics(packing, net, &options, &signal, err); /* any method */
    if (status == SP_OK) {
        sp_signal_free(out);
        *out = signal;
    }
    return status;
}

static sp_status describe(const sp_scene *scene, sp_sample *sample, sp_error *err) {
    sp_sample_name(scene, sample->name);
    if (sample->name[0] == '\0')
        return sp_fail_memory(err, 4096);
    sample->dim = scene->pack.dim;
    sample->grains = scene->pack.grains;
    sample->width = scene->pack.width;
    sample->pressure = scene->pack.pressure;
    sample->friction = scene->pack.friction;
    sample->seed = scene->pack.seed;
    sample->failed = false;
    sample->reason[0] = '\0';
    return SP_OK;
}

/* The first reason stays; no memory is no property of the sample and goes before all others. */
static void keep_first(sp_status status, const sp_error *reason, sp_status *first, sp_error *err) {
    if (status == SP_OK || (*first != SP_OK && status != SP_ENOMEM))
        return;
    *first = status;
    if (err)
        *err = *reason;
}

/* Every part of `missing` from a packing. */
static sp_status make_parts(const sp_scene *scene, unsigned missing, const sp_packing *packing, sp_sample *sample,
                            sp_signal *signal, sp_error *err) {
    sp_status first = SP_OK, status = SP_OK;
    sp_error reason = {0};
    sp_network net = sp_network_none();
    bool network = false;
    if (missing & (SP_WANT_CTOF | SP_WANT_MODULI | SP_WANT_SIGNAL)) {
        status = sp_network_make(packing, &scene->network, &net, &reason);
        keep_first(status, &reason, &first, err);
        network = status == SP_OK;
    }
    if (missing & SP_WANT_STATICS) {
        status = sp_statics_make(packing, scene->network.threshold, bulk_margin, &sample->statics, &reason);
        sample->have |= status == SP_OK ? SP_WANT_STATICS : 0;
        keep_first(status, &reason, &first, err);
    }
    if (network && missing & SP_WANT_CTOF) {
        status = sp_network_front(&net, scene->signal.source, 0, &sample->front, &reason);
        sample->have |= status == SP_OK ? SP_WANT_CTOF : 0;
        keep_first(status, &reason, &first, err);
    }
    if (network && missing & SP_WANT_MODULI && sample->have & SP_WANT_STATICS) { /* Phi3* of Eq. (8) is there */
        status = sp_moduli_make(&net, sample->statics.phi3s, &sample->moduli, &reason);
        sample->have |= status == SP_OK ? SP_WANT_MODULI : 0;
        keep_first(status, &reason, &first, err);
    }
    if (network && missing & SP_WANT_SIGNAL) {
        status = wanted_signal(scene, packing, &net, signal, &reason);
        sample->have |= status == SP_OK ? SP_WANT_SIGNAL : 0;
        keep_first(status, &reason, &first, err);
    }
    sp_network_free(&net);
    return first;
}

/* Whether a status says something about the sample, so that it would fail again. */
static bool of_the_sample(sp_status status) {
    return status == SP_EFAILED || status == SP_EREFUSED || status == SP_EINVAL || status == SP_EFORMAT;
}

sp_status sp_sample_make_with(const sp_scene *scene, unsigned want, const sp_pack_hooks *hooks, sp_packing *packing,
                              sp_sample *sample, sp_signal *signal, sp_error *err) {
    sp_error reason = {0};
    sp_status status = describe(scene, sample, err);
    if (status != SP_OK)
        return status;
    if (want & SP_WANT_MODULI)
        want |= SP_WANT_STATICS;
    if (packing->n == 0) {
        sample->have = 0;
        sample->height = NAN;
        status = sp_packing_make_with(&scene->pack, hooks, packing, &reason);
    }
    if (status == SP_OK && !packing->scene && !(packing->scene = sp_scene_text(scene, NULL)))
        status = sp_fail_memory(&reason, 4096);
    if (status == SP_OK) {
        sample->height = sp_packing_height(packing);
        unsigned missing = want & ~sample->have;
        if (missing && signal) /* a file written anew keeps the signal that it had */
            missing |= sample->have & SP_WANT_SIGNAL;
        if (!signal)
            missing &= ~(unsigned)SP_WANT_SIGNAL;
        status = make_parts(scene, missing, packing, sample, signal, &reason);
    }
    if (of_the_sample(status)) {
        sample->failed = true;
        snprintf(sample->reason, sizeof sample->reason, "%.255s", reason.text);
    }
    if (status != SP_OK && err)
        *err = reason;
    return status;
}

sp_status sp_sample_make(const sp_scene *scene, unsigned want, sp_packing *packing, sp_sample *sample,
                         sp_signal *signal, sp_error *err) {
    const sp_pack_hooks hooks = {0};
    return sp_sample_make_with(scene, want, &hooks, packing, sample, signal, err);
}
