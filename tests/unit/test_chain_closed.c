/* The chain of equal balls in closed form: against its modes, against Bessel functions in long double, against a row of
 * balls in the general network, and in the limit of an infinite length. */
#include "base/base.h"
#include "extended.h"
#include "numeric/bessel.h"
#include "reference.h"

#include <float.h>
#include <sonopack/chain.h>

static const long double PI = 3.14159265358979323846264338L;
static const sp_chain_source sources[] = {SP_CHAIN_VELOCITY, SP_CHAIN_DISPLACEMENT};

/* Abramowitz and Stegun, table 10.11 and 10.13: values, zeros and extrema. */
TEST(test_airy_tabulated) {
    const double at[][3] = {{0, 0.35502805388781724, -0.25881940379280680},
                            {1, 0.13529241631288142, -0.15914744129679321},
                            {-2.338107410459767, 0, 0.70121082272069},
                            {-1.018792971647471, 0.53565665601569, 0},
                            {-4.087949444130971, 0, -0.80311136965486},
                            {-9.02265085334098, 0, -0.97792280856950}}; /* by the asymptotic series */
    for (size_t k = 0; k < sizeof at / sizeof *at; k++) {
        double ai, slope;
        sp_airy(at[k][0], &ai, &slope);
        assert_close(ai, at[k][1], 2e-14);
        assert_close(slope, at[k][2], 2e-14);
    }
}

/* The power series at 0 in long double, which loses exp(2 zeta) of its 19 digits for x > 0. Both sides of the place at
 * 9 where one form takes over from another, and of the edges between two integers. */
TEST(test_airy_series) {
    for (double x = -9.5; x <= 4.6; x += 0.0625) {
        long double f = 1, g = x, df = 0, dg = 1, a = 1, b = x;
        const long double x3 = (long double)x * x * x, c1 = 0.355028053887817239260063186004183177L,
                          c2 = 0.258819403792806798405183560189203963L;
        for (int k = 1; k < 200; k++) {
            a *= x3 / ((3 * k - 1) * (3 * k));
            b *= x3 / ((3 * k) * (3 * k + 1));
            f += a;
            g += b;
            df += x == 0 ? 0 : 3 * k * a / x;
            dg += x == 0 ? 0 : (3 * k + 1) * b / x;
        }
        double ai, slope;
        sp_airy(x, &ai, &slope);
        const double zeta = 2.0 / 3 * fabs(x) * sqrt(fabs(x)), grown = exp(zeta);
        const double loss = (double)LDBL_EPSILON * 20 * grown, scale = x > 0 ? 1 / grown : 1;
        assert_close(ai, (double)(c1 * f - c2 * g), loss + 4 * DBL_EPSILON * scale);
        assert_close(slope, (double)(c1 * df - c2 * dg), (loss + 4 * DBL_EPSILON * scale) * (1 + fabs(x)));
    }
    double ai, slope, next, next_slope;
    for (int side = -1; side <= 1; side += 2) {
        sp_airy(side * 9, &ai, &slope);
        sp_airy(side * nextafter(9, 10), &next, &next_slope);
        assert_close(next, ai, 1e-14 * fabs(ai) + (side < 0 ? 3e-15 : 0)); /* of the phase, 18 */
        assert_close(next_slope, slope, 3e-14 * fabs(slope));
    }
    sp_airy(2000, &ai, &slope);
    assert_true(ai == 0 && slope == 0);
}

/* (C2) and (C5), every mode to a few ulp of itself, also of those near the end of the spectrum. */
TEST(test_modes) {
    const int64_t sizes[] = {1, 2, 50, 1000000, 1000000000};
    for (size_t q = 0; q < sizeof sizes / sizeof *sizes; q++)
        for (int64_t k = 0; k < 50; k++) {
            const int64_t size = sizes[q], n = k < 25 ? 1 + k % size : size - k % size;
            const long double wave = (long double)n * PI / (long double)(size + 1);
            assert_relative(sp_chain_omega(size, n), (double)(2 * sinl(wave / 2)), 4 * DBL_EPSILON);
            /* a cosine near pi/2 is as good as its argument, 1e-19 */
            assert_close(sp_chain_amplitude(size, n, SP_CHAIN_VELOCITY), (double)(2 * cosl(wave / 2) / (size + 1)),
                         (4 * DBL_EPSILON * (double)cosl(wave / 2) + 1e-18) * 2 / (double)size);
            assert_close(sp_chain_amplitude(size, n, SP_CHAIN_DISPLACEMENT), (double)(2 * sinl(wave) / (size + 1)),
                         (4 * DBL_EPSILON * (double)sinl(wave) + 1e-18) * 2 / (double)size);
        }
}

/* Against a longer recurrence in long double: the front at 10^5 balls, and its first echo. The promised bound. */
TEST(test_long_chain) {
    enum { N = 100000, L = N + 1, ORDERS = 2 * 3 * L + 10, POINTS = 6 };
    const double t[POINTS] = {L - 100, L - 3.5, L + 20, 1.5 * L, 3 * L - 60, 3.0 * L};
    double f[2][POINTS];
    RELEASED extended *j = calloc(ORDERS, sizeof *j);
    for (int s = 0; s < 2; s++)
        assert_ok(sp_chain_signal(N, sources[s], POINTS, t, f[s], &err));
    for (int l = 0; l < POINTS; l++) {
        extended a = 0, b = 0;
        extended_bessel(2 * (extended)t[l], ORDERS, j);
        for (int m = L; m <= 3 * L; m += 2 * L) {
            a += j[2 * m - 3] + j[2 * m - 1] - j[2 * m + 1] - j[2 * m + 3];
            b += j[2 * m - 4] - 2 * j[2 * m] + j[2 * m + 4];
        }
        printf("t = %.8g: F_A off by %.2g, F_B by %.2g\n", t[l], f[0][l] - (double)a, f[1][l] - (double)b);
        assert_close(f[0][l], (double)a, 1e-15 * (1 + sqrt(sqrt(t[l]))));
        assert_close(f[1][l], (double)b, 1e-15 * (1 + sqrt(sqrt(t[l]))));
        if (l < 3) { /* before the front, the error is of the Bessel functions there: 1e-12 of the peak */
            assert_close(f[0][l], (double)a, 1e-12 * 2.07 * pow(N, -2.0 / 3));
            assert_close(f[1][l], (double)b, 1e-12 * 2.19 / N);
        }
    }
}

/* The general network, expansion and all, of a row of balls: with K l/c = sqrt(K m) in its units, a first ball of speed
 * K/m has a signal sqrt(K/m) K F_A, a displacement K makes K^2 F_B; with other springs at the walls, source and first
 * ball are that many times as strong. Several echoes. */
TEST(test_network) {
    enum { POINTS = 900 };
    const double walls[] = {1, 0.2, 0.62, 1.6, 1.99};
    const int sizes[] = {2, 9, 300};
    for (size_t q = 0; q < sizeof walls / sizeof *walls * 3; q++) {
        const int n = sizes[q % 3];
        const double wall = walls[q / 3];
        FREED(sp_packing) p = chain_packing(n, 1e-4);
        for (int l = 0; l <= n; l++)
            if (p.contacts[l].j < 0) { /* k_n grows as the root of the overlap */
                p.contacts[l].overlap *= wall * wall;
                p.contacts[l].fn *= wall * wall * wall;
            }
        sp_network_options how = sp_network_options_default();
        FREED(sp_network) net = sp_network_none();
        assert_ok(sp_network_make(&p, &how, &net, &err));
        double k = 0;
        for (int l = 0; l <= n; l++)
            k = net.springs[l].j < 0 ? k : net.springs[l].kn;
        const double m = net.mass[0], rate = sqrt(k / m);
        for (int l = 0; l <= n; l++)
            assert_relative(net.springs[l].kn, net.springs[l].j < 0 ? wall * k : k, 1e-15);
        for (int s = 0; s < 2; s++) {
            const sp_chain chain = {.grains = n, .source = sources[s], .wall = wall};
            const double force = k * wall * (s ? k : rate);
            sp_signal_options o = sp_signal_options_default();
            FREED(sp_signal) signal = sp_signal_none();
            double t[POINTS], f[POINTS];
            o.source = s ? SP_SOURCE_DISPLACEMENT : SP_SOURCE_IMPULSE;
            o.until = (n < 10 ? 30 : 2.9) * n / rate;
            o.points = POINTS;
            assert_ok(sp_signal_make(&net, &o, &signal, &err));
            for (int l = 0; l < POINTS; l++)
                t[l] = signal.t[l] * rate;
            assert_ok(sp_chain_walls_signal(&chain, POINTS, t, f, &err));
            for (int l = 0; l < POINTS; l++) /* t is rounded, and F' is below 2 */
                assert_close(signal.f[l], f[l] * force, signal.error + 1e-15 * (1 + t[l]) * force);
        }
    }
}

/* What stiffer walls do to a long chain's front: it is 1/wall as high, and earlier by 2 (1 - 1/wall); the rest falls as
 * N^(-2/3). */
TEST(test_walls) {
    enum { POINTS = 101 };
    double before = 0;
    for (int64_t n = 1000; n <= 64000; n *= 64) {
        const sp_chain chain = {.grains = n, .source = SP_CHAIN_VELOCITY, .wall = 1.6};
        double t[POINTS], shifted[POINTS], f[POINTS], equal[POINTS], off = 0, height = 0;
        for (int l = 0; l < POINTS; l++) {
            t[l] = (double)n + cbrt((double)n) * (l - 50) / 25;
            shifted[l] = t[l] - 2 * (1 / chain.wall - 1);
        }
        assert_ok(sp_chain_walls_signal(&chain, POINTS, t, f, &err));
        assert_ok(sp_chain_signal(n, SP_CHAIN_VELOCITY, POINTS, shifted, equal, &err));
        for (int l = 0; l < POINTS; l++) {
            off = fmax(off, fabs(f[l] - equal[l] / chain.wall));
            height = fmax(height, f[l]);
        }
        off /= height;
        printf("wall 1.6, N = %lld: off by %.2g of the height\n", (long long)n, off);
        if (n > 1000)
            assert_close(log(off / before) / log(64), -2.0 / 3, 0.03);
        before = off;
    }
}

static double at(int64_t grains, sp_chain_source source, double t) {
    double f;
    assert_ok(sp_chain_signal(grains, source, 1, &t, &f, &err));
    return f;
}

/* Marks are where the signal has them: it changes sign, passes a tenth and is steepest at 0 within 1e-9 of the mark.
 * And the general rule finds the same on a fine grid that ends behind the zero. */
TEST(test_front) {
    enum { POINTS = 4000 };
    const int sizes[] = {1, 2, 3, 5, 12, 40, 1000, 30000};
    static double t[POINTS], f[POINTS];
    for (size_t q = 0; q < sizeof sizes / sizeof *sizes; q++)
        for (int s = 0; s < 2; s++) {
            const int n = sizes[q];
            sp_front marks, found;
            if (n == 1 && s == 1)
                continue;
            assert_ok(sp_chain_front(n, sources[s], &marks, &err));
            const double near = 1e-9 * marks.t_peak, unit = cbrt(n);
            assert_true(at(n, sources[s], marks.t10 - near) < 0.1 * marks.amplitude);
            assert_true(at(n, sources[s], marks.t10 + near) > 0.1 * marks.amplitude);
            assert_true(at(n, sources[s], marks.t_zero - near) > 0 && at(n, sources[s], marks.t_zero + near) < 0);
            /* times are rounded to 1e-16 N where the signal varies over N^(1/3) */
            assert_relative(at(n, sources[s], marks.t_peak), marks.amplitude, 1e-14 * (1 + unit * unit));
            if (s == 0) /* F_B is the slope of F_A */
                assert_true(at(n, SP_CHAIN_DISPLACEMENT, marks.t_peak - near) > 0 &&
                            at(n, SP_CHAIN_DISPLACEMENT, marks.t_peak + near) < 0);
            const double from = fmax(0, marks.t10 - 2 * unit), step = (marks.t_zero + 0.1 * unit - from) / (POINTS - 1);
            for (int l = 0; l < POINTS; l++)
                t[l] = from + l * step;
            const sp_front_options how = sp_front_options_default();
            assert_ok(sp_chain_signal(n, sources[s], POINTS, t, f, &err));
            assert_ok(sp_front_find(POINTS, t, f, &how, &found, &err));
            /* straight lines in a step h are off by h^2 F''/(8 F'), the vertex of a parabola by h^2 F'''/(6 F'') in
             * time and by less than h^3 F''' in height; F varies over unit/2
             */
            const double h = step * step / unit, fine = 2 * step / unit;
            assert_close(found.t10, marks.t10, h);
            assert_close(found.t_peak, marks.t_peak, h);
            assert_close(found.t_zero, marks.t_zero, h);
            assert_relative(found.amplitude, marks.amplitude, fine * fine * fine + 1e-14 * (1 + unit * unit));
            assert_int_equal(found.crossings, 1);
            assert_int_equal(marks.crossings, 1);
            assert_true(marks.width == marks.t_zero - marks.t10);
        }
}

/* The signal over the front of (16), w = -5 .. 5: equal but for N^(-1/3); for N^(-2/3) where the way is N + 1. */
TEST(test_airy_limit) {
    enum { POINTS = 101 };
    const double slope[] = {-1.0 / 3, -2.0 / 3};
    for (int s = 0; s < 2; s++) {
        double before[2] = {0};
        for (int64_t n = 10000; n <= 640000; n *= 64) {
            double t[POINTS], later[POINTS], limit[POINTS], f[2][POINTS], off[2] = {0}, height = 0;
            for (int l = 0; l < POINTS; l++) {
                t[l] = (double)n + cbrt((double)n) * (l - 50) / 20;
                later[l] = t[l] + 1;
            }
            assert_ok(sp_chain_airy(n, sources[s], POINTS, t, limit, &err));
            assert_ok(sp_chain_signal(n, sources[s], POINTS, t, f[0], &err));
            assert_ok(sp_chain_signal(n, sources[s], POINTS, later, f[1], &err));
            for (int l = 0; l < POINTS; l++) {
                height = fmax(height, fabs(limit[l]));
                for (int k = 0; k < 2; k++)
                    off[k] = fmax(off[k], fabs(f[k][l] - limit[l]));
            }
            for (int k = 0; k < 2; k++) {
                off[k] /= height;
                if (n > 10000)
                    assert_close(log(off[k] / before[k]) / log(64), slope[k], 0.03);
                before[k] = off[k];
            }
            printf("source %c, N = %lld: off by %.2g of the height, with N + 1 by %.2g\n", 'A' + s, (long long)n,
                   off[0], off[1]);
        }
    }
}

/* The numbers of sp_chain_limit_of are those of the Airy function. */
TEST(test_limits) {
    const double tenth[] = {2.5094406664594647, 3.2428893980567130}, peak[] = {0, 0.88405045855237295};
    for (int s = 0; s < 2; s++) {
        const sp_chain_limit limit = sp_chain_limit_of(sources[s]);
        const double zero = 2 * (peak[s] / 2 - limit.width_peak), places[] = {tenth[s], peak[s], zero};
        double height[3], slope[3];
        for (int k = 0; k < 3; k++) {
            double ai, derivative;
            sp_airy(places[k], &ai, &derivative);
            height[k] = s ? 16 * places[k] * ai : -8 * derivative;
            slope[k] = s ? ai + places[k] * derivative : -places[k] * ai;
        }
        assert_close(limit.height, height[1], 1e-14);
        assert_close(slope[1], 0, 1e-15);
        assert_close(height[0], 0.1 * height[1], 1e-14);
        assert_close(height[2], 0, 1e-14);
        assert_close(limit.width, (tenth[s] - zero) / 2, 1e-15);
    }
}

TEST(test_bad_input) {
    const double fine[2] = {1, 2}, bad[][2] = {{NAN, 1}, {-1, 1}, {2, 1}, {0, INFINITY}};
    double f[2];
    sp_front front;
    sp_status (*const of[])(int64_t, sp_chain_source, int64_t, const double *, double *, sp_error *) = {sp_chain_signal,
                                                                                                        sp_chain_airy};
    for (int k = 0; k < 2; k++) {
        assert_fails(of[k](0, SP_CHAIN_VELOCITY, 2, fine, f, &err), SP_EINVAL, "0 1");
        assert_fails(of[k](-4, SP_CHAIN_VELOCITY, 2, fine, f, &err), SP_EINVAL, "-4");
        assert_fails(of[k](INT64_MAX, SP_CHAIN_VELOCITY, 2, fine, f, &err), SP_EINVAL, "1 1000000000");
        assert_fails(of[k](5, (sp_chain_source)2, 2, fine, f, &err), SP_EINVAL, "source 2");
        for (int q = 0; q < 4; q++)
            assert_fails(of[k](5, SP_CHAIN_VELOCITY, 2, bad[q], f, &err), SP_EINVAL, "0");
        assert_ok(of[k](5, SP_CHAIN_VELOCITY, 0, NULL, f, &err));
    }
    const double ratios[] = {0, -1, 2, NAN, INFINITY};
    for (int k = 0; k < 5; k++) {
        const sp_chain chain = {.grains = 5, .wall = ratios[k]};
        assert_fails(sp_chain_walls_signal(&chain, 2, fine, f, &err), SP_EINVAL, "0 2");
    }
    const double late = 1e15;
    assert_fails(sp_chain_signal(5, SP_CHAIN_VELOCITY, 1, &late, f, &err), SP_EINVAL, "GB");
    assert_fails(sp_chain_front(0, SP_CHAIN_VELOCITY, &front, &err), SP_EINVAL, "0");
    assert_fails(sp_chain_front(1, SP_CHAIN_DISPLACEMENT, &front, &err), SP_EREFUSED, "2");
    for (int k = 0; k < 2; k++) {
        sp_alloc_fail_after(k);
        assert_fails(sp_chain_signal(5, SP_CHAIN_VELOCITY, 2, fine, f, &err), SP_ENOMEM, "");
        sp_alloc_fail_after(k);
        assert_fails(sp_chain_front(5, SP_CHAIN_VELOCITY, &front, &err), SP_ENOMEM, "");
    }
    sp_alloc_fail_after(-1);
}

RUN_TESTS(NULL, NULL)
