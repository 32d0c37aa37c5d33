/* Modes of damped motion, (lambda^2 M + lambda C + K) u = 0, from the first-order form of twice the size. All three
 * matrices are symmetric, so u is also the left eigenvector (transposed, not conjugated):
 *   G(s) = (s^2 M + s C + K)^-1 = sum u u^T/((s - lambda) u^T (2 lambda M + C) u). */
#include "base/base.h"
#include "linalg/arrays.h"
#include "linalg/eigen.h"
#include "network/rows.h"

#include <complex.h>
#undef I
#include <float.h>
#include <math.h>
#include <sonopack/modes.h>

typedef double complex number;

static inline number number_of(double re, double im) { return re + im * _Complex_I; }

typedef struct damped {
    const sp_network *net;
    sp_network dashpots;
    sp_source source;
    int64_t n; /* degrees of freedom */
    double omega, rate;
    double *memory; /* of all arrays */
    double *matrix, *vectors, *re, *im;
    double *source_vector;                      /* [n] */
    double *spring_detector, *dashpot_detector; /* [n] detector vectors of springs and of dashpots */
    double *u[2], *ku[2], *cu[2];               /* [n] real and imaginary parts */
} damped;

static sp_status allocate(damped *d, sp_error *err) {
    const size_t n = (size_t)d->n, order = 2 * n;
    const sp_array arrays[] = {{&d->matrix, order * order},
                               {&d->vectors, order * order},
                               {&d->re, order},
                               {&d->im, order},
                               {&d->source_vector, n},
                               {&d->spring_detector, n},
                               {&d->dashpot_detector, n},
                               {&d->u[0], n},
                               {&d->u[1], n},
                               {&d->ku[0], n},
                               {&d->ku[1], n},
                               {&d->cu[0], n},
                               {&d->cu[1], n},
                               {0}};
    return sp_arrays_make(arrays, &d->memory, err);
}

/* Adds factor M^-1/2 K M^-1/2, K that of net, to the block of the first-order matrix that begins at (row, column). */
static void add_block(const damped *d, const sp_network *net, int64_t row, int64_t column, double factor) {
    for (int32_t q = 0; q < net->n_springs; q++) {
        const sp_spring *s = &net->springs[q];
        sp_rows rows;
        sp_network_rows(net, s, &rows);
        for (int k = 0; k < rows.count; k++)
            for (int a = 0; a < rows.width; a++)
                for (int b = 0; b < rows.width; b++) {
                    const int64_t i = (int64_t)(a < net->dof ? s->i : s->j) * net->dof + a % net->dof,
                                  j = (int64_t)(b < net->dof ? s->i : s->j) * net->dof + b % net->dof;
                    d->matrix[(column + j) * 2 * d->n + row + i] +=
                        factor * rows.k[k] * rows.b[k][a] * rows.b[k][b] / sqrt(net->mass[i] * net->mass[j]);
                }
    }
}

/* The vector is (Omega M^1/2 u, M^1/2 u'), so that all blocks have the magnitude of Omega. */
static void fill_matrix(const damped *d) {
    for (int64_t k = 0; k < d->n; k++)
        d->matrix[(d->n + k) * 2 * d->n + k] = d->omega;
    add_block(d, d->net, d->n, 0, -1 / d->omega);
    add_block(d, &d->dashpots, d->n, d->n, -1);
}

/* Reads u of eigenvalue k from the larger half of its vector. */
static void load_vector(const damped *d, int64_t k) {
    const int64_t order = 2 * d->n;
    const number lambda = number_of(d->re[k], d->im[k]);
    const bool fast = cabs(lambda) > d->omega;
    for (int64_t q = 0; q < d->n; q++) {
        const int64_t at = k * order + q + (fast ? d->n : 0);
        number x = number_of(d->vectors[at], d->im[k] != 0 ? d->vectors[at + order] : 0);
        x = (fast ? d->omega * x / lambda : x) / sqrt(d->net->mass[q]);
        d->u[0][q] = creal(x);
        d->u[1][q] = cimag(x);
    }
    for (int part = 0; part < 2; part++) {
        sp_network_apply(d->net, d->u[part], d->ku[part]);
        sp_network_apply(&d->dashpots, d->u[part], d->cu[part]);
    }
}

/* x^T y without conjugation, x and y complex; im NULL: y is real. */
static number product(int64_t n, double *const x[2], const double *re, const double *im, const double *weight) {
    number sum = 0;
    for (int64_t k = 0; k < n; k++)
        sum += number_of(x[0][k], x[1][k]) * number_of(re[k], im ? im[k] : 0) * (weight ? weight[k] : 1);
    return sum;
}

/* Improves lambda by a Newton step, whose error is of second order because u is both left and right eigenvector. Stores
 * its error, residual and amplitudes. */
static void refine_mode(const damped *d, int64_t k, sp_damped_modes *out) {
    const double *mass = d->net->mass;
    number lambda = number_of(d->re[k], d->im[k]);
    load_vector(d, k);
    const number m = product(d->n, d->u, d->u[0], d->u[1], mass), c = product(d->n, d->u, d->cu[0], d->cu[1], NULL),
                 s = product(d->n, d->u, d->ku[0], d->ku[1], NULL);
    double size = 0, residual = 0;
    for (int64_t q = 0; q < d->n; q++) {
        const number r = lambda * lambda * mass[q] * number_of(d->u[0][q], d->u[1][q]) +
                         lambda * number_of(d->cu[0][q], d->cu[1][q]) + number_of(d->ku[0][q], d->ku[1][q]);
        size += mass[q] * (d->u[0][q] * d->u[0][q] + d->u[1][q] * d->u[1][q]);
        residual += creal(r * conj(r)) / mass[q];
    }
    const double scale = cabs(lambda) * (cabs(lambda) + d->rate) + d->omega * d->omega;
    const number slope = 2 * lambda * m + c;
    const number step = cabs(slope) > 0 ? (lambda * (lambda * m + c) + s) / slope : 0;
    /* rounding of the matrices; at a double eigenvalue slope is 0, and lambda moves with the square root */
    const double blur = 8 * DBL_EPSILON * scale * size;
    const double error = fmin(cabs(step) + blur / cabs(slope), sqrt((blur + sqrt(residual * size)) / size));
    if (cabs(step) <= error && cabs(step) <= 1e-6 * d->omega)
        lambda -= d->im[k] != 0 ? step : creal(step);
    number excitation = product(d->n, d->u, d->source_vector, NULL, NULL);
    if (d->source == SP_SOURCE_DISPLACEMENT)
        excitation = lambda * product(d->n, d->u, d->source_vector, NULL, mass) +
                     product(d->n, d->cu, d->source_vector, NULL, NULL);
    const number response = product(d->n, d->u, d->spring_detector, NULL, NULL) +
                            lambda * product(d->n, d->u, d->dashpot_detector, NULL, NULL);
    const number weight = (d->im[k] != 0 ? 2 : 1) * response * excitation / slope;
    const int64_t at = out->n++;
    out->omega[at] = d->im[k] != 0 ? fabs(cimag(lambda)) : 0;
    out->decay[at] = 0.0 - creal(lambda);
    out->cosine[at] = creal(weight);
    out->sine[at] = d->im[k] != 0 ? -cimag(weight) : 0;
    out->error[at] = error;
    out->residual = fmax(out->residual, sqrt(residual / size) / scale);
}

static sp_status collect(const damped *d, sp_damped_modes *out, sp_error *err) {
    const size_t n = 2 * (size_t)d->n;
    const sp_array arrays[] = {{&out->omega, n}, {&out->decay, n}, {&out->cosine, n},
                               {&out->sine, n},  {&out->error, n}, {0}};
    double *block;
    const sp_status status = sp_arrays_make(arrays, &block, err);
    if (status != SP_OK)
        return status;
    for (int64_t k = 0; k < 2 * d->n; k++)
        if (d->im[k] >= 0) /* one of each pair */
            refine_mode(d, k, out);
    double *const columns[] = {out->omega, out->decay, out->cosine, out->sine, out->error, NULL};
    return sp_arrays_sort(out->n, columns, err);
}

sp_status sp_damped_modes_make(const sp_network *net, double zeta, sp_source source, sp_damped_modes *out,
                               sp_error *err) {
    const sp_damping law = {.kind = SP_DAMPING_ZETA, .value = zeta};
    return sp_damped_modes_with(net, &law, source, out, err);
}

void sp_damped_modes_quality(const sp_damped_modes *m, int64_t k, double *q, double *q_error) {
    const double decay = m->decay[k], error = m->error[k], size = hypot(m->omega[k], decay);
    *q = *q_error = NAN;
    if (!(m->omega[k] > 0))
        return;
    *q = decay > error ? size / (2 * decay) : INFINITY;
    *q_error = decay > error ? (size + error) / (2 * (decay - error)) - *q : INFINITY;
}

sp_status sp_damped_modes_with(const sp_network *net, const sp_damping *law, sp_source source, sp_damped_modes *out,
                               sp_error *err) {
    damped d = {.net = net, .dashpots = sp_network_none(), .source = source, .n = sp_network_dofs(net)};
    sp_damped_modes m = sp_damped_modes_none();
    if (d.n > SP_DAMPED_MODES_MAX)
        return sp_fail(err, SP_EREFUSED, "%lld degrees of freedom, must be at most %d for damped modes", (long long)d.n,
                       SP_DAMPED_MODES_MAX);
    sp_status status = sp_network_need_symmetry(net, "a table of damped modes", err);
    if (status == SP_OK)
        status = sp_network_dashpots(net, law, &d.dashpots, err);
    if (status == SP_OK)
        status = allocate(&d, err);
    if (status == SP_OK)
        status = sp_network_source(net, source, d.source_vector, err);
    if (status == SP_OK)
        status = sp_network_detector(net, d.spring_detector, err);
    if (status == SP_OK)
        status = sp_network_detector(&d.dashpots, d.dashpot_detector, err);
    if (status == SP_OK) {
        d.omega = sp_network_omega_bound(net);
        d.rate = sp_network_omega_bound(&d.dashpots) * sp_network_omega_bound(&d.dashpots);
        fill_matrix(&d);
        status = sp_eigen_general(2 * d.n, d.matrix, d.re, d.im, d.vectors, err);
    }
    if (status == SP_OK)
        status = collect(&d, &m, err);
    sp_free(d.memory);
    sp_network_free(&d.dashpots);
    if (status == SP_OK)
        *out = m;
    else
        sp_damped_modes_free(&m);
    return status;
}
