/* The symbols of (35) and (37) as printed, of the expansion behind them, and of the long wave. */
#include "test.h"

#include <sonopack/tapped/tapped.h>

/* [B]'s ten particles: h = 2, K/m = 20 g, g = 980.67. */
static sp_tapped_spec ten(void) {
    sp_tapped_spec c = sp_tapped_spec_default();
    c.particles = 10;
    c.frequency = 9.5;
    return c;
}

static sp_tapped_symbol symbol(const sp_tapped_spec *c, sp_tapped_model model, double slope, double k) {
    sp_tapped_symbol s = {NAN, NAN};
    assert_ok(sp_tapped_symbol_at(c, model, 0.5, slope, k, &s, &err));
    return s;
}

/* At alpha = 1/h, slope 1: C = 5/6 + 1/3 + h^2 = 31/6 and A- = 6.5; the fastest grows at 3 C sqrt(K/(m A-)), some 850
 * /s, where k^2 = 18 C/(A- h^2). */
TEST(test_37_grows) {
    const sp_tapped_spec c = ten();
    const double k = sqrt(18 * 31 / 6.0 / 6.5 / 4), top = 15.5 * sqrt(20 * 980.67 / 6.5);
    assert_close(top, 850, 5);
    assert_relative(symbol(&c, SP_TAPPED_EQ37, 1, k).growth, top, 1e-12);
    for (double other = 0.05; other < 10; other *= 1.3)
        assert_true(symbol(&c, SP_TAPPED_EQ37, 1, other).growth <= top);
    assert_close(symbol(&c, SP_TAPPED_EQ37, 1, 1.5 * k).growth, 0, 0); /* beyond sqrt(2) of it: waves */
}

/* Twice k, four times the growth, far enough out; long waves do not grow. */
TEST(test_35_grows_without_bound) {
    const sp_tapped_spec c = ten();
    assert_close(symbol(&c, SP_TAPPED_EQ35, 1, 1).growth, 0, 0);
    for (double k = 1e3; k < 1e6; k *= 10) {
        double growth = symbol(&c, SP_TAPPED_EQ35, 1, k).growth;
        assert_relative(symbol(&c, SP_TAPPED_EQ35, 1, 2 * k).growth, 4 * growth, 1e-4);
        assert_relative(growth, 4 * sqrt(20 * 980.67 * 6.5) / 6 * k * k, 1e-4); /* h^2 sqrt(K A-/m)/6 k^2 */
    }
}

/* (35) by finite differences: its right-hand side, written out with all terms, applied to s z + epsilon cos k z. */
TEST(test_35_is_the_linearised_right_hand_side) {
    const sp_tapped_spec c = ten();
    const double h = 2, kh2m = 20 * 980.67 * 4;
    for (double alpha = 0.2; alpha < 1; alpha += 0.25)
        for (double slope = 0.5; slope < 1.3; slope += 0.25)
            for (double k = 0.3; k < 2; k *= 2) {
                const double plus = 1.5 + 6 * alpha + 8 * -2 * pow(alpha, 3), b = alpha + 4 * -2 * pow(alpha, 3),
                             minus = 1.5 + 6 * alpha - 8 * -2 * pow(alpha, 3), tiny = 1e-6, z = 0.4;
                const double y1 = slope - tiny * k * sin(k * z), y2 = -tiny * k * k * cos(k * z), y4 = -k * k * y2;
                const double right =
                    kh2m * (plus / 3 * y2 - h / 3 * b * y1 * y2 + h * h * (minus / 36 * y4 + 2 * alpha * y1 * y1 * y2));
                sp_tapped_symbol s;
                assert_ok(sp_tapped_symbol_at(&c, SP_TAPPED_EQ35, alpha, slope, k, &s, &err));
                assert_relative(-s.speed2 * k * k, right / (tiny * cos(k * z)), 1e-4);
                assert_ok(sp_tapped_symbol_at(&c, SP_TAPPED_EQ37, alpha, slope, k, &s, &err));
                assert_relative(s.speed2 * k * k, right / (tiny * cos(k * z)), 1e-4);
            }
}

/* What (35) is meant to expand is phi(X) = X chi(X) about X = 2 r. With chi = 1/2 + (alpha X - (alpha X)^3/3)/2, all
 * that (36) has of (30), phi is a polynomial of the fourth order and its derivative at X = 2 r - Dy exact: -1/6 at Dy =
 * h and alpha = 1/h, where all of (30) has 1/2. */
TEST(test_expansion_has_the_wrong_sign) {
    const sp_tapped_spec c = ten();
    const double kh2m = 20 * 980.67 * 4;
    assert_relative(sp_tapped_expansion_speed2(&c, 0.5, 1), -kh2m / 6, 1e-12);
    for (double alpha = 0.1; alpha < 0.8; alpha += 0.2) {
        const double x = 2, d1 = 0.5 + alpha * x - 2 * pow(alpha * x, 3) / 3, d2 = alpha - 2 * pow(alpha, 3) * x * x,
                     d3 = -4 * pow(alpha, 3) * x;
        for (double slope = 0.2; slope < 1.2; slope += 0.3) {
            const double dy = 2 * slope;
            assert_relative(sp_tapped_expansion_speed2(&c, alpha, slope), kh2m * (d1 - d2 * dy + 0.5 * d3 * dy * dy),
                            1e-11);
        }
    }
}

/* omega^2 (1 + h^2 k^2/12) = c^2 k^2 without e; always damped with it; nothing where contacts are open. */
TEST(test_longwave_is_well_posed) {
    sp_tapped_spec c = ten();
    const double k_over_m = 20 * 980.67;
    c.e = 0;
    for (double k = 1e-3; k < 1e4; k *= 3) {
        sp_tapped_symbol s = symbol(&c, SP_TAPPED_LONGWAVE, 0.9, k);
        assert_close(s.growth, 0, 0);
        assert_relative(s.speed2, k_over_m * 4 / (1 + k * k / 3), 1e-13);
        assert_true(s.speed2 * k * k < 12 * k_over_m);
    }
    c.e = 0.09;
    for (double k = 1e-2; k < 1e4; k *= 3)
        for (double alpha = 1e-3; alpha < 1e3; alpha *= 10) {
            c.alpha_v = alpha;
            sp_tapped_symbol s = symbol(&c, SP_TAPPED_LONGWAVE, 0.9, k);
            const double inertia = 1 + k * k / 3, damping = k_over_m * 0.09 * alpha * 0.2 * 4 * k * k / inertia,
                         stiffness = k_over_m * 4 * k * k / inertia;
            assert_true(s.growth < 0);
            const double omega2 = s.speed2 * k * k; /* lambda = growth + i omega solves the quadratic */
            assert_close(s.growth * s.growth - omega2 + damping * s.growth + stiffness, 0,
                         1e-12 * fmax(stiffness, damping * damping));
        }
    assert_close(symbol(&c, SP_TAPPED_LONGWAVE, 1.1, 1).speed2, 0, 0);
}

static sp_status no_row(double t, const double *y, const double *v, void *user, sp_error *err) {
    (void)t;
    (void)y;
    (void)v;
    (void)err;
    ++*(int *)user;
    return SP_OK;
}

TEST(test_refused) {
    sp_tapped_spec c = ten();
    const double t = 0;
    int rows = 0;
    c.model = SP_TAPPED_EQ37;
    assert_fails(sp_tapped_run(&c, 1, &t, no_row, &rows, NULL, &err), SP_EREFUSED, "851.4");
    assert_fails(sp_tapped_run(&c, 1, &t, no_row, &rows, NULL, &err), SP_EREFUSED, "280.1");
    assert_fails(sp_tapped_run(&c, 1, &t, no_row, &rows, NULL, &err), SP_EREFUSED, "-0.167");
    c.model = SP_TAPPED_EQ35;
    assert_fails(sp_tapped_run(&c, 1, &t, no_row, &rows, NULL, &err), SP_EREFUSED, "column.model eq35");
    assert_int_equal(rows, 0);
    sp_tapped_symbol s;
    assert_fails(sp_tapped_symbol_at(&c, SP_TAPPED_BSR, 0.5, 1, 1, &s, &err), SP_EINVAL, "symbol");
    assert_fails(sp_tapped_symbol_at(&c, SP_TAPPED_EQ35, 0.5, 1, 0, &s, &err), SP_EINVAL, "k 0");
    assert_fails(sp_tapped_symbol_at(&c, SP_TAPPED_EQ35, 0.5, NAN, 1, &s, &err), SP_EINVAL, "slope nan");
}

RUN_TESTS(NULL, NULL)
