#include "linalg/complex.h"
#include "base/base.h"

#include <umfpack.h>

struct sp_complex_solver {
    const SuiteSparse_long *p, *i;
    void *symbolic, *numeric;
    double control[UMFPACK_CONTROL];
};

_Static_assert(sizeof(SuiteSparse_long) == sizeof(int64_t), "UMFPACK's long indices have 64 bits");

static sp_status failed(SuiteSparse_long status, const char *what, sp_error *err) {
    if (status == UMFPACK_ERROR_out_of_memory)
        return sp_fail(err, SP_ENOMEM, "UMFPACK: no memory for the %s", what);
    if (status == UMFPACK_WARNING_singular_matrix)
        return sp_fail(err, SP_EREFUSED, "the matrix is singular");
    return sp_fail(err, SP_EFAILED, "UMFPACK: %s failed (status %lld)", what, (long long)status);
}

sp_status sp_complex_make(int64_t n, const int64_t *p, const int64_t *i, sp_complex_solver **out, sp_error *err) {
    sp_complex_solver *s = sp_alloc(1, sizeof *s);
    if (!s)
        return sp_fail_memory(err, sizeof *s);
    umfpack_zl_defaults(s->control);
    s->control[UMFPACK_PRL] = 0;
    s->control[UMFPACK_STRATEGY] = UMFPACK_STRATEGY_SYMMETRIC;
    s->p = (const SuiteSparse_long *)p;
    s->i = (const SuiteSparse_long *)i;
    const SuiteSparse_long status = umfpack_zl_symbolic(n, n, s->p, s->i, NULL, NULL, &s->symbolic, s->control, NULL);
    if (status == UMFPACK_OK) {
        *out = s;
        return SP_OK;
    }
    sp_complex_free(s);
    return failed(status, "ordering", err);
}

sp_status sp_complex_factor(sp_complex_solver *s, const double *x, sp_error *err) {
    umfpack_zl_free_numeric(&s->numeric);
    const SuiteSparse_long status = umfpack_zl_numeric(s->p, s->i, x, NULL, s->symbolic, &s->numeric, s->control, NULL);
    return status == UMFPACK_OK ? SP_OK : failed(status, "factorization", err);
}

sp_status sp_complex_solve(sp_complex_solver *s, const double *x, const double *b, double *v, sp_error *err) {
    const SuiteSparse_long status =
        umfpack_zl_solve(UMFPACK_A, s->p, s->i, x, NULL, v, NULL, b, NULL, s->numeric, s->control, NULL);
    return status == UMFPACK_OK ? SP_OK : failed(status, "solution", err);
}

void sp_complex_free(sp_complex_solver *s) {
    if (!s)
        return;
    umfpack_zl_free_numeric(&s->numeric);
    umfpack_zl_free_symbolic(&s->symbolic);
    sp_free(s);
}
