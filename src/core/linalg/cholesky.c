/* Sparse positive definite matrices: the LDL' factor, refused unless all pivots are positive and above rounding. */
#include "linalg/cholesky.h"
#include "base/base.h"
#include "linalg/ldl.h"

struct sp_cholesky {
    sp_ldl *ldl;
    int64_t n;
};

sp_status sp_cholesky_analyze(const sp_sparse *a, sp_cholesky **out, sp_error *err) {
    sp_cholesky *c = sp_alloc(1, sizeof *c);
    if (!c)
        return sp_fail_memory(err, sizeof *c);
    c->n = a->n;
    const sp_status status = sp_ldl_make(a, &c->ldl, err);
    if (status == SP_OK)
        *out = c;
    else
        sp_cholesky_free(c);
    return status;
}

sp_status sp_cholesky_factorize(sp_cholesky *c, const sp_sparse *a, sp_error *err) {
    sp_status status = sp_ldl_set(c->ldl, a, err);
    if (status == SP_OK)
        status = sp_ldl_factor(c->ldl, 0, err);
    if (status != SP_OK)
        return status;
    if (sp_ldl_negative(c->ldl) > 0)
        return sp_fail(err, SP_EREFUSED, "the matrix is not positive definite (%lld of %lld pivots are negative)",
                       (long long)sp_ldl_negative(c->ldl), (long long)c->n);
    const double ratio = sp_ldl_least_ratio(c->ldl, a);
    if (!(ratio > 1e-13))
        return sp_fail(err, SP_EREFUSED,
                       "the matrix is singular (a pivot is %.2g of its diagonal entry, must be above 1e-13)", ratio);
    return SP_OK;
}

sp_status sp_cholesky_make(const sp_sparse *a, sp_cholesky **out, sp_error *err) {
    sp_cholesky *c = NULL;
    sp_status status = sp_cholesky_analyze(a, &c, err);
    if (status == SP_OK)
        status = sp_cholesky_factorize(c, a, err);
    if (status == SP_OK)
        *out = c;
    else
        sp_cholesky_free(c);
    return status;
}

void sp_cholesky_solve(sp_cholesky *c, int columns, const double *b, double *x) {
    for (int q = 0; q < columns; q++)
        sp_ldl_solve_one(c->ldl, b + q * c->n, x + q * c->n);
}

void sp_cholesky_free(sp_cholesky *c) {
    if (!c)
        return;
    sp_ldl_free(c->ldl);
    sp_free(c);
}
