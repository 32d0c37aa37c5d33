/* Complex modes: closed forms, invariants of the matrices, and their sum against the damped signal. */
#include "base/base.h"
#include "linalg/eigen.h"
#include "reference.h"

#include <sonopack/modes.h>
#include <sonopack/signal.h>

/* lambda^2 + 2 d lambda + w2 = 0 as (omega, decay) pairs. */
static int roots(double d, double w2, double omega[2], double decay[2]) {
    if (d * d < w2) {
        omega[0] = sqrt(w2 - d * d);
        decay[0] = d;
        return 1;
    }
    const double root = sqrt(d * d - w2);
    omega[0] = omega[1] = 0;
    decay[1] = d + root;
    decay[0] = w2 / decay[1];
    return 2;
}

static void expect_mode(const sp_damped_modes *m, double omega, double decay) {
    double least = INFINITY, error = 0;
    for (int64_t k = 0; k < m->n; k++)
        if (hypot(m->omega[k] - omega, m->decay[k] - decay) < least) {
            least = hypot(m->omega[k] - omega, m->decay[k] - decay);
            error = m->error[k];
        }
    if (!(least <= error && error < 1e-7))
        fail_msg("omega %.17g decay %.17g: off by %g, bound %g", omega, decay, least, error);
}

/* One ball: both walls' springs and dashpots; critical at zeta = 1/sqrt(2). Two balls: their sum and their difference
 * (see test_damped). */
TEST(test_balls) {
    const double damping[] = {1e-6, 0.01, 0.3, M_SQRT1_2, 0.9, 5};
    for (size_t q = 0; q < sizeof damping / sizeof *damping; q++)
        for (int n = 1; n <= 2; n++) {
            FREED(sp_packing) p = chain_packing(n, 1e-4);
            FREED(sp_network) net = default_network(&p);
            FREED(sp_damped_modes) m = sp_damped_modes_none();
            assert_ok(sp_damped_modes_make(&net, damping[q], SP_SOURCE_IMPULSE, &m, &err));
            const double w2 = net.springs[0].kn / net.mass[0], d = damping[q] * sqrt(w2);
            double omega[2], decay[2];
            int64_t count = 0;
            for (int mode = 0; mode < n; mode++) {
                const double spring = n == 1 ? 2 : mode == 0 ? 1 : 3, dash = n == 1 ? 2 : mode == 0 ? 1 : 1 + M_SQRT2;
                const int many = roots(dash * d, spring * w2, omega, decay);
                if (n == 2 || q != 3)
                    for (int k = 0; k < many; k++)
                        expect_mode(&m, omega[k], decay[k]);
                count += many;
            }
            if (n == 1 && q == 3) /* a double eigenvalue is known to the root of rounding */
                for (int64_t k = 0; k < m.n; k++) {
                    assert_close(hypot(m.omega[k], m.decay[k] - sqrt(2 * w2)), 0, m.error[k]);
                    assert_true(m.error[k] < 1e-6);
                }
            else
                assert_int_equal(m.n, count);
            assert_true(m.residual < 1e-14);
        }
}

/* The eigenvalues add up to -tr M^-1 C, and the modes to the signal. */
static void check_sum(const sp_network *net, double zeta, sp_source source, double until) {
    enum { POINTS = 30 };
    FREED(sp_damped_modes) m = sp_damped_modes_none();
    FREED(sp_network) dashpots = sp_network_none();
    FREED(sp_signal) s = sp_signal_none();
    sp_signal_options o = sp_signal_options_default();
    const size_t n = (size_t)sp_network_dofs(net);
    double *unit = calloc(2 * n, sizeof *unit), trace = 0, sum = 0, error = 0, largest = 0;
    assert_ok(sp_damped_modes_make(net, zeta, source, &m, &err));
    assert_ok(sp_network_damping(net, zeta, &dashpots, &err));
    for (size_t k = 0; k < n; k++) {
        unit[k] = 1;
        sp_network_apply(&dashpots, unit, unit + n);
        trace += unit[n + k] / net->mass[k];
        unit[k] = 0;
    }
    int64_t count = 0;
    for (int64_t k = 0; k < m.n; k++) {
        sum += (m.omega[k] > 0 ? 2 : 1) * m.decay[k];
        error += 2 * m.error[k];
        count += m.omega[k] > 0 ? 2 : 1;
        assert_true(k == 0 || m.omega[k] >= m.omega[k - 1]);
    }
    assert_int_equal(count, 2 * n);
    assert_close(sum, trace, error);
    o.damping = zeta;
    o.source = source;
    o.until = until;
    o.points = POINTS;
    o.tolerance = 1e-8;
    assert_ok(sp_signal_make(net, &o, &s, &err));
    for (int l = 0; l < POINTS; l++)
        largest = fmax(largest, fabs(s.f[l]));
    for (int l = 1; l < POINTS; l++) {
        double f = 0;
        for (int64_t k = 0; k < m.n; k++)
            f += exp(-m.decay[k] * s.t[l]) *
                 (m.cosine[k] * cos(m.omega[k] * s.t[l]) + m.sine[k] * sin(m.omega[k] * s.t[l]));
        assert_close(f, s.f[l], 1e-9 * largest);
    }
    free(unit);
}

TEST(test_sum) {
    for (int q = 0; q < 4; q++) {
        FREED(sp_packing) p =
            q == 0 ? chain_packing(9, 1e-4) : scattered_packing(q < 3 ? 2 : 3, q < 3 ? 4 : 3, q == 1 ? 0 : 0.5, 8);
        FREED(sp_network) net = default_network(&p);
        for (double zeta = 0.01; zeta < 3; zeta *= 14)
            for (int source = 0; source < 3; source += 2)
                check_sum(&net, zeta, (sp_source)source, q == 0 ? 40 : 4);
    }
}

TEST(test_refusals) {
    FREED(sp_packing) p = chain_packing(SP_DAMPED_MODES_MAX + 1, 1e-4), small = chain_packing(3, 1e-4);
    FREED(sp_network) net = default_network(&p), few = default_network(&small);
    sp_damped_modes m = sp_damped_modes_none();
    assert_fails(sp_damped_modes_make(&net, 0.1, SP_SOURCE_IMPULSE, &m, &err), SP_EREFUSED, "2000");
    assert_fails(sp_damped_modes_make(&few, 0, SP_SOURCE_IMPULSE, &m, &err), SP_EINVAL, "damping 0");
    assert_fails(sp_damped_modes_make(&few, NAN, SP_SOURCE_IMPULSE, &m, &err), SP_EINVAL, "damping");
    double a[4] = {0, 1, NAN, 0}, re[2], im[2], vectors[4];
    assert_fails(sp_eigen_general(2, a, re, im, vectors, &err), SP_EINVAL, "");
    assert_fails(sp_eigen_general(0, a, re, im, vectors, &err), SP_EINVAL, "0");
    EACH_ALLOCATION_FAILS(10, sp_damped_modes_make(&few, 0.1, SP_SOURCE_IMPULSE, &m, &err), sp_damped_modes_free(&m));
}

RUN_TESTS(NULL, NULL)
