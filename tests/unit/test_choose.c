#include "reference.h"
#include "signal/job.h"

#include <sonopack/modes.h>

static sp_network network_of(sp_packing *p) {
    const sp_network_options o = sp_network_options_default();
    sp_network net = sp_network_none();
    assert_ok(sp_network_make(p, &o, &net, &err));
    sp_packing_free(p);
    return net;
}

static sp_signal_options options_of(const sp_network *net, double length, int32_t points) {
    sp_signal_options o = sp_signal_options_default();
    o.until = length / sp_network_omega_bound(net);
    o.points = points;
    o.tolerance = 1e-6;
    return o;
}

static sp_signal_method first_choice(const sp_network *net, const sp_signal_options *o) {
    sp_signal_method choice[SIGNAL_CHOICES];
    assert_true(sp_signal_choose(net, o, choice) >= 1);
    return choice[0];
}

/* The number of products that the cost stands for is that of the run, for one pair and for many. */
TEST(test_products) {
    sp_packing p = scattered_packing(2, 8, 0.5, 1);
    FREED(sp_network) net = network_of(&p);
    const double lengths[] = {50, 500, 5000};
    for (int k = 0; k < 3; k++)
        for (int many = 0; many < 2; many++) {
            sp_place at[4];
            FREED(sp_signal) s;
            sp_signal_options o = options_of(&net, lengths[k], 11);
            o.method = SP_SIGNAL_CHEBYSHEV;
            for (int q = 0; q < 4; q++)
                at[q] = (sp_place){.kind = SP_PLACE_GRAIN, .grain = 10 * q};
            if (many) {
                o.sources = o.detectors = 4;
                o.from = o.to = at;
            }
            assert_ok(sp_signal_make(&net, &o, &s, &err));
            /* the terms end where Bessel functions do, a few of their widths (Omega T)^(1/3) beyond Omega T */
            const double terms = lengths[k] / 2, width = cbrt(lengths[k]);
            assert_true(s.products >= (many ? 4 : 1) * terms);
            assert_true(s.products <= (many ? 4 : 1) * (terms + 7 * width + 8));
        }
}

/* By counts of operations alone, which leave room for a factor of four: the choice is not much worse than the other. */
static double operations(sp_signal_method method, const sp_network *net, const sp_signal_options *o) {
    const double n = (double)sp_network_dofs(net), x = sp_network_omega_bound(net) * o->until;
    if (method == SP_SIGNAL_CHEBYSHEV)
        return x / 4 * (40.0 * net->n_springs + 5 * n) + 2.0 * o->points * x / 2;
    return 9 * n * n * n / 4 + 60.0 * n * o->points; /* LAPACK's count for all vectors, at four a nanosecond; sines */
}

TEST(test_choice) {
    const int cells[] = {2, 4, 8, 16};
    int dense = 0, chebyshev = 0;
    for (int k = 0; k < 4; k++) {
        sp_packing p = scattered_packing(2, cells[k], 0.5, 1);
        FREED(sp_network) net = network_of(&p);
        for (double length = 10; length < 2e8; length *= 10) {
            const sp_signal_options o = options_of(&net, length, 801);
            const sp_signal_method method = first_choice(&net, &o);
            const double one = operations(SP_SIGNAL_CHEBYSHEV, &net, &o), all = operations(SP_SIGNAL_DENSE, &net, &o);
            assert_true(method == SP_SIGNAL_CHEBYSHEV || method == SP_SIGNAL_DENSE);
            if (method == SP_SIGNAL_DENSE)
                assert_true(all < 8 * one);
            else
                assert_true(one < 8 * all + 1e6); /* below a millisecond anything does */
            dense += method == SP_SIGNAL_DENSE;
            chebyshev += method == SP_SIGNAL_CHEBYSHEV;
        }
    }
    assert_true(dense >= 10 && chebyshev >= 10);
}

/* A modal sum vouches for nothing so early, and yet a small network is served: by the next method. */
TEST(test_next_choice) {
    sp_packing p = chain_packing(40, 1e-4);
    FREED(sp_network) net = network_of(&p);
    sp_signal_options o = options_of(&net, 3, 200000); /* so many times that modes are cheaper */
    FREED(sp_signal) s;
    o.tolerance = 1e-8;
    o.method = SP_SIGNAL_DENSE;
    assert_fails(sp_signal_make(&net, &o, &s, &err), SP_EREFUSED, "1e-08");
    o.method = SP_SIGNAL_AUTO;
    assert_ok(sp_signal_make(&net, &o, &s, &err));
    assert_int_equal(s.method, SP_SIGNAL_CHEBYSHEV);
}

RUN_TESTS(NULL, NULL)
