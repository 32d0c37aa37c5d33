/* Solves the driven network at one frequency and bounds the error of the response. */
#include "spectrum/driven.h"
#include "base/base.h"
#include "base/vector.h"
#include "linalg/arrays.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>

void sp_driven_free(driven *d) {
    sp_complex_ldl_free(d->ldl);
    sp_free(d->in_lower);
    sp_free(d->p);
    sp_free(d->i);
    sp_free(d->memory);
    *d = (driven){0};
}

/* Pattern of all entries of a symmetric matrix given by its lower triangle: by columns, rows ascending. */
static void fill_pattern(const sp_sparse *k, driven *d) {
    const int64_t n = k->n;
    for (int64_t c = 0; c < n; c++)
        for (int64_t q = k->p[c]; q < k->p[c + 1]; q++) {
            d->p[c + 1]++;
            if (k->i[q] != c)
                d->p[k->i[q] + 1]++;
        }
    for (int64_t c = 0; c < n; c++)
        d->p[c + 1] += d->p[c];
}

/* Entries over sqrt(m m), and the magnitudes of the sums that form them, at most sqrt(K_rr K_cc) by Cauchy-Schwarz. The
 * upper part of a column comes from earlier columns, so rows ascend. */
static void fill_values(const sp_sparse *k, const driven *d, int64_t *next, double *x, double *size) {
    const int64_t n = k->n;
    for (int64_t c = 0; c < n; c++)
        next[c] = d->p[c];
    for (int64_t c = 0; c < n; c++)
        for (int64_t q = k->p[c]; q < k->p[c + 1]; q++) {
            const int64_t r = k->i[q];
            const double scale = 1 / (d->root[c] * d->root[r]);
            const double most = sqrt(fabs(k->x[k->p[c]])) * sqrt(fabs(k->x[k->p[r]])) * scale;
            d->i[next[c]] = r;
            d->in_lower[q] = next[c];
            x[next[c]] = k->x[q] * scale;
            size[next[c]++] = fmax(most, fabs(k->x[q]) * scale);
            if (r == c)
                continue;
            d->i[next[r]] = c;
            x[next[r]] = k->x[q] * scale;
            size[next[r]++] = fmax(most, fabs(k->x[q]) * scale);
        }
}

static sp_status allocate(const sp_network *net, const sp_sparse *k, bool damped, driven *d, sp_error *err) {
    const size_t n = (size_t)k->n, entries = 2 * (size_t)k->p[n] - n;
    d->n = k->n;
    d->entries = k->p[n];
    d->p = sp_alloc(n + 1, sizeof *d->p);
    d->i = sp_alloc(entries, sizeof *d->i);
    d->in_lower = sp_alloc((size_t)d->entries, sizeof *d->in_lower);
    if (!d->p || !d->i || !d->in_lower)
        return sp_fail_memory(err, (2 * entries + n + 1) * sizeof *d->p);
    const sp_array arrays[] = {{&d->a, entries},
                               {&d->size_a, entries},
                               {&d->x, 2 * entries},
                               {&d->lower, 2 * (size_t)d->entries},
                               {&d->root, n},
                               {&d->v, 2 * n * SP_DRIVEN_MOST},
                               {&d->w, 2 * n * SP_DRIVEN_MOST},
                               {damped ? &d->c : NULL, entries},
                               {&d->size_c, entries},
                               {0}};
    /* without damping the list ends before c */
    const sp_status status = sp_arrays_make(arrays, &d->memory, err);
    if (status != SP_OK)
        return status;
    for (size_t r = 0; r < n; r++)
        d->root[r] = sqrt(net->mass[r]);
    return SP_OK;
}

sp_status sp_driven_make(const sp_network *net, const sp_network *dashpots, driven *out, sp_error *err) {
    driven d = {0};
    sp_sparse k = {0}, c = {0};
    int64_t *next = NULL;
    sp_status status = sp_network_assemble(net, &k, err);
    if (status == SP_OK && dashpots)
        status = sp_network_assemble(dashpots, &c, err);
    if (status == SP_OK && dashpots && c.p[c.n] != k.p[k.n])
        status = sp_fail(err, SP_EINVAL, "dashpots of %lld entries for springs of %lld, must be of the same network",
                         (long long)c.p[c.n], (long long)k.p[k.n]);
    if (status == SP_OK)
        status = allocate(net, &k, dashpots != NULL, &d, err);
    if (status == SP_OK) {
        next = sp_alloc((size_t)k.n, sizeof *next);
        status = next ? SP_OK : sp_fail_memory(err, (size_t)k.n * sizeof *next);
    }
    if (status == SP_OK) {
        fill_pattern(&k, &d);
        fill_values(&k, &d, next, d.a, d.size_a);
        if (dashpots)
            fill_values(&c, &d, next, d.c, d.size_c);
        status = sp_complex_ldl_make(&k, net, &d.ldl, err);
    }
    sp_free(next);
    sp_sparse_free(&c);
    sp_sparse_free(&k);
    if (status == SP_OK)
        *out = d;
    else
        sp_driven_free(&d);
    return status;
}

/* Estimates |H^-1| by a few steps of the power method on H^-1 and its adjoint. Since H is symmetric, H^-* x is the
 * conjugate of H^-1 applied to the conjugate of x. */
static sp_status estimate_inverse(driven *d, sp_error *err) {
    enum { STEPS = 4 };
    const int64_t n = d->n;
    for (int64_t k = 0; k < n; k++) { /* a starting vector without symmetry */
        d->v[2 * k] = 1 + 0.5 * sin(2.0 * (double)k * (double)k + 1);
        d->v[2 * k + 1] = 0;
    }
    d->inverse = 0;
    for (int step = 0; step < STEPS; step++) {
        const double before = sp_norm(2 * n, d->v);
        for (int64_t k = 0; k < 2 * n; k++)
            d->v[k] /= before;
        const sp_status status = sp_complex_ldl_solve(d->ldl, 1, d->v, d->w, err);
        if (status != SP_OK)
            return status;
        d->inverse = fmax(d->inverse, sp_norm(2 * n, d->w));
        for (int64_t k = 0; k < n; k++) {
            d->v[2 * k] = d->w[2 * k];
            d->v[2 * k + 1] = -d->w[2 * k + 1];
        }
    }
    return isfinite(d->inverse) ? SP_OK : sp_fail(err, SP_EREFUSED, "the matrix is singular");
}

sp_status sp_driven_factor(driven *d, double omega, sp_error *err) {
    d->omega = omega;
    d->size = 0;
    for (int64_t c = 0; c < d->n; c++) {
        double sum = 0;
        for (int64_t q = d->p[c]; q < d->p[c + 1]; q++) {
            d->x[2 * q] = d->a[q] - (d->i[q] == c ? omega * omega : 0);
            d->x[2 * q + 1] = d->c ? omega * d->c[q] : 0;
            sum += fabs(d->x[2 * q]) + fabs(d->x[2 * q + 1]);
        }
        d->size = fmax(d->size, sum);
    }
    for (int64_t q = 0; q < d->entries; q++)
        for (int part = 0; part < 2; part++)
            d->lower[2 * q + part] = d->x[2 * d->in_lower[q] + part];
    const sp_status status = sp_complex_ldl_factor(d->ldl, d->lower, err);
    return status == SP_OK ? estimate_inverse(d, err) : status;
}

/* r = b - H u; returns |r|. H is symmetric, so its columns are its rows. */
static double residual(const driven *d, const double *b, const double *u, double *r) {
    double squares = 0;
    for (int64_t c = 0; c < d->n; c++) {
        double re = b[2 * c], im = b[2 * c + 1];
        for (int64_t q = d->p[c]; q < d->p[c + 1]; q++) {
            const int64_t k = d->i[q];
            re -= d->x[2 * q] * u[2 * k] - d->x[2 * q + 1] * u[2 * k + 1];
            im -= d->x[2 * q] * u[2 * k + 1] + d->x[2 * q + 1] * u[2 * k];
        }
        r[2 * c] = re;
        r[2 * c + 1] = im;
        squares += re * re + im * im;
    }
    return sqrt(squares);
}

static double size2(const double *z) { return sqrt(z[0] * z[0] + z[1] * z[1]); }

/* Bound of |b - H u|: the computed residual r, and the rounding of itself, of H and of b. sizes [n]: scratch. */
static void bound_rest(const driven *d, const double *b, const double *u, const double *r, double *sizes,
                       double *rest) {
    for (int64_t k = 0; k < d->n; k++)
        sizes[k] = fabs(u[2 * k]) + fabs(u[2 * k + 1]);
    for (int64_t c = 0; c < d->n; c++) {
        double sum = fabs(b[2 * c]) + fabs(b[2 * c + 1]) + d->omega * d->omega * sizes[c];
        for (int64_t q = d->p[c]; q < d->p[c + 1]; q++)
            sum += (d->size_a[q] + (d->c ? d->omega * d->size_c[q] : 0)) * sizes[d->i[q]];
        rest[c] = size2(r + 2 * c) + DBL_EPSILON * (12 + (double)(d->p[c + 1] - d->p[c])) * sum;
    }
}

/* The factor knows no exchange of rows, so that small pivots may spoil it: solutions are refined until residuals are
 * rounding errors, or shrink no more. */
sp_status sp_driven_solve(driven *d, int count, const double *b, double *u, double *rest, sp_error *err) {
    enum { PASSES_MAX = 8 };
    const int64_t n = d->n;
    double before[SP_DRIVEN_MOST];
    sp_status status = sp_complex_ldl_solve(d->ldl, count, b, u, err);
    for (int pass = 0; status == SP_OK; pass++) {
        bool refine = false;
        for (int c = 0; c < count; c++) {
            const double *x = u + 2 * n * c, size = residual(d, b + 2 * n * c, x, d->v + 2 * n * c);
            if (size > 4 * DBL_EPSILON * d->size * sp_norm(2 * n, x))
                refine = refine || pass == 0 || size < 0.25 * before[c];
            before[c] = size;
        }
        if (!refine || pass == PASSES_MAX)
            break;
        status = sp_complex_ldl_solve(d->ldl, count, d->v, d->w, err);
        for (int64_t k = 0; k < 2 * n * count && status == SP_OK; k++)
            u[k] += d->w[k];
    }
    for (int c = 0; c < count && status == SP_OK; c++)
        bound_rest(d, b + 2 * n * c, u + 2 * n * c, d->v + 2 * n * c, d->w, rest + n * c);
    return status;
}

/* With r = source - H u and s = detector - H y for the computed u and y, the error of detector . u is y . r + s . H^-1
 * r. */
void sp_driven_response(const driven *d, const driven_solution *source, const driven_solution *detector, double f[2],
                        double *error) {
    const double *u = source->u, *y = detector->u, *b = detector->b;
    double first = 0, r2 = 0, s2 = 0, own = 0, terms = 0;
    f[0] = f[1] = 0;
    for (int64_t k = 0; k < d->n; k++) {
        const double r = source->rest[k], s = detector->rest[k];
        first += size2(y + 2 * k) * r;
        r2 += r * r;
        s2 += s * s;
        if (b[2 * k] == 0 && b[2 * k + 1] == 0)
            continue;
        f[0] += b[2 * k] * u[2 * k] - b[2 * k + 1] * u[2 * k + 1];
        f[1] += b[2 * k] * u[2 * k + 1] + b[2 * k + 1] * u[2 * k];
        own += (fabs(b[2 * k]) + fabs(b[2 * k + 1])) * size2(u + 2 * k);
        terms++;
    }
    /* the factor 10 is for the estimate of |H^-1|, a lower bound */
    *error = first + 10 * d->inverse * sqrt(r2) * sqrt(s2) + DBL_EPSILON * (12 + 2 * terms) * own;
}
