/* The damped linear motion: closed forms, a long double reference, bounds, limits. */
#include "base/base.h"
#include "extended.h"
#include "signals.h"

#include <complex.h>
#undef I
#include <sonopack/signal.h>

static sp_signal_options options_of(sp_source source, double damping, double until, int points) {
    sp_signal_options o = sp_signal_options_default();
    o.method = SP_SIGNAL_FABER;
    o.source = source;
    o.damping = damping;
    o.until = until;
    o.points = points;
    return o;
}

/* u and its velocity for u'' + 2 d u' + w2 u = 0 from u0, v0. */
static void oscillator(double d, double w2, double u0, double v0, double t, double *u, double *v) {
    const double complex root = csqrt(d * d - w2), plus = -d + root, minus = -d - root;
    const double complex a = (v0 - minus * u0) / (plus - minus), b = (plus * u0 - v0) / (plus - minus);
    *u = creal(a * cexp(plus * t) + b * cexp(minus * t));
    *v = creal(a * plus * cexp(plus * t) + b * minus * cexp(minus * t));
}

/* Two equal balls between walls that answer like balls: the sum of the two feels the walls' springs k and dashpots
 * c = 2 zeta sqrt(m k), the difference also twice those between the balls, k and c/sqrt(2). */
TEST(test_two_balls) {
    enum { POINTS = 60 };
    sp_packing p = chain_packing(2, 1e-4);
    sp_network net = network_of(&p, false);
    const double m = net.mass[0], k = net.springs[0].kn;
    for (int source = 0; source < 3; source += 2)
        for (double zeta = 1e-4; zeta < 6; zeta *= 6.1) {
            const sp_signal_options o = options_of((sp_source)source, zeta, 40, POINTS);
            const double c = 2 * zeta * sqrt(m * k), start = source ? k : k / m;
            double exact[POINTS];
            sp_signal s = sp_signal_none();
            assert_ok(sp_signal_make(&net, &o, &s, &err));
            for (int l = 0; l < POINTS; l++) {
                double us, vs, ud, vd;
                const double u0 = source ? start : 0, v0 = source ? 0 : start;
                oscillator(0.5 * c / m, k / m, u0, v0, s.t[l], &us, &vs);
                oscillator(0.5 * (c + sqrt(2) * c) / m, 3 * k / m, u0, v0, s.t[l], &ud, &vd);
                exact[l] = 0.5 * (k * (us - ud) + c * (vs - vd));
            }
            const double error = difference(POINTS, s.f, exact);
            assert_true(error <= s.error);
            assert_close(error, 0, 1e-13 * fmax(peak_of(POINTS, exact), 1e-3 * k * start));
            assert_int_equal(s.method, SP_SIGNAL_FABER);
            sp_signal_free(&s);
        }
    sp_network_free(&net);
    sp_packing_free(&p);
}

/* Power series of exp(h L) in long double, row by row. */
static void extended_damped(const sp_network *net, const sp_network *dashpots, sp_source source, int points,
                            double until, double *f) {
    const size_t n = (size_t)sp_network_dofs(net);
    const double omega = sp_network_omega_bound(net), rate = pow(sp_network_omega_bound(dashpots), 2);
    const int each = 1 + (int)ceil(until / (points - 1) * (omega + rate));
    const extended h = (extended)until / (points - 1) / each;
    extended *y = calloc(8 * n, sizeof *y), *term = y + 2 * n, *next = y + 4 * n, *ku = y + 6 * n, *cv = y + 7 * n;
    double *sent = calloc(3 * n, sizeof *sent), *seen = sent + n, *dash = sent + 2 * n;
    assert_ok(sp_network_source(net, source, sent, &err));
    assert_ok(sp_network_detector(net, seen, &err));
    assert_ok(sp_network_detector(dashpots, dash, &err));
    for (size_t k = 0; k < n; k++)
        if (source == SP_SOURCE_DISPLACEMENT)
            y[k] = sent[k];
        else
            y[n + k] = sent[k] / (extended)net->mass[k];
    for (int l = 0; l < points; l++) {
        for (int step = 0; step < (l > 0 ? each : 0); step++) {
            memcpy(term, y, 2 * n * sizeof *y);
            for (int q = 1; q < 27; q++) {
                extended_apply(net, term, ku);
                extended_apply(dashpots, term + n, cv);
                for (size_t k = 0; k < n; k++) {
                    next[k] = h / q * term[n + k];
                    next[n + k] = -h / q * (ku[k] + cv[k]) / net->mass[k];
                }
                for (size_t k = 0; k < 2 * n; k++)
                    y[k] += term[k] = next[k];
            }
        }
        extended sum = 0;
        for (size_t k = 0; k < n; k++)
            sum += seen[k] * y[k] + dash[k] * y[n + k];
        f[l] = (double)sum;
    }
    free(sent);
    free(y);
}

static void check_bound(const char *name, const sp_network *net, double zeta, double until) {
    enum { POINTS = 21 };
    sp_network dashpots = sp_network_none();
    assert_ok(sp_network_damping(net, zeta, &dashpots, &err));
    for (int source = 0; source < 3; source++) {
        double exact[POINTS];
        sp_signal s = sp_signal_none();
        sp_signal_options o = options_of((sp_source)source, zeta, until, POINTS);
        o.tolerance = 1e-7;
        extended_damped(net, &dashpots, (sp_source)source, POINTS, until, exact);
        assert_ok(sp_signal_make(net, &o, &s, &err));
        const double error = difference(POINTS, s.f, exact), peak = peak_of(POINTS, exact);
        if (!(error <= s.error))
            fail_msg("%s: source %d zeta %g until %g: error %g above its bound %g (peak %g)", name, source, zeta, until,
                     error, s.error, peak);
        if (peak > 1e-5)
            assert_close(error, 0, 1e-11 * peak);
        sp_signal_free(&s);
    }
    sp_network_free(&dashpots);
}

TEST(test_error_bound) {
    const double damping[] = {1e-6, 0.05, 0.4, 5};
    const struct {
        const char *name;
        sp_packing p;
        bool prestress;
    } all[] = {{"one ball", chain_packing(1, 1e-4), false},
               {"chain", chain_packing(7, 1e-4), false},
               {"2D", scattered_packing(2, 4, 0.5, 1), false},
               {"2D without friction", scattered_packing(2, 4, 0, 2), false},
               {"3D", scattered_packing(3, 3, 0.5, 3), false},
               {"reference", without_tangential(reference_packing(REFERENCE("packing_N200_p1e-4.txt"))), true}};
    for (size_t q = 0; q < sizeof all / sizeof *all; q++) {
        sp_packing p = all[q].p;
        sp_network net = network_of(&p, all[q].prestress);
        for (size_t k = q < 5 ? 0 : 2; k < (q < 5 ? sizeof damping / sizeof *damping : 3); k++) {
            if (q < 5)
                check_bound(all[q].name, &net, damping[k], 0.5);
            check_bound(all[q].name, &net, damping[k], q < 2 ? 150 : q < 5 ? 2.5 : 1);
        }
        sp_network_free(&net);
        sp_packing_free(&p);
    }
}

/* Springs from 1 to 1e-8 of each other: slow and fast, weakly and strongly damped modes at once. */
TEST(test_spread) {
    sp_packing p = chain_packing(6, 1e-4);
    for (int q = 0; q < 3; q++) {
        sp_network net = network_of(&p, false);
        for (int k = 0; k < net.n_springs; k++)
            net.springs[k].kn *= pow(10, q == 0 ? -(k * 5 % 7) : q == 1 ? -1.3 * k : k == 3 ? -8 : 0);
        for (double zeta = 1e-3; zeta < 9; zeta *= 20)
            check_bound("spread", &net, zeta, 400);
        sp_network_free(&net);
    }
    sp_packing_free(&p);
}

/* Without dashpots the expansion is Chebyshev's; with few of them the difference is proportional to zeta. */
TEST(test_weak) {
    enum { POINTS = 101 };
    sp_packing p = reference_packing(REFERENCE("packing_N200_p1e-4.txt"));
    sp_network net = network_of(&p, false);
    sp_signal_options o = options_of(SP_SOURCE_IMPULSE, 0, 200, POINTS);
    const sp_place to[] = {{.kind = SP_PLACE_WALL}, {.kind = SP_PLACE_PLANE, .height = 5, .shear = true}};
    sp_signal none = sp_signal_none(), weak = sp_signal_none(), weaker = sp_signal_none();
    o.to = to;
    o.detectors = 2;
    assert_ok(sp_signal_make(&net, &o, &weak, &err));
    o.method = SP_SIGNAL_CHEBYSHEV;
    assert_ok(sp_signal_make(&net, &o, &none, &err));
    assert_true(difference(2 * POINTS, none.f, weak.f) <= none.error + weak.error);
    sp_signal_free(&weak);
    o.method = SP_SIGNAL_AUTO;
    o.damping = 1e-4;
    assert_ok(sp_signal_make(&net, &o, &weak, &err));
    o.damping = 1e-5;
    assert_ok(sp_signal_make(&net, &o, &weaker, &err));
    for (int b = 0; b < 2; b++) {
        const double one = difference(POINTS, none.f + b * POINTS, weak.f + b * POINTS),
                     two = difference(POINTS, none.f + b * POINTS, weaker.f + b * POINTS);
        assert_close(log10(one / two), 1, 0.02);
    }
    sp_signal_free(&none);
    sp_signal_free(&weak);
    sp_signal_free(&weaker);
    sp_network_free(&net);
    sp_packing_free(&p);
}

TEST(test_refusals) {
    sp_packing p = chain_packing(10, 1e-4);
    sp_network net = network_of(&p, false);
    sp_signal s = sp_signal_none();
    sp_signal_options o = options_of(SP_SOURCE_IMPULSE, -0.1, 10, 5);
    assert_fails(sp_signal_make(&net, &o, &s, &err), SP_EINVAL, "damping -0.1");
    o.damping = NAN;
    assert_fails(sp_signal_make(&net, &o, &s, &err), SP_EINVAL, "damping");
    o.damping = 0.1;
    o.method = SP_SIGNAL_DENSE;
    assert_fails(sp_signal_make(&net, &o, &s, &err), SP_EINVAL, "method dense");
    o = options_of(SP_SOURCE_IMPULSE, 0.1, 1e9, 5);
    assert_fails(sp_signal_make(&net, &o, &s, &err), SP_EREFUSED, "until 1e+09 2e+07");
    o = options_of(SP_SOURCE_IMPULSE, 0.1, 10, 5);
    o.tolerance = 1e-16;
    assert_fails(sp_signal_make(&net, &o, &s, &err), SP_EREFUSED, "1e-16");
    o.tolerance = 1e-8;
    o.until = 300;
    for (int k = 0; k < net.n_springs; k++) /* springs that push, dashpots that damp */
        net.springs[k].kp = 0;
    net.springs[0].kn *= -1;
    assert_fails(sp_signal_make(&net, &o, &s, &err), SP_EREFUSED, "nan 1e-08");
    assert_true(s.f == NULL);
    sp_network_free(&net);
    sp_packing_free(&p);
}

TEST(test_memory) {
    sp_packing p = chain_packing(10, 1e-4);
    sp_network net = network_of(&p, false);
    const sp_signal_options o = options_of(SP_SOURCE_IMPULSE, 0.2, 10, 5);
    lacks_memory(NULL, &net, &o, 10);
    sp_network_free(&net);
    sp_packing_free(&p);
}

RUN_TESTS(NULL, NULL)
