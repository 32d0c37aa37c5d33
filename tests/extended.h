#ifndef TEST_EXTENDED_H
#define TEST_EXTENDED_H
/* The signal in long double by the plain three-term recurrence, K row by row and Bessel functions from a longer
 * recurrence normalised otherwise: shares nothing with the library but the formula, and has 11 bits more. */

#include "network/rows.h"
#include "test.h"

#include <sonopack/signal.h>

typedef long double extended;

static inline void extended_apply(const sp_network *net, const extended *u, extended *out) {
    memset(out, 0, (size_t)sp_network_dofs(net) * sizeof *out);
    for (int k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        sp_rows rows;
        sp_network_rows(net, s, &rows);
        for (int q = 0; q < rows.count; q++) {
            extended stretch = 0;
            for (int a = 0; a < rows.width; a++)
                stretch += (extended)rows.b[q][a] * u[(a < net->dof ? s->i : s->j) * net->dof + a % net->dof];
            for (int a = 0; a < rows.width; a++)
                out[(a < net->dof ? s->i : s->j) * net->dof + a % net->dof] += rows.k[q] * stretch * rows.b[q][a];
        }
    }
}

/* J_m(x), m < orders; those below 1e-60 are left 0. */
static inline void extended_bessel(extended x, int orders, extended *j) {
    int m = (int)(x + 100 + 40 * cbrtl(x));
    m += m % 2;
    extended above = 0, here = 1e-3000L, even = 0;
    memset(j, 0, (size_t)orders * sizeof *j);
    for (; m > 0; m--) {
        if (m < orders)
            j[m] = here;
        even += m % 2 ? 0 : here;
        const extended below = 2 * m / x * here - above;
        above = here;
        here = below;
    }
    j[0] = here;
    for (int k = 0; k < orders; k++)
        j[k] /= here + 2 * even;
}

/* sent: momenta, or displacements without `velocity`. */
static inline void extended_signal_of(const sp_network *net, const double *sent, const double *seen, bool velocity,
                                      int points, const double *t, double *f) {
    const size_t n = (size_t)sp_network_dofs(net);
    const extended omega = 1.01L * sp_network_omega_bound(net), last = omega * t[points - 1];
    const int terms = (int)(last / 2 + 40 + 10 * cbrtl(last));
    extended *v = calloc(4 * n, sizeof *v), *mu = calloc((size_t)terms, sizeof *mu), *now = v, *old = v + n,
             *ku = v + 2 * n;
    for (size_t k = 0; k < n; k++)
        now[k] = velocity ? sent[k] / (extended)net->mass[k] : sent[k];
    for (int step = 0; step < terms; step++) {
        for (size_t k = 0; k < n; k++)
            mu[step] += now[k] * seen[k];
        extended_apply(net, now, ku);
        for (size_t k = 0; k < n; k++) {
            const extended pull = 4 / (omega * omega) * ku[k] / net->mass[k];
            extended next = 2 * now[k] - pull - old[k];
            if (step == 0)
                next = velocity ? 3 * now[k] - pull : now[k] - pull / 2;
            old[k] = now[k];
            now[k] = next;
        }
    }
    RELEASED extended *j = calloc(2 * (size_t)terms, sizeof *j);
    for (int l = 0; l < points; l++) {
        extended sum = 0;
        if (t[l] == 0) {
            f[l] = velocity ? 0 : (double)mu[0];
            continue;
        }
        extended_bessel(omega * t[l], 2 * terms, j);
        for (int k = 0; k < terms; k++)
            sum += velocity ? 2 / omega * j[2 * k + 1] * mu[k] : (k ? 2 : 1) * j[2 * k] * mu[k];
        f[l] = (double)sum;
    }
    free(mu);
    free(v);
}

/* From wall to wall. */
static inline void extended_signal(const sp_network *net, sp_source source, int points, const double *t, double *f) {
    const size_t n = (size_t)sp_network_dofs(net);
    double *sent = calloc(2 * n, sizeof *sent), *seen = sent + n;
    assert_ok(sp_network_source(net, source, sent, &err));
    assert_ok(sp_network_detector(net, seen, &err));
    extended_signal_of(net, sent, seen, source != SP_SOURCE_DISPLACEMENT, points, t, f);
    free(sent);
}

#endif
