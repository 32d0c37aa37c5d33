/* Statistics of packings in three dimensions: near jamming as published, far enough from the walls, and the same by the
 * kernel as by the plain path. benchmarks/spheres makes the table with larger boxes. */
#include "making.h"

#include "base/base.h"

#include <sonopack/packing.h>

static sp_statics statics_of(const sp_packing *p, double margin) {
    sp_statics s;
    assert_ok(sp_statics_make(p, 1e-4, margin, &s, &err));
    return s;
}

static sp_packing make_equal(double friction, double pressure) {
    sp_pack_spec spec = spheres(1000, 8, friction, 1);
    spec.diameter_min = spec.diameter_max = 1;
    spec.pressure = pressure;
    sp_packing p = make_packing(&spec);
    const sp_statics s = statics_of(&p, 3);
    printf("mu = %g, p = %g: z %.3f, phi %.4f, rattlers %.2f%%\n", friction, pressure, s.zs, s.phi3, s.f0);
    return p;
}

/* Frictionless spheres: z -> 6 and phi -> 0.639 as p -> 0 (Agnolin and Roux, Phys. Rev. E 76, 061302, 2007), z - 6 ~
 * (phi - phi_c)^(1/2) and p ~ (phi - phi_c)^(3/2) (O'Hern et al., Phys. Rev. E 68, 011306, 2003), so that z - 6 ~
 * p^(1/3), 2.15 a decade. One box of 500 grains in the bulk leaves z to 0.1 and phi to 0.005. */
TEST(test_jamming) {
    FREED(sp_packing) high = make_equal(0, 1e-4), low = make_equal(0, 1e-5);
    const sp_statics a = statics_of(&high, 3), b = statics_of(&low, 3);
    assert_true(a.zs > 6.45 && a.zs < 7);
    assert_true(b.zs > 6.15 && b.zs < 6.55);
    assert_close((a.zs - 6) / (b.zs - 6), cbrt(10), 0.7);
    assert_close(a.phi3, 0.650, 0.012);
    assert_close(b.phi3, 0.642, 0.012);
    /* what is left out at the walls is enough: more of it changes nothing beyond the noise of a smaller bulk */
    const sp_statics inner = statics_of(&high, 4);
    assert_close(inner.zs, a.zs, 0.15);
    assert_close(inner.phi3, a.phi3, 0.008);
}

/* With friction spheres stop earlier: z between 4 and 6 and phi near 0.59 (0.593 at mu = 0.3 and low pressure, Agnolin
 * and Roux). */
TEST(test_friction) {
    FREED(sp_packing) p = make_equal(0.5, 1e-4);
    const sp_statics s = statics_of(&p, 3);
    assert_true(s.zs > 4.6 && s.zs < 5.3);
    assert_close(s.phi3, 0.595, 0.015);
    assert_true(s.f0 > 1 && s.f0 < 12);
}

enum { SAMPLES = 40, QUANTITIES = 6 };

static void sample(bool reference, double friction, uint64_t seed, double value[QUANTITIES]) {
    sp_pack_spec spec = spheres(100, 5, friction, 1);
    spec.seed = seed;
    spec.reference = reference;
    spec.tolerance = 1e-4 * spec.pressure;
    FREED(sp_packing) p = make_packing(&spec);
    const sp_statics s = statics_of(&p, 0.5);
    const double values[QUANTITIES] = {sp_packing_height(&p), s.zs, s.f0, s.n_over_p, s.z2, s.s1_over_s2};
    memcpy(value, values, sizeof values);
}

/* Means of samples by the two paths, within three standard errors of the difference: one of 160 such numbers lies
 * outside by chance; the seeds are fixed. */
TEST(test_paths_agree) {
    static const char *const name[QUANTITIES] = {"height", "z", "f0", "N/p", "Z2", "s1/s2"};
    for (int k = 0; k < 2; k++) {
        double sum[2][QUANTITIES] = {{0}}, square[2][QUANTITIES] = {{0}};
        for (int path = 0; path < 2; path++)
            for (uint64_t seed = 1; seed <= SAMPLES; seed++) {
                double value[QUANTITIES];
                sample(path == 1, k == 0 ? 0.5 : 0, 1000 * (uint64_t)(path + 1) + seed, value);
                for (int q = 0; q < QUANTITIES; q++) {
                    sum[path][q] += value[q] / SAMPLES;
                    square[path][q] += value[q] * value[q] / SAMPLES;
                }
            }
        for (int q = 0; q < QUANTITIES; q++) {
            const double variance = square[0][q] - sum[0][q] * sum[0][q] + square[1][q] - sum[1][q] * sum[1][q];
            const double error = sqrt(variance / (SAMPLES - 1)), off = sum[0][q] - sum[1][q];
            printf("mu = %s: %s: kernel %.4f, plain %.4f, %+.2f standard errors\n", k == 0 ? "0.5" : "0", name[q],
                   sum[0][q], sum[1][q], off / error);
            assert_true(fabs(off) <= 3 * error);
        }
    }
}

RUN_TESTS(NULL, NULL)
