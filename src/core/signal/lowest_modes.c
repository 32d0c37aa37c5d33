/* Signals as a sum over the lowest modes, with a bound of the contribution of the others.
 * With A = M^-1/2 K M^-1/2 and mass-weighted source a and detector b, let V be the modes found (A V = V D + R with
 * residuals R), a = V c + a', and b = V d + b'. The signal F = b^T s(A) a, s(x) = sin(sqrt(x) t)/sqrt(x), is
 *   d^T s(D) c  +  b'^T s(A) a'  +  terms with R, by Duhamel's formula.
 * The second term is at most |b'| |A^-1/2 a'|, or |a'| |A^-1/2 b'|, and a solve gives a'^T A^-1 a'. The bound needs no
 * frequencies beyond those found.
 *
 * Zero modes stretch no spring and so give no force on a detector: b has no part in their space. They are left out, and
 * a' is taken without its part there, which A^-1/2 does not allow for. Of that part the bound keeps the product with
 * the part of b, which is rounding. */
#include "base/base.h"
#include "base/vector.h"
#include "modes/refine.h"
#include "modes/slices.h"
#include "signal/job.h"

#include <float.h>
#include <math.h>
#include <sonopack/modes.h>

enum { LANES = SP_LDL_LANES, FIRST_TRY = 64 };

/* Projections of a source or a detector. */
typedef struct projection {
    double *c;                              /* [modes] projections on the modes */
    double *leak;                           /* [modes] projections of the remainder: rounding errors */
    double norm, inverse;                   /* |a|, |A^-1/2 a| */
    double null;                            /* norm of the part in the space of the null motions */
    double rest, rest_inverse, rest_energy; /* remainder a': |a'|, |A^-1/2 a'|, |A^1/2 a'| */
    double residuals;                       /* sum of |R_k| |c_k| w_k, w = 1/omega_k, or 1 for displacements */
} projection;

typedef struct sum {
    const signal_job *job;
    sp_modes m;
    int64_t modes;       /* rows of the table that belong to the network, not to rattlers */
    const double *omega; /* [modes] */
    double *residual;    /* [modes] upper bound of |A e - omega^2 e| */
    slicer z;            /* holds the factor of A + depth */
    double depth;
    projection *from, *to;
    double *numbers; /* memory of c and leak */
} sum;

static void sum_free(sum *q) {
    sp_modes_free(&q->m);
    sp_slicer_free(&q->z);
    sp_free(q->residual);
    sp_free(q->from);
    sp_free(q->to);
    sp_free(q->numbers);
}

/* min(t, 1/omega): largest displacement of a mode per unit of momentum. */
static double reach(const sum *q, int64_t k) {
    const double t = q->job->options->until;
    return q->omega[k] * t > 1 ? 1 / q->omega[k] : t;
}

/* Weight of a mode in the sums with residuals. */
static double residual_weight(const sum *q, int64_t k) { return job_has_momenta(q->job) ? reach(q, k) : 1; }

static sp_status find_residuals(sum *q, sp_error *err) {
    const sp_network *net = q->job->net;
    const int64_t n = q->m.dofs;
    const double noise = 8 * DBL_EPSILON * sp_network_omega_bound(net) * sp_network_omega_bound(net);
    double *u = sp_alloc((size_t)n, sizeof *u), *r = sp_alloc((size_t)n, sizeof *r);
    q->residual = sp_alloc((size_t)q->modes, sizeof *q->residual);
    sp_status status = u && r && q->residual ? SP_OK : sp_fail_memory(err, 2 * (size_t)n * sizeof *u);
    for (int64_t k = 0; k < q->modes && status == SP_OK; k++) {
        sp_mode_residual(net, q->m.vectors + k * n, q->omega[k] * q->omega[k], u, r);
        q->residual[k] = sp_norm(n, r) + noise;
    }
    sp_free(r);
    sp_free(u);
    return status;
}

/* rest <- rest - V (V^T rest); adds the projections to c. */
static void remove_modes(const sum *q, double *rest, double *c) {
    const int64_t n = q->m.dofs;
    for (int64_t k = 0; k < q->modes; k++) {
        const double *e = q->m.vectors + k * n;
        const double part = sp_dot(n, e, rest);
        for (int64_t i = 0; i < n; i++)
            rest[i] -= part * e[i];
        c[k] += part;
    }
}

/* No frequency that is left out is below this, but zeros. Where all are known, those beyond the sum are not kept. */
static double lowest_omitted(const sum *q) {
    const double last = fmax(q->omega[q->modes - 1], sqrt(sp_zero_limit(q->job->net)));
    return isfinite(q->m.certified_to) ? q->m.certified_to : last;
}

/* Upper bound of r . B^-1 r with B = A + depth, from x, which nearly solves B x = r: with what is left, l = r - B x, it
 * is x . (r + l) + l . B^-1 l, and B^-1 is at most 1/depth. work: [2][dofs]. */
static double inverse_square(const sum *q, const double *r, const double *x, double *work) {
    const int64_t n = q->m.dofs;
    double *bx = work + n, product = 0, left = 0;
    sp_mode_residual(q->job->net, x, -q->depth, work, bx);
    for (int64_t i = 0; i < n; i++) {
        const double l = r[i] - bx[i];
        product += x[i] * (r[i] + l);
        left += l * l;
    }
    return fmax(product, 0) + left / q->depth;
}

/* Norms of up to eight vectors, as many as a solve takes. places: [count][dofs], momenta or displacements of sources,
 * or detectors. work: [2][dofs]. */
static void project(sum *q, const double *places, bool source, int count, projection *out, double *rest, double *solved,
                    double *work) {
    const sp_network *net = q->job->net;
    const int64_t n = q->m.dofs;
    const bool moved = source && !job_has_momenta(q->job);
    for (int64_t i = 0; i < LANES * n; i++)
        rest[i] = 0;
    for (int p = 0; p < count; p++) {
        double *r = rest + p * n;
        for (int64_t i = 0; i < n; i++) {
            const double root = sqrt(net->mass[i]);
            r[i] = moved ? places[p * n + i] * root : places[p * n + i] / root;
            out[p].norm += r[i] * r[i];
        }
        out[p].norm = sqrt(out[p].norm);
        out[p].null = sp_null_motions_remove(net, &q->z.null, r);
        remove_modes(q, r, out[p].c);
        remove_modes(q, r, out[p].c); /* twice, since V is orthonormal only up to rounding */
        for (int64_t k = 0; k < q->modes; k++)
            out[p].leak[k] = sp_dot(n, q->m.vectors + k * n, r);
    }
    sp_ldl_solve(q->z.ldl, rest, solved);
    /* a'^T (A + s)^-1 a' is smaller than a'^T A^-1 a' by at most s over the lowest omitted eigenvalue; the second
     * factor is for the error of the product */
    const double cut = lowest_omitted(q), short_of = (1 + q->depth / (cut * cut)) * (1 + 1e-6);
    for (int p = 0; p < count; p++) {
        const double *r = rest + p * n, *x = solved + p * n;
        double whole = 0;
        for (int64_t k = 0; k < q->modes; k++) {
            const double far = q->omega[k] > 0 ? out[p].c[k] / q->omega[k] : 0;
            whole += far * far;
            out[p].residuals += q->residual[k] * fabs(out[p].c[k]) * residual_weight(q, k);
        }
        out[p].rest = sp_norm(n, r);
        out[p].rest_inverse = out[p].rest > 0 ? sqrt(inverse_square(q, r, x, work) * short_of) : 0;
        out[p].rest_energy = out[p].rest * sp_network_omega_bound(net);
        out[p].inverse = sqrt(whole + out[p].rest_inverse * out[p].rest_inverse);
    }
}

static sp_status project_all(sum *q, const double *places, bool source, int32_t count, projection *out, sp_error *err) {
    const int64_t n = q->m.dofs;
    enum { VECTORS = 2 * LANES + 2 };
    double *rest = sp_alloc(VECTORS, (size_t)n * sizeof *rest);
    if (!rest)
        return sp_fail_memory(err, VECTORS * (size_t)n * sizeof *rest);
    for (int32_t p = 0; p < count; p += LANES)
        project(q, places + p * n, source, count - p < LANES ? count - p : LANES, out + p, rest, rest + LANES * n,
                rest + 2 * LANES * n);
    sp_free(rest);
    return SP_OK;
}

static double error_of(const sum *q, const projection *a, const projection *b) {
    const double t = q->job->options->until;
    double left, leak = (job_has_momenta(q->job) ? t : 1) * a->null * b->null, rounding = 0;
    if (job_has_momenta(q->job))
        left = fmin(fmin(b->rest * a->rest_inverse, a->rest * b->rest_inverse), t * a->rest * b->rest);
    else
        left = fmin(a->rest * b->rest, b->rest_inverse * a->rest_energy);
    for (int64_t k = 0; k < q->modes; k++) {
        const double w = residual_weight(q, k);
        leak += w * (fabs(b->c[k]) * fabs(a->leak[k]) + fabs(a->c[k]) * fabs(b->leak[k]));
        rounding += w * fabs(a->c[k] * b->c[k]) * (4 + q->omega[k] * t);
    }
    const double loose = job_has_momenta(q->job) ? a->norm * b->inverse + b->norm * a->inverse : 2 * a->norm * b->norm;
    return left + leak + t * (b->inverse * a->residuals + a->rest_inverse * b->residuals) +
           DBL_EPSILON * (rounding + 16 * loose);
}

static void add_modes(const sum *q, const projection *a, const projection *b, const sp_signal *s, double *f) {
    for (int32_t l = 0; l < s->n; l++) {
        double total = 0;
        for (int64_t k = 0; k < q->modes; k++) {
            const double omega = q->omega[k], part = a->c[k] * b->c[k];
            if (!job_has_momenta(q->job))
                total += part * cos(omega * s->t[l]);
            else
                total += omega > 0 ? part / omega * sin(omega * s->t[l]) : part * s->t[l];
        }
        f[l] = total;
    }
}

static sp_status prepare(sum *q, int64_t modes, sp_error *err) {
    const signal_job *job = q->job;
    const sp_modes_options how = {.vectors = true, .source = job->options->source, .solver = job->options->solver};
    sp_modes_range range = sp_modes_range_lowest(modes);
    const size_t places = (size_t)(job->sources + job->detectors);
    slice_edge bottom = {0};
    sp_status status = sp_modes_make(job->net, &how, &range, &q->m, err);
    if (status == SP_OK && q->m.zero.mechanisms > 0) { /* only their vectors tell what is left without them */
        range.zero = true;
        sp_modes_free(&q->m);
        status = sp_modes_make(job->net, &how, &range, &q->m, err);
    }
    if (status != SP_OK)
        return status;
    q->modes = q->m.n - q->m.n_rattler;
    q->omega = q->m.omega + q->m.n_rattler;
    status = find_residuals(q, err);
    if (status == SP_OK)
        status = sp_slicer_make(job->net, false, &q->z, err);
    if (status == SP_OK)
        status = sp_slicer_bottom(&q->z, 1e-3 * lowest_omitted(q) * lowest_omitted(q), &bottom, err);
    if (status != SP_OK)
        return status;
    q->depth = -bottom.sigma;
    q->from = sp_alloc((size_t)job->sources, sizeof *q->from);
    q->to = sp_alloc((size_t)job->detectors, sizeof *q->to);
    q->numbers = sp_alloc(2 * places, (size_t)q->modes * sizeof *q->numbers);
    if (!q->from || !q->to || !q->numbers)
        return sp_fail_memory(err, 2 * places * (size_t)q->modes * sizeof *q->numbers);
    for (int64_t p = 0; p < job->sources + job->detectors; p++) {
        projection *x = p < job->sources ? &q->from[p] : &q->to[p - job->sources];
        x->c = q->numbers + 2 * p * q->modes;
        x->leak = x->c + q->modes;
    }
    return SP_OK;
}

/* The sum over a given number of modes, whatever its error. */
static sp_status sum_lowest(const signal_job *job, int64_t modes, sp_signal *s, sp_error *err) {
    sum q = {.job = job, .m = sp_modes_none()};
    sp_status status = prepare(&q, modes, err);
    if (status == SP_OK)
        status = project_all(&q, job->source_vectors, true, job->sources, q.from, err);
    if (status == SP_OK)
        status = project_all(&q, job->detector_vectors, false, job->detectors, q.to, err);
    for (int32_t a = 0; a < s->sources && status == SP_OK; a++)
        for (int32_t b = 0; b < s->detectors; b++) {
            add_modes(&q, &q.from[a], &q.to[b], s, signal_pair(s, a, b));
            s->errors[a * s->detectors + b] = error_of(&q, &q.from[a], &q.to[b]);
        }
    if (status == SP_OK)
        s->modes = modes;
    sum_free(&q);
    return status;
}

/* Largest ratio of error to tolerance of all pairs. */
static double excess(const signal_job *job, const sp_signal *s) {
    double worst = 0;
    for (int32_t a = 0; a < s->sources; a++)
        for (int32_t b = 0; b < s->detectors; b++) {
            const double *f = signal_pair(s, a, b);
            const double largest = fmax(1e-6 * sp_job_scale(job, a, b), sp_largest(s->n, f));
            const double ratio = s->errors[a * s->detectors + b] / (job->options->tolerance * largest);
            worst = ratio > worst || isnan(ratio) ? ratio : worst;
        }
    return worst;
}

sp_status sp_signal_by_lowest_modes(const signal_job *job, sp_signal *s, sp_error *err) {
    const int64_t n = sp_network_dofs(job->net), most = n / 4;
    if (job->options->modes > 0)
        return sum_lowest(job, job->options->modes, s, err);
    double ratio = HUGE_VAL;
    for (int64_t modes = FIRST_TRY; modes <= most; modes *= 2) {
        sp_error reason = {0};
        const sp_status status = sum_lowest(job, modes, s, &reason);
        if (status == SP_EINVAL) /* there are not so many */
            break;
        if (status != SP_OK)
            return sp_fail(err, status, "%s", reason.text);
        ratio = excess(job, s);
        /* what is left falls at best in proportion to the number of modes */
        if (ratio <= 1 || !(ratio * (double)modes < 4 * (double)most))
            break;
    }
    if (ratio <= 1)
        return SP_OK;
    if (n > SP_MODES_DENSE_MAX)
        return sp_fail(err, SP_EREFUSED,
                       "tolerance = %g: the %lld lowest of %lld modes have an error of %.2g of the largest |F|, and "
                       "all modes cost more than method chebyshev",
                       job->options->tolerance, (long long)s->modes, (long long)n, ratio * job->options->tolerance);
    s->modes = n;
    return sp_signal_by_modes(job, s, err);
}
