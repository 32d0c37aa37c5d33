#include "base/base.h"
#include "numeric/random.h"
#include "numeric/statistics.h"
#include "test.h"

#include <sonopack/study/study.h>

TEST(moments_by_hand) {
    const double x[] = {1, 2, 3, 6};
    assert_close(sp_mean(4, x), 3, 1e-15);
    assert_close(sp_sd(4, x), sqrt(14.0 / 3), 1e-15);
    assert_close(sp_standard_error(4, x), sqrt(14.0 / 12), 1e-15);
    assert_true(isnan(sp_mean(0, x)) && isnan(sp_sd(1, x)) && isnan(sp_sd(0, x)) && isnan(sp_standard_error(0, x)));
    const double same[] = {0.1, 0.1, 0.1}, bad[] = {1, NAN, 2};
    assert_close(sp_sd(3, same), 0, 1e-16);
    assert_true(isnan(sp_mean(3, bad)) && isnan(sp_sd(3, bad)));
}

TEST(spread_beside_a_large_offset) {
    const double x[] = {1e8 + 1, 1e8 + 2, 1e8 + 3};
    assert_close(sp_sd(3, x), 1, 1e-8); /* numbers near 1e8 are known to 1.5e-8 */
}

static double mean_statistic(const int64_t *size, const int64_t *const *pick, void *user) {
    const double *x = user;
    double sum = 0;
    for (int64_t k = 0; k < size[0]; k++)
        sum += x[pick[0][k]];
    return sum / (double)size[0];
}

/* The bootstrap error of a mean is the standard error, up to 1/sqrt(2 resamples), for few samples too. */
TEST(bootstrap_of_a_mean) {
    double x[50];
    sp_random r = sp_random_make(4, 99);
    for (int k = 0; k < 50; k++)
        x[k] = sp_random_normal(&r);
    const int64_t size[] = {50};
    sp_bootstrap_options o = sp_bootstrap_options_default();
    o.resamples = 20000;
    double error = 0, again = 1, other = 0;
    assert_ok(sp_bootstrap(1, size, mean_statistic, x, &o, &error, &err));
    /* four standard deviations of the estimate from 20000 resamples */
    assert_relative(error, sp_standard_error(50, x), 4 / sqrt(2 * 20000.0));
    const int64_t few[] = {3};
    assert_ok(sp_bootstrap(1, few, mean_statistic, x, &o, &error, &err));
    assert_relative(error, sp_standard_error(3, x), 4 / sqrt(2 * 20000.0));
    assert_ok(sp_bootstrap(1, size, mean_statistic, x, &o, &error, &err));
    assert_ok(sp_bootstrap(1, size, mean_statistic, x, &o, &again, &err));
    assert_true(error == again);
    o.seed = 2;
    assert_ok(sp_bootstrap(1, size, mean_statistic, x, &o, &other, &err));
    assert_true(other != error);
}

typedef struct two {
    const double *a, *b;
    int ruined; /* every n-th call gives no number */
    int calls;
} two;

static double difference(const int64_t *size, const int64_t *const *pick, void *user) {
    two *w = user;
    double sum = 0;
    for (int64_t k = 0; k < size[0]; k++)
        sum += w->a[pick[0][k]] / (double)size[0];
    for (int64_t k = 0; k < size[1]; k++)
        sum -= w->b[pick[1][k]] / (double)size[1];
    return w->ruined && ++w->calls % w->ruined == 0 ? NAN : sum;
}

TEST(groups_are_drawn_by_themselves) {
    double a[30], b[20];
    sp_random r = sp_random_make(5, 99);
    for (int k = 0; k < 30; k++)
        a[k] = 10 + sp_random_normal(&r);
    for (int k = 0; k < 20; k++)
        b[k] = -40 + 2 * sp_random_normal(&r); /* drawn across groups, the offset would dominate */
    const int64_t size[] = {30, 20};
    sp_bootstrap_options o = {.resamples = 10000, .seed = 1};
    two w = {a, b, 0, 0};
    double error = 0;
    assert_ok(sp_bootstrap(2, size, difference, &w, &o, &error, &err));
    double ea = sp_standard_error(30, a), eb = sp_standard_error(20, b);
    assert_relative(error, hypot(ea, eb), 4 / sqrt(2 * 10000.0));
    w.ruined = 20; /* 5% of the resamples give nothing: left out */
    assert_ok(sp_bootstrap(2, size, difference, &w, &o, &error, &err));
    assert_relative(error, hypot(ea, eb), 4 / sqrt(2 * 9000.0));
    w.ruined = 5;
    assert_ok(sp_bootstrap(2, size, difference, &w, &o, &error, &err));
    assert_true(isnan(error));
    const int64_t single[] = {30, 1};
    error = 0;
    assert_ok(sp_bootstrap(2, single, difference, &w, &o, &error, &err));
    assert_true(isnan(error));
}

/* Means of three groups, of which the last has one sample; and a value that is no number in some resamples. */
static void several_means(const int64_t *size, const int64_t *const *pick, double *value, void *user) {
    const double *x = user;
    for (int g = 0; g < 3; g++) {
        value[g] = 0;
        for (int64_t k = 0; k < size[g]; k++)
            value[g] += x[pick[g][k]] / (double)size[g];
        if (size[g] == 0)
            value[g] = NAN;
    }
    value[3] = value[0] + value[0];
    value[4] = value[0] > 3.5 ? NAN : 1; /* the mean of 1 .. 6: in half of the resamples */
}

/* Each error is that of the statistic by itself; all see the same resamples. */
TEST(many_statistics_of_one_bootstrap) {
    double x[] = {1, 2, 3, 4, 5, 6}, error[5];
    const int64_t size[3] = {6, 4, 1};
    const sp_bootstrap_options o = sp_bootstrap_options_default();
    assert_ok(sp_bootstrap_many(3, size, 5, several_means, x, &o, error, &err));
    assert_relative(error[0], sqrt(3.5 / 6), 4 / sqrt(2.0 * o.resamples));
    assert_relative(error[1], sqrt(5.0 / 3 / 4), 4 / sqrt(2.0 * o.resamples));
    assert_true(isnan(error[2]) && isnan(error[4]));
    assert_relative(error[3], 2 * error[0], 1e-14);
    double again[5];
    assert_ok(sp_bootstrap_many(3, size, 5, several_means, x, &o, again, &err));
    assert_memory_equal(error, again, sizeof error);
    assert_fails(sp_bootstrap_many(0, size, 5, several_means, x, &o, error, &err), SP_EINVAL, "0");
    assert_fails(sp_bootstrap_many(3, size, 0, several_means, x, &o, error, &err), SP_EINVAL, "0");
    EACH_ALLOCATION_FAILS(4, sp_bootstrap_many(3, size, 5, several_means, x, &o, error, &err), (void)0);
}

TEST(bootstrap_refuses) {
    double x[5] = {1, 2, 3, 4, 5}, error = 7;
    const int64_t size[] = {5, 5, 5, 5, 5};
    sp_bootstrap_options o = sp_bootstrap_options_default();
    assert_fails(sp_bootstrap(0, size, mean_statistic, x, &o, &error, &err), SP_EINVAL, "groups");
    o.resamples = 1;
    assert_fails(sp_bootstrap(1, size, mean_statistic, x, &o, &error, &err), SP_EINVAL, "resamples");
    o.resamples = 10;
    assert_true(error == 7);
    EACH_ALLOCATION_FAILS(1, sp_bootstrap(1, size, mean_statistic, x, &o, &error, &err),
                          assert_true(!lacks || error == 7));
}

TEST(line_by_hand) {
    const double x[] = {0, 1, 2}, y[] = {1, 3, 5}, e[] = {0.5, 0.5, 0.5};
    sp_line line;
    assert_ok(sp_fit_line(3, x, y, e, &line, &err));
    assert_close(line.slope, 2, 1e-15);
    assert_close(line.intercept, 1, 1e-15);
    assert_close(line.chi2, 0, 1e-28);
    assert_close(line.slope_err, 0.5 / sqrt(2), 1e-15);
    assert_close(line.intercept_err, 0.5 * sqrt(5.0 / 6), 1e-15);
    assert_int_equal(line.freedom, 1);
    const double bent[] = {1, 3, 8};
    assert_ok(sp_fit_line(3, x, bent, NULL, &line, &err)); /* residuals 0.5, -1, 0.5 */
    assert_close(line.slope, 3.5, 1e-15);
    assert_close(line.chi2, 1.5, 1e-14);
    assert_close(line.slope_err, sqrt(1.5 / 2), 1e-14);
    assert_ok(sp_fit_line(2, x, y, NULL, &line, &err));
    assert_close(line.slope, 2, 1e-15);
    assert_true(isnan(line.slope_err));
}

/* The errors of the fit are the spread of fits to data with these errors, and chi^2 has mean n - 2. */
TEST(line_errors_are_true) {
    enum { POINTS = 6, TRIALS = 4000 };
    const double x[POINTS] = {-3, -1, 0, 2, 5, 9}, e[POINTS] = {0.1, 0.3, 0.2, 1, 0.5, 0.2};
    static double slope[TRIALS], intercept[TRIALS], chi2[TRIALS];
    const uint64_t seed = 11;
    print_message("seed %llu\n", (unsigned long long)seed);
    sp_random r = sp_random_make(seed, 99);
    sp_line line = {0};
    for (int k = 0; k < TRIALS; k++) {
        double y[POINTS];
        for (int i = 0; i < POINTS; i++)
            y[i] = 2 - 0.7 * x[i] + e[i] * sp_random_normal(&r);
        assert_ok(sp_fit_line(POINTS, x, y, e, &line, &err));
        slope[k] = line.slope;
        intercept[k] = line.intercept;
        chi2[k] = line.chi2;
    }
    const double spread = 4 / sqrt(2.0 * TRIALS); /* four standard deviations of a standard deviation */
    assert_relative(sp_sd(TRIALS, slope), line.slope_err, spread);
    assert_relative(sp_sd(TRIALS, intercept), line.intercept_err, spread);
    assert_close(sp_mean(TRIALS, slope), -0.7, 4 * line.slope_err / sqrt(TRIALS));
    assert_close(sp_mean(TRIALS, chi2), POINTS - 2, 4 * sqrt(2.0 * (POINTS - 2) / TRIALS));
}

TEST(line_far_away_and_in_small_units) {
    const double x[] = {1e9, 1e9 + 1, 1e9 + 2, 1e9 + 3}, y[] = {1e-200, 3e-200, 5e-200, 7e-200},
                 e[] = {1e-201, 1e-201, 1e-201, 1e-201};
    sp_line line;
    assert_ok(sp_fit_line(4, x, y, e, &line, &err));
    assert_relative(line.slope, 2e-200, 1e-12);
    assert_relative(line.slope_err, 1e-201 / sqrt(5), 1e-12);
}

TEST(line_refuses) {
    const double x[] = {1, 1, 1}, y[] = {1, 2, 3}, up[] = {1, 2, 3}, bad[] = {1, NAN, 3}, zero[] = {1, 0, 1};
    sp_line line = {.slope = 7};
    assert_fails(sp_fit_line(1, up, y, NULL, &line, &err), SP_EINVAL, "1 points");
    assert_fails(sp_fit_line(3, x, y, NULL, &line, &err), SP_EINVAL, "x 1");
    assert_fails(sp_fit_line(3, up, bad, NULL, &line, &err), SP_EINVAL, "1");
    assert_fails(sp_fit_line(3, up, y, zero, &line, &err), SP_EINVAL, "1");
    assert_fails(sp_fit_line(3, up, y, bad, &line, &err), SP_EINVAL, "1");
    assert_true(line.slope == 7);
}

TEST(power_law) {
    const double p[] = {1e-7, 1e-6, 1e-5, 1e-4};
    double c[4], e[4], exponent, error, prefactor;
    for (int k = 0; k < 4; k++) {
        c[k] = 1.2 * pow(p[k], 1.0 / 6);
        e[k] = 0.02 * c[k];
    }
    assert_ok(sp_fit_power(4, p, c, e, &exponent, &error, &prefactor, &err));
    assert_close(exponent, 1.0 / 6, 1e-14);
    assert_relative(prefactor, 1.2, 1e-12);
    /* 2% each at four decades, one apart: 0.02 / (ln 10 sqrt(5)) */
    assert_relative(error, 0.02 / (log(10) * sqrt(5)), 1e-12);
    c[1] *= 1.2; /* ten standard deviations off: chi^2 = 70, the error must own up */
    double honest;
    assert_ok(sp_fit_power(4, p, c, e, &exponent, &honest, &prefactor, &err));
    assert_true(honest > 4 * error);
    assert_ok(sp_fit_power(4, p, c, NULL, &exponent, &error, &prefactor, &err));
    assert_true(isfinite(error) && error > 0);
    c[2] = -1;
    assert_fails(sp_fit_power(4, p, c, e, &exponent, &error, &prefactor, &err), SP_EINVAL, "2");
    assert_fails(sp_fit_power(2, p, c, e, &exponent, &error, &prefactor, &err), SP_EINVAL, "3");
    c[2] = NAN;
    assert_fails(sp_fit_power(4, p, c, e, &exponent, &error, &prefactor, &err), SP_EINVAL, "2");
    c[2] = 1;
    e[2] = 0;
    assert_fails(sp_fit_power(4, p, c, e, &exponent, &error, &prefactor, &err), SP_EINVAL, "2");
    EACH_ALLOCATION_FAILS(0, sp_fit_power(4, p, c, NULL, &exponent, &error, &prefactor, &err), (void)0);
}

RUN_TESTS(NULL, NULL)
