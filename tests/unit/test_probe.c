/* The probes of Appendix B of Somfai et al. 2005. */
#include "base/base.h"
#include "making.h"
#include "reference.h"

#include <sonopack/elastic.h>

static const double PI = 3.14159265358979323846;

static sp_probe_moduli probe_of(const sp_network *net, sp_probe_kind kind, int n) {
    const sp_probe probe = {kind, n};
    sp_probe_moduli out;
    assert_ok(sp_moduli_probe(net, 0.5, 1, &probe, NULL, &out, &err));
    return out;
}

/* N equal balls evenly between the walls: the sine is an eigenvector of N + 1 equal springs, with 4 k sin^2(n pi/(2(N +
 * 1))); lines leave every spring stretched alike. The sums that take part are of 25 terms. */
TEST(test_chain) {
    enum { N = 23 };
    FREED(sp_packing) p = chain_packing(N, 1e-4);
    FREED(sp_network) net = default_network(&p);
    const double height = net.box[0], k = net.springs[0].kn;
    for (int i = 0; i < N; i++)
        net.x[3 * i] = height * (i + 1) / (N + 1);
    for (int n = 1; n <= 11; n++) {
        const sp_probe_moduli got = probe_of(&net, SP_PROBE_SINE, n);
        const double s = sin(n * PI / (2 * (N + 1))), force = 4 * PI / 3 * 0.125 / 0.5;
        const double energy = 0.5 * force * force * (N + 1) / 2 / (4 * k * s * s);
        const double c = height * height * height / (4 * n * n * PI * PI * energy);
        assert_relative(got.along, c, 1e-11);
        assert_true(isnan(got.shear) && isnan(got.error_shear));
        assert_close(got.along, c, got.error_along);
        assert_true(got.error_along < 1e-11 * c && got.left_out == 0);
    }
    for (int n = 1; n <= 5; n += 2) { /* (n + 1) lines apart by whole numbers of balls: 24 is divided by 2, 4 and 6 */
        const sp_probe_moduli got = probe_of(&net, SP_PROBE_LINES, n);
        assert_relative(got.along, k * height / (N + 1), 1e-12);
        assert_close(got.along, k * height / (N + 1), got.error_along);
    }
}

/* In an ordered packing the apparent moduli of long waves are the global ones: what the walls and the lattice take off
 * falls as one over the height. */
TEST(test_lattice) {
    double off[2][4];
    for (int high = 0; high < 2; high++) {
        sp_pack_spec spec = sp_pack_spec_default();
        spec.kind = SP_PACK_TRIANGULAR;
        spec.width = 6;
        spec.grains = high ? 6 * 80 : 6 * 40;
        spec.pressure = 1e-6;
        FREED(sp_packing) p = make_packing(&spec);
        FREED(sp_network) net = default_network(&p);
        const sp_probe probe[] = {{SP_PROBE_SINE, 1}, {SP_PROBE_LINES, 1}};
        sp_probe_moduli got[2];
        sp_moduli m;
        sp_statics s;
        assert_ok(sp_statics_make(&p, 1e-4, 3, &s, &err));
        assert_ok(sp_moduli_probe(&net, s.phi3s, 2, probe, &m, got, &err));
        for (int k = 0; k < 2; k++) {
            off[high][2 * k] = fabs(got[k].along / m.c22 - 1);
            off[high][2 * k + 1] = fabs(got[k].shear / m.c33 - 1);
            assert_true(off[high][2 * k] < 0.1 && off[high][2 * k + 1] < 0.1);
        }
    }
    for (int q = 0; q < 4; q++) /* halved to a tenth, or rounding of positions */
        assert_true(off[1][q] < 0.55 * off[0][q] || off[1][q] < 1e-6);
}

/* Fixing grains can only stiffen; each probe alone is each probe among others, and the global moduli are those of
 * sp_moduli_make. */
TEST(test_together) {
    FREED(sp_packing) p = reference_packing(REFERENCE("packing_N600_p1e-4.txt"));
    FREED(sp_network) net = default_network(&p);
    const sp_probe probe[] = {{SP_PROBE_SINE, 1}, {SP_PROBE_SINE, 2}, {SP_PROBE_LINES, 1}, {SP_PROBE_LINES, 3}};
    sp_probe_moduli all[4];
    sp_moduli m, alone;
    assert_ok(sp_moduli_probe(&net, 0.5, 4, probe, &m, all, &err));
    assert_ok(sp_moduli_make(&net, 0.5, &alone, &err));
    assert_true(m.c11 == alone.c11 && m.c22 == alone.c22 && m.c33 == alone.c33 && m.residual == alone.residual);
    for (int k = 0; k < 4; k++) {
        const sp_probe_moduli one = probe_of(&net, probe[k].kind, probe[k].n);
        assert_true(one.along == all[k].along && one.shear == all[k].shear);
        /* Tables IV and V at p = 1e-4: the largest deviation of a mean from 1 is 0.37, four deviations of a sample 0.4
         */
        assert_close(one.along / m.c22, 1, 0.3);
        assert_close(one.shear / m.c33, 1, 0.8);
        assert_true(one.error_along < 1e-9 * one.along && one.error_shear < 1e-9 * one.shear);
        assert_true(one.concentrated < 0.1 && one.left_out == 0);
    }
    assert_true(all[3].along > all[2].along && all[3].shear > all[2].shear); /* held lines 2 of 3 are among 1 of 1 */
}

/* Walls that do not grip: the cosine has a modulus to give, lines have none. The cosine's is near the sine's between
 * walls that do. */
TEST(test_smooth) {
    FREED(sp_packing) p = scattered_packing(2, 16, 0.5, 1);
    FREED(sp_network) net = default_network(&p);
    const sp_probe_moduli rough = probe_of(&net, SP_PROBE_SINE, 2);
    for (int k = 0; k < net.n_springs; k++)
        if (net.springs[k].j < 0)
            net.springs[k].kt = 0;
    const sp_probe_moduli sine = probe_of(&net, SP_PROBE_SINE, 2), lines = probe_of(&net, SP_PROBE_LINES, 1);
    assert_true(sine.error_shear < 1e-9 * sine.shear);
    assert_close(sine.shear / rough.shear, 1, 0.15);
    assert_close(sine.along / rough.along, 1, 0.05);
    assert_true(lines.along > 0 && isnan(lines.shear));
    for (int k = 0; k < net.n_springs; k++) /* one wall */
        if (net.springs[k].j == SP_TOP)
            net.springs[k].kt = net.springs[k].kn;
    const sp_probe_moduli half = probe_of(&net, SP_PROBE_SINE, 1);
    assert_true(half.along > 0 && isnan(half.shear));
}

enum { LOOSE = 136 };

/* A grain that hangs on one spring: the body force across it has no answer and is left out, what remains is that of a
 * packing in which the grain rests on the spring alone. A grain that is nearly so takes most of the energy. */
TEST(test_loose) {
    FREED(sp_packing) p = scattered_packing(2, 16, 0.5, 1);
    FREED(sp_network) net = default_network(&p);
    const sp_probe_moduli whole = probe_of(&net, SP_PROBE_SINE, 1);
    int springs = 0;
    for (int k = 0; k < net.n_springs; k++) {
        sp_spring *s = &net.springs[k];
        if (s->i == LOOSE || s->j == LOOSE) {
            s->kt = 0;
            s->kn = springs++ == 0 ? s->kn : 0;
        }
    }
    const sp_probe_moduli loose = probe_of(&net, SP_PROBE_SINE, 1);
    assert_true(loose.left_out > 1e-4 && loose.left_out < 0.02 && loose.concentrated < 0.2);
    assert_close(loose.along / whole.along, 1, 0.3);
    assert_close(loose.shear / whole.shear, 1, 0.3);
    for (int k = 0; k < net.n_springs; k++)
        if (net.springs[k].i == LOOSE || net.springs[k].j == LOOSE)
            net.springs[k].kt = 1e-5 * net.springs[0].kn;
    const sp_probe_moduli hung = probe_of(&net, SP_PROBE_SINE, 1);
    assert_true(hung.left_out == 0 && hung.concentrated > 0.8 && hung.grain == LOOSE);
    for (int k = 0; k < net.n_springs; k++) /* half of all */
        if (net.springs[k].i % 2 == 0 || (net.springs[k].j >= 0 && net.springs[k].j % 2 == 0))
            net.springs[k].kt = net.springs[k].kn = net.springs[k].i % 2 ? 0 : 1e-30;
    sp_probe_moduli out;
    const sp_probe probe = {SP_PROBE_SINE, 1};
    sp_error refused = {0};
    assert_int_equal(sp_moduli_probe(&net, 0.5, 1, &probe, NULL, &out, &refused), SP_EREFUSED);
}

TEST(test_space) {
    for (int smooth = 0; smooth < 2; smooth++) {
        FREED(sp_packing) p = scattered_packing(3, 6, smooth ? 0 : 0.5, 1);
        FREED(sp_network) net = default_network(&p);
        const sp_probe probe[] = {{SP_PROBE_SINE, 1}, {SP_PROBE_LINES, 1}};
        sp_probe_moduli got[2];
        sp_moduli m;
        assert_ok(sp_moduli_probe(&net, 0.6, 2, probe, &m, got, &err));
        if (!smooth) { /* smooth grains in such places are nearly loose */
            assert_close(got[0].along / m.c33, 1, 0.4);
            assert_close(got[1].along / m.c33, 1, 0.2); /* no spring inside the displaced layer is stretched */
        }
        assert_true(got[0].shear > 0);
        assert_true(smooth ? isnan(got[1].shear) && got[0].along > 0 : fabs(got[1].shear / m.c55 - 1) < 0.2);
    }
}

TEST(test_refusals) {
    FREED(sp_packing) p = scattered_packing(2, 8, 0.5, 1);
    sp_network net = default_network(&p);
    sp_probe_moduli out[2];
    sp_moduli m;
    const sp_probe zero = {SP_PROBE_SINE, 0}, even = {SP_PROBE_LINES, 2}, fine = {SP_PROBE_SINE, 8},
                   close = {SP_PROBE_LINES, 7}, odd = {(sp_probe_kind)7, 1}, good = {SP_PROBE_SINE, 1};
    assert_fails(sp_moduli_probe(&net, 0.5, 1, &zero, NULL, out, &err), SP_EINVAL, "1");
    assert_fails(sp_moduli_probe(&net, 0.5, 1, &even, NULL, out, &err), SP_EINVAL, "lines:2");
    assert_fails(sp_moduli_probe(&net, 0.5, 1, &odd, NULL, out, &err), SP_EINVAL, "sine lines");
    assert_fails(sp_moduli_probe(&net, 0.5, -1, &good, NULL, out, &err), SP_EINVAL, "0");
    assert_fails(sp_moduli_probe(&net, 0.5, 1, &fine, NULL, out, &err), SP_EREFUSED, "sine:7");
    assert_fails(sp_moduli_probe(&net, 0.5, 1, &close, NULL, out, &err), SP_EREFUSED, "lines:7 lines:5");
    assert_fails(sp_moduli_probe(&net, NAN, 1, &good, NULL, out, &err), SP_EREFUSED, "Phi3*");
    for (int i = 0; i < net.n; i++) /* a gap in the middle, where line 1 is */
        net.x[3 * i + 1] += net.x[3 * i + 1] > 0.5 * net.box[1] ? 0.6 : -0.6;
    const sp_probe line = {SP_PROBE_LINES, 1};
    assert_fails(sp_moduli_probe(&net, 0.5, 1, &line, NULL, out, &err), SP_EREFUSED, "lines:1 1 3.6");
    sp_network_free(&net);
    net = default_network(&p);
    net.r[30] = 2;
    const sp_probe three = {SP_PROBE_LINES, 3};
    assert_fails(sp_moduli_probe(&net, 0.5, 1, &three, NULL, out, &err), SP_EREFUSED, "30");
    sp_network_free(&net);
    net = default_network(&p);
    net.n_springs = net.n_bulk;
    assert_fails(sp_moduli_probe(&net, 0.5, 1, &good, NULL, out, &err), SP_EREFUSED, "");
    sp_network_free(&net);
    net = default_network(&p);
    const sp_probe both[] = {{SP_PROBE_LINES, 1}, {SP_PROBE_SINE, 2}};
    assert_ok(sp_moduli_probe(&net, NAN, 1, both, NULL, out, &err)); /* lines need no density */
    assert_ok(sp_moduli_probe(&net, NAN, 0, NULL, &m, NULL, &err));
    EACH_ALLOCATION_FAILS(15, sp_moduli_probe(&net, 0.5, 2, both, &m, out, &err), (void)0);
    sp_network_free(&net);
}

RUN_TESTS(NULL, NULL)
