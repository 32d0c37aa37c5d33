/* Sums over the lowest modes: never further from the whole signal than their bound. */
#include "base/base.h"
#include "signals.h"

#include <sonopack/signal.h>

static sp_network kept_network(sp_packing p) {
    const sp_network_options o = sp_network_options_default();
    sp_network net = sp_network_none();
    assert_ok(sp_network_make(&p, &o, &net, &err));
    sp_packing_free(&p);
    return net;
}

static sp_signal signal_of(const sp_network *net, const sp_signal_options *o) {
    sp_signal s = sp_signal_none();
    assert_ok(sp_signal_make(net, o, &s, &err));
    return s;
}

/* Every pair of places, several numbers of modes: the error is within its bound, and the bound is no idle one. */
static void check(const sp_network *net, sp_source source, double until, const sp_place *from, const sp_place *to) {
    sp_signal_options o = sp_signal_options_default();
    o.source = source;
    o.until = until; /* long enough for all to arrive */
    o.points = 301;
    o.sources = o.detectors = 2;
    o.from = from;
    o.to = to;
    o.method = SP_SIGNAL_CHEBYSHEV;
    o.tolerance = 1e-9;
    FREED(sp_signal) whole = signal_of(net, &o);
    const int64_t counts[] = {5, 40, 160, sp_network_dofs(net)};
    double before = HUGE_VAL;
    o.method = SP_SIGNAL_SPARSE;
    for (int q = 0; q < 4; q++) {
        o.modes = counts[q];
        FREED(sp_signal) s = signal_of(net, &o);
        assert_int_equal(s.modes, counts[q]);
        assert_int_equal(s.method, SP_SIGNAL_SPARSE);
        for (int pair = 0; pair < 4; pair++) {
            double worst = 0, peak = 0;
            for (int l = 0; l < s.n; l++) {
                worst = fmax(worst, fabs(s.f[pair * s.n + l] - whole.f[pair * s.n + l]));
                peak = fmax(peak, fabs(whole.f[pair * s.n + l]));
            }
            assert_close(worst, 0, s.errors[pair] + whole.errors[pair]);
            if (q == 3)
                assert_true(s.errors[pair] < 1e-8 * peak);
            else
                assert_close(s.errors[pair], 0, 100 * worst);
        }
        assert_true(s.error < before);
        before = s.error;
    }
}

TEST(test_bound) {
    for (int shape = 0; shape < 3; shape++) {
        FREED(sp_network)
        net = kept_network(shape == 0   ? reference_packing(REFERENCE("packing_N200_p1e-4.txt"))
                           : shape == 1 ? scattered_packing(3, 5, 0.5, 3)
                                        : chain_packing(450, 1e-4));
        sp_place from[] = {sp_place_wall(), sp_place_wall()}, to[] = {sp_place_wall(), sp_place_wall()};
        from[1].kind = to[1].kind = SP_PLACE_GRAIN;
        from[1].grain = net.grain[3];
        to[1].grain = net.grain[net.n / 2];
        for (int source = 0; source < 3; source++)
            check(&net, (sp_source)source, shape == 2 ? 3000 : 150, from, to);
    }
}

/* By itself as many modes as the tolerance needs; here all. */
TEST(test_tolerance) {
    FREED(sp_network) net = kept_network(reference_packing(REFERENCE("packing_N200_p1e-4.txt")));
    sp_signal_options o = sp_signal_options_default();
    o.until = 100;
    o.points = 101;
    FREED(sp_signal) exact = signal_of(&net, &o);
    o.method = SP_SIGNAL_SPARSE;
    sp_signal s = signal_of(&net, &o);
    assert_int_equal(s.modes, sp_network_dofs(&net));
    for (int l = 0; l < s.n; l++)
        assert_close(s.f[l], exact.f[l], s.error + exact.error);
    sp_signal_free(&s);
    o.tolerance = 0.9;
    s = signal_of(&net, &o);
    double peak = 0;
    for (int l = 0; l < s.n; l++)
        peak = fmax(peak, fabs(s.f[l]));
    assert_true(s.error <= 0.9 * peak);
    for (int l = 0; l < s.n; l++)
        assert_close(s.f[l], exact.f[l], s.error + exact.error);
    sp_signal_free(&s);
    o.modes = 3;
    o.method = SP_SIGNAL_CHEBYSHEV;
    assert_fails(sp_signal_make(&net, &o, &s, &err), SP_EINVAL, "0");
    o.method = SP_SIGNAL_SPARSE;
    o.modes = sp_network_dofs(&net) + 1;
    assert_fails(sp_signal_make(&net, &o, &s, &err), SP_EINVAL, "1");
    sp_network_free(&net);
    /* more than the dense solver takes: told what is cheaper */
    net = kept_network(chain_packing(20100, 1e-4));
    o.modes = 0;
    o.tolerance = 1e-6;
    assert_fails(sp_signal_make(&net, &o, &s, &err), SP_EREFUSED, "chebyshev");
}

TEST(test_no_memory) {
    FREED(sp_network) net = kept_network(chain_packing(420, 1e-4));
    sp_signal_options o = sp_signal_options_default();
    o.until = 10;
    o.points = 11;
    o.method = SP_SIGNAL_SPARSE;
    o.modes = 3;
    lacks_memory(NULL, &net, &o, 30);
}

RUN_TESTS(NULL, NULL)
