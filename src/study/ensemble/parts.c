/* Computes the parts of a sample's results from its packing. */
#include "base/base.h"
#include "ensemble/sample.h"

#include <math.h>
#include <sonopack/modes.h>
#include <string.h>

/* Layers left out at both walls for bulk averages (Somfai et al. 2005, Table I) [d]. */
static const double bulk_margin = 3;
/* Least distance of a plane from the walls [d], so that it cuts no grain at a wall. */
static const double plane_margin = 1;

typedef struct part_input {
    const sp_scene *scene;
    const sp_packing *packing;
    const sp_network *net;
} part_input;

unsigned sp_want_parts(unsigned want) {
    if (want & SP_WANT_SCALING)
        want |= SP_WANT_CTOF;
    return want & ~(unsigned)SP_WANT_SCALING;
}

/* ---- the front --------------------------------------------------------------------------------------------------- */

/* Spacing of the times at which a signal is sampled. Against a grid 20 times finer, the marks of a front differ by up
 * to 2e-5 for packings of 200 and 600 grains at p = 1e-4 and 1e-7, and by up to 7e-5 for a chain of 3 grains; twice the
 * spacing makes these errors three to five times larger. */
double sp_front_spacing(double pressure) { return 0.1 * pow(pressure / 1e-4, -1.0 / 6); }

sp_status sp_front_grid(const sp_network *net, sp_source source, double window, sp_signal_options *out, sp_error *err) {
    double points = ceil(window / sp_front_spacing(net->pressure)) + 1;
    if (!(points < 1e8))
        return sp_fail(err, SP_EINVAL, "front: window %g at pressure %g needs %g points, at most 1e8", window,
                       net->pressure, points);
    sp_signal_options options = sp_signal_options_default();
    options.method = SP_SIGNAL_CHEBYSHEV;
    options.source = source;
    options.until = window;
    options.points = points > 3 ? (int32_t)points : 3;
    *out = options;
    return SP_OK;
}

sp_status sp_network_front(const sp_network *net, sp_source source, double window, sp_front *out, sp_error *err) {
    if (!(window > 0))
        window = sp_signal_window(net->box[net->dim - 1], net->pressure);
    sp_signal_options options;
    sp_signal signal = sp_signal_none();
    sp_status status = sp_front_grid(net, source, window, &options, err);
    if (status == SP_OK)
        status = sp_signal_make(net, &options, &signal, err);
    if (status == SP_OK) {
        sp_front_options rule = sp_front_options_default();
        status = sp_front_find(signal.n, signal.t, signal.f, &rule, out, err);
    }
    sp_signal_free(&signal);
    return status;
}

/* ---- the signal ------------------------------------------------------------------------------------------------ */

static double last_time(const sp_scene *scene, double height) {
    return scene->signal.until > 0 ? scene->signal.until : sp_signal_window(height, scene->pack.pressure);
}

static bool signal_fits(const sp_scene *scene, const sp_sample *s) {
    const sp_signal_options *o = &scene->signal;
    const sp_signal_made *made = &s->signal;
    const double until = last_time(scene, s->height);
    const bool method = o->method == SP_SIGNAL_AUTO ? made->method != SP_SIGNAL_DYNAMICS : made->method == o->method;
    return method && made->points == o->points && fabs(made->until - until) <= 1e-9 * until &&
           (isnan(made->tolerance) || made->tolerance == o->tolerance);
}

/* Computes the signal as the scene describes it. */
static sp_status make_signal(const part_input *in, sp_sample *sample, sp_signal *out, sp_error *err) {
    sp_signal_options options = in->scene->signal;
    options.until = last_time(in->scene, in->net->box[in->net->dim - 1]);
    sp_signal signal = sp_signal_none();
    sp_status status = sp_signal_compute(in->packing, in->net, &options, &signal, err); /* any method */
    if (status == SP_OK) {
        sample->signal = (sp_signal_made){
            .points = signal.n, .method = signal.method, .until = options.until, .tolerance = options.tolerance};
        sp_signal_free(out);
        *out = signal;
    }
    return status;
}

/* ---- the spectrum ----------------------------------------------------------------------------------------------- */

/* Computes every frequency of the network, without rattlers. */
static sp_status make_spectrum(const sp_network *net, sp_sample *sample, sp_sample_arrays *arrays, sp_error *err) {
    const sp_modes_options frequencies = {.vectors = false};
    sp_modes modes = sp_modes_none();
    sp_status status = sp_modes_dense(net, &frequencies, &modes, err);
    const int64_t count = status == SP_OK ? modes.n - modes.n_rattler : 0;
    if (status == SP_OK && count == 0)
        status = sp_fail(err, SP_EREFUSED, "spectrum: the network has no grain, and no frequency");
    double *omega = status == SP_OK ? sp_alloc((size_t)count, sizeof *omega) : NULL;
    if (status == SP_OK && !omega)
        status = sp_fail_memory(err, (size_t)count * sizeof *omega);
    if (status == SP_OK) {
        memcpy(omega, modes.omega + modes.n_rattler, (size_t)count * sizeof *omega);
        sample->spectrum = (sp_spectrum_made){.carrying = net->n,
                                              .dof = net->dof,
                                              .zero_modes = (int32_t)(modes.n_zero - modes.n_rattler),
                                              .omega_max = omega[count - 1]};
        sp_free(arrays->omega);
        arrays->omega = omega;
        arrays->modes = count;
    }
    sp_modes_free(&modes);
    return status;
}

/* ---- planes ---------------------------------------------------------------------------------------------------- */

/* Finds those planes of the scene that lie inside the packing. */
static int32_t planes_inside(const sp_scene *scene, double height, double plane[SP_PLANES_MAX]) {
    int32_t count = 0;
    for (int32_t k = 0; k < scene->planes; k++)
        if (scene->plane[k] >= plane_margin && scene->plane[k] <= height - plane_margin)
            plane[count++] = scene->plane[k];
    return count;
}

static bool planes_fit(const sp_scene *scene, const sp_sample *s) {
    double plane[SP_PLANES_MAX];
    const int32_t count = planes_inside(scene, s->height, plane);
    bool fit = count == s->planes;
    for (int32_t k = 0; k < count && fit; k++)
        fit = plane[k] == s->plane[k];
    return fit;
}

/* Whether the first front is over before its echo returns from the top wall. The echo is taken to travel at the mean
 * speed of the front up to the plane; it is never faster than that. */
static bool before_echo(const sp_front *f, double plane, double height) {
    return f->t_zero <= f->t10 * (2 * height - plane) / plane;
}

/* Finds the front at each plane, in the plane's own window; NAN where there is none, or where the echo comes too
 * early. */
static sp_status find_fronts(const sp_signal *signal, const sp_network *net, int32_t count, const double *plane,
                             sp_front *front, sp_error *err) {
    static const sp_front none = {NAN, NAN, NAN, NAN, NAN, 0};
    const double height = net->box[net->dim - 1];
    int32_t found = 0;
    sp_error first = {0};
    for (int32_t k = 0; k < count; k++) {
        sp_error reason = {0};
        sp_front_options rule = sp_front_options_default();
        rule.window = sp_signal_window(plane[k], net->pressure);
        sp_status status =
            sp_front_find(signal->n, signal->t, signal->f + (int64_t)k * signal->n, &rule, &front[k], &reason);
        if (status == SP_OK && !before_echo(&front[k], plane[k], height))
            status = sp_fail(&reason, SP_EREFUSED, "the echo of the top wall, at %g, comes before the front is over",
                             height);
        if (status == SP_OK) {
            found++;
            continue;
        }
        front[k] = none;
        if (first.text[0] == '\0')
            first = reason;
    }
    if (found == 0)
        return sp_fail(err, SP_EREFUSED, "planes: no front at any of the %d planes: the first says %s", count,
                       first.text);
    return SP_OK;
}

/* Finds the fronts at all planes from one run. It lasts to the end of the window of the highest plane, because the
 * first peak depends on the largest value in the whole window. */
static sp_status make_planes(const part_input *in, sp_sample *sample, sp_error *err) {
    const sp_network *net = in->net;
    sp_place detector[SP_PLANES_MAX];
    double plane[SP_PLANES_MAX];
    sp_front front[SP_PLANES_MAX];
    const int32_t count = planes_inside(in->scene, net->box[net->dim - 1], plane);
    for (int32_t k = 0; k < count; k++)
        detector[k] = (sp_place){.kind = SP_PLACE_PLANE, .height = plane[k]};
    sp_status status = SP_OK;
    if (count > 0) {
        sp_signal_options options;
        sp_signal signal = sp_signal_none();
        status = sp_front_grid(net, in->scene->signal.source, sp_signal_window(plane[count - 1], net->pressure),
                               &options, err);
        options.detectors = count;
        options.to = detector;
        if (status == SP_OK)
            status = sp_signal_make(net, &options, &signal, err);
        if (status == SP_OK)
            status = find_fronts(&signal, net, count, plane, front, err);
        sp_signal_free(&signal);
    }
    if (status != SP_OK)
        return status;
    sample->planes = count;
    memcpy(sample->plane, plane, (size_t)count * sizeof *plane);
    memcpy(sample->plane_front, front, (size_t)count * sizeof *front);
    return SP_OK;
}

/* ---- moduli ---------------------------------------------------------------------------------------------------- */

/* Computes the probes; and also the moduli if they are missing, because both use the same factorisation. */
static sp_status make_probes(const part_input *in, bool moduli, sp_sample *sample, sp_error *err) {
    static const sp_probe probe[SP_PROBES] = {[SP_SINE_1] = {SP_PROBE_SINE, 1},
                                              [SP_SINE_2] = {SP_PROBE_SINE, 2},
                                              [SP_LINES_1] = {SP_PROBE_LINES, 1},
                                              [SP_LINES_3] = {SP_PROBE_LINES, 3}};
    sp_moduli global;
    sp_probe_moduli probed[SP_PROBES];
    sp_status status =
        sp_moduli_probe(in->net, sample->statics.phi3s, SP_PROBES, probe, moduli ? &global : NULL, probed, err);
    if (status != SP_OK)
        return status;
    memcpy(sample->probe, probed, sizeof probed);
    if (moduli)
        sample->moduli = global;
    return SP_OK;
}

/* ---- all ------------------------------------------------------------------------------------------------------- */

/* Older stores have no K and G, which exist where all strains do. */
static bool lacks_isotropic(const sp_sample *s) {
    const sp_moduli *m = &s->moduli;
    return isnan(m->bulk) && isfinite(m->c11 + (s->dim == 3 ? m->c44 + m->c55 + m->c66 : m->c33));
}

unsigned sp_sample_parts(const sp_scene *scene, const sp_sample *sample) {
    unsigned parts = sample->have;
    if (lacks_isotropic(sample))
        parts &= ~(unsigned)SP_WANT_MODULI;
    if (!signal_fits(scene, sample))
        parts &= ~(unsigned)SP_WANT_SIGNAL;
    if (!planes_fit(scene, sample))
        parts &= ~(unsigned)SP_WANT_PLANES;
    return parts;
}

/* Parts that could not be made, and that the scene describes as the scene did then. */
static unsigned still_lacks(const sp_scene *scene, const sp_sample *sample) {
    const unsigned described = SP_WANT_SIGNAL | SP_WANT_PLANES;
    unsigned lacks = sample->lacks;
    if (lacks & described && sample->lacks_signal != sp_signal_keys(scene))
        lacks &= ~described;
    return lacks;
}

sp_stored sp_sample_stored(const sp_scene *scene, const sp_sample *sample) {
    if (sample->failed)
        return SP_STORED_FAILED;
    const unsigned missing = sp_want_parts(scene->want) & ~sp_sample_parts(scene, sample);
    if (missing == 0)
        return SP_STORED_ALL;
    return missing & ~still_lacks(scene, sample) ? SP_STORED_NOT : SP_STORED_FAILED;
}

/* Keeps the first reason. A lack of memory replaces any other, because it says nothing about the sample. */
static void keep_first(sp_status status, const sp_error *reason, sp_status *first, sp_error *err) {
    if (status == SP_OK || (*first != SP_OK && status != SP_ENOMEM))
        return;
    *first = status;
    if (err)
        *err = *reason;
}

/* Makes one part. */
static sp_status make_part(const part_input *in, unsigned part, sp_sample *sample, sp_sample_arrays *arrays,
                           sp_error *err) {
    switch (part) {
    case SP_WANT_STATICS:
        return sp_statics_make(in->packing, in->scene->network.threshold, bulk_margin, &sample->statics, err);
    case SP_WANT_CTOF: return sp_network_front(in->net, in->scene->signal.source, 0, &sample->front, err);
    case SP_WANT_PLANES: return make_planes(in, sample, err);
    case SP_WANT_MODULI: return sp_moduli_make(in->net, sample->statics.phi3s, &sample->moduli, err);
    case SP_WANT_PROBES: return make_probes(in, false, sample, err);
    case SP_WANT_SPECTRUM: return make_spectrum(in->net, sample, arrays, err);
    default: return make_signal(in, sample, &arrays->signal, err);
    }
}

sp_status sp_parts_make(const sp_scene *scene, unsigned missing, const sp_packing *packing, sp_sample *sample,
                        sp_sample_arrays *arrays, sp_error *err) {
    static const unsigned order[] = {SP_WANT_STATICS, SP_WANT_CTOF,   SP_WANT_PLANES,  SP_WANT_PROBES,
                                     SP_WANT_MODULI,  SP_WANT_SIGNAL, SP_WANT_SPECTRUM};
    const unsigned needs_network = missing & ~(unsigned)SP_WANT_STATICS;
    sp_status first = SP_OK, status = SP_OK;
    sp_error reason = {0};
    sp_network net = sp_network_none();
    const part_input in = {scene, packing, &net};
    bool network = false;
    unsigned made = 0;
    if (needs_network) {
        status = sp_network_make(packing, &scene->network, &net, &reason);
        keep_first(status, &reason, &first, err);
        network = status == SP_OK;
    }
    for (size_t k = 0; k < sizeof order / sizeof *order; k++) {
        const unsigned part = order[k] & missing & ~made;
        const bool elastic = part == SP_WANT_MODULI || part == SP_WANT_PROBES;
        if (!part || (part != SP_WANT_STATICS && !network) || (elastic && !(sample->have & SP_WANT_STATICS)))
            continue;
        if (part == SP_WANT_PROBES && missing & SP_WANT_MODULI) /* if this fails, the moduli alone are tried next */
            status = make_probes(&in, true, sample, &reason);
        else
            status = make_part(&in, part, sample, arrays, &reason);
        if (status == SP_OK)
            made |= part | (part == SP_WANT_PROBES ? missing & SP_WANT_MODULI : 0);
        sample->have |= made;
        keep_first(status, &reason, &first, err);
    }
    sp_network_free(&net);
    return first;
}
