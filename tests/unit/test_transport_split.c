/* The split of the energy: that of random motions is the mean over the modes of the band, and a pulse comes near it. */
#include "signals.h"

#include <sonopack/transport.h>

/* Kinetic parts of the modes about omega, each with the energy exp(-x^2/2). */
static void by_modes(const sp_network *net, double omega, double width, double out[3]) {
    const sp_modes_options o = sp_modes_options_default();
    FREED(sp_modes) m = sp_modes_none();
    double all = 0;
    out[0] = out[1] = out[2] = 0;
    assert_ok(sp_modes_dense(net, &o, &m, &err));
    for (int64_t n = m.n_zero; n < m.n; n++) {
        const double x = (m.omega[n] / omega - 1) / width, g = exp(-0.5 * x * x);
        const double *e = m.vectors + (n - m.n_rattler) * m.dofs;
        for (int64_t k = 0; k < m.dofs; k++) {
            const int a = (int)(k % net->dof);
            out[a >= net->dim ? 2 : a == net->dim - 1 ? 0 : 1] += 0.5 * g * e[k] * e[k];
        }
        all += g;
    }
    for (int a = 0; a < 3; a++)
        out[a] /= all;
}

TEST(test_equal_energy_of_modes) {
    FREED(sp_packing) p = reference_packing(SOURCE_DIR "/packings/reference/packing_N200_p1e-4.txt");
    FREED(sp_network) net = network_of(&p, false);
    sp_split_options o = sp_split_options_default();
    o.sources = 24;
    for (double omega = 0.2; omega < 1; omega += 0.3) {
        sp_split s;
        double exact[3];
        by_modes(&net, omega, o.width, exact);
        assert_ok(sp_split_make(&net, omega, &o, &s, &err));
        assert_true(s.rest_err.rotation > 0 && s.rest_err.rotation < 0.02);
        assert_close(s.rest.along, exact[0], 4 * s.rest_err.along);
        assert_close(s.rest.across, exact[1], 4 * s.rest_err.across);
        assert_close(s.rest.rotation, exact[2], 4 * s.rest_err.rotation);
        assert_close(sp_energy_sum(&s.rest), 1, 1e-12);
        assert_close(s.rest.normal + s.rest.tangential, 0.5, 4 * (s.rest_err.normal + s.rest_err.tangential));
        assert_close(sp_energy_sum(&s.pulse), 1, 1e-12);
        assert_close(s.pulse.normal + s.pulse.tangential, 0.5, 0.02); /* half of the energy is kinetic */
        assert_close(s.pulse.rotation, s.rest.rotation, 0.5 * s.rest.rotation);
        assert_close(s.until, 2 * s.from, 1e-9);
    }
}

RUN_TESTS(NULL, NULL)
