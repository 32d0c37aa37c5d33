/* Localisation in chains with random masses: against the modes of the same chain, and against the closed form of
 * Matsuda and Ishii for low frequencies. */
#include "base/base.h"
#include "signals.h"

#include <sonopack/modes.h>
#include <sonopack/transport.h>

/* det(K - omega^2 M) is a product over the modes of a network, and over the chain of transfer matrices:
 * |u_(n+1)/u_1| = prod m_j |omega_j^2 - omega^2| / prod k_j, the first spring left out. */
TEST(test_modes_agree) {
    enum { N = 400 };
    FREED(sp_packing) p = chain_packing(N, 1e-4);
    FREED(sp_network) net = network_of(&p, false);
    double *k = calloc(N + 1, sizeof *k), logs = 0;
    FREED(sp_modes) modes = sp_modes_none();
    sp_modes_options o = sp_modes_options_default();
    assert_non_null(k);
    assert_int_equal(net.n_springs, N + 1);
    for (int q = 0; q <= N; q++)
        k[q] = net.springs[0].kn; /* all are equal */
    assert_ok(sp_localisation_masses(N, 0.4, 3, net.mass, &err));
    o.vectors = false;
    assert_ok(sp_modes_dense(&net, &o, &modes, &err));
    for (double omega = 0.01; omega < 0.5; omega *= 1.7) {
        sp_localisation l;
        assert_ok(sp_localisation_chain(N, net.mass, k, omega, &l, &err));
        logs = 0;
        for (int j = 0; j < N; j++)
            logs += log(net.mass[j] / k[j + 1] * fabs(modes.omega[j] * modes.omega[j] - omega * omega));
        assert_close(l.log_end, logs, 1e-7 * (1 + fabs(logs)));
        assert_true(l.gamma_err > 0);
    }
    free(k);
}

TEST(test_closed_form) {
    enum { N = 3000000 };
    const double disorder = 0.35;
    double *mass = malloc(N * sizeof *mass), *k = malloc((N + 1) * sizeof *k), sum = 0, squares = 0;
    assert_true(mass && k);
    assert_ok(sp_localisation_masses(N, disorder, 1, mass, &err));
    for (int j = 0; j <= N; j++)
        k[j] = 1;
    for (int j = 0; j < N; j++) {
        sum += mass[j];
        squares += (mass[j] - 1) * (mass[j] - 1);
    }
    assert_close(sum / N, 1, 5 * disorder / sqrt(N));
    assert_relative(squares / N, disorder * disorder, 5 / sqrt(N));
    for (double omega = 0.1; omega < 0.5; omega *= 2) {
        sp_localisation l;
        const double law = sp_localisation_law(omega, 1, disorder * disorder, 1);
        assert_ok(sp_localisation_chain(N, mass, k, omega, &l, &err));
        assert_true(l.gamma_err < 0.1 * law);
        assert_close(l.gamma, law, 3 * l.gamma_err + omega * omega * law); /* the next order */
    }
    /* equal masses: nothing decays below the highest frequency, 2, and cosh(gamma) = omega^2/2 - 1 above it */
    assert_ok(sp_localisation_masses(N, 0, 1, mass, &err));
    sp_localisation l;
    assert_ok(sp_localisation_chain(N, mass, k, 1.3, &l, &err));
    assert_close(l.gamma, 0, 1e-5);
    assert_ok(sp_localisation_chain(N, mass, k, 2.5, &l, &err));
    assert_relative(l.gamma, acosh(0.5 * 2.5 * 2.5 - 1), 1e-5);
    free(mass);
    free(k);
}

TEST(test_bad_input) {
    double mass[400], k[401];
    sp_localisation l;
    assert_ok(sp_localisation_masses(400, 0.1, 1, mass, &err));
    for (int j = 0; j <= 400; j++)
        k[j] = 1;
    assert_fails(sp_localisation_masses(400, 0.6, 1, mass, &err), SP_EINVAL, "0.6");
    assert_fails(sp_localisation_chain(319, mass, k, 1, &l, &err), SP_EINVAL, "319");
    assert_fails(sp_localisation_chain(400, mass, k, 0, &l, &err), SP_EINVAL, "0");
    /* waves longer than the chain: no growth is seen, but that does not exclude one of 1/N */
    assert_ok(sp_localisation_chain(400, mass, k, 1e-12, &l, &err));
    assert_true(l.gamma_err >= 1.0 / 400);
    assert_fails(sp_localisation_chain(400, mass, k, 1e30, &l, &err), SP_EREFUSED, "1e+30");
    k[400] = 0;
    assert_fails(sp_localisation_chain(400, mass, k, 1, &l, &err), SP_EINVAL, "400");
}

RUN_TESTS(NULL, NULL)
