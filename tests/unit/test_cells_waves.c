/* Waves in cells without a piston: dispersion by lattice sums, pulses from a plane of grains. */
#include "base/vector.h"
#include "cells.h"
#include "network/network_cell.h"

#include <sonopack/coherent.h>
#include <sonopack/signal.h>
#include <sonopack/spectrum.h>

static const double PI = 3.14159265358979323846, tilted[3] = {0.3, -0.2, 0.4};

static sp_network network_of(const sp_packing *p, bool prestress) {
    return network_by(p, (sp_network_options){.prestress = prestress});
}

/* ---- dispersion ------------------------------------------------------------------------------------------------- */

/* The wave vector of the n-th wave along an axis: its phase changes by 2 pi n over that lattice vector, by 0 over the
 * others. */
TEST(reciprocal_vectors) {
    FREED(sp_packing) p = cells_packing(SP_CELL_PERIODIC, 3, 40, 0.7, tilted, 0, 3);
    FREED(sp_network) net = network_of(&p, false);
    for (int a = 0; a < 3; a++)
        for (int c = 0; c < 3; c++) {
            double b[3], lattice[3] = {0, 0, 0};
            sp_network_reciprocal(&net, a, b);
            sp_network_move(&net, c, 1, lattice);
            assert_close(dot3(b, lattice), a == c, 1e-15);
        }
}

/* In a lattice of one grain to a cell a plane wave of direction e has <omega^2> = 2/m sum over bonds of k (n . e)^2
 * (1 - cos(k . r)), in every cell of the lattice, tilted or not: any error of a phase across the cell would show. */
static void assert_lattice_wave(const sp_network *net, const sp_dispersion_point *w, const double k[3],
                                const double e[3]) {
    double sum = 0;
    for (int32_t q = 0; q < net->n_springs; q++) {
        const sp_spring *s = &net->springs[q];
        const double across = dot3(s->n, e);
        sum += s->kn * across * across * (1 - cos(dot3(k, s->n) * net->length[q]));
    }
    assert_relative(w->k, length3(k), 1e-14);
    assert_relative(w->rms * w->rms, 2 * sum / net->n / net->mass[0], 1e-12);
}

static void assert_lattice(sp_packing p) {
    FREED(sp_network) net = network_of(&p, false);
    for (int axis = 0; axis < p.dim; axis++) {
        sp_dispersion_options o = sp_dispersion_options_default();
        FREED(sp_dispersion) d = sp_dispersion_none();
        o.up = axis == p.dim - 1;
        o.along_y = axis == 1 && !o.up;
        o.waves = 3;
        assert_ok(sp_dispersion_make(&net, &o, &d, &err));
        assert_int_equal(d.n, 6);
        for (int q = 0; q < d.n; q++) {
            double k[3], e[3] = {0, 0, 0};
            sp_network_reciprocal(&net, axis, k);
            for (int a = 0; a < 3; a++)
                k[a] *= 2 * PI * d.wave[q].n;
            if (d.wave[q].polarization == SP_TRANSVERSE) {
                const int across = o.up ? 0 : p.dim - 1;
                const double part = k[across] / dot3(k, k);
                for (int a = 0; a < 3; a++)
                    e[a] = (a == across) - part * k[a];
            } else {
                memcpy(e, k, sizeof e);
            }
            const double size = length3(e);
            for (int a = 0; a < 3; a++)
                e[a] /= size;
            assert_lattice_wave(&net, &d.wave[q], k, e);
        }
    }
    sp_packing_free(&p);
}

TEST(lattices) {
    for (int lean = -2; lean <= 2; lean++)
        assert_lattice(cells_square(5, 7, lean, 0.01, 0));
    assert_lattice(cells_triangular(6, 7, 0.01, 0));
    assert_lattice(cells_fcc_tilted(5, 0.01, 0));
}

/* Along the rows of a square lattice the wave is an eigenmode: omega = 2 sqrt(k/m) |sin(k a/2)|. */
TEST(square_rows) {
    FREED(sp_packing) p = cells_square(12, 5, 0, 0.01, 0);
    FREED(sp_network) net = network_of(&p, false);
    sp_dispersion_options o = sp_dispersion_options_default();
    sp_dispersion d = sp_dispersion_none();
    o.waves = 6;
    assert_ok(sp_dispersion_make(&net, &o, &d, &err));
    for (int n = 0; n < 6; n++) {
        const double omega = 2 * sqrt(net.springs[0].kn / net.mass[0]) * sin(PI * (n + 1) / 12);
        assert_relative(d.wave[n].rms, omega, 1e-12);
        assert_close(d.wave[n].spread, 0, 1e-6 * omega);
        assert_close(d.wave[n].peak, omega, 2 * d.wave[n].resolution + 1e-9);
    }
    sp_dispersion_free(&d);
    o.node = 0.5;
    assert_fails(sp_dispersion_make(&net, &o, &d, &err), SP_EINVAL, "node 0.5");
    o.node = 0;
    o.along_y = true;
    assert_fails(sp_dispersion_make(&net, &o, &d, &err), SP_EINVAL, "y");
}

/* Long waves have the speeds of the moduli, by the kernel's peak and by the modes of the cell. */
TEST(speeds_of_moduli) {
    FREED(sp_packing) p = cells_triangular(12, 14, 0.01, 0);
    FREED(sp_network) net = network_of(&p, false);
    sp_moduli m;
    double density;
    sp_dispersion_options o = sp_dispersion_options_default();
    sp_dispersion d = sp_dispersion_none();
    assert_ok(sp_packing_density(&p, 0, 3, &density, &err));
    assert_ok(sp_moduli_make(&net, density, &m, &err));
    o.waves = 1;
    for (int up = 0; up < 2; up++) {
        o.up = up;
        assert_ok(sp_dispersion_make(&net, &o, &d, &err));
        assert_relative(d.wave[0].rms / d.wave[0].k, m.c_l, 0.02); /* omega bends down by (k a)^2/24 */
        assert_relative(d.wave[1].rms / d.wave[1].k, m.c_t, 0.02);
        sp_dispersion_free(&d);
    }
}

/* In a box waves along all axes stand between walls. */
TEST(standing_in_a_box) {
    FREED(sp_packing) p = cells_packing(SP_CELL_BOX, 2, 40, 0.95, NULL, 0, 5);
    FREED(sp_network) net = network_of(&p, false);
    for (int up = 0; up < 2; up++) {
        sp_dispersion_options o = sp_dispersion_options_default();
        FREED(sp_dispersion) d = sp_dispersion_none();
        o.up = up;
        o.waves = 2;
        assert_ok(sp_dispersion_make(&net, &o, &d, &err));
        assert_relative(d.wave[1].k, 2 * PI / p.box[up], 1e-14);
        assert_true(d.wave[0].rms > 0 && d.wave[0].rms < d.wave[1].rms);
    }
}

/* ---- pulses ----------------------------------------------------------------------------------------------------- */

static sp_signal signal_of(const sp_packing *p, const sp_network *net, sp_signal_method method, const sp_place *from,
                           const sp_place *to, int detectors, double until) {
    sp_signal s = sp_signal_none();
    sp_signal_options o = sp_signal_options_default();
    o.method = method;
    o.sources = 1;
    o.from = from;
    o.detectors = detectors;
    o.to = to;
    o.until = until;
    o.points = 101;
    if (method == SP_SIGNAL_DYNAMICS || method == SP_SIGNAL_VERLET)
        o.tolerance = 1e-4;
    assert_ok(sp_signal_compute(p, net, &o, &s, &err));
    return s;
}

/* A row of a square lattice gets unit momentum per grain: each column is a ring of masses, whose motion is a sum over
 * its waves. The pulse goes up and down, and round the period. */
TEST(rings) {
    enum { COLUMNS = 4, ROWS = 9 };
    FREED(sp_packing) p = cells_square(COLUMNS, ROWS, 1, 0.01, 0);
    FREED(sp_network) net = network_of(&p, false);
    const double a = 0.99, m = net.mass[0], k = net.springs[0].kn, until = 40;
    sp_place from = {.kind = SP_PLACE_PLANE, .height = 4.25 * a}, to[ROWS - 1];
    for (int j = 0; j < ROWS - 1; j++) /* between row j and the next one; opposite to the source there is no force */
        to[j] = (sp_place){.kind = SP_PLACE_PLANE, .height = (j + 0.75) * a};
    FREED(sp_signal) s = signal_of(&p, &net, SP_SIGNAL_CHEBYSHEV, &from, to, ROWS - 1, until);
    for (int j = 0; j < ROWS - 1; j++)
        for (int l = 0; l < s.n; l++) {
            double force = 0;
            for (int q = 1; q < ROWS; q++) {
                const double turn = 2 * PI * q / ROWS, omega = 2 * sqrt(k / m) * sin(0.5 * turn);
                force += (cos(turn * (j - 4)) - cos(turn * (j - 3))) * sin(omega * s.t[l]) / omega;
            }
            assert_close(s.f[j * s.n + l], COLUMNS * k * force / (m * ROWS), 1e-9 * k);
            assert_close(s.f[j * s.n + l], -s.f[(ROWS - 2 - j) * s.n + l], 1e-9 * k); /* both ways */
        }
}

/* A strong impulse moves the whole packing: its drift is left out, which would carry grains out of reach. */
TEST(no_drift) {
    FREED(sp_packing) p = cells_packing(SP_CELL_PERIODIC, 2, 40, 0.95, NULL, 0.3, 21);
    FREED(sp_network) net = network_of(&p, true);
    const sp_place plane = {.kind = SP_PLACE_PLANE, .height = 1};
    FREED(sp_signal) s = sp_signal_none();
    sp_signal_options o = sp_signal_options_default();
    o.method = SP_SIGNAL_DYNAMICS;
    o.sources = o.detectors = 1;
    o.from = o.to = &plane;
    o.until = 150;
    o.amplitude = 0.3;
    o.step = 0.2;
    o.tolerance = 0.5;
    assert_ok(sp_signal_compute(&p, &net, &o, &s, &err));
}

/* What needs a wall says so. */
TEST(refusals) {
    FREED(sp_packing) p = cells_packing(SP_CELL_PERIODIC, 2, 40, 0.95, NULL, 0.3, 21);
    FREED(sp_network) net = network_of(&p, false);
    sp_signal s = sp_signal_none();
    sp_signal_options o = sp_signal_options_default();
    o.until = 10;
    assert_fails(sp_signal_make(&net, &o, &s, &err), SP_EREFUSED, "bottom plane:Y");
    const double omega = 0.1;
    sp_harmonic_options h = sp_harmonic_options_default();
    sp_harmonic driven = sp_harmonic_none();
    h.omega = &omega;
    h.n = 1;
    assert_fails(sp_harmonic_make(&net, &h, &driven, &err), SP_EREFUSED, "harmonic");
    const sp_transmission_options t = sp_transmission_options_default();
    sp_transmission through = sp_transmission_none();
    assert_fails(sp_transmission_make(&net, &t, &through, &err), SP_EREFUSED, "transmission");
    sp_continuum strip = sp_continuum_none();
    assert_fails(sp_continuum_make(&net, 0.5, 3, SP_SOLVER_AUTO, &strip, &err), SP_EREFUSED, "piston");
}

RUN_TESTS(NULL, NULL)
