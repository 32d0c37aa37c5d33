/* The bound of the spectrum that the sizes of K's entries give. K is not assembled: a dense block for each grain, and
 * one for each spring between two. */
#include "network/bound.h"
#include "base/base.h"
#include "base/clones.h"
#include "network/rows.h"

#include <math.h>

enum { STEPS = 16, DOF_MAX = 6 };

typedef struct sizes {
    int dof;
    double *own;  /* [n][dof][dof] |K_ii| */
    double *link; /* [n_bulk][dof][dof] |K_ij|, a spring's part of it, rows of i */
    double *w, *next;
} sizes;

static void sizes_free(sizes *m) {
    sp_free(m->own);
    sp_free(m->link);
    sp_free(m->w);
    sp_free(m->next);
}

/* Adds rows' part of side a's dofs times side b's. */
static void add_block(const sp_rows *rows, int dof, int side_a, int side_b, double *block) {
    for (int q = 0; q < rows->count; q++)
        for (int a = 0; a < dof; a++)
            for (int b = 0; b < dof; b++)
                block[a * dof + b] += rows->k[q] * (rows->b[q][side_a * dof + a] * rows->b[q][side_b * dof + b]);
}

/* Two springs between the same grains are bounded by the sum of their sizes; a grain that touches itself through a
 * periodic side has all of the spring in its own block. */
static void add_spring(const sp_network *net, int32_t k, const sizes *m) {
    const sp_spring *s = &net->springs[k];
    const int dof = net->dof;
    const size_t block = (size_t)dof * (size_t)dof;
    sp_rows rows;
    sp_network_rows(net, s, &rows);
    add_block(&rows, dof, 0, 0, m->own + (size_t)s->i * block);
    if (s->j < 0)
        return;
    add_block(&rows, dof, 1, 1, m->own + (size_t)s->j * block);
    if (s->i == s->j) {
        add_block(&rows, dof, 0, 1, m->own + (size_t)s->i * block);
        add_block(&rows, dof, 1, 0, m->own + (size_t)s->i * block);
    } else {
        add_block(&rows, dof, 0, 1, m->link + (size_t)k * block);
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

/* Perron and Frobenius: the spectral radius of A = M^-1/2 K M^-1/2 is at most that of |A|, which is at most
 * max (|A| v)_i / v_i for every v > 0 (Collatz and Wielandt). Here with v = M^1/2 w, w improved by power steps, the
 * smallest of their maxima taken. */
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
        best = fmin(best, largest);
        for (int64_t k = 0; k < n; k++) /* the old part keeps every entry positive */
            m->w[k] = m->next[k] / largest + 0.05 * m->w[k];
    }
    return best;
}

sp_status sp_network_find_bound(const sp_network *net, double *omega, sp_error *err) {
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
    for (int32_t k = 0; k < net->n_springs; k++)
        add_spring(net, k, &m);
    for (size_t k = 0; k < n * dof * dof; k++)
        m.own[k] = fabs(m.own[k]);
    for (size_t k = 0; k < links * dof * dof; k++)
        m.link[k] = fabs(m.link[k]);
    /* room for the rounding of sums of some tens of terms */
    *omega = sqrt(collatz_wielandt(net, &m)) * (1 + 1e-13);
out:
    sizes_free(&m);
    return status;
}
