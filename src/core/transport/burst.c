/* The energy of a burst from the bottom wall: how much is below a plane, and what passes it. */
#include "base/base.h"
#include "network/network_cell.h"
#include "transport/packet.h"

#include <math.h>
#include <sonopack/transport.h>

enum { TIMES_MAX = 1000000, PLANES_MAX = 100000 };

typedef struct burst {
    const sp_network *net;
    packet_space space;
    double *motion; /* [dofs][2] */
    double *pair;   /* [2][dofs] u and v */
    sp_energy *energy;
    double scale; /* 1 over the energy */
} burst;

static void burst_free(burst *b) {
    sp_packet_space_free(&b->space);
    sp_free(b->motion);
    sp_free(b->pair);
    sp_free(b->energy);
}

static sp_status check(const sp_network *net, const sp_burst_options *o, sp_error *err) {
    if (!(o->omega > 0 && isfinite(o->omega)))
        return sp_fail(err, SP_EINVAL, "burst: frequency %g, must be above 0", o->omega);
    if (!(o->width >= 1e-3 && o->width <= 0.5))
        return sp_fail(err, SP_EINVAL, "burst: width %g of the band, must be 0.001 .. 0.5", o->width);
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
    sp_status status = sp_network_source(b->net, SP_SOURCE_IMPULSE, b->pair, err);
    if (status == SP_OK)
        status = sp_packet_map_band(b->space.omega, o->omega, M_SQRT2 * o->width * o->omega, &band, err);
    if (status != SP_OK)
        return status;
    for (int64_t q = 0; q < b->space.n; q++) {
        b->motion[2 * q] = 0;
        b->motion[2 * q + 1] = b->pair[q] / b->net->mass[q];
    }
    const double before = sp_packet_energy(&b->space, b->motion);
    sp_packet_apply(&b->space, &band, b->motion);
    sp_packet_map_free(&band);
    const double energy = sp_packet_energy(&b->space, b->motion);
    if (!(energy > 1e-12 * before))
        return sp_fail(err, SP_EREFUSED, "no mode has a frequency near %g", o->omega);
    b->scale = 1 / energy;
    return SP_OK;
}

static sp_status measure(burst *b, const sp_burst_options *o, double *below, sp_flux *flux, double *drift,
                         sp_error *err) {
    const sp_network *net = b->net;
    const int64_t n = b->space.n;
    double all = 0;
    for (int64_t q = 0; q < n; q++) {
        b->pair[q] = b->motion[2 * q];
        b->pair[n + q] = b->motion[2 * q + 1];
    }
    sp_status status = sp_transport_energy(net, b->pair, b->pair + n, b->energy, err);
    if (status == SP_OK)
        status = sp_transport_flux(net, b->pair, b->pair + n, o->planes, o->height, flux, err);
    for (int32_t p = 0; p < o->planes && status == SP_OK; p++) {
        below[p] = 0;
        flux[p] = (sp_flux){b->scale * flux[p].normal, b->scale * flux[p].sideways, b->scale * flux[p].rotation};
    }
    for (int64_t i = 0; i < net->n && status == SP_OK; i++) {
        const double e = b->scale * sp_energy_sum(&b->energy[i]);
        all += e;
        for (int32_t p = 0; p < o->planes; p++)
            below[p] += net->x[3 * i + net->dim - 1] < o->height[p] ? e : 0;
    }
    *drift = fmax(*drift, fabs(all - 1));
    if (status == SP_OK && !(*drift < 1e-6))
        return sp_fail(err, SP_EREFUSED, "the energy of the motion changes by %.3g: the network is unstable", *drift);
    return status;
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
    b.pair = sp_alloc(2 * (size_t)b.space.n, sizeof *b.pair);
    b.energy = sp_alloc((size_t)net->n, sizeof *b.energy);
    if (!b.motion || !b.pair || !b.energy)
        status = sp_fail_memory(err, 4 * (size_t)b.space.n * sizeof *b.motion);
    if (status == SP_OK)
        status = start(&b, opt, err);
    if (status == SP_OK)
        status = follow(&b, opt, below, flux, &change, err);
    if (status == SP_OK && drift)
        *drift = change;
    burst_free(&b);
    return status;
}
