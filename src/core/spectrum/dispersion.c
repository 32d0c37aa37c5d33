/* Dispersion relation of plane and standing waves, from moments of their spectral functions. */
#include "base/base.h"
#include "base/vector.h"
#include "linalg/arrays.h"
#include "network/network_cell.h"
#include "packing/geometry.h"
#include "spectrum/moments.h"

#include <float.h>
#include <math.h>
#include <sonopack/spectrum.h>
#include <string.h>

enum { WAVES_MAX = 100000, PROFILE_MAX = 1000000, MOMENTS_MAX = 10000000 };

sp_dispersion_options sp_dispersion_options_default(void) { return (sp_dispersion_options){.waves = 8}; }

sp_dispersion sp_dispersion_none(void) { return (sp_dispersion){0}; }

void sp_dispersion_free(sp_dispersion *d) {
    sp_free(d->wave);
    sp_free(d->omega);
    sp_free(d->s);
    *d = sp_dispersion_none();
}

/* The axis of the waves. */
static int axis_of(const sp_network *net, const sp_dispersion_options *o) {
    return o->up ? net->dim - 1 : o->along_y ? 1 : 0;
}

static sp_status check(const sp_network *net, const sp_dispersion_options *o, sp_error *err) {
    if (o->waves < 1 || o->waves > WAVES_MAX)
        return sp_fail(err, SP_EINVAL, "waves = %d, must be 1 .. %d", o->waves, WAVES_MAX);
    if (!o->up && net->dim < 2)
        return sp_fail(err, SP_EINVAL, "waves along x in one dimension, must be up");
    if (o->along_y && (o->up || net->dim < 3))
        return sp_fail(err, SP_EINVAL, "waves along y%s, must be in three dimensions, where z is up",
                       o->up ? " and up" : "");
    if (o->node > 0 && sp_network_periodic(net, axis_of(net, o)))
        return sp_fail(err, SP_EINVAL, "node = %g, but there are no walls across these waves", o->node);
    if (!(o->node >= 0 && isfinite(o->node)))
        return sp_fail(err, SP_EINVAL, "node = %g, must be a distance behind the walls, 0 or more", o->node);
    if (!(o->resolution >= 0 && isfinite(o->resolution)))
        return sp_fail(err, SP_EINVAL, "resolution = %g, must be a width in omega, or 0 for Omega/200", o->resolution);
    if (o->profile < 0 || o->profile > PROFILE_MAX)
        return sp_fail(err, SP_EINVAL, "profile = %d, must be 0 .. %d", o->profile, PROFILE_MAX);
    const double omega = sp_network_omega_bound(net);
    if (!(omega > 0 && isfinite(omega)))
        return sp_fail(err, SP_EREFUSED, "bound of the spectrum = %g: there are no vibrations", omega);
    if (o->resolution > 0 && !(1.6 * omega / o->resolution < MOMENTS_MAX))
        return sp_fail(err, SP_EINVAL, "resolution = %g needs %.3g moments, must be at most %d", o->resolution,
                       1.6 * omega / o->resolution, MOMENTS_MAX);
    return SP_OK;
}

/* Removes from v its part along the direction of w, and scales it to 1. */
static void turn_away(const double w[3], double v[3]) {
    const double part = dot3(v, w) / dot3(w, w);
    for (int a = 0; a < 3; a++)
        v[a] -= part * w[a];
    const double size = length3(v);
    for (int a = 0; a < 3; a++)
        v[a] /= size;
}

/* The degrees of freedom that a polarization moves, as a vector of unit length. False: the network has none. The
 * lattice vectors of a tilted cell are not upright on each other, but displacements are along k, or across it. */
static bool direction(const sp_network *net, const sp_dispersion_options *o, sp_polarization p, double moved[6]) {
    const int axis = axis_of(net, o), vertical = net->dim - 1;
    double k[3];
    memset(moved, 0, 6 * sizeof *moved);
    sp_network_reciprocal(net, axis, k);
    switch (p) {
    case SP_LONGITUDINAL:
        for (int a = 0; a < 3; a++)
            moved[a] = k[a] / length3(k);
        return true;
    case SP_TRANSVERSE:
        if (net->dim < 2)
            return false;
        moved[axis == vertical ? 0 : vertical] = 1;
        turn_away(k, moved);
        return true;
    default:
        if (net->dof == net->dim)
            return false;
        moved[net->dim == 2 ? 2 : net->dim + (axis == 1 ? 0 : 1)] = 1;
        return true;
    }
}

/* Wave vector of wave n, 0 on other axes: it fits between the walls, with nodes there, or into the period. */
static void wave_vector(const sp_network *net, const sp_dispersion_options *o, int32_t n, double k[3]) {
    const int axis = axis_of(net, o);
    sp_network_reciprocal(net, axis, k);
    for (int a = 0; a < 3; a++)
        k[a] *= 2 * M_PI * n;
    if (sp_network_periodic(net, axis))
        k[axis] = 2 * M_PI * n / net->box[axis];
    else
        k[axis] = M_PI * n / (net->box[axis] + 2 * o->node);
}

/* The wave as displacements: the cosine and sine of a plane wave, which form a complex wave, or a single standing wave;
 * scaled to |q| = 1. */
static sp_status make_wave(const sp_network *net, const sp_dispersion_options *o, const double moved[6],
                           sp_dispersion_point *w, double *start, sp_error *err) {
    const int axis = axis_of(net, o);
    const bool standing = !sp_network_periodic(net, axis);
    double norm = 0, all = 0, wave[3];
    wave_vector(net, o, w->n, wave);
    w->k = length3(wave);
    for (int32_t i = 0; i < net->n; i++) {
        double x[3];
        for (int a = 0; a < 3; a++)
            x[a] = net->x[3 * (int64_t)i + a] + (standing && a == axis ? o->node : 0);
        const double phase = dot3(wave, x);
        for (int a = 0; a < net->dof; a++) {
            const int64_t k = (int64_t)i * net->dof + a;
            start[2 * k] = moved[a] * (standing ? sin(phase) : cos(phase));
            start[2 * k + 1] = standing ? 0 : moved[a] * sin(phase);
            norm += net->mass[k] * (start[2 * k] * start[2 * k] + start[2 * k + 1] * start[2 * k + 1]);
            all += net->mass[k] * moved[a] * moved[a];
        }
    }
    if (!(norm > 1e-20 * all))
        return sp_fail(err, SP_EREFUSED, "wave %d moves no grain: all grains are at its nodes", w->n);
    for (int64_t k = 0; k < 2 * sp_network_dofs(net); k++)
        start[k] /= sqrt(norm);
    return SP_OK;
}

/* q . A q as a sum of squares over springs, and |A q|^2. u, force: scratch. */
static void exact_moments(const sp_network *net, const double *start, double *u, double *force,
                          sp_dispersion_point *w) {
    const int64_t n = sp_network_dofs(net);
    double second = 0, fourth = 0;
    for (int lane = 0; lane < 2; lane++) {
        for (int64_t k = 0; k < n; k++)
            u[k] = start[2 * k + lane];
        second += sp_network_energy2(net, u);
        sp_network_apply(net, u, force);
        for (int64_t k = 0; k < n; k++)
            fourth += force[k] * force[k] / net->mass[k];
    }
    w->rms = sqrt(fmax(second, 0));
    w->spread = w->rms > 0 ? sqrt(fmax(fourth - second * second, 0)) / (2 * w->rms) : 0;
}

/* A smoothed spectral function per unit of phi. The kernel has the same width at all phi, so peak heights show the
 * strength of lines. */
typedef struct spectral {
    double omega;
    int64_t n;
    const double *g, *mu;
} spectral;

static double value(const spectral *s, double at) {
    const double frequency = fmin(at, s->omega * (1 - DBL_EPSILON)); /* the limit at Omega */
    return sp_moments_density(s->omega, s->n, s->g, s->mu, frequency) *
           cos(0.5 * sp_moments_phase(s->omega, frequency));
}

/* Where S falls to `half` between a (above) and b (below). */
static double crossing(const spectral *s, double half, double a, double b) {
    for (int k = 0; k < 50; k++) {
        const double c = 0.5 * (a + b);
        if (value(s, c) > half)
            a = c;
        else
            b = c;
    }
    return 0.5 * (a + b);
}

/* Where S falls to `half` on one side of the peak, in steps of the grid from index `best`; NAN: nowhere. */
static double half_point(const spectral *s, double half, double peak, int64_t best, int64_t step, int64_t steps) {
    for (int64_t l = best + step; l >= 0 && l < steps; l += step) {
        const double at = s->omega * sin(0.5 * (M_PI / (double)steps) * (double)l);
        if (value(s, at) <= half)
            return crossing(s, half, peak, at);
    }
    return NAN;
}

/* Finds the largest value on a grid with four points per kernel width, even in phi, and refines it by ternary
 * search. */
static void find_peak(const spectral *s, sp_dispersion_point *w) {
    const int64_t steps = 4 * s->n;
    const double turn = M_PI / (double)steps;
    int64_t best = 0;
    double most = -HUGE_VAL;
    for (int64_t l = 0; l < steps; l++) {
        const double here = value(s, s->omega * sin(0.5 * turn * (double)l));
        if (here > most) {
            most = here;
            best = l;
        }
    }
    double low = turn * (double)(best > 0 ? best - 1 : 0), high = turn * (double)(best + 1);
    for (int k = 0; k < 60; k++) {
        const double a = low + (high - low) / 3, b = high - (high - low) / 3;
        if (value(s, s->omega * sin(0.5 * a)) < value(s, s->omega * sin(0.5 * b)))
            low = a;
        else
            high = b;
    }
    w->peak = s->omega * sin(0.25 * (low + high));
    const double half = 0.5 * value(s, w->peak), part = w->peak / s->omega;
    const double below = half_point(s, half, w->peak, best, -1, steps);
    const double above = half_point(s, half, w->peak, best, 1, steps);
    w->half_width = isnan(above) ? w->peak - below : isnan(below) ? above - w->peak : 0.5 * (above - below);
    w->resolution = sp_moments_width(s->omega, s->n) * sqrt(fmax(1 - part * part, 0));
}

typedef struct scratch {
    double *start, *u, *force, *g, *memory;
} scratch;

static sp_status one_wave(const sp_network *net, const sp_dispersion_options *o, sp_polarization p, int32_t n,
                          const scratch *x, sp_dispersion *d, sp_error *err) {
    sp_dispersion_point w = {.polarization = p, .n = n};
    moment_set m = {0};
    double moved[6];
    direction(net, o, p, moved);
    sp_status status = make_wave(net, o, moved, &w, x->start, err);
    if (status == SP_OK)
        status = sp_moments_make(net, d->moments, x->start, &m, err);
    if (status != SP_OK)
        return status;
    exact_moments(net, x->start, x->u, x->force, &w);
    for (int64_t k = 0; k < m.n; k++)
        m.xx[k] += m.yy[k]; /* moments of the complex wave */
    const spectral s = {m.omega, m.n, x->g, m.xx};
    find_peak(&s, &w);
    for (int32_t l = 0; l < d->profile; l++)
        d->s[(int64_t)d->n * d->profile + l] = sp_moments_density(m.omega, m.n, x->g, m.xx, d->omega[l]);
    sp_moments_free(&m);
    d->wave[d->n++] = w;
    return SP_OK;
}

static sp_status allocate(const sp_network *net, const sp_dispersion_options *o, scratch *x, sp_dispersion *d,
                          sp_error *err) {
    const size_t dofs = (size_t)sp_network_dofs(net), waves = (size_t)SP_POLARIZATIONS * (size_t)o->waves;
    d->omega_max = sp_network_omega_bound(net);
    d->moments = sp_moments_for_width(d->omega_max, o->resolution > 0 ? o->resolution : d->omega_max / 200);
    d->profile = o->profile;
    d->wave = sp_alloc(waves, sizeof *d->wave);
    if (o->profile > 0) {
        d->omega = sp_alloc((size_t)o->profile, sizeof *d->omega);
        d->s = sp_alloc(waves, (size_t)o->profile * sizeof *d->s);
    }
    if (!d->wave || (o->profile > 0 && (!d->omega || !d->s)))
        return sp_fail_memory(err, waves * (sizeof *d->wave + (size_t)o->profile * sizeof(double)));
    const sp_array arrays[] = {
        {&x->start, 2 * dofs}, {&x->u, dofs}, {&x->force, dofs}, {&x->g, (size_t)d->moments}, {0}};
    const sp_status status = sp_arrays_make(arrays, &x->memory, err);
    if (status != SP_OK)
        return status;
    sp_moments_jackson(d->moments, x->g);
    for (int32_t l = 0; l < d->profile; l++)
        d->omega[l] = d->omega_max * (l + 0.5) / d->profile;
    return SP_OK;
}

sp_status sp_dispersion_make(const sp_network *net, const sp_dispersion_options *opt, sp_dispersion *out,
                             sp_error *err) {
    sp_dispersion d = sp_dispersion_none();
    scratch x = {0};
    sp_status status = check(net, opt, err);
    if (status == SP_OK)
        status = sp_cell_need_flat(net->cell, "a dispersion relation", err);
    if (status == SP_OK)
        status = sp_network_need_symmetry(net, "a dispersion relation", err);
    if (status != SP_OK)
        return status;
    status = allocate(net, opt, &x, &d, err);
    for (int p = 0; p < SP_POLARIZATIONS; p++) {
        double moved[6];
        const bool exists = direction(net, opt, (sp_polarization)p, moved);
        for (int32_t n = 1; n <= opt->waves && exists && status == SP_OK; n++)
            status = one_wave(net, opt, (sp_polarization)p, n, &x, &d, err);
    }
    sp_free(x.memory);
    if (status == SP_OK)
        *out = d;
    else
        sp_dispersion_free(&d);
    return status;
}
