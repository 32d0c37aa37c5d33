/* Sums over many grains at the walls: N columns of one grain between two walls, all alike, so that rounding errors of
 * sums add up instead of cancelling. F = N k_0 k_1 sin(w t)/w or N k_0 k_1 cos(w t), w^2 = (k_0 + k_1)/m. */
#include "signals.h"

static const double bottom = 0.15008, top = 0.16968, mass = 0.3617;

static sp_packing columns_of(int n) {
    sp_packing all = copies_of(chain_packing(1, 1e-4), n);
    assert_ok(sp_packing_alloc_masses(&all, &err));
    for (int k = 0; k < n; k++)
        all.mass[k] = mass;
    for (int k = 0; k < all.n_contacts; k++)
        all.contacts[k].kn = all.contacts[k].kt = all.contacts[k].j == SP_BOTTOM ? bottom : top;
    return all;
}

/* Largest error of a signal of source 0 .. 2 over its bound. */
static double check(int n, sp_source source, const sp_signal *s) {
    const long double w = sqrtl(((long double)bottom + top) / mass);
    long double worst = 0;
    for (int l = 0; l < s->n; l++) {
        const long double wave = source == SP_SOURCE_DISPLACEMENT ? cosl(w * s->t[l]) : sinl(w * s->t[l]) / w;
        const long double exact =
            (long double)n * bottom * top * wave / (source == SP_SOURCE_IMPULSE ? (long double)mass : 1);
        worst = fmaxl(worst, fabsl(s->f[l] - exact));
    }
    return (double)(worst / s->error);
}

TEST(test_columns) {
    const sp_signal_method methods[] = {SP_SIGNAL_AUTO, SP_SIGNAL_CHEBYSHEV, SP_SIGNAL_FABER};
    for (int n = 10; n <= 20000; n = n < 1000 ? n * 10 : n * 20) {
        FREED(sp_packing) p = columns_of(n);
        FREED(sp_network) net = network_of(&p, false);
        for (int source = 0; source < 3; source++)
            for (int q = 0; q < 6; q++) {
                sp_signal_options o = sp_signal_options_default();
                FREED(sp_signal) s = sp_signal_none();
                o.source = (sp_source)source;
                o.method = methods[q % 3];
                o.until = q < 3 ? 3 : 100;
                o.points = 201;
                assert_ok(sp_signal_make(&net, &o, &s, &err));
                assert_true(check(n, o.source, &s) <= 1);
            }
    }
}

RUN_TESTS(NULL, NULL)
