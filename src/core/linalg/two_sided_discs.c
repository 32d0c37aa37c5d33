/* Encloses the lowest eigenvalues of a nonsymmetric A in discs, and proves that there are no others.
 *
 * With approximate right and left vectors V and W, W^T V = G ~ 1, and an orthonormal basis Y of the space orthogonal to
 * W, A is similar to [[D + G^-1 W^T R, G^-1 L^T Y], [Y^T (1 - P) R, A2]], P = V G^-1 W^T, where D are the eigenvalues
 * found and R = A V - V D, L = A^T W - W D^T. The symmetric part of A2 = Y^T A Y - Y^T V G^-1 L^T Y is at least c, by
 * the inertia of S - mu and W^T (S - mu)^-1 W (Haynsworth): hence |(A2 - z)^-1| <= 1/(c - Re z), and the eigenvalues
 * left of c are those of D plus a small matrix: Gershgorin's theorem, after each column of a guard was made as small as
 * the others. */
#include "base/base.h"
#include "base/vector.h"
#include "linalg/arrays.h"
#include "linalg/eigen.h"
#include "linalg/two_sided.h"

#include <float.h>
#include <math.h>
#include <string.h>

typedef struct enclosure {
    const sp_two_sided *t;
    const sp_sparse *a;
    const sp_two_sided_spec *spec;
    int64_t n, m;
    double *q, *x;              /* [m + 8][n] orthonormal basis of the left vectors; scratch */
    double *small, *tau;        /* [m][m], [m] */
    double *w, *r, *l, *weight; /* [m] |left|, bounds of |R| and |L| by columns, weights of Gershgorin's columns */
    double rounding;            /* upper bound of the error of a computed product A x, over |x| */
    double top;                 /* upper bound of |A| */
    double tilt;                /* angle between the spaces of Q and W: rounding */
    double slant;               /* |Y^T V| */
    double off;                 /* |G - 1| */
    double *memory;
} enclosure;

static sp_status allocate(enclosure *e, sp_error *err) {
    const size_t n = (size_t)e->n, m = (size_t)e->m;
    const sp_array arrays[] = {{&e->q, (m + SP_LDL_LANES) * n},
                               {&e->x, (m + SP_LDL_LANES) * n},
                               {&e->small, m * m},
                               {&e->tau, m},
                               {&e->w, m},
                               {&e->r, m},
                               {&e->l, m},
                               {&e->weight, m},
                               {0}};
    return sp_arrays_make(arrays, &e->memory, err);
}

static double norm(int64_t n, const double *x) { return sp_norm(n, x) * (1 + (double)n * DBL_EPSILON); }

/* |A|^2 is at most the largest sum of a column times the largest of a row. A has the pattern of its transpose. */
static void find_rounding(enclosure *e) {
    double columns = 0, rows = 0;
    int64_t longest = 0;
    memset(e->q, 0, (size_t)e->n * sizeof *e->q);
    for (int64_t c = 0; c < e->n; c++) {
        double sum = 0;
        for (int64_t k = e->a->p[c]; k < e->a->p[c + 1]; k++) {
            sum += fabs(e->a->x[k]);
            e->q[e->a->i[k]] += fabs(e->a->x[k]);
        }
        columns = fmax(columns, sum);
        longest = e->a->p[c + 1] - e->a->p[c] > longest ? e->a->p[c + 1] - e->a->p[c] : longest;
    }
    rows = sp_largest(e->n, e->q);
    e->top = sqrt(columns * rows);
    e->rounding = e->spec->noise + (double)(longest + 8) * DBL_EPSILON * e->top;
}

/* The orthonormal basis of W, and |V - Q Q^T V|. */
static sp_status find_basis(enclosure *e, sp_error *err) {
    const int64_t n = e->n, m = e->m;
    const size_t block = (size_t)(n * m) * sizeof *e->q;
    memcpy(e->q, e->t->left, block);
    const sp_status status = sp_orthonormalize(n, m, e->q, e->tau, err);
    sp_project(n, m, e->q, m, e->t->right, e->small);
    memcpy(e->x, e->t->right, block);
    sp_take_away(n, m, e->q, m, e->small, e->x);
    e->tilt = 2 * (double)(n * m) * DBL_EPSILON * sqrt((double)m) * norm(n * m, e->t->left); /* W's condition */
    e->slant = norm(n * m, e->x) + e->tilt * sqrt((double)m);
    return status;
}

/* |G - 1|, and the norms of the residuals. small = W^T R. */
static void find_residuals(enclosure *e) {
    const int64_t n = e->n, m = e->m;
    double most = 0;
    sp_project(n, m, e->t->left, m, e->t->right, e->small);
    for (int64_t k = 0; k < m; k++) {
        e->small[k * m + k] -= 1;
        e->w[k] = norm(n, e->t->left + k * n);
        most = fmax(most, e->w[k]);
    }
    e->off = norm(m * m, e->small) + (double)(n * m) * DBL_EPSILON * most;
    for (int side = 1; side >= 0; side--) { /* the right ones last, which remain in x */
        double *out = side ? e->l : e->r;
        sp_two_sided_residuals(e->t, e->a, side == 1, e->x);
        for (int64_t k = 0; k < m; k++)
            out[k] = norm(n, e->x + k * n) + (side ? e->w[k] : 1) * e->rounding;
    }
    sp_project(n, m, e->t->left, m, e->x, e->small);
}

/* |Q - (S - mu) X|. work: [2 n]. */
static double rest_of(const enclosure *e, double mu, double *work) {
    const int64_t n = e->n;
    double sum = 0;
    for (int64_t k = 0; k < e->m; k++) {
        const double *x = e->x + k * n;
        sp_sparse_apply(e->a, false, x, work);
        sp_sparse_apply(e->a, true, x, work + n);
        for (int64_t q = 0; q < n; q++) {
            const double rest = e->q[k * n + q] - 0.5 * (work[q] + work[n + q]) + mu * x[q];
            sum += rest * rest;
        }
    }
    return sqrt(sum);
}

/* Whether S >= mu on the space orthogonal to the left vectors: Q^T (S - mu)^-1 Q has as many negative eigenvalues as S
 * - mu. free: no eigenvalue of S lies between mu and mu + free. */
static sp_status is_above(enclosure *e, sp_ldl *factor, double mu, double free, bool *above, sp_error *err) {
    const int64_t n = e->n, m = e->m;
    int64_t negative = 0;
    for (int64_t k = 0; k < m; k += SP_LDL_LANES)
        sp_ldl_solve(factor, e->q + k * n, e->x + k * n);
    const double size = norm(n * m, e->x), spoilt = sp_ldl_error(factor) + e->rounding;
    double *work = sp_alloc(2 * (size_t)n, sizeof *work);
    if (!work)
        return sp_fail_memory(err, 2 * (size_t)n * sizeof *work);
    const double rest = rest_of(e, mu, work) + spoilt * size;
    sp_free(work);
    sp_project(n, m, e->q, m, e->x, e->small);
    const double error = rest * size + rest * rest / free + (double)(n * m) * DBL_EPSILON * size;
    for (int64_t c = 0; c < m; c++)
        for (int64_t r = c; r < m; r++)
            e->small[c * m + r] = 0.5 * (e->small[c * m + r] + e->small[r * m + c]);
    const sp_status status = sp_eigen_values(m, e->small, e->tau, err);
    for (int64_t k = 0; k < m; k++)
        negative += e->tau[k] < -error;
    *above = negative >= sp_ldl_negative(factor);
    return status;
}

/* A lower bound of the symmetric part of A2. */
static sp_status find_bottom(enclosure *e, sp_ldl *factor, double *bottom, sp_error *err) {
    static const double places[] = {0.71, 0.53, 0.83, 0.37, 0.61, 0.23, 0.11};
    const sp_two_sided *t = e->t;
    const double low = t->re[t->wanted - 1], width = t->re[t->count - 1] - low, gap = 1e-3 * width;
    bool above = false;
    sp_status status = SP_OK;
    for (size_t k = 0; k < sizeof places / sizeof *places && !above; k++) {
        const double mu = low + places[k] * width;
        status = sp_ldl_factor(factor, mu + gap, err);
        const int64_t count = status == SP_OK ? sp_ldl_negative(factor) : -1;
        double spoilt = status == SP_OK ? sp_ldl_error(factor) : 0;
        if (status == SP_OK)
            status = sp_ldl_factor(factor, mu, err);
        spoilt += status == SP_OK ? sp_ldl_error(factor) + e->rounding : 0;
        if (status == SP_OK && count == sp_ldl_negative(factor) && spoilt < 0.25 * gap)
            status = is_above(e, factor, mu, 0.5 * gap, &above, err);
        if (status != SP_OK && status != SP_EREFUSED)
            return status;
        *bottom = mu - spoilt - 2 * e->tilt * e->top;
    }
    *bottom -= e->slant * (1 + 2 * e->off) * norm(e->m, e->l);
    if (!above || !(*bottom > low) || !(e->off < 1e-3))
        return sp_fail(err, SP_EREFUSED, "it cannot be proved that no motions are missing below omega^2 = %.6g", low);
    return SP_OK;
}

/* Radii for eigenvalues with real parts up to `limit`. */
static void find_radii(enclosure *e, double bottom, double limit, double *radius) {
    const int64_t m = e->m;
    const double loose = 1 + 2 * e->off, slope = (1 + e->slant * loose * norm(m, e->w)) / (bottom - limit);
    double all = 0, lefts = 0, rights = 0, noise = 0;
    for (int64_t k = 0; k < m; k++) {
        const double *pair = e->r + (e->t->im[k] > 0 ? k + 1 : e->t->im[k] < 0 ? k - 1 : k);
        e->weight[k] = fmin(1, e->spec->goal / fmax(e->r[k], *pair));
        lefts += e->l[k];
        rights += e->weight[k] * e->r[k];
        noise += e->weight[k] * (e->rounding + (double)e->n * DBL_EPSILON * e->r[k]);
    }
    for (int64_t i = 0; i < m; i++) {
        radius[i] = e->w[i] * noise;
        for (int64_t j = 0; j < m; j++)
            radius[i] += e->weight[j] * fabs(e->small[j * m + i]);
        all += radius[i];
    }
    for (int64_t i = 0; i < m; i++)
        radius[i] = (radius[i] + 2 * e->off * all + (e->l[i] + 2 * e->off * lefts) * rights * slope) / e->weight[i];
    for (int64_t i = 0; i + 1 < m; i++) /* the two rows of a complex pair form one block, which is normal */
        if (e->t->im[i] > 0) {
            radius[i] = radius[i + 1] = radius[i] + radius[i + 1];
            i++;
        }
}

static sp_status fill(enclosure *e, double bottom, double *complete, sp_discs *d, sp_error *err) {
    const size_t m = (size_t)e->m;
    const sp_status status = sp_discs_empty(e->m, d, err);
    if (status != SP_OK)
        return status;
    *complete = 0.5 * (e->t->re[e->t->wanted - 1] + bottom);
    memcpy(d->re, e->t->re, m * sizeof *d->re);
    memcpy(d->im, e->t->im, m * sizeof *d->im);
    find_radii(e, bottom, *complete, d->radius);
    return SP_OK;
}

sp_status sp_two_sided_enclose(const sp_two_sided *t, sp_ldl *factor, const sp_sparse *a, const sp_two_sided_spec *spec,
                               double *complete, sp_discs *out, sp_error *err) {
    enclosure e = {.t = t, .a = a, .spec = spec, .n = t->n, .m = t->count};
    double bottom = 0;
    sp_status status = allocate(&e, err);
    if (status == SP_OK) {
        find_rounding(&e);
        status = find_basis(&e, err);
    }
    if (status == SP_OK) {
        find_residuals(&e); /* for the norms, which the bottom needs */
        status = find_bottom(&e, factor, &bottom, err);
    }
    if (status == SP_OK) {
        find_residuals(&e); /* for W^T R, which the bottom has overwritten */
        status = fill(&e, bottom, complete, out, err);
    }
    sp_free(e.memory);
    return status;
}
