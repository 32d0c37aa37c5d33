/* Signals as a sum over all modes, Eq. (3) of Somfai et al. 2005, with error bounds. */
#include "base/base.h"
#include "base/vector.h"
#include "linalg/eigen.h"
#include "modes/refine.h"
#include "signal/job.h"

#include <float.h>
#include <math.h>
#include <sonopack/modes.h>

/* Projections of a source or a detector on the modes. */
typedef struct modal_projection {
    double *c;    /* [modes] mass weighted; for a source not yet divided by omega */
    double norm;  /* norm of the source or detector */
    double reach; /* sqrt(sum (c w)^2), w = min(t, 1/omega), or 1 for displacements */
} modal_projection;

/* One source at one detector. */
typedef struct modal_pair {
    const modal_projection *a, *b;
    double coupled; /* sum (a_n b_m E_mn g_mn)^2, see add_coupling */
} modal_pair;

static const double *omegas(const sp_modes *m) { return m->omega + m->n_rattler; }

static double weight(const signal_job *job, double omega, bool source) {
    const double t = job->options->until;
    return source && !job_has_momenta(job) ? 1 : omega * t > 1 ? 1 / omega : t;
}

/* vector: momenta, displacements or a detector; weighted: [dofs] scratch. */
static void project(const signal_job *job, const sp_modes *m, const double *vector, bool source, double *weighted,
                    modal_projection *projection) {
    const bool displaced = source && !job_has_momenta(job);
    for (int64_t q = 0; q < m->dofs; q++) {
        const double mass = job->net->mass[q], root = sqrt(mass);
        weighted[q] = displaced ? vector[q] * root : vector[q] / root;
        projection->norm += vector[q] * vector[q] * (displaced ? mass : 1 / mass);
    }
    projection->norm = sqrt(projection->norm);
    for (int64_t k = 0; k < m->dofs; k++) {
        projection->c[k] = sp_dot(m->dofs, m->vectors + k * m->dofs, weighted);
        const double moved = projection->c[k] * weight(job, omegas(m)[k], source);
        projection->reach += moved * moved;
    }
    projection->reach = sqrt(projection->reach);
}

/* The computed modes are those of A - E, E_mn = e_m . (A e_n - omega_n^2 e_n). E couples them, to first order
 * (Duhamel):
 *   dF = - int_0^t s_b(t - q) E s_a(q) dq = - sum_mn b_m E_mn a_n g_mn,  |g_mn| <= w_m w_n min(t, 1/|omega_m -
 *   omega_n|).
 * Signs of rounding errors are random, so the terms add as squares. row: E_mn of one n for all m. */
static void add_coupling(const signal_job *job, const sp_modes *m, int64_t n, const double *row, double noise,
                         modal_pair *p) {
    const double t = job->options->until, *omega = omegas(m), push = p->a->c[n] * weight(job, omega[n], true);
    double sum = 0;
    for (int64_t k = 0; k < m->dofs; k++) {
        const double apart = fabs(omega[k] - omega[n]), time = apart * t > 1 ? 1 / apart : t;
        const double term = p->b->c[k] * weight(job, omega[k], false) * time;
        sum += term * term * (row[k] * row[k] + noise * noise);
    }
    p->coupled += push * push * sum;
}

static sp_status couple(const signal_job *job, const sp_modes *m, int64_t pairs, modal_pair *each, sp_error *err) {
    enum { BLOCK = 64 };
    const int64_t n = m->dofs;
    const double omega = sp_network_omega_bound(job->net), noise = 4 * DBL_EPSILON * omega * omega / sqrt((double)n);
    double *r = sp_alloc((2 * BLOCK + 1) * (size_t)n, sizeof *r);
    if (!r)
        return sp_fail_memory(err, (2 * BLOCK + 1) * (size_t)n * sizeof *r);
    double *product = r + BLOCK * n, *u = product + BLOCK * n;
    for (int64_t first = 0; first < n; first += BLOCK) {
        const int many = n - first < BLOCK ? (int)(n - first) : BLOCK;
        for (int c = 0; c < many; c++)
            sp_mode_residual(job->net, m->vectors + (first + c) * n, omegas(m)[first + c] * omegas(m)[first + c], u,
                             r + c * n);
        sp_project(n, n, m->vectors, many, r, product);
        for (int64_t k = 0; k < pairs; k++)
            for (int c = 0; c < many; c++)
                add_coupling(job, m, first + c, product + c * n, noise, &each[k]);
    }
    sp_free(r);
    return SP_OK;
}

/* Error of the sum at the last time: phase errors due to errors of the frequencies, coupling of modes, rounding of
 * projections and orthogonality, rounding of the sines and the sum, and what add_modes leaves out: a computed zero mode
 * stretches springs a little. */
static double modal_error(const signal_job *job, const sp_modes *m, const modal_pair *p) {
    const double last = job->options->until, omega = sp_network_omega_bound(job->net);
    double phases = 0, squares = 0, left_out = 0;
    for (int64_t k = 0; k < m->dofs; k++) {
        const double turn = fmin(2, m->error[m->n_rattler + k] * last);
        const double size = p->a->c[k] * p->b->c[k] * weight(job, omegas(m)[k], true);
        phases += size * size * turn * turn;
        squares += size * size;
        left_out += omegas(m)[k] > 0 || !job_has_momenta(job) ? 0 : fabs(size);
    }
    const double loose = (4 * DBL_EPSILON + m->orthogonality) * (p->a->norm * p->b->reach + p->b->norm * p->a->reach);
    return 2 * sqrt(phases) + 4 * sqrt(p->coupled) + loose + left_out +
           DBL_EPSILON * (1 + omega * last) * sqrt(squares);
}

/* wave: [modes] scratch. */
static void add_modes(const sp_modes *m, const modal_pair *each, bool momenta, double *wave, sp_signal *s) {
    const double *omega = omegas(m);
    for (int32_t l = 0; l < s->n; l++) {
        for (int64_t k = 0; k < m->dofs; k++) {
            const double phase = omega[k] * s->t[l];
            if (!momenta)
                wave[k] = cos(phase);
            else /* a mode that stretches no spring causes no force */
                wave[k] = omega[k] > 0 ? sin(phase) / omega[k] : 0;
        }
        for (int64_t q = 0; q < (int64_t)s->sources * s->detectors; q++) {
            double sum = 0;
            for (int64_t k = 0; k < m->dofs; k++)
                sum += each[q].a->c[k] * each[q].b->c[k] * wave[k];
            s->f[q * s->n + l] = sum;
        }
    }
}

sp_status sp_signal_by_modes(const signal_job *job, sp_signal *s, sp_error *err) {
    sp_modes m = sp_modes_none();
    const sp_modes_options how = {.vectors = true, .source = job->options->source};
    const int64_t pairs = (int64_t)s->sources * s->detectors, places = (int64_t)s->sources + s->detectors;
    modal_pair *each = NULL;
    modal_projection *projection = NULL; /* sources, then detectors */
    double *numbers = NULL;
    sp_status status = sp_modes_dense(job->net, &how, &m, err);
    if (status != SP_OK)
        goto out;
    each = sp_alloc((size_t)pairs, sizeof *each);
    projection = sp_alloc((size_t)places, sizeof *projection);
    numbers = sp_alloc((size_t)places + 1, (size_t)m.dofs * sizeof *numbers);
    if (!each || !projection || !numbers) {
        status =
            sp_fail_memory(err, (size_t)pairs * sizeof *each + (size_t)(places + 1) * (size_t)m.dofs * sizeof *numbers);
        goto out;
    }
    double *scratch = numbers + places * m.dofs;
    for (int32_t k = 0; k < places; k++) {
        const bool source = k < s->sources;
        projection[k].c = numbers + k * m.dofs;
        project(job, &m, source ? job_source(job, k) : job_detector(job, k - s->sources), source, scratch,
                &projection[k]);
    }
    for (int64_t k = 0; k < pairs; k++)
        each[k] = (modal_pair){.a = &projection[k / s->detectors], .b = &projection[s->sources + k % s->detectors]};
    add_modes(&m, each, job_has_momenta(job), scratch, s);
    status = couple(job, &m, pairs, each, err);
    for (int64_t k = 0; k < pairs && status == SP_OK; k++)
        s->errors[k] = modal_error(job, &m, &each[k]);
out:
    sp_free(numbers);
    sp_free(projection);
    sp_free(each);
    sp_modes_free(&m);
    return status;
}
