/* Harmonics of bursts: a chain against the second order of its equation of motion, the linear limit, bad input. */
#include "base/base.h"
#include "carried.h"
#include "signals.h"

#include <complex.h>
#include <sonopack/amplitude.h>
#include <sonopack/pulse.h>

/* F2/F1^2, over the force at rest, at the contact above ball n - 1 of a half-infinite chain whose wall, ball -1, moves
 * with omega alone. The force F = K (r + r^2/(4 delta0)) of a wave r = R cos(kn - omega t) drives a wave of 2 omega and
 * 2 k; a free wave of 2 omega keeps the wall from it. */
static double second_order(double omega, double highest, double n) {
    const double k = 2 * asin(omega / highest), free_k = 2 * asin(2 * omega / highest);
    const double half = sin(0.5 * k), tangent = tan(0.5 * k);
    const double bound = 1 / (8 * half * half), stretch = 1 / (8 * tangent * tangent);
    const double complex ball = stretch / (cexp(-2 * I * k) - 1), back = -ball * cexp(I * (free_k - 2 * k));
    const double complex wave = back * (cexp(-I * free_k) - 1) * cexp(I * free_k * n);
    return cabs(bound * cexp(2 * I * k * n) + wave) / 1.5; /* K delta0 = 3/2 F0 */
}

/* The longer the burst, the nearer it is to a wave without end. */
TEST(test_chain) {
    const double heights[] = {20, 40, 60};
    FREED(sp_packing) p = chain_packing(200, 1e-6);
    FREED(sp_network) net = carried_network(&p);
    const double highest = 2 * sqrt(net.springs[0].kn / grain_mass(0.5)), length = 1 - p.contacts[0].overlap;
    const double omega = 0.3 * highest;
    double off[2];
    for (int q = 0; q < 2; q++) {
        const sp_amplitude_burst burst = {1e-3, omega, q ? 12 : 6};
        sp_amplitude_options o = sp_amplitude_options_default();
        sp_amplitude_harmonics h[3];
        sp_amplitude_second second;
        assert_ok(sp_amplitude_bursts(&p, &o, &burst, 3, heights, h, &second, &err));
        off[q] = 0;
        for (int b = 0; b < 3; b++) {
            const double right = second_order(omega, highest, h[b].height / length);
            off[q] = fmax(off[q], fabs(h[b].ratio.value / right - 1));
            assert_true(h[b].ratio.error < 2e-2 * right && h[b].third.value < 0.2 * h[b].second.value);
            assert_relative(h[b].first.value, 1.5 * 1e-3 * 2 * sin(asin(0.3)), 3e-3);
        }
        assert_relative(second.k.value, 2 * asin(0.3) / length, 2e-3);
        assert_true(second.energy.defect < 1e-3 && second.energy.input > 0);
    }
    assert_true(off[0] < 0.05 && off[1] < 0.5 * off[0]);
}

/* Long waves: beta delta0/d = 1/2, up to their dispersion. */
TEST(test_beta) {
    SKIP_SANITIZED();
    FREED(sp_packing) p = chain_packing(300, 1e-6);
    const double highest = 2 * sqrt(2 * contact_stiffness(0.5, 0.5) * sqrt(p.contacts[0].overlap) / grain_mass(0.5));
    const sp_amplitude_burst burst = {1e-2, 0.06 * highest, 5};
    sp_amplitude_options o = sp_amplitude_options_default();
    sp_amplitude_harmonics h[10];
    sp_amplitude_second second;
    assert_ok(sp_amplitude_bursts(&p, &o, &burst, 10, NULL, h, &second, &err));
    assert_relative(second.beta.value * p.contacts[0].overlap, 0.5, 0.05);
    assert_true(second.beta.error < 0.05 * second.beta.value);
    assert_relative(second.speed.value, 0.5 * highest, 1e-2);
}

/* A quiet burst has the first harmonic of the linear signal, in a packing with friction. */
TEST(test_linear) {
    const double heights[] = {1.2, 2}, omega = 0.67, quiet = 1e-6;
    FREED(sp_packing) p = reference_packing(REFERENCE("packing_N200_p1e-4.txt"));
    FREED(sp_network) net = carried_network(&p);
    const sp_amplitude_burst burst = {quiet, omega, 3};
    sp_amplitude_options o = sp_amplitude_options_default();
    sp_amplitude_harmonics h[2];
    double overlap = 0;
    assert_ok(sp_amplitude_bursts(&p, &o, &burst, 2, heights, h, NULL, &err));
    for (int k = 0; k < net.n_springs; k++)
        overlap += p.contacts[net.springs[k].contact].overlap / net.n_springs;
    sp_place place[2] = {{.kind = SP_PLACE_PLANE, .height = 1.2}, {.kind = SP_PLACE_PLANE, .height = 2}};
    const sp_pulse pulse = {.kind = SP_PULSE_SINE, .omega = omega, .cycles = 3};
    sp_signal_options linear = sp_signal_options_default();
    sp_signal s = sp_signal_none();
    linear.tolerance = 1e-6;
    linear.points = 2001;
    linear.detectors = 2;
    linear.to = place;
    for (int b = 0; b < 2; b++) {
        linear.until = h[b].until;
        assert_ok(sp_signal_pulse(&net, &linear, &pulse, &s, &err));
        double complex sum = 0;
        for (int l = 0; l < s.n; l++)
            sum += s.f[b * s.n + l] * cexp(-I * (omega * s.t[l])) * h[b].until / (s.n - 1);
        const double first = cabs(sum) * 4 * omega / (6 * M_PI) * quiet * overlap / (p.pressure * p.box[0]);
        assert_relative(h[b].first.value, first, 5e-3);
        sp_signal_free(&s);
    }
}

TEST(test_bad_input) {
    FREED(sp_packing) p = chain_packing(100, 1e-6);
    sp_amplitude_options o = sp_amplitude_options_default();
    sp_amplitude_harmonics h[3];
    sp_amplitude_second second;
    const double high[] = {10, 20, 95}, same[] = {10, 10.1, 20}, far[] = {10, 20, 200};
    const struct {
        sp_amplitude_burst burst;
        int32_t n;
        const double *height;
        sp_status status;
        const char *word;
    } bad[] = {{{0, 0.05, 4}, 3, NULL, SP_EINVAL, "amplitude"},   {{1e-3, -1, 4}, 3, NULL, SP_EINVAL, "omega"},
               {{1e-3, NAN, 4}, 3, NULL, SP_EINVAL, "omega"},     {{1e-3, 5, 4}, 3, NULL, SP_EREFUSED, "omega"},
               {{1e-3, 0.05, 2}, 3, NULL, SP_EINVAL, "cycles"},   {{1e-3, 0.05, 1000}, 3, NULL, SP_EREFUSED, "cycles"},
               {{1e-3, 0.05, 4}, 2, NULL, SP_EINVAL, "planes"},   {{1e-3, 0.05, 4}, 3, high, SP_EREFUSED, "cycles"},
               {{1e-3, 0.05, 4}, 3, same, SP_EINVAL, "height"},   {{1e-3, 0.05, 4}, 3, far, SP_EINVAL, "height"},
               {{1e5, 0.05, 4}, 3, NULL, SP_EFAILED, "amplitude"}};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
        assert_fails(sp_amplitude_bursts(&p, &o, &bad[k].burst, bad[k].n, bad[k].height, h, &second, &err),
                     bad[k].status, bad[k].word);
    const sp_amplitude_burst good = {1e-3, 0.05, 4};
    o.tolerance = 1;
    assert_fails(sp_amplitude_bursts(&p, &o, &good, 3, NULL, h, &second, &err), SP_EINVAL, "tolerance");
    o.tolerance = 0.05;
    EACH_ALLOCATION_FAILS(8, sp_amplitude_bursts(&p, &o, &good, 3, NULL, h, &second, &err), );
}

RUN_TESTS(NULL, NULL)
