#ifndef PROPERTIES_EXACT_MOTION_H
#define PROPERTIES_EXACT_MOTION_H
/* M u'' + C u' + K u = 0 in extended precision, by Taylor's series in time of short steps: K need not be symmetric or
 * positive. It shares the springs' rows with the library, and no method of solution. */
#include "network/rows.h"
#include "test.h"

#include <sonopack/network.h>

typedef long double extended;

typedef struct motion {
    int n;
    extended *k, *c;     /* [n][n] M^-1/2 K M^-1/2, and with dashpots the same of C, or NULL */
    int32_t *first, *at; /* row a has entries in the columns at[first[a]] .. */
    extended *y;         /* [2 n] mass-weighted displacements and velocities; behind it scratch of [4 n] */
    extended rate;       /* bound of the rates */
} motion;

static inline size_t motion_place(const sp_network *net, const sp_spring *s, int entry) {
    return (size_t)(entry < net->dof ? s->i : s->j) * (size_t)net->dof + (size_t)(entry % net->dof);
}

static inline extended *motion_matrix(const sp_network *net) {
    const size_t n = (size_t)sp_network_dofs(net);
    extended *k = calloc(n * n, sizeof *k);
    for (int32_t c = 0; c < net->n_springs; c++) {
        const sp_spring *s = &net->springs[c];
        sp_rows rows;
        sp_turns turns;
        sp_network_rows(net, s, &rows);
        sp_network_turns(net, c, &turns);
        for (int a = 0; a < rows.width; a++)
            for (int b = 0; b < rows.width; b++) {
                extended sum = 0;
                for (int q = 0; q < rows.count; q++)
                    sum += (extended)rows.k[q] * rows.b[q][a] * rows.b[q][b];
                for (int q = 0; q < turns.count; q++)
                    sum += (extended)turns.left[q][a] * turns.right[q][b];
                k[motion_place(net, s, a) * n + motion_place(net, s, b)] += sum;
            }
    }
    for (size_t a = 0; a < n; a++)
        for (size_t b = 0; b < n; b++)
            k[a * n + b] /= sqrtl((extended)net->mass[a]) * sqrtl((extended)net->mass[b]);
    return k;
}

/* The norm of rows and of columns bounds that of the matrix. */
static inline extended motion_norm(int n, const extended *k) {
    extended rows = 0, columns = 0;
    for (int a = 0; a < n; a++) {
        extended row = 0, column = 0;
        for (int b = 0; b < n; b++) {
            row += fabsl(k[a * n + b]);
            column += fabsl(k[b * n + a]);
        }
        rows = fmaxl(rows, row);
        columns = fmaxl(columns, column);
    }
    return sqrtl(rows * columns);
}

/* Where k or c has entries. */
static inline void motion_columns(motion *m) {
    m->first = calloc((size_t)m->n + 1, sizeof *m->first);
    m->at = calloc((size_t)m->n * (size_t)m->n, sizeof *m->at);
    for (int a = 0, used = 0; a < m->n; a++) {
        for (int b = 0; b < m->n; b++)
            if (m->k[a * m->n + b] != 0 || (m->c && m->c[a * m->n + b] != 0))
                m->at[used++] = b;
        m->first[a + 1] = used;
    }
}

/* sent: momenta, or displacements without `velocity`. */
static inline motion motion_begin(const sp_network *net, const sp_network *dashpots, const double *sent,
                                  bool velocity) {
    motion m = {.n = (int)sp_network_dofs(net), .k = motion_matrix(net)};
    m.c = dashpots ? motion_matrix(dashpots) : NULL;
    motion_columns(&m);
    m.y = calloc(6 * (size_t)m.n, sizeof *m.y);
    m.rate = sqrtl(motion_norm(m.n, m.k)) + (m.c ? motion_norm(m.n, m.c) : 0);
    for (int a = 0; a < m.n; a++) {
        const extended root = sqrtl((extended)net->mass[a]);
        m.y[velocity ? m.n + a : a] = velocity ? sent[a] / root : sent[a] * root;
    }
    return m;
}

static inline void motion_end(motion *m) {
    free(m->k);
    free(m->c);
    free(m->first);
    free(m->at);
    free(m->y);
}

/* out = L y: velocities, and accelerations. */
static inline void motion_rates(const motion *m, const extended *y, extended *out) {
    const int n = m->n;
    for (int a = 0; a < n; a++) {
        extended sum = 0;
        for (int32_t q = m->first[a]; q < m->first[a + 1]; q++) {
            const int b = m->at[q];
            sum -= m->k[a * n + b] * y[b] + (m->c ? m->c[a * n + b] * y[n + b] : 0);
        }
        out[a] = y[n + a];
        out[n + a] = sum;
    }
}

static inline void motion_step(motion *m, extended h) {
    const int n = 2 * m->n;
    extended *term = m->y + n, *next = term + n;
    memcpy(term, m->y, (size_t)n * sizeof *term);
    for (int k = 1; k < 40; k++) {
        motion_rates(m, term, next);
        for (int a = 0; a < n; a++) {
            term[a] = next[a] * h / k;
            m->y[a] += term[a];
        }
    }
}

static inline void motion_advance(motion *m, extended t) {
    const int steps = (int)ceill(t * m->rate) + 1;
    for (int k = 0; k < steps; k++)
        motion_step(m, t / steps);
}

/* det . u + dash . u'; dash may be NULL. */
static inline extended motion_seen(const motion *m, const sp_network *net, const double *det, const double *dash) {
    extended sum = 0;
    for (int a = 0; a < m->n; a++) {
        const extended root = sqrtl((extended)net->mass[a]);
        sum += det[a] * m->y[a] / root + (dash ? dash[a] * m->y[m->n + a] / root : 0);
    }
    return sum;
}

#endif
