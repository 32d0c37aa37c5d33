/* The diffusivity of energy from the decay of a wave of its density. */
#include "base/base.h"
#include "network/network_cell.h"
#include "numeric/random.h"
#include "numeric/statistics.h"
#include "packing/geometry.h"
#include "transport/packet.h"

#include <math.h>

enum { SOURCES_MAX = 1000, WAVES_MAX = 1000, POINTS_MAX = 1200, STEPS_BEFORE_DOUBLING = 24 };

static const double FIT_END = 0.2;        /* of f: below, what is left of the wave is not far above its noise */
static const double END_NEEDED = 0.5;     /* a fit needs f to fall at least to this */
static const double SHIFT_MOST = 1 / 3.0; /* of d, beyond twice its error; for a ballistic motion it exceeds d */
static const double SHIFT_EVER = 2 / 3.0; /* of d */
static const double FIRST_STEP = 0.25;    /* of a period of omega */
/* Over the time at which the fit begins: a decay that is exponential ends at 4.5, and one that has not ended here will
 * be refused. */
static const double PATIENCE = 12;
static const double PERIODS = 300; /* of omega: the last time */

sp_spread_options sp_spread_options_default(void) {
    return (sp_spread_options){.axis = -1, .width = 0.1, .waves = 1, .sources = 6, .seed = 1};
}

typedef struct spreading {
    const sp_network *net;
    const sp_spread_options *opt;
    double omega, until, q;
    packet_space space;
    packet_map step;
    double *wave;   /* [n] cos(q x) of each grain */
    double *motion; /* [2 sources][dofs][2]: densities 1 + cos and 1 - cos in turn */
    double *first;  /* [2 sources] energies at the start */
    int32_t points;
    double *t; /* [POINTS_MAX] */
    double *f; /* [sources][POINTS_MAX] */
    double drift;
} spreading;

static void spreading_free(spreading *s) {
    sp_packet_space_free(&s->space);
    sp_packet_map_free(&s->step);
    sp_free(s->wave);
    sp_free(s->motion);
    sp_free(s->first);
    sp_free(s->t);
    sp_free(s->f);
}

static sp_status check(const sp_network *net, double omega, const sp_spread_options *opt, sp_error *err) {
    const sp_status status = sp_packet_check_band("spread", omega, opt->width, err);
    if (status != SP_OK)
        return status;
    if (opt->axis < -1 || opt->axis >= net->dim)
        return sp_fail(err, SP_EINVAL, "spread: axis %d, must be 0 .. %d", opt->axis, net->dim - 1);
    if (opt->waves < 1 || opt->waves > WAVES_MAX)
        return sp_fail(err, SP_EINVAL, "spread: %d waves, must be 1 .. %d", opt->waves, WAVES_MAX);
    if (opt->sources < 2 || opt->sources > SOURCES_MAX)
        return sp_fail(err, SP_EINVAL, "spread: %d random motions, must be 2 .. %d", opt->sources, SOURCES_MAX);
    if (!(opt->until >= 0 && isfinite(opt->until)))
        return sp_fail(err, SP_EINVAL, "spread: last time %g, must be 0 or above", opt->until);
    return SP_OK;
}

static sp_status allocate(spreading *s, sp_error *err) {
    const size_t n = (size_t)s->space.n, sources = (size_t)s->opt->sources;
    s->wave = sp_alloc((size_t)s->net->n, sizeof *s->wave);
    s->motion = sp_alloc(2 * sources * 2 * n, sizeof *s->motion);
    s->first = sp_alloc(2 * sources, sizeof *s->first);
    s->t = sp_alloc(POINTS_MAX, sizeof *s->t);
    s->f = sp_alloc(sources * POINTS_MAX, sizeof *s->f);
    return s->wave && s->motion && s->first && s->t && s->f ? SP_OK
                                                            : sp_fail_memory(err, 4 * sources * n * sizeof *s->motion);
}

/* The wave fits into the cell: whole periods along a periodic axis, half waves between walls, where no energy leaves.
 */
static void make_wave(spreading *s) {
    const sp_network *net = s->net;
    const int axis = s->opt->axis >= 0 ? s->opt->axis : net->dim - 1;
    double b[3] = {0};
    if (sp_network_periodic(net, axis))
        sp_network_reciprocal(net, axis, b);
    else
        b[axis] = 0.5 / net->box[axis];
    const double factor = 2 * M_PI * s->opt->waves;
    s->q = factor * sqrt(b[0] * b[0] + b[1] * b[1] + b[2] * b[2]);
    for (int64_t i = 0; i < net->n; i++) {
        const double *x = net->x + 3 * i;
        s->wave[i] = cos(factor * (b[0] * x[0] + b[1] * x[1] + b[2] * x[2]));
    }
}

/* Displacements and velocities are independent, so that the energy sets out in no direction. */
static void make_motion(spreading *s, sp_random *random, int sign, double *motion) {
    const sp_network *net = s->net;
    for (int64_t k = 0; k < s->space.n; k++) {
        const double part = sqrt(fmax(0, (1 + sign * s->wave[k / net->dof]) / net->mass[k]));
        motion[2 * k] = part * (2 * sp_random_uniform(random) - 1) / s->omega;
        motion[2 * k + 1] = part * (2 * sp_random_uniform(random) - 1);
    }
}

/* The same random numbers serve both signs. */
static sp_status make_motions(spreading *s, sp_error *err) {
    packet_map band = {0};
    sp_status status = sp_packet_band(&s->space, s->omega, s->opt->width, &band, err);
    for (int32_t l = 0; l < 2 * s->opt->sources && status == SP_OK; l++) {
        double *motion = s->motion + (int64_t)l * 2 * s->space.n;
        sp_random random = sp_random_make(s->opt->seed, SP_STREAM_SPREAD);
        random.count = (uint64_t)(l / 2) << 32;
        make_motion(s, &random, l % 2 == 0 ? 1 : -1, motion);
        status = sp_packet_filter(&s->space, &band, s->omega, motion, &s->first[l], err);
    }
    sp_packet_map_free(&band);
    return status;
}

/* Part of the energy of a motion that has the form of the wave. */
static sp_status part_of_wave(spreading *s, int32_t l, double *part, sp_error *err) {
    double sum = 0, all = 0;
    const sp_status status = sp_packet_energies(&s->space, s->motion + (int64_t)l * 2 * s->space.n, err);
    for (int32_t i = 0; i < s->net->n && status == SP_OK; i++) {
        const double e = sp_energy_sum(&s->space.energy[i]);
        sum += e * s->wave[i];
        all += e;
    }
    *part = sum / all;
    return status == SP_OK ? sp_packet_check_drift(all / s->first[l], &s->drift, err) : status;
}

/* The difference of the two signs: it vanishes when the energy has reached its equilibrium, uniform or not. */
static sp_status note_point(spreading *s, double t, double *mean, sp_error *err) {
    *mean = 0;
    s->t[s->points] = t;
    for (int32_t l = 0; l < s->opt->sources; l++) {
        double plus = 0, minus = 0;
        sp_status status = part_of_wave(s, 2 * l, &plus, err);
        if (status == SP_OK)
            status = part_of_wave(s, 2 * l + 1, &minus, err);
        if (status != SP_OK)
            return status;
        s->f[(int64_t)l * POINTS_MAX + s->points] = plus - minus;
        *mean += (plus - minus) / s->opt->sources;
    }
    s->points++;
    return SP_OK;
}

static void advance(spreading *s) {
    for (int32_t l = 0; l < 2 * s->opt->sources; l++)
        sp_packet_apply(&s->space, &s->step, s->motion + (int64_t)l * 2 * s->space.n);
}

/* Records f until it has fallen. The steps double now and then, because it may fall fast or slowly. */
static sp_status follow(spreading *s, sp_error *err) {
    double t = 0, dt = FIRST_STEP * 2 * M_PI / s->omega, first = 0, mean = 0, until = s->until;
    sp_status status = note_point(s, 0, &first, err);
    mean = first;
    for (int32_t k = 0; status == SP_OK && t < until && mean > 0.8 * FIT_END * first && s->points < POINTS_MAX; k++) {
        if (k % STEPS_BEFORE_DOUBLING == 0) {
            dt *= k > 0 ? 2 : 1;
            sp_packet_map_free(&s->step);
            status = sp_packet_map_time(s->space.omega, dt, &s->step, err);
        }
        if (status == SP_OK) {
            advance(s);
            status = note_point(s, t += dt, &mean, err);
        }
        if (mean > SP_SPREAD_HIGH * first)
            until = fmin(s->until, PATIENCE * (t + dt));
    }
    return status;
}

/* f of all sources but one (none left out: -1), over its value at the start. */
static double left_of_wave(const spreading *s, int32_t without, int32_t point) {
    double now = 0, start = 0;
    for (int32_t l = 0; l < s->opt->sources; l++)
        if (l != without) {
            now += s->f[(int64_t)l * POINTS_MAX + point];
            start += s->f[(int64_t)l * POINTS_MAX];
        }
    return now / start;
}

/* Time at which f falls through a value, interpolated in ln f; NAN if it does not. */
static double time_of(const spreading *s, int32_t without, double value) {
    double before = 1;
    for (int32_t k = 1; k < s->points; k++) {
        const double f = left_of_wave(s, without, k);
        if (f <= value && before > value) {
            if (!(f > 0))
                return NAN;
            return s->t[k - 1] + (s->t[k] - s->t[k - 1]) * log(before / value) / log(before / f);
        }
        before = f;
    }
    return NAN;
}

typedef struct rates {
    double d, shift, from, to;
} rates;

/* From the times at which ln f has fallen to the start, the middle and the end of the fit. */
static rates rates_of(const spreading *s, int32_t without, double low) {
    const double middle = sqrt(SP_SPREAD_HIGH * low), q2 = s->q * s->q;
    const double from = time_of(s, without, SP_SPREAD_HIGH), half = time_of(s, without, middle);
    const double to = time_of(s, without, low), fall = log(SP_SPREAD_HIGH / low) / q2;
    const double early = 0.5 * fall / (half - from), late = 0.5 * fall / (to - half);
    return (rates){fall / (to - from), late - early, from, to};
}

/* Whether a shift of d contradicts diffusion: it is resolved and not small, or so large that its error excuses nothing.
 * A shift that is not a number does. */
static bool contradicts(double shift, double error, double d) {
    return !(fabs(shift) - 2 * error <= SHIFT_MOST * d && fabs(shift) <= SHIFT_EVER * d);
}

static double jackknife(int32_t n, const double *value) { return (n - 1) * sp_standard_error(n, value); }

static sp_status evaluate(const spreading *s, sp_spread *out, sp_error *err) {
    const int32_t n = s->opt->sources;
    const double last = left_of_wave(s, -1, s->points - 1);
    double *d = sp_alloc((size_t)n, 2 * sizeof *d);
    if (!d)
        return sp_fail_memory(err, (size_t)n * 2 * sizeof *d);
    double *shift = d + n;
    out->low = fmax(FIT_END, 1.05 * last);
    const rates all = rates_of(s, -1, out->low);
    for (int32_t l = 0; l < n; l++) {
        const rates r = rates_of(s, l, out->low);
        d[l] = r.d;
        shift[l] = r.shift;
    }
    *out = (sp_spread){.omega = s->omega,
                       .q = s->q,
                       .d = all.d,
                       .d_err = jackknife(n, d),
                       .d_shift = all.shift,
                       .from = all.from,
                       .to = all.to,
                       .low = out->low,
                       .drift = s->drift};
    const double shift_err = jackknife(n, shift);
    if (!(out->low <= END_NEEDED) || contradicts(all.shift, shift_err, all.d))
        out->d = out->d_err = out->d_shift = NAN;
    sp_free(d);
    return SP_OK;
}

static sp_status spread_once(const sp_network *net, double omega, const sp_spread_options *opt, sp_spread *out,
                             sp_error *err) {
    spreading s = {.net = net, .opt = opt, .omega = omega};
    s.until = opt->until > 0 ? opt->until : PERIODS * 2 * M_PI / omega;
    sp_status status = sp_packet_space_make(net, &s.space, err);
    if (status == SP_OK)
        status = allocate(&s, err);
    if (status == SP_OK) {
        make_wave(&s);
        status = make_motions(&s, err);
    }
    if (status == SP_OK)
        status = follow(&s, err);
    if (status == SP_OK)
        status = evaluate(&s, out, err);
    spreading_free(&s);
    return status;
}

/* The rate of decay of a wave of half the length is 4 times as large if the energy diffuses, but twice if it moves
 * freely, and more than 4 times if it is localised. */
sp_status sp_spread_make(const sp_network *net, double omega, const sp_spread_options *opt, sp_spread *out,
                         sp_error *err) {
    sp_spread long_wave, short_wave;
    sp_spread_options half = *opt;
    sp_status status = check(net, omega, opt, err);
    if (status == SP_OK)
        status = sp_cell_need_flat(net->cell, "a wave of the density of energy", err);
    half.waves *= 2;
    if (status == SP_OK)
        status = spread_once(net, omega, opt, &long_wave, err);
    if (status == SP_OK)
        status = spread_once(net, omega, &half, &short_wave, err);
    if (status != SP_OK)
        return status;
    *out = long_wave;
    out->drift = fmax(long_wave.drift, short_wave.drift);
    out->d_half = short_wave.d - long_wave.d;
    if (contradicts(out->d_half, hypot(long_wave.d_err, short_wave.d_err), long_wave.d))
        out->d = out->d_err = out->d_shift = out->d_half = NAN;
    out->d_err = hypot(out->d_err, hypot(out->d_shift, SP_SPREAD_HALVES * out->d_half));
    return SP_OK;
}
