#include "linalg/lu.h"
#include "base/base.h"

#include <umfpack.h>

struct sp_lu {
    void *symbolic, *numeric;
    double control[UMFPACK_CONTROL];
};

_Static_assert(sizeof(SuiteSparse_long) == sizeof(int64_t), "UMFPACK's long indices have 64 bits");

static const SuiteSparse_long *indices(const int64_t *i) { return (const SuiteSparse_long *)i; }

static sp_status failed(SuiteSparse_long status, const char *what, sp_error *err) {
    if (status == UMFPACK_ERROR_out_of_memory)
        return sp_fail(err, SP_ENOMEM, "UMFPACK: no memory for the %s", what);
    if (status == UMFPACK_WARNING_singular_matrix)
        return sp_fail(err, SP_EREFUSED, "the matrix is singular");
    return sp_fail(err, SP_EFAILED, "UMFPACK: %s failed (status %lld)", what, (long long)status);
}

sp_status sp_lu_make(const sp_sparse *a, sp_lu **out, sp_error *err) {
    sp_lu *f = sp_alloc(1, sizeof *f);
    if (!f)
        return sp_fail_memory(err, sizeof *f);
    umfpack_dl_defaults(f->control);
    f->control[UMFPACK_PRL] = 0;
    f->control[UMFPACK_STRATEGY] = UMFPACK_STRATEGY_SYMMETRIC;
    const SuiteSparse_long status =
        umfpack_dl_symbolic(a->n, a->n, indices(a->p), indices(a->i), NULL, &f->symbolic, f->control, NULL);
    if (status == UMFPACK_OK) {
        *out = f;
        return SP_OK;
    }
    sp_lu_free(f);
    return failed(status, "ordering", err);
}

sp_status sp_lu_factor(sp_lu *f, const sp_sparse *a, sp_error *err) {
    umfpack_dl_free_numeric(&f->numeric);
    const SuiteSparse_long status =
        umfpack_dl_numeric(indices(a->p), indices(a->i), a->x, f->symbolic, &f->numeric, f->control, NULL);
    return status == UMFPACK_OK ? SP_OK : failed(status, "factorization", err);
}

sp_status sp_lu_solve(const sp_lu *f, const sp_sparse *a, bool transposed, const double *b, double *x, sp_error *err) {
    const SuiteSparse_long status = umfpack_dl_solve(transposed ? UMFPACK_At : UMFPACK_A, indices(a->p), indices(a->i),
                                                     a->x, x, b, f->numeric, f->control, NULL);
    return status == UMFPACK_OK ? SP_OK : failed(status, "solution", err);
}

void sp_lu_free(sp_lu *f) {
    if (!f)
        return;
    umfpack_dl_free_numeric(&f->numeric);
    umfpack_dl_free_symbolic(&f->symbolic);
    sp_free(f);
}
