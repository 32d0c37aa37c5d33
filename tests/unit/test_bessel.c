#include "extended.h"
#include "numeric/bessel.h"
#include "test.h"

#include <float.h>

static const double arguments[] = {1e-12, 1e-4, 0.00011, 0.3, 1, 2.404825557695773, 10, 37.3, 200, 560.7, 2000, 30000};
enum { ARGUMENTS = sizeof arguments / sizeof *arguments };

/* Abramowitz and Stegun, tables 9.1, 9.2, 9.4. */
TEST(test_tabulated) {
    double j[101];
    sp_bessel_j(1, 101, j);
    assert_close(j[0], 0.76519768655796655, 2e-16);
    assert_close(j[1], 0.44005058574493352, 2e-16);
    assert_close(j[10], 2.630615123687453e-10, 1e-24);
    sp_bessel_j(10, 101, j);
    assert_close(j[0], -0.24593576445134834, 3e-16);
    assert_close(j[10], 0.20748610663335885, 3e-16);
    sp_bessel_j(50, 101, j);
    assert_close(j[0], 0.055812327669251815, 3e-16);
    assert_close(j[100], 1.1159273690838e-21, 1e-33);
    sp_bessel_j(100, 101, j);
    assert_close(j[100], 0.09636667329586156, 3e-16);
}

TEST(test_zero) {
    double j[5] = {7, 7, 7, 7, 7}, f[2], c[3] = {2, 3, 4};
    const double x[2] = {0, 0};
    sp_bessel_j(0, 5, j);
    assert_true(j[0] == 1);
    for (int m = 1; m < 5; m++)
        assert_true(j[m] == 0);
    sp_bessel_j(0, 0, j);
    sp_bessel_j(3, 0, j);
    assert_true(j[0] == 1);
    sp_bessel_series(3, c, 0, 2, x, f);
    assert_true(f[0] == 2 && f[1] == 2);
    sp_bessel_series(3, c, 1, 2, x, f);
    assert_true(f[0] == 0 && f[1] == 0);
    sp_bessel_series(0, c, 0, 2, x, f);
    assert_true(f[0] == 0 && f[1] == 0);
}

TEST(test_all_orders) {
    for (int q = 0; q < ARGUMENTS; q++) {
        const double x = arguments[q];
        const int n = (int)sp_bessel_orders(x) + 10;
        RELEASED double *j = calloc((size_t)n, sizeof *j);
        RELEASED extended *exact = calloc((size_t)n, sizeof *exact);
        sp_bessel_j(x, n, j);
        extended_bessel(x, n, exact);
        double squares = -j[0] * j[0];
        for (int m = 0; m < n; m++) {
            assert_close(j[m], (double)exact[m], 4 * DBL_EPSILON);
            squares += 2 * j[m] * j[m];
        }
        assert_close(squares, 1, 1e-14);
        assert_true(fabsl(exact[n - 10]) < 1e-20L); /* what counts as 0 */
        assert_true(j[n - 1] == 0 || x < 1e-4);
    }
}

/* A series with coefficients of either sign, all arguments in one call: groups mix short recurrences with long ones. */
TEST(test_series) {
    enum { TERMS = 700 };
    double c[TERMS], f[ARGUMENTS];
    srand(3);
    for (int k = 0; k < TERMS; k++)
        c[k] = rand() / (double)RAND_MAX - 0.5;
    for (int parity = 0; parity < 2; parity++) {
        for (int count = 1; count <= ARGUMENTS; count++) { /* every filling of the last group */
            sp_bessel_series(TERMS, c, parity, count, arguments, f);
            for (int q = 0; q < count && (count == ARGUMENTS || q == count - 1); q++) {
                extended j[2 * TERMS], sum = 0, scale = 0;
                extended_bessel(arguments[q], 2 * TERMS, j);
                for (int k = 0; k < TERMS; k++) {
                    sum += c[k] * j[2 * k + parity];
                    scale += c[k] * j[2 * k + parity] * c[k] * j[2 * k + parity];
                }
                /* rounding of the recurrence adds up like a random walk; a shifted argument would grow with x */
                assert_close(f[q], (double)sum, (8 + 3 * sqrt(arguments[q])) * DBL_EPSILON * (double)sqrtl(scale));
            }
        }
    }
}

RUN_TESTS(NULL, NULL)
