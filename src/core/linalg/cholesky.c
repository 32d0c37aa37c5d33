/* Sparse Cholesky factorization with CHOLMOD. */
#include "linalg/cholesky.h"
#include "base/base.h"

#include <cholmod.h>
#include <stdbool.h>
#include <string.h>

struct sp_cholesky {
    cholmod_common common;
    cholmod_factor *factor;
};

/* CHOLMOD takes no constant matrix, so this makes a copy. stype -1: lower triangle. */
static cholmod_sparse *copy_matrix(const sp_sparse *a, cholmod_common *common) {
    const size_t n = (size_t)a->n, entries = (size_t)a->p[a->n];
    cholmod_sparse *m = cholmod_l_allocate_sparse(n, n, entries, 1, 1, -1, CHOLMOD_REAL, common);
    if (!m)
        return NULL;
    SuiteSparse_long *p = m->p, *i = m->i;
    for (size_t k = 0; k <= n; k++)
        p[k] = a->p[k];
    for (size_t k = 0; k < entries; k++)
        i[k] = a->i[k];
    memcpy(m->x, a->x, entries * sizeof(double));
    return m;
}

/* Reads the status of the last call, which the next call clears. */
static sp_status check_call(const sp_cholesky *c, sp_error *err) {
    const int state = c->common.status;
    if (state == CHOLMOD_OUT_OF_MEMORY)
        return sp_fail(err, SP_ENOMEM, "CHOLMOD: no memory for the factor");
    if (!c->factor || (state != CHOLMOD_OK && state != CHOLMOD_NOT_POSDEF))
        return sp_fail(err, SP_EFAILED, "CHOLMOD: factorization failed (status %d)", state);
    return SP_OK;
}

sp_status sp_cholesky_analyze(const sp_sparse *a, sp_cholesky **out, sp_error *err) {
    sp_cholesky *c = sp_alloc(1, sizeof *c);
    if (!c)
        return sp_fail_memory(err, sizeof *c);
    sp_status status = SP_OK;
    cholmod_l_start(&c->common);
    c->common.print = 0;
    c->common.final_ll = 1;  /* LL': an LDL' would accept an indefinite matrix silently */
    c->common.try_catch = 1; /* CHOLMOD returns errors as a status and prints nothing */
    cholmod_sparse *m = copy_matrix(a, &c->common);
    if (!m) {
        status = sp_fail_memory(err, 16 * (size_t)a->p[a->n]);
    } else {
        c->factor = cholmod_l_analyze(m, &c->common);
        status = check_call(c, err);
    }
    cholmod_l_free_sparse(&m, &c->common);
    if (status == SP_OK)
        *out = c;
    else
        sp_cholesky_free(c);
    return status;
}

/* The square of entry c of the diagonal of L: a pivot. */
static double pivot_of(const cholmod_factor *l, SuiteSparse_long c, SuiteSparse_long supernode) {
    const double *x = l->x;
    if (!l->is_super) {
        const SuiteSparse_long *p = l->p;
        return x[p[c]] * x[p[c]];
    }
    const SuiteSparse_long *first = l->super, *rows = l->pi, *at = l->px;
    const SuiteSparse_long height = rows[supernode + 1] - rows[supernode], k = c - first[supernode];
    const double d = x[at[supernode] + k * (height + 1)];
    return d * d;
}

/* The smallest ratio of a pivot to the entry of A's diagonal that elimination made it from: how much was cancelled. It
 * does not change if rows and columns of A are scaled, so that soft grains among stiff ones do not look singular. */
static double least_ratio(const cholmod_factor *l, const cholmod_sparse *a) {
    const SuiteSparse_long *p = a->p, *order = l->Perm, *first = l->super;
    const double *x = a->x;
    double least = 1;
    for (SuiteSparse_long c = 0, supernode = 0; c < (SuiteSparse_long)l->n; c++) {
        if (l->is_super && c == first[supernode + 1])
            supernode++;
        const double ratio = pivot_of(l, c, supernode) / x[p[order[c]]];
        least = ratio >= least ? least : ratio; /* keeps a NAN */
    }
    return least;
}

/* A factorization that fails returns TRUE. A singular matrix may pass with a pivot that is pure rounding error, hence
 * the bound on the ratio of pivots. */
sp_status sp_cholesky_factorize(sp_cholesky *c, const sp_sparse *a, sp_error *err) {
    cholmod_common *common = &c->common;
    cholmod_sparse *m = copy_matrix(a, common);
    if (!m)
        return sp_fail_memory(err, 16 * (size_t)a->p[a->n]);
    cholmod_l_factorize(m, c->factor, common);
    const bool indefinite = common->status == CHOLMOD_NOT_POSDEF || c->factor->minor != c->factor->n;
    sp_status status = check_call(c, err);
    if (status == SP_OK && indefinite)
        status = sp_fail(err, SP_EREFUSED, "the matrix is not positive definite (pivot %lld of %lld)",
                         (long long)c->factor->minor, (long long)c->factor->n);
    const double ratio = status == SP_OK ? least_ratio(c->factor, m) : 1;
    if (!(ratio > 1e-13))
        status = sp_fail(err, SP_EREFUSED,
                         "the matrix is singular (a pivot is %.2g of its diagonal entry, must be above 1e-13)", ratio);
    cholmod_l_free_sparse(&m, common);
    return status;
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

sp_status sp_cholesky_solve(sp_cholesky *c, int columns, const double *b, double *x, sp_error *err) {
    const size_t n = c->factor->n, size = n * (size_t)columns;
    cholmod_dense *right = cholmod_l_allocate_dense(n, (size_t)columns, n, CHOLMOD_REAL, &c->common);
    cholmod_dense *solution = NULL;
    if (right) {
        memcpy(right->x, b, size * sizeof *b);
        solution = cholmod_l_solve(CHOLMOD_A, c->factor, right, &c->common);
    }
    if (solution)
        memcpy(x, solution->x, size * sizeof *x);
    sp_status status = solution ? SP_OK : sp_fail_memory(err, size * sizeof *x);
    cholmod_l_free_dense(&solution, &c->common);
    cholmod_l_free_dense(&right, &c->common);
    return status;
}

void sp_cholesky_free(sp_cholesky *c) {
    if (!c)
        return;
    cholmod_l_free_factor(&c->factor, &c->common);
    cholmod_l_finish(&c->common);
    sp_free(c);
}
