/* LDL' factorization with CHOLMOD. The factor is copied into groups of columns with equal rows, at least the degrees of
 * freedom of one grain. A solve then reads each row index once for up to four columns and eight right-hand sides. */
#include "linalg/ldl.h"
#include "base/base.h"
#include "base/clones.h"

#include <cholmod.h>
#include <float.h>
#include <limits.h>
#include <math.h>
#include <string.h>

enum { LANES = SP_LDL_LANES, WIDEST = 4 };
typedef double lanes __attribute__((vector_size(8 * LANES), aligned(64), may_alias));

/* Columns first .. first + width - 1, with the same `below` rows below the triangle. */
typedef struct group {
    int32_t first, width, below;
    int64_t rows;   /* its first row in sp_ldl.row */
    int64_t values; /* its first value in sp_ldl.value: the triangle by rows without the unit diagonal, then
                       [below][width] */
} group;

struct sp_ldl {
    cholmod_common common;
    cholmod_sparse *a;
    cholmod_factor *factor; /* only the pattern between calls */
    int64_t n, groups, negative;
    double sigma, size, error;
    group *group; /* [n] at most */
    int32_t *row, *order;
    double *value, *pivot, *work;
    bool ready;
};

/* stype -1: lower triangle. */
static cholmod_sparse *copy_matrix(const sp_sparse *a, cholmod_common *common) {
    const size_t n = (size_t)a->n, entries = (size_t)a->p[a->n];
    cholmod_sparse *m = cholmod_allocate_sparse(n, n, entries, 1, 1, -1, CHOLMOD_REAL, common);
    if (!m)
        return NULL;
    int *p = m->p, *i = m->i;
    for (size_t k = 0; k <= n; k++)
        p[k] = (int)a->p[k];
    for (size_t k = 0; k < entries; k++)
        i[k] = (int)a->i[k];
    memcpy(m->x, a->x, entries * sizeof(double));
    return m;
}

static sp_status cholmod_failed(const sp_ldl *f, sp_error *err) {
    if (f->common.status == CHOLMOD_OUT_OF_MEMORY)
        return sp_fail(err, SP_ENOMEM, "CHOLMOD: no memory for the factor");
    if (f->common.status == CHOLMOD_TOO_LARGE)
        return sp_fail(err, SP_EREFUSED, "CHOLMOD: the factor has more than 2^31 entries");
    return sp_fail(err, SP_EFAILED, "CHOLMOD: factorization failed (status %d)", f->common.status);
}

/* The largest row sum of |A|, which bounds its norm. */
static sp_status find_size(const sp_sparse *a, double *size, sp_error *err) {
    double *sum = sp_alloc((size_t)a->n, sizeof *sum), most = 0;
    if (!sum)
        return sp_fail_memory(err, (size_t)a->n * sizeof *sum);
    for (int64_t c = 0; c < a->n; c++)
        for (int64_t k = a->p[c]; k < a->p[c + 1]; k++) {
            sum[c] += fabs(a->x[k]);
            if (a->i[k] != c)
                sum[a->i[k]] += fabs(a->x[k]);
        }
    for (int64_t c = 0; c < a->n; c++)
        most = sum[c] > most || isnan(sum[c]) ? sum[c] : most;
    sp_free(sum);
    *size = most;
    return isfinite(most) ? SP_OK
                          : sp_fail(err, SP_EINVAL, "sparse eigenproblem: an entry of the matrix is not finite");
}

sp_status sp_ldl_make(const sp_sparse *a, sp_ldl **out, sp_error *err) {
    double size = 0;
    if (a->n < 1 || a->n >= INT32_MAX || a->p[a->n] >= INT32_MAX)
        return sp_fail(err, SP_EREFUSED, "sparse eigenproblem of order %lld with %lld entries, must be below 2^31",
                       (long long)a->n, (long long)a->p[a->n]);
    sp_status status = find_size(a, &size, err);
    if (status != SP_OK)
        return status;
    sp_ldl *f = sp_alloc(1, sizeof *f);
    if (!f)
        return sp_fail_memory(err, sizeof *f);
    cholmod_common *common = &f->common;
    cholmod_start(common);
    common->print = 0;
    common->try_catch = 1; /* CHOLMOD returns errors as a status and prints nothing */
    common->supernodal = CHOLMOD_SIMPLICIAL;
    common->final_ll = 0;
    common->final_super = 0;
    f->n = a->n;
    f->size = size;
    f->a = copy_matrix(a, common);
    f->factor = f->a ? cholmod_analyze(f->a, common) : NULL;
    f->group = sp_alloc((size_t)a->n, sizeof *f->group);
    f->order = sp_alloc((size_t)a->n, sizeof *f->order);
    f->pivot = sp_alloc((size_t)a->n, sizeof *f->pivot);
    f->work = sp_alloc((size_t)a->n, LANES * sizeof *f->work);
    if (!f->factor)
        status = f->a ? cholmod_failed(f, err) : sp_fail_memory(err, 12 * (size_t)a->p[a->n]);
    else if (!f->group || !f->order || !f->pivot || !f->work)
        status = sp_fail_memory(err, (size_t)a->n * (LANES + 5) * sizeof(double));
    if (status == SP_OK) {
        memcpy(f->order, f->factor->Perm, (size_t)a->n * sizeof *f->order);
        *out = f;
    } else
        sp_ldl_free(f);
    return status;
}

void sp_ldl_free(sp_ldl *f) {
    if (!f)
        return;
    cholmod_free_factor(&f->factor, &f->common);
    cholmod_free_sparse(&f->a, &f->common);
    cholmod_finish(&f->common);
    sp_free(f->group);
    sp_free(f->order);
    sp_free(f->pivot);
    sp_free(f->work);
    sp_free(f->row);
    sp_free(f->value);
    sp_free(f);
}

/* Whether column c+1 has the rows of column c except row c+1. */
static bool follows(const cholmod_factor *l, int64_t c) {
    const int *p = l->p, *i = l->i, *count = l->nz;
    if (count[c] != count[c + 1] + 1)
        return false;
    return memcmp(i + p[c] + 1, i + p[c + 1], (size_t)count[c + 1] * sizeof *i) == 0;
}

/* Finds widths and positions of the groups; returns the number of values. */
static int64_t find_groups(sp_ldl *f) {
    const int *count = f->factor->nz;
    int64_t rows = 0, values = 0;
    f->groups = 0;
    for (int64_t c = 0; c < f->n;) {
        int64_t width = 1;
        while (width < WIDEST && c + width < f->n && follows(f->factor, c + width - 1))
            width++;
        group *g = &f->group[f->groups++];
        *g = (group){(int32_t)c, (int32_t)width, (int32_t)(count[c] - width), rows, values};
        rows += g->below;
        values += width * (width - 1) / 2 + g->below * width;
        c += width;
    }
    return values;
}

static void copy_group(sp_ldl *f, const group *g) {
    const int *p = f->factor->p, *i = f->factor->i;
    const double *x = f->factor->x;
    double *triangle = f->value + g->values, *rest = triangle + g->width * (g->width - 1) / 2;
    for (int c = 0; c < g->width; c++) {
        const int64_t column = g->first + c, diagonal = p[column];
        f->pivot[column] = x[diagonal];
        for (int r = c + 1; r < g->width; r++)
            triangle[r * (r - 1) / 2 + c] = x[diagonal + r - c];
        for (int r = 0; r < g->below; r++)
            rest[r * g->width + c] = x[diagonal + g->width - c + r];
    }
    const int *rows = i + p[g->first] + g->width;
    for (int r = 0; r < g->below; r++)
        f->row[g->rows + r] = rows[r];
}

static sp_status copy_factor(sp_ldl *f, sp_error *err) {
    const int64_t values = find_groups(f);
    const group *last = &f->group[f->groups - 1];
    sp_free(f->row);
    sp_free(f->value);
    f->row = sp_alloc((size_t)(last->rows + last->below), sizeof *f->row);
    f->value = sp_alloc((size_t)values, sizeof *f->value);
    if (!f->row || !f->value)
        return sp_fail_memory(err, (size_t)values * sizeof *f->value);
    for (int64_t g = 0; g < f->groups; g++)
        copy_group(f, &f->group[g]);
    return SP_OK;
}

/* Bounds the backward error E. |E| <= (k + 3) eps |L||D||L'| for each entry, where k, the largest number of terms in an
 * entry, is at most the number of entries in a row of L (Higham, Accuracy and Stability of Numerical Algorithms, 2002,
 * section 10.1; the proof does not need positive pivots). The largest row sum bounds the norm of a symmetric matrix.
 * Forming A - sigma adds one rounding. */
static void find_error(sp_ldl *f) {
    double *t = f->work, *s = f->work + f->n, *terms = f->work + 2 * f->n, most = 0;
    for (int64_t k = 0; k < f->n; k++)
        s[k] = terms[k] = 0;
    for (int pass = 0; pass < 2; pass++) /* t = |D||L'| 1, then s = |L| t */
        for (int64_t q = 0; q < f->groups; q++) {
            const group *g = &f->group[q];
            const double *triangle = f->value + g->values, *rest = triangle + g->width * (g->width - 1) / 2;
            for (int c = 0; c < g->width; c++) {
                const int64_t column = g->first + c;
                double sum = 1;
                for (int r = c + 1; r < g->width; r++) {
                    const double x = fabs(triangle[r * (r - 1) / 2 + c]);
                    sum += x;
                    if (pass == 1)
                        s[g->first + r] += x * t[column], terms[g->first + r]++;
                }
                for (int r = 0; r < g->below; r++) {
                    const double x = fabs(rest[r * g->width + c]);
                    const int32_t row = f->row[g->rows + r];
                    sum += x;
                    if (pass == 1)
                        s[row] += x * t[column], terms[row]++;
                }
                if (pass == 0)
                    t[column] = sum * fabs(f->pivot[column]);
                else
                    s[column] += t[column];
            }
        }
    for (int64_t k = 0; k < f->n; k++) {
        const double bound = (terms[k] + 3) * s[k];
        most = bound > most || isnan(bound) ? bound : most;
    }
    f->error = DBL_EPSILON * (most + f->size + fabs(f->sigma));
}

sp_status sp_ldl_factor(sp_ldl *f, double sigma, sp_error *err) {
    double beta[2] = {-sigma, 0};
    cholmod_common *common = &f->common;
    f->ready = false;
    f->sigma = sigma;
    if (!isfinite(sigma))
        return sp_fail(err, SP_EINVAL, "shift = %g, must be finite", sigma);
    cholmod_factorize_p(f->a, beta, NULL, 0, f->factor, common);
    if (common->status != CHOLMOD_OK && common->status != CHOLMOD_NOT_POSDEF)
        return cholmod_failed(f, err);
    if (common->status == CHOLMOD_NOT_POSDEF || f->factor->minor != f->factor->n)
        return sp_fail(err, SP_EREFUSED, "shift = %.17g: pivot %lld of %lld is zero", sigma,
                       (long long)f->factor->minor, (long long)f->factor->n);
    sp_status status = copy_factor(f, err);
    /* the values have been copied */
    cholmod_change_factor(CHOLMOD_PATTERN, 0, 0, 1, 1, f->factor, common);
    if (status != SP_OK)
        return status;
    f->negative = 0;
    for (int64_t k = 0; k < f->n; k++) {
        if (f->pivot[k] == 0 || !isfinite(f->pivot[k]))
            return sp_fail(err, SP_EREFUSED, "shift = %.17g: pivot %lld of %lld is %g", sigma, (long long)k,
                           (long long)f->n, f->pivot[k]);
        f->negative += f->pivot[k] < 0;
    }
    find_error(f);
    f->ready = true;
    return SP_OK;
}

double sp_ldl_sigma(const sp_ldl *f) { return f->sigma; }
int64_t sp_ldl_negative(const sp_ldl *f) { return f->negative; }
double sp_ldl_error(const sp_ldl *f) { return f->ready ? f->error : HUGE_VAL; }

/* x = L^-1 x for a group of w columns. */
static ALWAYS_INLINE void forward(const sp_ldl *f, const group *g, int w, lanes *x) {
    const double *triangle = f->value + g->values, *l = triangle + w * (w - 1) / 2;
    const int32_t *row = f->row + g->rows;
    lanes *own = x + g->first, top[WIDEST];
    for (int r = 0; r < w; r++) {
        top[r] = own[r];
        for (int c = 0; c < r; c++)
            top[r] -= triangle[r * (r - 1) / 2 + c] * top[c];
        own[r] = top[r];
    }
    for (int32_t r = 0; r < g->below; r++, l += w) {
        lanes sum = l[0] * top[0];
        for (int c = 1; c < w; c++)
            sum += l[c] * top[c];
        x[row[r]] -= sum;
    }
}

/* x = (D L')^-1 x for a group of w columns. */
static ALWAYS_INLINE void backward(const sp_ldl *f, const group *g, int w, lanes *x) {
    const double *triangle = f->value + g->values, *l = triangle + w * (w - 1) / 2;
    const int32_t *row = f->row + g->rows;
    lanes *own = x + g->first, top[WIDEST];
    for (int c = 0; c < w; c++)
        top[c] = own[c] / f->pivot[g->first + c];
    for (int32_t r = 0; r < g->below; r++, l += w) {
        const lanes there = x[row[r]];
        for (int c = 0; c < w; c++)
            top[c] -= l[c] * there;
    }
    for (int c = w - 1; c >= 0; c--) {
        for (int r = c + 1; r < w; r++)
            top[c] -= triangle[r * (r - 1) / 2 + c] * top[r];
        own[c] = top[c];
    }
}

CLONES static void solve_lanes(const sp_ldl *f, lanes *x) {
    for (int64_t k = 0; k < f->groups; k++) {
        const group *g = &f->group[k];
        switch (g->width) {
        case 1: forward(f, g, 1, x); break;
        case 2: forward(f, g, 2, x); break;
        case 3: forward(f, g, 3, x); break;
        default: forward(f, g, 4, x); break;
        }
    }
    for (int64_t k = f->groups - 1; k >= 0; k--) {
        const group *g = &f->group[k];
        switch (g->width) {
        case 1: backward(f, g, 1, x); break;
        case 2: backward(f, g, 2, x); break;
        case 3: backward(f, g, 3, x); break;
        default: backward(f, g, 4, x); break;
        }
    }
}

void sp_ldl_solve(sp_ldl *f, const double *b, double *x) {
    for (int64_t k = 0; k < f->n; k++)
        for (int q = 0; q < LANES; q++)
            f->work[k * LANES + q] = b[q * f->n + f->order[k]];
    solve_lanes(f, (lanes *)f->work);
    for (int64_t k = 0; k < f->n; k++)
        for (int q = 0; q < LANES; q++)
            x[q * f->n + f->order[k]] = f->work[k * LANES + q];
}
