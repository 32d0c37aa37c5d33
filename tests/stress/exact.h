#ifndef STRESS_EXACT_H
#define STRESS_EXACT_H
/* A small network solved in quadruple precision: A = M^-1/2 K M^-1/2 summed spring by spring from the rows of B, its
 * eigenvalues and vectors by Jacobi's rotations, signals as whole functions of the eigenvalues. Eigenvalues are right
 * to some 1e-33 of the largest, so that no frequency need be told from zero. */

#include "network/rows.h"
#include "stress/quad.h"
#include "test.h"

#include <sonopack/signal.h>

typedef struct exact {
    int n;
    quad *lambda; /* [n] ascending */
    quad *e;      /* [n][n] rows: vectors, mass weighted */
} exact;

static inline void exact_free(exact *x) {
    free(x->lambda);
    free(x->e);
    *x = (exact){0};
}

/* K as a full matrix. */
static inline quad *exact_stiffness(const sp_network *net) {
    const int n = (int)sp_network_dofs(net), dof = net->dof;
    quad *k = calloc((size_t)n * (size_t)n, sizeof *k);
    for (int c = 0; c < net->n_springs; c++) {
        const sp_spring *s = &net->springs[c];
        sp_rows rows;
        sp_network_rows(net, s, &rows);
        for (int q = 0; q < rows.count; q++)
            for (int a = 0; a < rows.width; a++)
                for (int b = 0; b < rows.width; b++) {
                    const int i = (a < dof ? s->i : s->j) * dof + a % dof, j = (b < dof ? s->i : s->j) * dof + b % dof;
                    k[i * n + j] += (quad)rows.k[q] * rows.b[q][a] * rows.b[q][b];
                }
    }
    return k;
}

static inline quad *exact_matrix(const sp_network *net) {
    const int n = (int)sp_network_dofs(net);
    quad *a = exact_stiffness(net), *root = calloc((size_t)n, sizeof *root);
    for (int i = 0; i < n; i++)
        root[i] = quad_sqrt(net->mass[i]);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            a[i * n + j] /= root[i] * root[j];
    free(root);
    return a;
}

static inline void exact_turn(int n, quad *x, int stride, int p, int q, quad c, quad s) {
    for (int k = 0; k < n; k++) {
        const quad a = x[p + k * stride], b = x[q + k * stride];
        x[p + k * stride] = c * a - s * b;
        x[q + k * stride] = s * a + c * b;
    }
}

/* One rotation that makes a_pq zero (Golub and Van Loan, section 8.5). */
static inline void exact_rotate(int n, quad *a, quad *e, int p, int q) {
    const quad tau = (a[q * n + q] - a[p * n + p]) / (2 * a[p * n + q]);
    const quad t = (tau >= 0 ? 1 : -1) / (quad_abs(tau) + quad_sqrt(1 + tau * tau)), c = 1 / quad_sqrt(1 + t * t);
    exact_turn(n, a, n, p, q, c, t * c); /* columns */
    exact_turn(n, a + p * n, 1, 0, (q - p) * n, c, t * c);
    a[p * n + q] = a[q * n + p] = 0;
    exact_turn(n, e + p * n, 1, 0, (q - p) * n, c, t * c);
}

static inline void exact_order(exact *x) {
    for (int i = 0; i < x->n; i++) {
        int least = i;
        for (int j = i + 1; j < x->n; j++)
            least = x->lambda[j] < x->lambda[least] ? j : least;
        const quad lambda = x->lambda[i];
        x->lambda[i] = x->lambda[least];
        x->lambda[least] = lambda;
        for (int k = 0; k < x->n && least != i; k++) {
            const quad part = x->e[i * x->n + k];
            x->e[i * x->n + k] = x->e[least * x->n + k];
            x->e[least * x->n + k] = part;
        }
    }
}

static inline exact exact_solve(const sp_network *net) {
    exact x = {.n = (int)sp_network_dofs(net)};
    const int n = x.n;
    quad *a = exact_matrix(net), scale = 0;
    x.lambda = calloc((size_t)n, sizeof *x.lambda);
    x.e = calloc((size_t)n * (size_t)n, sizeof *x.e);
    for (int i = 0; i < n; i++) {
        x.e[i * n + i] = 1;
        for (int j = 0; j < n; j++)
            scale = quad_abs(a[i * n + j]) > scale ? quad_abs(a[i * n + j]) : scale;
    }
    for (int sweep = 0, turns = 1; turns > 0; sweep++) {
        assert_true(sweep < 60);
        turns = 0;
        for (int p = 0; p < n; p++)
            for (int q = p + 1; q < n; q++)
                if (quad_abs(a[p * n + q]) > scale * 1e-34L) {
                    exact_rotate(n, a, x.e, p, q);
                    turns++;
                }
    }
    for (int i = 0; i < n; i++)
        x.lambda[i] = a[i * n + i];
    exact_order(&x);
    free(a);
    return x;
}

/* Weights (detector . u_n)(u_n . source) of all modes. sent: momenta, or displacements; seen: the detector. */
static inline void exact_weights(const exact *x, const sp_network *net, bool velocity, const double *sent,
                                 const double *seen, quad *ab) {
    for (int m = 0; m < x->n; m++) {
        quad a = 0, b = 0;
        for (int k = 0; k < x->n; k++) {
            const quad root = quad_sqrt(net->mass[k]), part = x->e[m * x->n + k];
            a += velocity ? part * sent[k] / root : part * sent[k] * root;
            b += part * seen[k] / root;
        }
        ab[m] = a * b;
    }
}

static inline void exact_signal(const exact *x, bool velocity, const quad *ab, int points, const double *t, quad *f) {
    for (int l = 0; l < points; l++) {
        f[l] = 0;
        for (int m = 0; m < x->n; m++)
            if (ab[m] > 0 || ab[m] < 0)
                f[l] += ab[m] * quad_swing(x->lambda[m], t[l], velocity);
    }
}

#endif
