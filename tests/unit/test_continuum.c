/* Modes of an elastic strip, and those of a packing beside them. */
#include "base/base.h"
#include "reference.h"

#include <sonopack/spectrum.h>

static const double PI = 3.14159265358979323846;

/* Without n1 the two components are alone: n pi c/L2 of either kind. With C12 = -C33 they are alone for every n1. */
TEST(test_decoupled) {
    const double box[2] = {7, 5}, density = 0.6;
    for (int n1 = 0; n1 < 4; n1++) {
        const sp_moduli m = {.c11 = 3, .c12 = n1 == 0 ? 1.3 : -0.7, .c22 = 2, .c33 = 0.7};
        sp_strip_mode mode[24];
        assert_ok(sp_strip_modes(&m, density, box, n1, 24, mode, &err));
        double omega[60];
        for (int q = 0; q < 60; q++) {
            const int n2 = q / 2 + 1;
            const double k1 = 2 * PI * n1 / box[0], k2 = PI * n2 / box[1];
            omega[q] = sqrt((q % 2 ? m.c11 * k1 * k1 + m.c33 * k2 * k2 : m.c33 * k1 * k1 + m.c22 * k2 * k2) / density);
        }
        for (int k = 0; k < 24; k++) {
            int below = 0;
            for (int q = 0; q < 60; q++)
                below += omega[q] < mode[k].omega * (1 - 1e-8);
            assert_int_equal(below, k); /* as many below as there should be, and one there */
            double nearest = 1;
            for (int q = 0; q < 60; q++)
                nearest = fmin(nearest, fabs(omega[q] / mode[k].omega - 1));
            assert_true(nearest < 1e-8);
            assert_relative(mode[k].omega_plane, mode[k].omega, 1e-8);
            assert_int_equal(mode[k].n1, n1);
        }
    }
}

/* Coupled: tied to the weak form by a variational principle, a sum of squares over a fine grid, which no basis of the
 * solver enters: the Rayleigh quotient of a mode is its frequency to the order of the grid, h^2. */
TEST(test_coupled) {
    enum { GRID = 4000 };
    const sp_moduli m = {.c11 = 1.3e-2, .c12 = 7e-3, .c22 = 1.8e-2, .c33 = 4e-3};
    const double box[2] = {24, 25}, density = 0.53, h = box[1] / GRID;
    sp_strip_mode mode[6];
    assert_ok(sp_strip_modes(&m, density, box, 1, 6, mode, &err));
    for (int k = 0; k < 6; k++) {
        const double k1 = 2 * PI / box[0];
        double energy = 0, mass = 0, v0 = 0, w0 = 0;
        for (int q = 1; q <= GRID; q++) {
            const double s = 2.0 * q / GRID - 1;
            double l[50] = {1, s}, v = 0, w = 0;
            for (int a = 2; a < 50; a++)
                l[a] = ((2 * a - 1) * s * l[a - 1] - (a - 1) * l[a - 2]) / a;
            for (int a = 0; a < 48; a++) {
                v += mode[k].v[a] * (l[a] - l[a + 2]) / sqrt(4.0 * a + 6);
                w += mode[k].w[a] * (l[a] - l[a + 2]) / sqrt(4.0 * a + 6);
            }
            /* u = (v cos, -w sin)(k1 x): strains -k1 v sin, -w' sin, (v' - k1 w) cos, each squared half on average */
            const double dv = (v - v0) / h, dw = (w - w0) / h, vm = 0.5 * (v + v0), wm = 0.5 * (w + w0);
            energy += h * (m.c11 * k1 * k1 * vm * vm + m.c22 * dw * dw + 2 * m.c12 * k1 * vm * dw +
                           m.c33 * (dv - k1 * wm) * (dv - k1 * wm));
            mass += h * density * (vm * vm + wm * wm);
            v0 = v;
            w0 = w;
        }
        assert_relative(sqrt(energy / mass), mode[k].omega, 1e-5);
        assert_relative(mass, 1.0, 1e-5); /* and it is one mode of unit mass */
        assert_true(k == 0 || mode[k].omega >= mode[k - 1].omega);
        /* the lowest mode of the strip is above the lowest plane wave of the same n1 and k2 = 0 */
        assert_true(mode[k].omega > sqrt(m.c33 / density) * k1);
    }
}

TEST(test_packing) {
    FREED(sp_packing) p = reference_packing(REFERENCE("packing_N600_p1e-4.txt"));
    FREED(sp_network) net = sp_network_none();
    const sp_network_options o = sp_network_options_default();
    sp_statics s;
    sp_continuum c = sp_continuum_none();
    assert_ok(sp_network_make(&p, &o, &net, &err));
    assert_ok(sp_statics_make(&p, 1e-4, 3, &s, &err));
    assert_ok(sp_continuum_make(&net, s.phi3s, 6, SP_SOLVER_AUTO, &c, &err));
    assert_int_equal(c.n, 6);
    /* the lowest is the shear of the whole, slower than the continuum's as walls and disorder soften it */
    assert_int_equal(c.row[0].n1, 0);
    assert_int_equal(c.row[0].n2, 1);
    assert_false(c.row[0].fast);
    assert_true(c.row[0].overlap > 0.8 && c.row[0].overlap <= 1);
    assert_close(c.row[0].omega / c.row[0].omega_continuum, 0.95, 0.1);
    assert_relative(c.row[0].omega_continuum, PI * c.moduli.c_t / p.box[1], 1e-9);
    assert_int_equal(c.row[0].n, 3 * (600 - net.n));
    for (int k = 0; k < c.n; k++)
        assert_true(c.row[k].overlap > 0 && c.row[k].overlap <= 1 + 1e-12);
    sp_continuum_free(&c);
    for (int k = 0;; k++) {
        sp_error error = {0};
        sp_alloc_fail_after(k);
        const sp_status status = sp_continuum_make(&net, s.phi3s, 2, SP_SOLVER_AUTO, &c, &error);
        sp_alloc_fail_after(-1);
        if (status == SP_OK) {
            assert_true(k > 15);
            break;
        }
        assert_int_equal(status, SP_ENOMEM);
    }
    sp_continuum_free(&c);
    assert_fails(sp_continuum_make(&net, NAN, 2, SP_SOLVER_AUTO, &c, &err), SP_EREFUSED, "Phi3*");
    assert_fails(sp_continuum_make(&net, 0.5, 0, SP_SOLVER_AUTO, &c, &err), SP_EINVAL, "1");
    sp_strip_mode mode;
    const double box[2] = {1, 1};
    const sp_moduli bad = {.c11 = 1, .c22 = 1, .c33 = NAN};
    assert_fails(sp_strip_modes(&bad, 0.5, box, 0, 1, &mode, &err), SP_EINVAL, "0");
    assert_fails(sp_strip_modes(&c.moduli, 0.5, box, 0, 25, &mode, &err), SP_EINVAL, "1 24");
    sp_network_free(&net);
    sp_packing_free(&p);
    p = scattered_packing(3, 3, 0.5, 1);
    assert_ok(sp_network_make(&p, &o, &net, &err));
    assert_fails(sp_continuum_make(&net, 0.5, 2, SP_SOLVER_AUTO, &c, &err), SP_EREFUSED, "2");
    sp_network_free(&net);
    sp_packing_free(&p);
    p = scattered_packing(2, 6, 0, 1);
    assert_ok(sp_network_make(&p, &o, &net, &err));
    assert_fails(sp_continuum_make(&net, 0.5, 2, SP_SOLVER_AUTO, &c, &err), SP_EREFUSED, "");
}

RUN_TESTS(NULL, NULL)
