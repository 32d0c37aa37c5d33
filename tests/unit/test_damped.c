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
    FREED(sp_packing) p = chain_packing(2, 1e-4);
    FREED(sp_network) net = network_of(&p, false);
    const double m = net.mass[0], k = net.springs[0].kn;
    for (int source = 0; source < 3; source += 2)
        for (double zeta = 1e-4; zeta < 6; zeta *= 6.1) {
            const sp_signal_options o = options_of((sp_source)source, zeta, 40, POINTS);
            const double c = 2 * zeta * sqrt(m * k), start = source ? k : k / m;
            double exact[POINTS];
            FREED(sp_signal) s = sp_signal_none();
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
        }
}

/* Without dashpots the expansion is Chebyshev's; with few of them the difference is proportional to zeta. */
TEST(test_weak) {
    enum { POINTS = 101 };
    FREED(sp_packing) p = reference_packing(REFERENCE("packing_N200_p1e-4.txt"));
    FREED(sp_network) net = network_of(&p, false);
    sp_signal_options o = options_of(SP_SOURCE_IMPULSE, 0, 200, POINTS);
    const sp_place to[] = {{.kind = SP_PLACE_WALL}, {.kind = SP_PLACE_PLANE, .height = 5, .shear = true}};
    FREED(sp_signal) none = sp_signal_none(), weak = sp_signal_none(), weaker = sp_signal_none();
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
}

RUN_TESTS(NULL, NULL)
