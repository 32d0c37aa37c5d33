/* The chain of equal balls between walls, where everything is known exactly (Somfai et al. 2005, Appendix C). */
#include "reference.h"

#include <sonopack/front.h>
#include <sonopack/modes.h>
#include <sonopack/signal.h>

static const long double PI = 3.14159265358979323846264338L;

static sp_network chain_network(int n) {
    FREED(sp_packing) p = chain_packing(n, 1e-4);
    sp_network_options o = sp_network_options_default();
    sp_network net = sp_network_none();
    assert_ok(sp_network_make(&p, &o, &net, &err));
    assert_int_equal(net.n_springs, n + 1);
    for (int k = 1; k <= n; k++)
        assert_true(net.springs[k].kn == net.springs[0].kn); /* the walls' too */
    return net;
}

/* (C2): omega_n = 2 sqrt(K/m) sin(n pi/(2(N+1))), every one of them relative to itself, with vectors and without. The
 * lowest of 1000 is 1/640 of the highest: its square is right to 1e-13 although LAPACK's error is 1e-15 of the highest
 * square, which is 4e-10 of the lowest. */
TEST(test_frequencies) {
    const int sizes[] = {1, 2, 5, 64, 333, 1000};
    for (size_t q = 0; q < sizeof sizes / sizeof *sizes; q++)
        for (int vectors = 0; vectors < 2; vectors++) {
            const int n = sizes[q];
            FREED(sp_network) net = chain_network(n);
            const long double top = 2 * sqrtl((long double)net.springs[0].kn / net.mass[0]);
            const sp_modes_options o = {.vectors = vectors, .source = SP_SOURCE_IMPULSE};
            FREED(sp_modes) m = sp_modes_none();
            double worst = 0;
            assert_ok(sp_modes_dense(&net, &o, &m, &err));
            assert_int_equal(m.n, n);
            assert_int_equal(m.n_zero, 0);
            for (int k = 1; k <= n; k++) {
                const double exact = (double)(top * sinl(k * PI / (2 * (n + 1))));
                worst = fmax(worst, fabs(m.omega[k - 1] / exact - 1));
                assert_close(m.omega[k - 1], exact, m.error[k - 1] + 2e-16 * exact);
                assert_relative(m.omega[k - 1], exact, 1e-13);
            }
            printf("N = %d, %s: worst relative error of a frequency %.2g\n", n, vectors ? "vectors" : "values", worst);
        }
}

/* u_n(i) = sqrt(2/(N+1)) sin(n pi i/(N+1)). */
TEST(test_vectors) {
    enum { N = 100 };
    FREED(sp_network) net = chain_network(N);
    const sp_modes_options o = sp_modes_options_default();
    FREED(sp_modes) m = sp_modes_none();
    assert_ok(sp_modes_dense(&net, &o, &m, &err));
    for (int n = 1; n <= N; n++) {
        const double *e = m.vectors + (n - 1) * N;
        double overlap = 0;
        for (int i = 1; i <= N; i++)
            overlap += e[i - 1] * sqrt(2.0 / (N + 1)) * sin((double)(n * PI * i / (N + 1)));
        assert_close(fabs(overlap), 1, 1e-12);
    }
}

/* (C4), (C5): F(t) = K u_N(t) with a_n^A = 2/(N+1) cos(k_n/2) v/(...) for a kick of the first ball, and a_n^B = 2/(N+1)
 * sin(k_n) for its displacement; here kick and displacement are K instead of 1. */
TEST(test_signal) {
    enum { N = 50, POINTS = 301 };
    FREED(sp_network) net = chain_network(N);
    const long double stiffness = net.springs[0].kn, mass = net.mass[0], rate = sqrtl(stiffness / mass);
    for (int source = 0; source < 3; source++)
        for (int method = SP_SIGNAL_CHEBYSHEV; method <= SP_SIGNAL_DENSE; method++) {
            sp_signal_options o = sp_signal_options_default();
            FREED(sp_signal) s = sp_signal_none();
            o.method = (sp_signal_method)method;
            o.source = (sp_source)source;
            o.until = 3 * N / (double)rate;
            o.points = POINTS;
            assert_ok(sp_signal_make(&net, &o, &s, &err));
            for (int l = 0; l < POINTS; l++) {
                long double f = 0;
                for (int n = 1; n <= N; n++) {
                    const long double k = n * PI / (N + 1), omega = 2 * rate * sinl(k / 2);
                    long double a = 2.0L / (N + 1) * sinl(k);
                    if (source == SP_SOURCE_DISPLACEMENT)
                        a *= stiffness * cosl(omega * s.t[l]);
                    else
                        a *= stiffness / (source == SP_SOURCE_IMPULSE ? mass : 1) * sinl(omega * s.t[l]) / omega;
                    f += stiffness * a * sinl(k * N);
                }
                assert_close(s.f[l], (double)f, s.error);
            }
        }
}

/* Amplitude and width of the first front at N and 4 N balls: exponents gamma and alpha. */
static void exponents(sp_source source, int n, double *gamma, double *alpha) {
    sp_front front[2];
    for (int q = 0; q < 2; q++) {
        const int length = n << 2 * q;
        FREED(sp_network) net = chain_network(length);
        sp_signal_options o = sp_signal_options_default();
        FREED(sp_signal) s = sp_signal_none();
        const sp_front_options how = sp_front_options_default();
        o.source = source;
        o.until = (length + 8 * cbrt(length)) / sqrt(net.springs[0].kn / net.mass[0]);
        o.points = 4 * length;
        assert_ok(sp_signal_make(&net, &o, &s, &err));
        assert_ok(sp_front_find(s.n, s.t, s.f, &how, &front[q], &err));
    }
    *gamma = -log2(front[1].amplitude / front[0].amplitude) / 2;
    *alpha = log2(front[1].width / front[0].width) / 2;
}

/* Table III: gamma = 2/3 from a velocity, 1 from a displacement, alpha = 1/3, as N grows. Corrections to the Airy front
 * fall as N^(-1/3) at the slowest: to 0.63 of themselves where N is 4 times larger. */
TEST(test_exponents) {
    const double limit[] = {2.0 / 3, 1};
    const sp_source source[] = {SP_SOURCE_VELOCITY, SP_SOURCE_DISPLACEMENT};
    for (int q = 0; q < 2; q++) {
        double gamma[2], alpha[2];
        for (int k = 0; k < 2; k++)
            exponents(source[q], 400 << 2 * k, &gamma[k], &alpha[k]);
        printf("source %c: gamma %.4f, %.4f; alpha %.4f, %.4f\n", 'A' + q, gamma[0], gamma[1], alpha[0], alpha[1]);
        assert_close(gamma[1], limit[q], 0.02);
        assert_close(alpha[1], 1.0 / 3, 0.02);
        assert_true(fabs(gamma[1] - limit[q]) < 0.75 * fabs(gamma[0] - limit[q]));
        assert_true(fabs(alpha[1] - 1.0 / 3) < 0.75 * fabs(alpha[0] - 1.0 / 3));
    }
}

RUN_TESTS(NULL, NULL)
