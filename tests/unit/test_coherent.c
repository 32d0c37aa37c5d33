/* The coherent wave of record sections: made-up ones with known waves and noise, and the chain, whose dispersion is
 * known in closed form (Eq. (C2) of Somfai et al. 2005). */
#include "numeric/random.h"
#include "signals.h"

#include <sonopack/coherent.h>

/* A Gaussian pulse e^(-(t - t0)^2 / (2 w^2)) at y = 0 that travels with phase speed c and attenuation a k^3 exactly: at
 * every plane the inverse Fourier integral of its spectrum, over omega = 0 .. 8/w. */
enum { PLANES = 60, TIMES = 3000 };
static const double speed = 0.2, rayleigh = 1.3, pulse = 8, start = 50, step = 0.25;

static sp_coherent_section made_up(double noise) {
    sp_coherent_section s = {.planes = PLANES, .n = TIMES, .spacing = step};
    s.y = sp_alloc(PLANES, sizeof *s.y);
    s.arrival = sp_alloc(PLANES, sizeof *s.arrival);
    s.until = sp_alloc(PLANES, sizeof *s.until);
    s.f = sp_alloc((size_t)PLANES * TIMES, sizeof *s.f);
    for (int j = 0; j < PLANES; j++) {
        s.y[j] = 5 + j;
        s.arrival[j] = start + s.y[j] / speed;
        s.until[j] = step * (TIMES - 1);
        for (int q = 0; q < 400; q++) {
            const double w = q * (8 / pulse) / 400, k = w / speed;
            const double size = (q == 0 ? 0.5 : 1) * exp(-0.5 * w * w * pulse * pulse - rayleigh * k * k * k * s.y[j]);
            for (int l = 0; l < TIMES; l++)
                s.f[j * TIMES + l] += size * cos(w * (l * step - start) - k * s.y[j]);
        }
        sp_random stream = sp_random_make(1, (uint64_t)(100 + j));
        for (int l = 0; l < TIMES; l++)
            s.f[j * TIMES + l] += noise * (sp_random_uniform(&stream) - 0.5);
    }
    return s;
}

/* Where the wave hardly decays the four periods hold the whole pulse. Where it decays within a few planes, the low
 * frequencies that are left farther up are longer than the window, and what is cut off of them is felt: 1e-3. */
TEST(test_known_wave) {
    FREED(sp_coherent_section) s = made_up(0);
    for (double w = 0.04; w < 0.16; w += 0.02) {
        sp_coherent_wave c;
        const double k = w / speed;
        assert_ok(sp_coherent_fit(&s, w, &c, &err));
        assert_relative(c.k, k, k < 0.3 ? 1e-4 : 4e-3);
        assert_relative(c.alpha, rayleigh * k * k * k, k < 0.3 ? 2e-3 : 1e-2);
        assert_true(c.part > 1 - 1e-3);
    }
}

/* Noise on every plane that is independent of the others: k and alpha stay near, and `part` tells of it. */
TEST(test_noise) {
    FREED(sp_coherent_section) s = made_up(20);
    sp_coherent_wave c;
    const double w = 0.06, k = w / speed;
    assert_ok(sp_coherent_fit(&s, w, &c, &err));
    assert_relative(c.k, k, 0.05);
    assert_close(c.alpha, rayleigh * k * k * k, 0.03);
    assert_true(c.part < 0.999);
    for (int l = 0; l < PLANES * TIMES; l++)
        s.f[l] *= 0.7; /* rounds every value anew, and changes no wave */
    sp_coherent_wave again;
    assert_ok(sp_coherent_fit(&s, w, &again, &err));
    assert_true(again.k != c.k || again.alpha != c.alpha);
    assert_relative(again.k, c.k, 1e-13);
    assert_relative(again.alpha, c.alpha, 1e-12);
    assert_close(again.k_shift, c.k_shift, 1e-13);
    assert_close(again.alpha_shift, c.alpha_shift, 1e-13);
}

/* omega = 2 sqrt(K/m) sin(k l/2), no attenuation. The slower the waves of a frequency are beside the front, the more of
 * them comes after the record's end: the error is small up to 0.7 of omega_max = 2 sqrt(K/m), and told by what half the
 * time changes. */
static void check_rows(const sp_packing *p, bool lattice) {
    FREED(sp_network) net = network_of(p, false);
    FREED(sp_coherent_section) s = sp_coherent_section_none();
    const sp_coherent_section_options o = sp_coherent_section_options_default();
    assert_ok(sp_coherent_section_make(&net, &o, &s, &err));
    const double angle = lattice ? sqrt(0.75) : 1, l = angle * net.length[0];
    const double root = sqrt((lattice ? 1.5 : 1) * net.springs[0].kn / net.mass[0]);
    for (int32_t j = 0; j < s.planes; j++) { /* half way between two rows */
        const double rows = (s.y[j] - net.x[net.dim - 1]) / l - 0.5;
        assert_close(rows, round(rows), 1e-9);
    }
    for (double part = 0.1; part < 0.95; part += 0.1) {
        sp_coherent_wave c;
        const double k = 2 * asin(part) / l;
        assert_ok(sp_coherent_fit(&s, part * 2 * root, &c, &err));
        const double error = hypot(c.k - k, c.alpha), shift = hypot(c.k_shift, c.alpha_shift);
        assert_true(error < (part < 0.75 ? 2e-5 : part < 0.85 ? 5e-4 : 6e-3));
        assert_true(error < (part < 0.85 ? 1 : 3) * shift + 1e-6);
        assert_true(shift < 0.01 * k);
    }
    assert_true(s.highest > 2 * root && s.highest < 1.0011 * 2 * root);
    for (int q = 0; q < 3; q++) { /* where nothing can swing, no wave */
        sp_coherent_wave c;
        assert_ok(sp_coherent_fit(&s, (const double[]){1.002, 1.05, 1.2}[q] * 2 * root, &c, &err));
        assert_true(isnan(c.k) && isnan(c.alpha) && isnan(c.k_shift) && isnan(c.alpha_shift));
    }
}

TEST(test_chain) {
    FREED(sp_packing) p = chain_packing(180, 1e-4);
    check_rows(&p, false);
}

/* Rows of a lattice move as the grains of a chain with 1.5 of a contact's stiffness, sqrt(3)/2 of a spacing apart:
 * Eq. (18) of Somfai et al. 2005. Planes are not at the same height between the rows, one row after the other. */
TEST(test_lattice) {
    sp_pack_spec spec = sp_pack_spec_default();
    FREED(sp_packing) p = sp_packing_none();
    spec.kind = SP_PACK_TRIANGULAR;
    spec.grains = 6 * 180;
    spec.width = 6;
    spec.friction = 0;
    assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
    check_rows(&p, true);
}

/* Planes closer than the rows have one another's contacts: they are left out. What comes too late for three planes, or
 * only as the record ends, is told to be none. */
TEST(test_few_planes) {
    FREED(sp_packing) p = chain_packing(40, 1e-4);
    FREED(sp_network) net = network_of(&p, false);
    FREED(sp_coherent_section) s = sp_coherent_section_none();
    sp_coherent_section_options o = sp_coherent_section_options_default();
    sp_coherent_wave c;
    o.spacing = 0.1;
    assert_ok(sp_coherent_section_make(&net, &o, &s, &err));
    assert_true(s.planes >= 20 && s.planes <= 21);
    const double length = s.until[0];
    assert_ok(sp_coherent_fit(&s, 0.2, &c, &err));
    assert_false(isnan(c.k) || isnan(c.alpha) || isnan(c.k_shift) || isnan(c.alpha_shift));
    for (int32_t j = 0; j < s.planes - 3; j++)
        s.until[j] = s.arrival[j] + 0.4 * 2 * M_PI / 0.2;
    s.until[s.planes - 1] = length;
    assert_ok(sp_coherent_fit(&s, 0.2, &c, &err));
    assert_true(isnan(c.k) && isnan(c.alpha) && isnan(c.k_shift) && isnan(c.alpha_shift));
    assert_close(sp_network_plane_height(&net, 0.1), 0.5 * net.x[net.dim - 1], 1e-14); /* the contact with the wall */
}

TEST(test_refusals) {
    sp_coherent_section s = made_up(0);
    sp_coherent_wave c = {.k = 7};
    assert_fails(sp_coherent_fit(&s, 0, &c, &err), SP_EINVAL, "omega 0");
    assert_fails(sp_coherent_fit(&s, NAN, &c, &err), SP_EINVAL, "omega nan");
    assert_fails(sp_coherent_fit(&s, 7, &c, &err), SP_EINVAL, "omega 7");
    s.y[3] = s.y[2];
    assert_fails(sp_coherent_fit(&s, 0.1, &c, &err), SP_EINVAL, "3");
    assert_true(c.k == 7);
    s.y[3] = 8;
    memset(s.f, 0, sizeof *s.f * PLANES * TIMES); /* silence has no wave */
    assert_ok(sp_coherent_fit(&s, 0.1, &c, &err));
    assert_true(isnan(c.k) && isnan(c.alpha));
    sp_coherent_section_free(&s);
    FREED(sp_packing) p = chain_packing(12, 1e-4);
    FREED(sp_network) net = network_of(&p, false);
    sp_coherent_section_options o = sp_coherent_section_options_default();
    assert_fails(sp_coherent_section_make(&net, &o, &s, &err), SP_EREFUSED, "8");
    o.spacing = 0;
    assert_fails(sp_coherent_section_make(&net, &o, &s, &err), SP_EINVAL, "0");
    o.spacing = 1e-9;
    assert_fails(sp_coherent_section_make(&net, &o, &s, &err), SP_EINVAL, "100000");
    o.spacing = 0.3;
    assert_fails(sp_coherent_section_make(&net, &o, &s, &err), SP_EREFUSED, "4");
    sp_network_free(&net);
    sp_packing_free(&p);
    p = chain_packing(30, 1e-4);
    net = network_of(&p, false);
    s = sp_coherent_section_none();
    EACH_ALLOCATION_FAILS(8, sp_coherent_section_make(&net, &o, &s, &err), assert_true(!lacks || !s.f),
                          sp_coherent_section_free(&s));
}

RUN_TESTS(NULL, NULL)
