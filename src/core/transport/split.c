/* The split of the energy of a band of frequencies: in equilibrium, and long after a pulse. */
#include "base/base.h"
#include "numeric/random.h"
#include "numeric/statistics.h"
#include "transport/packet.h"

#include <math.h>

enum { SOURCES_MAX = 1000, KINDS = 5, PARTS = 8, TIMES_OF_PART = 6 };
static const double PERIODS = 100; /* of omega, before the first time */

sp_split_options sp_split_options_default(void) { return (sp_split_options){.width = 0.1, .sources = 6, .seed = 1}; }

typedef struct splitting {
    const sp_network *net;
    packet_space space;
    packet_map band, step;
    double *motion; /* [dofs][2] */
    double *part;   /* [KINDS][samples] */
} splitting;

static void splitting_free(splitting *s) {
    sp_packet_space_free(&s->space);
    sp_packet_map_free(&s->band);
    sp_packet_map_free(&s->step);
    sp_free(s->motion);
    sp_free(s->part);
}

static sp_status check(double omega, const sp_split_options *opt, sp_error *err) {
    const sp_status status = sp_packet_check_band("split", omega, opt->width, err);
    if (status != SP_OK)
        return status;
    if (opt->sources < 2 || opt->sources > SOURCES_MAX)
        return sp_fail(err, SP_EINVAL, "split: %d random motions, must be 2 .. %d", opt->sources, SOURCES_MAX);
    if (!(opt->from >= 0 && isfinite(opt->from)))
        return sp_fail(err, SP_EINVAL, "split: first time %g, must be 0 or above", opt->from);
    return SP_OK;
}

static sp_status prepare(splitting *s, double omega, double step, const sp_split_options *opt, sp_error *err) {
    const size_t samples = (size_t)(opt->sources > PARTS ? opt->sources : PARTS);
    sp_status status = sp_packet_space_make(s->net, &s->space, err);
    if (status == SP_OK)
        status = sp_packet_band(&s->space, omega, opt->width, &s->band, err);
    if (status == SP_OK)
        status = sp_packet_map_time(s->space.omega, step, &s->step, err);
    if (status != SP_OK)
        return status;
    s->motion = sp_alloc(2 * (size_t)s->space.n, sizeof *s->motion);
    s->part = sp_alloc(KINDS * samples, sizeof *s->part);
    return s->motion && s->part ? SP_OK : sp_fail_memory(err, 2 * (size_t)s->space.n * sizeof *s->motion);
}

/* Adds `weight` times the parts of the energy of the motion to sample `k` of `samples`. */
static sp_status add_parts(splitting *s, int32_t samples, int32_t k, double weight, sp_error *err) {
    double sum[KINDS] = {0}, all = 0;
    const sp_status status = sp_packet_energies(&s->space, s->motion, err);
    for (int32_t i = 0; i < s->net->n && status == SP_OK; i++) {
        const sp_energy *e = &s->space.energy[i];
        const double value[KINDS] = {e->along, e->across, e->rotation, e->normal, e->tangential};
        for (int a = 0; a < KINDS; a++)
            sum[a] += value[a];
        all += sp_energy_sum(e);
    }
    for (int a = 0; a < KINDS && status == SP_OK; a++)
        s->part[a * samples + k] += weight * sum[a] / all;
    return status;
}

static void finish(const splitting *s, int32_t samples, sp_energy *mean, sp_energy *error) {
    double *const m[KINDS] = {&mean->along, &mean->across, &mean->rotation, &mean->normal, &mean->tangential};
    double *const e[KINDS] = {&error->along, &error->across, &error->rotation, &error->normal, &error->tangential};
    for (int a = 0; a < KINDS; a++) {
        *m[a] = sp_mean(samples, s->part + a * samples);
        *e[a] = sp_standard_error(samples, s->part + a * samples);
    }
}

/* Independent displacements and velocities of the same energy in each mode near omega. */
static void randomise(splitting *s, double omega, sp_random *random) {
    for (int64_t q = 0; q < s->space.n; q++) {
        const double root = 1 / sqrt(s->net->mass[q]);
        s->motion[2 * q] = root / omega * (2 * sp_random_uniform(random) - 1);
        s->motion[2 * q + 1] = root * (2 * sp_random_uniform(random) - 1);
    }
}

static sp_status at_rest(splitting *s, double omega, const sp_split_options *opt, sp_split *out, sp_error *err) {
    sp_status status = SP_OK;
    for (int32_t k = 0; k < opt->sources && status == SP_OK; k++) {
        sp_random random = sp_random_make(opt->seed, SP_STREAM_SPREAD);
        random.count = (uint64_t)k << 32;
        randomise(s, omega, &random);
        status = sp_packet_filter(&s->space, &s->band, omega, s->motion, NULL, err);
        if (status == SP_OK)
            status = add_parts(s, opt->sources, k, 1, err);
    }
    if (status == SP_OK)
        finish(s, opt->sources, &out->rest, &out->rest_err);
    return status;
}

static sp_status after_pulse(splitting *s, double omega, const sp_split *times, sp_energy *mean, sp_energy *error,
                             sp_error *err) {
    packet_map wait = {0};
    double drift = 0;
    sp_status status = sp_packet_impulse(&s->space, s->motion, err);
    if (status == SP_OK)
        status = sp_packet_filter(&s->space, &s->band, omega, s->motion, NULL, err);
    for (int64_t q = 0; q < (int64_t)KINDS * PARTS; q++)
        s->part[q] = 0;
    const double before = sp_packet_energy(&s->space, s->motion);
    if (status == SP_OK)
        status = sp_packet_map_time(s->space.omega, times->from, &wait, err);
    if (status == SP_OK)
        sp_packet_apply(&s->space, &wait, s->motion);
    sp_packet_map_free(&wait);
    for (int32_t l = 0; l < PARTS * TIMES_OF_PART && status == SP_OK; l++) {
        status = add_parts(s, PARTS, l / TIMES_OF_PART, 1.0 / TIMES_OF_PART, err);
        sp_packet_apply(&s->space, &s->step, s->motion);
    }
    if (status == SP_OK)
        status = sp_packet_check_drift(sp_packet_energy(&s->space, s->motion) / before, &drift, err);
    if (status == SP_OK)
        finish(s, PARTS, mean, error);
    return status;
}

sp_status sp_split_make(const sp_network *net, double omega, const sp_split_options *opt, sp_split *out,
                        sp_error *err) {
    splitting s = {.net = net};
    const sp_energy none = {NAN, NAN, NAN, NAN, NAN};
    sp_status status = check(omega, opt, err);
    if (status != SP_OK)
        return status;
    const double from = opt->from > 0 ? opt->from : PERIODS * 2 * M_PI / omega;
    sp_split r = {.omega = omega, .pulse = none, .pulse_err = none, .from = from, .until = 2 * from};
    status = prepare(&s, omega, from / (PARTS * TIMES_OF_PART), opt, err);
    if (status == SP_OK)
        status = at_rest(&s, omega, opt, &r, err);
    if (status == SP_OK && sp_network_touches(net, SP_BOTTOM))
        status = after_pulse(&s, omega, &r, &r.pulse, &r.pulse_err, err);
    if (status == SP_OK)
        *out = r;
    splitting_free(&s);
    return status;
}
