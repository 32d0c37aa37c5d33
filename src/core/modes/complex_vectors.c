/* Right and left vectors of motions that may grow, scaled, and how well they solve the eigenproblem. */
#include "modes/complex_vectors.h"
#include "base/base.h"
#include "base/vector.h"
#include "linalg/arrays.h"
#include "linalg/eigen.h"
#include "linalg/two_sided.h"
#include "modes/count.h"

#include <complex.h>
#undef I
#include <math.h>
#include <string.h>

typedef double complex number;

static number number_of(double re, double im) { return re + im * _Complex_I; }

/* x = c (a + i b) with a real b or none. */
static void scale(int64_t n, number c, const double *a, const double *b, double *re, double *im) {
    for (int64_t q = 0; q < n; q++) {
        const number x = c * number_of(a[q], b ? b[q] : 0);
        re[q] = creal(x);
        im[q] = cimag(x);
    }
}

/* 1/c makes a + i b a unit vector whose largest component is positive. */
static number size_of(int64_t n, const double *a, const double *b) {
    double squares = 0, most = 0;
    number turn = 1;
    for (int64_t q = 0; q < n; q++) {
        const double square = a[q] * a[q] + (b ? b[q] * b[q] : 0);
        squares += square;
        if (square > most) {
            most = square;
            turn = number_of(a[q], b ? b[q] : 0);
        }
    }
    return sqrt(squares) * turn / cabs(turn);
}

/* A pair has x + i y with rows x, y of `right`, and (v - i w)/2 with rows v, w of `left`. The row that grows has the
 * conjugates. */
static void fill_row(const sp_vector_pairs *p, int64_t row, sp_complex_modes *m) {
    const int64_t n = m->dofs, k = (int64_t)p->origin[row], at = (row - m->rattlers) * n;
    const bool pair = p->im[k] > 0;
    const double *x = p->right + k * n, *v = p->left + k * n;
    const number c = size_of(n, x, pair ? x + n : NULL);
    scale(n, 1 / c, x, pair ? x + n : NULL, m->right + at, m->right_im + at);
    scale(n, pair ? 0.5 * conj(c) : c, v, pair ? v + n : NULL, m->left + at, m->left_im + at);
    for (int64_t q = at; q < at + n && pair; q++) {
        const bool grows = m->growth[row] > 0;
        m->right_im[q] *= grows ? -1 : 1;
        m->left_im[q] *= grows ? 1 : -1;
    }
}

/* |A x - z x| or |A^T x - z x|. work: [2 n]. */
static double residual_of(const sp_sparse *a, bool left, number z, const double *const x[2], double *work) {
    const int64_t n = a->n;
    double squares = 0;
    for (int part = 0; part < 2; part++)
        sp_sparse_apply(a, left, x[part], work + part * n);
    for (int64_t q = 0; q < n; q++) {
        const number off = number_of(work[q], work[n + q]) - z * number_of(x[0][q], x[1][q]);
        squares += creal(off) * creal(off) + cimag(off) * cimag(off);
    }
    return sqrt(squares);
}

static sp_status find_residual(const sp_network *net, sp_complex_modes *m, sp_error *err) {
    const int64_t n = m->dofs;
    const double top = sp_network_omega_bound(net);
    sp_sparse a = {0};
    double *work = sp_alloc(2 * (size_t)n, sizeof *work);
    sp_status status =
        work ? sp_network_assemble_whole(net, &a, err) : sp_fail_memory(err, 2 * (size_t)n * sizeof *work);
    if (status == SP_OK)
        sp_scale_by_masses(net, &a);
    m->residual = 0;
    for (int64_t row = m->rattlers; row < m->n && status == SP_OK; row++) {
        const int64_t at = (row - m->rattlers) * n;
        const number exponent = number_of(m->growth[row], m->omega[row]), z = -exponent * exponent;
        const double *const right[2] = {m->right + at, m->right_im + at}, *const left[2] = {m->left + at,
                                                                                            m->left_im + at};
        const double size = hypot(sp_norm(n, left[0]), sp_norm(n, left[1]));
        m->residual = fmax(m->residual, residual_of(&a, false, z, right, work) / (top * top));
        m->residual = fmax(m->residual, residual_of(&a, true, z, left, work) / (size * top * top));
    }
    sp_sparse_free(&a);
    sp_free(work);
    return status;
}

enum { BLOCK = 64 };

/* Of `many` right vectors from `first` on with all left ones. product: [4][BLOCK][rows], 0 where there are no pairs. */
static double worst_product(const sp_vector_pairs *p, const sp_complex_modes *m, int64_t first, int64_t many,
                            double *product) {
    const int64_t n = m->dofs, rows = m->n - m->rattlers, size = rows * BLOCK;
    const double *const right[2] = {m->right + first * n, m->right_im + first * n}, *const left[2] = {m->left,
                                                                                                      m->left_im};
    double worst = 0;
    for (int part = 0; part < (m->pairs > 0 ? 4 : 1); part++)
        sp_project(n, rows, left[part / 2], many, right[part % 2], product + part * size);
    for (int64_t c = 0; c < many; c++)
        for (int64_t r = 0; r < rows; r++) {
            const double *at = product + c * rows + r, *origin = p->origin + m->rattlers;
            const bool same = r == first + c || (origin[r] == origin[first + c] && p->im[(int64_t)origin[r]] == 0);
            worst = fmax(worst, hypot(at[0] - at[3 * size] - same, at[size] + at[2 * size]));
        }
    return worst;
}

/* Rows that diverge and decay with one real eigenvalue have the same vectors. */
static sp_status find_orthogonality(const sp_vector_pairs *p, sp_complex_modes *m, sp_error *err) {
    const int64_t rows = m->n - m->rattlers;
    double *product = sp_alloc(4 * BLOCK * (size_t)rows, sizeof *product);
    if (!product)
        return sp_fail_memory(err, 4 * BLOCK * (size_t)rows * sizeof *product);
    m->orthogonality = 0;
    for (int64_t first = 0; first < rows; first += BLOCK)
        m->orthogonality =
            fmax(m->orthogonality, worst_product(p, m, first, rows - first < BLOCK ? rows - first : BLOCK, product));
    sp_free(product);
    return SP_OK;
}

sp_status sp_complex_vectors_make(const sp_network *net, const sp_vector_pairs *p, sp_complex_modes *m, sp_error *err) {
    const size_t size = (size_t)(m->n - m->rattlers) * (size_t)m->dofs;
    const sp_array arrays[] = {{&m->right, size}, {&m->right_im, size}, {&m->left, size}, {&m->left_im, size}, {0}};
    double *block;
    sp_status status = sp_arrays_make(arrays, &block, err);
    for (int64_t row = m->rattlers; row < m->n && status == SP_OK; row++)
        fill_row(p, row, m);
    if (status == SP_OK)
        status = find_residual(net, m, err);
    return status == SP_OK ? find_orthogonality(p, m, err) : status;
}
