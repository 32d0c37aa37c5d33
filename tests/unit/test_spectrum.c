#include "base/base.h"
#include "extended.h"
#include "network/bound.h"
#include "reference.h"

#include <complex.h>
#include <sonopack/pulse.h>
#include <sonopack/spectrum.h>
#undef I

/* CMPLX of C11, which not every compiler has. */
static double complex number(double re, double im) { return re + im * _Complex_I; }

/* Frequencies of a chain, (C2) of Somfai et al. 2005. */
static double chain_frequency(const sp_network *net, int n) {
    return 2 * sqrt(net->springs[0].kn / net->mass[0]) * sin(n * M_PI / (2 * (net->n + 1)));
}

/* Histogram, cumulative count and normalisation of the exact density of states of a chain. */
TEST(test_exact_chain) {
    enum { GRAINS = 50 };
    FREED(sp_packing) p = chain_packing(GRAINS, 1e-4);
    FREED(sp_network) net = default_network(&p);
    sp_dos_options o = sp_dos_options_default();
    o.bins = 23;
    for (int norm = 0; norm < 3; norm++) {
        FREED(sp_dos) d = sp_dos_none();
        o.norm = (sp_dos_norm)norm;
        assert_ok(sp_dos_make(&net, &o, &d, &err));
        assert_int_equal(d.method, SP_DOS_EXACT);
        assert_true(d.zero.total == d.zero.rattlers && d.modes == GRAINS && d.vectors == 0);
        const double scale = norm == SP_DOS_MODES ? 1 : GRAINS;
        int before = 0;
        for (int b = 0; b < d.bins; b++) {
            int below = 0;
            for (int n = 1; n <= GRAINS; n++)
                below += chain_frequency(&net, n) <= d.edge[b + 1];
            assert_close(d.cumulative[b], below / scale, 1e-14);
            assert_close(d.density[b] * (d.edge[b + 1] - d.edge[b]), (below - before) / scale, 1e-13);
            assert_true(d.density_error[b] == 0 && d.cumulative_error[b] == 0 && d.smooth[b] >= 0);
            before = below;
        }
        assert_int_equal(before, GRAINS);
    }
}

/* From the bound of the spectrum on there is nothing, with every method: there the density per phi, which is not 0, is
 * divided by a slope that has vanished. */
TEST(test_above_spectrum) {
    FREED(sp_packing) p = scattered_packing(2, 5, 0.5, 2);
    FREED(sp_network) net = default_network(&p);
    sp_dos_options o = sp_dos_options_default();
    o.bins = 41;
    o.until = 2 * sp_network_omega_bound(&net); /* the bound is the middle of a bin */
    for (int method = 0; method < 3; method++) {
        FREED(sp_dos) d = sp_dos_none();
        o.method = (sp_dos_method[]){SP_DOS_EXACT, SP_DOS_KPM, SP_DOS_COUNT}[method];
        assert_ok(sp_dos_make(&net, &o, &d, &err));
        assert_true(0.5 * (d.edge[20] + d.edge[21]) == d.omega_max);
        for (int b = 20; b < o.bins; b++)
            assert_true(d.smooth[b] == 0 && d.smooth_error[b] == 0);
    }
}

/* The stochastic trace agrees with the exact density, smoothed by the same kernel, within its errors: of many
 * deviations over their errors the mean square is near 1. Signs of one vector are shared by all frequencies, so that
 * values of neighbours move together; those here are several widths of the kernel apart. */
TEST(test_kpm) {
    FREED(sp_packing) p = scattered_packing(2, 8, 0.5, 1);
    FREED(sp_network) net = default_network(&p);
    sp_dos_options o = sp_dos_options_default();
    FREED(sp_dos) exact = sp_dos_none(), d = sp_dos_none(), again = sp_dos_none();
    o.bins = 12;
    o.resolution = 0.1 * sp_network_omega_bound(&net) / o.bins;
    assert_ok(sp_dos_make(&net, &o, &exact, &err));
    o.method = SP_DOS_KPM;
    o.vectors = 40;
    double squares = 0, count = 0;
    for (int seed = 1; seed <= 8; seed++) {
        o.seed = (uint64_t)seed;
        assert_ok(sp_dos_make(&net, &o, &d, &err));
        assert_true(d.zero.total == -1 && d.vectors == 40 && d.moments == exact.moments);
        assert_close(d.cumulative[o.bins - 1], net.dof, 1e-10); /* every vector has all of them */
        for (int b = 0; b < o.bins; b++) {
            const double off = d.smooth[b] - exact.smooth[b];
            assert_true(d.smooth_error[b] > 0 || off == 0);
            if (exact.smooth[b] < 1e-3 * exact.smooth[2])
                continue;
            squares += off * off / (d.smooth_error[b] * d.smooth_error[b]);
            count++;
        }
        if (seed < 8)
            sp_dos_free(&d);
    }
    /* about 90 nearly independent squares with the mean 39/37: their mean has a standard deviation of 0.16 */
    assert_close(squares / count, 1.05, 0.5);
    o.threads = 3;
    assert_ok(sp_dos_make(&net, &o, &again, &err));
    for (int b = 0; b < o.bins; b++)
        assert_true(again.smooth[b] == d.smooth[b] && again.cumulative_error[b] == d.cumulative_error[b]);
}

/* Counting by inertia gives the histogram of all frequencies, and the zero modes: a packing without friction slides
 * along its walls. */
TEST(test_of_count) {
    for (int q = 0; q < 4; q++) {
        FREED(sp_packing) p = scattered_packing(q < 2 ? 2 : 3, q < 2 ? 6 : 3, q % 2 ? 0.5 : 0, 5);
        FREED(sp_network) net = default_network(&p);
        sp_dos_options o = sp_dos_options_default();
        FREED(sp_dos) exact = sp_dos_none(), d = sp_dos_none();
        o.bins = 31;
        o.norm = SP_DOS_MODES;
        o.method = SP_DOS_EXACT;
        assert_ok(sp_dos_make(&net, &o, &exact, &err));
        o.method = SP_DOS_COUNT;
        assert_ok(sp_dos_make(&net, &o, &d, &err));
        assert_int_equal(d.zero.total, exact.zero.total);
        assert_true(q % 2 || exact.zero.rigid == p.dim - 1);
        for (int b = 0; b < o.bins; b++) {
            assert_true(d.cumulative[b] == exact.cumulative[b] && d.density[b] == exact.density[b]);
            assert_true(d.cumulative_error[b] == 0 && d.smooth_error[b] > 0);
        }
    }
}

/* F^ of a single mode from its definition: sin(omega_n t) is 2 sum J_(2k+1)(Omega t) sin((2k+1) theta_n). */
static double complex line(double omega_max, int moments, bool velocity, double omega_n, double omega) {
    const double theta = asin(omega_n / omega_max), psi = asin(omega / omega_max), turn = M_PI / (2.0 * moments + 1);
    double complex sum = 0;
    for (int k = 0; k < moments; k++) {
        const double m = velocity ? 2 * k + 1 : 2 * k;
        const double g = ((2.0 * moments - m + 1) * cos(turn * m) + sin(turn * m) / tan(turn)) / (2.0 * moments + 1);
        const double part = velocity ? sin(m * theta) : (k == 0 ? 0.5 : 1) * cos(m * theta);
        sum += 2 * g * part * cexp(number(0, m * psi));
    }
    return sum / (omega_max * cos(psi));
}

/* Against the sum over all modes, for every source, within the error that is reported. */
TEST(test_transmission) {
    sp_packing all[] = {chain_packing(20, 1e-4), scattered_packing(2, 5, 0.5, 1), scattered_packing(3, 3, 0.3, 2)};
    for (int q = 0; q < 3; q++) {
        FREED(sp_network) net = default_network(&all[q]);
        for (int source = 0; source < 3; source++) {
            sp_transmission_options o = sp_transmission_options_default();
            FREED(sp_transmission) t = sp_transmission_none();
            const sp_modes_options mo = {.vectors = true, .source = (sp_source)source};
            FREED(sp_modes) m = sp_modes_none();
            o.source = (sp_source)source;
            o.points = 60;
            assert_ok(sp_transmission_make(&net, &o, &t, &err));
            assert_ok(sp_modes_dense(&net, &mo, &m, &err));
            const bool velocity = source != SP_SOURCE_DISPLACEMENT;
            double largest = 0, sizes = 0;
            for (int64_t n = 0; n < m.n; n++)
                sizes += fabs(m.a[n] * m.b[n]);
            for (int l = 0; l < t.n; l++)
                largest = fmax(largest, hypot(t.re[l], t.im[l]));
            for (int l = 0; l < t.n; l++) {
                double complex exact = 0;
                for (int64_t n = 0; n < m.n; n++)
                    exact += m.a[n] * m.b[n] * line(t.omega_max, (int)t.moments, velocity, m.omega[n], t.omega[l]);
                const double off = cabs(exact - number(t.re[l], t.im[l]));
                /* the modes' own error: amplitudes by LAPACK */
                const double modes = 1e-13 * sizes * (double)t.moments / t.omega_max;
                if (!(off <= t.error[l] + modes))
                    fail_msg("packing %d source %d omega %g: off by %g, bounds %g and %g", q, source, t.omega[l], off,
                             t.error[l], modes);
                assert_true(t.error[l] < 1e-9 * largest);
                assert_close(t.density[l], 2 / M_PI * (velocity ? t.im[l] : t.re[l]), 1e-14 * largest);
            }
        }
        sp_packing_free(&all[q]);
    }
}

/* The density is that of the signal: the integral of g sin(omega t) is F(t), but for the kernel, which multiplies it by
 * about exp(-(resolution t)^2/2). */
TEST(test_transmission_is_signal) {
    enum { POINTS = 11 };
    FREED(sp_packing) p = chain_packing(12, 1e-4);
    FREED(sp_network) net = default_network(&p);
    sp_transmission_options o = sp_transmission_options_default();
    FREED(sp_transmission) t = sp_transmission_none();
    sp_signal_options so = sp_signal_options_default();
    FREED(sp_signal) s = sp_signal_none();
    o.points = 20000;
    o.resolution = sp_network_omega_bound(&net) / 2000;
    so.until = 100;
    so.points = POINTS;
    assert_ok(sp_transmission_make(&net, &o, &t, &err));
    assert_ok(sp_signal_make(&net, &so, &s, &err));
    double peak = 0, worst = 0;
    for (int l = 0; l < POINTS; l++) {
        double f = 0;
        for (int q = 0; q < t.n; q++)
            f += t.density[q] * sin(t.omega[q] * s.t[l]) * t.omega_max / t.n;
        peak = fmax(peak, fabs(s.f[l]));
        worst = fmax(worst, fabs(f - s.f[l]));
    }
    assert_true(worst < 1e-3 * peak); /* (Omega/2000 x 100)^2/2 = 3e-4 */
}

/* Standing waves are the eigenmodes of a chain. */
TEST(test_dispersion_chain) {
    FREED(sp_packing) p = chain_packing(60, 1e-4);
    FREED(sp_network) net = default_network(&p);
    sp_dispersion_options o = sp_dispersion_options_default();
    sp_dispersion d = sp_dispersion_none();
    o.up = true;
    o.node = 0.5;
    o.waves = 60;
    o.profile = 500;
    assert_ok(sp_dispersion_make(&net, &o, &d, &err));
    assert_int_equal(d.n, 60);
    for (int q = 0; q < d.n; q++) {
        const sp_dispersion_point *w = &d.wave[q];
        const double exact = chain_frequency(&net, q + 1);
        assert_int_equal(w->polarization, SP_LONGITUDINAL);
        assert_close(w->k, M_PI * (q + 1) / (p.box[0] + 1), 1e-14);
        assert_relative(w->rms, exact, 1e-13);
        assert_true(w->spread < 3e-8 * d.omega_max / w->rms * d.omega_max); /* the root of rounding */
        assert_close(w->peak, exact, 0.02 * w->resolution);
        assert_close(w->half_width, 1.18 * w->resolution, 0.1 * w->resolution); /* the kernel's own */
        double sum = 0;
        for (int l = 0; l < d.profile; l++)
            sum += d.s[q * d.profile + l] * d.omega_max / d.profile;
        if (exact < 0.9 * d.omega_max) /* S ends in a root's singularity */
            assert_close(sum, 1, 2e-3);
    }
    sp_dispersion_free(&d);
    o.waves = 61; /* which has a node on every grain */
    assert_fails(sp_dispersion_make(&net, &o, &d, &err), SP_EREFUSED, "61");
}

TEST(test_participation) {
    FREED(sp_packing) p = chain_packing(30, 1e-4);
    FREED(sp_network) net = default_network(&p);
    const sp_modes_options o = sp_modes_options_default();
    FREED(sp_modes) m = sp_modes_none();
    sp_participation_bin bin[4];
    assert_ok(sp_modes_dense(&net, &o, &m, &err));
    assert_ok(sp_participation(&m, 4, 0, bin, &err));
    int64_t all = 0;
    for (int b = 0; b < 4; b++) {
        /* sines: 2 (N + 1)/(3 N), but for one that is commensurate with the chain */
        assert_true(bin[b].modes > 2);
        assert_close(bin[b].mean, 2.0 / 3 * 31 / 30, 0.02);
        assert_true(bin[b].least <= bin[b].mean && bin[b].mean <= bin[b].largest && bin[b].sd < 0.05);
        all += bin[b].modes;
    }
    assert_int_equal(all, 30);
    assert_fails(sp_participation(&m, 0, 0, bin, &err), SP_EINVAL, "bins 0");
}

/* One ball between two springs and dashpots: F = k (k + i omega c)/(2 k - omega^2 m + 2 i omega c). */
TEST(test_harmonic_ball) {
    FREED(sp_packing) p = chain_packing(1, 1e-4);
    FREED(sp_network) net = default_network(&p);
    const double k = net.springs[0].kn, m = net.mass[0], own = sqrt(2 * k / m);
    const double omega[] = {0.01 * own, 0.9 * own, 0.999999 * own, own, 3 * own};
    for (int q = 0; q < 3; q++) {
        sp_harmonic_options o = sp_harmonic_options_default();
        FREED(sp_harmonic) h = sp_harmonic_none();
        const double zeta[] = {0, 1e-3, 0.8};
        o.damping = zeta[q];
        o.omega = omega;
        o.n = zeta[q] > 0 ? 5 : 3;
        assert_ok(sp_harmonic_make(&net, &o, &h, &err));
        for (int l = 0; l < h.n; l++) {
            const double c = 2 * o.damping * sqrt(m * k);
            const double complex f =
                k * number(k, omega[l] * c) / number(2 * k - omega[l] * omega[l] * m, 2 * omega[l] * c);
            const double off = cabs(f - number(h.f[2 * l], h.f[2 * l + 1]));
            assert_true(off <= h.error[l] + 1e-15 * cabs(f) / fmax(1e-6, fabs(1 - omega[l] / own)));
            assert_true(h.error[l] < 1e-8 * cabs(f));
        }
    }
    sp_harmonic_options o = sp_harmonic_options_default();
    sp_harmonic h = sp_harmonic_none();
    o.omega = &own; /* the resonance */
    o.n = 1;
    assert_fails(sp_harmonic_make(&net, &o, &h, &err), SP_EREFUSED, "omega");
}

/* Waves in a chain whose dashpots are those of its inside: 2 (K + i omega c)(1 - cos q) = m omega^2. The fit finds q
 * between the reflecting walls. */
TEST(test_attenuation) {
    enum { GRAINS = 60, FREQUENCIES = 7 };
    FREED(sp_packing) p = chain_packing(GRAINS, 1e-4);
    FREED(sp_network) net = default_network(&p);
    const double k = net.springs[0].kn, m = net.mass[0], top = 2 * sqrt(k / m);
    double omega[FREQUENCIES];
    sp_harmonic_options o = sp_harmonic_options_default();
    sp_harmonic h = sp_harmonic_none();
    for (int l = 0; l < FREQUENCIES; l++)
        omega[l] = top * (l + 1) / (FREQUENCIES + 1);
    o.omega = omega;
    o.n = FREQUENCIES;
    o.planes = GRAINS - 1; /* one between any two grains */
    for (int q = 0; q < 2; q++) {
        o.damping = q == 0 ? 0.02 : 0;
        assert_ok(sp_harmonic_make(&net, &o, &h, &err));
        const double step = h.height[1] - h.height[0], c = 2 * o.damping * sqrt(0.5 * m * k);
        for (int l = 0; l < FREQUENCIES; l++) {
            const double complex cosine = 1 - m * omega[l] * omega[l] / (2 * number(k, omega[l] * c));
            const double complex wave = cacos(cosine); /* a grain */
            assert_close(h.fit[l].k * step, fabs(creal(wave)), 1e-9);
            assert_close(h.fit[l].alpha * step, o.damping > 0 ? fabs(cimag(wave)) : 0, 1e-9);
            assert_true(h.fit[l].misfit < 1e-16);
        }
        sp_harmonic_free(&h);
    }
}

/* Every allocation that fails is told, and nothing leaks (under the sanitizers). */
TEST(test_no_memory) {
    FREED(sp_packing) p = scattered_packing(2, 3, 0.5, 1);
    FREED(sp_network) net = default_network(&p);
    const double omega = 0.3;
    sp_dos_options dos = sp_dos_options_default();
    sp_harmonic_options ho = sp_harmonic_options_default();
    const sp_transmission_options to = sp_transmission_options_default();
    const sp_dispersion_options wo = sp_dispersion_options_default();
    sp_dos d = sp_dos_none();
    sp_transmission t = sp_transmission_none();
    sp_dispersion w = sp_dispersion_none();
    sp_harmonic h = sp_harmonic_none();
    ho.omega = &omega;
    ho.n = 1;
    ho.damping = 0.1;
    dos.method = SP_DOS_KPM;
    dos.vectors = 4;
    EACH_ALLOCATION_FAILS(4, sp_dos_make(&net, &dos, &d, &err), sp_dos_free(&d));
    EACH_ALLOCATION_FAILS(4, sp_transmission_make(&net, &to, &t, &err), sp_transmission_free(&t));
    EACH_ALLOCATION_FAILS(4, sp_dispersion_make(&net, &wo, &w, &err), sp_dispersion_free(&w));
    EACH_ALLOCATION_FAILS(4, sp_harmonic_make(&net, &ho, &h, &err), sp_harmonic_free(&h));
}

/* A negative omega^2 is told by every method. */
TEST(test_unstable) {
    FREED(sp_packing) p = scattered_packing(2, 4, 0.5, 1);
    FREED(sp_network) net = default_network(&p);
    net.prestress = true;
    for (int k = 0; k < net.n_bulk; k++)
        net.springs[k].kp = -1.5 * net.springs[k].kn;
    assert_ok(sp_network_find_bounds(&net, &err));
    sp_dos d = sp_dos_none();
    sp_transmission t = sp_transmission_none();
    sp_dispersion w = sp_dispersion_none();
    const sp_transmission_options to = sp_transmission_options_default();
    const sp_dispersion_options wo = sp_dispersion_options_default();
    sp_dos_options o = sp_dos_options_default();
    for (int method = SP_DOS_EXACT; method <= SP_DOS_COUNT; method++) {
        o.method = (sp_dos_method)method;
        assert_fails(sp_dos_make(&net, &o, &d, &err), SP_EREFUSED, "");
    }
    assert_fails(sp_transmission_make(&net, &to, &t, &err), SP_EREFUSED, "");
    assert_fails(sp_dispersion_make(&net, &wo, &w, &err), SP_EREFUSED, "");
}

TEST(test_refusals) {
    FREED(sp_packing) p = scattered_packing(2, 3, 0.5, 1);
    FREED(sp_network) net = default_network(&p);
    const double bad[] = {NAN, INFINITY, -1}, omega = 0.3;
    sp_dos d;
    sp_transmission t;
    sp_dispersion w;
    sp_harmonic h;
#define WRONG(kind, change, out, words)                                                                                \
    do {                                                                                                               \
        sp_##kind##_options o = sp_##kind##_options_default();                                                         \
        change;                                                                                                        \
        assert_fails(sp_##kind##_make(&net, &o, out, &err), SP_EINVAL, words);                                         \
    } while (0)
    for (int k = 0; k < 3; k++) {
        WRONG(dos, o.resolution = bad[k], &d, "resolution");
        WRONG(dos, o.until = bad[k], &d, "until");
        WRONG(transmission, o.resolution = bad[k], &t, "resolution");
        WRONG(dispersion, o.resolution = bad[k], &w, "resolution");
        WRONG(harmonic, (o.omega = &bad[k], o.n = 1), &h, "omega");
        WRONG(harmonic, (o.omega = &omega, o.n = 1, o.damping = bad[k]), &h, "damping");
    }
    WRONG(dos, o.vectors = 3, &d, "vectors 3");
    WRONG(dos, o.resolution = 1e-12, &d, "moments");
#undef WRONG
}

RUN_TESTS(NULL, NULL)
