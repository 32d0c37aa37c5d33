/* Time stepping of the linear motion: bounds, orders, reciprocity, refusals. */
#include "base/base.h"
#include "extended.h"
#include "signals.h"

#include <sonopack/signal.h>

enum { SCHEMES = 2, POINTS = 33 };
static const sp_signal_method schemes[SCHEMES] = {SP_SIGNAL_VERLET, SP_SIGNAL_LAX_WENDROFF};

static sp_signal_options options_of(sp_signal_method method, sp_source source, double until, double tolerance) {
    sp_signal_options o = sp_signal_options_default();
    o.method = method;
    o.source = source;
    o.until = until;
    o.points = POINTS;
    o.tolerance = tolerance;
    return o;
}

static void exact_signal(const sp_network *net, sp_source source, double until, double *exact) {
    double t[POINTS];
    for (int k = 0; k < POINTS; k++)
        t[k] = k < POINTS - 1 ? until * k / (POINTS - 1) : until;
    extended_signal(net, source, POINTS, t, exact);
}

/* The true error, by long double, stays below the bound, and the bound below what was asked for. */
static void check_bound(const char *name, const sp_network *net, double until, double tolerance) {
    double exact[POINTS];
    for (int source = 0; source < 3; source++) {
        exact_signal(net, (sp_source)source, until, exact);
        for (int q = 0; q < SCHEMES; q++) {
            const sp_signal_options o =
                options_of(schemes[q], (sp_source)source, until, q ? tolerance : 1e2 * tolerance);
            FREED(sp_signal) s = sp_signal_none();
            assert_ok(sp_signal_make(net, &o, &s, &err));
            const double error = difference(POINTS, s.f, exact);
            if (!(error <= s.error))
                fail_msg("%s: %s source %d until %g: error %g above its bound %g", name,
                         sp_signal_method_name(o.method), source, until, error, s.error);
            assert_true(s.error <= o.tolerance * fmax(peak_of(POINTS, exact), 1e-5));
            assert_true(s.products > 0 && s.step * (POINTS - 1) <= until * (1 + 1e-12));
        }
    }
}

TEST(test_error_bound) {
    const struct {
        const char *name;
        sp_packing p;
        bool prestress;
    } all[] = {{"one ball", chain_packing(1, 1e-4), false},
               {"chain", chain_packing(12, 1e-4), false},
               {"2D", scattered_packing(2, 5, 0.5, 1), false},
               {"2D without friction", scattered_packing(2, 5, 0, 2), false},
               {"3D", scattered_packing(3, 3, 0.5, 3), false},
               {"reference", without_tangential(reference_packing(REFERENCE("packing_N200_p1e-4.txt"))), true}};
    for (size_t q = 0; q < sizeof all / sizeof *all; q++) {
        FREED(sp_packing) p = all[q].p;
        FREED(sp_network) net = network_of(&p, all[q].prestress);
        check_bound(all[q].name, &net, 0.3, 1e-5);
        check_bound(all[q].name, &net, 40, 1e-7);
    }
}

/* Rounding: ten thousands of steps, where the scheme itself is right to a few 1e-13. */
TEST(test_rounding) {
    FREED(sp_packing) p = chain_packing(6, 1e-4);
    FREED(sp_network) net = network_of(&p, false);
    double exact[POINTS];
    exact_signal(&net, SP_SOURCE_IMPULSE, 100, exact);
    sp_signal_options o = options_of(SP_SIGNAL_LAX_WENDROFF, SP_SOURCE_IMPULSE, 100, 1e-10);
    for (double step = 0.02; step > 5e-4; step /= 4) {
        FREED(sp_signal) s = sp_signal_none();
        o.step = step;
        assert_ok(sp_signal_make(&net, &o, &s, &err));
        assert_true(difference(POINTS, s.f, exact) <= s.error);
        if (step < 2e-3)
            assert_close(difference(POINTS, s.f, exact), 0, 3e-13 * peak_of(POINTS, exact));
    }
}

/* Errors fall as the second and the fourth power of the step. */
TEST(test_order) {
    FREED(sp_packing) p = scattered_packing(2, 5, 0.5, 7);
    FREED(sp_network) net = network_of(&p, false);
    for (int source = 0; source < 3; source += 2) {
        double exact[POINTS];
        exact_signal(&net, (sp_source)source, 30, exact);
        for (int q = 0; q < SCHEMES; q++) {
            double error[4];
            for (int k = 0; k < 4; k++) {
                sp_signal_options o = options_of(schemes[q], (sp_source)source, 30, 1e-3);
                FREED(sp_signal) s = sp_signal_none();
                o.step = 30.0 / (POINTS - 1) / (16 << k);
                assert_ok(sp_signal_make(&net, &o, &s, &err));
                assert_relative(s.step, o.step, 1e-12);
                error[k] = difference(POINTS, s.f, exact);
                assert_true(error[k] <= s.error);
            }
            for (int k = 1; k < 4; k++) /* leading error, the next one is some (h Omega)^2 of it */
                assert_close(log2(error[k - 1] / error[k]), q == 0 ? 2 : 4, 0.05);
        }
    }
}

/* Many sources and one detector are followed from the detector's end; the signals are those of Chebyshev. */
TEST(test_places) {
    FREED(sp_packing) p = reference_packing(REFERENCE("packing_N200_p1e-4.txt"));
    FREED(sp_network) net = network_of(&p, false);
    const sp_place from[] = {
        {.kind = SP_PLACE_WALL}, {.kind = SP_PLACE_WALL, .shear = true}, {.kind = SP_PLACE_PART, .from = 3, .to = 11}};
    const sp_place to[] = {{.kind = SP_PLACE_PLANE, .height = 4}, {.kind = SP_PLACE_WALL}};
    for (int sources = 1; sources <= 3; sources += 2)
        for (int source = 0; source < 3; source += 2) {
            sp_signal_options o = options_of(SP_SIGNAL_CHEBYSHEV, (sp_source)source, 50, 1e-6);
            FREED(sp_signal) one = sp_signal_none(), two = sp_signal_none();
            o.from = from;
            o.sources = sources;
            o.to = to;
            o.detectors = 2;
            assert_ok(sp_signal_make(&net, &o, &one, &err));
            o.method = SP_SIGNAL_LAX_WENDROFF;
            assert_ok(sp_signal_make(&net, &o, &two, &err));
            for (int q = 0; q < sources * 2; q++)
                assert_true(difference(POINTS, one.f + q * POINTS, two.f + q * POINTS) <=
                            two.errors[q] + one.errors[q]);
        }
}

RUN_TESTS(NULL, NULL)
