#include "base/base.h"
#include "linalg/eigen.h"
#include "modes/refine.h"

#include <float.h>
#include <math.h>
#include <sonopack/modes.h>
#include <stdlib.h>
#include <string.h>

enum { DOFS_MAX = 20000 };

sp_modes_options sp_modes_options_default(void) {
    return (sp_modes_options){.vectors = true, .source = SP_SOURCE_IMPULSE};
}

sp_modes sp_modes_none(void) { return (sp_modes){.residual = NAN, .orthogonality = NAN}; }

void sp_modes_free(sp_modes *m) {
    sp_free(m->omega);
    sp_free(m->error);
    sp_free(m->a);
    sp_free(m->b);
    sp_free(m->participation);
    sp_free(m->vectors);
    *m = sp_modes_none();
}

/* A = M^-1/2 K M^-1/2, the lower triangle by columns. */
static sp_status dense_matrix(const sp_network *net, double **out, sp_error *err) {
    sp_sparse k = {0};
    const size_t n = (size_t)sp_network_dofs(net);
    double *a = NULL;
    sp_status status = sp_network_assemble(net, &k, err);
    if (status != SP_OK)
        return status;
    a = sp_alloc(n * n, sizeof *a);
    if (!a)
        status = sp_fail_memory(err, n * n * sizeof *a);
    for (int64_t c = 0; a && c < k.n; c++)
        for (int64_t q = k.p[c]; q < k.p[c + 1]; q++)
            a[(size_t)c * n + (size_t)k.i[q]] = k.x[q] / sqrt(net->mass[c] * net->mass[k.i[q]]);
    sp_sparse_free(&k);
    *out = a;
    return status;
}

/* One mode on the way to its place in the list. */
typedef struct candidate {
    sp_ritz ritz;
    int64_t vector; /* its row among the vectors */
} candidate;

static int by_lambda(const void *a, const void *b) {
    const candidate *x = a, *y = b;
    if (x->ritz.lambda != y->ritz.lambda)
        return x->ritz.lambda < y->ritz.lambda ? -1 : 1;
    return (x->vector > y->vector) - (x->vector < y->vector);
}

/* Eigenvalues below their own error are floppy modes: omega = 0. One that is negative beyond its error has no
 * frequency. */
static sp_status put_frequencies(const candidate *list, int64_t n, sp_modes *m, sp_error *err) {
    for (int64_t k = 0; k < n; k++) {
        const double lambda = list[k].ritz.lambda, error = list[k].ritz.error;
        const int64_t row = m->n_rattler + k;
        if (lambda < -error)
            return sp_fail(err, SP_EREFUSED,
                           "omega^2 = %.6g of mode %lld is negative: the network is unstable (prestress)", lambda,
                           (long long)row);
        if (lambda <= error) {
            m->n_zero++;
            m->omega[row] = 0;
            m->error[row] = sqrt(fmax(lambda, 0) + error);
        } else {
            m->omega[row] = sqrt(lambda);
            m->error[row] = error / (m->omega[row] + sqrt(lambda - error)) + DBL_EPSILON * m->omega[row];
        }
    }
    return SP_OK;
}

static sp_status sort_modes(int64_t n, const sp_ritz *ritz, candidate **out, sp_error *err) {
    candidate *list = sp_alloc((size_t)n, sizeof *list);
    if (!list)
        return sp_fail_memory(err, (size_t)n * sizeof *list);
    for (int64_t k = 0; k < n; k++)
        list[k] = (candidate){ritz[k], k};
    qsort(list, (size_t)n, sizeof *list, by_lambda);
    *out = list;
    return SP_OK;
}

/* Without vectors: the matrix is made tridiagonal once, its values are taken, and vectors only of the modes so soft
 * that LAPACK's error shows in them; those are refined. */
static sp_status frequencies(const sp_network *net, double *a, sp_ritz *ritz, sp_error *err) {
    enum { FINE = 20 }; /* accepted: omega within 1/FINE of 1e-12 */
    const int64_t n = sp_network_dofs(net);
    const double blur = sp_lapack_error(net);
    sp_tridiagonal t = {0};
    double *values = sp_alloc((size_t)n, sizeof *values), *vectors = NULL;
    int64_t count = 0;
    sp_status status = values ? sp_tridiagonal_make(n, a, &t, err) : sp_fail_memory(err, (size_t)n * sizeof *values);
    if (status != SP_OK)
        goto out;
    status = sp_tridiagonal_values(&t, values, err);
    if (status != SP_OK)
        goto out;
    for (int64_t k = 0; k < n; k++)
        ritz[k] = (sp_ritz){values[k], blur, NAN};
    while (count < n &&
           (blur > values[count] * 2e-12 / FINE || (count > 0 && values[count] - values[count - 1] <= 8 * blur)))
        count++; /* a cluster is not cut */
    if (count == 0)
        goto out;
    vectors = sp_alloc((size_t)(count * n), sizeof *vectors);
    if (!vectors) {
        status = sp_fail_memory(err, (size_t)(count * n) * sizeof *vectors);
        goto out;
    }
    status = sp_tridiagonal_vectors(&t, count, vectors, err);
    if (status == SP_OK)
        status = sp_modes_refine(net, values, count, vectors, ritz, err);
out:
    sp_free(vectors);
    sp_free(values);
    sp_tridiagonal_free(&t);
    return status;
}

/* The sign of a vector: its largest part positive. */
static void copy_vector(int64_t n, const double *from, double *to) {
    int64_t largest = 0;
    for (int64_t k = 1; k < n; k++)
        if (fabs(from[k]) > fabs(from[largest]))
            largest = k;
    for (int64_t k = 0; k < n; k++)
        to[k] = from[largest] < 0 ? -from[k] : from[k];
}

/* (sum w)^2/(N sum w^2) over grains, w = |e|^2 of a grain. */
static double participation(const sp_network *net, const double *e) {
    double sum = 0, squares = 0;
    for (int32_t i = 0; i < net->n; i++) {
        double w = 0;
        for (int d = 0; d < net->dof; d++) {
            const double part = e[(int64_t)i * net->dof + d];
            w += part * part;
        }
        sum += w;
        squares += w * w;
    }
    return sum * sum / (net->n * squares);
}

/* u = sum a_n u^(n) sin(omega_n t): a_n = e . M^-1/2 p/omega_n from momenta p, or, with a cosine, e . M^1/2 u(0); b_n =
 * (detector) M^-1/2 e. A floppy mode's sin(omega t)/omega = t does not fit the form: a = 0 there. */
static sp_status put_amplitudes(const sp_network *net, sp_source source, sp_modes *m, sp_error *err) {
    const int64_t n = sp_network_dofs(net);
    double *sent = sp_alloc((size_t)n, sizeof *sent), *seen = sp_alloc((size_t)n, sizeof *seen);
    sp_status status = sent && seen ? SP_OK : sp_fail_memory(err, 2 * (size_t)n * sizeof *sent);
    if (status == SP_OK)
        status = sp_network_source(net, source, sent, err);
    if (status == SP_OK)
        status = sp_network_detector(net, seen, err);
    if (status != SP_OK)
        goto out;
    for (int64_t k = 0; k < n; k++) {
        const double root = sqrt(net->mass[k]);
        sent[k] = source == SP_SOURCE_DISPLACEMENT ? sent[k] * root : sent[k] / root;
        seen[k] /= root;
    }
    for (int64_t row = 0; row < m->n; row++) {
        if (row < m->n_rattler) {
            m->participation[row] = 1.0 / net->n; /* one grain moves */
            continue;
        }
        const double *e = m->vectors + (row - m->n_rattler) * n;
        double a = 0, b = 0;
        for (int64_t k = 0; k < n; k++) {
            a += e[k] * sent[k];
            b += e[k] * seen[k];
        }
        if (source != SP_SOURCE_DISPLACEMENT)
            a = m->omega[row] > 0 ? a / m->omega[row] : 0;
        m->a[row] = a;
        m->b[row] = b;
        m->participation[row] = participation(net, e);
    }
out:
    sp_free(seen);
    sp_free(sent);
    return status;
}

/* All vectors: refined, sorted, and what follows from them. a becomes the vectors in LAPACK's order. */
static sp_status with_vectors(const sp_network *net, double *a, sp_ritz *ritz, sp_error *err) {
    const int64_t n = sp_network_dofs(net);
    double *values = sp_alloc((size_t)n, sizeof *values);
    sp_status status = values ? sp_eigen_all(n, a, values, err) : sp_fail_memory(err, (size_t)n * sizeof *values);
    if (status == SP_OK)
        status = sp_modes_refine(net, values, n, a, ritz, err);
    sp_free(values);
    return status;
}

static sp_status put_vectors(const sp_network *net, const double *a, const candidate *list, sp_modes *m,
                             sp_error *err) {
    const int64_t n = sp_network_dofs(net);
    const double omega = sp_network_omega_bound(net);
    m->residual = 0;
    for (int64_t k = 0; k < n; k++) {
        copy_vector(n, a + list[k].vector * n, m->vectors + k * n);
        m->residual = fmax(m->residual, list[k].ritz.residual / (omega * omega));
    }
    return sp_orthogonality(n, n, m->vectors, &m->orthogonality, err);
}

static sp_status allocate(const sp_network *net, bool vectors, sp_modes *m, sp_error *err) {
    m->dofs = sp_network_dofs(net);
    m->n_rattler = (int64_t)net->rattlers * net->dof;
    m->n_zero = m->n_rattler;
    m->n = m->n_rattler + m->dofs;
    const size_t n = (size_t)m->n, dofs = (size_t)m->dofs;
    m->omega = sp_alloc(n, sizeof *m->omega);
    m->error = sp_alloc(n, sizeof *m->error);
    if (vectors) {
        m->a = sp_alloc(n, sizeof *m->a);
        m->b = sp_alloc(n, sizeof *m->b);
        m->participation = sp_alloc(n, sizeof *m->participation);
        m->vectors = sp_alloc(dofs * dofs, sizeof *m->vectors);
    }
    if (!m->omega || !m->error || (vectors && (!m->a || !m->b || !m->participation || !m->vectors)))
        return sp_fail_memory(err, (5 * n + dofs * dofs) * sizeof(double));
    return SP_OK;
}

sp_status sp_modes_dense(const sp_network *net, const sp_modes_options *opt, sp_modes *out, sp_error *err) {
    sp_modes m = sp_modes_none();
    double *a = NULL;
    sp_ritz *ritz = NULL;
    candidate *list = NULL;
    const int64_t n = sp_network_dofs(net);
    if (n > DOFS_MAX)
        return sp_fail(err, SP_EREFUSED, "%lld degrees of freedom: all modes by a dense solver are for %d at the most",
                       (long long)n, DOFS_MAX);
    sp_status status = dense_matrix(net, &a, err);
    if (status != SP_OK)
        goto out;
    ritz = sp_alloc((size_t)n, sizeof *ritz);
    status = ritz ? SP_OK : sp_fail_memory(err, (size_t)n * sizeof *ritz);
    if (status == SP_OK)
        status = opt->vectors ? with_vectors(net, a, ritz, err) : frequencies(net, a, ritz, err);
    if (status == SP_OK)
        status = sort_modes(n, ritz, &list, err);
    if (status == SP_OK)
        status = allocate(net, opt->vectors, &m, err);
    if (status == SP_OK)
        status = put_frequencies(list, n, &m, err);
    if (status == SP_OK && opt->vectors) {
        status = put_vectors(net, a, list, &m, err);
        if (status == SP_OK)
            status = put_amplitudes(net, opt->source, &m, err);
    }
out:
    sp_free(list);
    sp_free(ritz);
    sp_free(a);
    if (status == SP_OK)
        *out = m;
    else
        sp_modes_free(&m);
    return status;
}
