/* Sums the Chebyshev series of a pass and bounds its error. */
#include "base/base.h"
#include "numeric/bessel.h"
#include "signal/expansion.h"
#include "signal/pass.h"

#include <float.h>
#include <math.h>

/* Factors of rounding(). */
#define MOMENT_ROUNDING 5.0
#define PHASE_ROUNDING  5.0

/* Accumulated rounding. Moment k carries the independent errors of about k/2 steps (k without doubling), each a few
 * DBL_EPSILON of its terms. Omega t has the relative error DBL_EPSILON. The factors are 5 times the errors observed. */
static double rounding(const pass *p, int64_t column, double x, int64_t n, const double *j) {
    double moments = 0, signal = 0;
    for (int64_t k = 0; k < n && k < p->n; k++) {
        const double size = p->size[k * p->columns + column], mu = p->mu[k * p->columns + column];
        const double own = j[k] * size * sqrt(1 + (double)k), term = j[k] * mu;
        moments += own * own;
        signal += term * term;
    }
    return DBL_EPSILON * (MOMENT_ROUNDING * sqrt(moments) + PHASE_ROUNDING * (1 + x) * sqrt(signal));
}

static sp_status find_errors(const pass *p, double omega, double last, double *errors, sp_error *err) {
    const double scale = p->velocity ? 2 / omega : 2, x = omega * last;
    double *j = NULL, tail = 0, sum = 0;
    int64_t terms = 0;
    sp_status status = sp_expansion_bessel(x, p->velocity, &terms, &j, err);
    if (status != SP_OK)
        return status;
    for (int64_t k = p->n; k < terms && !(p->spread > 0); k++)
        tail += sp_expansion_weight(p->velocity, k) * fabs(j[k]);
    if (p->spread > 0)
        tail = sp_expansion_tail(x, p->velocity, p->spread, p->n);
    else
        tail += 2 * sp_expansion_weight(p->velocity, terms) * fabs(j[terms - 1]); /* those omitted as negligible */
    for (int64_t k = 0; k < terms && k < p->n; k++)
        sum += fabs(j[k]);
    tail += sum * sp_recurrence_dropped(&p->r, p->n);
    for (int64_t c = 0; c < p->columns; c++) {
        double low =
            0; /* moments whose Bessel functions were set to 0; for a spread above 0 these moments may be large */
        for (int64_t k = terms; k < p->n && p->spread > 0; k++)
            low += 1e-20 * fabs(p->mu[k * p->columns + c]);
        errors[c] = scale * (p->norms[c] * tail + low + rounding(p, c, x, terms, j));
    }
    sp_free(j);
    return SP_OK;
}

sp_status sp_pass_sum(const pass *p, double omega, int64_t n, const double *t, int64_t stride, double *f,
                      double *errors, sp_error *err) {
    const double scale = p->velocity ? 2 / omega : 2;
    double *x = sp_alloc((size_t)n, sizeof *x), *work = NULL;
    sp_status status = SP_OK;
    if (p->columns > 1)
        work = sp_alloc((size_t)sp_bessel_scratch(p->n, p->columns), sizeof *work);
    if (!x || (p->columns > 1 && !work)) {
        status = sp_fail_memory(err, ((size_t)n + (size_t)sp_bessel_scratch(p->n, p->columns)) * sizeof *x);
        goto out;
    }
    for (int64_t l = 0; l < n; l++)
        x[l] = omega * t[l];
    if (p->columns == 1)
        sp_bessel_series(p->n, p->mu, p->velocity, n, x, f);
    else
        sp_bessel_series_many(p->n, p->columns, p->mu, p->velocity, n, x, f, stride, work);
    for (int64_t c = 0; c < p->columns; c++)
        for (int64_t l = 0; l < n; l++)
            f[c * stride + l] *= scale;
    status = find_errors(p, omega, t[n - 1], errors, err);
out:
    sp_free(x);
    sp_free(work);
    return status;
}
