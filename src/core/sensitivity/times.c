/* Derivatives of the signal at all times. With A_j = P_j M^-1 a and V_i = U_i M^-1 b, moment k changes by -(4/Omega^2)
 * sum over i + j = k - 1 of V_i.dK A_j: the stretches of a spring in both expansions give it by a convolution. */
#include "base/base.h"
#include "base/vector.h"
#include "modes/count.h"
#include "network/place.h"
#include "numeric/bessel.h"
#include "sensitivity/forward.h"
#include "sensitivity/gradient.h"
#include "sensitivity/products.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { PARTS_MAX = 4 };
/* Bytes of stretches that are kept at once; more springs take further passes. */
#define MEMORY 2.5e8

typedef struct times_job {
    const forward *f;
    int32_t times;
    int64_t terms;
    double *j;       /* [times][terms] coefficients of the moments */
    double largest;  /* the largest sum of their sizes */
    int parts;       /* stretches of a spring: along n, and tangential ones */
    double *row;     /* [2][springs at once][parts][terms + 1] of A and of V */
    double *moments; /* [2][terms] */
} times_job;

static void job_free(times_job *job) {
    sp_free(job->j);
    sp_free(job->row);
    sp_free(job->moments);
}

static sp_status set_coefficients(times_job *job, const double *t, sp_error *err) {
    const forward *f = job->f;
    double last = 0;
    for (int32_t l = 0; l < job->times; l++)
        last = fmax(last, t[l]);
    const int64_t orders = sp_bessel_orders(f->omega * last);
    double *all = sp_alloc((size_t)orders, sizeof *all);
    job->terms = orders / 2;
    job->j = sp_alloc((size_t)job->times, (size_t)job->terms * sizeof *job->j);
    job->moments = sp_alloc(2, (size_t)job->terms * sizeof *job->moments);
    if (!all || !job->j || !job->moments) {
        sp_free(all);
        return sp_fail_memory(err, (size_t)job->times * (size_t)job->terms * sizeof *all);
    }
    for (int32_t l = 0; l < job->times; l++) {
        double sum = 0, *to = job->j + (int64_t)l * job->terms;
        sp_bessel_j(f->omega * t[l], orders, all);
        for (int64_t k = 0; k < job->terms; k++) {
            to[k] = (f->velocity ? 2 / f->omega : k == 0 ? 1 : 2) * all[2 * k + f->velocity];
            sum += fabs(to[k]);
        }
        job->largest = fmax(job->largest, sum);
    }
    sp_free(all);
    return SP_OK;
}

/* Stretches of a spring in a lane of the recurrence. */
static void stretch(const forward *f, const sp_spring *s, const double *u, int lane, int64_t stride, double *out) {
    const sp_operator *op = &f->op;
    const sp_network *net = f->net;
    const int64_t i = (int64_t)op->row_of[s->i] * op->row, j = (s->j < 0 ? op->n : op->row_of[s->j]) * (int64_t)op->row;
    double x[SP_LOCAL_MAX], across[3];
    for (int a = 0; a < net->dof; a++) {
        const double one = u[i + quad_component(a) + lane], two = u[j + quad_component(a) + lane];
        x[a] = a < net->dim ? two - one : one + two;
    }
    out[0] = sp_products_along(net, s->n, x);
    if (net->dof == net->dim)
        return;
    sp_products_across(net, s->n, x, across);
    for (int a = 0; a < (net->dim == 2 ? 1 : 3); a++)
        out[(1 + a) * stride] = across[a];
}

/* One pass of both fields for the springs first .. first + count - 1 of the list. */
static sp_status record(times_job *job, const int32_t *spring, int32_t first, int32_t count, sp_error *err) {
    const forward *f = job->f;
    const int64_t stride = job->terms + 1;
    recurrence r;
    sp_status status = sp_recurrence_make(&f->op, f->net->mass, f->omega, 1, &r, err);
    if (status != SP_OK)
        return status;
    sp_recurrence_start(&r, 0, f->velocity, &f->from);
    sp_recurrence_start(&r, 1, true, &f->to);
    for (int64_t k = 0; k < f->to.n; k++) /* U_(-1) = 0 */
        r.v[f->to.at[k] + 1] *= 0.5;
    for (int64_t k = 0; k <= job->terms; k++) {
        for (int32_t c = 0; c < count; c++)
            for (int lane = 0; lane < 2; lane++)
                stretch(f, &f->net->springs[spring ? spring[first + c] : first + c], r.u, lane, stride,
                        job->row + ((int64_t)lane * count + c) * job->parts * stride + k);
        sp_recurrence_step(&r);
    }
    const double growth = (2 * (double)r.step + 1) * sp_expansion_growth(0);
    if (!(sp_recurrence_squares(&r)[1] <= growth * growth * r.start[1]))
        status = sp_fail(err, SP_EREFUSED, "the motion grows without bound: the network is unstable (prestress)");
    sp_recurrence_free(&r);
    return status;
}

/* Adds the convolution of two sequences to moments 1, 2, ... */
static void convolve(int64_t terms, bool velocity, double factor, const double *a, const double *v, double *moments) {
    for (int64_t j = 0; j + 1 < terms; j++) {
        const double x = factor * a[j] * (j == 0 && !velocity ? 0.5 : 1);
        double *restrict to = moments + j + 1;
        const double *restrict from = v;
        for (int64_t i = 0; i + j + 1 < terms; i++)
            to[i] += x * from[i];
    }
}

/* What a change of the spring makes of the detector: -(gap) A_k, and of the source: -(gap) P_k M^-1 b, where P is W_k =
 * U_k + U_(k-1) or T_k = (U_k - U_(k-2))/2. */
static void add_places(const times_job *job, int32_t k, int part, const double *a, const double *v, double *moments) {
    const forward *f = job->f;
    const sp_network *net = f->net;
    const sp_spring *s = &net->springs[k];
    for (int which = 0; which < 2; which++) {
        double x[SP_LOCAL_MAX] = {0}, across[3], size;
        for (int q = 0; q < net->dim; q++)
            x[q] = f->gap[which][3 * (int64_t)k + q];
        sp_products_across(net, s->n, x, across);
        size = part == 0 ? sp_products_along(net, s->n, x) : across[part - 1];
        if (which == 0 && f->source != SP_SOURCE_IMPULSE)
            size *= net->mass[(int64_t)s->i * net->dof];
        if (size == 0)
            continue;
        for (int64_t q = 0; q < job->terms; q++) {
            const double back = q == 0 ? 0 : f->velocity ? v[q - 1] : q == 1 ? 0 : -v[q - 2];
            const double field = f->velocity ? v[q] + back : q == 0 ? v[0] : 0.5 * (v[q] + back);
            moments[q] -= size * (which == 0 ? field : a[q]);
        }
    }
}

static void sum_times(const times_job *job, const double *moments, double *out) {
    for (int32_t l = 0; l < job->times; l++) {
        const double *restrict j = job->j + (int64_t)l * job->terms;
        double sum = 0;
        for (int64_t k = 0; k < job->terms; k++)
            sum += j[k] * moments[k];
        out[l] = sum;
    }
}

/* Both derivatives of one spring from its stretches. */
static void differentiate(times_job *job, int32_t k, const double *a, const double *v, double *kn, double *kt,
                          double *error) {
    const forward *f = job->f;
    const int64_t stride = job->terms + 1;
    const double factor = -4 / (f->omega * f->omega);
    for (int which = 0; which < 2; which++) {
        double *moments = job->moments, *to = which == 0 ? kn : kt, size = 0;
        memset(moments, 0, (size_t)job->terms * sizeof *moments);
        for (int part = which; part < (which == 0 ? 1 : job->parts); part++) {
            convolve(job->terms, f->velocity, factor, a + part * stride, v + part * stride, moments);
            add_places(job, k, part, a + part * stride, v + part * stride, moments);
            size += sp_norm(job->terms, a + part * stride) * sp_norm(job->terms, v + part * stride);
        }
        if (to)
            sum_times(job, moments, to);
        if (error)
            error[which] =
                5 * DBL_EPSILON * sqrt(1 + (double)job->terms) * -factor * size * job->largest +
                1e-18 * -factor * f->norm_a * f->norm_b * sp_products_mobility(f->net, &f->net->springs[k], which == 1);
    }
}

static sp_status run(times_job *job, int32_t springs, const int32_t *spring, double *kn, double *kt, double *error,
                     sp_error *err) {
    const int64_t stride = job->terms + 1, own = 2 * job->parts * stride;
    const int32_t most = (int32_t)fmax(1, fmin(springs, MEMORY / (8 * (double)own)));
    job->row = sp_alloc((size_t)most, (size_t)own * sizeof *job->row);
    if (!job->row)
        return sp_fail_memory(err, (size_t)most * (size_t)own * sizeof *job->row);
    sp_status status = SP_OK;
    for (int32_t first = 0; first < springs && status == SP_OK; first += most) {
        const int32_t count = springs - first < most ? springs - first : most;
        status = record(job, spring, first, count, err);
        for (int32_t c = 0; c < count && status == SP_OK; c++) {
            const int64_t at = first + c, size = job->parts * stride;
            differentiate(job, spring ? spring[at] : (int32_t)at, job->row + c * size,
                          job->row + ((int64_t)count + c) * size, kn ? kn + at * job->times : NULL,
                          kt ? kt + at * job->times : NULL, error ? error + 2 * at : NULL);
        }
    }
    return status;
}

static sp_status check(const sp_network *net, const sp_sensitivity_options *opt, int32_t springs, const int32_t *spring,
                       int32_t times, const double *t, sp_error *err) {
    if (springs < 1 || (!spring && springs != net->n_springs))
        return sp_fail(err, SP_EINVAL, "%d springs, must be 1 or more, or all %d", springs, net->n_springs);
    for (int32_t k = 0; k < springs && spring; k++)
        if (spring[k] < 0 || spring[k] >= net->n_springs)
            return sp_fail(err, SP_EINVAL, "spring %d, must be 0 .. %d", spring[k], net->n_springs - 1);
    if (times < 1 || !t)
        return sp_fail(err, SP_EINVAL, "%d times, must be 1 or more", times);
    for (int32_t l = 0; l < times; l++)
        if (!(t[l] >= 0 && 0.5 * sp_network_omega_bound(net) * t[l] < 1e6))
            return sp_fail(err, SP_EINVAL, "time %g, must be 0 or above and below %.4g", t[l],
                           2e6 / sp_network_omega_bound(net));
    if (opt->pulse && opt->pulse->kind != SP_PULSE_DELTA)
        return sp_fail(err, SP_EINVAL, "pulse: derivatives at all times are those of the short pulse");
    if (opt->from && opt->from->shear && opt->from->kind != SP_PLACE_PLANE && opt->source != SP_SOURCE_IMPULSE)
        return sp_fail(err, SP_EINVAL, "a source along x, must be an impulse for derivatives at all times");
    return SP_OK;
}

sp_status sp_sensitivity_times(const sp_network *net, const sp_sensitivity_options *opt, int32_t springs,
                               const int32_t *spring, int32_t times, const double *t, double *kn, double *kt,
                               double *error, sp_error *err) {
    sp_status status = sp_gradient_check(net, SP_BY_KN, NULL, err);
    forward f = {0};
    double last = 0;
    if (status == SP_OK)
        status = check(net, opt, springs, spring, times, t, err);
    for (int32_t l = 0; l < times && status == SP_OK; l++)
        last = fmax(last, t[l]);
    if (status == SP_OK && last > 0)
        status = sp_need_bounded(net, last, err);
    if (status == SP_OK)
        status = sp_forward_make(net, opt, 16, 16, &f, err);
    if (status != SP_OK)
        return status;
    times_job job = {.f = &f, .times = times, .parts = net->dof == net->dim ? 1 : net->dim == 2 ? 2 : PARTS_MAX};
    status = set_coefficients(&job, t, err);
    if (status == SP_OK)
        status = run(&job, springs, spring, kn, kt, error, err);
    job_free(&job);
    sp_forward_free(&f);
    return status;
}
