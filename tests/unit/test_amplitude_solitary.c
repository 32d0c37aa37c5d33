/* Solitary waves of chains: their limits, and that the motion of a chain carries them without change. */
#include "amplitude/loud_motion.h"
#include "base/base.h"
#include "carried.h"

#include <sonopack/amplitude.h>

/* Weak waves are those of Korteweg and de Vries: what is missing in the speed goes as the square of the peak, in the
 * width as the peak. */
TEST(test_weak) {
    sp_solitary a, b;
    assert_ok(sp_solitary_make(0.002, &a, &err));
    assert_ok(sp_solitary_make(0.02, &b, &err));
    assert_true(a.error < 1e-7 && b.error < 1e-7);
    assert_close((b.kdv - b.speed) / (a.kdv - a.speed), 100, 2);
    assert_close((b.width / b.kdv_width - 1) / (a.width / a.kdv_width - 1), 10, 0.2);
    assert_relative(a.speed - 1, 0.002 / 12, 1e-3);
    assert_close(a.kdv, sqrt(1 + 0.002 / 6), 1e-15);
    assert_true(fabs(a.nesterenko - a.speed) < 0.02 * fabs(a.kdv - a.speed) + 1e-8);
}

/* Strong waves tend to that of a chain without force at rest, whose form does not depend on its strength. */
TEST(test_strong) {
    sp_solitary a, b, bare;
    assert_ok(sp_solitary_make(1e6, &a, &err));
    assert_ok(sp_solitary_make(1e9, &b, &err));
    assert_ok(sp_solitary_make(INFINITY, &bare, &err));
    assert_relative(b.speed_at_peak, bare.speed_at_peak, 1e-8);
    assert_relative(b.velocity_at_peak, bare.velocity_at_peak, 1e-8);
    assert_relative(b.width, bare.width, 1e-7);
    assert_true(fabs(a.speed_at_peak - bare.speed_at_peak) > 100 * fabs(b.speed_at_peak - bare.speed_at_peak));
    assert_close(bare.nesterenko_at_peak, sqrt(8.0 / 15), 1e-15);
    assert_true(isinf(bare.speed) && bare.error < 1e-12);
    /* V = 0.6802 (2 E/(a rho^(3/2)(1 - nu^2)))^(1/3) F^(1/6), (1.112) of Nesterenko 2001, in units E* = a = rho = 1 */
    const double force = 1, overlap = pow(3 * force, 2.0 / 3), sound = sqrt(0.5 * sqrt(overlap) / (M_PI / 6));
    assert_relative(bare.nesterenko_at_peak * sound, 0.6802 * cbrt(2), 1e-4);
}

/* The numbers agree with the form: the half width, and both lengths of the identity of momentum. */
TEST(test_form) {
    enum { N = 4001 };
    double *x = calloc(N, sizeof *x), *r = calloc(N, sizeof *r), *v = calloc(N, sizeof *v), half, at;
    for (int q = 0; q < 3; q++) {
        const double peak = (const double[]){0.1, 10, INFINITY}[q];
        sp_solitary s;
        double sum_r = 0, sum_v = 0;
        assert_ok(sp_solitary_make(peak, &s, &err));
        for (int k = 0; k < N; k++)
            x[k] = 0.05 * (k - N / 2);
        assert_ok(sp_solitary_form(peak, N, x, r, v, &err));
        assert_close(r[N / 2], 1, 1e-12);
        assert_close(v[N / 2], 1, 1e-12);
        for (int k = 0; k < N; k++) {
            assert_true(r[k] > -1e-12 && r[k] <= 1 + 1e-12);
            assert_close(r[k], r[N - 1 - k], 1e-12);
            sum_r += r[k];
            sum_v += v[k];
        }
        /* r is the difference of displacements, v = -s times their slope: s sum r = sum v, each in its unit */
        if (q < 2)
            assert_relative(sum_v * s.velocity, sum_r * s.speed * peak, 1e-9);
        half = 0.5 * s.width;
        assert_ok(sp_solitary_form(peak, 1, &half, &at, v, &err));
        assert_close(at, 0.5, 1e-9);
    }
    free(x);
    free(r);
    free(v);
}

/* Puts the wave into a chain, its middle at the contact of balls 50 and 51. The balls behind it have been moved on. */
static void put_wave(motion *s, double peak, double overlap, double sound) {
    enum { N = 160 };
    double x[N + 1], r[N + 1], v[N + 1], ball[N + 1], unused[N + 1], moved = 0;
    sp_solitary wave;
    assert_ok(sp_solitary_make(peak, &wave, &err));
    for (int k = 0; k <= N; k++) {
        x[k] = k - 50.5; /* of contact k, below ball k; the ball is half a step above */
        ball[k] = x[k] + 0.5;
    }
    assert_ok(sp_solitary_form(peak, N + 1, x, r, unused, &err));
    assert_ok(sp_solitary_form(peak, N + 1, ball, unused, v, &err));
    sp_motion_rest(s);
    for (int i = N - 1; i >= 0; i--) {
        moved += r[i + 1] * peak * overlap;
        s->m.u[6 * i] = moved;
        s->m.v[6 * i] = v[i] * wave.velocity * sound * overlap;
    }
    moved += r[0] * peak * overlap;
    for (int k = 0; k < s->m.count; k++)
        if (s->m.touch[k].j == SP_BOTTOM)
            s->m.touch[k].shift[0] = moved;
    sp_vibration_begin(&s->m);
}

/* After the time of 60 balls every contact has the overlap that the one 60 below it had. */
TEST(test_travels) {
    enum { N = 160, FAR = 60, STEPS = 60000 };
    const double peaks[] = {0.1, 0.5, 20};
    FREED(sp_packing) p = chain_packing(N, 1e-6);
    FREED(sp_network) net = carried_network(&p);
    const double overlap = p.contacts[0].overlap, sound = sqrt(net.springs[0].kn / grain_mass(0.5));
    motion s;
    assert_ok(sp_motion_make(&p, &net, SP_MOTION_NEAR, 0, NULL, &s, &err));
    for (int q = 0; q < 3; q += SANITIZED_STEP(3)) {
        sp_solitary wave;
        double before[N];
        assert_ok(sp_solitary_make(peaks[q], &wave, &err));
        put_wave(&s, peaks[q], overlap, sound);
        for (int i = 0; i < N - 1; i++)
            before[i] = s.m.u[6 * i] - s.m.u[6 * (i + 1)];
        double shift = 0;
        for (int k = 0; k < s.m.count; k++)
            shift = s.m.touch[k].j == SP_BOTTOM ? s.m.touch[k].shift[0] : shift;
        for (int k = 0; k < STEPS; k++)
            sp_motion_step(&s, FAR / (wave.speed * sound) / STEPS, shift);
        for (int i = 0; i < N - 1; i++) {
            const double now = s.m.u[6 * i] - s.m.u[6 * (i + 1)], right = i >= FAR ? before[i - FAR] : 0;
            assert_close(now / overlap / peaks[q], right / overlap / peaks[q], 3e-6);
        }
    }
    sp_motion_free(&s);
}

/* A hard knock ends in such a wave: `planes' measures its speed from plane to plane. */
TEST(test_knock) {
    FREED(sp_packing) p = chain_packing(100, 1e-9);
    sp_amplitude_options o = sp_amplitude_options_default();
    sp_amplitude_plane a[2];
    sp_amplitude_front top;
    const double heights[] = {50, 80}, twice[] = {50, 50.1}, outside[] = {50, 120};
    o.tolerance = 1e-4;
    assert_ok(sp_amplitude_planes(&p, &o, 300, 2, heights, a, &top, &err));
    const double overlap = p.contacts[0].overlap, k = contact_normal_stiffness(contact_stiffness(0.5, 0.5), overlap);
    const double sound = sqrt(k / grain_mass(0.5)) * (1 - overlap);
    sp_solitary wave;
    assert_ok(sp_solitary_make(pow(1 + a[1].overpressure.value, 2.0 / 3) - 1, &wave, &err));
    assert_relative(a[1].speed_peak.value, wave.speed * sound, 1e-3);
    assert_relative(a[1].speed.value, wave.speed * sound, 1e-3);
    assert_true(fabs(wave.nesterenko / wave.speed - 1) > 5e-3 && isnan(a[0].speed.value));
    assert_true(top.t10.value > a[1].t10.value && a[1].overpressure.error < 1e-2 * a[1].overpressure.value);
    assert_fails(sp_amplitude_planes(&p, &o, 1, 2, twice, a, NULL, &err), SP_EINVAL, "height");
    assert_fails(sp_amplitude_planes(&p, &o, 1, 2, outside, a, NULL, &err), SP_EINVAL, "height");
}

TEST(test_bad_input) {
    const double bad[] = {0, -1, 1e-5, 1e10, NAN, -INFINITY};
    double x = 0, y, z;
    sp_solitary s;
    for (int k = 0; k < 6; k++) {
        assert_fails(sp_solitary_make(bad[k], &s, &err), SP_EINVAL, "peak");
        assert_fails(sp_solitary_form(bad[k], 1, &x, &y, &z, &err), SP_EINVAL, "peak");
    }
    sp_alloc_fail_after(0);
    const sp_status status = sp_solitary_make(1, &s, NULL);
    sp_alloc_fail_after(-1);
    assert_int_equal(status, SP_ENOMEM);
}

RUN_TESTS(NULL, NULL)
