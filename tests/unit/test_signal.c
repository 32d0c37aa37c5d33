#include "base/base.h"
#include "extended.h"
#include "signals.h"

#include <sonopack/signal.h>

static sp_signal_options options_of(sp_signal_method method, sp_source source, double until, int points) {
    sp_signal_options o = sp_signal_options_default();
    o.method = method;
    o.source = source;
    o.until = until;
    o.points = points;
    return o;
}

static sp_signal signal_of(const sp_network *net, sp_signal_options o) {
    sp_signal s = sp_signal_none();
    assert_ok(sp_signal_make(net, &o, &s, &err));
    assert_int_equal(s.n, o.points);
    assert_true(s.t[0] == 0 && s.t[s.n - 1] == o.until);
    return s;
}

/* The signals that came with the packings: both sources, both methods. Theirs are right to 2.1e-13 of the peak. */
TEST(test_reference) {
    enum { MOST = 1000 };
    const char *const packings[] = {REFERENCE("packing_N200_p1e-4.txt"), REFERENCE("packing_N600_p1e-4.txt")};
    const char *const signals[] = {REFERENCE("signal_N200_p1e-4.txt"), REFERENCE("signal_N600_p1e-4.txt")};
    for (int q = 0; q < 2; q++) {
        double t[MOST], velocity[MOST], impulse[MOST];
        const int n = reference_signal(signals[q], MOST, t, velocity, impulse);
        FREED(sp_packing) p = reference_packing(packings[q]);
        FREED(sp_network) net = network_of(&p, false);
        assert_int_equal(n, 801);
        for (int source = 0; source < 2; source++)
            for (int method = SP_SIGNAL_AUTO; method <= (q == 0 ? SP_SIGNAL_DENSE : SP_SIGNAL_CHEBYSHEV); method++) {
                const double *exact = source == SP_SOURCE_IMPULSE ? impulse : velocity, peak = peak_of(n, exact);
                FREED(sp_signal)
                s = signal_of(&net, options_of((sp_signal_method)method, (sp_source)source, t[n - 1], n));
                for (int k = 0; k < n; k++)
                    assert_close(s.t[k], t[k], 1e-12);
                assert_close(difference(n, s.f, exact), 0, 5e-13 * peak);
                assert_close(s.error, 0, 1e-11 * peak);
                assert_int_equal(s.method, method == SP_SIGNAL_DENSE ? SP_SIGNAL_DENSE : SP_SIGNAL_CHEBYSHEV);
            }
    }
}

/* The true error, by long double, stays below the bound for every dimension, source, method and time span; and the
 * bound is no more than some hundred times too large, where there is a signal. */
static void check_bound(const char *name, const sp_network *net, double until, int points) {
    double *t = calloc(2 * (size_t)points, sizeof *t), *exact = t + points;
    for (int k = 0; k < points; k++)
        t[k] = k < points - 1 ? until * k / (points - 1) : until;
    for (int source = 0; source < 3; source++) {
        extended_signal(net, (sp_source)source, points, t, exact);
        const double peak = peak_of(points, exact);
        for (int method = SP_SIGNAL_CHEBYSHEV; method <= SP_SIGNAL_DENSE; method++) {
            sp_signal_options o = options_of((sp_signal_method)method, (sp_source)source, until, points);
            FREED(sp_signal) s = sp_signal_none();
            sp_error err = {0};
            o.tolerance = 1e-9;
            if (sp_signal_make(net, &o, &s, &err) != SP_OK) { /* dense sums cannot see what has not arrived */
                assert_int_equal(method, SP_SIGNAL_DENSE);
                assert_true(err.status == SP_EREFUSED && peak < 1e-5);
                continue;
            }
            const double error = difference(points, s.f, exact);
            if (!(error <= s.error))
                fail_msg("%s: source %d method %d until %g: error %g above its bound %g (peak %g)", name, source,
                         method, until, error, s.error, peak);
            if (peak > 1e-5)
                assert_true(s.error < 1e-10 * peak);
        }
    }
    free(t);
}

TEST(test_error_bound) {
    const double spans[] = {1, 7, 30, 150, 1200};
    const struct {
        const char *name;
        sp_packing p;
        bool prestress;
    } all[] = {{"one ball", chain_packing(1, 1e-4), false},
               {"two balls", chain_packing(2, 1e-4), false},
               {"chain", chain_packing(40, 1e-4), false},
               {"2D", scattered_packing(2, 5, 0.5, 1), false},
               {"2D without friction", scattered_packing(2, 5, 0, 2), false},
               {"3D", scattered_packing(3, 3, 0.5, 3), false},
               {"3D without friction", scattered_packing(3, 3, 0, 4), false},
               {"reference", without_tangential(reference_packing(REFERENCE("packing_N200_p1e-4.txt"))), true}};
    for (size_t q = 0; q < sizeof all / sizeof *all; q++) {
        FREED(sp_packing) p = all[q].p;
        FREED(sp_network) net = network_of(&p, all[q].prestress);
        for (size_t k = 0; k < (q < 7 ? 5 : 4); k++)
            check_bound(all[q].name, &net, spans[k], 41);
    }
}

/* Before anything can have arrived F is 0 beyond doubt, and afterwards small values are right relative to themselves:
 * no floor of rounding. */
TEST(test_early) {
    FREED(sp_packing) p = chain_packing(20, 1e-4);
    FREED(sp_network) net = network_of(&p, false);
    FREED(sp_signal) s = signal_of(&net, options_of(SP_SIGNAL_CHEBYSHEV, SP_SOURCE_IMPULSE, 60, 61));
    const double m = net.mass[0], k = net.springs[0].kn;
    assert_true(s.f[0] == 0);
    /* first term of the power series in t, through 19 springs: F = k (k/m) (k/m)^19 t^39/39! */
    double first = k * (k / m), t = s.t[1];
    for (int q = 1; q < 20; q++)
        first *= k / m * t / (2 * q) * t / (2 * q + 1);
    first *= t;
    assert_relative(s.f[1], first, 0.01);
    assert_true(first < 1e-30);
}

TEST(test_window) {
    assert_relative(sp_signal_window(24, 1e-4), 232.0, 1e-15);
    assert_relative(sp_signal_window(24, 1e-7), 232 * sqrt(10), 1e-14);
}

/* All refusals of signals, one row each: what is changed in options that are right. */
TEST(test_refusals) {
    sp_packing p = chain_packing(30, 1e-4);
    sp_network net = network_of(&p, false);
    sp_signal s = sp_signal_none();
    const double no_times[] = {0, -1, NAN, INFINITY}, no_tolerances[] = {0, -1, NAN, 1, INFINITY};
#define WRONG(method_, until_, change, status, words)                                                                  \
    do {                                                                                                               \
        sp_signal_options o = options_of(method_, SP_SOURCE_IMPULSE, until_, 51);                                      \
        change;                                                                                                        \
        assert_fails(sp_signal_make(&net, &o, &s, &err), status, words);                                               \
    } while (0)
    for (size_t k = 0; k < sizeof no_times / sizeof *no_times; k++)
        WRONG(SP_SIGNAL_AUTO, no_times[k], , SP_EINVAL, "until");
    for (size_t k = 0; k < sizeof no_tolerances / sizeof *no_tolerances; k++)
        WRONG(SP_SIGNAL_AUTO, 100, o.tolerance = no_tolerances[k], SP_EINVAL, "tolerance");
    for (int k = 1; k < 4; k++)
        WRONG(SP_SIGNAL_VERLET, 100, o.step = fmin(no_times[k], INFINITY), SP_EINVAL, "step");
    WRONG(SP_SIGNAL_AUTO, 100, o.points = 1, SP_EINVAL, "points 1");
    WRONG((sp_signal_method)99, 100, , SP_EINVAL, "method 99");
    WRONG(SP_SIGNAL_AUTO, 100, o.source = (sp_source)7, SP_EINVAL, "source 7");
    WRONG(SP_SIGNAL_AUTO, 100, o.damping = -0.1, SP_EINVAL, "damping -0.1");
    WRONG(SP_SIGNAL_AUTO, 100, o.damping = NAN, SP_EINVAL, "damping");
    WRONG(SP_SIGNAL_DENSE, 100, o.damping = 0.1, SP_EINVAL, "method dense");
    WRONG(SP_SIGNAL_CHEBYSHEV, 100, o.step = 0.1, SP_EINVAL, "step 0.1 chebyshev");
    WRONG(SP_SIGNAL_VERLET, 1e5, o.step = 1.71 / sp_network_omega_bound(&net), SP_EINVAL, "step");
    WRONG(SP_SIGNAL_VERLET, 1e5, o.step = 1e-9, SP_EINVAL, "1e9");
    /* more than double can give, and more than anybody waits for */
    for (int method = SP_SIGNAL_CHEBYSHEV; method <= SP_SIGNAL_DENSE; method++)
        WRONG((sp_signal_method)method, 100, o.tolerance = 1e-16, SP_EREFUSED, "1e-16");
    WRONG(SP_SIGNAL_FABER, 10, (o.damping = 0.1, o.tolerance = 1e-16), SP_EREFUSED, "1e-16");
    WRONG(SP_SIGNAL_VERLET, 1e5, o.tolerance = 1e-14, SP_EREFUSED, "tolerance");
    WRONG(SP_SIGNAL_CHEBYSHEV, 1e12, , SP_EREFUSED, "until 1e+12 20000000");
    WRONG(SP_SIGNAL_FABER, 1e9, o.damping = 0.1, SP_EREFUSED, "until 1e+09 2e+07");
    /* a spring that pushes: motion grows */
    net.springs[0].kn *= -1;
    WRONG(SP_SIGNAL_FABER, 300, (o.damping = 0.1, o.tolerance = 1e-8), SP_EREFUSED, "");
    net.prestress = true;
    WRONG(SP_SIGNAL_VERLET, 100, o.tolerance = 1e-3, SP_EREFUSED, "");
    sp_network_free(&net);
    sp_packing_free(&p);
    p = scattered_packing(2, 6, 0, 1); /* prestress alone acts sideways */
    net = network_of(&p, true);
    WRONG(SP_SIGNAL_CHEBYSHEV, 200, , SP_EREFUSED, "");
#undef WRONG
    assert_null(s.f);
    sp_network_free(&net);
    sp_packing_free(&p);
}

/* Every allocation of every method fails once. */
TEST(test_no_memory) {
    static const sp_place planes[] = {{.kind = SP_PLACE_PLANE, .height = 1}, {.kind = SP_PLACE_PLANE, .height = 2}};
    FREED(sp_packing) p = scattered_packing(2, 6, 0.5, 1);
    FREED(sp_network) net = network_of(&p, false);
    for (int method = SP_SIGNAL_CHEBYSHEV; method <= SP_SIGNAL_FABER; method++) {
        sp_signal_options o = options_of((sp_signal_method)method, SP_SOURCE_IMPULSE, 30, 11);
        o.to = planes;
        o.detectors = 2;
        o.front = method == SP_SIGNAL_CHEBYSHEV;
        o.damping = method == SP_SIGNAL_FABER ? 0.2 : 0;
        o.tolerance = method == SP_SIGNAL_VERLET || method == SP_SIGNAL_LAX_WENDROFF ? 1e-2 : o.tolerance;
        lacks_memory(NULL, &net, &o, 8);
    }
}

/* Long times on a small network are cheaper by modes; both agree. */
TEST(test_auto) {
    FREED(sp_packing) p = chain_packing(5, 1e-4);
    FREED(sp_network) net = network_of(&p, false);
    FREED(sp_signal) a = signal_of(&net, options_of(SP_SIGNAL_AUTO, SP_SOURCE_IMPULSE, 20000, 301));
    FREED(sp_signal) b = signal_of(&net, options_of(SP_SIGNAL_CHEBYSHEV, SP_SOURCE_IMPULSE, 20000, 301));
    assert_int_equal(a.method, SP_SIGNAL_DENSE);
    assert_close(difference(a.n, a.f, b.f), 0, a.error + b.error);
    assert_true(b.products > 5000 && a.products == 0);
}

RUN_TESTS(NULL, NULL)
