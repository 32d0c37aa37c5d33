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
        sp_packing p = reference_packing(packings[q]);
        sp_network net = network_of(&p, false);
        assert_int_equal(n, 801);
        for (int source = 0; source < 2; source++)
            for (int method = SP_SIGNAL_AUTO; method <= (q == 0 ? SP_SIGNAL_DENSE : SP_SIGNAL_CHEBYSHEV); method++) {
                const double *exact = source == SP_SOURCE_IMPULSE ? impulse : velocity, peak = peak_of(n, exact);
                sp_signal s = signal_of(&net, options_of((sp_signal_method)method, (sp_source)source, t[n - 1], n));
                for (int k = 0; k < n; k++)
                    assert_close(s.t[k], t[k], 1e-12);
                assert_close(difference(n, s.f, exact), 0, 5e-13 * peak);
                assert_close(s.error, 0, 1e-11 * peak);
                assert_int_equal(s.method, method == SP_SIGNAL_DENSE ? SP_SIGNAL_DENSE : SP_SIGNAL_CHEBYSHEV);
                sp_signal_free(&s);
            }
        sp_network_free(&net);
        sp_packing_free(&p);
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
            sp_signal s = sp_signal_none();
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
            sp_signal_free(&s);
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
        sp_packing p = all[q].p;
        sp_network net = network_of(&p, all[q].prestress);
        for (size_t k = 0; k < (q < 7 ? 5 : 4); k++)
            check_bound(all[q].name, &net, spans[k], 41);
        sp_network_free(&net);
        sp_packing_free(&p);
    }
}

/* Before anything can have arrived F is 0 beyond doubt, and afterwards small values are right relative to themselves:
 * no floor of rounding. */
TEST(test_early) {
    sp_packing p = chain_packing(20, 1e-4);
    sp_network net = network_of(&p, false);
    sp_signal s = signal_of(&net, options_of(SP_SIGNAL_CHEBYSHEV, SP_SOURCE_IMPULSE, 60, 61));
    const double m = net.mass[0], k = net.springs[0].kn;
    assert_true(s.f[0] == 0);
    /* first term of the power series in t, through 19 springs: F = k (k/m) (k/m)^19 t^39/39! */
    double first = k * (k / m), t = s.t[1];
    for (int q = 1; q < 20; q++)
        first *= k / m * t / (2 * q) * t / (2 * q + 1);
    first *= t;
    assert_relative(s.f[1], first, 0.01);
    assert_true(first < 1e-30);
    sp_signal_free(&s);
    sp_network_free(&net);
    sp_packing_free(&p);
}

static sp_signal plain_signal(const sp_packing *p) {
    sp_network net = network_of(p, false);
    sp_signal s = signal_of(&net, options_of(SP_SIGNAL_CHEBYSHEV, SP_SOURCE_IMPULSE, 200, 101));
    sp_network_free(&net);
    return s;
}

/* Grain i becomes grain n-1-i; the whole is shifted sideways; x is reflected; the packing is turned upside down, where
 * the signal of an impulse is the same by reciprocity (K is symmetric). */
static void transform(sp_packing *p, int which) {
    const double height = p->box[1];
    if (which == 0)
        for (int i = 0; i < p->n / 2; i++) {
            const int j = p->n - 1 - i;
            for (int a = 0; a < 3; a++) {
                const double x = p->x[3 * i + a];
                p->x[3 * i + a] = p->x[3 * j + a];
                p->x[3 * j + a] = x;
            }
            const double r = p->r[i];
            p->r[i] = p->r[j];
            p->r[j] = r;
        }
    for (int i = 0; i < p->n && which > 0; i++) {
        double *x = p->x + 3 * i;
        x[0] = which == 1 ? fmod(x[0] + 7.3, p->box[0]) : which == 2 ? p->box[0] - x[0] : x[0];
        x[1] = which == 3 ? height - x[1] : x[1];
    }
    for (int k = 0; k < p->n_contacts; k++) {
        sp_contact *c = &p->contacts[k];
        if (which == 0) {
            c->i = p->n - 1 - c->i;
            c->j = c->j < 0 ? c->j : p->n - 1 - c->j;
            if (c->j >= 0) { /* i < j again */
                const int i = c->i;
                c->i = c->j;
                c->j = i;
                for (int a = 0; a < 2; a++)
                    c->n[a] = -c->n[a];
            }
        }
        if (which == 2)
            c->n[0] = -c->n[0];
        if (which == 3) {
            c->n[1] = -c->n[1];
            c->j = c->j == SP_BOTTOM ? SP_TOP : c->j == SP_TOP ? SP_BOTTOM : c->j;
        }
    }
    sp_packing_sort(p);
}

TEST(test_invariance) {
    sp_packing p = reference_packing(REFERENCE("packing_N200_p1e-4.txt"));
    sp_signal s = plain_signal(&p);
    const double peak = peak_of(s.n, s.f);
    for (int which = 0; which < 4; which++) {
        sp_packing q = reference_packing(REFERENCE("packing_N200_p1e-4.txt"));
        transform(&q, which);
        sp_signal other = plain_signal(&q);
        assert_close(difference(s.n, s.f, other.f), 0, s.error + other.error);
        assert_true(s.error < 1e-12 * peak);
        sp_signal_free(&other);
        sp_packing_free(&q);
    }
    sp_packing_free(&p);
    p = reference_packing(REFERENCE("packing_N200_p1e-4.txt"));
    p.contacts[100].overlap *= 1.001; /* the comparison can tell */
    sp_signal other = plain_signal(&p);
    assert_true(difference(s.n, s.f, other.f) > 1e-6 * peak);
    sp_signal_free(&other);
    sp_signal_free(&s);
    sp_packing_free(&p);
}

/* A displacement's signal is the derivative of that of the same velocities: with momenta m u, d/dt of sin(wt)/w. */
TEST(test_sources) {
    sp_packing p = reference_packing(REFERENCE("packing_N200_p1e-4.txt"));
    sp_network net = network_of(&p, false);
    double errors[2];
    for (int q = 0; q < 2; q++) { /* centred differences on two grids: second order */
        const int n = 2001 << q;
        sp_signal v = signal_of(&net, options_of(SP_SIGNAL_CHEBYSHEV, SP_SOURCE_VELOCITY, 200, n + 1 - (n + 1) % 2));
        sp_signal u = signal_of(&net, options_of(SP_SIGNAL_CHEBYSHEV, SP_SOURCE_DISPLACEMENT, 200, v.n));
        errors[q] = 0;
        for (int k = 1; k + 1 < v.n; k++)
            errors[q] = fmax(errors[q], fabs((v.f[k + 1] - v.f[k - 1]) / (v.t[k + 1] - v.t[k - 1]) - u.f[k]));
        errors[q] /= peak_of(u.n, u.f);
        sp_signal_free(&u);
        sp_signal_free(&v);
    }
    assert_true(errors[0] < 1e-2);
    assert_close(log2(errors[0] / errors[1]), 2, 0.1);
    sp_network_free(&net);
    sp_packing_free(&p);
}

TEST(test_window) {
    assert_relative(sp_signal_window(24, 1e-4), 232.0, 1e-15);
    assert_relative(sp_signal_window(24, 1e-7), 232 * sqrt(10), 1e-14);
}

TEST(test_refusals) {
    sp_packing p = chain_packing(30, 1e-4);
    sp_network net = network_of(&p, false);
    const sp_signal_options good = options_of(SP_SIGNAL_AUTO, SP_SOURCE_IMPULSE, 100, 51);
    sp_signal s = sp_signal_none();
    const double untils[] = {0, -1, NAN, INFINITY}, tolerances[] = {0, -1, NAN, 1, INFINITY};
    for (size_t k = 0; k < sizeof untils / sizeof *untils; k++) {
        sp_signal_options o = good;
        o.until = untils[k];
        assert_fails(sp_signal_make(&net, &o, &s, &err), SP_EINVAL, "until");
    }
    for (size_t k = 0; k < sizeof tolerances / sizeof *tolerances; k++) {
        sp_signal_options o = good;
        o.tolerance = tolerances[k];
        assert_fails(sp_signal_make(&net, &o, &s, &err), SP_EINVAL, "tolerance");
    }
    sp_signal_options o = good;
    o.points = 1;
    assert_fails(sp_signal_make(&net, &o, &s, &err), SP_EINVAL, "points 1");
    o = good;
    o.method = (sp_signal_method)99;
    assert_fails(sp_signal_make(&net, &o, &s, &err), SP_EINVAL, "method 99");
    o = good;
    o.source = (sp_source)7;
    assert_fails(sp_signal_make(&net, &o, &s, &err), SP_EINVAL, "source 7");
    for (int method = SP_SIGNAL_CHEBYSHEV; method <= SP_SIGNAL_DENSE; method++) {
        o = good;
        o.method = (sp_signal_method)method;
        o.tolerance = 1e-16; /* more than double can give */
        assert_fails(sp_signal_make(&net, &o, &s, &err), SP_EREFUSED, "1e-16");
    }
    o = good;
    o.method = SP_SIGNAL_CHEBYSHEV;
    o.until = 1e12;
    assert_fails(sp_signal_make(&net, &o, &s, &err), SP_EREFUSED, "until 1e+12 20000000");
    assert_null(s.f);
    sp_network_free(&net);
    sp_packing_free(&p);
    p = scattered_packing(2, 6, 0, 1); /* prestress alone acts sideways: motion grows */
    net = network_of(&p, true);
    o = options_of(SP_SIGNAL_CHEBYSHEV, SP_SOURCE_IMPULSE, 200, 51);
    assert_fails(sp_signal_make(&net, &o, &s, &err), SP_EREFUSED, "");
    sp_network_free(&net);
    sp_packing_free(&p);
}

TEST(test_no_memory) {
    sp_packing p = chain_packing(10, 1e-4);
    sp_network net = network_of(&p, false);
    for (int method = SP_SIGNAL_CHEBYSHEV; method <= SP_SIGNAL_DENSE; method++) {
        const sp_signal_options o = options_of((sp_signal_method)method, SP_SOURCE_IMPULSE, 30, 11);
        lacks_memory(NULL, &net, &o, 10);
    }
    sp_network_free(&net);
    sp_packing_free(&p);
}

/* Long times on a small network are cheaper by modes; both agree. */
TEST(test_auto) {
    sp_packing p = chain_packing(5, 1e-4);
    sp_network net = network_of(&p, false);
    sp_signal a = signal_of(&net, options_of(SP_SIGNAL_AUTO, SP_SOURCE_IMPULSE, 20000, 301));
    sp_signal b = signal_of(&net, options_of(SP_SIGNAL_CHEBYSHEV, SP_SOURCE_IMPULSE, 20000, 301));
    assert_int_equal(a.method, SP_SIGNAL_DENSE);
    assert_close(difference(a.n, a.f, b.f), 0, a.error + b.error);
    assert_true(b.products > 5000 && a.products == 0);
    sp_signal_free(&a);
    sp_signal_free(&b);
    sp_network_free(&net);
    sp_packing_free(&p);
}

RUN_TESTS(NULL, NULL)
