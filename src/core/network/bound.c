/* Bounds of the spectrum: from above by the absolute values of K's entries, from below by the Lanczos recursion. */
#include "network/bound.h"

#include "base/base.h"
#include "base/clones.h"
#include "base/vector.h"
#include "network/rows.h"
#include "numeric/random.h"

#include <math.h>
#include <string.h>

enum { STEPS = 16, DOF_MAX = 6 };

typedef struct sizes {
    int dof;
    double *own;  /* [n][dof][dof] |K_ii| */
    double *link; /* [n_bulk][dof][dof] a spring's part of |K_ij|, rows of i */
    double *w, *next;
} sizes;

static void sizes_free(sizes *m) {
    sp_free(m->own);
    sp_free(m->link);
    sp_free(m->w);
    sp_free(m->next);
}

/* The matrix to bound: the symmetric part of K, the contribution of the forces at rest to it, or the antisymmetric
 * part. */
typedef enum part { PART_SYMMETRIC = 0, PART_ADDED, PART_SKEW } part;

/* Matrix of a spring: rows, and the symmetric (sign 1) or antisymmetric (-1) part of turns. */
typedef struct matrix {
    sp_rows rows;
    sp_turns turns;
    double sign;
} matrix;

static void matrix_of(const sp_network *net, int32_t k, part which, matrix *out) {
    sp_spring s = net->springs[k];
    if (which == PART_ADDED)
        s.kn = s.kt = 0;
    if (which == PART_SKEW)
        s.kn = s.kt = s.kp = 0;
    out->sign = which == PART_SKEW ? -1 : 1;
    sp_network_rows(net, &s, &out->rows);
    sp_network_turns(net, k, &out->turns);
}

/* Adds the block of the matrix with rows of end a and columns of end b. */
static void add_block(const matrix *m, int dof, int side_a, int side_b, double *block) {
    const sp_rows *rows = &m->rows;
    for (int q = 0; q < rows->count; q++)
        for (int a = 0; a < dof; a++)
            for (int b = 0; b < dof; b++)
                block[a * dof + b] += rows->k[q] * (rows->b[q][side_a * dof + a] * rows->b[q][side_b * dof + b]);
    const sp_turns *t = &m->turns;
    for (int q = 0; q < t->count; q++)
        for (int a = 0; a < dof; a++)
            for (int b = 0; b < dof; b++)
                block[a * dof + b] += 0.5 * (t->left[q][side_a * dof + a] * t->right[q][side_b * dof + b] +
                                             m->sign * t->right[q][side_a * dof + a] * t->left[q][side_b * dof + b]);
}

/* Adding absolute values also bounds several springs between the same grains. If a grain touches its own periodic
 * image, the whole spring belongs to the grain's own block. */
static void add_spring(const sp_network *net, int32_t k, part which, const sizes *m) {
    const sp_spring *s = &net->springs[k];
    const int dof = net->dof;
    const size_t block = (size_t)dof * (size_t)dof;
    matrix x;
    matrix_of(net, k, which, &x);
    add_block(&x, dof, 0, 0, m->own + (size_t)s->i * block);
    if (s->j < 0)
        return;
    add_block(&x, dof, 1, 1, m->own + (size_t)s->j * block);
    if (s->i == s->j) {
        add_block(&x, dof, 0, 1, m->own + (size_t)s->i * block);
        add_block(&x, dof, 1, 0, m->own + (size_t)s->i * block);
    } else {
        add_block(&x, dof, 0, 1, m->link + (size_t)k * block);
    }
}

static ALWAYS_INLINE void multiply(int dof, const sp_network *net, const sizes *m) {
    const double *w = m->w;
    double *next = m->next;
    for (ptrdiff_t g = 0; g < net->n; g++)
        for (int a = 0; a < dof; a++) {
            double sum = 0;
            for (int b = 0; b < dof; b++)
                sum += m->own[(g * dof + a) * dof + b] * w[g * dof + b];
            next[g * dof + a] = sum;
        }
    for (ptrdiff_t k = 0; k < net->n_bulk; k++) {
        const ptrdiff_t i = (ptrdiff_t)net->springs[k].i * dof, j = (ptrdiff_t)net->springs[k].j * dof;
        const double *block = m->link + k * dof * dof;
        double other[DOF_MAX] = {0};
        for (int a = 0; a < dof; a++) {
            double sum = 0;
            for (int b = 0; b < dof; b++) {
                sum += block[a * dof + b] * w[j + b];
                other[b] += block[a * dof + b] * w[i + a];
            }
            next[i + a] += sum;
        }
        for (int b = 0; b < dof; b++)
            next[j + b] += other[b];
    }
}

/* next = |K| w. */
static void apply(const sp_network *net, const sizes *m) {
    switch (m->dof) {
    case 1: multiply(1, net, m); break;
    case 2: multiply(2, net, m); break;
    case 3: multiply(3, net, m); break;
    default: multiply(6, net, m); break;
    }
}

/* Bounds the spectral radius of A = M^-1/2 K M^-1/2, where K may be a part with symmetric absolute values. By Perron
 * and Frobenius it is at most that of |A|, and by Collatz and Wielandt this is at most max (|A| v)_i / v_i for every v
 * > 0. Here v = M^1/2 w. Power steps improve w, and the smallest of the maxima is used. */
static double collatz_wielandt(const sp_network *net, const sizes *m) {
    const int64_t n = sp_network_dofs(net);
    double best = HUGE_VAL;
    for (int64_t k = 0; k < n; k++)
        m->w[k] = 1 / sqrt(net->mass[k]);
    for (int step = 0; step < STEPS; step++) {
        double largest = 0;
        apply(net, m);
        for (int64_t k = 0; k < n; k++) {
            m->next[k] /= net->mass[k];
            largest = fmax(largest, m->next[k] / m->w[k]);
        }
        if (largest == 0)
            return 0;
        best = fmin(best, largest);
        for (int64_t k = 0; k < n; k++) /* keeping part of the old w keeps all entries positive */
            m->w[k] = m->next[k] / largest + 0.05 * m->w[k];
    }
    return best;
}

/* Upper bound of the absolute eigenvalues of a part of M^-1/2 K M^-1/2. */
static double bound_of(const sp_network *net, part which, const sizes *m) {
    const size_t dof = (size_t)net->dof, n = (size_t)net->n, links = (size_t)net->n_bulk;
    memset(m->own, 0, n * dof * dof * sizeof *m->own);
    memset(m->link, 0, links * dof * dof * sizeof *m->link);
    for (int32_t k = 0; k < net->n_springs; k++)
        add_spring(net, k, which, m);
    for (size_t k = 0; k < n * dof * dof; k++)
        m->own[k] = fabs(m->own[k]);
    for (size_t k = 0; k < links * dof * dof; k++)
        m->link[k] = fabs(m->link[k]);
    return collatz_wielandt(net, m);
}

sp_status sp_network_find_bounds(sp_network *net, sp_error *err) {
    const size_t dof = (size_t)net->dof, n = (size_t)net->n, links = (size_t)net->n_bulk;
    sizes m = {.dof = net->dof};
    sp_status status = SP_OK;
    m.own = sp_alloc(n, dof * dof * sizeof *m.own);
    m.link = sp_alloc(links, dof * dof * sizeof *m.link);
    m.w = sp_alloc(n, dof * sizeof *m.w);
    m.next = sp_alloc(n, dof * sizeof *m.next);
    if (!m.own || !m.link || !m.w || !m.next) {
        status = sp_fail_memory(err, ((n + links) * dof + 2 * n) * dof * sizeof(double));
        goto out;
    }
    /* margin for rounding in sums of some tens of terms */
    net->omega_bound = sqrt(bound_of(net, PART_SYMMETRIC, &m)) * (1 + 1e-13);
    net->soft = net->prestress ? bound_of(net, PART_ADDED, &m) * (1 + 1e-13) : 0;
    net->skew = net->carried ? bound_of(net, PART_SKEW, &m) * (1 + 1e-13) : 0;
out:
    sizes_free(&m);
    return status;
}

/* ---- from below -------------------------------------------------------------------------------------------------- */

enum { LANCZOS_STEPS = 200 };

/* Whether the symmetric tridiagonal matrix T has an eigenvalue above x: some pivot of T - x is positive (Sylvester). */
static bool exceeds(int n, const double *diagonal, const double *off_diagonal, double x) {
    double pivot = diagonal[0] - x;
    for (int k = 1; k < n && pivot < 0; k++)
        pivot = diagonal[k] - x - off_diagonal[k - 1] * off_diagonal[k - 1] / pivot;
    return pivot >= 0;
}

static double largest_of(int n, const double *diagonal, const double *off_diagonal) {
    double low = 0, high = 0;
    for (int k = 0; k < n; k++)
        high =
            fmax(high, diagonal[k] + (k > 0 ? fabs(off_diagonal[k - 1]) : 0) + (k + 1 < n ? fabs(off_diagonal[k]) : 0));
    while (high - low > 1e-12 * high) {
        const double middle = 0.5 * (low + high);
        if (exceeds(n, diagonal, off_diagonal, middle))
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* out = A x, where A is the symmetric part of M^-1/2 K M^-1/2. */
static void apply_symmetric(const sp_network *net, const double *x, double *out, double *work) {
    const int64_t n = sp_network_dofs(net);
    double *scaled = work, *other = work + n;
    for (int64_t k = 0; k < n; k++)
        scaled[k] = x[k] / sqrt(net->mass[k]);
    sp_network_apply(net, scaled, out);
    if (net->carried) {
        sp_network_apply_transposed(net, scaled, other);
        for (int64_t k = 0; k < n; k++)
            out[k] = 0.5 * (out[k] + other[k]);
    }
    for (int64_t k = 0; k < n; k++)
        out[k] /= sqrt(net->mass[k]);
}

/* The vectors are not reorthogonalized: the resulting copies of eigenvalues do not affect the largest one. */
static double recur(const sp_network *net, double *work) {
    const int64_t n = sp_network_dofs(net);
    double *x = work, *before = work + n, *next = work + 2 * n, diagonal[LANCZOS_STEPS], off_diagonal[LANCZOS_STEPS],
           beta = 0;
    sp_random stream = sp_random_make(1, SP_STREAM_LARGEST);
    int steps = 0;
    for (int64_t k = 0; k < n; k++)
        x[k] = sp_random_uniform(&stream) - 0.5;
    const double size = sqrt(sp_dot(n, x, x));
    for (int64_t k = 0; k < n; k++)
        x[k] /= size;
    while (steps < LANCZOS_STEPS && steps < n) {
        apply_symmetric(net, x, next, work + 3 * n);
        const double alpha = sp_dot(n, x, next);
        for (int64_t k = 0; k < n; k++)
            next[k] -= alpha * x[k] + beta * before[k];
        beta = sqrt(sp_dot(n, next, next));
        diagonal[steps] = alpha;
        off_diagonal[steps++] = beta;
        if (!(beta > 1e-12 * fabs(alpha)))
            break;
        for (int64_t k = 0; k < n; k++)
            next[k] /= beta;
        double *oldest = before;
        before = x;
        x = next;
        next = oldest;
    }
    return sqrt(largest_of(steps, diagonal, off_diagonal));
}

sp_status sp_network_find_largest(const sp_network *net, double *omega, sp_error *err) {
    const size_t n = (size_t)sp_network_dofs(net);
    double *work = sp_alloc(5 * n, sizeof *work);
    if (!work)
        return sp_fail_memory(err, 5 * n * sizeof *work);
    *omega = recur(net, work);
    sp_free(work);
    return SP_OK;
}
