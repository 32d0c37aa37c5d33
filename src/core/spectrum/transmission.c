/* Spectrum of the signal. With psi = asin(omega/Omega), the Bessel series of the signal (docs/physics.md, The signal)
 * and the integral of J_m(Omega t) exp(i omega t) over t > 0, which is exp(i m psi)/(Omega cos psi), give
 *   F^(omega) = 2/(Omega^2 cos psi) sum_k g_(2k+1) w_k exp(i (2k+1) psi),  w_k = <b|W_k|a> = t_0 + 2 sum_(j<=k) t_j,
 * and for displacements 1/(Omega cos psi) [t_0 + 2 sum_k g_2k t_k exp(i 2k psi)], t_k = <b|T_k|a>. g: Jackson's factors
 * of twice the order. */
#include "base/base.h"
#include "network/network_cell.h"
#include "spectrum/moments.h"

#include <float.h>
#include <math.h>
#include <sonopack/spectrum.h>

enum { POINTS_MAX = 10000000, MOMENTS_MAX = 10000000 };

sp_transmission_options sp_transmission_options_default(void) {
    return (sp_transmission_options){
        .source = SP_SOURCE_IMPULSE, .from = sp_place_wall(), .to = sp_place_wall(), .points = 400};
}

sp_transmission sp_transmission_none(void) { return (sp_transmission){0}; }

void sp_transmission_free(sp_transmission *t) {
    sp_free(t->omega);
    *t = sp_transmission_none();
}

static sp_status check(const sp_network *net, const sp_transmission_options *o, sp_error *err) {
    const double omega = sp_network_omega_bound(net);
    if (o->points < 1 || o->points > POINTS_MAX)
        return sp_fail(err, SP_EINVAL, "points = %d, must be 1 .. %d", o->points, POINTS_MAX);
    if (!(omega > 0 && isfinite(omega)))
        return sp_fail(err, SP_EREFUSED, "bound of the spectrum = %g: there are no vibrations", omega);
    if (!(o->until >= 0 && o->until <= omega))
        return sp_fail(err, SP_EINVAL,
                       "until = %g, must be 0 (the whole spectrum), or a frequency up to its bound, %.6g", o->until,
                       omega);
    if (!(o->resolution >= 0 && isfinite(o->resolution)))
        return sp_fail(err, SP_EINVAL, "resolution = %g, must be a width in omega, or 0 for that of a bin",
                       o->resolution);
    return SP_OK;
}

/* Source and detector as the two vectors of displacements. */
static sp_status make_start(const sp_network *net, const sp_transmission_options *o, double **out, sp_error *err) {
    const size_t n = (size_t)sp_network_dofs(net);
    double *start = sp_alloc(2 * n, sizeof *start), *source = sp_alloc(2 * n, sizeof *source);
    sp_status status = start && source ? SP_OK : sp_fail_memory(err, 4 * n * sizeof *source);
    if (status == SP_OK && (o->from.kind == SP_PLACE_WALL || o->to.kind == SP_PLACE_WALL))
        status = sp_network_need_walls(net, "transmission from wall to wall", err);
    if (status == SP_OK)
        status = sp_network_source_at(net, o->source, &o->from, source, err);
    if (status == SP_OK)
        status = sp_network_detector_at(net, &o->to, source + n, err);
    for (size_t k = 0; k < n && status == SP_OK; k++) {
        start[2 * k] = o->source == SP_SOURCE_DISPLACEMENT ? source[k] : source[k] / net->mass[k];
        start[2 * k + 1] = source[n + k] / net->mass[k];
    }
    sp_free(source);
    if (status == SP_OK)
        *out = start;
    else
        sp_free(start);
    return status;
}

/* Coefficients of exp(i m psi), m = 2k + 1 or 2k, with the kernel. *rounding: the sum of their errors. Moment t_k
 * carries the independent errors of about k/2 steps, each a few DBL_EPSILON of |a||b|; w_k is a sum of k of these. */
static void coefficients(const moment_set *m, bool velocity, const double *g, double *c, double *rounding) {
    double w = 0;
    *rounding = 0;
    for (int64_t k = 0; k < m->n; k++) {
        const double steps = 1 + (double)k;
        if (velocity) {
            w += k == 0 ? m->xy[0] : 2 * m->xy[k];
            c[k] = 2 / m->omega * g[2 * k + 1] * w;
            *rounding += 2 / m->omega * g[2 * k + 1] * 16 * steps * DBL_EPSILON * m->reach;
        } else {
            c[k] = (k == 0 ? 1 : 2) * g[2 * k] * m->xy[k];
            *rounding += 2 * g[2 * k] * 16 * sqrt(steps) * DBL_EPSILON * m->reach;
        }
    }
}

static void sum_series(const moment_set *m, bool velocity, const double *c, double rounding, sp_transmission *t) {
    for (int32_t l = 0; l < t->n; l++) {
        const double s = t->omega[l] / m->omega, cosine = sqrt((1 - s) * (1 + s)), psi = asin(s);
        const double turn_re = cos(2 * psi), turn_im = sin(2 * psi), scale = 1 / (m->omega * cosine);
        double re = 0, im = 0;
        for (int64_t k = m->n - 1; k >= 0; k--) { /* Horner */
            const double old = re;
            re = old * turn_re - im * turn_im + c[k];
            im = old * turn_im + im * turn_re;
        }
        const double first_re = velocity ? cosine : 1, first_im = velocity ? s : 0;
        t->re[l] = scale * (re * first_re - im * first_im);
        t->im[l] = scale * (re * first_im + im * first_re);
        t->density[l] = 2 / 3.14159265358979323846 * (velocity ? t->im[l] : t->re[l]);
        t->error[l] = scale * rounding;
    }
}

/* Rounding of Horner's scheme with n terms and a rounded angle: 8 DBL_EPSILON n times the size of the terms. */
static double horner_rounding(int64_t n, const double *c) {
    double sum = 0;
    for (int64_t k = 0; k < n; k++)
        sum += fabs(c[k]) * (double)(k + 1);
    return 8 * DBL_EPSILON * sum;
}

static sp_status allocate(const sp_network *net, const sp_transmission_options *o, sp_transmission *t, sp_error *err) {
    const size_t n = (size_t)o->points;
    t->n = o->points;
    t->omega_max = sp_network_omega_bound(net);
    const double until = o->until > 0 ? o->until : t->omega_max;
    const double wanted = o->resolution > 0 ? o->resolution : until / o->points;
    if (!(1.6 * t->omega_max / wanted + 2 < MOMENTS_MAX))
        return sp_fail(err, SP_EINVAL, "resolution = %g needs %.3g moments, must be at most %d", wanted,
                       1.6 * t->omega_max / wanted, MOMENTS_MAX);
    t->moments = sp_moments_for_width(t->omega_max, wanted);
    t->resolution = sp_moments_width(t->omega_max, t->moments);
    t->omega = sp_alloc(5 * n, sizeof *t->omega);
    if (!t->omega)
        return sp_fail_memory(err, 5 * n * sizeof *t->omega);
    t->density = t->omega + n;
    t->re = t->omega + 2 * n;
    t->im = t->omega + 3 * n;
    t->error = t->omega + 4 * n;
    for (size_t l = 0; l < n; l++)
        t->omega[l] = until * ((double)l + 0.5) / (double)n;
    return SP_OK;
}

sp_status sp_transmission_make(const sp_network *net, const sp_transmission_options *opt, sp_transmission *out,
                               sp_error *err) {
    const bool velocity = opt->source != SP_SOURCE_DISPLACEMENT;
    sp_transmission t = sp_transmission_none();
    moment_set m = {0};
    double *start = NULL, *g = NULL, *c = NULL, rounding;
    sp_status status = check(net, opt, err);
    if (status == SP_OK)
        status = allocate(net, opt, &t, err);
    if (status == SP_OK)
        status = make_start(net, opt, &start, err);
    if (status == SP_OK)
        status = sp_moments_make(net, t.moments, start, &m, err);
    if (status != SP_OK)
        goto out;
    g = sp_alloc(2 * (size_t)t.moments, sizeof *g);
    c = sp_alloc((size_t)t.moments, sizeof *c);
    if (!g || !c) {
        status = sp_fail_memory(err, 3 * (size_t)t.moments * sizeof *g);
        goto out;
    }
    sp_moments_jackson(2 * t.moments, g);
    coefficients(&m, velocity, g, c, &rounding);
    sum_series(&m, velocity, c, rounding + horner_rounding(m.n, c), &t);
out:
    sp_free(c);
    sp_free(g);
    sp_free(start);
    sp_moments_free(&m);
    if (status == SP_OK)
        *out = t;
    else
        sp_transmission_free(&t);
    return status;
}
