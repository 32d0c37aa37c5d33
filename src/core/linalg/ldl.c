/* LDL' factorization of A - sigma by supernodes, with its inertia, a bound of its error, and solves of eight right-hand
 * sides at once. */
#include "linalg/ldl.h"
#include "base/base.h"
#include "base/clones.h"
#include "base/pool.h"
#include "linalg/supernodes.h"

#include <cblas.h>
#include <float.h>
#include <math.h>
#include <string.h>

#define NUMBER double
#define GEMM(ta, tb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)                                                     \
    cblas_dgemm(CblasRowMajor, ta, tb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)
#define TRSM(m, n, a, lda, b, ldb)                                                                                     \
    cblas_dtrsm(CblasRowMajor, CblasRight, CblasLower, CblasTrans, CblasUnit, m, n, 1, a, lda, b, ldb)
#include "linalg/panels.inc"

enum { LANES = SP_LDL_LANES, CHUNK = 256 };
typedef double lanes __attribute__((vector_size(8 * LANES), aligned(64), may_alias));

/* Values of a factor that is not worth sharing. */
static const int64_t SMALL = 4000000;

struct sp_ldl {
    sp_supernodes s;
    panel_work memory;
    int64_t entries, negative;
    double sigma, size, error;
    double *entry; /* [entries] the lower triangle of A */
    double *value, *pivot, *work;
    sp_pool *pool; /* NULL: one thread */
    bool ready;
};

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

sp_status sp_ldl_make(const sp_sparse *a, const sp_network *net, sp_ldl **out, sp_error *err) {
    double size = 0;
    sp_status status = find_size(a, &size, err);
    if (status != SP_OK)
        return status;
    sp_ldl *f = sp_alloc(1, sizeof *f);
    if (!f)
        return sp_fail_memory(err, sizeof *f);
    f->size = size;
    f->entries = a->p[a->n];
    status = sp_supernodes_make(a, net, &f->s, err);
    if (status == SP_OK)
        status = panel_work_make(&f->s, &f->memory, err);
    if (status == SP_OK) {
        const size_t n = (size_t)a->n, values = (size_t)f->s.value_at[f->s.count];
        f->entry = sp_alloc((size_t)f->entries, sizeof *f->entry);
        f->value = sp_alloc_bare(values, sizeof *f->value);
        f->pivot = sp_alloc(n, sizeof *f->pivot);
        f->work = sp_alloc(n, LANES * sizeof *f->work);
        if (f->entry && f->value && f->pivot && f->work)
            memcpy(f->entry, a->x, (size_t)f->entries * sizeof *f->entry);
        else
            status = sp_fail_memory(err, ((size_t)f->entries + values + (LANES + 1) * n) * sizeof(double));
    }
    if (status == SP_OK)
        *out = f;
    else
        sp_ldl_free(f);
    return status;
}

sp_status sp_ldl_set(sp_ldl *f, const sp_sparse *a, sp_error *err) {
    const sp_status status = find_size(a, &f->size, err);
    memcpy(f->entry, a->x, (size_t)f->entries * sizeof *f->entry);
    return status;
}

sp_status sp_ldl_share(sp_ldl *f, int threads, sp_error *err) {
    const bool small = f->s.value_at[f->s.count] < SMALL;
    const sp_status status = f->pool || small ? SP_OK : sp_pool_make(threads, &f->pool, err);
    f->memory.pool = f->pool;
    return status;
}

void sp_ldl_free(sp_ldl *f) {
    if (!f)
        return;
    sp_pool_free(f->pool);
    sp_supernodes_free(&f->s);
    panel_work_free(&f->memory);
    sp_free(f->entry);
    sp_free(f->value);
    sp_free(f->pivot);
    sp_free(f->work);
    sp_free(f);
}

/* t = |D||L'| 1, by supernodes. */
static void column_sums(const sp_ldl *f, double *t) {
    for (int64_t k = 0; k < f->s.count; k++) {
        const int width = sp_supernode_width(&f->s, k), many = sp_supernode_rows(&f->s, k);
        const double *x = f->value + f->s.value_at[k];
        double *sum = t + f->s.first[k];
        for (int c = 0; c < width; c++)
            sum[c] = 1;
        for (int r = 1; r < many; r++)
            for (int c = 0; c < (r < width ? r : width); c++)
                sum[c] += fabs(x[(int64_t)r * width + c]);
        for (int c = 0; c < width; c++)
            sum[c] *= fabs(f->pivot[f->s.first[k] + c]);
    }
}

/* s = |L| t, and the number of entries in each row of L. */
static void row_sums(const sp_ldl *f, const double *t, double *s, double *terms) {
    for (int64_t k = 0; k < f->s.n; k++) {
        s[k] = t[k];
        terms[k] = 0;
    }
    for (int64_t k = 0; k < f->s.count; k++) {
        const int width = sp_supernode_width(&f->s, k), many = sp_supernode_rows(&f->s, k);
        const double *x = f->value + f->s.value_at[k], *of = t + f->s.first[k];
        const int32_t *row = f->s.rows + f->s.rows_at[k];
        for (int r = 1; r < many; r++) {
            const int last = r < width ? r : width;
            double sum = 0;
            for (int c = 0; c < last; c++)
                sum += fabs(x[(int64_t)r * width + c]) * of[c];
            s[row[r]] += sum;
            terms[row[r]] += last;
        }
    }
}

/* Bounds the backward error E. |E| <= (k + 4) eps |L||D||L'| for each entry, where k, the largest number of terms in an
 * entry, is at most the number of entries in a row of L, in whatever order they are added (Higham, Accuracy and
 * Stability of Numerical Algorithms, 2002, section 10.1; the proof does not need positive pivots). The largest row sum
 * bounds the norm of a symmetric matrix. Forming A - sigma adds one rounding. */
static void find_error(sp_ldl *f) {
    double *t = f->work, *s = t + f->s.n, *terms = s + f->s.n, most = 0;
    column_sums(f, t);
    row_sums(f, t, s, terms);
    for (int64_t k = 0; k < f->s.n; k++) {
        const double bound = (terms[k] + 4) * s[k];
        most = bound > most || isnan(bound) ? bound : most;
    }
    f->error = DBL_EPSILON * (most + f->size + fabs(f->sigma));
}

sp_status sp_ldl_factor(sp_ldl *f, double sigma, sp_error *err) {
    const sp_supernodes *s = &f->s;
    f->ready = false;
    f->sigma = sigma;
    if (!isfinite(sigma))
        return sp_fail(err, SP_EINVAL, "shift = %g, must be finite", sigma);
    memset(f->value, 0, (size_t)s->value_at[s->count] * sizeof *f->value);
    for (int64_t k = 0; k < f->entries; k++)
        f->value[s->place[k]] += f->entry[k];
    for (int64_t k = 0; k < s->n; k++)
        f->value[s->diagonal[k]] -= sigma;
    factor_panels(s, f->value, f->pivot, &f->memory);
    f->negative = 0;
    for (int64_t k = 0; k < s->n; k++) {
        if (f->pivot[k] == 0 || !isfinite(f->pivot[k]))
            return sp_fail(err, SP_EREFUSED, "shift = %.17g: pivot %lld of %lld is %g", sigma, (long long)k,
                           (long long)s->n, f->pivot[k]);
        f->negative += f->pivot[k] < 0;
    }
    find_error(f);
    f->ready = true;
    return SP_OK;
}

double sp_ldl_least_ratio(const sp_ldl *f, const sp_sparse *a) {
    double least = 1;
    for (int64_t k = 0; k < f->s.n; k++) {
        const double ratio = f->pivot[k] / a->x[a->p[f->s.order[k]]];
        least = ratio >= least ? least : ratio; /* keeps a NAN */
    }
    return least;
}

sp_pool *sp_ldl_pool(const sp_ldl *f) { return f->pool; }
double sp_ldl_sigma(const sp_ldl *f) { return f->sigma; }
int64_t sp_ldl_negative(const sp_ldl *f) { return f->negative; }
double sp_ldl_error(const sp_ldl *f) { return f->ready ? f->error : HUGE_VAL; }

#define LANE    lanes
#define NAME(x) x##_lanes
#include "linalg/panel_solve.inc"
#undef LANE
#undef NAME
#define LANE    double
#define NAME(x) x##_single
#include "linalg/panel_solve.inc"
#undef LANE
#undef NAME

void sp_ldl_solve(sp_ldl *f, const double *b, double *x) {
    const int64_t n = f->s.n;
    for (int64_t k = 0; k < n; k++)
        for (int q = 0; q < LANES; q++)
            f->work[k * LANES + q] = b[q * n + f->s.order[k]];
    solve_lanes(&f->s, f->value, f->pivot, (lanes *)f->work);
    for (int64_t k = 0; k < n; k++)
        for (int q = 0; q < LANES; q++)
            x[q * n + f->s.order[k]] = f->work[k * LANES + q];
}

void sp_ldl_solve_one(sp_ldl *f, const double *b, double *x) {
    for (int64_t k = 0; k < f->s.n; k++)
        f->work[k] = b[f->s.order[k]];
    solve_single(&f->s, f->value, f->pivot, f->work);
    for (int64_t k = 0; k < f->s.n; k++)
        x[f->s.order[k]] = f->work[k];
}
