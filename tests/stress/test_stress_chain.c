/* The chain in closed form against its matrix in quadruple precision, with walls from soft to stiff: frequencies and
 * signals within the errors that chain.h promises. */
#include "stress/exact.h"
#include "stress/record.h"

#include <sonopack/chain.h>

enum { TIMES = 9 };

/* Eigenvalues and vectors of the chain. */
static exact solve_chain(int n, double wall) {
    exact x = {.n = n};
    quad *a = calloc((size_t)(n * n), sizeof *a);
    x.lambda = calloc((size_t)n, sizeof *x.lambda);
    x.e = calloc((size_t)(n * n), sizeof *x.e);
    for (int i = 0; i < n; i++) {
        x.e[i * n + i] = 1;
        a[i * n + i] = (i == 0 ? (quad)wall : 1) + (i == n - 1 ? (quad)wall : 1);
        if (i > 0)
            a[i * n + i - 1] = a[(i - 1) * n + i] = -1;
    }
    for (int sweep = 0, turns = 1; turns > 0; sweep++) {
        assert_true(sweep < 60);
        turns = 0;
        for (int p = 0; p < n; p++)
            for (int q = p + 1; q < n; q++)
                if (quad_abs(a[p * n + q]) > 1e-34L) {
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

/* The worst time against the promised bound. */
static void compare_signal(stress_record *r, const char *network, const char *what, const sp_chain *chain,
                           const double *t, const double *f, const quad *want) {
    double error = 0, reported = 1;
    for (int l = 0; l < TIMES; l++) {
        const double off = (double)quad_abs(f[l] - want[l]);
        const double bound = sp_chain_signal_error(chain, t[l]);
        if (!(off / bound <= error / reported)) {
            error = off;
            reported = bound;
        }
    }
    stress_agree(r, network, "chain", what, error, reported, 1);
}

static void run(stress_record *r, int n, double wall) {
    const double t[TIMES] = {0, 1e-3, 0.7, n, 2.3 * n + 1, 10 * n + 3, 1e3, 2e4, 3e5};
    FREED(exact) x = solve_chain(n, wall);
    double f[TIMES], worst = 0;
    quad want[TIMES];
    char network[48];
    snprintf(network, sizeof network, "%d balls, walls of %g", n, wall);
    for (int source = SP_CHAIN_VELOCITY; source <= SP_CHAIN_DISPLACEMENT; source++) {
        const sp_chain chain = {n, (sp_chain_source)source, wall};
        for (int l = 0; l < TIMES; l++) {
            want[l] = 0;
            for (int m = 0; m < n; m++)
                want[l] +=
                    wall * x.e[m * n] * x.e[m * n + n - 1] * quad_swing(x.lambda[m], t[l], source == SP_CHAIN_VELOCITY);
        }
        assert_ok(sp_chain_walls_signal(&chain, TIMES, t, f, &err));
        compare_signal(r, network, source == SP_CHAIN_VELOCITY ? "signal A" : "signal B", &chain, t, f, want);
        if (wall < 1 || wall > 1)
            continue;
        assert_ok(sp_chain_signal(n, (sp_chain_source)source, TIMES, t, f, &err));
        compare_signal(r, network, "signal, equal springs", &chain, t, f, want);
    }
    for (int m = 1; m <= n && wall >= 1 && wall <= 1; m++) {
        const quad omega = quad_sqrt(x.lambda[m - 1]);
        worst = fmax(worst, (double)(quad_abs(sp_chain_omega(n, m) - omega) / omega));
    }
    if (wall >= 1 && wall <= 1)
        stress_agree(r, network, "chain", "frequencies, relative", worst, 5e-16, 1);
}

TEST(test_chains) {
    static const int lengths[] = {1, 2, 5, 24, 61};
    static const double walls[] = {0.01, 0.5, 1, 1.6, 1.95};
    stress_record r = stress_open();
    for (int k = 0; k < 5; k++)
        for (int w = 0; w < 5; w++)
            run(&r, lengths[k], walls[w]);
    stress_close(&r);
    assert_int_equal(r.wrong, 0);
}

RUN_TESTS_WHERE(STRESS_QUAD, NULL, NULL)
