#include "base/base.h"
#include "numeric/random.h"
#include "numeric/statistics.h"
#include "test.h"

#include <sonopack/front.h>
#include <stdbool.h>

enum { MOST = 40001 };

/* A smooth model front: Gaussian rise, then an oscillation that dies out. With s = (t - 30)/6 it is
 * exp(-s^2/2) cos(s/2) before and after: one zero crossing at s = pi, later swings below 1e-2. */
static double model(double t) {
    double s = (t - 30) / 6;
    return exp(-0.5 * s * s) * cos(0.5 * s) * (1 + 0.3 * tanh(s));
}

typedef struct trace {
    int64_t n;
    double t[MOST], f[MOST];
} trace;

static trace *sampled(double first, double last, double step) {
    trace *w = calloc(1, sizeof *w);
    assert_non_null(w);
    w->n = (int64_t)floor((last - first) / step + 1e-9) + 1;
    assert_true(w->n <= MOST);
    for (int64_t k = 0; k < w->n; k++) {
        w->t[k] = first + step * (double)k;
        w->f[k] = model(w->t[k]);
    }
    return w;
}

static sp_front find(const trace *w, double window) {
    sp_front_options o = sp_front_options_default();
    o.window = window;
    sp_front front = {0};
    assert_ok(sp_front_find(w->n, w->t, w->f, &o, &front, &err));
    assert_close(front.width, front.t_zero - front.t10, isnan(front.t_zero) ? INFINITY : 0);
    return front;
}

#define assert_no_front(w, status, text)                                                                               \
    do {                                                                                                               \
        sp_front_options o_ = sp_front_options_default();                                                              \
        sp_front front_ = {.t10 = 123, .amplitude = 123};                                                              \
        assert_fails(sp_front_find((w)->n, (w)->t, (w)->f, &o_, &front_, &err), status, text);                         \
        assert_true(front_.t10 == 123 && front_.amplitude == 123); /* untouched */                                     \
    } while (0)

/* Marks of the model itself, by bisection of the function and of its derivative. */
static sp_front exact(void) {
    sp_front e = {0};
    double low = 25, high = 40;
    for (int k = 0; k < 200; k++) {
        double mid = 0.5 * (low + high), h = 1e-5;
        *(model(mid + h) > model(mid - h) ? &low : &high) = mid;
    }
    e.t_peak = low;
    e.amplitude = model(low);
    low = 0, high = e.t_peak;
    for (int k = 0; k < 200; k++) {
        double mid = 0.5 * (low + high);
        *(model(mid) < 0.1 * e.amplitude ? &low : &high) = mid;
    }
    e.t10 = low;
    e.t_zero = 30 + 6 * acos(-1.0);
    return e;
}

TEST(marks_converge_with_the_sampling) {
    sp_front e = exact();
    enum { STEPS = 5, SHIFTS = 16 };
    double step[STEPS], off[4][STEPS];
    for (int s = 0; s < STEPS; s++) {
        step[s] = 1.6 * pow(0.5, s);
        for (int m = 0; m < 4; m++)
            off[m][s] = 0;
        for (int shift = 0; shift < SHIFTS; shift++) { /* the error depends on where the grid falls */
            RELEASED trace *w = sampled(step[s] * shift / SHIFTS, 100, step[s]);
            sp_front front = find(w, 0);
            const double d[4] = {front.t10 - e.t10, front.t_peak - e.t_peak, front.t_zero - e.t_zero,
                                 front.amplitude - e.amplitude};
            for (int m = 0; m < 4; m++)
                off[m][s] += d[m] * d[m] / SHIFTS;
        }
    }
    /* linear interpolation and the vertex: second order; the height at a vertex: third and more */
    const double order[4] = {2, 2, 2, 3};
    const char *name[4] = {"t10", "t_peak", "t_zero", "amplitude"};
    for (int m = 0; m < 4; m++) {
        double x[STEPS], y[STEPS];
        for (int s = 0; s < STEPS; s++) {
            x[s] = log(step[s]);
            y[s] = 0.5 * log(off[m][s]);
        }
        sp_line line;
        assert_ok(sp_fit_line(STEPS, x, y, NULL, &line, &err));
        print_message("order of %s: %.3f, error at step %g: %.3g\n", name[m], line.slope, step[STEPS - 1],
                      sqrt(off[m][STEPS - 1]));
        assert_true(line.slope > order[m] - 0.15 && line.slope < order[m] + (m == 3 ? 1.2 : 0.15));
    }
}

TEST(noise_moves_the_marks_little) {
    sp_front e = exact();
    for (uint64_t seed = 1; seed <= 200; seed++) {
        sp_random r = sp_random_make(seed, 99);
        RELEASED trace *w = sampled(0, 100, 0.02); /* fine: the noise makes a maximum at every third point */
        for (int64_t k = 0; k < w->n; k++) {
            double gauss = sqrt(-2 * log1p(-sp_random_uniform(&r))) * cos(6.283185307179586 * sp_random_uniform(&r));
            w->f[k] += 1e-3 * e.amplitude * gauss;
        }
        sp_front front = find(w, 0);
        /* Five standard deviations over the slope at the crossing. At the peak: the noise reaches 5e-3 of the height,
         * which the curve 1 - (t - t_peak)^2/(2 (5.5)^2) has lost at sqrt(2 5e-3) 5.5 = 0.55. */
        double slope10 = (model(e.t10 + 1e-4) - model(e.t10 - 1e-4)) / 2e-4;
        double slope0 = (model(e.t_zero - 1e-4) - model(e.t_zero + 1e-4)) / 2e-4;
        if (!(fabs(front.t10 - e.t10) < 5e-3 * e.amplitude / slope10) ||
            !(fabs(front.t_zero - e.t_zero) < 5e-3 * e.amplitude / slope0) || !(fabs(front.t_peak - e.t_peak) < 0.8) ||
            !(fabs(front.amplitude - e.amplitude) < 5e-3 * e.amplitude))
            fail_msg("seed %llu: t10 %g t_peak %g t_zero %g amplitude %g", (unsigned long long)seed, front.t10,
                     front.t_peak, front.t_zero, front.amplitude);
    }
}

TEST(precursors_do_not_count) {
    RELEASED trace *w = sampled(0, 100, 0.1);
    sp_front clean = find(w, 0);
    for (int64_t k = 0; k < w->n; k++) /* rounding before the front, maxima at 1e-17 and a crossing each time */
        w->f[k] += 1e-17 * sin(7 * w->t[k]);
    sp_front front = find(w, 0);
    assert_close(front.t10, clean.t10, 1e-13);
    assert_close(front.t_peak, clean.t_peak, 1e-10);
    assert_close(front.t_zero, clean.t_zero, 1e-13);
    for (int64_t k = 50; k < 60; k++) /* an early bump of half the threshold */
        w->f[k] += 0.05;
    front = find(w, 0);
    assert_close(front.t10, clean.t10, 1e-13);
}

TEST(crossings_before_the_peak_are_counted) {
    RELEASED trace *w = sampled(0, 100, 0.1);
    sp_front clean = find(w, 0);
    assert_int_equal(clean.crossings, 1);
    for (int bump = 1; bump <= 3; bump++) { /* each above a tenth, below the prominence */
        for (int64_t k = 0; k < 5; k++)
            w->f[20 * bump + k] += 0.15;
        sp_front front = find(w, 0);
        assert_int_equal(front.crossings, 1 + bump);
        assert_true(front.t10 < 2.1 && front.t10 > 1.9); /* the first, by definition */
        assert_close(front.t_peak, clean.t_peak, 1e-13);
    }
    for (int64_t k = 600; k < 700; k++) /* after the peak nothing counts */
        w->f[k] += (double)(k % 2);
    assert_int_equal(find(w, 0).crossings, 4);
}

TEST(an_offset_is_told) {
    RELEASED trace *w = sampled(0, 100, 0.1);
    for (int64_t k = 0; k < w->n; k++)
        w->f[k] += 0.5;
    assert_no_front(w, SP_EREFUSED, "0.1");
}

TEST(a_second_higher_peak_does_not_count) {
    RELEASED trace *w = sampled(0, 300, 0.1);
    sp_front clean = find(w, 0);
    for (int64_t k = 0; k < w->n; k++)
        w->f[k] += 4 * model(w->t[k] - 120);
    sp_front front = find(w, 0); /* 1 > 0.2 x 4 */
    assert_close(front.t_peak, clean.t_peak, 1e-12);
    for (int64_t k = 0; k < w->n; k++)
        w->f[k] += 2 * model(w->t[k] - 120);
    front = find(w, 0); /* 1 < 0.2 x 6: the first is a precursor ... */
    assert_close(front.t_peak, clean.t_peak + 120, 1e-6);
    front = find(w, 90); /* ... unless the window leaves the second out */
    assert_close(front.t_peak, clean.t_peak, 1e-12);
}

TEST(noise_within_a_maximum_and_real_dips) {
    /* 0.9, a dip by `dip`, 1.0: one maximum if the dip is below 0.01 of the largest value, two if above */
    for (int deep = 0; deep < 2; deep++) {
        double dip = deep ? 0.012 : 0.008;
        const double t[] = {0, 1, 2, 3, 4, 5}, f[] = {0, 0.9, 0.9 - dip, 1.0, 0.5, -0.5};
        sp_front_options o = sp_front_options_default();
        sp_front front = {0};
        assert_ok(sp_front_find(6, t, f, &o, &front, &err));
        assert_close(front.t_peak, deep ? 1 : 3, 0.5);
    }
}

TEST(plateaus) {
    sp_front_options o = sp_front_options_default();
    sp_front front = {0};
    const double t[] = {0, 1, 2, 3, 4, 5, 6};
    const double two[] = {0, 0.5, 1, 1, 0.5, 0, -1};
    assert_ok(sp_front_find(7, t, two, &o, &front, &err));
    assert_close(front.t_peak, 2.5, 1e-15); /* the parabola through (0.5, 1, 1) */
    assert_close(front.amplitude, 1.0625, 1e-15);
    assert_close(front.t_zero, 5, 0); /* a zero is a crossing */
    assert_close(front.t10, 0.2125, 1e-15);
    const double four[] = {0, 1, 1, 1, 1, -1, 1};
    assert_ok(sp_front_find(7, t, four, &o, &front, &err));
    assert_close(front.t_peak, 2.5, 0);
    assert_close(front.amplitude, 1, 0);
    assert_close(front.t_zero, 4.5, 1e-15);
    assert_close(front.t10, 0.1, 1e-15);
    const double touch[] = {0, 1, 0, 0.1, 0.05, -0.5, 0};
    assert_ok(sp_front_find(7, t, touch, &o, &front, &err));
    assert_close(front.t_zero, 2, 0);
    const double shoulder[] = {0, 0.5, 0.5, 0.5, 1, 0.2, 0.1};
    assert_ok(sp_front_find(7, t, shoulder, &o, &front, &err));
    assert_close(front.t_peak, 4, 0.5);
    assert_true(isnan(front.t_zero) && isnan(front.width));
}

TEST(uneven_times) {
    /* points of 1 - (t - 3)^2 / 4: the parabola is exact for any times */
    const double t[] = {0.9, 1.0, 2.7, 4.1, 5.0, 5.5};
    double f[6];
    for (int k = 0; k < 6; k++)
        f[k] = 1 - (t[k] - 3) * (t[k] - 3) / 4;
    sp_front_options o = sp_front_options_default();
    sp_front front = {0};
    assert_ok(sp_front_find(6, t, f, &o, &front, &err));
    assert_close(front.t_peak, 3, 1e-14);
    assert_close(front.amplitude, 1, 1e-14);
}

TEST(negative_first_swing) {
    RELEASED trace *w = sampled(0, 100, 0.1);
    sp_front clean = find(w, 0);
    for (int64_t k = 0; k < w->n; k++)
        w->f[k] -= 3 * exp(-0.5 * (w->t[k] - 10) * (w->t[k] - 10) / 4); /* three times as high, downwards */
    sp_front front = find(w, 0);
    assert_close(front.t_peak, clean.t_peak, 1e-12);
    assert_close(front.t_zero, clean.t_zero, 1e-12);
    assert_true(front.t10 > clean.t10 && front.t10 < front.t_peak);
}

TEST(traces_without_a_front) {
    RELEASED trace *w = sampled(0, 100, 0.1);
    RELEASED trace *v = calloc(1, sizeof *v);
    assert_non_null(v);
    memcpy(v, w, sizeof *v);
    for (int64_t k = 0; k < v->n; k++)
        v->f[k] = 0;
    assert_no_front(v, SP_EREFUSED, "100");
    for (int64_t k = 0; k < v->n; k++)
        v->f[k] = -w->f[k] * (w->f[k] > 0);
    assert_no_front(v, SP_EREFUSED, "100");
    for (int64_t k = 0; k < v->n; k++)
        v->f[k] = (double)k;
    assert_no_front(v, SP_EREFUSED, "0.2 1000 100");
    for (int64_t k = 0; k < v->n; k++)
        v->f[k] = -(double)k;
    assert_no_front(v, SP_EREFUSED, "100");
    for (int64_t k = 0; k < v->n; k++)
        v->f[k] = 1000 - (double)k;
    assert_no_front(v, SP_EREFUSED, "1000");
    for (int64_t k = 0; k < v->n; k++)
        v->f[k] = 5;
    assert_no_front(v, SP_EREFUSED, "0.2 5 100");
    memcpy(v, w, sizeof *v);
    v->n = (int64_t)(30.5 / 0.1); /* the peak is the last point: it may still rise */
    assert_no_front(v, SP_EREFUSED, "0.2 30.4");
    memcpy(v, w, sizeof *v);
    for (int64_t k = 0; k < v->n; k++) /* an offset of 15% */
        v->f[k] += 0.15;
    assert_no_front(v, SP_EREFUSED, "0.1");
}

TEST(peaks_that_the_points_do_not_resolve) {
    /* the parabola follows the fall after the highest point: its vertex is 1e18 times as high */
    const double t[] = {0, 7.25, 21.76, 22}, f[] = {0, 4, -6e19, -6e19}, steep[] = {0, 1, -6, -6};
    sp_front_options o = sp_front_options_default();
    sp_front front = {0};
    assert_fails(sp_front_find(4, t, f, &o, &front, &err), SP_EREFUSED, "4 7.25");
    const double even[] = {0, 1, 2, 3};
    assert_ok(sp_front_find(4, even, steep, &o, &front, &err));
    assert_close(front.amplitude, 1.5625, 1e-14);
    o.rise = 0.9; /* reached at the point itself, after the vertex */
    assert_fails(sp_front_find(4, even, steep, &o, &front, &err), SP_EREFUSED, "1.5625 0.625");
}

TEST(wrong_input) {
    trace *w = sampled(0, 100, 0.1);
    w->f[77] = NAN;
    assert_no_front(w, SP_EINVAL, "77");
    w->f[77] = INFINITY;
    assert_no_front(w, SP_EINVAL, "77");
    w->f[77] = 0;
    w->t[500] = w->t[499];
    assert_no_front(w, SP_EINVAL, "500");
    w->t[500] = w->t[499] - 1;
    assert_no_front(w, SP_EINVAL, "500 48.900000000000006");
    w->t[500] = NAN;
    assert_no_front(w, SP_EINVAL, "500");
    w->n = 2;
    assert_no_front(w, SP_EINVAL, "3");
    w->n = 0;
    assert_no_front(w, SP_EINVAL, "3");
    free(w);
    w = sampled(0, 100, 0.1);
    sp_front front;
    const sp_front_options bad[] = {{0, 0, 0.2},   {0, 1, 0.2},   {0, NAN, 0.2},  {0, 0.1, 0},
                                    {0, 0.1, 1.5}, {0, 0.1, NAN}, {NAN, 0.1, 0.2}};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
        assert_fails(sp_front_find(w->n, w->t, w->f, &bad[k], &front, &err), SP_EINVAL, "fractions");
    sp_front_options narrow = {0.15, 0.1, 0.2};
    assert_fails(sp_front_find(w->n, w->t, w->f, &narrow, &front, &err), SP_EREFUSED, "window");
    free(w);
}

/* A signal times any factor has the same times, as long as its numbers are numbers. */
TEST(any_unit_of_force) {
    RELEASED trace *w = sampled(0, 100, 0.1);
    sp_front one = find(w, 0);
    const double factor[] = {1e-300, 1e-30, 1e30, 1e307};
    for (int c = 0; c < 4; c++) {
        RELEASED trace *v = sampled(0, 100, 0.1);
        for (int64_t k = 0; k < v->n; k++)
            v->f[k] *= factor[c];
        sp_front front = find(v, 0);
        assert_close(front.t10, one.t10, 1e-12);
        assert_close(front.t_peak, one.t_peak, 1e-9);
        assert_close(front.t_zero, one.t_zero, 1e-12);
        assert_close(front.amplitude / factor[c], one.amplitude, 1e-12);
    }
    const double t[] = {0, 1, 2, 3, 4}, f[] = {-1e308, 1e308, -1e308, 1e308, -1e308};
    sp_front_options o = sp_front_options_default();
    sp_front front;
    assert_ok(sp_front_find(5, t, f, &o, &front, &err));
    assert_close(front.t_peak, 1, 1e-15);
    assert_close(front.t10, 0.55, 1e-15);
    assert_close(front.t_zero, 1.5, 1e-15);
}

RUN_TESTS(NULL, NULL)
