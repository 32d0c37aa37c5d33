/* LU factorisation of sparse matrices: the only file that calls UMFPACK. */
#include "linalg/lu.h"
#include "base/base.h"

#include <umfpack.h>

struct sp_lu {
    const SuiteSparse_long *p, *i;
    void *symbolic, *numeric;
    double control[UMFPACK_CONTROL];
};

_Static_assert(sizeof(SuiteSparse_long) == sizeof(int64_t), "UMFPACK's long indices have 64 bits");

static sp_status check_call(SuiteSparse_long status, const char *what, sp_error *err) {
    if (status == UMFPACK_OK)
        return SP_OK;
    if (status == UMFPACK_ERROR_out_of_memory)
        return sp_fail(err, SP_ENOMEM, "UMFPACK: no memory for the %s", what);
    if (status == UMFPACK_WARNING_singular_matrix)
        return sp_fail(err, SP_EREFUSED, "the matrix is singular");
    return sp_fail(err, SP_EFAILED, "UMFPACK: %s failed (status %lld)", what, (long long)status);
}

sp_status sp_lu_make(int64_t n, const int64_t *p, const int64_t *i, bool is_complex, sp_lu **out, sp_error *err) {
    if (!is_complex)
        return sp_fail(err, SP_EINVAL, "LU factorisation of a real matrix, must be complex");
    sp_lu *f = sp_alloc(1, sizeof *f);
    if (!f)
        return sp_fail_memory(err, sizeof *f);
    *f = (sp_lu){.p = (const SuiteSparse_long *)p, .i = (const SuiteSparse_long *)i};
    umfpack_zl_defaults(f->control);
    f->control[UMFPACK_PRL] = 0;
    f->control[UMFPACK_STRATEGY] = UMFPACK_STRATEGY_SYMMETRIC;
    const sp_status status =
        check_call(umfpack_zl_symbolic(n, n, f->p, f->i, NULL, NULL, &f->symbolic, f->control, NULL), "ordering", err);
    if (status == SP_OK)
        *out = f;
    else
        sp_lu_free(f);
    return status;
}

sp_status sp_lu_factor(sp_lu *f, const double *x, sp_error *err) {
    umfpack_zl_free_numeric(&f->numeric);
    return check_call(umfpack_zl_numeric(f->p, f->i, x, NULL, f->symbolic, &f->numeric, f->control, NULL),
                      "factorization", err);
}

sp_status sp_lu_solve(const sp_lu *f, const double *x, bool transposed, const double *b, double *v, sp_error *err) {
    return check_call(umfpack_zl_solve(transposed ? UMFPACK_Aat : UMFPACK_A, f->p, f->i, x, NULL, v, NULL, b, NULL,
                                       f->numeric, f->control, NULL),
                      "solution", err);
}

void sp_lu_free(sp_lu *f) {
    if (!f)
        return;
    umfpack_zl_free_numeric(&f->numeric);
    umfpack_zl_free_symbolic(&f->symbolic);
    sp_free(f);
}
