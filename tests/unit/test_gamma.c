/* Dashpots with the same coefficient at every contact, and in proportion to mass: closed forms, the matrix of GranE,
 * the motion at small amplitudes. */
#include "base/base.h"
#include "carried.h"
#include "signals.h"

#include <complex.h>
#undef I
#include <sonopack/modes.h>
#include <sonopack/signal.h>
#include <sonopack/spectrum.h>

static double complex number(double re, double im) { return re + im * _Complex_I; }

/* Two balls between walls: the sum of their displacements feels one spring and one dashpot, the difference three, since
 * gamma is the same at walls and between the balls. lambda^2 + (s gamma/m) lambda + s k/m = 0, s = 1 and 3. */
TEST(test_two_balls) {
    const double factors[] = {1e-3, 0.1, 0.9};
    for (size_t q = 0; q < 3; q++) {
        FREED(sp_packing) p = chain_packing(2, 1e-4);
        FREED(sp_network) net = default_network(&p);
        FREED(sp_damped_modes) m = sp_damped_modes_none();
        const double k = net.springs[0].kn, mass = net.mass[0], gamma = factors[q] * sqrt(mass * k);
        const sp_damping law = {SP_DAMPING_GAMMA, gamma, 1};
        assert_ok(sp_damped_modes_with(&net, &law, SP_SOURCE_IMPULSE, &m, &err));
        assert_int_equal(m.n, 2);
        for (int s = 1; s <= 3; s += 2) {
            const double decay = 0.5 * s * gamma / mass, omega2 = s * k / mass;
            double quality, error;
            const int64_t row = s == 1 ? 0 : 1;
            assert_close(m.decay[row], decay, m.error[row]);
            assert_close(hypot(m.omega[row], m.decay[row]), sqrt(omega2), m.error[row]);
            sp_damped_modes_quality(&m, row, &quality, &error);
            assert_close(quality, sqrt(omega2) / (2 * decay), error);
            assert_true(error < 1e-10 * quality);
        }
    }
}

/* Waves in a chain: 2 (K + i omega gamma)(1 - cos q) = m omega^2 for gamma, and for mass with gamma = rate m/2. Long
 * waves: 1/Q = omega gamma/K, so that alpha rises with omega^2. */
TEST(test_chain) {
    enum { GRAINS = 60, FREQUENCIES = 6 };
    FREED(sp_packing) p = chain_packing(GRAINS, 1e-4);
    FREED(sp_network) net = default_network(&p);
    const double k = net.springs[0].kn, m = net.mass[0], top = 2 * sqrt(k / m), c = 0.02 * sqrt(m * k);
    double omega[FREQUENCIES];
    sp_harmonic_options o = sp_harmonic_options_default();
    for (int l = 0; l < FREQUENCIES; l++)
        omega[l] = top * (l == 0 ? 0.05 : l / (FREQUENCIES + 0.5));
    o.omega = omega;
    o.n = FREQUENCIES;
    o.planes = GRAINS - 1;
    for (int kind = SP_DAMPING_GAMMA; kind <= SP_DAMPING_MASS; kind++) {
        FREED(sp_harmonic) h = sp_harmonic_none();
        o.damping_kind = (sp_damping_kind)kind;
        o.damping = kind == SP_DAMPING_GAMMA ? c : c / (0.5 * m);
        /* the walls' dashpots differ for mass, but the waves inside do not know */
        assert_ok(sp_harmonic_make(&net, &o, &h, &err));
        const double step = h.height[1] - h.height[0];
        for (int l = 0; l < FREQUENCIES; l++) {
            const double complex wave = cacos(1 - m * omega[l] * omega[l] / (2 * number(k, omega[l] * c)));
            double quality, error;
            sp_wave_quality(h.fit[l].k, h.fit[l].k_err, h.fit[l].alpha, h.fit[l].alpha_err, &quality, &error);
            assert_close(h.fit[l].k * step, fabs(creal(wave)), 1e-9);
            assert_close(h.fit[l].alpha * step, fabs(cimag(wave)), 1e-9);
            assert_close(quality, fabs(creal(wave) / (2 * cimag(wave))), 1e-6 * quality);
            if (l == 0)
                assert_close(quality * omega[l] * c / k, 1, 2e-3);
        }
    }
}

static double pseudo(int64_t k) { return sin(1.3 * (double)k * (double)k + 0.7); }

/* Without friction the matrix is that of GranE, gamma times the Laplacian of the contacts in each direction: a grain
 * feels gamma times its velocity against that of each neighbour. Walls count as neighbours at rest. */
TEST(test_laplacian) {
    for (int dim = 2; dim <= 3; dim++) {
        FREED(sp_packing) p = scattered_packing(dim, 4, 0, 3);
        FREED(sp_network) net = default_network(&p), dashpots = sp_network_none();
        const sp_damping law = {SP_DAMPING_GAMMA, 0.3, 1};
        const size_t n = (size_t)sp_network_dofs(&net);
        RELEASED double *v = calloc(n, sizeof *v), *ours = calloc(n, sizeof *ours), *theirs = calloc(n, sizeof *theirs);
        assert_int_equal(net.dof, dim);
        for (size_t k = 0; k < n; k++)
            v[k] = pseudo((int64_t)k);
        assert_ok(sp_network_dashpots(&net, &law, &dashpots, &err));
        sp_network_apply(&dashpots, v, ours);
        for (int32_t k = 0; k < net.n_springs; k++)
            for (int a = 0; a < dim; a++) {
                const int64_t i = (int64_t)net.springs[k].i * dim + a, j = (int64_t)net.springs[k].j * dim + a;
                const double force = 0.3 * (v[i] - (net.springs[k].j >= 0 ? v[j] : 0));
                theirs[i] += force;
                if (net.springs[k].j >= 0)
                    theirs[j] -= force;
            }
        assert_close(difference((int)n, ours, theirs), 0, 1e-13);
    }
}

/* The motion of the packing itself approaches the linear signal in proportion to the amplitude, for every kind. */
TEST(test_motion) {
    enum { POINTS = 21 };
    const double amplitudes[] = {1e-2, 1e-3, 1e-4};
    for (int q = 0; q < 6; q++) {
        FREED(sp_packing) p = scattered_packing(q / 2 == 2 ? 3 : 2, q / 2 == 2 ? 3 : 4, q / 2 ? 0.5 : 0, 5);
        FREED(sp_network) net = carried_network(&p);
        sp_signal_options o = sp_signal_options_default();
        FREED(sp_signal) linear = sp_signal_none();
        double differ[3];
        o.until = 3;
        o.points = POINTS;
        o.damping_kind = q % 2 ? SP_DAMPING_GAMMA : SP_DAMPING_MASS;
        o.damping = 0.3;
        o.damping_ratio = 0.7;
        o.method = SP_SIGNAL_FABER;
        o.tolerance = 1e-8;
        assert_ok(sp_signal_make(&net, &o, &linear, &err));
        o.method = SP_SIGNAL_DYNAMICS;
        o.step = 2e-3;
        for (int k = 0; k < 3; k++) {
            FREED(sp_signal) s = sp_signal_none();
            o.amplitude = amplitudes[k];
            assert_ok(sp_signal_compute(&p, &net, &o, &s, &err));
            differ[k] = difference(POINTS, s.f, linear.f);
        }
        for (int k = 1; k < 3; k++)
            if (fabs(log10(differ[k - 1] / differ[k]) - 1) > 0.1)
                fail_msg("case %d: differences %g %g %g", q, differ[0], differ[1], differ[2]);
    }
}

TEST(test_words) {
    sp_damping d;
    const char *const bad[] = {"",         "gamma",    "gamma:",     "gamma:-1", "gamma:1:",    "gamma:1:2:3",
                               "gamma:1x", "zeta:1:2", "mass:nan",   "drag:1",   "gamma:1e400", "gamma:0:1",
                               "-0.1",     "0.1:0.2",  "gamma:1:-1", "mass:1,2", "gamma::1",    "gamma:1e-300:1e300"};
    assert_ok(sp_damping_read("0.25", &d, &err));
    assert_true(d.kind == SP_DAMPING_ZETA && d.value == 0.25);
    assert_ok(sp_damping_read("gamma:0.5", &d, &err));
    assert_true(d.kind == SP_DAMPING_GAMMA && d.value == 0.5 && d.ratio == 1);
    assert_ok(sp_damping_read("mass:2e-1:0.1", &d, &err));
    assert_true(d.kind == SP_DAMPING_MASS && d.value == 0.2 && d.ratio == 0.5);
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
        if (sp_damping_read(bad[k], &d, NULL) != SP_EINVAL)
            fail_msg("\"%s\" was read", bad[k]);
}

TEST(test_refusals) {
    FREED(sp_packing) p = chain_packing(3, 1e-4);
    sp_network net = default_network(&p), out = sp_network_none();
    const sp_damping bad[] = {{SP_DAMPING_GAMMA, 0, 1},    {SP_DAMPING_GAMMA, -1, 1},  {SP_DAMPING_MASS, NAN, 1},
                              {SP_DAMPING_GAMMA, 1, -0.1}, {(sp_damping_kind)7, 1, 1}, {SP_DAMPING_MASS, 1, INFINITY}};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
        assert_int_equal(sp_network_dashpots(&net, &bad[k], &out, NULL), SP_EINVAL);
    double q = 0, error = 0;
    sp_wave_quality(1, 0.1, 0.2, 0.1, &q, &error); /* alpha within three errors of 0 */
    assert_true(isnan(q) && isnan(error));
    sp_network_free(&net);
}

RUN_TESTS(NULL, NULL)
