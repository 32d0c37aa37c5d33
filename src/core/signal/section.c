/* Record sections of packings: signals at planes one above the other. */
#include "base/base.h"
#include "network/bound.h"
#include "network/network_cell.h"
#include "signal/job.h"

#include <math.h>
#include <sonopack/coherent.h>

enum { LEAST_PLANES = 8, MOST_PLANES = 100000 };

sp_coherent_section_options sp_coherent_section_options_default(void) {
    return (sp_coherent_section_options){.spacing = 1, .low = 4, .part = 0.6, .damping_ratio = 1};
}

static void set_damping(const sp_coherent_section_options *opt, sp_signal_options *o) {
    o->method = opt->damping > 0 ? SP_SIGNAL_FABER : SP_SIGNAL_CHEBYSHEV;
    o->damping = opt->damping;
    o->damping_kind = opt->damping_kind;
    o->damping_ratio = opt->damping_ratio;
}

/* The front at the top wall, as in the table of fronts. */
static sp_status find_front(const sp_network *net, const sp_coherent_section_options *opt, double height, sp_front *out,
                            sp_error *err) {
    sp_signal_options o = sp_signal_options_default();
    const sp_place wall = {.kind = SP_PLACE_WALL, .shear = opt->shear};
    set_damping(opt, &o);
    o.source = opt->source;
    o.until = (opt->shear ? 2 : 1) * sp_signal_window(height, net->pressure); /* shear takes up to twice as long */
    o.points = (int32_t)ceil(20 * height) + 200;
    o.sources = o.detectors = 1;
    o.from = o.to = &wall;
    return sp_signal_front(net, &o, out, err);
}

static sp_status alloc_section(int32_t planes, sp_coherent_section *s, sp_place **place, sp_error *err) {
    s->planes = planes;
    s->y = sp_alloc((size_t)planes, sizeof *s->y);
    s->arrival = sp_alloc((size_t)planes, sizeof *s->arrival);
    s->until = sp_alloc((size_t)planes, sizeof *s->until);
    *place = sp_alloc((size_t)planes, sizeof **place);
    return s->y && s->arrival && s->until && *place ? SP_OK
                                                    : sp_fail_memory(err, (size_t)planes * (24 + sizeof **place));
}

static sp_status check(const sp_coherent_section_options *opt, double height, int32_t *planes, sp_error *err) {
    if (!(opt->spacing > 0) || !(opt->low >= 0) || !(opt->part > 0 && opt->part <= 1))
        return sp_fail(err, SP_EINVAL, "section: spacing = %g, low = %g, part = %g; must be > 0, >= 0, and in 0 .. 1",
                       opt->spacing, opt->low, opt->part);
    const double count = floor((opt->part * height - opt->low) / opt->spacing) + 1;
    if (!(count >= LEAST_PLANES))
        return sp_fail(err, SP_EREFUSED,
                       "section: a box %g high has %g planes at distances of %g between %g and %g; at least %d needed: "
                       "a higher box, or closer planes",
                       height, fmax(0, count), opt->spacing, opt->low, opt->part * height, LEAST_PLANES);
    if (!(count <= MOST_PLANES))
        return sp_fail(err, SP_EINVAL, "section: %g planes; at most %d", count, MOST_PLANES);
    *planes = (int32_t)count;
    return SP_OK;
}

/* Planes crossed by the same contacts have the same flux and height, and count once. */
static sp_status place_planes(const sp_network *net, const sp_coherent_section_options *opt, int32_t count, double t10,
                              sp_coherent_section *s, sp_place *place, sp_error *err) {
    const double height = net->box[net->dim - 1];
    s->planes = 0;
    for (int32_t k = 0; k < count; k++) {
        const double plane = opt->low + k * opt->spacing, y = sp_network_plane_height(net, plane);
        const int32_t j = s->planes;
        if (isnan(y) || (j > 0 && !(y > s->y[j - 1] + 1e-6 * opt->spacing)))
            continue;
        s->y[j] = y;
        s->arrival[j] = t10 * y / height;
        s->until[j] = 2 * t10 - s->arrival[j];
        place[j] = (sp_place){.kind = SP_PLACE_PLANE, .shear = opt->shear, .height = plane};
        s->planes++;
    }
    return s->planes >= LEAST_PLANES
               ? SP_OK
               : sp_fail(err, SP_EREFUSED,
                         "section: the %d planes between %g and %g cross %d different sets of contacts; at least %d "
                         "needed: a higher box",
                         count, opt->low, opt->part * height, s->planes, LEAST_PLANES);
}

/* Records up to `until`. The bound of the spectrum is a third of the Nyquist frequency of the times. */
static sp_status record(const sp_network *net, const sp_coherent_section_options *opt, double until,
                        const sp_place *place, sp_coherent_section *s, sp_error *err) {
    sp_signal_options o = sp_signal_options_default();
    sp_signal signal = sp_signal_none();
    const double points = ceil(until / (M_PI / 3 / sp_network_omega_bound(net))) + 1;
    if (!(points * s->planes < 1e9))
        return sp_fail(err, SP_EREFUSED, "section: %d planes of %g times; at most 1e9 numbers", s->planes, points);
    set_damping(opt, &o);
    o.source = opt->source;
    o.until = until;
    o.points = (int32_t)points;
    o.detectors = s->planes;
    o.to = place;
    const sp_place wall = {.kind = SP_PLACE_WALL, .shear = opt->shear};
    o.sources = 1;
    o.from = &wall;
    sp_status status = sp_signal_make(net, &o, &signal, err);
    if (status == SP_OK) {
        s->n = signal.n;
        s->spacing = until / (signal.n - 1);
        s->f = signal.f;
        signal.f = NULL;
    }
    sp_signal_free(&signal);
    return status;
}

sp_status sp_coherent_section_make(const sp_network *net, const sp_coherent_section_options *opt,
                                   sp_coherent_section *out, sp_error *err) {
    const double height = net->box[net->dim - 1];
    sp_coherent_section s = sp_coherent_section_none();
    sp_place *place = NULL;
    sp_front front = {0};
    int32_t planes = 0;
    sp_status status = sp_network_need_walls(net, "a wave that leaves a wall", err);
    if (status == SP_OK)
        status = check(opt, height, &planes, err);
    if (status == SP_OK)
        status = find_front(net, opt, height, &front, err);
    if (status == SP_OK)
        status = alloc_section(planes, &s, &place, err);
    if (status == SP_OK)
        status = place_planes(net, opt, planes, front.t10, &s, place, err);
    if (status == SP_OK)
        status = record(net, opt, s.until[0], place, &s, err);
    if (status == SP_OK)
        status = sp_network_find_largest(net, &s.highest, err);
    s.highest *= 1.001; /* the value is a lower bound */
    sp_free(place);
    if (status != SP_OK) {
        sp_coherent_section_free(&s);
        return status;
    }
    *out = s;
    return SP_OK;
}
