/* LU factorisation of sparse matrices: the only file that calls UMFPACK. */
#include "linalg/lu.h"
#include "base/base.h"

#include <umfpack.h>

struct sp_lu {
    bool is_complex;
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

static void free_numeric(sp_lu *f) {
    if (f->is_complex)
        umfpack_zl_free_numeric(&f->numeric);
    else
        umfpack_dl_free_numeric(&f->numeric);
}

sp_status sp_lu_make(int64_t n, const int64_t *p, const int64_t *i, bool is_complex, sp_lu **out, sp_error *err) {
    sp_lu *f = sp_alloc(1, sizeof *f);
    if (!f)
        return sp_fail_memory(err, sizeof *f);
    *f = (sp_lu){.is_complex = is_complex, .p = (const SuiteSparse_long *)p, .i = (const SuiteSparse_long *)i};
    if (is_complex)
        umfpack_zl_defaults(f->control);
    else
        umfpack_dl_defaults(f->control);
    f->control[UMFPACK_PRL] = 0;
    f->control[UMFPACK_STRATEGY] = UMFPACK_STRATEGY_SYMMETRIC;
    const SuiteSparse_long called =
        is_complex ? umfpack_zl_symbolic(n, n, f->p, f->i, NULL, NULL, &f->symbolic, f->control, NULL)
                   : umfpack_dl_symbolic(n, n, f->p, f->i, NULL, &f->symbolic, f->control, NULL);
    const sp_status status = check_call(called, "ordering", err);
    if (status == SP_OK)
        *out = f;
    else
        sp_lu_free(f);
    return status;
}

sp_status sp_lu_factor(sp_lu *f, const double *x, sp_error *err) {
    free_numeric(f);
    return check_call(f->is_complex
                          ? umfpack_zl_numeric(f->p, f->i, x, NULL, f->symbolic, &f->numeric, f->control, NULL)
                          : umfpack_dl_numeric(f->p, f->i, x, f->symbolic, &f->numeric, f->control, NULL),
                      "factorization", err);
}

sp_status sp_lu_solve(const sp_lu *f, const double *x, bool transposed, const double *b, double *v, sp_error *err) {
    const int system = transposed ? UMFPACK_At : UMFPACK_A;
    return check_call(
        f->is_complex ? umfpack_zl_solve(system, f->p, f->i, x, NULL, v, NULL, b, NULL, f->numeric, f->control, NULL)
                      : umfpack_dl_solve(system, f->p, f->i, x, v, b, f->numeric, f->control, NULL),
        "solution", err);
}

void sp_lu_free(sp_lu *f) {
    if (!f)
        return;
    free_numeric(f);
    if (f->is_complex)
        umfpack_zl_free_symbolic(&f->symbolic);
    else
        umfpack_dl_free_symbolic(&f->symbolic);
    sp_free(f);
}
