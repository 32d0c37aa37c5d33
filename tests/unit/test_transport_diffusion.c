/* The diffusivity of energy in two independent ways, and where it must not be given. */
#include "cells.h"
#include "signals.h"

#include <sonopack/transport.h>

static sp_modes modes_of(const sp_network *net) {
    const sp_modes_options o = sp_modes_options_default();
    sp_modes m = sp_modes_none();
    assert_ok(sp_modes_dense(net, &o, &m, &err));
    return m;
}

/* Means over packings of the diffusivity in both ways: the energy of random motions spreads as the eigenmodes say. In
 * cells of 15 diameters in the plane modes are not quite extended, and energy spreads by some 20% more slowly
 * (docs/transport.md). */
TEST(test_two_ways) {
    SKIP_SANITIZED();
    enum { PACKINGS = 4 };
    double spread = 0, squares = 0, kubo = 0;
    for (unsigned seed = 1; seed <= PACKINGS; seed++) {
        FREED(sp_packing) p = cells_packing(SP_CELL_PERIODIC, 2, 300, 0.9, NULL, 0, seed);
        FREED(sp_network) net = network_of(&p, false);
        FREED(sp_modes) modes = modes_of(&net);
        const double omega = 0.35 * modes.omega[modes.n - 1];
        double mean = 0;
        sp_kubo_options ko = sp_kubo_options_default();
        sp_spread_options so = sp_spread_options_default();
        sp_kubo k;
        assert_ok(sp_kubo_make(&net, &modes, 1, &omega, &ko, &k, &err));
        for (so.axis = 0; so.axis < 2; so.axis++) {
            sp_spread s;
            assert_ok(sp_spread_make(&net, omega, &so, &s, &err));
            assert_true(s.drift < 1e-10);
            assert_true(s.d > 0 && s.d_err > 0 && s.to > s.from);
            mean += 0.5 * s.d;
        }
        assert_true(k.d_err > 0 && k.d_err < 0.3 * k.d);
        spread += mean / PACKINGS;
        squares += mean * mean / PACKINGS;
        kubo += k.d / PACKINGS;
    }
    const double error = sqrt((squares - spread * spread) / (PACKINGS - 1));
    assert_true(error < 0.2 * spread);
    assert_true(spread > 0.5 * kubo - 2 * error && spread < 1.1 * kubo + 2 * error);
}

/* The spread of energy in a lattice is ballistic: no diffusivity from either way. The speed is that of the groups: in
 * the square lattice of smooth grains half of the modes move along y, with omega = w sin(k a/2). */
TEST(test_lattice) {
    enum { ROWS = 40 };
    FREED(sp_packing) p = cells_square(6, ROWS, 0, 1e-3, 0);
    FREED(sp_network) net = network_of(&p, false);
    FREED(sp_modes) modes = modes_of(&net);
    sp_kubo_options ko = sp_kubo_options_default();
    const sp_spread_options so = sp_spread_options_default();
    const double a = net.length[0], top = 2 * sqrt(net.springs[0].kn / net.mass[0]);
    for (double part = 0.3; part < 0.8; part += 0.2) {
        const double omega = part * top;
        double squares = 0, weights = 0;
        sp_kubo k;
        sp_spread s;
        for (int q = 1; q < ROWS; q++) { /* u_y */
            const double w = top * sin(M_PI * q / ROWS), v = 0.5 * top * a * cos(M_PI * q / ROWS);
            const double g = 6 * exp(-0.5 * (w / omega - 1) * (w / omega - 1) / (ko.width * ko.width));
            squares += g * v * v;
            weights += g;
        }
        for (int q = 1; q < 6; q++) /* u_x, which nothing moves along y */
            weights += ROWS * exp(-0.5 * pow((top * sin(M_PI * q / 6) / omega - 1) / ko.width, 2));
        ko.axis = 1;
        assert_ok(sp_kubo_make(&net, &modes, 1, &omega, &ko, &k, &err));
        assert_true(isnan(k.d) && isnan(k.d_err) && isnan(k.d_shift));
        assert_relative(k.speed, sqrt(2 * squares / weights), 0.1); /* a part of the modes */
        assert_ok(sp_spread_make(&net, omega, &so, &s, &err));
        assert_true(isnan(s.d) && isnan(s.d_err) && isnan(s.d_shift));
    }
}

/* A triangular lattice whose grains are lighter or heavier by a part. */
static sp_network two_masses(int columns, int rows, double part, unsigned random) {
    FREED(sp_packing) p = cells_triangular(columns, rows, 0.01, 0);
    sp_network net = network_of(&p, false);
    for (int32_t i = 0; i < net.n; i++) {
        const double factor = (random = 1664525 * random + 1013904223) >> 31 ? 1 + part : 1 - part;
        for (int a = 0; a < net.dof; a++)
            net.mass[i * net.dof + a] *= factor;
    }
    net.omega_bound /= sqrt(1 - part);
    return net;
}

/* Masses that differ a little scatter little: a wide delta cuts the motion off before it is scattered, and the error of
 * D says how much is missing. */
TEST(test_shift) {
    SKIP_SANITIZED();
    FREED(sp_network) net = two_masses(24, 24, 0.35, 1);
    FREED(sp_modes) modes = modes_of(&net);
    for (int part = 4; part < 7; part++) {
        const double omega = 0.1 * part * modes.omega[modes.n - 1];
        sp_kubo_options o = sp_kubo_options_default();
        sp_kubo wide, narrow;
        o.smear = part == 4 ? 0.05 : 0.1;
        assert_ok(sp_kubo_make(&net, &modes, 1, &omega, &o, &wide, &err));
        o.smear *= 0.25;
        assert_ok(sp_kubo_make(&net, &modes, 1, &omega, &o, &narrow, &err));
        const double off = fabs(wide.d - narrow.d), shift = SP_KUBO_SHIFTS * wide.d_shift;
        assert_true(off < wide.d_err && wide.d_err < 0.5 * wide.d);
        assert_true(sqrt(wide.d_err * wide.d_err - shift * shift) <
                    0.5 * off); /* what the modes scatter is not enough */
    }
}

/* A strip that energy almost crosses before it is scattered: what random motions scatter by is a small part of the
 * error of D, and longer strips agree within the whole of it. */
TEST(test_strips) {
    SKIP_SANITIZED();
    sp_spread crossed, scattered, longer;
    sp_spread_options o = sp_spread_options_default();
    o.axis = 1;
    FREED(sp_network) net = two_masses(24, 48, 0.25, 7919), more = two_masses(24, 96, 0.25, 7919);
    const double omega = 0.9 * net.omega_bound;
    assert_ok(sp_spread_make(&net, 0.4 * omega, &o, &crossed, &err));
    assert_ok(sp_spread_make(&net, 0.5 * omega, &o, &scattered, &err));
    assert_ok(sp_spread_make(&more, 0.4 * omega, &o, &longer, &err));
    assert_true(fabs(crossed.d_half) > 0.2 * crossed.d && crossed.d_err > 2 * fabs(crossed.d_half));
    assert_true(crossed.d_err < hypot(2 * crossed.d_half, 0.15 * crossed.d));
    assert_true(scattered.d_err < 0.2 * scattered.d && longer.d_err < crossed.d_err);
    assert_close(longer.d, crossed.d, crossed.d_err);
}

TEST(test_bad_input) {
    FREED(sp_packing) p = reference_packing(SOURCE_DIR "/packings/reference/packing_N200_p1e-4.txt");
    FREED(sp_network) net = network_of(&p, false), turning = network_of(&p, true);
    sp_modes modes = modes_of(&net), none = sp_modes_none();
    const sp_spread_options so = sp_spread_options_default();
    const sp_split_options po = sp_split_options_default();
    const sp_kubo_options ko = sp_kubo_options_default();
    const double good = 0.3, bad = NAN;
    sp_spread s;
    sp_split l;
    sp_kubo k;
    assert_fails(sp_spread_make(&net, NAN, &so, &s, &err), SP_EINVAL, "nan");
    assert_fails(sp_spread_make(&net, 50, &so, &s, &err), SP_EREFUSED, "50");
    assert_fails(sp_spread_make(&turning, good, &so, &s, &err), SP_EREFUSED, "");
    assert_fails(sp_split_make(&net, -1, &po, &l, &err), SP_EINVAL, "-1");
    assert_fails(sp_split_make(&net, 50, &po, &l, &err), SP_EREFUSED, "50");
    assert_fails(sp_split_make(&turning, good, &po, &l, &err), SP_EREFUSED, "");
    assert_fails(sp_kubo_make(&net, &modes, 1, &bad, &ko, &k, &err), SP_EINVAL, "nan");
    assert_fails(sp_kubo_make(&net, &none, 1, &good, &ko, &k, &err), SP_EINVAL, "modes");
#define WRONG(kind, change, status, words, ...)                                                                        \
    do {                                                                                                               \
        sp_##kind##_options o = sp_##kind##_options_default();                                                         \
        change;                                                                                                        \
        assert_fails(sp_##kind##_make(&net, __VA_ARGS__, &err), status, words);                                        \
    } while (0)
    WRONG(spread, o.axis = 2, SP_EINVAL, "2", good, &o, &s);
    WRONG(spread, o.sources = 1, SP_EINVAL, "1", good, &o, &s);
    WRONG(spread, o.width = 0.7, SP_EINVAL, "0.7", good, &o, &s);
    WRONG(spread, o.waves = 0, SP_EINVAL, "0", good, &o, &s);
    WRONG(split, o.sources = 1, SP_EINVAL, "1", good, &o, &l);
    WRONG(split, o.width = 0, SP_EINVAL, "0", good, &o, &l);
    WRONG(split, o.from = NAN, SP_EINVAL, "nan", good, &o, &l);
    WRONG(kubo, o.axis = 1, SP_EREFUSED, "1", &modes, 1, &good, &o, &k);
    WRONG(kubo, o.axis = 5, SP_EINVAL, "5", &modes, 1, &good, &o, &k);
    WRONG(kubo, o.smear = 0, SP_EINVAL, "0", &modes, 1, &good, &o, &k);
#undef WRONG
    sp_modes_free(&modes);
}

RUN_TESTS(NULL, NULL)
