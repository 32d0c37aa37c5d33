#include "base/base.h"
#include "numeric/random.h"
#include "test.h"

#include <sonopack/study/study.h>

enum { SIGNALS = 40, POINTS = 25 };

static double times[POINTS], force[SIGNALS][POINTS];

/* Numbers around an offset as large as asked for, with a spread near 0.3. */
static void fill(double offset) {
    sp_random r = sp_random_make(7, 1);
    for (int k = 0; k < POINTS; k++)
        times[k] = 0.25 * k;
    for (int j = 0; j < SIGNALS; j++)
        for (int k = 0; k < POINTS; k++)
            force[j][k] = offset + sin(times[k]) + sp_random_uniform(&r);
}

static sp_signal_average sum_up(int first, int step) {
    sp_signal_average s = sp_signal_average_none();
    for (int j = 0; j < SIGNALS; j++)
        assert_ok(sp_signal_average_add(&s, POINTS, times, force[(first + j * step) % SIGNALS], &err));
    assert_int_equal(s.count, SIGNALS);
    return s;
}

/* Direct sums in long double. Rounding of 40 updates is below 40 eps of the numbers, here below 2. */
TEST(the_same_as_direct_sums) {
    fill(0);
    FREED(sp_signal_average) s = sum_up(0, 1);
    assert_int_equal(s.points, POINTS);
    for (int k = 0; k < POINTS; k++) {
        long double mean = 0, squares = 0;
        for (int j = 0; j < SIGNALS; j++)
            mean += force[j][k];
        mean /= SIGNALS;
        for (int j = 0; j < SIGNALS; j++)
            squares += (force[j][k] - mean) * (force[j][k] - mean);
        assert_true(s.t[k] == times[k]);
        assert_close(s.mean[k], (double)mean, 2e-14);
        assert_relative(sp_signal_average_rms(&s, k), (double)sqrtl(squares / SIGNALS), 1e-13);
        assert_relative(sp_signal_average_mean_err(&s, k), (double)sqrtl(squares / (SIGNALS - 1) / SIGNALS), 1e-13);
    }
}

TEST(order_is_rounding) {
    fill(0);
    FREED(sp_signal_average) a = sum_up(0, 1), b = sum_up(5, 3), c = sum_up(SIGNALS - 1, SIGNALS - 1);
    for (int k = 0; k < POINTS; k++) {
        assert_close(b.mean[k], a.mean[k], 2e-14);
        assert_close(c.mean[k], a.mean[k], 2e-14);
        assert_relative(sp_signal_average_rms(&b, k), sp_signal_average_rms(&a, k), 1e-13);
        assert_relative(sp_signal_average_rms(&c, k), sp_signal_average_rms(&a, k), 1e-13);
    }
}

/* The difference of sums of squares would keep none of the scatter: 1e8 squared has 16 digits before it. */
TEST(scatter_beside_a_large_offset) {
    fill(0);
    FREED(sp_signal_average) small = sum_up(0, 1);
    fill(1e8);
    FREED(sp_signal_average) large = sum_up(0, 1);
    for (int k = 0; k < POINTS; k++) /* numbers near 1e8 are known to 1.5e-8 */
        assert_relative(sp_signal_average_rms(&large, k), sp_signal_average_rms(&small, k), 1e-6);
}

TEST(few_signals) {
    sp_signal_average s = sp_signal_average_none();
    const double t[] = {0, 1}, one[] = {1, -2}, two[] = {4, NAN};
    assert_true(isnan(sp_signal_average_rms(&s, 0)) && isnan(sp_signal_average_mean_err(&s, 0)));
    assert_ok(sp_signal_average_add(&s, 2, t, one, &err));
    assert_true(s.mean[0] == 1 && s.mean[1] == -2 && isnan(sp_signal_average_rms(&s, 0)) &&
                isnan(sp_signal_average_mean_err(&s, 1)));
    assert_ok(sp_signal_average_add(&s, 2, t, two, &err));
    assert_close(s.mean[0], 2.5, 1e-15);
    assert_close(sp_signal_average_rms(&s, 0), 1.5, 1e-15);
    assert_close(sp_signal_average_mean_err(&s, 0), 1.5, 1e-15); /* sd 3/sqrt(2) over sqrt(2) */
    assert_true(isnan(s.mean[1]) && isnan(sp_signal_average_rms(&s, 1)));
    sp_signal_average_free(&s);
    sp_signal_average_free(&s);
}

TEST(other_times_are_refused) {
    FREED(sp_signal_average) s = sp_signal_average_none();
    const double t[] = {0, 10, 20}, f[] = {1, 2, 3}, near[] = {1e-12, 10 - 1e-12, 20 + 1e-11};
    const double far[] = {0, 10 + 1e-10, 20}, begin[] = {1e-10, 10, 20}, nan[] = {0, NAN, 20}, end[] = {0, 10, NAN};
    assert_fails(sp_signal_average_add(&s, 0, t, f, &err), SP_EINVAL, "0 points");
    assert_ok(sp_signal_average_add(&s, 3, t, f, &err));
    assert_ok(sp_signal_average_add(&s, 3, near, f, &err));
    assert_fails(sp_signal_average_add(&s, 2, t, f, &err), SP_EREFUSED, "2 points 3");
    assert_fails(sp_signal_average_add(&s, 3, far, f, &err), SP_EREFUSED, "2");
    assert_fails(sp_signal_average_add(&s, 3, begin, f, &err), SP_EREFUSED, "1");
    assert_fails(sp_signal_average_add(&s, 3, nan, f, &err), SP_EREFUSED, "nan");
    assert_fails(sp_signal_average_add(&s, 3, end, f, &err), SP_EREFUSED, "3");
    assert_int_equal(s.count, 2);
    for (int k = 0; k < 3; k++)
        assert_true(s.t[k] == t[k] && s.mean[k] == f[k] && sp_signal_average_rms(&s, k) == 0);
}

TEST(no_memory) {
    FREED(sp_signal_average) s = sp_signal_average_none();
    const double t[] = {0, 1}, f[] = {1, 2};
    sp_alloc_fail_after(0);
    assert_fails(sp_signal_average_add(&s, 2, t, f, &err), SP_ENOMEM, "");
    sp_alloc_fail_after(-1);
    assert_true(s.count == 0 && !s.t);
    assert_ok(sp_signal_average_add(&s, 2, t, f, &err));
}

RUN_TESTS(NULL, NULL)
