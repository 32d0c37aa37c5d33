#include "base/base.h"
#include "reference.h"

#include <complex.h>
#include <sonopack/modes.h>
#include <sonopack/pulse.h>
#undef I

/* CMPLX of C11, which not every compiler has. */
static double complex number(double re, double im) { return re + im * _Complex_I; }

static sp_signal_options options_of(double until, int points) {
    sp_signal_options o = sp_signal_options_default();
    o.until = until;
    o.points = points;
    return o;
}

/* Integral of s(t') exp(z (t - t')) from a to b for s = exp(v t'). */
static double complex exponential(double complex v, double complex z, double t, double a, double b) {
    return b > a ? (cexp(z * (t - b) + v * b) - cexp(z * (t - a) + v * a)) / (v - z) : 0;
}

/* The same for s = c0 + c1 t'. */
static double complex straight(double c0, double c1, double complex z, double t, double a, double b) {
    if (!(b > a))
        return 0;
    const double complex at_a = cexp(z * (t - a)), at_b = cexp(z * (t - b));
    return -((c0 + c1 * b) * at_b - (c0 + c1 * a) * at_a) / z - c1 * (at_b - at_a) / (z * z);
}

static double complex table_response(const sp_pulse *p, double complex z, double t) {
    double complex sum = 0;
    for (int64_t k = 1; k < p->n; k++) {
        const double step = p->t[k] - p->t[k - 1], c1 = step > 0 ? (p->s[k] - p->s[k - 1]) / step : 0;
        if (step > 0)
            sum += straight(p->s[k - 1] - c1 * p->t[k - 1], c1, z, t, p->t[k - 1], fmin(p->t[k], t));
    }
    return sum;
}

/* The pulse's answer of exp(z t), t > 0. Gauss and Ricker: all of the pulse must have passed. */
static double complex response(const sp_pulse *p, double complex z, double t) {
    double first, last;
    sp_pulse_span(p, &first, &last);
    const double end = fmin(t, last), w = p->omega, half = 0.5 * w;
    double complex sum = 0;
    switch (p->kind) {
    case SP_PULSE_SQUARE: return straight(1 / p->width, 0, z, t, 0, end);
    case SP_PULSE_TABLE: return table_response(p, z, t);
    case SP_PULSE_SINE: /* a sum of three sines */
        for (int sign = -1; sign < 2; sign += 2) {
            const double complex i = number(0, sign);
            sum += 0.5 * exponential(i * w, z, t, 0, end) / (2 * i);
            sum -= 0.25 * exponential(i * w * (1 + 1 / p->cycles), z, t, 0, end) / (2 * i);
            sum -= 0.25 * exponential(i * w * (1 - 1 / p->cycles), z, t, 0, end) / (2 * i);
        }
        return sum;
    case SP_PULSE_GAUSS: assert_true(t > last); return cexp(z * t + 0.5 * z * z * p->width * p->width);
    default:
        assert_true(t > last);
        return -sqrt(M_PI) / half * z * z / (2 * half * half) * cexp(z * t + z * z / (4 * half * half));
    }
}

static const double table_t[] = {0, 1.7, 1.7, 6, 6}, table_s[] = {0, 1, 0.4, -0.3, 0};
static const sp_pulse pulses[] = {{.kind = SP_PULSE_GAUSS, .width = 0.7},
                                  {.kind = SP_PULSE_GAUSS, .width = 1e-3},
                                  {.kind = SP_PULSE_RICKER, .omega = 1.1},
                                  {.kind = SP_PULSE_SINE, .omega = 0.4, .cycles = 3},
                                  {.kind = SP_PULSE_SINE, .omega = 30, .cycles = 0.5},
                                  {.kind = SP_PULSE_SQUARE, .width = 4},
                                  {.kind = SP_PULSE_SQUARE, .width = 200},
                                  {.kind = SP_PULSE_SQUARE, .width = 1e-2},
                                  {.kind = SP_PULSE_TABLE, .n = 5, .t = table_t, .s = table_s}};
enum { PULSES = sizeof pulses / sizeof *pulses };

/* Closed forms, mode by mode; both kinds of source. */
TEST(test_closed_forms) {
    sp_packing all[] = {chain_packing(1, 1e-4), chain_packing(15, 1e-4), scattered_packing(2, 4, 0.5, 1)};
    for (int q = 0; q < 3; q++) {
        FREED(sp_network) net = default_network(&all[q]);
        for (int source = 0; source < 3; source += 2) {
            const sp_modes_options mo = {.vectors = true, .source = (sp_source)source};
            FREED(sp_modes) m = sp_modes_none();
            assert_ok(sp_modes_dense(&net, &mo, &m, &err));
            double sizes = 0;
            for (int64_t n = 0; n < m.n; n++)
                sizes += fabs(m.a[n] * m.b[n]);
            for (int k = 0; k < PULSES; k++) {
                sp_signal_options o = options_of(120, 61);
                FREED(sp_signal) s = sp_signal_none();
                double first, last, largest = 0, strength = 0;
                sp_pulse_span(&pulses[k], &first, &last);
                o.source = (sp_source)source;
                o.tolerance = 1e-9;
                assert_ok(sp_signal_pulse(&net, &o, &pulses[k], &s, &err));
                for (int l = 0; l < 4000; l++)
                    strength += fabs(sp_pulse_strength(&pulses[k], first + (last - first) * (l + 0.5) / 4000)) *
                                (last - first) / 4000;
                for (int l = 0; l < s.n; l++)
                    largest = fmax(largest, fabs(s.f[l]));
                /* rounding of phases up to 120 Omega, and of differences over a short pulse */
                const double closed = 4e-13 + 2e-14 / (last - first);
                for (int l = 0; l < s.n; l++) {
                    double exact = 0;
                    if (first < 0 && s.t[l] <= last)
                        continue;
                    for (int64_t n = 0; n < m.n; n++) {
                        const double complex f = response(&pulses[k], number(0, m.omega[n]), s.t[l]);
                        exact += m.a[n] * m.b[n] * (source == SP_SOURCE_DISPLACEMENT ? creal(f) : cimag(f));
                    }
                    if (!(fabs(s.f[l] - exact) <= s.error + closed * sizes * strength))
                        fail_msg("packing %d source %d pulse %d t %g: off by %g, bound %g", q, source, k, s.t[l],
                                 fabs(s.f[l] - exact), s.error);
                }
                assert_true(s.error <= 1e-9 * largest && s.n == 61 && s.t[60] == 120);
            }
        }
        sp_packing_free(&all[q]);
    }
}

/* A Gaussian while it goes on, by Simpson's rule. */
TEST(test_gauss_within) {
    enum { STEPS = 40000 };
    FREED(sp_packing) p = chain_packing(1, 1e-4);
    FREED(sp_network) net = default_network(&p);
    const sp_pulse pulse = {.kind = SP_PULSE_GAUSS, .width = 6};
    const sp_signal_options o = options_of(50, 26);
    const double own = sqrt(2 * net.springs[0].kn / net.mass[0]);
    const double height = net.springs[0].kn * net.springs[0].kn / (net.mass[0] * own);
    FREED(sp_signal) s = sp_signal_none();
    assert_ok(sp_signal_pulse(&net, &o, &pulse, &s, &err));
    for (int l = 0; l < s.n; l++) {
        double sum = 0; /* step 2.8e-3: (own h)^4 is 1e-12 */
        const double low = -60, step = (s.t[l] - low) / STEPS;
        for (int k = 0; k <= STEPS; k++) {
            const double at = low + step * k, w = k == 0 || k == STEPS ? 1 : k % 2 ? 4 : 2;
            sum += w * step / 3 * sp_pulse_strength(&pulse, at) * height * sin(own * (s.t[l] - at));
        }
        assert_close(s.f[l], sum, 1e-11 * height);
    }
}

/* The answer with dashpots, which is nothing before t = 0 and has no continuation there. */
TEST(test_damped) {
    FREED(sp_packing) p = chain_packing(1, 1e-4);
    FREED(sp_network) net = default_network(&p);
    /* two springs and dashpots c = decay m each: the force on the wall is k u + c u' */
    const double k = net.springs[0].kn, m = net.mass[0], zeta = 0.2, decay = 2 * zeta * sqrt(m * k) / m;
    const double complex z = number(-decay, sqrt(2 * k / m - decay * decay));
    sp_signal_options o = options_of(60, 31);
    o.damping = zeta;
    for (int q = 0; q < PULSES; q++) {
        double first, last, strength = 0;
        FREED(sp_signal) s = sp_signal_none();
        sp_pulse_span(&pulses[q], &first, &last);
        assert_ok(sp_signal_pulse(&net, &o, &pulses[q], &s, &err));
        for (int l = 0; l < 4000; l++)
            strength +=
                fabs(sp_pulse_strength(&pulses[q], first + (last - first) * (l + 0.5) / 4000)) * (last - first) / 4000;
        for (int l = 0; l < s.n; l++)
            if (first == 0 || s.t[l] > last) {
                const double exact = k / m / cimag(z) * cimag((k + decay * m * z) * response(&pulses[q], z, s.t[l]));
                if (!(fabs(s.f[l] - exact) <= s.error + 1e-14 * k * strength))
                    fail_msg("pulse %d t %g: off by %g, bound %g", q, s.t[l], fabs(s.f[l] - exact), s.error);
            }
    }
}

TEST(test_refusals) {
    const double t[] = {0, 2, 1}, s[] = {0, 1, 0}, bad[] = {0, NAN, 1};
    const struct {
        sp_pulse pulse;
        const char *reason;
    } wrong[] = {{{.kind = SP_PULSE_GAUSS, .width = 0}, "width 0"},
                 {{.kind = SP_PULSE_SQUARE, .width = NAN}, "width"},
                 {{.kind = SP_PULSE_RICKER, .omega = -1}, "omega -1"},
                 {{.kind = SP_PULSE_SINE, .omega = 1, .cycles = INFINITY}, "cycles"},
                 {{.kind = SP_PULSE_TABLE, .n = 1, .t = t, .s = s}, "2"},
                 {{.kind = SP_PULSE_TABLE, .n = 3, .t = t, .s = s}, "2"},
                 {{.kind = SP_PULSE_TABLE, .n = 3, .t = table_t, .s = bad}, "2"},
                 {{.kind = (sp_pulse_kind)77}, "77"}};
    FREED(sp_packing) p = chain_packing(3, 1e-4);
    FREED(sp_network) net = default_network(&p);
    const sp_signal_options o = options_of(20, 11);
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        sp_signal f = sp_signal_none();
        assert_fails(sp_signal_pulse(&net, &o, &wrong[k].pulse, &f, &err), SP_EINVAL, wrong[k].reason);
    }
    /* frequencies far beyond the network's: next to nothing arrives */
    const sp_pulse shrill = {.kind = SP_PULSE_RICKER, .omega = 1e4};
    sp_signal f = sp_signal_none();
    const sp_status status = sp_signal_pulse(&net, &o, &shrill, &f, NULL);
    assert_true(status == SP_EREFUSED || status == SP_OK);
    sp_signal_free(&f);
    EACH_ALLOCATION_FAILS(8, sp_signal_pulse(&net, &o, &pulses[3], &f, &err), sp_signal_free(&f));
}

RUN_TESTS(NULL, NULL)
