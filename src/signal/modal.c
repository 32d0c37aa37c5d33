#include "base/base.h"
#include "linalg/eigen.h"
#include "signal/job.h"

#include <float.h>
#include <math.h>
#include <sonopack/modes.h>

/* The sum of one source and one detector over the modes of the network. */
typedef struct modal_pair {
    double *a, *b;           /* [modes] projections of source and detector, mass weighted; a not yet over omega */
    double a_norm, b_norm;   /* of source and detector */
    double reach_a, reach_b; /* sqrt(sum (a w)^2), sqrt(sum (b w)^2): w = min(t, 1/omega), 1 for displacements */
    double squares;          /* sum (a w b)^2 */
    double coupled;          /* sum (a_n b_m E_mn g_mn)^2, see add_coupling */
} modal_pair;

static const double *omegas(const sp_modes *m) { return m->omega + m->n_rattler; }

static double weight(const signal_job *job, double omega, bool source) {
    const double t = job->options->until;
    return source && !job_moves(job) ? 1 : omega * t > 1 ? 1 / omega : t;
}

static void project(const signal_job *job, const sp_modes *m, const double *sent, const double *seen, modal_pair *p) {
    const double *mass = job->net->mass;
    for (int64_t q = 0; q < m->dofs; q++) {
        p->a_norm += sent[q] * sent[q] * (job_moves(job) ? 1 / mass[q] : mass[q]);
        p->b_norm += seen[q] * seen[q] / mass[q];
    }
    p->a_norm = sqrt(p->a_norm);
    p->b_norm = sqrt(p->b_norm);
    for (int64_t k = 0; k < m->dofs; k++) {
        const double *e = m->vectors + k * m->dofs;
        double a = 0, b = 0;
        for (int64_t q = 0; q < m->dofs; q++) {
            const double root = sqrt(mass[q]);
            a += e[q] * (job_moves(job) ? sent[q] / root : sent[q] * root);
            b += e[q] * (seen[q] / root);
        }
        p->a[k] = a;
        p->b[k] = b;
        const double push = a * weight(job, omegas(m)[k], true), feel = b * weight(job, omegas(m)[k], false);
        p->reach_a += push * push;
        p->reach_b += feel * feel;
        p->squares += push * push * b * b;
    }
    p->reach_a = sqrt(p->reach_a);
    p->reach_b = sqrt(p->reach_b);
}

/* The solver's modes are those of A - E, E_mn = e_m . (A e_n - omega_n^2 e_n): they couple through
 *   dF = - int_0^t s_b(t - q) E s_a(q) dq = - sum_mn b_m E_mn a_n g_mn   (Duhamel, first order),
 * |g_mn| <= w_m w_n min(t, 1/|omega_m - omega_n|). Rounding has no preferred sign: the terms add up as squares. row:
 * E_mn of one n, for all m. */
static void add_coupling(const signal_job *job, const sp_modes *m, int64_t n, const double *row, double noise,
                         modal_pair *p) {
    const double t = job->options->until, *omega = omegas(m), push = p->a[n] * weight(job, omega[n], true);
    double sum = 0;
    for (int64_t k = 0; k < m->dofs; k++) {
        const double apart = fabs(omega[k] - omega[n]), time = apart * t > 1 ? 1 / apart : t;
        const double term = p->b[k] * weight(job, omega[k], false) * time;
        sum += term * term * (row[k] * row[k] + noise * noise);
    }
    p->coupled += push * push * sum;
}

/* r = A e - lambda e, by way of u = M^-1/2 e. */
static void residual(const sp_network *net, const double *e, double lambda, double *u, double *r) {
    const int64_t n = sp_network_dofs(net);
    for (int64_t k = 0; k < n; k++)
        u[k] = e[k] / sqrt(net->mass[k]);
    sp_network_apply(net, u, r);
    for (int64_t k = 0; k < n; k++)
        r[k] = r[k] / sqrt(net->mass[k]) - lambda * e[k];
}

static sp_status couple(const signal_job *job, const sp_modes *m, int64_t pairs, modal_pair *pair, sp_error *err) {
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
            residual(job->net, m->vectors + (first + c) * n, omegas(m)[first + c] * omegas(m)[first + c], u, r + c * n);
        sp_project(n, n, m->vectors, many, r, product);
        for (int64_t k = 0; k < pairs; k++)
            for (int c = 0; c < many; c++)
                add_coupling(job, m, first + c, product + c * n, noise, &pair[k]);
    }
    sp_free(r);
    return SP_OK;
}

/* Error of the sum at the last time: each frequency's own error turns its phase; the solver's residuals couple modes;
 * projections and orthogonality are rounded; so are sine and sum. */
static double modal_error(const signal_job *job, const sp_modes *m, const modal_pair *p) {
    const double last = job->options->until, omega = sp_network_omega_bound(job->net);
    double phases = 0;
    for (int64_t k = 0; k < m->dofs; k++) {
        const double turn = fmin(2, m->error[m->n_rattler + k] * last);
        const double term = p->a[k] * p->b[k] * weight(job, omegas(m)[k], true) * turn;
        phases += term * term;
    }
    const double loose = (4 * DBL_EPSILON + m->orthogonality) * (p->a_norm * p->reach_b + p->b_norm * p->reach_a);
    return 2 * sqrt(phases) + 4 * sqrt(p->coupled) + loose + DBL_EPSILON * (1 + omega * last) * sqrt(p->squares);
}

/* wave: [modes] scratch. */
static void add_modes(const sp_modes *m, const modal_pair *pair, bool moves, double *wave, sp_signal *s) {
    const double *omega = omegas(m);
    for (int32_t l = 0; l < s->n; l++) {
        for (int64_t k = 0; k < m->dofs; k++) {
            const double phase = omega[k] * s->t[l];
            if (!moves)
                wave[k] = cos(phase);
            else /* no force is felt of a mode that stretches nothing */
                wave[k] = omega[k] > 0 ? sin(phase) / omega[k] : 0;
        }
        for (int64_t q = 0; q < (int64_t)s->sources * s->detectors; q++) {
            double sum = 0;
            for (int64_t k = 0; k < m->dofs; k++)
                sum += pair[q].a[k] * pair[q].b[k] * wave[k];
            s->f[q * s->n + l] = sum;
        }
    }
}

sp_status sp_signal_by_modes(const signal_job *job, sp_signal *s, sp_error *err) {
    sp_modes m = sp_modes_none();
    const sp_modes_options how = {.vectors = true, .source = job->options->source};
    const int64_t pairs = (int64_t)s->sources * s->detectors;
    modal_pair *pair = NULL;
    double *numbers = NULL;
    sp_status status = sp_modes_dense(job->net, &how, &m, err);
    if (status != SP_OK)
        goto out;
    pair = sp_alloc((size_t)pairs, sizeof *pair);
    numbers = sp_alloc(2 * (size_t)pairs + 1, (size_t)m.dofs * sizeof *numbers);
    if (!pair || !numbers) {
        status = sp_fail_memory(err, (size_t)pairs * (sizeof *pair + 2 * (size_t)m.dofs * sizeof *numbers));
        goto out;
    }
    for (int64_t k = 0; k < pairs; k++) {
        const int32_t a = (int32_t)(k / s->detectors), b = (int32_t)(k % s->detectors);
        pair[k].a = numbers + 2 * k * m.dofs;
        pair[k].b = pair[k].a + m.dofs;
        project(job, &m, job_source(job, a), job_detector(job, b), &pair[k]);
    }
    add_modes(&m, pair, job_moves(job), numbers + 2 * pairs * m.dofs, s);
    status = couple(job, &m, pairs, pair, err);
    for (int64_t k = 0; k < pairs && status == SP_OK; k++)
        s->errors[k] = modal_error(job, &m, &pair[k]);
out:
    sp_free(numbers);
    sp_free(pair);
    sp_modes_free(&m);
    return status;
}
