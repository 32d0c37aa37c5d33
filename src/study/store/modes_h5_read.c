/* Reads files of modes. */
#include "store/modes_h5.h"

#include "base/base.h"

#include <math.h>
#include <string.h>

sp_modes_file sp_modes_file_none(void) { return (sp_modes_file){.modes = sp_modes_none()}; }

void sp_modes_file_free(sp_modes_file *f) {
    sp_modes_free(&f->modes);
    sp_free(f->grain);
    sp_free(f->mass);
    *f = sp_modes_file_none();
}

/* The index of a stored word. */
static sp_status get_word(sp_h5 *h, const char *path, int count, const char *const *words, int *out, sp_error *err) {
    char *text = NULL;
    sp_status status = sp_h5_get_text(h, path, &text, err);
    if (status != SP_OK)
        return status;
    for (*out = 0; *out < count && strcmp(text, words[*out]) != 0;)
        ++*out;
    if (*out == count)
        status = sp_h5_fail(h, err, SP_EFORMAT, "%s is '%.60s'", path, text);
    sp_free(text);
    return status;
}

static sp_status check_packing(sp_h5 *h, const sp_modes_file *f, const sp_packing *p, sp_error *err) {
    if (f->packing != sp_packing_hash(p))
        return sp_h5_fail(h, err, SP_EFORMAT, "the modes are of another packing: %s is %016llx; must be %016llx",
                          sp_modes_name_packing.path, (unsigned long long)f->packing,
                          (unsigned long long)sp_packing_hash(p));
    if (f->dim != p->dim)
        return sp_h5_fail(h, err, SP_EFORMAT, "/modes/dimension is %d; must be %d", f->dim, p->dim);
    return SP_OK;
}

static sp_status get_head(sp_h5 *h, const sp_packing *p, sp_modes_file *f, sp_error *err) {
    const sp_h5_shape single = {0};
    sp_modes_numbers numbers = {0};
    int64_t format;
    int source = 0, solver = 0;
    if (!sp_h5_has(h, "/modes"))
        return sp_h5_fail(h, err, SP_EFORMAT, "no group /modes: not a file of `sonopack modes --vectors'");
    sp_status status = sp_h5_attribute_int(h, "/modes", "format", &format, err);
    if (status == SP_OK && format != SP_MODES_FORMAT)
        status = sp_h5_fail(h, err, SP_EFORMAT, "format %lld of /modes; this version reads format %d",
                            (long long)format, SP_MODES_FORMAT);
    if (status == SP_OK)
        status = sp_h5_get(h, sp_modes_name_packing.path, SP_H5_U64, &single, &f->packing, err);
    if (status == SP_OK)
        status = sp_h5_get_fields(h, sp_modes_field_count, sp_modes_fields, &f->modes, err);
    if (status == SP_OK)
        status = sp_h5_get_fields(h, sp_modes_network_field_count, sp_modes_network_fields, &numbers, err);
    if (status == SP_OK)
        status = get_word(h, sp_modes_name_source.path, 3, sp_modes_sources, &source, err);
    if (status == SP_OK)
        status = get_word(h, sp_modes_name_solver.path, 4, sp_modes_solvers, &solver, err);
    if (status != SP_OK)
        return status;
    f->dim = numbers.dim;
    f->dof = numbers.dof;
    f->modes.solver = (sp_modes_solver)solver;
    f->made.source = (sp_source)source;
    f->made.network = (sp_network_options){
        .threshold = numbers.threshold, .prestress = numbers.prestress != 0, .sliding_free = numbers.sliding_free != 0};
    return check_packing(h, f, p, err);
}

/* The numbers of modes, grains and columns must agree before memory is taken. */
static sp_status get_sizes(sp_h5 *h, const sp_packing *p, sp_modes_file *f, sp_error *err) {
    sp_modes *m = &f->modes;
    sp_h5_shape modes, grains, vectors;
    sp_status status = sp_h5_find(h, sp_modes_arrays[0].name.path, SP_H5_F64, 1, &modes, err);
    if (status == SP_OK)
        status = sp_h5_find(h, sp_modes_name_grain.path, SP_H5_I32, 1, &grains, err);
    if (status == SP_OK)
        status = sp_h5_find(h, sp_modes_name_vector.path, SP_H5_F64, 2, &vectors, err);
    if (status != SP_OK)
        return status;
    m->n = modes.dim[0];
    f->n = (int32_t)grains.dim[0];
    m->dofs = vectors.dim[1];
    const bool turns = f->dof == (f->dim == 1 ? 1 : f->dim == 2 ? 3 : 6), slides = f->dof == f->dim;
    if ((!turns && !slides) || f->n < 1 || f->n > p->n || m->dofs != (int64_t)f->n * f->dof)
        return sp_h5_fail(h, err, SP_EFORMAT, "%d grains of %d with %d degrees of freedom, and %lld columns of vector",
                          f->n, p->n, f->dof, (long long)m->dofs);
    const sp_zero_modes *z = &m->zero;
    const bool counted = z->rattlers >= 0 && z->spins >= 0 && z->rigid >= 0 && z->mechanisms >= 0 && z->below >= 0 &&
                         z->total == z->rattlers + z->spins + z->rigid + z->mechanisms;
    if (!counted || m->n_zero > z->total || m->first > (int64_t)p->n * f->dof - m->n)
        return sp_h5_fail(h, err, SP_EFORMAT,
                          "%lld modes from number %lld on, of %d grains, and %lld zero modes: a count is wrong",
                          (long long)m->n, (long long)m->first, p->n, (long long)z->total);
    if (m->n_rattler < 0 || m->n_rattler > m->n_zero || m->n_zero > m->n || m->first < 0 || m->on_edge < 0 ||
        vectors.dim[0] != m->n - m->n_rattler)
        return sp_h5_fail(h, err, SP_EFORMAT,
                          "%lld modes, %lld of them of rattlers, %lld zero modes, and %lld rows of vector",
                          (long long)m->n, (long long)m->n_rattler, (long long)m->n_zero, (long long)vectors.dim[0]);
    return SP_OK;
}

static sp_status get_arrays(sp_h5 *h, sp_modes_file *f, sp_error *err) {
    sp_modes *m = &f->modes;
    const sp_h5_shape modes = {1, {m->n}}, grains = {1, {f->n}}, columns = {1, {m->dofs}};
    double *block = sp_alloc(SP_MODES_ARRAYS * (size_t)m->n, sizeof *block);
    f->grain = sp_alloc((size_t)f->n, sizeof *f->grain);
    f->mass = sp_alloc((size_t)m->dofs, sizeof *f->mass);
    m->omega = block; /* sp_modes_free frees the block */
    if (!block || !f->grain || !f->mass)
        return sp_fail_memory(err, (SP_MODES_ARRAYS * (size_t)m->n + (size_t)m->dofs) * sizeof *block);
    sp_status status = SP_OK;
    for (int k = 0; k < SP_MODES_ARRAYS && status == SP_OK; k++) {
        double *to = *sp_modes_array_at(&sp_modes_arrays[k], m) = block + k * m->n;
        status = sp_h5_get(h, sp_modes_arrays[k].name.path, SP_H5_F64, &modes, to, err);
    }
    if (status == SP_OK)
        status = sp_h5_get(h, sp_modes_name_grain.path, SP_H5_I32, &grains, f->grain, err);
    if (status == SP_OK)
        status = sp_h5_get(h, sp_modes_name_mass.path, SP_H5_F64, &columns, f->mass, err);
    return status;
}

/* Whether all numbers are finite, or (amplitudes without a wall) none is. */
static bool all_or_none(int64_t n, const double *x) {
    int64_t finite = 0, missing = 0;
    for (int64_t k = 0; k < n; k++) {
        finite += isfinite(x[k]) != 0;
        missing += isnan(x[k]) != 0;
    }
    return finite == n || missing == n;
}

static sp_status check_modes(sp_h5 *h, const sp_modes *m, sp_error *err) {
    for (int64_t k = 0; k < m->n; k++) {
        const double omega = m->omega[k], error = m->error[k], part = m->participation[k];
        if (!(omega >= (k > 0 ? m->omega[k - 1] : 0) && isfinite(omega)) || (omega > 0) != (k >= m->n_zero))
            return sp_h5_fail(h, err, SP_EFORMAT, "omega[%lld] is %g; must be finite, ascending, and 0 for zero modes",
                              (long long)k, omega);
        if (!(error >= 0 && isfinite(error)) || !(part > 0 && part <= 1 + 1e-9))
            return sp_h5_fail(h, err, SP_EFORMAT, "error[%lld] is %g and participation %g", (long long)k, error, part);
    }
    if (!all_or_none(m->n, m->a) || !all_or_none(m->n, m->b))
        return sp_h5_fail(h, err, SP_EFORMAT, "an amplitude a or b is not finite");
    const bool measured = m->residual >= 0 && m->orthogonality >= 0;
    if (!(m->certified_from >= 0 && m->certified_from <= m->certified_to) || (m->n > m->n_rattler && !measured))
        return sp_h5_fail(h, err, SP_EFORMAT, "certified %g to %g, residual %g, orthogonality %g", m->certified_from,
                          m->certified_to, m->residual, m->orthogonality);
    return SP_OK;
}

static sp_status check_columns(sp_h5 *h, const sp_modes_file *f, const sp_packing *p, sp_error *err) {
    for (int32_t k = 0; k < f->n; k++)
        if (f->grain[k] < (k > 0 ? f->grain[k - 1] + 1 : 0) || f->grain[k] >= p->n)
            return sp_h5_fail(h, err, SP_EFORMAT, "%s[%d] is %d; must ascend within 0..%d", sp_modes_name_grain.path, k,
                              f->grain[k], p->n - 1);
    for (int64_t k = 0; k < f->modes.dofs; k++)
        if (!(f->mass[k] > 0 && isfinite(f->mass[k])))
            return sp_h5_fail(h, err, SP_EFORMAT, "%s[%lld] is %g; must be positive", sp_modes_name_mass.path,
                              (long long)k, f->mass[k]);
    return SP_OK;
}

bool sp_modes_file_looks(const char *path) {
    sp_h5 h;
    sp_error reason = {0};
    const bool opened = sp_h5_open(&h, path, &reason) == SP_OK, looks = opened && sp_h5_has(&h, "/modes");
    sp_h5_close(&h);
    return looks;
}

sp_status sp_modes_file_read(const char *path, const sp_packing *p, sp_modes_file *out, sp_error *err) {
    sp_modes_file f = sp_modes_file_none();
    sp_h5 h;
    sp_status status = sp_h5_open(&h, path, err);
    if (status == SP_OK)
        status = get_head(&h, p, &f, err);
    if (status == SP_OK)
        status = get_sizes(&h, p, &f, err);
    if (status == SP_OK)
        status = get_arrays(&h, &f, err);
    if (status == SP_OK)
        status = check_modes(&h, &f.modes, err);
    if (status == SP_OK)
        status = check_columns(&h, &f, p, err);
    sp_h5_close(&h);
    if (status == SP_OK)
        *out = f;
    else
        sp_modes_file_free(&f);
    return status;
}

/* A damaged vector is nearly never a unit vector. */
static sp_status check_unit(const char *path, const sp_modes_file *f, int64_t row, int64_t count, const double *e,
                            sp_error *err) {
    for (int64_t k = 0; k < count; k++) {
        double sum = 0;
        for (int64_t c = 0; c < f->modes.dofs; c++)
            sum += e[k * f->modes.dofs + c] * e[k * f->modes.dofs + c];
        if (!(fabs(sum - 1) <= 1e-6))
            return sp_fail(err, SP_EFORMAT, "%s: the vector of mode %lld has the length %.6g; must be 1", path,
                           (long long)(f->modes.first + row + k), sqrt(sum));
    }
    return SP_OK;
}

sp_status sp_modes_file_vectors(const char *path, const sp_modes_file *f, int64_t row, int64_t count, double *out,
                                sp_error *err) {
    const sp_modes *m = &f->modes;
    const sp_h5_shape whole = {2, {m->n - m->n_rattler, m->dofs}};
    if (row < m->n_rattler || count < 0 || row > m->n - count)
        return sp_fail(err, SP_EINVAL, "%s: vectors of rows %lld .. %lld, must be within %lld .. %lld", path,
                       (long long)row, (long long)(row + count - 1), (long long)m->n_rattler, (long long)m->n - 1);
    sp_h5 h;
    sp_status status = sp_h5_open(&h, path, err);
    if (status == SP_OK)
        status = sp_h5_get_rows(&h, sp_modes_name_vector.path, SP_H5_F64, &whole, row - m->n_rattler, count, out, err);
    sp_h5_close(&h);
    return status == SP_OK ? check_unit(path, f, row, count, out, err) : status;
}
