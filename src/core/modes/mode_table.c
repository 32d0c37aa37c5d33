/* Makes a table of modes from eigenpairs, and bounds the errors of its vectors. */
#include "modes/mode_table.h"

#include "base/base.h"
#include "linalg/arrays.h"
#include "linalg/eigen.h"

#include <float.h>
#include <math.h>
#include <sonopack/modes.h>
#include <stdlib.h>
#include <string.h>

/* A mode before sorting. */
typedef struct candidate {
    sp_ritz ritz;
    int64_t vector; /* row of its vector */
} candidate;

static int by_lambda(const void *a, const void *b) {
    const candidate *x = a, *y = b;
    if (x->ritz.lambda != y->ritz.lambda)
        return x->ritz.lambda < y->ritz.lambda ? -1 : 1;
    return (x->vector > y->vector) - (x->vector < y->vector);
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

/* Zero modes have omega = 0. An eigenvalue that is negative beyond its error has no frequency. */
static sp_status set_frequencies(const candidate *list, const sp_mode_pairs *set, sp_modes *m, sp_error *err) {
    for (int64_t k = 0; k < set->count; k++) {
        const double lambda = list[k].ritz.lambda, error = list[k].ritz.error;
        const int64_t row = m->n_rattler + k;
        if (lambda < -error)
            return sp_fail(err, SP_EREFUSED,
                           "omega^2 = %.6g of mode %lld is negative: the network is unstable (prestress)", lambda,
                           (long long)(m->first + row));
        if (k < set->zeros) {
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

/* The sign that makes its largest component positive. */
static void set_sign(int64_t n, double *x) {
    int64_t largest = 0;
    for (int64_t k = 1; k < n; k++)
        if (fabs(x[k]) > fabs(x[largest]))
            largest = k;
    const double sign = x[largest] < 0 ? -1 : 1;
    for (int64_t k = 0; k < n; k++)
        x[k] *= sign;
}

/* Moves row list[k].vector to row k for all k, along the cycles of the permutation. place: scratch [count]; row: [n].
 */
static void permute(int64_t n, int64_t count, double *x, const candidate *list, int64_t *place, double *row) {
    for (int64_t k = 0; k < count; k++)
        place[k] = list[k].vector;
    for (int64_t start = 0; start < count; start++) {
        if (place[start] == start)
            continue;
        memcpy(row, x + start * n, (size_t)n * sizeof *x);
        int64_t k = start;
        while (place[k] != start) {
            const int64_t from = place[k];
            memcpy(x + k * n, x + from * n, (size_t)n * sizeof *x);
            place[k] = k;
            k = from;
        }
        memcpy(x + k * n, row, (size_t)n * sizeof *x);
        place[k] = k;
    }
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

/* Amplitudes in u = sum a_n u^(n) sin(omega_n t): a_n = e . M^-1/2 p/omega_n for momenta p, or e . M^1/2 u(0) with cos
 * for displacements; b_n = (detector) M^-1/2 e. a = 0 for zero modes, whose limit sin(omega t)/omega = t does not fit
 * this form. A network that does not touch a wall has modes all the same, but no amplitudes there: NAN. */
sp_status sp_modes_walls(const sp_network *net, sp_source source, double *from, double *to, sp_error *err) {
    const int64_t n = sp_network_dofs(net);
    const bool has_source = sp_network_touches(net, SP_BOTTOM), has_detector = sp_network_touches(net, SP_TOP);
    sp_status status = has_source ? sp_network_source(net, source, from, err) : SP_OK;
    if (status == SP_OK && has_detector)
        status = sp_network_detector(net, to, err);
    for (int64_t k = 0; status == SP_OK && k < n; k++) {
        const double root = sqrt(net->mass[k]);
        from[k] = !has_source ? NAN : source == SP_SOURCE_DISPLACEMENT ? from[k] * root : from[k] / root;
        to[k] = has_detector ? to[k] / root : NAN;
    }
    return status;
}

static sp_status set_amplitudes(const sp_network *net, sp_source source, sp_modes *m, sp_error *err) {
    const int64_t n = sp_network_dofs(net);
    double *from = sp_alloc((size_t)n, sizeof *from), *to = sp_alloc((size_t)n, sizeof *to);
    sp_status status = from && to ? SP_OK : sp_fail_memory(err, 2 * (size_t)n * sizeof *from);
    const bool has_source = sp_network_touches(net, SP_BOTTOM), has_detector = sp_network_touches(net, SP_TOP);
    if (status == SP_OK)
        status = sp_modes_walls(net, source, from, to, err);
    for (int64_t row = 0; row < m->n && status == SP_OK; row++) {
        const bool rattler = row < m->n_rattler; /* a single grain moves, away from the walls */
        const double *e = rattler ? NULL : m->vectors + (row - m->n_rattler) * n;
        double a = 0, b = 0;
        for (int64_t k = 0; k < (rattler ? 0 : n); k++) {
            a += e[k] * from[k];
            b += e[k] * to[k];
        }
        if (source != SP_SOURCE_DISPLACEMENT)
            a = m->omega[row] > 0 ? a / m->omega[row] : 0;
        m->a[row] = has_source ? a : NAN;
        m->b[row] = has_detector ? b : NAN;
        m->participation[row] = rattler ? 1.0 / net->n : participation(net, e);
    }
    sp_free(to);
    sp_free(from);
    return status;
}

/* Sorts the vectors where they are: they may take most of the memory. */
static sp_status set_vectors(const sp_network *net, const sp_mode_pairs *set, const candidate *list, sp_modes *m,
                             sp_error *err) {
    const int64_t n = m->dofs, count = set->count;
    const double omega = sp_network_omega_bound(net);
    int64_t *place = sp_alloc((size_t)count, sizeof *place);
    double *row = sp_alloc((size_t)n, sizeof *row);
    sp_status status = place && row ? SP_OK : sp_fail_memory(err, (size_t)(count + n) * sizeof *row);
    if (status == SP_OK) {
        m->vectors = *set->vectors;
        *set->vectors = NULL;
        if (set->row > 0)
            memmove(m->vectors, m->vectors + set->row * n, (size_t)(count * n) * sizeof *m->vectors);
        permute(n, count, m->vectors, list, place, row);
    }
    sp_free(row);
    sp_free(place);
    m->residual = 0;
    for (int64_t k = 0; k < count && status == SP_OK; k++) {
        set_sign(n, m->vectors + k * n);
        m->residual = fmax(m->residual, list[k].ritz.residual / (omega * omega));
    }
    return status == SP_OK ? sp_orthogonality(n, count, m->vectors, &m->orthogonality, err) : status;
}

static sp_status allocate(const sp_network *net, const sp_mode_pairs *set, sp_modes *m, sp_error *err) {
    m->dofs = sp_network_dofs(net);
    m->n_rattler = set->rattlers;
    m->n_zero = m->n_rattler;
    m->n = m->n_rattler + set->count;
    m->first = set->first;
    m->zero = set->zero;
    const size_t n = (size_t)m->n;
    /* without vectors the list ends after the errors */
    const sp_array arrays[] = {{&m->omega, n}, {&m->error, n},         {set->vectors ? &m->a : NULL, n},
                               {&m->b, n},     {&m->participation, n}, {0}};
    double *block;
    return sp_arrays_make(arrays, &block, err);
}

sp_status sp_modes_tabulate(const sp_network *net, sp_source source, const sp_mode_pairs *set, sp_modes *out,
                            sp_error *err) {
    sp_modes m = sp_modes_none();
    candidate *list = NULL;
    sp_status status = sort_modes(set->count, set->ritz, &list, err);
    if (status == SP_OK)
        status = allocate(net, set, &m, err);
    if (status == SP_OK)
        status = set_frequencies(list, set, &m, err);
    if (status == SP_OK && set->vectors) {
        status = set_vectors(net, set, list, &m, err);
        if (status == SP_OK)
            status = set_amplitudes(net, source, &m, err);
    }
    sp_free(list);
    if (status == SP_OK)
        *out = m;
    else
        sp_modes_free(&m);
    return status;
}

/* ---- options and memory ------------------------------------------------------------------------------------------ */

sp_modes_options sp_modes_options_default(void) {
    return (sp_modes_options){.vectors = true, .source = SP_SOURCE_IMPULSE};
}

sp_modes sp_modes_none(void) { return (sp_modes){.residual = NAN, .orthogonality = NAN}; }

void sp_modes_free(sp_modes *m) {
    sp_free(m->omega); /* all other arrays are one block */
    sp_free(m->vectors);
    *m = sp_modes_none();
}

sp_modes_range sp_modes_range_all(void) { return (sp_modes_range){.to = HUGE_VAL}; }
sp_modes_range sp_modes_range_lowest(int64_t count) { return (sp_modes_range){.lowest = count, .to = HUGE_VAL}; }
sp_modes_range sp_modes_range_band(double from, double to) { return (sp_modes_range){.from = from, .to = to}; }

sp_damped_modes sp_damped_modes_none(void) { return (sp_damped_modes){0}; }

void sp_damped_modes_free(sp_damped_modes *m) {
    sp_free(m->omega); /* all arrays are one block */
    *m = sp_damped_modes_none();
}

/* ---- errors of vectors ------------------------------------------------------------------------------------------- */

static double square(double x) { return x * x; }

double sp_modes_gap(const sp_modes *m, int64_t first, int64_t last) {
    const double low = square(fmax(0, m->omega[first] - m->error[first]));
    const double high = square(m->omega[last] + m->error[last]);
    double below = -HUGE_VAL, above = HUGE_VAL;
    if (first > m->n_rattler)
        below = square(m->omega[first - 1] + m->error[first - 1]);
    else if (m->certified_from > 0)
        below = square(m->certified_from);
    else if (m->first > 0) /* zero modes, which are not listed */
        below = square(m->zero.below);
    if (last + 1 < m->n)
        above = square(fmax(0, m->omega[last + 1] - m->error[last + 1]));
    else if (isfinite(m->certified_to))
        above = square(m->certified_to);
    return fmin(low - below, above - high);
}

double sp_modes_vector_error(const sp_modes *m, const sp_network *net, int64_t row) {
    const double top = square(sp_network_omega_bound(net)), gap = sp_modes_gap(m, row, row);
    const double residual = (m->residual + 8 * DBL_EPSILON) * top; /* with the rounding of its computation */
    /* Davis and Kahan: the sine of the angle is at most |R|/gap, and |e - f| at most sqrt(2) times that */
    return M_SQRT2 * (gap > residual ? residual / gap : 1);
}
