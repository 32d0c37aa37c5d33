/* The energy of a burst from the bottom wall: how much is below a plane, and what passes it. */
#include "base/base.h"
#include "network/network_cell.h"
#include "transport/packet.h"

#include <math.h>

enum { TIMES_MAX = 1000000, PLANES_MAX = 100000 };

typedef struct burst {
    const sp_network *net;
    packet_space space;
    double *motion; /* [dofs][2] */
    double scale;   /* 1 over the energy */
} burst;

static sp_status check(const sp_network *net, const sp_burst_options *o, sp_error *err) {
    const sp_status status = sp_packet_check_band("burst", o->omega, o->width, err);
    if (status != SP_OK)
        return status;
    if (o->times < 1 || o->times > TIMES_MAX || o->planes < 1 || o->planes > PLANES_MAX)
        return sp_fail(err, SP_EINVAL, "burst: %d times and %d planes, must be 1 .. %d and 1 .. %d", o->times,
                       o->planes, TIMES_MAX, PLANES_MAX);
    for (int32_t l = 0; l < o->times; l++)
        if (!(o->t[l] >= (l > 0 ? o->t[l - 1] : 0) && isfinite(o->t[l])))
            return sp_fail(err, SP_EINVAL, "burst: time %d is %g, must be 0 or above and ascend", l + 1, o->t[l]);
    for (int32_t l = 0; l < o->planes; l++)
        if (!isfinite(o->height[l]))
            return sp_fail(err, SP_EINVAL, "burst: plane %d is at %g", l + 1, o->height[l]);
    return sp_network_need_walls(net, "a burst from the bottom", err);
}

/* The filtered impulse. */
static sp_status start(burst *b, const sp_burst_options *o, sp_error *err) {
    packet_map band = {0};
    double energy = 0;
    sp_status status = sp_packet_impulse(&b->space, b->motion, err);
    if (status == SP_OK)
        status = sp_packet_band(&b->space, o->omega, o->width, &band, err);
    if (status == SP_OK)
        status = sp_packet_filter(&b->space, &band, o->omega, b->motion, &energy, err);
    sp_packet_map_free(&band);
    b->scale = 1 / energy;
    return status;
}

static sp_status measure(burst *b, const sp_burst_options *o, double *below, sp_flux *flux, double *drift,
                         sp_error *err) {
    const sp_network *net = b->net;
    double all = 0;
    sp_status status = sp_packet_energies(&b->space, b->motion, err);
    const double *parts = sp_packet_parts(&b->space, b->motion);
    if (status == SP_OK)
        status = sp_transport_flux(net, parts, parts + b->space.n, o->planes, o->height, flux, err);
    for (int32_t p = 0; p < o->planes && status == SP_OK; p++) {
        below[p] = 0;
        flux[p] = (sp_flux){b->scale * flux[p].normal, b->scale * flux[p].sideways, b->scale * flux[p].rotation};
    }
    for (int64_t i = 0; i < net->n && status == SP_OK; i++) {
        const double e = b->scale * sp_energy_sum(&b->space.energy[i]);
        all += e;
        for (int32_t p = 0; p < o->planes; p++)
            below[p] += net->x[3 * i + net->dim - 1] < o->height[p] ? e : 0;
    }
    return status == SP_OK ? sp_packet_check_drift(all, drift, err) : status;
}

static sp_status follow(burst *b, const sp_burst_options *o, double *below, sp_flux *flux, double *drift,
                        sp_error *err) {
    sp_status status = SP_OK;
    double t = 0;
    for (int32_t l = 0; l < o->times && status == SP_OK; l++) {
        packet_map step = {0};
        status = sp_packet_map_time(b->space.omega, o->t[l] - t, &step, err);
        if (status == SP_OK)
            sp_packet_apply(&b->space, &step, b->motion);
        sp_packet_map_free(&step);
        t = o->t[l];
        if (status == SP_OK)
            status = measure(b, o, below + (int64_t)l * o->planes, flux + (int64_t)l * o->planes, drift, err);
    }
    return status;
}

sp_status sp_burst_make(const sp_network *net, const sp_burst_options *opt, double *below, sp_flux *flux, double *drift,
                        sp_error *err) {
    burst b = {.net = net};
    double change = 0;
    sp_status status = check(net, opt, err);
    if (status == SP_OK)
        status = sp_packet_space_make(net, &b.space, err);
    if (status != SP_OK)
        return status;
    b.motion = sp_alloc(2 * (size_t)b.space.n, sizeof *b.motion);
    if (!b.motion)
        status = sp_fail_memory(err, 2 * (size_t)b.space.n * sizeof *b.motion);
    if (status == SP_OK)
        status = start(&b, opt, err);
    if (status == SP_OK)
        status = follow(&b, opt, below, flux, &change, err);
    if (status == SP_OK && drift)
        *drift = change;
    sp_packet_space_free(&b.space);
    sp_free(b.motion);
    return status;
}
