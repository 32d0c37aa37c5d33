#include "base/base.h"
#include "numeric/interval.h"
#include "numeric/random.h"
#include "numeric/statistics.h"
#include "test.h"

#include <stdbool.h>

static double exponential(sp_random *r) { return -log1p(-sp_random_uniform(r)); }

TEST(quantiles_by_hand) {
    const double x[] = {1, 2, 4, 8};
    assert_close(sp_quantile(4, x, 0.2), 1, 1e-15);
    assert_close(sp_quantile(4, x, 0.5), 3, 1e-15);
    assert_close(sp_quantile(4, x, 0.7), 6, 1e-14);
    assert_true(sp_quantile(4, x, 0) == 1 && sp_quantile(4, x, 0.1) == 1 && sp_quantile(4, x, 0.95) == 8);
    assert_true(sp_quantile(1, x, 0.3) == 1 && sp_quantile(4, x, 1) == 8);
}

TEST(student_quantiles) {
    static const struct {
        double p;
        int64_t freedom;
        double t;
    } table[] = {{0.975, 1, 12.706204736174705},
                 {0.975, 2, 4.302652729749464},
                 {0.975, 3, 3.182446305283710},
                 {0.975, 4, 2.7764451051977944},
                 {0.975, 9, 2.2621571627982055},
                 {0.9995, 10, 4.586893858702636},
                 {0.75, 1, 1},
                 {0.975, 1000, 1.962339080826408},
                 {0.975, 99, 1.9842169515864175}};
    for (size_t k = 0; k < sizeof table / sizeof *table; k++) {
        assert_relative(sp_student_quantile(table[k].p, table[k].freedom), table[k].t, 1e-9);
        assert_relative(sp_student_quantile(1 - table[k].p, table[k].freedom), -table[k].t, 1e-9);
    }
    assert_close(sp_student_quantile(0.5, 7), 0, 1e-12);
}

/* How often the interval of n samples' mean holds the true one, in percent; the median width over Student's. */
static double coverage(int64_t n, bool skew, double level, int trials, double *width) {
    enum { TOGETHER = 200 }; /* means of unlike samples, whose resamples are drawn alike */
    static double x[TOGETHER][100];
    const double *of[TOGETHER];
    const uint64_t seed = 17;
    const double truth = skew ? 1 : 0, student = sp_student_quantile(0.5 * (1 + level), n - 1);
    sp_random r = sp_random_make(seed, 99);
    sp_interval interval[TOGETHER];
    int held = 0;
    *width = 0;
    for (int k = 0; k < trials; k += TOGETHER) {
        for (int v = 0; v < TOGETHER; v++) {
            of[v] = x[v];
            for (int64_t i = 0; i < n; i++)
                x[v][i] = skew ? exponential(&r) : sp_random_normal(&r);
        }
        const sp_interval_options o = {.level = level, .seed = (uint64_t)k + 1};
        assert_ok(sp_intervals_of_means(n, TOGETHER, of, &o, interval, &err));
        for (int v = 0; v < TOGETHER; v++) {
            held += interval[v].low <= truth && truth <= interval[v].high;
            *width += (interval[v].high - interval[v].low) / (2 * student * sp_standard_error(n, x[v])) / trials;
        }
    }
    return 100.0 * held / trials;
}

/* The numbers that the header states, to four standard deviations of so many trials, and 0.5 for resamples that the
 * trials share. */
TEST(coverage_of_the_mean) {
    SKIP_SANITIZED();
    static const struct {
        int64_t n;
        double level;
        int trials;
        double stated[2]; /* normal, exponential */
    } table[] = {{2, 0.95, 800, {97.6, 95.0}},   {3, 0.95, 800, {98.9, 95.5}},   {5, 0.95, 1000, {95.1, 92.6}},
                 {10, 0.95, 1000, {95.0, 94.1}}, {30, 0.95, 1000, {94.7, 94.8}}, {100, 0.95, 600, {94.6, 94.8}},
                 {10, 0.68, 1000, {68.5, 66.5}}, {30, 0.99, 1000, {99.0, 98.6}}};
    for (size_t k = 0; k < sizeof table / sizeof *table; k++)
        for (int skew = 0; skew < 2; skew++) {
            double width;
            const double found = coverage(table[k].n, skew, table[k].level, table[k].trials, &width);
            const double p = table[k].stated[skew] / 100;
            print_message("n %lld, level %g, %s: %.2f%%, mean width over Student's %.2f\n", (long long)table[k].n,
                          table[k].level, skew ? "exponential" : "normal", found, width);
            assert_close(found, 100 * p, 400 * sqrt(p * (1 - p) / table[k].trials) + 0.5);
        }
}

/* Bit for bit, whatever other quantities there are; others with another seed. */
TEST(the_same_again) {
    double x[2][30];
    const double *of[2] = {x[0], x[1]};
    sp_random r = sp_random_make(3, 99);
    for (int k = 0; k < 60; k++)
        x[k / 30][k % 30] = sp_random_normal(&r);
    sp_interval a[2], b[2], one;
    sp_interval_options o = sp_interval_options_default();
    assert_ok(sp_intervals_of_means(30, 2, of, &o, a, &err));
    assert_ok(sp_intervals_of_means(30, 2, of, &o, b, &err));
    assert_memory_equal(a, b, sizeof a);
    assert_ok(sp_intervals_of_means(30, 1, of + 1, &o, &one, &err));
    assert_memory_equal(&one, &a[1], sizeof one);
    o.seed = 2;
    assert_ok(sp_intervals_of_means(30, 2, of, &o, b, &err));
    assert_true(b[0].low != a[0].low && b[1].high != a[1].high);
    /* a higher level is a wider interval, of the same middle for the most part */
    double width = 0;
    for (double level = 0.5; level < 0.9995; level += level < 0.98 ? 0.05 : 0.001) {
        o = (sp_interval_options){level, 1};
        assert_ok(sp_intervals_of_means(30, 1, of, &o, &one, &err));
        assert_true(one.high - one.low > 0.98 * width);
        width = one.high - one.low;
    }
    assert_int_equal(sp_interval_resamples(0.95), 1000);
    assert_int_equal(sp_interval_resamples(0.99), 1000);
    assert_int_equal(sp_interval_resamples(0.999), 10000);
}

TEST(where_there_is_none) {
    const double x[] = {1, 2, 5}, same[] = {0.1, 0.1, 0.1}, bad[] = {1, NAN, 2}, far[] = {1, INFINITY, 2};
    const double *const of[] = {x, same, bad, far};
    sp_interval i[4];
    sp_interval_options o = sp_interval_options_default();
    assert_ok(sp_intervals_of_means(3, 4, of, &o, i, &err));
    assert_true(i[0].low < 8.0 / 3 && 8.0 / 3 < i[0].high);
    assert_close(i[1].low, 0.1, 1e-15);
    assert_close(i[1].high, 0.1, 1e-15);
    assert_true(isnan(i[2].low) && isnan(i[2].high) && isnan(i[3].low) && isnan(i[3].high));
    for (int64_t n = 0; n < 2; n++) {
        i[0] = (sp_interval){0, 0};
        assert_ok(sp_intervals_of_means(n, 1, of, &o, i, &err));
        assert_true(isnan(i[0].low) && isnan(i[0].high));
    }
    /* two samples: at most twice Student's interval, of one degree of freedom */
    assert_ok(sp_intervals_of_means(2, 1, of, &o, i, &err));
    assert_relative(i[0].high, 1.5 + 2 * 12.706204736 * 0.5, 1e-8);
    assert_relative(i[0].low, 1.5 - 2 * 12.706204736 * 0.5, 1e-8);
    i[0].low = 7;
    static const double levels[] = {0.49, 0.9991, NAN, -1};
    for (int k = 0; k < 4; k++) {
        o.level = levels[k];
        assert_fails(sp_intervals_of_means(3, 1, of, &o, i, &err), SP_EINVAL, "0.5 0.999");
    }
    o.level = 0.95;
    const sp_interval_problem nothing = {0};
    assert_fails(sp_intervals(&nothing, &o, i, &err), SP_EINVAL, "0");
    assert_true(i[0].low == 7);
    EACH_ALLOCATION_FAILS(4, sp_intervals_of_means(3, 1, of, &o, i, &err), assert_true(!lacks || i[0].low == 7));
}

/* 1000 samples of 11 quantities: a row of a table. */
TEST(fast_enough) {
    enum { N = 1000, M = 11 };
    static double x[M][N];
    const double *of[M];
    sp_interval i[M];
    for (int v = 0; v < M; v++) {
        of[v] = x[v];
        for (int k = 0; k < N; k++)
            x[v][k] = sin(k * (v + 1.5));
    }
    const sp_interval_options o = sp_interval_options_default();
    const double begin = sp_clock_cpu();
    assert_ok(sp_intervals_of_means(N, M, of, &o, i, &err));
    const double seconds = sp_clock_cpu() - begin;
    print_message("%d quantities of %d samples: %.3f s\n", M, N, seconds);
    assert_true(seconds < 1);
    for (int v = 0; v < M; v++) /* many samples: Student's, to 8% for 1000 resamples */
        assert_relative(i[v].high - i[v].low, 2 * 1.96 * sp_standard_error(N, x[v]), 0.15);
}

/* ---- one at a time ---------------------------------------------------------------------------------------------- */

/* Mean and variance 1, and no correlation of neighbours: to four standard deviations. The law's fourth central moment
 * is 4, so that the variance of 1e6 weights has the deviation sqrt(3e-6). */
TEST(weights_of_poisson) {
    enum { SAMPLES = 1000, RESAMPLES = 1000 };
    double sum = 0, squares = 0, along = 0, across = 0, none = 0;
    for (uint64_t s = 0; s < SAMPLES; s++)
        for (uint64_t b = 0; b < RESAMPLES; b++) {
            const double w = sp_poisson_weight(1, s, b) - 1;
            sum += w;
            squares += w * w;
            along += w * (sp_poisson_weight(1, s, b + 1) - 1);
            across += w * (sp_poisson_weight(1, s + 1, b) - 1);
            none += w < 0;
        }
    const double n = (double)SAMPLES * RESAMPLES;
    assert_close(sum / n, 0, 4e-3);
    assert_close(squares / n, 1, 4 * sqrt(3) * 1e-3);
    assert_close(along / n, 0, 4e-3);
    assert_close(across / n, 0, 4e-3);
    assert_close(none / n, exp(-1), 4 * sqrt(exp(-1) * (1 - exp(-1))) * 1e-3);
}

enum { NUMBERS = 300, SAMPLES = 53 }; /* more than a block of numbers, and not a whole number of those waiting */

static void fill(double x[SAMPLES][NUMBERS], double offset) {
    sp_random r = sp_random_make(5, 99);
    for (int s = 0; s < SAMPLES; s++)
        for (int k = 0; k < NUMBERS; k++)
            x[s][k] = offset + (k % 2 ? exponential(&r) : sp_random_normal(&r));
}

static void resample(double x[SAMPLES][NUMBERS], int n, double level, sp_interval *out) {
    FREED(sp_resampled) r = sp_resampled_none();
    assert_ok(sp_resampled_make(NUMBERS, level, &r, &err));
    for (int s = 0; s < n; s++)
        sp_resampled_add(&r, x[s]);
    assert_ok(sp_resampled_intervals(&r, out, &err));
}

/* Against the bootstrap that keeps the samples. An end is a quantile of 1000 resamples, known to
 * sqrt(q (1 - q) / 1000) / density(z) = 0.085 errors; of a difference of two ends, and 300 numbers, less on average.
 * The numbers are independent but share the weights: their average offset has the deviation of one. */
TEST(like_the_bootstrap) {
    static double x[SAMPLES][NUMBERS], column[NUMBERS][SAMPLES];
    const double *of[NUMBERS];
    static sp_interval one[NUMBERS], kept[NUMBERS];
    fill(x, 0);
    for (int k = 0; k < NUMBERS; k++) {
        of[k] = column[k];
        for (int s = 0; s < SAMPLES; s++)
            column[k][s] = x[s][k];
    }
    const sp_interval_options o = sp_interval_options_default();
    resample(x, SAMPLES, o.level, one);
    assert_ok(sp_intervals_of_means(SAMPLES, NUMBERS, of, &o, kept, &err));
    double low = 0, high = 0;
    for (int k = 0; k < NUMBERS; k++) {
        const double error = sp_standard_error(SAMPLES, column[k]);
        /* of an end of skewed samples, where t has a long tail, twice the deviation of a normal one */
        assert_close(one[k].low, kept[k].low, 5 * 2 * sqrt(2) * 0.085 * error);
        assert_close(one[k].high, kept[k].high, 5 * 2 * sqrt(2) * 0.085 * error);
        low += (one[k].low - kept[k].low) / error / NUMBERS;
        high += (one[k].high - kept[k].high) / error / NUMBERS;
    }
    print_message("ends differ by %.3f and %.3f errors on average\n", low, high);
    assert_close(low, 0, 0.1);
    assert_close(high, 0, 0.1);
}

TEST(one_at_a_time_again) {
    static double x[SAMPLES][NUMBERS];
    static sp_interval a[NUMBERS], b[NUMBERS];
    fill(x, 0);
    resample(x, SAMPLES, 0.95, a);
    resample(x, SAMPLES, 0.95, b);
    assert_memory_equal(a, b, sizeof a);
    /* looking at them in between changes rounding at most, and a window of the numbers is as good as all */
    FREED(sp_resampled) r = sp_resampled_none();
    assert_ok(sp_resampled_make(20, 0.95, &r, &err));
    for (int s = 0; s < SAMPLES; s++) {
        sp_resampled_add(&r, x[s] + 70);
        if (s % 10 == 3)
            assert_ok(sp_resampled_intervals(&r, b, &err));
    }
    assert_ok(sp_resampled_intervals(&r, b, &err));
    for (int k = 0; k < 20; k++) {
        assert_close(b[k].low, a[k + 70].low, 1e-12);
        assert_close(b[k].high, a[k + 70].high, 1e-12);
    }
    /* sums are of differences: an offset of 1e6 leaves 10 digits of them */
    fill(x, 1e6);
    resample(x, SAMPLES, 0.95, b);
    for (int k = 0; k < NUMBERS; k++)
        assert_close(b[k].low - 1e6, a[k].low, 1e-8);
}

TEST(few_at_a_time) {
    static double x[SAMPLES][NUMBERS];
    static sp_interval a[NUMBERS];
    fill(x, 0);
    resample(x, 0, 0.95, a);
    assert_true(isnan(a[0].low) && isnan(a[0].high));
    resample(x, 1, 0.95, a);
    assert_true(isnan(a[0].low) && isnan(a[0].high));
    for (int s = 0; s < SAMPLES; s++)
        x[s][7] = 0.1;
    x[40][8] = NAN;
    x[41][9] = INFINITY;
    resample(x, 2, 0.95, a);
    assert_true(a[0].low < fmin(x[0][0], x[1][0]) && a[0].high > fmax(x[0][0], x[1][0]));
    resample(x, SAMPLES, 0.95, a);
    assert_true(a[7].low == 0.1 && a[7].high == 0.1);
    for (int k = 8; k < 10; k++)
        assert_true(isnan(a[k].low) && isnan(a[k].high));
    sp_resampled r = sp_resampled_none();
    assert_fails(sp_resampled_make(0, 0.95, &r, &err), SP_EINVAL, "0");
    assert_fails(sp_resampled_make(1, 1.5, &r, &err), SP_EINVAL, "0.5 0.999");
    EACH_ALLOCATION_FAILS(1, sp_resampled_make(5, 0.95, &r, &err), assert_true(!lacks || !r.sums),
                          sp_resampled_free(&r));
}

/* Signals of a few frequencies, at times much closer than their periods: the width of the interval over the error
 * changes little from one to the next, for any number of samples. Of few samples it is Student's. */
TEST(smooth_in_time) {
    enum { TIMES = 800, WAVES = 6, MOST = 20 };
    static double x[MOST][TIMES];
    static sp_interval i[TIMES];
    sp_random random = sp_random_make(11, 99);
    for (int s = 0; s < MOST; s++)
        for (int w = 0; w < WAVES; w++) {
            const double size = sp_random_normal(&random), omega = 0.3 + 0.7 * sp_random_uniform(&random);
            const double phase = 6.283185307179586 * sp_random_uniform(&random);
            for (int k = 0; k < TIMES; k++)
                x[s][k] += size * cos(0.075 * omega * k + phase);
        }
    assert_int_equal(sp_resampled_least(0.95), 8);
    assert_int_equal(sp_resampled_least(0.99), 10);
    for (int n = 2; n <= MOST; n += n < 12 ? 1 : 4) {
        FREED(sp_resampled) r = sp_resampled_none();
        assert_ok(sp_resampled_make(TIMES, 0.95, &r, &err));
        for (int s = 0; s < n; s++)
            sp_resampled_add(&r, x[s]);
        assert_ok(sp_resampled_intervals(&r, i, &err));
        double before = 0, largest = 0;
        for (int k = 0; k < TIMES; k++) {
            double column[MOST];
            for (int s = 0; s < n; s++)
                column[s] = x[s][k];
            const double width = (i[k].high - i[k].low) / sp_standard_error(n, column);
            if (n < sp_resampled_least(0.95))
                assert_relative(width, 2 * sp_student_quantile(0.975, n - 1), 1e-6);
            largest = k > 0 ? fmax(largest, fabs(log(width / before))) : 0;
            before = width;
        }
        print_message("%d samples: widths of neighbours differ by %.3f at the most\n", n, largest);
        assert_true(largest < 0.25);
    }
}

/* The numbers that the header states of intervals from one sample at a time, to four standard deviations of so many
 * trials, and 1 for weights that the trials of one seed share. */
TEST(coverage_one_at_a_time) {
    SKIP_SANITIZED();
    enum { TRIALS = 1000, TOGETHER = 200, MOST = 10 };
    static const int numbers[] = {3, 5, 8, 10};
    static const double stated[][2] = {{94.8, 89.0}, {94.9, 88.3}, {96.0, 94.9}, {95.6, 94.6}};
    static double x[MOST][TOGETHER];
    static sp_interval i[TOGETHER];
    sp_random random = sp_random_make(23, 99);
    for (int q = 0; q < 8; q++) {
        const int n = numbers[q / 2], skew = q % 2;
        int held = 0;
        for (int k = 0; k < TRIALS; k += TOGETHER) {
            FREED(sp_resampled) r = sp_resampled_none();
            assert_ok(sp_resampled_make(TOGETHER, 0.95, &r, &err));
            r.seed = (uint64_t)k + 1;
            for (int s = 0; s < n; s++) {
                for (int v = 0; v < TOGETHER; v++)
                    x[s][v] = skew ? exponential(&random) - 1 : sp_random_normal(&random);
                sp_resampled_add(&r, x[s]);
            }
            assert_ok(sp_resampled_intervals(&r, i, &err));
            for (int v = 0; v < TOGETHER; v++)
                held += i[v].low <= 0 && 0 <= i[v].high;
        }
        const double p = stated[q / 2][skew] / 100;
        print_message("%d samples, %s: %.2f%%\n", n, skew ? "exponential" : "normal", 100.0 * held / TRIALS);
        assert_close(100.0 * held / TRIALS, 100 * p, 400 * sqrt(p * (1 - p) / TRIALS) + 1);
    }
}

RUN_TESTS(NULL, NULL)
