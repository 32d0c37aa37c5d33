/* Computes all modes with LAPACK and refines their eigenvalues. */
#include "base/base.h"
#include "linalg/eigen.h"
#include "modes/mode_table.h"
#include "modes/refine.h"
#include "modes/slices.h"

#include <math.h>

/* The lower triangle of A = M^-1/2 K M^-1/2, by columns. */
static sp_status dense_matrix(const sp_network *net, double **out, sp_error *err) {
    sp_sparse k = {0};
    const size_t n = (size_t)sp_network_dofs(net);
    double *a = NULL;
    sp_status status = sp_network_assemble(net, &k, err);
    if (status != SP_OK)
        return status;
    a = sp_alloc(n * n, sizeof *a);
    if (!a)
        status = sp_fail_memory(err, n * n * sizeof *a);
    for (int64_t c = 0; a && c < k.n; c++)
        for (int64_t q = k.p[c]; q < k.p[c + 1]; q++)
            a[(size_t)c * n + (size_t)k.i[q]] = k.x[q] / sqrt(net->mass[c] * net->mass[k.i[q]]);
    sp_sparse_free(&k);
    *out = a;
    return status;
}

/* Refines eigenvalues whose vectors LAPACK found, softest first; `above`: the next eigenvalue. */
static sp_status refine(const sp_network *net, int64_t count, double *vectors, const double *values, double above,
                        sp_ritz *ritz, sp_error *err) {
    const double blur = sp_lapack_error(net);
    const int64_t soft = sp_zeros_near(count, values, blur, above);
    const sp_refine_set set = {.count = count,
                               .vectors = vectors,
                               .values = values,
                               .blur = 2 * blur,
                               .soft = soft,
                               .below = -HUGE_VAL,
                               .above = above};
    sp_status status = sp_zeros_part(net, soft, vectors, err);
    return status == SP_OK ? sp_modes_refine(net, &set, ritz, err) : status;
}

/* Number of soft modes: those whose omega has a relative error above `allowed` by LAPACK's eigenvalues alone. */
static int64_t soft_modes(int64_t n, const double *values, double blur, double allowed) {
    int64_t count = 0;
    while (count < n && blur > values[count] * 2 * allowed)
        count++;
    return count;
}

/* Frequencies only, in one reduction to tridiagonal form that also gives the eigenvectors of the soft modes. */
static sp_status by_tridiagonal(const sp_network *net, double *a, sp_ritz *ritz, sp_error *err) {
    const int64_t n = sp_network_dofs(net);
    const double blur = sp_lapack_error(net);
    sp_tridiagonal t = {0};
    double *values = sp_alloc((size_t)n, sizeof *values), *vectors = NULL;
    int64_t count = 0;
    sp_status status = values ? sp_tridiagonal_make(n, a, &t, err) : sp_fail_memory(err, (size_t)n * sizeof *values);
    if (status == SP_OK)
        status = sp_tridiagonal_values(&t, values, err);
    if (status != SP_OK)
        goto out;
    for (int64_t k = 0; k < n; k++)
        ritz[k] = (sp_ritz){.lambda = values[k], .error = blur, .residual = NAN, .rounding = blur};
    count = soft_modes(n, values, blur, 5e-14);
    while (count > 0 && count < n && values[count] - values[count - 1] <= 8 * blur)
        count++; /* never split a cluster */
    if (count == 0)
        goto out;
    vectors = sp_alloc((size_t)(count * n), sizeof *vectors);
    if (!vectors) {
        status = sp_fail_memory(err, (size_t)(count * n) * sizeof *vectors);
        goto out;
    }
    status = sp_tridiagonal_vectors(&t, count, vectors, err);
    if (status == SP_OK)
        status = refine(net, count, vectors, values, count < n ? values[count] : HUGE_VAL, ritz, err);
out:
    sp_free(vectors);
    sp_free(values);
    sp_tridiagonal_free(&t);
    return status;
}

/* Replaces the `count` lowest eigenvalues by those of the sparse solver, which are as accurate as their own size
 * allows. SP_EREFUSED if it does not find the same modes. */
static sp_status soften(const sp_network *net, int64_t count, sp_ritz *ritz, sp_error *err) {
    slicer z = {0};
    slice_edge end = {0};
    sp_status status = sp_slicer_make(net, false, &z, err);
    if (status != SP_OK)
        return status;
    z.solver = SP_SOLVER_LANCZOS;
    z.null_rows = true;
    const int64_t known = z.null.spins + z.null.rigid;
    status = sp_slicer_softest(&z, count > known ? count - known : 1, &end, err);
    for (int64_t k = 0; status == SP_OK && k < count; k++) {
        const double apart = fabs(z.ritz[k].lambda - ritz[k].lambda);
        if (!(apart <= z.ritz[k].error + ritz[k].error))
            status = sp_fail(err, SP_EREFUSED, "two solvers differ by %.3g in omega^2 = %.6g", apart, ritz[k].lambda);
        else if (z.ritz[k].error < ritz[k].error)
            ritz[k] = z.ritz[k];
    }
    sp_slicer_free(&z);
    return status;
}

/* Frequencies only: all by LAPACK, the soft modes again by the sparse solver. *done stays false if there are too many
 * of these, or if the sparse solver refuses: it does where pivots vanish, as in perfect lattices. */
static sp_status in_two_stages(const sp_network *net, double *a, sp_ritz *ritz, bool *done, sp_error *err) {
    enum { FEW = 4 }; /* a quarter of the modes takes the sparse solver as long as LAPACK takes for all */
    const int64_t n = sp_network_dofs(net);
    const double blur = sp_lapack_error(net);
    double *values = sp_alloc((size_t)n, sizeof *values);
    sp_status status = values ? sp_eigen_values(n, a, values, err) : sp_fail_memory(err, (size_t)n * sizeof *values);
    if (status != SP_OK)
        goto out;
    for (int64_t k = 0; k < n; k++)
        ritz[k] = (sp_ritz){.lambda = values[k], .error = blur, .residual = NAN, .rounding = blur};
    const int64_t count = soft_modes(n, values, blur, 1e-12);
    sp_error reason = {0};
    if (count > 0)
        status = count <= n / FEW ? soften(net, count, ritz, &reason) : SP_EREFUSED;
    *done = status == SP_OK;
    if (status == SP_EREFUSED)
        status = SP_OK;
    else if (status != SP_OK)
        sp_fail(err, status, "%s", reason.text);
out:
    sp_free(values);
    return status;
}

/* Frequencies only. Destroys *a. */
static sp_status frequencies(const sp_network *net, double **a, sp_ritz *ritz, sp_error *err) {
    enum { SMALL = 400 }; /* degrees of freedom up to which one reduction is as fast */
    bool done = false;
    if (sp_network_dofs(net) > SMALL) {
        sp_status status = in_two_stages(net, *a, ritz, &done, err);
        if (status != SP_OK || done)
            return status;
        sp_free(*a);
        *a = NULL;
        status = dense_matrix(net, a, err);
        if (status != SP_OK)
            return status;
    }
    return by_tridiagonal(net, *a, ritz, err);
}

/* All eigenvectors and refined eigenvalues. Overwrites a with the vectors, in LAPACK's order. */
static sp_status with_vectors(const sp_network *net, double *a, sp_ritz *ritz, sp_error *err) {
    const int64_t n = sp_network_dofs(net);
    double *values = sp_alloc((size_t)n, sizeof *values);
    sp_status status = values ? sp_eigen_all(n, a, values, err) : sp_fail_memory(err, (size_t)n * sizeof *values);
    if (status == SP_OK)
        status = refine(net, n, a, values, HUGE_VAL, ritz, err);
    sp_free(values);
    return status;
}

/* Counts the zero modes, of which the null motions are known. */
static sp_status count_zeros(const sp_network *net, const sp_ritz *ritz, sp_mode_pairs *set, sp_error *err) {
    sp_null_motions known = {0};
    sp_status status = sp_null_motions_make(net, &known, err);
    if (status == SP_OK)
        status = sp_zeros_count(net, set->count, ritz, known.spins + known.rigid, &set->zeros, err);
    if (status == SP_OK && set->zeros < known.spins + known.rigid)
        status = sp_fail(err, SP_EREFUSED, "%lld zero modes found, must be at least %lld: eigenvalues are too inexact",
                         (long long)set->zeros, (long long)(known.spins + known.rigid));
    if (status == SP_OK)
        set->zero = sp_zeros_sum(net, &known, set->zeros - known.spins - known.rigid);
    sp_null_motions_free(&known);
    return status;
}

/* The matrix, and what LAPACK needs beside it: as core/cost foretells. */
static sp_status check_memory(int64_t n, bool vectors, sp_error *err) {
    const double need = (vectors ? 24.0 : 12.0) * (double)n * (double)n, have = 0.8 * sp_memory_limit();
    if (need <= have)
        return SP_OK;
    return sp_fail(err, SP_ENOMEM, "all modes of %lld degrees of freedom need %.3g GB of memory, at most %.3g GB here",
                   (long long)n, 1e-9 * need, 1e-9 * have);
}

sp_status sp_modes_dense(const sp_network *net, const sp_modes_options *opt, sp_modes *out, sp_error *err) {
    double *a = NULL;
    sp_ritz *ritz = NULL;
    const int64_t n = sp_network_dofs(net);
    if (n > SP_MODES_DENSE_MAX)
        return sp_fail(err, SP_EREFUSED, "%lld degrees of freedom, must be at most %d for the dense solver",
                       (long long)n, SP_MODES_DENSE_MAX);
    sp_status status = sp_network_need_symmetry(net, "a table of modes", err);
    if (status == SP_OK)
        status = check_memory(n, opt->vectors, err);
    if (status == SP_OK)
        status = dense_matrix(net, &a, err);
    if (status != SP_OK)
        goto out;
    ritz = sp_alloc((size_t)n, sizeof *ritz);
    status = ritz ? SP_OK : sp_fail_memory(err, (size_t)n * sizeof *ritz);
    if (status == SP_OK)
        status = opt->vectors ? with_vectors(net, a, ritz, err) : frequencies(net, &a, ritz, err);
    if (status == SP_OK) {
        sp_mode_pairs set = {.count = n,
                             .ritz = ritz,
                             .vectors = opt->vectors ? &a : NULL,
                             .rattlers = (int64_t)net->rattlers * net->dof};
        status = count_zeros(net, ritz, &set, err);
        if (status == SP_OK)
            status = sp_modes_tabulate(net, opt->source, &set, out, err);
    }
    if (status == SP_OK) {
        out->solver = SP_SOLVER_DENSE;
        out->certified_to = HUGE_VAL;
    }
out:
    sp_free(ritz);
    sp_free(a);
    return status;
}
