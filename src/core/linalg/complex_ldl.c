/* LDL' factorization of complex symmetric matrices by supernodes. */
#include "linalg/complex_ldl.h"
#include "base/base.h"
#include "base/pool.h"
#include "linalg/supernodes.h"

#include <cblas.h>
#include <math.h>
#include <string.h>

typedef double _Complex number;

#define NUMBER number
#define GEMM(ta, tb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)                                                     \
    cblas_zgemm(CblasRowMajor, ta, tb, m, n, k, &(number){alpha}, a, lda, b, ldb, &(number){beta}, c, ldc)
#define TRSM(m, n, a, lda, b, ldb)                                                                                     \
    cblas_ztrsm(CblasRowMajor, CblasRight, CblasLower, CblasTrans, CblasUnit, m, n, &(number){1}, a, lda, b, ldb)
#include "linalg/panels.inc"

struct sp_complex_ldl {
    sp_supernodes s;
    panel_work memory;
    int64_t entries;
    number *value, *pivot, *inverse; /* inverse: of the pivots */
    int most;                        /* right-hand sides for which there is memory */
    number *work, *part;             /* [n][most], rows of a supernode [rows][most] */
};

sp_status sp_complex_ldl_make(const sp_sparse *a, const sp_network *net, sp_complex_ldl **out, sp_error *err) {
    sp_complex_ldl *f = sp_alloc(1, sizeof *f);
    if (!f)
        return sp_fail_memory(err, sizeof *f);
    f->entries = a->p[a->n];
    sp_status status = sp_supernodes_make(a, net, &f->s, err);
    if (status == SP_OK)
        status = panel_work_make(&f->s, &f->memory, err);
    if (status == SP_OK) {
        const size_t n = (size_t)a->n, values = (size_t)f->s.value_at[f->s.count];
        f->value = sp_alloc(values, sizeof *f->value);
        f->pivot = sp_alloc(n, sizeof *f->pivot);
        f->inverse = sp_alloc(n, sizeof *f->inverse);
        if (!f->value || !f->pivot || !f->inverse)
            status = sp_fail_memory(err, (values + 2 * n) * sizeof *f->value);
    }
    if (status == SP_OK)
        *out = f;
    else
        sp_complex_ldl_free(f);
    return status;
}

void sp_complex_ldl_free(sp_complex_ldl *f) {
    if (!f)
        return;
    sp_supernodes_free(&f->s);
    panel_work_free(&f->memory);
    sp_free(f->value);
    sp_free(f->pivot);
    sp_free(f->inverse);
    sp_free(f->work);
    sp_free(f->part);
    sp_free(f);
}

sp_status sp_complex_ldl_factor(sp_complex_ldl *f, const double *x, sp_error *err) {
    const sp_supernodes *s = &f->s;
    const number *entry = (const number *)x;
    memset(f->value, 0, (size_t)s->value_at[s->count] * sizeof *f->value);
    for (int64_t k = 0; k < f->entries; k++)
        f->value[s->place[k]] += entry[k];
    factor_panels(s, f->value, f->pivot, &f->memory);
    for (int64_t k = 0; k < s->n; k++) {
        const double re = __real__ f->pivot[k], im = __imag__ f->pivot[k];
        if (!(fabs(re) + fabs(im) > 0) || !isfinite(re + im))
            return sp_fail(err, SP_EREFUSED, "the matrix is singular");
        f->inverse[k] = 1 / f->pivot[k];
    }
    return SP_OK;
}

static sp_status reserve(sp_complex_ldl *f, int count, sp_error *err) {
    if (count <= f->most)
        return SP_OK;
    const size_t n = (size_t)f->s.n, many = (size_t)count;
    sp_free(f->work);
    sp_free(f->part);
    f->work = sp_alloc(n, many * sizeof *f->work);
    f->part = sp_alloc(n, many * sizeof *f->part);
    f->most = f->work && f->part ? count : 0;
    return f->most > 0 ? SP_OK : sp_fail_memory(err, 2 * n * many * sizeof *f->work);
}

/* x = L^-1 x for the columns of supernode k, and what they do to the rows below. */
static void forward(sp_complex_ldl *f, int64_t k, int count, number *x) {
    static const number one = 1, zero = 0;
    const int width = sp_supernode_width(&f->s, k), below = sp_supernode_rows(&f->s, k) - width;
    const int32_t *row = f->s.rows + f->s.rows_at[k] + width;
    const number *panel = f->value + f->s.value_at[k];
    number *own = x + (int64_t)f->s.first[k] * count;
    cblas_ztrsm(CblasRowMajor, CblasLeft, CblasLower, CblasNoTrans, CblasUnit, width, count, &one, panel, width, own,
                count);
    if (below == 0)
        return;
    cblas_zgemm(CblasRowMajor, CblasNoTrans, CblasNoTrans, below, count, width, &one, panel + (int64_t)width * width,
                width, own, count, &zero, f->part, count);
    for (int r = 0; r < below; r++)
        for (int c = 0; c < count; c++)
            x[(int64_t)row[r] * count + c] -= f->part[(int64_t)r * count + c];
}

/* x = (D L')^-1 x for the same columns. */
static void backward(sp_complex_ldl *f, int64_t k, int count, number *x) {
    static const number one = 1, minus = -1;
    const int width = sp_supernode_width(&f->s, k), below = sp_supernode_rows(&f->s, k) - width;
    const int32_t *row = f->s.rows + f->s.rows_at[k] + width;
    const number *panel = f->value + f->s.value_at[k], *inverse = f->inverse + f->s.first[k];
    number *own = x + (int64_t)f->s.first[k] * count;
    for (int r = 0; r < width; r++)
        for (int c = 0; c < count; c++)
            own[(int64_t)r * count + c] *= inverse[r];
    for (int r = 0; r < below; r++)
        memcpy(f->part + (int64_t)r * count, x + (int64_t)row[r] * count, (size_t)count * sizeof *x);
    if (below > 0)
        cblas_zgemm(CblasRowMajor, CblasTrans, CblasNoTrans, width, count, below, &minus,
                    panel + (int64_t)width * width, width, f->part, count, &one, own, count);
    cblas_ztrsm(CblasRowMajor, CblasLeft, CblasLower, CblasTrans, CblasUnit, width, count, &one, panel, width, own,
                count);
}

sp_status sp_complex_ldl_solve(sp_complex_ldl *f, int count, const double *b, double *x, sp_error *err) {
    const int64_t n = f->s.n;
    const number *from = (const number *)b;
    number *to = (number *)x;
    const sp_status status = reserve(f, count, err);
    if (status != SP_OK)
        return status;
    for (int64_t k = 0; k < n; k++)
        for (int c = 0; c < count; c++)
            f->work[k * count + c] = from[c * n + f->s.order[k]];
    for (int64_t k = 0; k < f->s.count; k++)
        forward(f, k, count, f->work);
    for (int64_t k = f->s.count; k-- > 0;)
        backward(f, k, count, f->work);
    for (int64_t k = 0; k < n; k++)
        for (int c = 0; c < count; c++)
            to[c * n + f->s.order[k]] = f->work[k * count + c];
    return SP_OK;
}
